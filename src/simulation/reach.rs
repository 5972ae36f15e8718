//! Where the structure is expected to stay: the momentum box is laid around it.

use glam::DVec3;

use crate::case::scene::{BodyKind, RigidBody};
use crate::cpu::cloth::Cloth;

/// Margin of the momentum box around the fabric's reach, in nominal diameters (or sizes).
const LATERAL_REACH: f64 = 0.7;

/// Reach of the momentum box from the held edge of a plate, in its lengths.
const PLATE_REACH: f64 = 1.15;

/// Least margin of the momentum box around rigid bodies [cells]: the kernel reaches two.
const BODY_MARGIN_CELLS: f64 = 4.0;

/// Instants at which the way of a rigid body is looked at.
const LOOKS: u32 = 200;

/// Corners of the box that a rigid body stays in on its way, with a margin [m].
pub(super) fn body_reach(body: &RigidBody, end_s: f64, cell_m: f64) -> (DVec3, DVec3) {
    let (low, high) = body.surface.bounds_m();
    let margin = (0.5 * (high - low).max_element()).max(BODY_MARGIN_CELLS * cell_m);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for time_s in body.motion.looks_s(end_s, LOOKS) {
        let placement = body.motion.at(time_s);
        for &point in &body.surface.positions_m {
            let place = placement.position_m(point);
            (low, high) = (low.min(place), high.max(place));
        }
    }
    (low - margin, high + margin)
}

/// Corners of the box that the structure is expected to stay in [m].
pub(super) fn reach(kind: Option<&BodyKind>, cloth: &Cloth) -> (DVec3, DVec3) {
    let positions = &cloth.positions_m;
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    match kind {
        Some(BodyKind::Canopy(canopy)) => {
            let diameter = canopy.nominal_diameter_m;
            let confluence = canopy.confluence_m(positions);
            let skirt = positions[..canopy.canopy_node_count]
                .iter()
                .map(|p| p.x)
                .fold(f64::INFINITY, f64::min);
            let lateral = DVec3::new(0.0, LATERAL_REACH * diameter, LATERAL_REACH * diameter);
            let line = skirt - confluence.x;
            (
                confluence - lateral + DVec3::X * (0.3 * line),
                confluence + lateral + DVec3::X * (1.1 * line + 0.65 * diameter),
            )
        }
        Some(BodyKind::Plate(plate)) => {
            // All that it can sweep, but for what lies far upstream.
            let held = positions.iter().zip(&cloth.structure.held);
            let held = held.filter(|(_, held)| **held).map(|(place, _)| *place);
            let length = plate.size_m[0];
            let (low, high) = held
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                    (low.min(p), high.max(p))
                });
            (
                low - DVec3::new(0.5, PLATE_REACH, PLATE_REACH) * length,
                high + DVec3::splat(PLATE_REACH * length),
            )
        }
        Some(BodyKind::Wing(_)) => {
            // The lines below do not feel the air.
            let fabric = cloth.structure.triangles.iter().flat_map(|t| t.nodes);
            let (low, high) = fabric
                .map(|node| positions[node as usize])
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                    (low.min(p), high.max(p))
                });
            let margin = DVec3::splat(0.5 * (high.x - low.x));
            (low - margin, high + margin)
        }
        _ => {
            let margin = DVec3::splat(0.5 * (high - low).max_element());
            (low - margin, high + margin)
        }
    }
}
