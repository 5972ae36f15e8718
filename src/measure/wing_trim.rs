//! What a designer reads of a trim: the glide, where the drag comes from, and how far the flown wing is from the designed one.

use glam::DVec3;

use super::read_out::{ReadOut, results};
use super::shared::{DRAG_COEFFICIENT, LIFT_COEFFICIENT};
use super::statistics::average;
use crate::case::wing::Wing;
use crate::cloth::Structure;
use crate::frame::StructureFrame;
use crate::geometry::wing::LineKind;
use crate::output::{Quantity, Results};
use crate::statics::Trim;
use crate::trim::Flight;

results! {
    /// Of a flight.
    RESULTS: "Trims of wings";
    SPEED: "speed_m_s", "m/s", "along the path";
    SINK: "sink_m_s", "m/s", "vertical speed";
    GLIDE_RATIO: "glide_ratio", "1", "horizontal over vertical speed";
    ANGLE_OF_ATTACK: "angle_of_attack_deg", "deg", "of the chord in or next to the middle to the stream";
    INDUCED_DRAG: "induced_drag_n", "N", "induced drag";
    INDUCED_SHARE: "induced_drag_share", "1", "share of the induced drag";
    SECTION_DRAG: "section_drag_n", "N", "drag of the sections, by their polars";
    SECTION_SHARE: "section_drag_share", "1", "share of the sections' drag";
    LINE_DRAG: "line_drag_n", "N", "drag of the lines";
    LINE_SHARE: "line_drag_share", "1", "share of the lines' drag";
    PILOT_DRAG: "pilot_drag_n", "N", "drag of the pilot";
    PILOT_SHARE: "pilot_drag_share", "1", "share of the pilot's drag";
    LIFT: "lift_n", "N", "of wing and lines, across the stream";
    WEIGHT: "weight_n", "N", "weight of all";
    INTERNAL_PRESSURE: "internal_pressure_coefficient", "1", "pressure coefficient inside all cells";
    LIFT_RATIO: "pressure_lift_over_far_wake_lift", "1", "how well panels, and their pressures on the fabric, agree with the far wake";
    DRAG_RATIO: "pressure_drag_over_induced_drag", "1", "of the pressures on the fabric; traction makes up the difference";
    SECTION_LIFT_ERROR: "section_lift_error", "1", "largest difference of a strip's lift coefficient from its polar's";
    PANELS: "panels", "1", "of the half wing";
    ITERATIONS: "trim_iterations", "1", "iterations of the trim";
    TURN_LEFT: "trim_turn_left_deg", "deg", "by which the last balance still turned the wing";
    CELL_WIDTH_MEAN: "cell_width_over_designed_mean", "1", "distance of neighbouring ribs over the designed one, mean";
    CELL_WIDTH_MIN: "cell_width_over_designed_min", "1", "smallest distance of neighbouring ribs over the designed one";
    BALLOONING_FLOWN: "ballooning_flown", "1", "height of the flown upper panels' middle over the distance of the ribs";
    BALLOONING_DESIGNED: "ballooning_designed", "1", "height of the designed upper panels' middle over the distance of the ribs";
    SECTION_DEVIATION: "section_deviation", "1", "of ribs' outlines from the designed ones, each laid chord on chord: root of the mean square, per chord";
    ROW_STRETCH_MAX: "row_{row}_stretch_max_mm", "mm", "loaded less unloaded length of the line that stretches most";
}

/// A number of the flight.
struct OfFlight {
    read_out: &'static ReadOut,
    /// Remark for the reader; empty for none.
    note: &'static str,
    of: fn(&Flown) -> f64,
}

/// A flight on a wing of a flat area [m²].
struct Flown<'a> {
    flight: &'a Flight,
    area_m2: f64,
}

impl Flown<'_> {
    fn drag_n(&self) -> f64 {
        let f = self.flight;
        f.induced_drag_n + f.section_drag_n + f.line_drag_n + f.pilot_drag_n
    }

    fn over_pressure(&self, force_n: f64) -> f64 {
        force_n / (self.flight.balance.dynamic_pa * self.area_m2)
    }
}

const fn of_flight(
    read_out: &'static ReadOut,
    note: &'static str,
    of: fn(&Flown) -> f64,
) -> OfFlight {
    OfFlight { read_out, note, of }
}

