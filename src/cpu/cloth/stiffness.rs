//! The whole positive semidefinite projection of the Hessian, block by block, for the multigrid cycle.
//!
//! Springs and cables contribute k nnᵀ + max(0, k (1 − L/l)) (I − nnᵀ); triangles the tangent law through their edges, 4 S_ij e_i e_jᵀ,
//! plus the geometric stiffness of the tensile part of their stress, 2 q_i for edge i with q = A Bᵀ T⁺. Every part is semidefinite by
//! itself, so the sum is. [`super::initial_hessian`] holds the diagonal blocks of nearly the same matrix.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::contact::Rows;
use super::dashpots::Dashpot;
use super::gather::Gather;
use super::initial_hessian::{axial_block, cable_block};
use super::loads::StepInput;
use super::{cut_reactions, permeable};
use crate::cloth::elements::EDGES;
use crate::cloth::{Bending, Structure, Triangle};
use crate::fabric::membrane::{Membrane, principal};
use crate::solve::multigrid::blocks::{Block, BlockMatrix, Entry, Pattern};
use crate::solve::multigrid::coarsening::Graph;

/// Elements that one task works on.
const ELEMENTS_AT_ONCE: usize = 512;

/// What stiffens a structure beside its elements.
#[derive(Clone, Copy)]
pub(super) struct Extra<'a> {
    pub(super) dashpots: &'a [Dashpot],
    pub(super) contact: Option<&'a Rows>,
}

/// Stiffness of a triangle against its three squared elongations.
#[derive(Debug, Clone, Copy)]
struct TriangleStiffness {
    /// 4 A Bᵀ C B.
    material: [[f64; 3]; 3],
    /// 2 q.
    geometric: [f64; 3],
}

/// Nodes that share an element.
#[must_use]
pub fn graph(structure: &Structure) -> Graph {
    let groups = structure
        .triangles
        .iter()
        .map(|t| &t.nodes[..])
        .chain(structure.springs.iter().map(|s| &s.nodes[..]))
        .chain(structure.bendings.iter().map(|b| &b.nodes[..]))
        .chain(structure.curvatures.iter().map(|b| &b.nodes[..]))
        .chain(structure.cables.iter().map(|c| &c.nodes[..]));
    let positions = &structure.positions_m;
    Graph::new(
        Pattern::from_groups(structure.node_count(), groups),
        structure.held.clone(),
        |a, b| positions[a].distance(positions[b]),
    )
}

/// Tensile part of a tension (xx, yy, xy).
fn tensile(tension: [f64; 3]) -> [f64; 3] {
    let [larger, smaller] = principal(tension[0], tension[1], tension[2]);
    if smaller >= 0.0 {
        return tension;
    }
    if larger <= 0.0 {
        return [0.0; 3];
    }
    // T = larger m⊗m + smaller n⊗n, and m⊗m + n⊗n = I.
    let share = larger / (larger - smaller);
    [
        share * (tension[0] - smaller),
        share * (tension[1] - smaller),
        share * tension[2],
    ]
}

fn triangle_stiffness(
    membrane: &Membrane,
    triangle: &Triangle,
    positions: &[DVec3],
) -> TriangleStiffness {
    let edges = triangle.edge_vectors(positions);
    let strain = triangle.strain(&edges);
    let response = membrane.respond(&strain);
    let tangent = membrane.tangent(&strain, &response);
    let b = &triangle.strain_from_squares;
    let area = triangle.rest_area_m2;
    let mut material = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                for l in 0..3 {
                    material[i][j] += 4.0 * area * b[k][i] * tangent[k][l] * b[l][j];
                }
            }
        }
    }
    let t = tensile(response.tension);
    let geometric =
        [0, 1, 2].map(|i| 2.0 * area * (b[0][i] * t[0] + b[1][i] * t[1] + b[2][i] * t[2]));
    TriangleStiffness {
        material,
        geometric,
    }
}

