//! Part of stage `solve_cloth` where air passes the fabric: the reaction of the air at permeable markers ([`crate::immersed::permeable`]).
//!
//! In place of ½ dt K |V − u*|² a marker has dt K (½ |V + v n − u*|² + (α/2) v² + (β/3) |v|³), v being what passes at that V: a convex function
//! of V with gradient K (V + v n − u*), the opposite of what the air gets, and Hessian K (I − v' n nᵀ). Normals are those of the start of the
//! step.

use glam::{DMat3, DVec3};

use super::initial_hessian::outer;
use super::loads::{MarkerReaction, StepInput};
use crate::cloth::Structure;
use crate::immersed::permeable::Permeable;

/// What a marker does at a point of the search.
struct Reaction {
    nodes: [usize; 3],
    normal: DVec3,
    /// V + v n − u* [m/s].
    slip: DVec3,
    /// v [m/s].
    through: f64,
}

impl Reaction {
    fn at(
        structure: &Structure,
        (marker, permeable): (&MarkerReaction, &Permeable),
        start: &[DVec3],
        point: &[DVec3],
        dt: f64,
    ) -> Self {
        let nodes = structure.triangles[marker.triangle as usize]
            .nodes
            .map(|n| n as usize);
        let mut displacement = DVec3::ZERO;
        for (&node, weight) in nodes.iter().zip(marker.weights) {
            displacement += (point[node] - start[node]) * weight;
        }
        let normal = DVec3::from_array(permeable.normal);
        let slip = displacement / dt - marker.air_velocity_m_s;
        let through = permeable.resistance.through_velocity(-slip.dot(normal));
        Self {
            nodes,
            normal,
            slip: slip + normal * through,
            through,
        }
    }
}

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
    for pair in input.permeable_markers() {
        let (marker, permeable) = pair;
        let reaction = Reaction::at(structure, pair, start, point, dt);
        let potential = permeable.resistance.potential(reaction.through);
        value += dt * marker.stiffness_kg_s * (0.5 * reaction.slip.length_squared() + potential);
        let force = reaction.slip * marker.stiffness_kg_s;
        for (node, weight) in reaction.nodes.into_iter().zip(marker.weights) {
            gradient[node] += force * weight;
        }
    }
    value
}

/// Adds their blocks [N/m] at `point` to block-Jacobi's.
pub(super) fn add_blocks(
    structure: &Structure,
    start: &[DVec3],
    point: &[DVec3],
    dt: f64,
    input: &StepInput,
    blocks: &mut [DMat3],
) {
    for pair in input.permeable_markers() {
        let (marker, permeable) = pair;
        let reaction = Reaction::at(structure, pair, start, point, dt);
        let slope = permeable.resistance.slope(reaction.through);
        let block = DMat3::IDENTITY - outer(reaction.normal, reaction.normal) * slope;
        for (node, weight) in reaction.nodes.into_iter().zip(marker.weights) {
            blocks[node] += block * (marker.stiffness_kg_s / dt * weight * weight);
        }
    }
}

/// What the passing air takes off the stiffness of every triangle: Σ (K v'/dt) w wᵀ [N/m], and n nᵀ; empty where no air passes. The markers
/// of a triangle share its normal.
pub(super) fn through_matrices(
    structure: &Structure,
    start: &[DVec3],
    point: &[DVec3],
    dt: f64,
    input: &StepInput,
) -> Vec<(DMat3, DMat3)> {
    if input.permeable.is_empty() {
        return Vec::new();
    }
    let mut matrices = vec![(DMat3::ZERO, DMat3::ZERO); structure.triangles.len()];
    for pair in input.permeable_markers() {
        let (marker, permeable) = pair;
        let reaction = Reaction::at(structure, pair, start, point, dt);
        let slope = permeable.resistance.slope(reaction.through);
        let w = DVec3::from_array(marker.weights);
        let (weights, normals) = &mut matrices[marker.triangle as usize];
        *weights += outer(w, w) * (marker.stiffness_kg_s / dt * slope);
        *normals = outer(reaction.normal, reaction.normal);
    }
    matrices
}
