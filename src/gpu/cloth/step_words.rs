//! What a step sends of elements, word by word as `shaders/elements.wgsl` reads it.

use glam::DVec3;

use crate::cloth::Structure;
use crate::cpu::cloth::StepInput;
use crate::cpu::cloth::dashpots::dashpots;
use crate::immersed::permeable::Permeable;

use super::elements::{CUT_WORDS, damped_cables, narrow};

/// What the air does to triangles that cut its lattice, as `shaders/elements.wgsl` reads it, and its part of the objective that stays constant [J]; `velocity` is that of the prediction.
pub(super) fn cut_reactions(
    structure: &Structure,
    velocity: &dyn Fn(usize) -> DVec3,
    input: &StepInput,
) -> (Vec<f32>, f64) {
    let count = structure.triangles.len();
    let mut words = vec![0.0; CUT_WORDS * count];
    let Some(dt) = input.time_step_s else {
        return (words, 0.0);
    };
    let mut constant_j = 0.0;
    for reaction in input.cut_triangles {
        let triangle = reaction.triangle as usize;
        let nodes = structure.triangles[triangle].nodes;
        let (power_w, forces_n) = reaction.at(nodes.map(|node| velocity(node as usize)));
        constant_j += dt * power_w;
        let blocks = reaction.stiffness_kg_s.iter().flat_map(|block| {
            let [x, y, z] = [block.x_axis, block.y_axis, block.z_axis];
            [x.x, y.y, z.z, x.y, x.z, y.z]
        });
        let forces = forces_n.iter().flat_map(|force| force.to_array());
        for (word, value) in blocks.chain(forces).enumerate() {
            words[word * count + triangle] = value as f32;
        }
    }
    (words, constant_j)
}

/// What damping needs of a step that starts at `start`, as `shaders/elements.wgsl` reads it; `velocity` is that of the prediction.
pub(super) fn dashpot_states(
    structure: &Structure,
    start: &[DVec3],
    velocity: &dyn Fn(usize) -> DVec3,
    time_step_s: Option<f64>,
) -> Vec<f32> {
    let count = damped_cables(structure).count();
    let mut words = vec![0.0; 5 * count];
    let Some(dt) = time_step_s else {
        return words;
    };
    let dashpots = dashpots(structure, start, time_step_s);
    let mut taut = dashpots.iter().peekable();
    for (k, cable) in damped_cables(structure).enumerate() {
        // Slack segments have none; the others come in the order of the segments.
        let Some(dashpot) = taut.next_if(|dashpot| dashpot.nodes == cable.nodes) else {
            continue;
        };
        let [a, b] = dashpot.nodes.map(|n| n as usize);
        let stretch_m = (velocity(b) - velocity(a)).dot(dashpot.direction) * dt;
        let [x, y, z] = narrow(&dashpot.direction);
        let state = [x, y, z, dashpot.stiffness_n_m as f32, stretch_m as f32];
        for (word, value) in state.into_iter().enumerate() {
            words[word * count + k] = value;
        }
    }
    words
}

/// What markers let pass, as `shaders/elements.wgsl` reads it; nothing resists where `permeable` says nothing, since no marker acts then.
pub(super) fn permeability_words(permeable: &[Permeable], count: usize) -> Vec<f32> {
    let mut words = vec![0.0; 5 * count];
    for (k, marker) in permeable.iter().enumerate() {
        let [x, y, z] = marker.normal;
        let values = [
            x,
            y,
            z,
            marker.resistance.viscous,
            marker.resistance.inertial,
        ];
        for (word, value) in values.into_iter().enumerate() {
            words[word * count + k] = value as f32;
        }
    }
    words
}