/// Sign of corner `c` in the vector of edge `i`: +1 where it ends, −1 where it starts, 0 elsewhere.
const fn sign(i: usize, c: usize) -> f64 {
    let [from, to] = EDGES[i];
    if c == to {
        1.0
    } else if c == from {
        -1.0
    } else {
        0.0
    }
}

/// Adds what a triangle gives for corners `a`, `b`.
fn triangle_block(stiffness: &TriangleStiffness, edges: &[DVec3; 3], a: usize, b: usize) -> DMat3 {
    let mut block = DMat3::ZERO;
    for i in 0..3 {
        let sign_a = sign(i, a);
        if sign_a == 0.0 {
            continue;
        }
        // Σ_j of S_ij, sign and edge vector j.
        let mut other = DVec3::ZERO;
        for j in 0..3 {
            other += edges[j] * (stiffness.material[i][j] * sign(j, b));
        }
        let left = edges[i] * sign_a;
        block += DMat3::from_cols(left * other.x, left * other.y, left * other.z);
        let geometric = stiffness.geometric[i] * sign_a * sign(i, b);
        block += DMat3::from_diagonal(DVec3::splat(geometric));
    }
    block
}

/// Stiffness of a bending term between one of its nodes and all [N/m].
fn bending_row<const N: usize>(
    bending: &Bending<N>,
    corner: usize,
) -> impl Iterator<Item = (u32, f64)> + '_ {
    let own = bending.stiffness_n_m * bending.coefficients[corner];
    let nodes = bending.nodes.iter().zip(bending.coefficients);
    nodes.map(move |(&node, coefficient)| (node, own * coefficient))
}

fn add<T: Entry>(blocks: &mut [Block<T>], place: Option<usize>, value: DMat3) {
    let Some(place) = place else {
        return;
    };
    let block = &mut blocks[place];
    for row in 0..3 {
        for column in 0..3 {
            block[3 * row + column] += T::of(value.col(column)[row]);
        }
    }
}

