//! Fabric in the shape of a surface, free of stress (but for the fabric's initial strain) as it stands.

use glam::DVec3;

use crate::cloth::{Structure, Triangle};
use crate::fabric::Fabric;
use crate::rigid::Surface;

/// The structure, or the number of the first triangle without area. The warp lies along the projection of `warp` on each triangle.
pub fn build(surface: &Surface, warp: DVec3, fabric: &Fabric) -> Result<Structure, usize> {
    let node_count = surface.positions_m.len();
    let mut structure = Structure {
        positions_m: surface.positions_m.clone(),
        masses_kg: vec![0.0; node_count],
        held: vec![false; node_count],
        membrane: Some(fabric.membrane()),
        thickness_m: fabric.thickness_m,
        yield_stress_pa: fabric.yield_stress_pa,
        ..Structure::default()
    };
    for (index, &nodes) in surface.triangles.iter().enumerate() {
        let corners = surface.corners(nodes);
        let triangle =
            Triangle::laid_out(nodes, corners, warp, fabric.initial_strain).ok_or(index)?;
        for node in nodes {
            structure.masses_kg[node as usize] +=
                fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
        }
        structure.triangles.push(triangle);
    }
    Ok(structure)
}
