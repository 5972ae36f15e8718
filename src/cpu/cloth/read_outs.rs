//! What designers read of fabric, cables and supports.

use glam::DVec3;

use super::loads::{StepInput, dead_loads};
use super::nodal_forces::elastic_gradient;
use super::{Cloth, pressure};
use crate::cloth::{Structure, Triangle};
use crate::fabric::membrane::{Membrane, Response, principal};
use crate::frame::FabricState;

/// Load of one triangle.
#[derive(Debug, Clone, Copy)]
pub struct TriangleLoad {
    /// Principal tensions per present width (Cauchy stress times present thickness), larger first [N/m].
    pub principal_tensions_n_m: [f64; 2],
    /// Shear tension between warp and weft (second Piola–Kirchhoff) [N/m].
    pub shear_tension_n_m: f64,
    /// Shear strain 2ε₁₂ between warp and weft (Green).
    pub shear_strain: f64,
    /// Taut, wrinkled or slack.
    pub state: FabricState,
}

impl TriangleLoad {
    /// Without a membrane law.
    const fn of_network(state: FabricState) -> Self {
        Self {
            principal_tensions_n_m: [f64::NAN; 2],
            shear_tension_n_m: f64::NAN,
            shear_strain: f64::NAN,
            state,
        }
    }

    fn new(strain: &[f64; 3], response: &Response) -> Self {
        // σ h = F T Fᵀ/J has the eigenvalues of T C/J, with C = 2E + I and J² = det C.
        let t = response.tension;
        let c = [1.0 + 2.0 * strain[0], 1.0 + 2.0 * strain[1], strain[2]];
        let determinant = c[0] * c[1] - c[2] * c[2];
        let half_trace = 0.5 * (t[0] * c[0] + t[1] * c[1] + 2.0 * t[2] * c[2]);
        let product = (t[0] * t[1] - t[2] * t[2]) * determinant;
        let radius = (half_trace * half_trace - product).max(0.0).sqrt();
        let stretch = determinant.max(0.0).sqrt();
        let principal_tensions_n_m = if stretch > 0.0 {
            [half_trace + radius, half_trace - radius].map(|value| value / stretch)
        } else {
            // Collapsed to a line: per rest width.
            principal(t[0], t[1], t[2])
        };
        Self {
            principal_tensions_n_m,
            shear_tension_n_m: t[2],
            shear_strain: strain[2],
            state: response.state,
        }
    }

    /// Von Mises tension of plane stress, √(N₁² − N₁N₂ + N₂²) [N/m].
    #[must_use]
    pub fn von_mises_n_m(&self) -> f64 {
        let [a, b] = self.principal_tensions_n_m;
        (a * a - a * b + b * b).sqrt()
    }
}

fn load(membrane: &Membrane, triangle: &Triangle, positions: &[DVec3]) -> TriangleLoad {
    let strain = triangle.strain(&triangle.edge_vectors(positions));
    TriangleLoad::new(&strain, &membrane.respond(&strain))
}

/// Loads of all triangles; without tensions (NaN) where a spring network carries the load.
#[must_use]
pub fn triangle_loads(structure: &Structure, positions: &[DVec3]) -> Vec<TriangleLoad> {
    let load = |triangle| match &structure.membrane {
        Some(membrane) => load(membrane, triangle, positions),
        None => TriangleLoad::of_network(network_state(triangle, positions)),
    };
    structure.triangles.iter().map(load).collect()
}

/// A network has springs, no membrane tension: the state of the edges is told, taut if all are stretched, slack if none is.
fn network_state(triangle: &Triangle, positions: &[DVec3]) -> FabricState {
    let edges = triangle.edge_vectors(positions);
    let stretched = edges
        .iter()
        .zip(triangle.rest_squares_m2)
        .filter(|(edge, rest)| edge.length_squared() > *rest)
        .count();
    match stretched {
        3 => FabricState::Taut,
        0 => FabricState::Slack,
        _ => FabricState::Wrinkled,
    }
}

impl Cloth {
    /// Tension of a cable segment, its damping included [N].
    #[must_use]
    pub fn cable_tension_n(&self, index: usize) -> f64 {
        let cable = &self.structure.cables[index];
        let [a, b] = cable.nodes.map(|n| n as usize);
        let edge = self.positions_m[b] - self.positions_m[a];
        let state = self.structure.cable_state(cable, edge.length());
        if edge.length() <= cable.rest_length_m {
            return state.tension_n;
        }
        let rate = edge
            .normalize_or_zero()
            .dot(self.velocities_m_s[b] - self.velocities_m_s[a]);
        state.tension_n + cable.damping_n_s * rate / cable.rest_length_m
    }

    /// Forces with which supports hold the structure, `(node, force [N])` for every held node: what elements pull there, less the loads
    /// of `input`. Inertia and damping of supports that move are not in it.
    #[must_use]
    pub fn reactions_n(&self, input: &StepInput) -> Vec<(u32, DVec3)> {
        let structure = &self.structure;
        let mut forces = vec![DVec3::ZERO; structure.node_count()];
        let mut pulls = super::Pulls::default();
        elastic_gradient(
            structure,
            &self.prepared.gather,
            &self.positions_m,
            &mut pulls,
            &mut forces,
        );
        if let Some(contact) = self.contact_state() {
            for (force, push) in forces.iter_mut().zip(&contact.forces_n) {
                *force -= *push;
            }
        }
        let mut loads = dead_loads(structure, input);
        pressure::add_forces(structure, &self.positions_m, input.pressure, &mut loads);
        let held = structure.held.iter().enumerate();
        held.filter(|(_, held)| **held)
            .map(|(node, _)| (node as u32, forces[node] - loads[node]))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tensions_are_per_present_width() {
        // A square of law T = k E stretched by 20 % along x and 10 % along y: N = F T Fᵀ/J.
        let membrane = Membrane::new([[1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 500.0]], 0.0);
        let (a, b) = (1.2, 1.1);
        let strain = [0.5 * (a * a - 1.0), 0.5 * (b * b - 1.0), 0.0];
        let load = TriangleLoad::new(&strain, &membrane.respond(&strain));
        let expected = [1e3 * strain[0] * a / b, 1e3 * strain[1] * b / a];
        for (found, expected) in load.principal_tensions_n_m.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12);
        }
        // The same stretch at 45° to the warp.
        let [mean, half] = [0.5 * (strain[0] + strain[1]), strain[0] - strain[1]];
        let turned = [mean, mean, half];
        let across = TriangleLoad::new(&turned, &membrane.respond(&turned));
        for (found, expected) in across.principal_tensions_n_m.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12);
        }
        let [n1, n2] = expected;
        let mises = (0.5 * ((n1 - n2).powi(2) + n1 * n1 + n2 * n2)).sqrt();
        assert!((load.von_mises_n_m() / mises - 1.0).abs() < 1e-12);
    }
}
