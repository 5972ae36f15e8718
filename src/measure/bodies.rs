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
use super::record::Record;
use super::statistics::{Mean, batch_mean, student};
use crate::case::Scene;
use crate::case::scene::{Air, BodyKind, Flow, RigidBody, Shape};
use crate::case::steady::never_steady;
use crate::measure::steady::bodies::{BodyWindow, Settling, second_half};
use crate::measure::steady::{self, Watched};
use crate::output::{Quantity, Results};
use crate::rigid::Motion;

/// Columns of every body; a scene with more than one thing in the air puts the body's name before them.
pub(super) const COLUMNS: [&str; 9] = [
    "drag_coefficient",
    "lift_coefficient",
    "side_force_coefficient",
    "force_x_n",
    "force_y_n",
    "force_z_n",
    "moment_x_n_m",
    "moment_y_n_m",
    "moment_z_n_m",
];

/// Columns of a scene of bodies alone, before those of the bodies.
pub(super) const SCENE_COLUMNS: [&str; 8] = [
    "time_s",
    "wind_speed_m_s",
    "drag_markers_n",
    "drag_momentum_box_n",
    "impulse_markers_n_s",
    "impulse_momentum_box_n_s",
    "slip_ratio",
    "mass_defect",
];

/// Length of a batch for the uncertainty of means without a settling rule [lengths/U]: longer than a period of vortices.
const BATCH: f64 = 8.0;

/// Change of the drag between two halves of such a window beyond which the flow counts as still developing.
const SETTLED: f64 = 0.01;

/// Amplitude of the lift coefficient below which there is no oscillation to speak of.
const NO_LIFT: f64 = 2e-3;

/// What goes before the names of a body's columns and results.
#[must_use]
pub fn prefix(scene: &Scene, body: &RigidBody) -> String {
    if scene.body.is_none() && scene.rigid_bodies.len() == 1 {
        String::new()
    } else {
        format!("{}_", body.name)
    }
}

/// Direction of the drag.
pub(super) fn drag_direction(air: &Air, body: &RigidBody) -> DVec3 {
    match (&body.motion.motion, air.flow) {
        (_, Flow::WindTunnel { speed_m_s, .. }) if speed_m_s > 0.0 => DVec3::X,
        (Motion::ConstantVelocity { velocity_m_s, .. }, _) => {
            (-*velocity_m_s).try_normalize().unwrap_or(DVec3::X)
        }
        _ => DVec3::X,
    }
}

/// Speed that the coefficients of a body refer to [m/s].
pub(super) fn reference_speed_m_s(air: &Air, body: &RigidBody) -> f64 {
    match (&body.motion.motion, air.flow) {
        (_, Flow::WindTunnel { speed_m_s, .. }) if speed_m_s > 0.0 => speed_m_s,
        (Motion::ConstantVelocity { velocity_m_s, .. }, _) if *velocity_m_s != DVec3::ZERO => {
            velocity_m_s.length()
        }
        _ => air.reference_speed_m_s,
    }
}

/// The columns of a body for a force [N] and a moment [N·m].
pub(super) fn row(air: &Air, body: &RigidBody, force: DVec3, moment: DVec3) -> Vec<f64> {
    let speed = reference_speed_m_s(air, body);
    let scale = 0.5 * air.units.density_kg_m3 * speed * speed * body.reference_area_m2;
    vec![
        force.dot(drag_direction(air, body)) / scale,
        force.z / scale,
        force.y / scale,
        force.x,
        force.y,
        force.z,
        moment.x,
        moment.y,
        moment.z,
    ]
}

/// Reynolds number of a body, with its reference length.
#[must_use]
pub fn reynolds_number(air: &Air, body: &RigidBody) -> f64 {
    reference_speed_m_s(air, body) * body.reference_length_m / air.kinematic_viscosity_m2_s
}

/// What the settling of the flow past a body depends on, or why that never becomes steady.
pub fn settling(scene: &Scene, air: &Air, body: &RigidBody) -> Result<Settling, &'static str> {
    if scene.body.is_some() {
        return Err("fabric beside the body moves");
    }
    if let Some(why) = never_steady(air, scene.descent.is_some(), body) {
        return Err(why);
    }
    let (risen_s, turn_s) = match &body.motion.motion {
        Motion::ConstantVelocity { rise_s, .. } => (*rise_s, None),
        Motion::ConstantRotation { rate_rad_s, rise_s } => {
            let turn_s = std::f64::consts::TAU / rate_rad_s.abs();
            (*rise_s, turn_s.is_finite().then_some(turn_s))
        }
        _ => (0.0, None),
    };
    Ok(Settling {
        unit_s: body.reference_length_m / reference_speed_m_s(air, body),
        risen_s,
        turn_s,
        unsteady: reynolds_number(air, body) > steady_reynolds_number(body.shape),
    })
}

