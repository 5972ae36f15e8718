//! Part of stage `solve_cloth`: elastic energy E(x) and its gradient ∇E = −f, gathered from elements to nodes.

use glam::DVec3;

use crate::cloth::elements::EDGES;
use crate::cloth::{CableSegment, Structure, Triangle};
use crate::fabric::membrane::principal;
use crate::frame::FabricState;
use crate::lines;

/// Adds the gradient of the elastic energy to `gradient` [N] and returns the energy [J].
pub fn add_elastic_gradient(
    structure: &Structure,
    positions: &[DVec3],
    gradient: &mut [DVec3],
) -> f64 {
    let mut energy = 0.0;
    if let Some(membrane) = &structure.membrane {
        for triangle in &structure.triangles {
            let edges = triangle.edge_vectors(positions);
            let response = membrane.respond(&triangle.strain(&edges));
            energy += triangle.rest_area_m2 * response.energy;
            let b = &triangle.strain_from_squares;
            let t = response.tension;
            for (i, [from, to]) in EDGES.into_iter().enumerate() {
                // ∂W/∂s_i, times ∂s_i/∂x = ±2 (x_to − x_from).
                let q = triangle.rest_area_m2 * (b[0][i] * t[0] + b[1][i] * t[1] + b[2][i] * t[2]);
                let pull = edges[i] * (2.0 * q);
                gradient[triangle.nodes[to] as usize] += pull;
                gradient[triangle.nodes[from] as usize] -= pull;
            }
        }
    }
    for spring in &structure.springs {
        let [a, b] = spring.nodes.map(|n| n as usize);
        let edge = positions[b] - positions[a];
        let length = edge.length();
        let elongation = length - spring.rest_length_m;
        let stiffness = if elongation < 0.0 {
            spring.compressive_stiffness_n_m
        } else {
            spring.stiffness_n_m
        };
        energy += 0.5 * stiffness * elongation * elongation;
        if length > 0.0 {
            let pull = edge * (stiffness * elongation / length);
            gradient[b] += pull;
            gradient[a] -= pull;
        }
    }
    for bending in &structure.bendings {
        let [a, b, c] = bending.nodes.map(|n| n as usize);
        let second_difference = positions[a] - 2.0 * positions[b] + positions[c];
        energy += 0.5 * bending.stiffness_n_m * second_difference.length_squared();
        let pull = second_difference * bending.stiffness_n_m;
        gradient[a] += pull;
        gradient[b] -= 2.0 * pull;
        gradient[c] += pull;
    }
    for cable in &structure.cables {
        let [a, b] = cable.nodes.map(|n| n as usize);
        let edge = positions[b] - positions[a];
        let length = edge.length();
        let elongation = length - cable.rest_length_m;
        if elongation > 0.0 {
            let tension = lines::tension_n(cable.axial_stiffness_n, cable.rest_length_m, length);
            energy += 0.5 * tension * elongation;
            let pull = edge * (tension / length);
            gradient[b] += pull;
            gradient[a] -= pull;
        }
    }
    for guide in &structure.guides {
        let node = guide.node as usize;
        let offset = positions[node] - guide.anchor_m;
        energy += 0.5 * (guide.stiffness_n_m * offset).dot(offset);
        gradient[node] += guide.stiffness_n_m * offset;
    }
    energy
}

/// Adds the follower load of a pressure jump (positive along the triangle normals) to `forces` [N].
pub fn add_pressure(
    structure: &Structure,
    positions: &[DVec3],
    pressure_pa: f64,
    forces: &mut [DVec3],
) {
    for triangle in &structure.triangles {
        let share = triangle.doubled_area_vector(positions) * (pressure_pa / 6.0);
        for node in triangle.nodes {
            forces[node as usize] += share;
        }
    }
}

/// Tension of a cable segment [N].
#[must_use]
pub fn cable_tension_n(cable: &CableSegment, positions: &[DVec3]) -> f64 {
    let [a, b] = cable.nodes.map(|n| positions[n as usize]);
    lines::tension_n(cable.axial_stiffness_n, cable.rest_length_m, a.distance(b))
}

/// What designers read of one triangle.
#[derive(Debug, Clone, Copy)]
pub struct TriangleLoad {
    /// Principal membrane tensions (second Piola–Kirchhoff), larger first [N/m].
    pub principal_tensions_n_m: [f64; 2],
    /// Taut, wrinkled or slack.
    pub state: FabricState,
}

/// Loads of all triangles; without tensions (NaN) where a spring network carries the load.
#[must_use]
pub fn triangle_loads(structure: &Structure, positions: &[DVec3]) -> Vec<TriangleLoad> {
    structure
        .triangles
        .iter()
        .map(|triangle| {
            let Some(membrane) = &structure.membrane else {
                return network_load(triangle, positions);
            };
            let response = membrane.respond(&triangle.strain(&triangle.edge_vectors(positions)));
            let t = response.tension;
            let values = principal(t[0], t[1], t[2]);
            TriangleLoad {
                principal_tensions_n_m: values,
                state: response.state,
            }
        })
        .collect()
}

/// A network has springs, no membrane tension: only the state of the edges is told, taut if all are stretched, slack if none is.
fn network_load(triangle: &Triangle, positions: &[DVec3]) -> TriangleLoad {
    let edges = triangle.edge_vectors(positions);
    let stretched = edges
        .iter()
        .zip(triangle.rest_squares_m2)
        .filter(|(edge, rest)| edge.length_squared() > *rest)
        .count();
    let state = match stretched {
        3 => FabricState::Taut,
        0 => FabricState::Slack,
        _ => FabricState::Wrinkled,
    };
    TriangleLoad {
        principal_tensions_n_m: [f64::NAN; 2],
        state,
    }
}
