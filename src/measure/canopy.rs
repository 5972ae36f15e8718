//! A canopy in air: its forces by three routes, their means, and the correction for walls.

use std::ops::Range;

use super::blockage::THREE_DIMENSIONS;
use super::canopy_shape::{self, CanopyShape, Shape};
use super::falling::HEIGHT_FALLEN;
use super::impulses::Forces;
use super::read_out::Reduction::{Largest, LargestAndMean, Mean as MeanOf};
use super::read_out::{columns, results};
use super::record::Record;
use super::reduce::{column_max, mass_drift, mean_forces_n, quantity, reduce, released};
use super::shared::{
    BELT_TENSION_MAX, BELTS, BLOCKAGE_RATIO, BY_MARKERS, CORRECTED_DRAG, DRAG_COEFFICIENT,
    DRAG_MARKERS, DRAG_MOMENTUM_BOX, FORCE_IMBALANCE, FORCE_Y, FORCE_Z, HEIGHT, IMPULSE_MARKERS,
    IMPULSE_MOMENTUM_BOX, KINETIC_ENERGY, LINE_LOAD_SHARE, LINE_STRENGTHS, LINE_TENSION_MAX,
    MASS_DEFECT, MASS_DRIFT, PRESSURE_RATIO, PROJECTED_DIAMETER_RATIO, RISER_TENSION_MAX, RISERS,
    SLIP_MEAN, SLIP_RATIO, STRESS_MAX, TAPE_LOAD_SHARE, TAPE_STRENGTHS, TIME,
    VENT_LINE_TENSION_MAX, VENT_LINES, WIND_SPEED,
};
use super::statistics::{Mean, average, largest};
use super::steady::{self, SETTLING, SHORTEST_WINDOW, Window};
use super::strengths::{Carrier, load_shares};
use super::{bodies, opening};
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Canopy, Flow, STANDARD_GRAVITY_M_S2};
use crate::frame::CableKind;
use crate::gpu::DeviceError;
use crate::output::{Quantity, Results, Supports};
use crate::simulation::Simulation;

columns! {
    /// The first columns of a canopy.
    COLUMNS of Moment, in Scene: "Canopies in air: forces";
    TIME => |now| now.time_s;
    WIND_SPEED => |now| now.wind_m_s;
    DRAG_COEFFICIENT => |now| now.forces.markers_n.x / now.dynamic_force_n, reduced MeanOf;
    DRAG_COEFFICIENT_MOMENTUM_BOX: "drag_coefficient_momentum_box", "1", "drag coefficient by the momentum of a box of air"
        => |now| now.forces.momentum_box_n.x / now.dynamic_force_n;
    DRAG_COEFFICIENT_LINES: "drag_coefficient_lines", "1", "drag coefficient by the tension of lines and the sheet's own momentum"
        => |now| now.forces.supports_n.x / now.dynamic_force_n;
    FORCE_Y => |now| now.forces.markers_n.y;
    FORCE_Z => |now| now.forces.markers_n.z;
    IMPULSE_MARKERS => |now| now.forces.impulse.markers.x;
    IMPULSE_MOMENTUM_BOX => |now| now.forces.impulse.momentum_box.x;
    IMPULSE_LINES: "impulse_lines_n_s", "N s", "impulse of lines, and of the sheet itself, along x; since release"
        => |now| now.forces.impulse.supports.x;
    PROJECTED_DIAMETER_RATIO => |now| (now.shape.projected_area_m2 / now.nominal_area_m2).sqrt(), reduced MeanOf;
    HEIGHT => |now| now.shape.height_m, reduced MeanOf;
    LINE_TENSION_MEAN: "line_tension_mean_n", "N", "mean tension of the suspension lines"
        => |now| average(&now.line_tensions_n()), reduced MeanOf;
    LINE_TENSION_MAX => |now| now.line_tensions_n().into_iter().fold(0.0, f64::max), reduced Largest;
    LINE_LOAD_SHARE => |now| now.line_load_share, reduced Largest, when LINE_STRENGTHS;
    BELT_TENSION_MAX => |now| now.largest_tension_n(CableKind::Belt), reduced LargestAndMean("belt_tension_max_steady_n"), when BELTS;
    TAPE_LOAD_SHARE => |now| now.tape_load_share, reduced Largest, when TAPE_STRENGTHS;
    VENT_LINE_TENSION_MAX => |now| now.largest_tension_n(CableKind::VentLine), reduced LargestAndMean("vent_line_tension_max_steady_n"), when VENT_LINES;
    RISER_TENSION_MAX => |now| now.largest_tension_n(CableKind::Riser), reduced LargestAndMean("riser_tension_max_steady_n"), when RISERS;
    STRESS_MAX => |now| now.shape.frame.stress_pa.iter().copied().fold(0.0, f64::max), reduced LargestAndMean("stress_max_steady_pa");
    SLIP_RATIO => |now| now.slip_ratio, when BY_MARKERS;
    APEX_OFFSET: "apex_offset_m", "m", "distance of the apex from the line through the confluence along the wind"
        => |now| now.apex_offset_m;
    KINETIC_ENERGY => |now| now.kinetic_energy_j;
    MASS_DEFECT => |now| now.forces.mass_defect;
}

