//! What a run needs on the disk, estimated before it begins.

use std::fmt::Write;

use super::{Plan, Sizes};
use crate::case::Scene;
use crate::lattice::DIRECTION_COUNT;
use crate::lattice::nest::Level;

/// Checkpoints on the disk at once: the last two, and the one that is being written.
const CHECKPOINTS_AT_ONCE: u64 = 3;

/// Bytes of a checkpoint for each node: its position and velocity.
const NODE_BYTES: u64 = 48;

/// Bytes of a checkpoint for each marker: places, velocities, forces, and the touched cells around it.
const MARKER_BYTES: u64 = 300;

/// Bytes of a file of the structure for each node and each triangle or cable segment.
const FRAME_NODE_BYTES: u64 = 72;
const FRAME_ELEMENT_BYTES: u64 = 136;

/// Bytes of a flow file for each cell: velocity and pressure in single precision.
const FLOW_CELL_BYTES: u64 = 16;

/// Bytes of a picture, and of a frame of the animation, as shipped cases have them.
const PICTURE_BYTES: u64 = 250_000;
const ANIMATION_FRAME_BYTES: u64 = 150_000;

/// Bytes of a row of the history, as a canopy has them.
const ROW_BYTES: u64 = 1_500;

/// What a run needs on the disk [bytes].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Disk {
    /// One checkpoint.
    pub checkpoint: u64,
    /// All that stays but checkpoints.
    pub results: u64,
    /// Everything, while the last checkpoint is written.
    pub most: u64,
}

impl Disk {
    /// Estimates it.
    #[must_use]
    pub fn new(scene: &Scene, sizes: &Sizes) -> Self {
        let air = scene.air.as_ref().map_or(0, |air| {
            let ghosts = |level: Level| {
                let counts = level.cells.into_iter().map(|n| n as u64 + 2);
                counts.fold(1, u64::saturating_mul)
            };
            let cells = (air.levels().into_iter().map(ghosts)).fold(0, u64::saturating_add);
            let held = (air.eddy_viscosity).and_then(|model| model.gradient_model());
            let eddy = u64::from(held.is_some());
            let bytes = sizes.population_bytes / sizes.padded_cells.max(1);
            cells.saturating_mul((DIRECTION_COUNT as u64 + eddy) * bytes)
        });
        let end_s = scene.time.map_or(0.0, |time| time.end_s);
        let count = |interval_s: Option<f64>| {
            (interval_s.map_or(0, |i| (end_s / i) as u64)).saturating_add(1)
        };
        let output = &scene.output;
        let rows = count(Some(output.sample_interval_s)).saturating_mul(ROW_BYTES);
        let checkpoint = air
            .saturating_add(sizes.markers.saturating_mul(MARKER_BYTES))
            .saturating_add(sizes.nodes.saturating_mul(NODE_BYTES))
            .saturating_add(rows / 2);
        let elements = sizes.triangles + sizes.cables;
        let structure = count(output.canopy_interval_s)
            .saturating_mul(sizes.nodes * FRAME_NODE_BYTES + elements * FRAME_ELEMENT_BYTES);
        let surfaces = scene.rigid_bodies.iter().map(|body| {
            (body.surface.positions_m.len() as u64) * FRAME_NODE_BYTES
                + (body.surface.triangles.len() as u64) * FRAME_NODE_BYTES
        });
        let bodies = count(output.bodies_interval_s).saturating_mul(surfaces.sum());
        let flow = count(output.flow_interval_s)
            .saturating_mul(sizes.cells.saturating_mul(FLOW_CELL_BYTES));
        let each = (output.picture_fabric.len() + output.picture_flow.len() - 1) as u64;
        let drawn = output
            .picture_times_s
            .iter()
            .filter(|t| **t <= end_s)
            .count() as u64
            + 1;
        let pictures = drawn.saturating_mul(each * PICTURE_BYTES);
        // Frames and the file that they become, side by side.
        let animation = output.animation_interval_s.map_or(0, |interval_s| {
            count(Some(interval_s)).saturating_mul(2 * ANIMATION_FRAME_BYTES)
        });
        let results = [structure, bodies, flow, pictures, animation, rows]
            .into_iter()
            .fold(0, u64::saturating_add);
        let most = results.saturating_add(checkpoint.saturating_mul(CHECKPOINTS_AT_ONCE));
        Self {
            checkpoint,
            results,
            most,
        }
    }
}

/// So many bytes, in words.
pub(super) fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

/// Writes it for `ripstop check`.
pub(super) fn write(out: &mut impl Write, plan: &Plan, scene: &Scene) -> std::fmt::Result {
    let disk = Disk::new(scene, &plan.sizes);
    let stays = if scene.time.is_some() && scene.equilibrium.is_none() {
        "one stays as final.checkpoint"
    } else {
        "none stays at the end"
    };
    writeln!(
        out,
        "  disk                about {}: results {}, checkpoints {} each, {CHECKPOINTS_AT_ONCE} at once while one is written; {stays}",
        megabytes(disk.most),
        megabytes(disk.results),
        megabytes(disk.checkpoint)
    )
}
