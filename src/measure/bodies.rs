//! What the air does to rigid bodies: columns of the history and named results.
//!
//! Drag is the force along the wind (+x); without wind, against a body's constant velocity. Lift is the force along +z, the side force
//! along +y. Coefficients refer to ½ ρ U² and the body's reference area, those of moments also to its reference length, with U the wind
//! speed; without wind a body's constant speed, else the reference speed of the lattice. Forces on closed bodies are those of the air
//! outside: what the air inside takes up, moving with the body, is taken off.
//!
//! Means of bodies in a steady stream begin when the flow has settled ([`crate::measure::steady::bodies`]), those beside a canopy with the canopy's;
//! all others are taken over the second half of the run.

use glam::DVec3;

use super::blockage;
use super::flow_past_bodies::{drag_direction, prefix, reference_drag, settling};
use super::impulses::{Forces, Impulses};
use super::read_out::Reduction::Mean as MeanOf;
use super::read_out::{ReadOut, columns, results};
use super::record::Record;
use super::reduce::{mass_drift, mean_forces_n, quantity};
use super::shared::{
    BLOCKAGE_RATIO, BY_MARKERS, DRAG_MARKERS, DRAG_MOMENTUM_BOX, FORCE_IMBALANCE, IMPULSE_MARKERS,
    IMPULSE_MOMENTUM_BOX, MASS_DEFECT, MASS_DRIFT, SLIP_MEAN, SLIP_RATIO, STROUHAL_NUMBER, TIME,
    WIND_SPEED,
};
use super::spectrum::frequency;
use super::statistics::{Mean, average, batch_mean, range};
use super::steady::bodies::{BodyWindow, second_half};
use super::steady::{self, Watched};
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, RigidBody};
use crate::gpu::DeviceError;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

columns! {
    /// Of every body; a scene with more than one thing in the air puts the body's name before them.
    COLUMNS of Moment, in Scene: "Rigid bodies in air";
    BODY_DRAG: "{body}drag_coefficient", "1", "drag coefficient; on ½ ρ U² and the reference area"
        => |now| now.force_n.dot(now.along) / now.scale_n, reduced MeanOf;
    BODY_LIFT: "{body}lift_coefficient", "1", "lift coefficient, along z" => |now| now.force_n.z / now.scale_n, reduced MeanOf;
    BODY_SIDE_FORCE: "{body}side_force_coefficient", "1", "coefficient of the side force, along y" => |now| now.force_n.y / now.scale_n, reduced MeanOf;
    BODY_FORCE_X: "{body}force_x_n", "N", "force of the air along x" => |now| now.force_n.x, reduced MeanOf;
    BODY_FORCE_Y: "{body}force_y_n", "N", "force of the air along y" => |now| now.force_n.y, reduced MeanOf;
    BODY_FORCE_Z: "{body}force_z_n", "N", "force of the air along z" => |now| now.force_n.z, reduced MeanOf;
    BODY_MOMENT_X: "{body}moment_x_n_m", "N m", "moment of the air about x" => |now| now.moment_n_m.x, reduced MeanOf;
    BODY_MOMENT_Y: "{body}moment_y_n_m", "N m", "moment of the air about y" => |now| now.moment_n_m.y, reduced MeanOf;
    BODY_MOMENT_Z: "{body}moment_z_n_m", "N m", "moment of the air about z" => |now| now.moment_n_m.z, reduced MeanOf;
}

columns! {
    /// Of a scene of bodies alone, before those of the bodies; the drag is that along the first body's direction.
    OF_SCENE of Bodies, in Scene: "Rigid bodies alone in air: all together";
    TIME => |now| now.time_s;
    WIND_SPEED => |now| now.wind_m_s;
    DRAG_MARKERS => |now| now.forces.markers_n.dot(now.along);
    DRAG_MOMENTUM_BOX => |now| now.forces.momentum_box_n.dot(now.along);
    IMPULSE_MARKERS => |now| now.forces.impulse.markers.dot(now.along);
    IMPULSE_MOMENTUM_BOX => |now| now.forces.impulse.momentum_box.dot(now.along);
    SLIP_RATIO => |now| now.slip_ratio, when BY_MARKERS;
    MASS_DEFECT => |now| now.forces.mass_defect;
}

results! {
    /// Of every body.
    RESULTS: "Rigid bodies in air";
    REFERENCE_AREA: "{body}reference_area_m2", "m2", "area that the body's coefficients refer to";
}

