//! Contact of fabric with itself, as geometry: distances, barriers, pairs. [`crate::cpu::cloth`] makes forces of it.
//!
//! Incremental potential contact (Li et al. 2020; of shells: Li, Kaufman & Jiang 2021): fabric that comes closer than a thickness has an
//! energy that grows without bounds as the distance goes to zero, so it takes part in the minimisation of the implicit step, its forces
//! are equal and opposite, and fabric that has not crossed itself never does. Between trials of the line search no pair may go farther
//! than it safely can ([`advance`]).
//!
//! * [`distance`]: nearest points of a node and a triangle, and of two edges;
//! * [`barrier`]: energy, gradient and curvature of a pair;
//! * [`advance`]: how far a pair may go;
//! * [`grid`], [`pairs`]: which pairs are near;
//! * [`crossing`]: whether fabric has passed through itself.
//!
//! *Departures from the cited form*: the barrier is of the distance, not of its square, and has no offset: two fabrics begin to push at
//! the thickness and may come closer under load. Its stiffness follows from what holds the nodes (`cpu/cloth/contact.rs`), not from
//! a rule that adapts it within a step. The projected Hessian keeps the curvature along the normal only, which is positive; what
//! is left out (the turning of the normal) is negative for most pairs. Pairs that start closer than the thickness keep
//! their own. There is no friction. `docs/contact.md` says what it costs.

pub mod advance;
pub mod barrier;
pub mod crossing;
pub mod distance;
pub mod grid;
pub mod pairs;

use super::Structure;
use pairs::{Kind, Surface};

/// That a structure's fabric meets itself, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Distance of the middle surfaces below which fabric pushes fabric [m].
    pub thickness_m: f64,
}

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

fn sides(kind: Kind, [a, b, c, d]: &[u32; 4]) -> String {
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