results! {
    /// What follows from them.
    RESULTS: "Canopies in air: forces";
    RATIO_AT_RELEASE: "projected_diameter_ratio_at_release", "1", "projected over nominal diameter at release";
    DRAG: "drag_n", "N", "drag; mean drag coefficient times dynamic pressure and S_0";
    OPENING_FORCE_FACTOR: "opening_force_factor", "1", "largest drag of a sample interval over the mean drag; C_x";
    DESCENT_RATE: "descent_rate_m_s", "m/s", "rate of steady descent with the payload: speed at which the drag coefficient without the walls of the tunnel bears payload and canopy";
    DRAG_LINES: "drag_lines_n", "N", "mean drag by lines; line tensions plus the sheet's own momentum";
}

/// A canopy at a sample.
pub(super) struct Moment {
    time_s: f64,
    wind_m_s: f64,
    forces: Forces,
    /// Dynamic pressure times nominal area [N].
    dynamic_force_n: f64,
    nominal_area_m2: f64,
    slip_ratio: f64,
    apex_offset_m: f64,
    kinetic_energy_j: f64,
    /// Load over breaking load of the line nearest to breaking; not a number where none tells its breaking load.
    line_load_share: f64,
    /// The same of tapes.
    tape_load_share: f64,
    pub shape: Shape,
}

impl Moment {
    /// A sample; `None` where there is no canopy in air.
    pub fn new(
        simulation: &Simulation,
        (shape, canopy): (&CanopyShape, &Canopy),
        forces: Forces,
    ) -> Result<Option<Self>, DeviceError> {
        let (Some(frame), Some(coupled), Some(air)) = (
            simulation.structure_frame().structure,
            simulation.coupled(),
            &simulation.scene().air,
        ) else {
            return Ok(None);
        };
        let reference = air.wind_or_reference_m_s();
        let confluence = canopy.confluence_m(&frame.positions_m);
        let body = simulation.scene().body.as_ref();
        let load_share = |of| {
            let shares = body.map(|body| load_shares(&body.structure, of, &frame.cable_tensions_n));
            let largest = shares.into_iter().flatten().reduce(f64::max);
            largest.unwrap_or(f64::NAN)
        };
        let [line_load_share, tape_load_share] = [Carrier::Lines, Carrier::Tapes].map(load_share);
        let apex = shape.outline().apex(&frame.positions_m) - confluence;
        Ok(Some(Self {
            time_s: simulation.time_s(),
            wind_m_s: simulation.wind_speed_m_s(),
            forces,
            dynamic_force_n: 0.5
                * air.units.density_kg_m3
                * reference
                * reference
                * canopy.nominal_area_m2,
            nominal_area_m2: canopy.nominal_area_m2,
            slip_ratio: coupled.slip_m_s()?.unwrap_or(f64::NAN) / reference,
            apex_offset_m: apex.y.hypot(apex.z),
            kinetic_energy_j: simulation
                .cloth()
                .map_or(f64::NAN, crate::cpu::cloth::Cloth::kinetic_energy_j),
            line_load_share,
            tape_load_share,
            shape: shape.sample(frame),
        }))
    }

