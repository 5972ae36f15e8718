//! Named results of a run.

use glam::DVec3;

use super::record::Record;
use super::shared::{DRAG_MOMENTUM_BOX, FORCE_IMBALANCE, TIME};
use super::{
    air, bodies, canopy, contact, energy, fabric, falling, flown_ballooning, imported_wing,
    line_drag, load_test, payload_bodies, permeable, plate, residual, sail_support, supports, wing,
    wing_trim, wing_wind,
};
use crate::case::scene::{BodyKind, Scene};
use crate::frame::StructureFrame;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;
use crate::statics::Statics;

/// Why forces are not checked where a body passes through a face.
const NO_MOMENTUM_BOX: &str = "a body passes through a face, which the momentum box keeps three cells from: there is no second route";

/// All results that the scene of a simulation defines.
#[must_use]
pub fn results(simulation: &Simulation, statics: &Statics, record: &Record) -> Results {
    let frame = simulation.structure_frame();
    let structure = frame.structure.as_ref();
    of_scene(simulation.scene(), structure, record, statics)
}

/// From when to when means are taken, since release [s]; `None` of other scenes than canopies, wings, plates and bodies held in a tunnel. Of several bodies the window that begins last.
#[must_use]
pub fn averaging_window_s(scene: &Scene, record: &Record) -> Option<[f64; 2]> {
    let times = record.column(&TIME);
    let samples = canopy::averaged(scene, record)
        .or_else(|| bodies::averaged(scene, record))
        .or_else(|| wing_wind::averaged(scene, record))
        .or_else(|| plate::averaged(scene, record))?;
    Some([
        *times.get(samples.start)?,
        *times.get(samples.end.checked_sub(1)?)?,
    ])
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
                canopy::results(&mut results, record, (scene, canopy, air));
            } else {
                fabric::in_wind(&mut results, record, scene);
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
        (None, Some(air)) => air::results(&mut results, record, (scene, air)),
        (None, None) => {}
    }
    permeable::results(&mut results, record, scene);
    if scene.descent.is_some() {
        falling::results(&mut results, record, scene);
        payload_bodies::results(&mut results, record, scene);
    }
    line_drag::results(&mut results, record, scene);
    contact::results(&mut results, record);
    energy::results(&mut results, record, scene);
    residual::results(&mut results, record, scene);
    supports::results(&mut results, record, scene);
    if let (Some(_), Some(air)) = (&scene.body, &scene.air) {
        bodies::body_results(&mut results, record, scene, air);
    }
    if scene.passes_through_a_face() {
        for read_out in [&FORCE_IMBALANCE, &DRAG_MOMENTUM_BOX] {
            if results.get(&read_out.name).is_some() {
                results.insert(read_out, Quantity::missing(NO_MOMENTUM_BOX));
            }
        }
    }
    results
}
