//! Part of stage `solve_cloth`: elastic energy E(x) and its gradient ∇E = −f, element by element, then gathered at the nodes.
//!
//! Sums run over chunks of fixed size, so that results do not depend on the number of threads.

use glam::DVec3;
use rayon::prelude::*;

use super::gather::Gather;
use super::vectors::{ALONE, CHUNK, each};
use crate::cloth::{Bending, Structure};

/// What elements pull with, before it is gathered at the nodes.
#[derive(Debug, Clone, Default)]
pub struct Pulls {
    /// Gradient at the corners of every triangle [N], `[3 · triangle_count]`.
    triangles: Vec<DVec3>,
    /// Force over length of every spring [N/m].
    springs: Vec<f64>,
    /// The same of every cable segment [N/m].
    cables: Vec<f64>,
}

/// Writes what `of` finds for every element, and returns the sum of the energies.
fn fill<E: Sync, P: Send + Clone + Default>(
    elements: &[E],
    pulls: &mut Vec<P>,
    of: impl Fn(&E) -> (P, f64) + Sync,
) -> f64 {
    pulls.resize(elements.len(), P::default());
    let one = |(elements, pulls): (&[E], &mut [P])| {
        let mut sum = 0.0;
        for (element, pull) in elements.iter().zip(pulls) {
            let (found, energy) = of(element);
            *pull = found;
            sum += energy;
        }
        sum
    };
    let energies: Vec<f64> = if elements.len() <= ALONE {
        elements
            .chunks(CHUNK)
            .zip(pulls.chunks_mut(CHUNK))
            .map(one)
            .collect()
    } else {
        elements
            .par_chunks(CHUNK)
            .zip(pulls.par_chunks_mut(CHUNK))
            .map(one)
            .collect()
    };
    energies.iter().sum()
}

/// What the elements of a structure do where its nodes are, before it is gathered at them.
pub(super) struct Elastic<'a> {
    structure: &'a Structure,
    gather: &'a Gather,
    positions: &'a [DVec3],
    pulls: &'a Pulls,
    /// E [J].
    pub energy_j: f64,
}

/// Writes the gradient of the elastic energy [N], `[node_count]`, and returns the energy [J].
pub fn elastic_gradient(
    structure: &Structure,
    gather: &Gather,
    positions: &[DVec3],
    pulls: &mut Pulls,
    gradient: &mut [DVec3],
) -> f64 {
    let elastic = elastic(structure, gather, positions, pulls);
    each(gradient, |node, gradient| *gradient = elastic.at(node));
    elastic.energy_j
}

/// What all elements do with nodes at `positions` [m].
pub(super) fn elastic<'a>(
    structure: &'a Structure,
    gather: &'a Gather,
    positions: &'a [DVec3],
    pulls: &'a mut Pulls,
) -> Elastic<'a> {
    let mut energy = 0.0;
    if structure.membrane.is_some() {
        energy += gather
            .membrane
            .pulls(structure, positions, &mut pulls.triangles);
    }
    energy += fill(&structure.springs, &mut pulls.springs, |spring| {
        let [a, b] = spring.nodes.map(|n| positions[n as usize]);
        let length = a.distance(b);
        let elongation = length - spring.rest_length_m;
        let stiffness = if elongation < 0.0 {
            spring.compressive_stiffness_n_m
        } else {
            spring.stiffness_n_m
        };
        let pull = if length > 0.0 {
            stiffness * elongation / length
        } else {
            0.0
        };
        (pull, 0.5 * stiffness * elongation * elongation)
    });
    energy += fill(&structure.cables, &mut pulls.cables, |cable| {
        let [a, b] = cable.nodes.map(|n| positions[n as usize]);
        let length = a.distance(b);
        let state = structure.cable_state(cable, length);
        let pull = if state.tension_n > 0.0 {
            state.tension_n / length
        } else {
            // Not a number goes through.
            state.tension_n
        };
        (pull, state.energy_n * cable.rest_length_m)
    });
    for bending in &structure.bendings {
        energy += bending_energy(bending, positions);
    }
    for curvature in &structure.curvatures {
        energy += bending_energy(curvature, positions);
    }
    for guide in &structure.guides {
        let offset = positions[guide.node as usize] - guide.anchor_m;
        energy += 0.5 * (guide.stiffness_n_m * offset).dot(offset);
    }
    Elastic {
        structure,
        gather,
        positions,
        pulls,
        energy_j: energy,
    }
}

/// Σ c_i x_i.
fn bend<const N: usize>(bending: &Bending<N>, positions: &[DVec3]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (&node, coefficient) in bending.nodes.iter().zip(bending.coefficients) {
        sum += positions[node as usize] * coefficient;
    }
    sum
}

fn bending_energy<const N: usize>(bending: &Bending<N>, positions: &[DVec3]) -> f64 {
    0.5 * bending.stiffness_n_m * bend(bending, positions).length_squared()
}

/// Gradient of a bending term at one of its nodes [N].
fn bending_pull<const N: usize>(bending: &Bending<N>, corner: usize, positions: &[DVec3]) -> DVec3 {
    bend(bending, positions) * (bending.coefficients[corner] * bending.stiffness_n_m)
}

impl Elastic<'_> {
    /// Gradient of the energy at one node [N].
    #[inline]
    pub(super) fn at(&self, node: usize) -> DVec3 {
        let Self {
            structure,
            gather,
            positions,
            pulls,
            ..
        } = *self;
        let mut sum = DVec3::ZERO;
        if structure.membrane.is_some() {
            for place in gather.triangles.places(node) {
                sum += pulls.triangles[place];
            }
        }
        for (s, corner) in gather.springs.at(node) {
            let other = structure.springs[s].nodes[1 - corner] as usize;
            sum += (positions[node] - positions[other]) * pulls.springs[s];
        }
        for (b, corner) in gather.bendings.at(node) {
            sum += bending_pull(&structure.bendings[b], corner, positions);
        }
        for (c, corner) in gather.curvatures.at(node) {
            sum += bending_pull(&structure.curvatures[c], corner, positions);
        }
        for (c, corner) in gather.cables.at(node) {
            let other = structure.cables[c].nodes[1 - corner] as usize;
            sum += (positions[node] - positions[other]) * pulls.cables[c];
        }
        for (g, _) in gather.guides.at(node) {
            let guide = &structure.guides[g];
            sum += guide.stiffness_n_m * (positions[node] - guide.anchor_m);
        }
        sum
    }
}
