//! What a designer reads of a trim: the glide, where the drag comes from, and how far the flown wing is from the designed one.

use glam::DVec3;

use crate::case::wing::Wing;
use crate::cloth::Structure;
use crate::frame::StructureFrame;
use crate::geometry::wing::LineKind;
use crate::output::{Quantity, Results};
use crate::statics::Trim;
use crate::trim::Flight;

/// A part of the drag: its name, and its force [N].
type DragPart = (&'static str, fn(&Flight) -> f64);

/// Adds the results of a trim; without a flight their names alone.
pub(super) fn results(
    results: &mut Results,
    wing: &Wing,
    designed: &Structure,
    structure: &StructureFrame,
    state: Option<&Trim>,
) {
    let flight = state.and_then(|state| state.flight.as_ref());
    glide(results, wing, flight);
    if let Some(state) = state {
        let last = state.iterations.last();
        let iterations = Quantity::new(state.iterations.len() as f64, "1");
        results.insert("trim_iterations", iterations);
        results.insert(
            "trim_turn_left_deg",
            Quantity::new(last.map_or(f64::NAN, |i| i.turn_rad.to_degrees()), "deg")
                .with_note("by which the last balance still turned the wing"),
        );
    } else {
        for (name, unit) in [("trim_iterations", "1"), ("trim_turn_left_deg", "deg")] {
            results.insert(name, Quantity::missing(unit, "no trim was sought yet"));
        }
    }
    shape(results, wing, designed, structure);
    lines(results, wing, designed, structure);
}

fn glide(results: &mut Results, wing: &Wing, flight: Option<&Flight>) {
    let area_m2 = wing.built.measures.flat_area_m2;
    let mut insert = |name: &str, unit: &str, note: &str, of: &dyn Fn(&Flight) -> f64| {
        let quantity = match flight {
            Some(flight) => Quantity::new(of(flight), unit),
            None => Quantity::missing(unit, "there is no flight"),
        };
        results.insert(
            name,
            if note.is_empty() || flight.is_none() {
                quantity
            } else {
                quantity.with_note(note)
            },
        );
    };
    let drag = |f: &Flight| f.induced_drag_n + f.section_drag_n + f.line_drag_n + f.pilot_drag_n;
    insert("speed_m_s", "m/s", "along the path", &|f| {
        f.balance.speed_m_s
    });
    insert("sink_m_s", "m/s", "", &|f| {
        f.balance.speed_m_s * f.balance.glide_rad.sin()
    });
    insert("glide_ratio", "1", "horizontal over vertical speed", &|f| {
        1.0 / f.balance.glide_rad.tan()
    });
    insert(
        "angle_of_attack_deg",
        "deg",
        "of the chord in or next to the middle to the stream",
        &|f| f.attack_rad.to_degrees(),
    );
    insert("lift_coefficient", "1", "on the flat area", &|f| {
        f.lift_n / (f.balance.dynamic_pa * area_m2)
    });
    insert("drag_coefficient", "1", "of all, on the flat area", &|f| {
        drag(f) / (f.balance.dynamic_pa * area_m2)
    });
    let parts: [DragPart; 4] = [
        ("induced", |f| f.induced_drag_n),
        ("section", |f| f.section_drag_n),
        ("line", |f| f.line_drag_n),
        ("pilot", |f| f.pilot_drag_n),
    ];
    for (name, of) in parts {
        insert(&format!("{name}_drag_n"), "N", "", &of);
        insert(&format!("{name}_drag_share"), "1", "of all drag", &|f| {
            of(f) / drag(f)
        });
    }
    insert(
        "lift_n",
        "N",
        "of wing and lines, across the stream",
        &|f| f.lift_n,
    );
    insert("weight_n", "N", "of all", &|f| f.weight_n);
    insert("internal_pressure_coefficient", "1", "of all cells", &|f| {
        f.inside
    });
    insert(
        "pressure_lift_over_far_wake_lift",
        "1",
        "how well panels, and their pressures on the fabric, agree with the far wake",
        &|f| f.pressure_lift_n / f.far_lift_n,
    );
    insert(
        "pressure_drag_over_induced_drag",
        "1",
        "of the pressures on the fabric; traction makes up the difference",
        &|f| f.pressure_drag_n / f.induced_drag_n,
    );
    insert(
        "section_lift_error",
        "1",
        "largest difference of a strip's lift coefficient from its polar's",
        &|f| f.section_residual,
    );
    insert("panels", "1", "of the half wing", &|f| f.panels as f64);
}

/// Distances of neighbouring ribs, mean over their outlines [m], from the left tip.
#[must_use]
pub fn cell_widths_m(wing: &Wing, positions_m: &[DVec3]) -> Vec<f64> {
    let place = |n: u32| positions_m[n as usize];
    wing.built
        .outlines
        .windows(2)
        .map(|pair| {
            let sum: f64 = pair[0]
                .iter()
                .zip(&pair[1])
                .map(|(a, b)| place(*a).distance(place(*b)))
                .sum();
            sum / pair[0].len() as f64
        })
        .collect()
}

/// How far the middle of a cell's panel stands out over the distance of its ribs, mean over the upper side between a tenth and 0.7 of the chord.
fn ballooning(wing: &Wing, positions_m: &[DVec3], cell: usize) -> Option<f64> {
    let place = |n: u32| positions_m[n as usize];
    let [left, right] = [cell, cell + 1].map(|rib| &wing.built.outlines[rib]);
    let upper = wing.built.places.upper.iter().enumerate();
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, _) in upper.filter(|(_, x)| (0.1..0.7).contains(*x)) {
        let across = &wing.built.rows_across[cell][k];
        let Some(middle) = across.get(across.len() / 2) else {
            continue;
        };
        let (a, b) = (place(left[k]), place(right[k]));
        sum += place(*middle).distance(0.5 * (a + b)) / a.distance(b);
        count += 1.0;
    }
    (count > 0.0).then(|| sum / count)
}

