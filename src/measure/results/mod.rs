//! Named results of a run.

mod air;
mod canopy;
mod canopy_shape;
mod fabric;
mod filling;

pub use canopy::averaging;

use glam::DVec3;

use super::statistics::Mean;
use super::{
    Record, bodies, falling, flown_ballooning, imported_wing, load_test, payload_bodies, plate,
    residual, sail_support, supports, wing, wing_trim, wing_wind,
};
use crate::case::scene::{BodyKind, Scene};
use crate::frame::StructureFrame;
use crate::measure::steady;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;
use crate::statics::Statics;

/// All results that the scene of a simulation defines.
#[must_use]
pub fn results(simulation: &Simulation, statics: &Statics, record: &Record) -> Results {
    let frame = simulation.structure_frame();
    let structure = frame.structure.as_ref();
    of_scene(simulation.scene(), structure, record, statics)
}

/// Rows of frequency [Hz] and power density [m² s] with which the skirt flaps, averaged over the gores; `None` where there is no canopy in
/// air, or before its opening is over.
#[must_use]
pub fn skirt_spectrum(scene: &Scene, record: &Record) -> Option<Vec<Vec<f64>>> {
    let (Some(body), Some(air)) = (&scene.body, &scene.air) else {
        return None;
    };
    let BodyKind::Canopy(canopy) = &body.kind else {
        return None;
    };
    let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
    let window = steady::window(record, unit_s)?;
    let spectrum = canopy_shape::skirt_spectrum(record, &window)?;
    let pairs = spectrum.frequencies.iter().zip(&spectrum.densities);
    Some(pairs.map(|(f, density)| vec![*f, *density]).collect())
}

/// All results from the scene, its structure at the end of the run, and what was recorded.
pub(super) fn of_scene(
    scene: &Scene,
    structure: Option<&StructureFrame>,
    record: &Record,
    statics: &Statics,
) -> Results {
    let mut results = Results::new();
    match (&scene.body, &scene.air) {
        (Some(body), Some(air)) => {
            if let BodyKind::Canopy(canopy) = &body.kind {
                canopy::results(&mut results, record, canopy, air);
            } else {
                fabric::in_wind(&mut results, record);
            }
            if let BodyKind::Plate(shape) = &body.kind {
                plate::results(&mut results, record, shape, air);
            }
            wing_wind::results(&mut results, record, scene, structure);
        }
        (Some(body), None) => {
            if let Some(structure) = structure {
                let weight: f64 = body.structure.masses_kg.iter().sum::<f64>()
                    * scene.gravity_m_s2.map_or(0.0, DVec3::length);
                let rests = scene.equilibrium.is_some() && scene.supports.is_empty();
                fabric::alone(&mut results, &body.kind, structure, (weight, rests));
                if let Some(known) = scene.imported_wing() {
                    imported_wing::results(&mut results, known, structure);
                }
                if let Some(known) = scene.wing() {
                    let gravity = scene.gravity_m_s2.unwrap_or(DVec3::ZERO);
                    let mass: f64 = body.structure.masses_kg.iter().sum();
                    let trim = statics.trim.as_ref();
                    if known.trim.is_some() {
                        wing_trim::results(&mut results, known, &body.structure, structure, trim);
                    }
                    wing::results(&mut results, known, structure, gravity * mass, trim);
                    sail_support::results(&mut results, known, &body.structure, structure);
                    if known.panel_shaping.is_some() {
                        flown_ballooning::results(&mut results, statics.shaping_steps());
                    }
                    if known.load_test.is_some() {
                        let designed = &body.structure;
                        let tested = statics.load_test.as_ref();
                        load_test::results(&mut results, known, designed, gravity.length(), tested);
                    }
                }
            }
        }
        (None, Some(air)) if !scene.rigid_bodies.is_empty() => {
            bodies::scene_results(&mut results, record, scene, air);
        }
        (None, Some(air)) => air::results(&mut results, record, air),
        (None, None) => {}
    }
    through_results(&mut results, record);
    if scene.descent.is_some() {
        falling::results(&mut results, record, scene);
        payload_bodies::results(&mut results, record, scene);
    }
    line_drag_results(&mut results, record);
    contact_results(&mut results, record);
    residual::results(&mut results, record, scene);
    supports::results(&mut results, record, scene);
    if let (Some(_), Some(air)) = (&scene.body, &scene.air) {
        bodies::body_results(&mut results, record, scene, air);
    }
    results
}

/// Drag of suspension lines, mean over the second half of the run.
fn line_drag_results(results: &mut Results, record: &Record) {
    let values = record.column("line_drag_n");
    let Some(half) = values
        .get(values.len() / 2..)
        .filter(|half| !half.is_empty())
    else {
        return;
    };
    let mean = half.iter().sum::<f64>() / half.len() as f64;
    results.insert(
        "line_drag_n",
        Quantity::new(mean, "N")
            .with_note("along the wind, second half of the run; not given to the air"),
    );
}

/// What passes permeable surfaces: means over the second half of the run.
fn through_results(results: &mut Results, record: &Record) {
    let times = record.column("time_s");
    let Some(released) = times.iter().position(|&t| t > 0.0) else {
        return;
    };
    let first = released.midpoint(times.len());
    for (name, what) in [
        ("through_velocity_m_s", "along the normals of the triangles"),
        (
            "through_velocity_of_slip_m_s",
            "what residual slip adds: the permeability of the method itself",
        ),
    ] {
        let values = record.column(name);
        if let Some(values) = values.get(first..).filter(|values| !values.is_empty()) {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let note = format!("mean over the permeable area, second half of the run; {what}");
            results.insert(name, Quantity::new(mean, "m/s").with_note(&note));
        }
    }
}

/// Where fabric meets itself.
fn contact_results(results: &mut Results, record: &Record) {
    let gaps = record.column("smallest_gap_m");
    if gaps.is_empty() {
        return;
    }
    // f64::min passes over samples in which nothing is near.
    let smallest = gaps.into_iter().fold(f64::INFINITY, f64::min);
    let gap = if smallest.is_finite() {
        Quantity::new(smallest, "m").with_note("smallest of all samples, between middle surfaces")
    } else {
        Quantity::missing(
            "m",
            "no fabric came closer to other fabric than contact.thickness_m",
        )
    };
    results.insert("smallest_gap_m", gap);
    let energies = record.column("contact_energy_j");
    let largest = energies.into_iter().fold(0.0, f64::max);
    results.insert(
        "contact_energy_max_j",
        Quantity::new(largest, "J").with_note("largest of all samples"),
    );
}

fn quantity(mean: Mean, unit: &str) -> Quantity {
    let quantity = Quantity::new(mean.value, unit);
    match mean.confidence {
        Some(confidence) => quantity.with_confidence(confidence),
        None => quantity,
    }
}

/// (time, value) of the largest entry from `first` on.
pub(super) fn column_max(record: &Record, name: &str, first: usize) -> (f64, f64) {
    let times = record.column("time_s");
    record.column(name).into_iter().zip(times).skip(first).fold(
        (0.0, f64::NEG_INFINITY),
        |best, (value, time)| {
            if value > best.1 { (time, value) } else { best }
        },
    )
}

fn largest(results: &mut Results, record: &Record, first: usize, name: &str, unit: &str) {
    let (time, value) = column_max(record, name, first);
    results.insert(
        name,
        Quantity::new(value, unit).with_note(&format!("largest of the run, at {time:.4} s")),
    );
}