/// A body at a sample.
pub(super) struct Moment {
    /// Direction of the drag.
    along: DVec3,
    /// Dynamic pressure times reference area [N].
    scale_n: f64,
    /// Mean since the last sample [N].
    force_n: DVec3,
    /// The same [N m].
    moment_n_m: DVec3,
}

/// All bodies of a scene without fabric at a sample.
pub(super) struct Bodies {
    time_s: f64,
    wind_m_s: f64,
    along: DVec3,
    forces: Forces,
    slip_ratio: f64,
}

impl Bodies {
    /// A sample; `None` where there are no bodies in air.
    pub fn new(simulation: &Simulation, forces: Forces) -> Result<Option<Self>, DeviceError> {
        let scene = simulation.scene();
        let (Some(air), Some(body), Some(coupled)) =
            (&scene.air, scene.rigid_bodies.first(), simulation.coupled())
        else {
            return Ok(None);
        };
        Ok(Some(Self {
            time_s: simulation.time_s(),
            wind_m_s: simulation.wind_speed_m_s(),
            along: drag_direction(air, body),
            forces,
            slip_ratio: coupled.slip_m_s()?.unwrap_or(f64::NAN) / body.reference_speed_m_s(air),
        }))
    }
}

/// Columns of every body of a scene.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = ReadOut> {
    let bodies = scene.rigid_bodies.iter();
    bodies.flat_map(|body| COLUMNS.read_outs_of(scene, &prefix(scene, body)))
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation, impulses: &Impulses) -> Vec<f64> {
    let scene = simulation.scene();
    let Some(air) = &scene.air else {
        return Vec::new();
    };
    let moment = |(number, body): (usize, &RigidBody)| {
        let speed = body.reference_speed_m_s(air);
        let [force_n, moment_n_m] = impulses.of_body(number);
        Moment {
            along: drag_direction(air, body),
            scale_n: 0.5 * air.units.density_kg_m3 * speed * speed * body.reference_area_m2,
            force_n,
            moment_n_m,
        }
    };
    let moments = scene.rigid_bodies.iter().enumerate().map(moment);
    moments
        .flat_map(|moment| COLUMNS.values(scene, Some(&moment)))
        .collect()
}

/// Length of a batch for the uncertainty of means without a settling rule [lengths/U]: longer than a period of vortices.
const BATCH: f64 = 8.0;

/// Change of the drag between two halves of such a window beyond which the flow counts as still developing.
const SETTLED: f64 = 0.01;

/// The same beyond which its mean is marked: no value that is off by more counts as resolved in a sweep either.
const UNSETTLED: f64 = 0.05;

/// Amplitude of the lift coefficient below which there is no oscillation to speak of.
const NO_LIFT: f64 = 2e-3;

/// The bodies whose drags decide when a run may stop: all of the scene; an error names one whose flow never becomes steady, and why.
pub fn watched(scene: &Scene) -> Result<Vec<Watched>, (String, &'static str)> {
    let Some(air) = &scene.air else {
        return Ok(Vec::new());
    };
    scene
        .rigid_bodies
        .iter()
        .map(|body| {
            Ok(Watched {
                name: body.name.clone(),
                columns: [&BODY_DRAG, &BODY_LIFT, &BODY_SIDE_FORCE]
                    .map(|column| column.of(prefix(scene, body))),
                settling: settling(scene, air, body).map_err(|why| (body.name.clone(), why))?,
            })
        })
        .collect()
}

