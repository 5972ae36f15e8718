//! Part of stage `solve_cloth`: what [`crate::solve::stiffening`] asks of a structure and of the objective: softened tension, the second-order force of a step, and a
//! factorisation of the whole projected Hessian.

use glam::DVec3;

use super::gather::Gather;
use crate::cloth::elements::EDGES;
use crate::cloth::{Structure, Triangle};
use crate::fabric::membrane::Membrane;
use crate::fabric::shear::CubicShear;

/// A structure with a share of its tensile stiffness.
#[derive(Debug)]
pub(super) struct Soft {
    pub(super) structure: Structure,
    pub(super) gather: Gather,
}

impl Soft {
    pub(super) fn new(structure: &Structure, share: f64) -> Self {
        let structure = softened(structure, share);
        Self {
            gather: Gather::new(&structure),
            structure,
        }
    }
}

/// The same structure with `share` of its tensile stiffness. What membranes resist compression with stays what it is, so that folds are those of the true
/// fabric, as long as it is no more than what is left of the tensile stiffness. Springs are softened in both directions; cables are not.
#[must_use]
fn softened(structure: &Structure, share: f64) -> Structure {
    let mut soft = structure.clone();
    if share >= 1.0 {
        return soft;
    }
    if let Some(law) = &mut soft.membrane {
        *law = softened_law(law, share);
    }
    for fabric in &mut soft.further_fabrics {
        fabric.membrane = softened_law(&fabric.membrane, share);
    }
    for spring in &mut soft.springs {
        spring.stiffness_n_m *= share;
        spring.compressive_stiffness_n_m *= share;
    }
    soft
}

fn softened_law(law: &Membrane, share: f64) -> Membrane {
    let stiffness = law.stiffness().map(|row| row.map(|k| share * k));
    let soft = Membrane::new(stiffness, (law.residual() / share).min(1.0));
    // γ = c τ + k τ³ with tensions that are `share` of those.
    match law.shear() {
        Some(shear) => soft.with_shear(CubicShear {
            compliance_m_n: shear.compliance_m_n / share,
            cubic_m3_n3: shear.cubic_m3_n3 / share.powi(3),
        }),
        None => soft,
    }
}

/// Writes the part of the elastic gradient at `positions` + l d that grows with l² [N], with the tangent at `positions`:
/// Bᵀ C E₂ + B′ᵀ C E₁, E₁ the strain linear in d, E₂ that of its squares, B′ the change of B along d. Zero where nodes are held.
pub(super) fn second_order(
    structure: &Structure,
    positions: &[DVec3],
    direction: &[DVec3],
    force: &mut [DVec3],
) {
    force.fill(DVec3::ZERO);
    if let Some(laws) = structure.laws() {
        for triangle in &structure.triangles {
            add_triangle(laws.of(triangle), triangle, [positions, direction], force);
        }
    }
    let mut add_axial = |nodes: [u32; 2], stiffness: &dyn Fn(f64) -> f64| {
        let [a, b] = nodes.map(|n| n as usize);
        let edge = positions[b] - positions[a];
        let length = edge.length();
        if length == 0.0 {
            return;
        }
        let along = edge / length;
        let turn = direction[b] - direction[a];
        let stretch = along.dot(turn);
        let across = turn - along * stretch;
        let second = 0.5 * across.length_squared() / length;
        let pull = (along * second + across * (stretch / length)) * stiffness(length);
        force[b] += pull;
        force[a] -= pull;
    };
    for spring in &structure.springs {
        add_axial(spring.nodes, &|length| {
            if length > spring.rest_length_m {
                spring.stiffness_n_m
            } else {
                spring.compressive_stiffness_n_m
            }
        });
    }
    for cable in &structure.cables {
        add_axial(cable.nodes, &|length| {
            if length > cable.rest_length_m {
                structure.cable_state(cable, length).tangent_n / cable.rest_length_m
            } else {
                0.0
            }
        });
    }
    for (force, &held) in force.iter_mut().zip(&structure.held) {
        if held {
            *force = DVec3::ZERO;
        }
    }
}

fn add_triangle(
    law: &Membrane,
    triangle: &Triangle,
    [positions, direction]: [&[DVec3]; 2],
    force: &mut [DVec3],
) {
    let edges = triangle.edge_vectors(positions);
    let turns = triangle.edge_vectors(direction);
    let strain = triangle.strain(&edges);
    let tangent = law.tangent(&strain, &law.respond(&strain));
    let b = &triangle.strain_from_squares;
    // ∂E/∂s of the three edges, twice, for changes of the squared elongations.
    let pulls = |squares: [f64; 3]| -> [f64; 3] {
        let change = b.map(|row| row[0] * squares[0] + row[1] * squares[1] + row[2] * squares[2]);
        let tension =
            tangent.map(|row| row[0] * change[0] + row[1] * change[1] + row[2] * change[2]);
        [0, 1, 2].map(|i| {
            let sum = b[0][i] * tension[0] + b[1][i] * tension[1] + b[2][i] * tension[2];
            2.0 * triangle.rest_area_m2 * sum
        })
    };
    let first = pulls([0, 1, 2].map(|i| 2.0 * edges[i].dot(turns[i])));
    let second = pulls(turns.map(|turn| turn.length_squared()));
    for (i, [from, to]) in EDGES.into_iter().enumerate() {
        let pull = edges[i] * second[i] + turns[i] * first[i];
        force[triangle.nodes[to] as usize] += pull;
        force[triangle.nodes[from] as usize] -= pull;
    }
}