static OF_FLIGHT: [OfFlight; 21] = [
    of_flight(&SPEED, SPEED.meaning, |f| f.flight.balance.speed_m_s),
    of_flight(&SINK, "", |f| {
        f.flight.balance.speed_m_s * f.flight.balance.glide_rad.sin()
    }),
    of_flight(&GLIDE_RATIO, GLIDE_RATIO.meaning, |f| {
        1.0 / f.flight.balance.glide_rad.tan()
    }),
    of_flight(&ANGLE_OF_ATTACK, ANGLE_OF_ATTACK.meaning, |f| {
        f.flight.attack_rad.to_degrees()
    }),
    of_flight(&LIFT_COEFFICIENT, "on the flat area", |f| {
        f.over_pressure(f.flight.lift_n)
    }),
    of_flight(&DRAG_COEFFICIENT, "of all, on the flat area", |f| {
        f.over_pressure(f.drag_n())
    }),
    of_flight(&INDUCED_DRAG, "", |f| f.flight.induced_drag_n),
    of_flight(&INDUCED_SHARE, "of all drag", |f| {
        f.flight.induced_drag_n / f.drag_n()
    }),
    of_flight(&SECTION_DRAG, "", |f| f.flight.section_drag_n),
    of_flight(&SECTION_SHARE, "of all drag", |f| {
        f.flight.section_drag_n / f.drag_n()
    }),
    of_flight(&LINE_DRAG, "", |f| f.flight.line_drag_n),
    of_flight(&LINE_SHARE, "of all drag", |f| {
        f.flight.line_drag_n / f.drag_n()
    }),
    of_flight(&PILOT_DRAG, "", |f| f.flight.pilot_drag_n),
    of_flight(&PILOT_SHARE, "of all drag", |f| {
        f.flight.pilot_drag_n / f.drag_n()
    }),
    of_flight(&LIFT, LIFT.meaning, |f| f.flight.lift_n),
    of_flight(&WEIGHT, "of all", |f| f.flight.weight_n),
    of_flight(&INTERNAL_PRESSURE, "of all cells", |f| f.flight.inside),
    of_flight(&LIFT_RATIO, LIFT_RATIO.meaning, |f| {
        f.flight.pressure_lift_n / f.flight.far_lift_n
    }),
    of_flight(&DRAG_RATIO, DRAG_RATIO.meaning, |f| {
        f.flight.pressure_drag_n / f.flight.induced_drag_n
    }),
    of_flight(&SECTION_LIFT_ERROR, SECTION_LIFT_ERROR.meaning, |f| {
        f.flight.section_residual
    }),
    of_flight(&PANELS, PANELS.meaning, |f| f.flight.panels as f64),
];

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
    let last = state.and_then(|state| state.iterations.last());
    let untold = || Quantity::missing("no trim was sought yet");
    results.insert(
        &ITERATIONS,
        state.map_or_else(untold, |state| Quantity::new(state.iterations.len() as f64)),
    );
    results.insert(
        &TURN_LEFT,
        state.map_or_else(untold, |_| {
            let turn_deg = last.map_or(f64::NAN, |i| i.turn_rad.to_degrees());
            Quantity::new(turn_deg).with_note(TURN_LEFT.meaning)
        }),
    );
    shape(results, wing, designed, structure);
    lines(results, wing, designed, structure);
}

fn glide(results: &mut Results, wing: &Wing, flight: Option<&Flight>) {
    let area_m2 = wing.wing.measures.flat_area_m2;
    for OfFlight { read_out, note, of } in &OF_FLIGHT {
        let quantity = match flight {
            Some(flight) => Quantity::new(of(&Flown { flight, area_m2 })),
            None => Quantity::missing("there is no flight"),
        };
        results.insert(
            read_out,
            if note.is_empty() || flight.is_none() {
                quantity
            } else {
                quantity.with_note(note)
            },
        );
    }
}

/// Distances of neighbouring ribs, mean over their outlines [m], from the left tip.
#[must_use]
pub fn cell_widths_m(wing: &Wing, positions_m: &[DVec3]) -> Vec<f64> {
    let place = |n: u32| positions_m[n as usize];
    wing.wing
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
    let [left, right] = [cell, cell + 1].map(|rib| &wing.wing.outlines[rib]);
    let upper = wing.wing.places.upper.iter().enumerate();
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, _) in upper.filter(|(_, x)| (0.1..0.7).contains(*x)) {
        let across = &wing.wing.rows_across[cell][k];
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
        &CELL_WIDTH_MEAN,
        Quantity::new(average(&ratios)).with_note("distance of neighbouring ribs"),
    );
    results.insert(
        &CELL_WIDTH_MIN,
        Quantity::new(ratios.iter().copied().fold(f64::INFINITY, f64::min)),
    );
    let bulges = |p: &[DVec3]| {
        let own: Vec<f64> = (0..wing.wing.cells)
            .filter_map(|cell| ballooning(wing, p, cell))
            .collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    let [before, after] = positions.map(|p| bulges(p));
    for (read_out, value) in [(&BALLOONING_FLOWN, after), (&BALLOONING_DESIGNED, before)] {
        results.insert(
            read_out,
            Quantity::new(value).with_note(
                "height of the upper panels' middle over the distance of the ribs, mean from 0.1 to 0.7 of the chord",
            ),
        );
    }
    results.insert(
        &SECTION_DEVIATION,
        Quantity::new(section_deviation(wing, positions)).with_note(SECTION_DEVIATION.meaning),
    );
}

/// Root of the mean square deviation of outlines, each turned to its chord and scaled by it.
fn section_deviation(wing: &Wing, [designed, flown]: [&Vec<DVec3>; 2]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for outline in &wing.wing.outlines {
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
    for (number, name) in wing.wing.row_names.iter().enumerate() {
        let own = designed
            .cables
            .iter()
            .zip(&wing.wing.line_kinds)
            .filter(|(_, kind)| matches!(kind, LineKind::Line { row, .. } | LineKind::Riser { row } if *row == number));
        let stretched = own.map(|(cable, _)| {
            let [a, b] = cable.nodes.map(|n| flown.positions_m[n as usize]);
            (a.distance(b) - cable.rest_length_m).max(0.0)
        });
        results.insert(
            &ROW_STRETCH_MAX.of(name),
            Quantity::new(1e3 * stretched.fold(0.0, f64::max)).with_note(ROW_STRETCH_MAX.meaning),
        );
    }
}