    fn line_tensions_n(&self) -> Vec<f64> {
        let frame = &self.shape.frame;
        frame.tensions_n(&[CableKind::SuspensionLine]).collect()
    }

    fn largest_tension_n(&self, kind: CableKind) -> f64 {
        self.shape
            .frame
            .largest_tension_n(&[kind])
            .unwrap_or(f64::NAN)
    }
}

/// As close as times of samples come [D₀/U].
const ROUND_OFF: f64 = 1e-6;

/// Drag coefficient below which relative differences of forces mean nothing.
const NO_DRAG: f64 = 1e-3;

/// How long a run of a canopy or of rigid bodies in the wind of a tunnel is, and from when on means are taken; `None` of other scenes.
#[must_use]
pub fn averaging(scene: &Scene) -> Option<String> {
    if scene.body.is_none() {
        return bodies::averaging(scene);
    }
    let (Some(air), Some(body), Some(time)) = (&scene.air, &scene.body, &scene.time) else {
        return None;
    };
    let (BodyKind::Canopy(canopy), Flow::WindTunnel { speed_m_s, .. }) = (&body.kind, &air.flow)
    else {
        return None;
    };
    (*speed_m_s > 0.0 && scene.descent.is_none()).then(|| {
        format!(
            "length of the run {:.1} D_0/U; means begin {SETTLING} D_0/U after the first peak of the diameter, when the wake has settled, and need {SHORTEST_WINDOW}",
            time.end_s * speed_m_s / canopy.nominal_diameter_m
        )
    })
}

/// Samples over which the means of a canopy in wind are taken; `None` of other scenes.
pub(super) fn averaged(scene: &Scene, record: &Record) -> Option<Range<usize>> {
    let (canopy, air) = (scene.canopy()?, scene.air.as_ref()?);
    if scene.descent.is_some() {
        return None;
    }
    let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
    let window = steady::window(record, unit_s)?;
    Some(window.first..window.end)
}

