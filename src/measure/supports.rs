//! Supports that are moved: columns of the history, and results.

use glam::DVec3;

use super::read_out::Reduction::Last;
use super::read_out::{ReadOut, columns};
use super::record::Record;
use crate::case::Scene;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// How far the middle of a support is displaced [m], and the force with which it holds the structure [N].
type Moment = (DVec3, DVec3);

columns! {
    /// Of every support.
    COLUMNS of Moment, in Scene: "Moved supports";
    DISPLACEMENT_X: "{support}_displacement_x_m", "m", "displacement of the support's middle along x" => |now| now.0.x, reduced Last;
    DISPLACEMENT_Y: "{support}_displacement_y_m", "m", "displacement of the support's middle along y" => |now| now.0.y, reduced Last;
    DISPLACEMENT_Z: "{support}_displacement_z_m", "m", "displacement of the support's middle along z" => |now| now.0.z, reduced Last;
    FORCE_X: "{support}_force_x_n", "N", "force of the support on the structure along x" => |now| now.1.x, reduced Last;
    FORCE_Y: "{support}_force_y_n", "N", "force of the support on the structure along y" => |now| now.1.y, reduced Last;
    FORCE_Z: "{support}_force_z_n", "N", "force of the support on the structure along z" => |now| now.1.z, reduced Last;
}

/// The columns of a scene.
pub(super) fn columns(scene: &Scene) -> impl Iterator<Item = ReadOut> {
    let supports = scene.supports.iter();
    supports.flat_map(|support| COLUMNS.read_outs_of(scene, &support.name))
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation) -> Vec<f64> {
    let scene = simulation.scene();
    if scene.supports.is_empty() {
        return Vec::new();
    }
    let frame = simulation.structure_frame();
    let reactions_n = frame.structure.map_or(Vec::new(), |s| s.reactions_n);
    simulation
        .support_loads(&reactions_n)
        .flat_map(|load| COLUMNS.values(scene, Some(&load)))
        .collect()
}

/// Where supports are at the end, and how they pull.
pub(super) fn results(results: &mut Results, record: &Record, scene: &Scene) {
    for column in columns(scene) {
        let value = record.latest(&column).unwrap_or(f64::NAN);
        results.insert(&column, Quantity::new(value).with_note("at the end"));
    }
}