/// Fills `matrix`, whose pattern is that of [`graph`], with the stiffness at `positions` [N/m] in a step from `start`; held nodes have no
/// entries.
pub(super) fn assemble<T: Entry>(
    structure: &Structure,
    gather: &Gather,
    (input, extra): (&StepInput, Extra),
    [start, positions]: [&[DVec3]; 2],
    matrix: &mut BlockMatrix<T>,
) {
    let triangles: Vec<TriangleStiffness> = match structure.laws() {
        Some(laws) => structure
            .triangles
            .par_iter()
            .with_min_len(ELEMENTS_AT_ONCE)
            .map(|triangle| triangle_stiffness(laws.of(triangle), triangle, positions))
            .collect(),
        None => Vec::new(),
    };
    let cables: Vec<DMat3> = structure
        .cables
        .iter()
        .map(|cable| {
            let [a, b] = cable.nodes.map(|n| n as usize);
            let edge = positions[b] - positions[a];
            let length = edge.length();
            cable_block(structure, cable, edge, length)
        })
        .collect();
    let mut markers: Vec<DMat3> = Vec::new();
    let mut through = Vec::new();
    if let (Some(dt), false) = (input.time_step_s, input.markers.is_empty()) {
        // Per triangle: Σ K/dt w_a w_b, the same along all axes; too stiff along triangles that feel the air across themselves alone, which a
        // preconditioner may be (what takes the matrix at its word has no such markers).
        markers.resize(structure.triangles.len(), DMat3::ZERO);
        for marker in input.markers {
            let w = DVec3::from_array(marker.weights);
            let k = marker.stiffness_kg_s / dt;
            markers[marker.triangle as usize] += DMat3::from_cols(w * w.x, w * w.y, w * w.z) * k;
        }
        through = permeable::through_matrices(structure, start, positions, dt, input);
    }
    let cut = cut_reactions::by_triangle(structure, input);
    let per_dt = input.time_step_s.map_or(0.0, f64::recip);
    let mut drags_kg_s = vec![0.0; structure.node_count()];
    for drag in input.drags {
        drags_kg_s[drag.node as usize] += drag.coefficient_kg_s;
    }
    // (node, dashpot, which of its ends), ascending.
    let mut dashpots: Vec<(usize, usize, usize)> = Vec::new();
    for (number, dashpot) in extra.dashpots.iter().enumerate() {
        for (corner, node) in dashpot.nodes.into_iter().enumerate() {
            dashpots.push((node as usize, number, corner));
        }
    }
    dashpots.sort_unstable();
    matrix.fill_rows(
        || (),
        |(), row, columns, blocks| {
            if structure.held[row] {
                return;
            }
            let place = |node: u32| {
                if structure.held[node as usize] {
                    None
                } else {
                    columns.binary_search(&node).ok()
                }
            };
            if !triangles.is_empty() || !markers.is_empty() || !cut.is_empty() {
                for (t, corner) in gather.triangles.at(row) {
                    let triangle = &structure.triangles[t];
                    let edges = triangle.edge_vectors(positions);
                    for (other, &node) in triangle.nodes.iter().enumerate() {
                        let mut block = DMat3::ZERO;
                        if let Some(stiffness) = triangles.get(t) {
                            block += triangle_block(stiffness, &edges, corner, other);
                        }
                        if let Some(weights) = markers.get(t) {
                            let k = weights.col(other)[corner];
                            block += DMat3::from_diagonal(DVec3::splat(k));
                        }
                        if let Some(Some(reaction)) = cut.get(t) {
                            block += reaction.between(corner, other) * per_dt;
                        }
                        if let Some((weights, normals)) = through.get(t) {
                            block -= *normals * weights.col(other)[corner];
                        }
                        add(blocks, place(node), block);
                    }
                }
            }
            let own = place(row as u32);
            for (s, corner) in gather.springs.at(row) {
                let spring = &structure.springs[s];
                let [a, b] = spring.nodes.map(|n| n as usize);
                let edge = positions[b] - positions[a];
                let (stretched, length) = (edge.length() > spring.rest_length_m, edge.length());
                let (stiffness, transverse) = if stretched {
                    let k = spring.stiffness_n_m;
                    (k, k * (1.0 - spring.rest_length_m / length))
                } else {
                    let soft = 1e-3 * spring.stiffness_n_m;
                    (spring.compressive_stiffness_n_m.max(soft), 0.0)
                };
                let block = axial_block(edge, stiffness, transverse);
                add(blocks, own, block);
                add(blocks, place(spring.nodes[1 - corner]), -block);
            }
            for (e, corner) in gather.bendings.at(row) {
                let bending = &structure.bendings[e];
                for (node, k) in bending_row(bending, corner) {
                    add(blocks, place(node), DMat3::from_diagonal(DVec3::splat(k)));
                }
            }
            for (e, corner) in gather.curvatures.at(row) {
                let curvature = &structure.curvatures[e];
                for (node, k) in bending_row(curvature, corner) {
                    add(blocks, place(node), DMat3::from_diagonal(DVec3::splat(k)));
                }
            }
            for (c, corner) in gather.cables.at(row) {
                add(blocks, own, cables[c]);
                add(
                    blocks,
                    place(structure.cables[c].nodes[1 - corner]),
                    -cables[c],
                );
            }
            let first = dashpots.partition_point(|&(node, ..)| node < row);
            for &(_, number, corner) in dashpots[first..].iter().take_while(|(n, ..)| *n == row) {
                let dashpot = &extra.dashpots[number];
                add(blocks, own, dashpot.block());
                add(blocks, place(dashpot.nodes[1 - corner]), -dashpot.block());
            }
            if let Some(contact) = extra.contact {
                for &(column, block) in contact.row(row) {
                    add(blocks, place(column), block);
                }
            }
            for (g, _) in gather.guides.at(row) {
                let stiffness = structure.guides[g].stiffness_n_m;
                add(blocks, own, DMat3::from_diagonal(stiffness));
            }
            if let Some(dt) = input.time_step_s {
                let held_back = structure.masses_kg[row] * (1.0 / dt + input.damping_1_s);
                let k = (held_back + drags_kg_s[row]) / dt;
                add(blocks, own, DMat3::from_diagonal(DVec3::splat(k)));
            }
        },
    );
}