/// Means over the settled window, extremes and times since release.
pub(super) fn results(
    results: &mut Results,
    record: &Record,
    (scene, canopy, air): (&Scene, &Canopy, &Air),
) {
    let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
    let Some(window) = steady::window(record, unit_s) else {
        let missing = Quantity::missing("the run ended before two samples after the release");
        results.insert(&DRAG_COEFFICIENT, missing);
        return;
    };
    let indicative = (!window.settled || window.length < SHORTEST_WINDOW - ROUND_OFF).then(|| {
        format!(
            "window of {:.1} D_0/U{}; {SHORTEST_WINDOW} after settling are needed: means of this run are indicative only",
            window.length,
            match (window.settled, window.opened) {
                (true, _) => "",
                (false, true) => ", wake not settled",
                (false, false) => ", opening not over",
            }
        )
    });
    let times = record.column(&TIME);
    let released = released(&times);
    let drag = steady::mean(record, &DRAG_COEFFICIENT, &window);
    let mut drag_quantity = quantity(drag);
    if let Some(note) = &indicative {
        drag_quantity = drag_quantity.with_note(note);
    }
    let wind = matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0);
    results.insert(
        &DRAG_COEFFICIENT,
        if wind {
            drag_quantity
        } else {
            Quantity::missing("there is no wind to refer to")
        },
    );
    if matches!(air.flow, Flow::WindTunnel { .. }) {
        let unknown = match (wind, &scene.descent) {
            (false, _) => Some("there is no wind to refer to"),
            (true, Some(_)) => Some(
                "the speed of a fall changes; divide drag_coefficient_terminal by 1 + 1.85 times itself times blockage_ratio",
            ),
            (true, None) => None,
        };
        let corrected = blockage_results(results, canopy, air, drag, unknown);
        if let (Some(carried), Some(body), true) = (&scene.carried, &scene.body, wind) {
            let mass_kg = carried.mass_kg + body.structure.masses_kg.iter().sum::<f64>();
            let area = [canopy.nominal_area_m2, carried.drag_area_m2];
            let own = scene.gravity_m_s2.map(|g| g.length());
            let gravity = own.filter(|g| *g > 0.0).unwrap_or(STANDARD_GRAVITY_M_S2);
            let rate = descent_rate(corrected, mass_kg * gravity, area, air.units.density_kg_m3);
            results.insert(&DESCENT_RATE, quantity(rate));
        }
    }
    let mean = |column: &_| quantity(steady::mean(record, column, &window));
    results.insert(&PROJECTED_DIAMETER_RATIO, mean(&PROJECTED_DIAMETER_RATIO));
    let at_release = record.column(&PROJECTED_DIAMETER_RATIO)[released];
    results.insert(&RATIO_AT_RELEASE, Quantity::new(at_release));
    let ways = ways_past(canopy, air, scene.descent.is_some(), record, released);
    opening::inflation(results, record, released, &ways);
    let of_forces = COLUMNS.of(scene).map(|row| (row.read_out, row.reduced));
    // The mean drag stands there with its remarks already.
    let of_forces = of_forces.filter(|(column, _)| column.name != DRAG_COEFFICIENT.name);
    let shape = record.canopy();
    let of_shape = shape
        .into_iter()
        .flat_map(|shape| canopy_shape::COLUMNS.of(shape));
    let of_shape = of_shape.map(|row| (row.read_out, row.reduced));
    reduce(results, record, of_forces.chain(of_shape), released, mean);
    opening::line_sides(results, record, &window);
    opening::oscillations(results, record, &window);
    let force = 0.5
        * air.units.density_kg_m3
        * air.wind_or_reference_m_s().powi(2)
        * canopy.nominal_area_m2;
    let newtons = Quantity::told(&DRAG, drag.value * force);
    results.insert(
        &DRAG,
        match drag.confidence {
            Some(confidence) => newtons.with_confidence(confidence * force),
            None => newtons,
        },
    );
    let peak = column_max(record, &DRAG_COEFFICIENT, released);
    // Of a canopy that is hardly folded there is no opening.
    if wind && at_release > FOLDED {
        let why = "the canopy was not folded at the start";
        results.insert(&OPENING_FORCE_FACTOR, Quantity::missing(why));
    } else if wind {
        let of_what = if scene.descent.is_some() {
            "the mean drag of the slow end; a handbook's factor refers to the speed of release"
        } else {
            "the mean drag"
        };
        let factor = Quantity::new(peak.1 / drag.value).with_note(&format!(
            "C_x: largest drag of a sample interval, at {:.4} s, over {of_what}",
            peak.0
        ));
        results.insert(
            &OPENING_FORCE_FACTOR,
            match drag.confidence {
                Some(confidence) => {
                    factor.with_confidence(peak.1 * confidence / (drag.value * drag.value))
                }
                None => factor,
            },
        );
    }
    insert_balances(results, record, &window, released, drag.value);
    if indicative.is_some() {
        let means = results.iter_mut();
        for (_, mean) in means.filter(|(name, _)| Supports::Means.covers(name)) {
            mean.mark_unresolved("the wake has not settled");
        }
    }
}

/// Largest projected over nominal diameter at which a canopy counts as folded.
const FOLDED: f64 = 0.5;