/// How long a run of bodies alone is, and from when on means are taken; `None` of other scenes.
pub(super) fn averaging(scene: &Scene) -> Option<String> {
    let time = scene.time?;
    let of_body = |body: Watched| {
        let [begin, least] = body.settling.times();
        format!(
            "length of the run {:.1} L/U of `{}`; its means begin {begin} L/U after the speeds have risen, and need {least}",
            time.end_s / body.settling.unit_s,
            body.name,
        )
    };
    let lines: Vec<String> = watched(scene).ok()?.into_iter().map(of_body).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// The samples that the means of a body are taken over.
enum Averaging {
    /// After its flow has settled.
    Settled(BodyWindow),
    /// Those of the canopy beside it.
    Canopy(steady::Window),
    /// The second half of the run, since there is no rule.
    Half {
        samples: std::ops::Range<usize>,
        batch: usize,
        why: &'static str,
        /// In a box that falls.
        falls: bool,
    },
}

impl Averaging {
    fn new(record: &Record, scene: &Scene, air: &Air, body: &RigidBody) -> Option<Self> {
        if let (Some(BodyKind::Canopy(canopy)), None) =
            (scene.body.as_ref().map(|body| &body.kind), &scene.descent)
        {
            let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
            return Some(Self::Canopy(steady::window(record, unit_s)?));
        }
        let times = record.column(&TIME);
        match settling(scene, air, body) {
            Ok(settling) => {
                let drag = record.column(&BODY_DRAG.of(prefix(scene, body)));
                Some(Self::Settled(BodyWindow::new(&times, &drag, &settling)?))
            }
            Err(why) => {
                let samples = second_half(&times)?;
                let unit_s = body.reference_length_m / body.reference_speed_m_s(air);
                let interval_s = interval(&times, &samples);
                let batch = ((BATCH * unit_s / interval_s).round() as usize).max(1);
                Some(Self::Half {
                    samples,
                    batch,
                    why,
                    falls: scene.descent.is_some(),
                })
            }
        }
    }

    fn samples(&self) -> std::ops::Range<usize> {
        match self {
            Self::Settled(window) => window.first..window.end,
            Self::Canopy(window) => window.first..window.end,
            Self::Half { samples, .. } => samples.clone(),
        }
    }

    fn mean(&self, record: &Record, column: &ReadOut) -> Mean {
        match self {
            Self::Settled(window) => window.mean(&record.column(column)),
            Self::Canopy(window) => steady::mean(record, column, window),
            Self::Half { samples, batch, .. } => {
                batch_mean(&record.column(column)[samples.clone()], *batch)
            }
        }
    }

    fn unsettled(&self, drag: &[f64], across: [&[f64]; 2]) -> Option<String> {
        match self {
            Self::Settled(window) => window.unsettled(drag, Some(across)),
            Self::Canopy(window) => {
                (!window.settled).then(|| "not settled: the wake of the canopy".to_owned())
            }
            // Of a fall the means at the terminal speed are judged by themselves.
            Self::Half { falls: true, .. } => None,
            Self::Half { samples, .. } => {
                let change = change_between_halves(&drag[samples.clone()]);
                (change.abs() > UNSETTLED).then(|| {
                    format!("not settled: the mean drag changes by {:.1} % from one half of its window to the other", 100.0 * change)
                })
            }
        }
    }

    /// What the mean is over; `length` in L/U.
    fn note(&self, drag: &[f64], length: f64) -> String {
        match self {
            Self::Settled(window) => format!(
                "mean over the last {length:.1} L/U; interval: {}",
                window.how()
            ),
            Self::Canopy(_) => {
                format!("mean over the last {length:.1} L/U, as that of the canopy")
            }
            Self::Half { samples, why, .. } => {
                let change = change_between_halves(&drag[samples.clone()]);
                let mut note = format!(
                    "mean over the last {length:.1} L/U, the second half of the run: {why}"
                );
                if change.abs() > SETTLED {
                    note += &format!(", still changing by {:.1} %", 100.0 * change);
                }
                note
            }
        }
    }
}

/// Change of the mean of a series from its first half to its second, over the root of its mean square: of what swings about nothing that is not much.
fn change_between_halves(series: &[f64]) -> f64 {
    let (early, late) = series.split_at(series.len() / 2);
    let square = series.iter().map(|value| value * value).sum::<f64>() / series.len() as f64;
    (average(late) - average(early)) / square.sqrt()
}

/// Time between samples [s].
fn interval(times: &[f64], samples: &std::ops::Range<usize>) -> f64 {
    (times[samples.end - 1] - times[samples.start]) / (samples.len() - 1) as f64
}

/// Results of every body.
pub(super) fn body_results(results: &mut Results, record: &Record, scene: &Scene, air: &Air) {
    for body in &scene.rigid_bodies {
        of_body(results, record, (scene, air, body));
    }
}

fn of_body(results: &mut Results, record: &Record, (scene, air, body): (&Scene, &Air, &RigidBody)) {
    let prefix = prefix(scene, body);
    let own = |read_out: &ReadOut| read_out.of(&prefix);
    let Some(averaging) = Averaging::new(record, scene, air, body) else {
        results.insert(
            &own(&BODY_DRAG),
            Quantity::missing("the run ended too early"),
        );
        return;
    };
    let times = record.column(&TIME);
    let samples = averaging.samples();
    let unit_s = body.reference_length_m / body.reference_speed_m_s(air);
    let length = (times[samples.end - 1] - times[samples.start]) / unit_s;
    let drags = record.column(&own(&BODY_DRAG));
    let [lift, side] =
        [&BODY_LIFT, &BODY_SIDE_FORCE].map(|coefficient| record.column(&own(coefficient)));
    let unsettled = averaging.unsettled(&drags, [&lift, &side]);
    let marked = |mut quantity: Quantity| {
        if let Some(why) = &unsettled {
            quantity.mark_unresolved(why);
        }
        quantity
    };
    for column in COLUMNS.reduced(scene, MeanOf).map(own) {
        let mean = averaging.mean(record, &column);
        results.insert(&column, marked(self::quantity(mean)));
    }
    let drag = averaging.mean(record, &own(&BODY_DRAG));
    let mut quantity = marked(self::quantity(drag));
    if let Some((reference, source)) = reference_drag(scene, air, body) {
        quantity = quantity.with_reference(reference, source);
    }
    let note = averaging.note(&drags, length);
    results.insert(&own(&BODY_DRAG), quantity.with_note(&note));
    blockage::results(results, (scene, air, body), drag, unsettled.as_deref());
    // A cylinder along z has its lift across the stream as a side force.
    let across = [&lift, &side].map(|force| &force[samples.clone()]);
    let [of_lift, of_side] = across.map(range);
    let (force, name) = if of_side > of_lift {
        (across[1], "side force")
    } else {
        (across[0], "lift")
    };
    results.insert(
        &own(&STROUHAL_NUMBER),
        match frequency(force, interval(&times, &samples), NO_LIFT) {
            Ok(mean) => {
                let strouhal = Mean {
                    value: mean.value * unit_s,
                    confidence: mean.confidence.map(|c| c * unit_s),
                };
                marked(self::quantity(strouhal)).with_note(&format!("of the {name}, f L/U"))
            }
            Err(why) => Quantity::missing(&format!("of the {name}: {why}")),
        },
    );
    results.insert(&own(&REFERENCE_AREA), Quantity::new(body.reference_area_m2));
}

/// Samples that the results of a scene of bodies alone are taken over: of several bodies the window that begins last.
fn common_samples(record: &Record, scene: &Scene, air: &Air) -> Option<std::ops::Range<usize>> {
    scene
        .rigid_bodies
        .iter()
        .filter_map(|body| Some(Averaging::new(record, scene, air, body)?.samples()))
        .max_by_key(|samples| samples.start)
}

/// The same; `None` of other scenes.
pub(super) fn averaged(scene: &Scene, record: &Record) -> Option<std::ops::Range<usize>> {
    let air = scene.air.as_ref().filter(|_| scene.body.is_none())?;
    common_samples(record, scene, air)
}

/// Results of a scene of bodies alone.
pub(super) fn scene_results(results: &mut Results, record: &Record, scene: &Scene, air: &Air) {
    body_results(results, record, scene, air);
    let Some(window) = common_samples(record, scene, air) else {
        return;
    };
    let section = air.section_m2();
    let area: f64 = scene.rigid_bodies.iter().map(|b| b.blocking_area_m2).sum();
    results.insert(
        &BLOCKAGE_RATIO,
        Quantity::new(area / section).with_note("frontal area in the box over section"),
    );
    let impulses = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX];
    // A row's drag is that of the interval before it, so the impulses count from the row before the window.
    let samples = [window.start.saturating_sub(1), window.end - 1];
    let [markers, momentum_box] = mean_forces_n(record, impulses, samples);
    for (drag, force) in [(&DRAG_MARKERS, markers), (&DRAG_MOMENTUM_BOX, momentum_box)] {
        results.tell(drag, force);
    }
    let imbalance = (markers - momentum_box).abs() / markers.abs();
    results.insert(
        &FORCE_IMBALANCE,
        if imbalance.is_finite() {
            Quantity::new(imbalance).with_note("difference of the two routes over the drag")
        } else {
            Quantity::missing("markers left the momentum box, or there is no drag")
        },
    );
    if record.latest(&SLIP_RATIO).is_some() {
        let slip = &record.column(&SLIP_RATIO)[window];
        results.insert(&SLIP_MEAN, Quantity::new(average(slip)));
    }
    let defects = record.column(&MASS_DEFECT);
    results.insert(&MASS_DRIFT, mass_drift(&defects));
}
