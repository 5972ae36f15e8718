//! What keeps a structure's fabric from meeting itself.

use super::Contact;
use super::crossing;
use super::pairs::{Kind, Surface};
use crate::cloth::Structure;

/// Largest thickness, as a share of the smallest altitude of a triangle at rest: what shares no node is farther apart then.
pub const LARGEST_THICKNESS: f64 = 0.5;

/// Smallest distance at the start, as a share of the thickness: closer ones cannot be told from what has crossed.
pub const CLOSEST_START: f64 = 1e-4;

/// Why fabric cannot meet itself; nodes and triangles count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ContactFault {
    /// The thickness does not fit the mesh.
    #[error(
        "triangle {triangle} has an altitude of {altitude_m:.3e} m at rest, of which the thickness may be at most a half"
    )]
    TooThick {
        /// Triangle with the smallest altitude.
        triangle: usize,
        /// That altitude [m].
        altitude_m: f64,
    },
    /// The start passes through itself.
    #[error("the edge between nodes {} and {} passes through the triangle of nodes {}, {} and {}", .edge[0], .edge[1], .triangle[0], .triangle[1], .triangle[2])]
    Crossing {
        /// Nodes of the edge.
        edge: [u32; 2],
        /// Nodes of the triangle.
        triangle: [u32; 3],
    },
    /// The start touches itself.
    #[error("{} are {gap_m:.1e} m apart", sides(*.kind, .nodes))]
    Touching {
        /// What touches.
        kind: Kind,
        /// Nodes of both sides.
        nodes: [u32; 4],
        /// Distance [m].
        gap_m: f64,
    },
}

pub(super) fn sides(kind: Kind, [a, b, c, d]: &[u32; 4]) -> String {
    match kind {
        Kind::NodeTriangle => format!("node {a} and the triangle of nodes {b}, {c} and {d}"),
        Kind::EdgeEdge => format!("the edges between nodes {a} and {b} and between {c} and {d}"),
    }
}

/// Looks for what keeps a structure's fabric from meeting itself with this thickness.
pub fn check(structure: &Structure, contact: Contact) -> Result<(), ContactFault> {
    let thickness_m = contact.thickness_m;
    let altitudes = structure.triangles.iter().map(|t| {
        let longest = t.rest_squares_m2.iter().copied().fold(0.0, f64::max);
        2.0 * t.rest_area_m2 / longest.sqrt()
    });
    if let Some((triangle, altitude_m)) = altitudes
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, altitude)| thickness_m > LARGEST_THICKNESS * altitude)
    {
        return Err(ContactFault::TooThick {
            triangle,
            altitude_m,
        });
    }
    let surface = Surface::new(structure, thickness_m);
    let positions = &structure.positions_m;
    if let Some(&(edge, triangle)) = crossing::crossings(&surface, positions).first() {
        return Err(ContactFault::Crossing { edge, triangle });
    }
    match surface.nearest(positions, CLOSEST_START * thickness_m) {
        Some((pair, gap_m)) => Err(ContactFault::Touching {
            kind: pair.kind,
            nodes: pair.nodes,
            gap_m,
        }),
        None => Ok(()),
    }
}