/// Ways of the air past a canopy from release until each sample, in D₀. A canopy that falls slows down, and with it the air past it.
fn ways_past(
    canopy: &Canopy,
    air: &Air,
    falls: bool,
    record: &Record,
    released: usize,
) -> Vec<f64> {
    let ways_m = if falls {
        record.column(&HEIGHT_FALLEN)
    } else {
        let speed = air.wind_or_reference_m_s();
        (record.column(&TIME).iter())
            .map(|time| speed * time)
            .collect()
    };
    let mut farthest = 0.0_f64;
    let ways = ways_m[released..].iter().map(|way_m| {
        farthest = farthest.max((way_m - ways_m[released]) / canopy.nominal_diameter_m);
        farthest
    });
    ways.collect()
}

/// Speed at which the drag of a canopy, by its coefficient on the first area, and of a payload, by its own drag area, bears a weight \[m/s\].
fn descent_rate(
    drag: Mean,
    weight_n: f64,
    [nominal_m2, payload_m2]: [f64; 2],
    density: f64,
) -> Mean {
    let area_m2 = drag.value * nominal_m2 + payload_m2;
    let value = (2.0 * weight_n / (density * area_m2)).sqrt();
    Mean {
        value,
        confidence: drag
            .confidence
            .map(|c| 0.5 * value * c * nominal_m2 / area_m2),
    }
}

/// Drag coefficient without the walls of the tunnel, by Macha & Buffington (1990), "Wall-interference corrections for parachutes in a
/// closed wind tunnel", J. Aircraft 27: q_corrected/q = 1 + K C_D S_0/C, C the section. Their K holds for steady drag of inflated
/// canopies between solid walls; ours are frictionless, which takes no drag away.
fn blockage_results(
    results: &mut Results,
    canopy: &Canopy,
    air: &Air,
    drag: Mean,
    unknown: Option<&str>,
) -> Mean {
    let blockage = canopy.nominal_area_m2 / air.section_m2();
    let ratio = 1.0 + THREE_DIMENSIONS * drag.value * blockage;
    let corrected = Mean {
        value: drag.value / ratio,
        confidence: drag.confidence.map(|c| c / (ratio * ratio)),
    };
    results.insert(
        &CORRECTED_DRAG.of(""),
        unknown.map_or_else(
            || {
                quantity(corrected)
                    .with_note("Macha & Buffington 1990, factor 1.85 on C_D S_0 / section")
            },
            Quantity::missing,
        ),
    );
    results.insert(
        &PRESSURE_RATIO.of(""),
        unknown.map_or_else(|| Quantity::told(&PRESSURE_RATIO, ratio), Quantity::missing),
    );
    results.insert(
        &BLOCKAGE_RATIO,
        Quantity::new(blockage).with_note("nominal area over section"),
    );
    corrected
}

fn insert_balances(
    results: &mut Results,
    record: &Record,
    window: &Window,
    released: usize,
    drag_coefficient: f64,
) {
    // A row's drag is that of the interval before it, so the impulses count from the row before the window.
    let routes = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX, &IMPULSE_LINES];
    let samples = [window.first.saturating_sub(1), window.end - 1];
    let [markers, momentum_box, lines] = mean_forces_n(record, routes, samples);
    for (drag, force) in [
        (&DRAG_MARKERS, markers),
        (&DRAG_MOMENTUM_BOX, momentum_box),
        (&DRAG_LINES, lines),
    ] {
        results.tell(drag, force);
    }
    let spread = largest(
        [
            markers - momentum_box,
            markers - lines,
            momentum_box - lines,
        ]
        .map(f64::abs),
    );
    let imbalance = if spread.is_nan() {
        Quantity::missing("the fabric left the momentum box, or is held directly")
    } else if drag_coefficient.abs() < NO_DRAG {
        Quantity::missing("there is no drag to compare with")
    } else {
        Quantity::new(spread / markers.abs())
            .with_note("largest difference of the three routes over the drag")
    };
    results.insert(&FORCE_IMBALANCE, imbalance);
    if record.latest(&SLIP_RATIO).is_some() {
        let slip = steady::mean(record, &SLIP_RATIO, window);
        results.insert(&SLIP_MEAN, quantity(slip));
    }
    let defects = record.column(&MASS_DEFECT);
    results.insert(&MASS_DRIFT, mass_drift(&defects[released..]));
}
