//! Block-Jacobi initial Hessian: the 3×3 diagonal blocks of a positive semidefinite projection of the Hessian.
//!
//! Springs and cables contribute k nnᵀ + max(0, k (1 − L/l)) (I − nnᵀ); triangles the tangent law through their edges
//! plus the positive part of the geometric stiffness.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::vectors::{ALONE, CHUNK};
use crate::cloth::fabrics::Laws;
use crate::cloth::{Bending, CableSegment, Structure, Triangle};

/// Stiffness below which a node counts as held by nothing [N/m].
pub const FREE_NODE_STIFFNESS: f64 = 1e-9;

/// Triangles whose blocks are kept at once.
const MANY_CHUNKS: usize = 64 * CHUNK;

pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

pub(super) fn axial_block(edge: DVec3, stiffness: f64, transverse: f64) -> DMat3 {
    let n = edge.normalize_or_zero();
    DMat3::from_diagonal(DVec3::splat(transverse)) + outer(n, n) * (stiffness - transverse)
}

/// Block of a cable segment at one of its ends.
pub(super) fn cable_block(
    structure: &Structure,
    cable: &CableSegment,
    edge: DVec3,
    length: f64,
) -> DMat3 {
    if length > cable.rest_length_m {
        let state = structure.cable_state(cable, length);
        axial_block(
            edge,
            state.tangent_n / cable.rest_length_m,
            state.tension_n / length,
        )
    } else {
        // A slack cable has no stiffness; a thousandth keeps steps that would tighten it within bounds.
        let stiffness =
            structure.cable_laws[cable.law as usize].initial_stiffness_n() / cable.rest_length_m;
        DMat3::from_diagonal(DVec3::splat(1e-3 * stiffness))
    }
}

fn add_bending<const N: usize>(bendings: &[Bending<N>], blocks: &mut [DMat3]) {
    for bending in bendings {
        for (&node, coefficient) in bending.nodes.iter().zip(bending.coefficients) {
            let k = bending.stiffness_n_m * coefficient * coefficient;
            blocks[node as usize] += DMat3::from_diagonal(DVec3::splat(k));
        }
    }
}

/// What a triangle adds at its corners.
fn corner_blocks(triangle: &Triangle, laws: &Laws<'_>, positions: &[DVec3]) -> [DMat3; 3] {
    let membrane = laws.of(triangle);
    let edges = triangle.edge_vectors(positions);
    let strain = triangle.strain(&edges);
    let response = membrane.respond(&strain);
    let tangent = membrane.tangent(&strain, &response);
    let b = &triangle.strain_from_squares;
    let area = triangle.rest_area_m2;
    // By the squares of edges: area Bᵀ T B.
    let squares: [[f64; 3]; 3] = {
        let of_columns: [[f64; 3]; 3] = std::array::from_fn(|k| {
            std::array::from_fn(|j| (0..3).map(|l| tangent[k][l] * b[l][j]).sum::<f64>())
        });
        std::array::from_fn(|i| {
            std::array::from_fn(|j| area * (0..3).map(|k| b[k][i] * of_columns[k][j]).sum::<f64>())
        })
    };
    let t = response.tension;
    let q: [f64; 3] =
        std::array::from_fn(|i| area * (b[0][i] * t[0] + b[1][i] * t[1] + b[2][i] * t[2]));
    let of_edges = edges.map(|edge| outer(edge, edge));
    std::array::from_fn(|corner| {
        // One edge ends at the corner, the other begins there.
        let (i, j) = ((corner + 1) % 3, (corner + 2) % 3);
        let both = outer(edges[i], edges[j]);
        let geometric: f64 = 2.0 * (q[i] + q[j]);
        of_edges[i] * (4.0 * squares[i][i]) + of_edges[j] * (4.0 * squares[j][j])
            - (both + both.transpose()) * (4.0 * squares[i][j])
            + DMat3::from_diagonal(DVec3::splat(geometric.max(0.0)))
    })
}

/// Adds the elastic blocks [N/m] to `blocks`, `[node_count]`.
pub fn add_elastic_blocks(structure: &Structure, positions: &[DVec3], blocks: &mut [DMat3]) {
    if let Some(laws) = structure.laws() {
        let mut add = |triangle: &Triangle, of_corners: [DMat3; 3]| {
            for (node, block) in triangle.nodes.into_iter().zip(of_corners) {
                blocks[node as usize] += block;
            }
        };
        let triangles = &structure.triangles;
        if triangles.len() <= ALONE {
            for triangle in triangles {
                add(triangle, corner_blocks(triangle, &laws, positions));
            }
        } else {
            let mut of_some: Vec<[DMat3; 3]> = Vec::new();
            for some in triangles.chunks(MANY_CHUNKS) {
                (some.par_iter())
                    .with_min_len(CHUNK)
                    .map(|triangle| corner_blocks(triangle, &laws, positions))
                    .collect_into_vec(&mut of_some);
                for (triangle, of_corners) in some.iter().zip(&of_some) {
                    add(triangle, *of_corners);
                }
            }
        }
    }
    for spring in &structure.springs {
        let [a, b] = spring.nodes.map(|n| n as usize);
        let edge = positions[b] - positions[a];
        let stretched = edge.length() > spring.rest_length_m;
        let stiffness = if stretched {
            spring.stiffness_n_m
        } else {
            spring
                .compressive_stiffness_n_m
                .max(1e-3 * spring.stiffness_n_m)
        };
        let transverse = if stretched {
            stiffness * (1.0 - spring.rest_length_m / edge.length())
        } else {
            0.0
        };
        let block = axial_block(edge, stiffness, transverse);
        blocks[a] += block;
        blocks[b] += block;
    }
    add_bending(&structure.bendings, blocks);
    add_bending(&structure.curvatures, blocks);
    for cable in &structure.cables {
        let [a, b] = cable.nodes.map(|n| n as usize);
        let edge = positions[b] - positions[a];
        let block = cable_block(structure, cable, edge, edge.length());
        blocks[a] += block;
        blocks[b] += block;
    }
    for guide in &structure.guides {
        blocks[guide.node as usize] += DMat3::from_diagonal(guide.stiffness_n_m);
    }
}

/// Inverts the blocks in place; a singular block (a node that nothing holds) falls back to the inverse of `floor` [N/m],
/// held nodes get zero.
pub fn invert(blocks: &mut [DMat3], held: &[bool], floor: f64) {
    for (block, &held) in blocks.iter_mut().zip(held) {
        if held {
            *block = DMat3::ZERO;
            continue;
        }
        let scale = block
            .x_axis
            .x
            .max(block.y_axis.y)
            .max(block.z_axis.z)
            .max(floor);
        // A millionth of the largest entry keeps the block regular where an element gives no transverse stiffness.
        *block += DMat3::from_diagonal(DVec3::splat(1e-6 * scale));
        *block = block.inverse();
        if !block.is_finite() {
            *block = DMat3::from_diagonal(DVec3::splat(1.0 / scale));
        }
    }
}
