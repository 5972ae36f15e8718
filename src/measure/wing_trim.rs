//! What a designer reads of a trim: the glide, where the drag comes from, and how far the flown wing is from the designed one.

use glam::DVec3;

use super::read_out::{ReadOut, results};
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
    SPEED: "speed_m_s", "m/s", "speed in flight; along the path";
    SINK: "sink_m_s", "m/s", "vertical speed";
    GLIDE_RATIO: "glide_ratio", "1", "glide ratio; horizontal over vertical speed";
    ANGLE_OF_ATTACK: "angle_of_attack_deg", "deg", "angle of attack; of the chord in or next to the middle to the stream";
    FLIGHT_LIFT: "lift_coefficient", "1", "lift coefficient; on the flat area";
    FLIGHT_DRAG: "drag_coefficient", "1", "drag coefficient; of all, on the flat area";
    INDUCED_DRAG: "induced_drag_n", "N", "induced drag";
    INDUCED_SHARE: "induced_drag_share", "1", "share of the induced drag; of all drag";
    SECTION_DRAG: "section_drag_n", "N", "drag of the sections, by their polars";
    SECTION_SHARE: "section_drag_share", "1", "share of the sections' drag; of all drag";
    LINE_DRAG: "line_drag_n", "N", "drag of the lines";
    LINE_SHARE: "line_drag_share", "1", "share of the lines' drag; of all drag";
    PILOT_DRAG: "pilot_drag_n", "N", "drag of the pilot";
    PILOT_SHARE: "pilot_drag_share", "1", "share of the pilot's drag; of all drag";
    LIFT: "lift_n", "N", "lift; of wing and lines, across the stream";
    WEIGHT: "weight_n", "N", "weight; of all";
    INTERNAL_PRESSURE: "internal_pressure_coefficient", "1", "pressure coefficient inside; of all cells";
    LIFT_RATIO: "pressure_lift_over_far_wake_lift", "1", "lift of pressures over that of the far wake; how well panels, and their pressures on the fabric, agree with the far wake";
    DRAG_RATIO: "pressure_drag_over_induced_drag", "1", "drag of pressures over induced drag; of the pressures on the fabric; traction makes up the difference";
    SECTION_LIFT_ERROR: "section_lift_error", "1", "error of the strips' lift; largest difference of a strip's lift coefficient from its polar's";
    PANELS: "panels", "1", "panels of the wing's surface; of the half wing";
    ITERATIONS: "trim_iterations", "1", "iterations of the trim";
    TURN_LEFT: "trim_turn_left_deg", "deg", "turn of the last iteration; by which the last balance still turned the wing";
    CELL_WIDTH_MEAN: "cell_width_over_designed_mean", "1", "distance of neighbouring ribs over the designed one, mean";
    CELL_WIDTH_MIN: "cell_width_over_designed_min", "1", "smallest distance of neighbouring ribs over the designed one";
    BALLOONING_FLOWN: "ballooning_flown", "1", "height of the flown upper panels' middle over the distance of the ribs";
    BALLOONING_DESIGNED: "ballooning_designed", "1", "height of the designed upper panels' middle over the distance of the ribs";
    SECTION_DEVIATION: "section_deviation", "1", "deviation of the sections; of ribs' outlines from the designed ones, each laid chord on chord: root of the mean square, per chord";
    ROW_STRETCH_MAX: "row_{row}_stretch_max_mm", "mm", "largest stretch of a line of the row; loaded less unloaded length of the line that stretches most";
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

/// A number of the flight.
type OfFlight = (&'static ReadOut, fn(&Flown) -> f64);

/// All of them.
static OF_FLIGHT: [OfFlight; 21] = [
    (&SPEED, |f| f.flight.balance.speed_m_s),
    (&SINK, |f| {
        f.flight.balance.speed_m_s * f.flight.balance.glide_rad.sin()
    }),
    (&GLIDE_RATIO, |f| 1.0 / f.flight.balance.glide_rad.tan()),
    (&ANGLE_OF_ATTACK, |f| f.flight.attack_rad.to_degrees()),
    (&FLIGHT_LIFT, |f| f.over_pressure(f.flight.lift_n)),
    (&FLIGHT_DRAG, |f| f.over_pressure(f.drag_n())),
    (&INDUCED_DRAG, |f| f.flight.induced_drag_n),
    (&INDUCED_SHARE, |f| f.flight.induced_drag_n / f.drag_n()),
    (&SECTION_DRAG, |f| f.flight.section_drag_n),
    (&SECTION_SHARE, |f| f.flight.section_drag_n / f.drag_n()),
    (&LINE_DRAG, |f| f.flight.line_drag_n),
    (&LINE_SHARE, |f| f.flight.line_drag_n / f.drag_n()),
    (&PILOT_DRAG, |f| f.flight.pilot_drag_n),
    (&PILOT_SHARE, |f| f.flight.pilot_drag_n / f.drag_n()),
    (&LIFT, |f| f.flight.lift_n),
    (&WEIGHT, |f| f.flight.weight_n),
    (&INTERNAL_PRESSURE, |f| f.flight.inside),
    (&LIFT_RATIO, |f| {
        f.flight.pressure_lift_n / f.flight.far_lift_n
    }),
    (&DRAG_RATIO, |f| {
        f.flight.pressure_drag_n / f.flight.induced_drag_n
    }),
    (&SECTION_LIFT_ERROR, |f| f.flight.section_residual),
    (&PANELS, |f| f.flight.panels as f64),
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
            Quantity::told(&TURN_LEFT, turn_deg)
        }),
    );
    shape(results, wing, designed, structure);
    lines(results, wing, designed, structure);
}

fn glide(results: &mut Results, wing: &Wing, flight: Option<&Flight>) {
    let area_m2 = wing.built.measures.flat_area_m2;
    for (read_out, of) in &OF_FLIGHT {
        let quantity = match (flight, read_out.detail()) {
            (Some(flight), None) => Quantity::new(of(&Flown { flight, area_m2 })),
            (Some(flight), Some(_)) => Quantity::told(read_out, of(&Flown { flight, area_m2 })),
            (None, _) => Quantity::missing("there is no flight"),
        };
        results.insert(read_out, quantity);
    }
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
        &CELL_WIDTH_MEAN,
        Quantity::new(average(&ratios)).with_note("distance of neighbouring ribs"),
    );
    results.insert(
        &CELL_WIDTH_MIN,
        Quantity::new(ratios.iter().copied().fold(f64::INFINITY, f64::min)),
    );
    let bulges = |p: &[DVec3]| {
        let own: Vec<f64> = (0..wing.built.cells)
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
    results.tell(&SECTION_DEVIATION, section_deviation(wing, positions));
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
        results.tell(
            &ROW_STRETCH_MAX.of(name),
            1e3 * stretched.fold(0.0, f64::max),
        );
    }
}
