//! Parachute canopies: flat patterns of gores, their folding, and the complete rigged canopy.

pub mod folding;
pub mod gores;
pub mod shape;

use glam::DVec3;

use crate::cloth::{Guide, Structure, Triangle};
use crate::fabric::Fabric;
use crate::frame::CableKind;
use crate::lines::Cable;
use gores::FlatCircular;

/// A rigged canopy: fabric, belts, suspension lines, confluence.
///
/// The wind blows along +x: the confluence is upstream, the apex downstream. Triangle normals point out of the canopy.
#[derive(Debug, Clone)]
pub struct Rigging {
    /// The flat pattern.
    pub pattern: FlatCircular,
    /// Fabric.
    pub fabric: Fabric,
    /// Belt along every seam, if any.
    pub belts: Option<Cable>,
    /// Suspension lines, one per seam.
    pub lines: Cable,
    /// Length of a suspension line [m].
    pub line_length_m: f64,
    /// What its unstretched length is beyond that [m].
    pub line_slack_m: f64,
    /// Where all lines meet, held fixed [m].
    pub confluence_m: DVec3,
    /// Projected diameter of the folded canopy over its nominal diameter.
    pub folded_diameter_ratio: f64,
    /// Lateral stiffness of a guide at the apex, if any [N/m].
    pub apex_guide_n_m: Option<f64>,
}

/// Builds the canopy as an exactly isometric pleated cone with its lines straight; `None` if the folding asked for does
/// not exist.
#[must_use]
pub fn build(rigging: &Rigging) -> Option<Structure> {
    let pattern = &rigging.pattern;
    let mesh = gores::mesh(pattern);
    let folded = folding::pleated_cone(pattern, &mesh, rigging.folded_diameter_ratio)?;
    let attached = folded[mesh.seams[0][pattern.rings] as usize];
    let reach = rigging.line_length_m.powi(2) - attached.y.powi(2) - attached.z.powi(2);
    if reach <= 0.0 {
        return None;
    }
    let shift = rigging.confluence_m + DVec3::X * (reach.sqrt() - attached.x);
    let mut structure = Structure {
        positions_m: folded.iter().map(|p| *p + shift).collect(),
        membrane: Some(rigging.fabric.membrane()),
        yield_stress_pa: rigging.fabric.yield_stress_pa,
        thickness_m: rigging.fabric.thickness_m,
        ..Structure::default()
    };
    structure.positions_m.push(rigging.confluence_m);
    let node_count = structure.node_count();
    let confluence = (node_count - 1) as u32;
    structure.masses_kg = vec![0.0; node_count];
    structure.held = vec![false; node_count];
    structure.held[confluence as usize] = true;
    for (nodes, warp) in mesh.triangles.iter().zip(&mesh.warps) {
        let rest = nodes.map(|n| mesh.flat_positions_m[n as usize]);
        let triangle = Triangle::laid_out(*nodes, rest, *warp, rigging.fabric.initial_strain)?;
        for node in nodes {
            structure.masses_kg[*node as usize] +=
                rigging.fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
        }
        structure.triangles.push(triangle);
    }
    for seam in &mesh.seams {
        if let Some(belt) = &rigging.belts {
            let rest: Vec<f64> = seam
                .windows(2)
                .map(|pair| {
                    mesh.flat_positions_m[pair[0] as usize]
                        .distance(mesh.flat_positions_m[pair[1] as usize])
                })
                .collect();
            structure.add_cable(seam, &rest, belt, CableKind::Belt);
        }
        let skirt = seam[pattern.rings];
        structure.add_cable(
            &[skirt, confluence],
            &[rigging.line_length_m + rigging.line_slack_m],
            &rigging.lines,
            CableKind::SuspensionLine,
        );
    }
    if let Some(stiffness) = rigging.apex_guide_n_m {
        structure.guides.push(Guide {
            node: 0,
            anchor_m: rigging.confluence_m,
            stiffness_n_m: DVec3::new(0.0, stiffness, stiffness),
        });
    }
    Some(structure)
}