/// Reynolds number up to which the wake of a shape is steady: sphere 210 and disk 116 (Natarajan & Acrivos 1993, J. Fluid Mech. 254), all
/// others that of a cylinder across the stream, 47 (Williamson 1996, Annu. Rev. Fluid Mech. 28).
fn steady_reynolds_number(shape: Shape) -> f64 {
    match shape {
        Shape::Sphere { .. } => 210.0,
        Shape::Disk { .. } => 116.0,
        Shape::Plate { .. } | Shape::Cylinder { .. } | Shape::Mesh => 47.0,
    }
}

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
                columns: [
                    "drag_coefficient",
                    "lift_coefficient",
                    "side_force_coefficient",
                ]
                .map(|name| format!("{}{name}", prefix(scene, body))),
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
        let times = record.column("time_s");
        match settling(scene, air, body) {
            Ok(settling) => {
                let drag = record.column(&format!("{}drag_coefficient", prefix(scene, body)));
                Some(Self::Settled(BodyWindow::new(&times, &drag, &settling)?))
            }
            Err(why) => {
                let samples = second_half(&times)?;
                let unit_s = body.reference_length_m / reference_speed_m_s(air, body);
                let interval_s = interval(&times, &samples);
                let batch = ((BATCH * unit_s / interval_s).round() as usize).max(1);
                Some(Self::Half {
                    samples,
                    batch,
                    why,
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

    fn mean(&self, record: &Record, name: &str) -> Mean {
        match self {
            Self::Settled(window) => window.mean(&record.column(name)),
            Self::Canopy(window) => steady::mean(record, name, window),
            Self::Half { samples, batch, .. } => {
                batch_mean(&record.column(name)[samples.clone()], *batch)
            }
        }
    }

    fn unsettled(&self, drag: &[f64], across: [&[f64]; 2]) -> Option<String> {
        match self {
            Self::Settled(window) => window.unsettled(drag, across),
            Self::Canopy(window) => {
                (!window.settled).then(|| "not settled: the wake of the canopy".to_owned())
            }
            Self::Half { .. } => None,
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
                let drag = &drag[samples.clone()];
                let half = drag.len() / 2;
                let [early, late] = [&drag[..half], &drag[half..]].map(|d| batch_mean(d, 1).value);
                let change = (late - early) / batch_mean(drag, 1).value;
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

/// Time between samples [s].
fn interval(times: &[f64], samples: &std::ops::Range<usize>) -> f64 {
    (times[samples.end - 1] - times[samples.start]) / (samples.len() - 1) as f64
}

/// Means of a body, besides its drag coefficient.
const MEANS: [(&str, &str); 8] = [
    ("lift_coefficient", "1"),
    ("side_force_coefficient", "1"),
    ("force_x_n", "N"),
    ("force_y_n", "N"),
    ("force_z_n", "N"),
    ("moment_x_n_m", "N m"),
    ("moment_y_n_m", "N m"),
    ("moment_z_n_m", "N m"),
];

/// Results of every body.
pub(super) fn body_results(results: &mut Results, record: &Record, scene: &Scene, air: &Air) {
    for body in &scene.rigid_bodies {
        of_body(results, record, (scene, air, body));
    }
}

fn of_body(results: &mut Results, record: &Record, (scene, air, body): (&Scene, &Air, &RigidBody)) {
    let prefix = prefix(scene, body);
    let name = |name: &str| format!("{prefix}{name}");
    let Some(averaging) = Averaging::new(record, scene, air, body) else {
        results.insert(
            &name("drag_coefficient"),
            Quantity::missing("1", "the run ended too early"),
        );
        return;
    };
    let times = record.column("time_s");
    let samples = averaging.samples();
    let unit_s = body.reference_length_m / reference_speed_m_s(air, body);
    let length = (times[samples.end - 1] - times[samples.start]) / unit_s;
    let drags = record.column(&name("drag_coefficient"));
    let [lift, side] = ["lift_coefficient", "side_force_coefficient"]
        .map(|coefficient| record.column(&name(coefficient)));
    let unsettled = averaging.unsettled(&drags, [&lift, &side]);
    let marked = |mut quantity: Quantity| {
        if let Some(why) = &unsettled {
            quantity.mark_unresolved(why);
        }
        quantity
    };
    let drag = averaging.mean(record, &name("drag_coefficient"));
    let mut quantity = marked(with_interval(drag, "1"));
    if let Some((reference, source)) = reference_drag(air, body) {
        quantity = quantity.with_reference(reference, source);
    }
    let note = averaging.note(&drags, length);
    results.insert(&name("drag_coefficient"), quantity.with_note(&note));
    blockage::results(results, (scene, air, body), drag, unsettled.as_deref());
    for (column, unit) in MEANS {
        let mean = averaging.mean(record, &name(column));
        results.insert(&name(column), marked(with_interval(mean, unit)));
    }
    let lift = &lift[samples.clone()];
    results.insert(
        &name("strouhal_number"),
        match frequency(lift, interval(&times, &samples), NO_LIFT) {
            Ok(mean) => {
                let strouhal = Mean {
                    value: mean.value * unit_s,
                    confidence: mean.confidence.map(|c| c * unit_s),
                };
                marked(with_interval(strouhal, "1")).with_note("of the lift, f L/U")
            }
            Err(why) => Quantity::missing("1", &format!("of the lift: {why}")),
        },
    );
    results.insert(
        &name("reference_area_m2"),
        Quantity::new(body.reference_area_m2, "m2"),
    );
}

/// Results of a scene of bodies alone.
pub(super) fn scene_results(results: &mut Results, record: &Record, scene: &Scene, air: &Air) {
    body_results(results, record, scene, air);
    // Of several bodies the window that begins last.
    let Some(window) = scene
        .rigid_bodies
        .iter()
        .filter_map(|body| Some(Averaging::new(record, scene, air, body)?.samples()))
        .max_by_key(|samples| samples.start)
    else {
        return;
    };
    let section = blockage::section_m2(air);
    let area: f64 = scene.rigid_bodies.iter().map(|b| b.reference_area_m2).sum();
    results.insert(
        "blockage_ratio",
        Quantity::new(area / section, "1").with_note("reference area over section"),
    );
    let times = record.column("time_s");
    let (first, last) = (window.start, window.end - 1);
    let [markers, momentum_box] = ["impulse_markers_n_s", "impulse_momentum_box_n_s"].map(|name| {
        let impulse = record.column(name);
        (impulse[last] - impulse[first]) / (times[last] - times[first])
    });
    for (name, force, what) in [
        ("drag_markers_n", markers, "sum over markers"),
        (
            "drag_momentum_box_n",
            momentum_box,
            "populations through a box, with storage",
        ),
    ] {
        results.insert(name, Quantity::new(force, "N").with_note(what));
    }
    let imbalance = (markers - momentum_box).abs() / markers.abs();
    results.insert(
        "force_imbalance",
        if imbalance.is_finite() {
            Quantity::new(imbalance, "1").with_note("difference of the two routes over the drag")
        } else {
            Quantity::missing("1", "markers left the momentum box, or there is no drag")
        },
    );
    let slip = &record.column("slip_ratio")[window];
    results.insert(
        "slip_mean",
        Quantity::new(slip.iter().sum::<f64>() / slip.len() as f64, "1"),
    );
    let defects = record.column("mass_defect");
    let defect = super::record::largest(defects.into_iter().filter(|d| !d.is_nan()).map(f64::abs));
    results.insert(
        "mass_drift",
        Quantity::new(defect, "1")
            .with_note("largest defect of the mass balance of the momentum box, over its mass"),
    );
}

fn with_interval(mean: Mean, unit: &str) -> Quantity {
    let quantity = Quantity::new(mean.value, unit);
    match mean.confidence {
        Some(confidence) => quantity.with_confidence(confidence),
        None => quantity,
    }
}

/// Published drag coefficient of a body at rest in an unbounded stream, where its Reynolds number is covered.
fn reference_drag(air: &Air, body: &RigidBody) -> Option<(f64, &'static str)> {
    let steady = match &body.motion.motion {
        Motion::Held => true,
        Motion::ConstantVelocity { .. } => {
            matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s == 0.0)
        }
        _ => false,
    };
    let speed = reference_speed_m_s(air, body);
    if !steady {
        return None;
    }
    match body.shape {
        Shape::Sphere { diameter_m } => {
            sphere_drag(speed * diameter_m / air.kinematic_viscosity_m2_s)
                .map(|drag| (drag, "Schiller & Naumann 1933: 24/Re (1 + 0.15 Re^0.687)"))
        }
        Shape::Disk { diameter_m }
            if body.normal.dot(drag_direction(air, body)).abs() > 0.9999 =>
        {
            disk_drag(speed * diameter_m / air.kinematic_viscosity_m2_s).map(|drag| {
                (
                    drag,
                    "Clift, Grace & Weber 1978: 64/(pi Re) (1 + 0.138 Re^0.792), disk normal to the flow",
                )
            })
        }
        _ => None,
    }
}

/// Drag coefficient of a sphere, 0.5 < Re < 800 (Schiller & Naumann 1933, within 5 %).
#[must_use]
pub fn sphere_drag(reynolds: f64) -> Option<f64> {
    (0.5..=800.0)
        .contains(&reynolds)
        .then(|| 24.0 / reynolds * (1.0 + 0.15 * reynolds.powf(0.687)))
}

/// Drag coefficient of a disk normal to the flow, 1.5 < Re ≤ 133 (Clift, Grace & Weber 1978).
#[must_use]
pub fn disk_drag(reynolds: f64) -> Option<f64> {
    (1.5..=133.0)
        .contains(&reynolds)
        .then(|| 64.0 / (std::f64::consts::PI * reynolds) * (1.0 + 0.138 * reynolds.powf(0.792)))
}

/// Frequency of an evenly sampled oscillation, from its upward passages through the mean [1/time of `interval`], with the interval that the
/// scatter of the periods leads to; an error says why there is none, such as an amplitude below `least`.
pub(super) fn frequency(series: &[f64], interval: f64, least: f64) -> Result<Mean, &'static str> {
    let mean = batch_mean(series, 1).value;
    let square = series.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / series.len() as f64;
    if (2.0 * square).sqrt() < least {
        return Err("it does not oscillate");
    }
    let passages: Vec<f64> = (1..series.len())
        .filter(|&i| series[i - 1] < mean && series[i] >= mean)
        .map(|i| i as f64 - (series[i] - mean) / (series[i] - series[i - 1]))
        .collect();
    let periods: Vec<f64> = passages.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if periods.len() < 4 {
        return Err("fewer than four periods");
    }
    let period = periods.iter().sum::<f64>() / periods.len() as f64;
    if periods.iter().any(|p| (p / period - 1.0).abs() > 0.3) {
        return Err("there is no single period");
    }
    let n = periods.len() as f64;
    let variance = periods.iter().map(|p| (p - period).powi(2)).sum::<f64>() / (n - 1.0);
    let half = student(periods.len() - 1) * (variance / n).sqrt();
    let value = 1.0 / (period * interval);
    Ok(Mean {
        value,
        confidence: Some(value * half / period),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_and_their_absence() {
        let wave = |f: f64, a: f64| -> Vec<f64> {
            (0..500)
                .map(|i| 0.3 + a * (std::f64::consts::TAU * f * 0.1 * f64::from(i)).sin())
                .collect()
        };
        let known = frequency(&wave(0.37, 0.2), 0.1, NO_LIFT).unwrap();
        assert!((known.value - 0.37).abs() < 1e-3, "{known:?}");
        assert!(known.confidence.unwrap() < 1e-3, "{known:?}");
        // Periods of 2.5 and 2.9 in turn: ± 0.2 on ten of them, Student's t 2.26.
        let uneven: Vec<f64> = (0..300)
            .map(|i| {
                let t = (0.1 * f64::from(i)) % 5.4;
                let phase = if t < 2.5 { t / 2.5 } else { (t - 2.5) / 2.9 };
                (std::f64::consts::TAU * phase).sin()
            })
            .collect();
        let scattered = frequency(&uneven, 0.1, NO_LIFT).unwrap();
        let share = scattered.confidence.unwrap() / scattered.value;
        assert!((0.04..0.08).contains(&share), "{scattered:?}");
        assert!(frequency(&wave(0.37, 1e-4), 0.1, NO_LIFT).is_err());
        assert!(frequency(&wave(0.05, 0.2), 0.1, NO_LIFT).is_err());
    }

    /// Re 100: 1.09 for the sphere (VALIDATION of this project, and the correlation); limits of the ranges.
    #[test]
    fn published_values() {
        assert!((sphere_drag(100.0).unwrap() - 1.0917).abs() < 1e-3);
        assert!(sphere_drag(1e4).is_none());
        assert!((disk_drag(100.0).unwrap() - 1.282).abs() < 1e-3);
    }
}
