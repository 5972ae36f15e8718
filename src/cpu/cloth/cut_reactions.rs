//! Part of stage `solve_cloth` where the fabric cuts the lattice: the reactions of the air on its triangles ([`super::triangle_reaction`]).

use glam::{DMat3, DVec3};

use super::loads::StepInput;
use super::triangle_reaction::TriangleReaction;
use crate::cloth::Structure;

/// Adds the reactions at `point` to the gradient [N]; returns their part of the objective [J].
pub(super) fn add_reactions(
    structure: &Structure,
    start: &[DVec3],
    dt: f64,
    input: &StepInput,
    point: &[DVec3],
    gradient: &mut [DVec3],
) -> f64 {
    let mut value = 0.0;
    for reaction in input.cut_triangles {
        let nodes = nodes_of(structure, reaction);
        let velocities = nodes.map(|node| (point[node] - start[node]) / dt);
        let (power, forces) = reaction.at(velocities);
        value += dt * power;
        for (node, force) in nodes.into_iter().zip(forces) {
            gradient[node] += force;
        }
    }
    value
}

/// Adds their blocks [N/m] to block-Jacobi's.
pub(super) fn add_blocks(structure: &Structure, dt: f64, input: &StepInput, blocks: &mut [DMat3]) {
    for reaction in input.cut_triangles {
        for (corner, node) in nodes_of(structure, reaction).into_iter().enumerate() {
            blocks[node] += reaction.between(corner, corner) * (1.0 / dt);
        }
    }
}

fn nodes_of(structure: &Structure, reaction: &TriangleReaction) -> [usize; 3] {
    let nodes = structure.triangles[reaction.triangle as usize].nodes;
    nodes.map(|node| node as usize)
}

/// The reaction of every triangle by its number; empty where nothing is cut.
pub(super) fn by_triangle<'a>(
    structure: &Structure,
    input: &StepInput<'a>,
) -> Vec<Option<&'a TriangleReaction>> {
    if input.cut_triangles.is_empty() {
        return Vec::new();
    }
    let mut found = vec![None; structure.triangles.len()];
    for reaction in input.cut_triangles {
        found[reaction.triangle as usize] = Some(reaction);
    }
    found
}
