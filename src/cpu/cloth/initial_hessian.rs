//! Block-Jacobi initial Hessian: the 3×3 diagonal blocks of a positive semidefinite projection of the Hessian.
//!
//! Springs and cables contribute k nnᵀ + max(0, k (1 − L/l)) (I − nnᵀ); triangles the tangent law through their edges
//! plus the positive part of the geometric stiffness.

use glam::{DMat3, DVec3};

use crate::cloth::elements::EDGES;
use crate::cloth::{Bending, CableSegment, Structure};

/// Stiffness below which a node counts as held by nothing [N/m].
pub const FREE_NODE_STIFFNESS: f64 = 1e-9;

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

/// Adds the elastic blocks [N/m] to `blocks`, `[node_count]`.
pub fn add_elastic_blocks(structure: &Structure, positions: &[DVec3], blocks: &mut [DMat3]) {
    if let Some(laws) = structure.laws() {
        for triangle in &structure.triangles {
            let membrane = laws.of(triangle);
            let edges = triangle.edge_vectors(positions);
            let strain = triangle.strain(&edges);
            let response = membrane.respond(&strain);
            let tangent = membrane.tangent(&strain, &response);
            let b = &triangle.strain_from_squares;
            let area = triangle.rest_area_m2;
            let mut squares = [[0.0; 3]; 3];
            for i in 0..3 {
                for j in 0..3 {
                    let mut sum = 0.0;
                    for k in 0..3 {
                        for l in 0..3 {
                            sum += b[k][i] * tangent[k][l] * b[l][j];
                        }
                    }
                    squares[i][j] = area * sum;
                }
            }
            let t = response.tension;
            let q: [f64; 3] =
                std::array::from_fn(|i| area * (b[0][i] * t[0] + b[1][i] * t[1] + b[2][i] * t[2]));
            for corner in 0..3 {
                let mut block = DMat3::ZERO;
                let mut geometric = 0.0;
                for (i, ei) in EDGES.into_iter().enumerate() {
                    let Some(sign_i) = incidence(ei, corner) else {
                        continue;
                    };
                    geometric += 2.0 * q[i];
                    for (j, ej) in EDGES.into_iter().enumerate() {
                        if let Some(sign_j) = incidence(ej, corner) {
                            block +=
                                outer(edges[i], edges[j]) * (4.0 * squares[i][j] * sign_i * sign_j);
                        }
                    }
                }
                block += DMat3::from_diagonal(DVec3::splat(geometric.max(0.0)));
                blocks[triangle.nodes[corner] as usize] += block;
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

/// +1 where the edge ends at the corner, −1 where it starts there.
fn incidence(edge: [usize; 2], corner: usize) -> Option<f64> {
    if edge[1] == corner {
        Some(1.0)
    } else if edge[0] == corner {
        Some(-1.0)
    } else {
        None
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