fn shape(results: &mut Results, wing: &Wing, designed: &Structure, flown: &StructureFrame) {
    let positions = [&designed.positions_m, &flown.positions_m];
    let [before, after] = positions.map(|p| cell_widths_m(wing, p));
    let ratios: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a / b).collect();
    results.insert(
        "cell_width_over_designed_mean",
        Quantity::new(ratios.iter().sum::<f64>() / ratios.len() as f64, "1")
            .with_note("distance of neighbouring ribs"),
    );
    results.insert(
        "cell_width_over_designed_min",
        Quantity::new(ratios.iter().copied().fold(f64::INFINITY, f64::min), "1"),
    );
    let bulges = |p: &[DVec3]| {
        let own: Vec<f64> = (0..wing.built.cells)
            .filter_map(|cell| ballooning(wing, p, cell))
            .collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    let [before, after] = positions.map(|p| bulges(p));
    for (name, value) in [("ballooning_flown", after), ("ballooning_designed", before)] {
        results.insert(
            name,
            Quantity::new(value, "1").with_note(
                "height of the upper panels' middle over the distance of the ribs, mean from 0.1 to 0.7 of the chord",
            ),
        );
    }
    results.insert(
        "section_deviation",
        Quantity::new(section_deviation(wing, positions), "1").with_note(
            "of ribs' outlines from the designed ones, each laid chord on chord: root of the mean square, per chord",
        ),
    );
}

/// Root of the mean square deviation of outlines, each turned to its chord and scaled by it.
fn section_deviation(wing: &Wing, [designed, flown]: [&Vec<DVec3>; 2]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for outline in &wing.built.outlines {
        let [a, b] = [designed, flown].map(|p| in_chord(outline, p));
        for (a, b) in a.iter().zip(&b) {
            sum += (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(sum / count)
}

/// An outline's points along and across its chord, per chord.
fn in_chord(outline: &[u32], positions_m: &[DVec3]) -> Vec<[f64; 2]> {
    let place = |n: u32| positions_m[n as usize];
    let (nose, tail) = (place(outline[0]), place(outline[outline.len() / 2]));
    let chord = tail - nose;
    let along = chord.normalize_or(DVec3::X);
    // The plane of the rib by its enclosed area.
    let area: DVec3 = (0..outline.len())
        .map(|i| {
            let next = outline[(i + 1) % outline.len()];
            (place(outline[i]) - nose).cross(place(next) - nose)
        })
        .sum();
    let up = area.cross(along).normalize_or_zero();
    let scale = 1.0 / chord.length();
    outline
        .iter()
        .map(|n| {
            let point = place(*n) - nose;
            [point.dot(along) * scale, point.dot(up) * scale]
        })
        .collect()
}

/// How much lines are longer under load.
fn lines(results: &mut Results, wing: &Wing, designed: &Structure, flown: &StructureFrame) {
    for (number, name) in wing.built.row_names.iter().enumerate() {
        let own = designed
            .cables
            .iter()
            .zip(&wing.built.line_kinds)
            .filter(|(_, kind)| matches!(kind, LineKind::Line { row, .. } | LineKind::Riser { row } if *row == number));
        let stretched = own.map(|(cable, _)| {
            let [a, b] = cable.nodes.map(|n| flown.positions_m[n as usize]);
            (a.distance(b) - cable.rest_length_m).max(0.0)
        });
        results.insert(
            &format!("row_{name}_stretch_max_mm"),
            Quantity::new(1e3 * stretched.fold(0.0, f64::max), "mm")
                .with_note("loaded less unloaded length of the line that stretches most"),
        );
    }
}
