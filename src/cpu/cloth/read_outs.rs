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
    /// Principal tensions per present width of the cloth (Cauchy stress times present thickness), larger first [N/m]. Where it is wrinkled, that is
    /// its width along the wrinkles' slopes, not the smaller one between their feet.
    pub principal_tensions_n_m: [f64; 2],
    /// Unit vector along the larger principal tension, along which wrinkles run; zero where there is none.
    pub direction: DVec3,
    /// Shear tension between warp and weft (second Piola–Kirchhoff) [N/m].
    pub shear_tension_n_m: f64,
    /// Shear strain 2ε₁₂ between warp and weft (Green).
    pub shear_strain: f64,
    /// Principal strains (Green), larger first.
    pub principal_strains: [f64; 2],
    /// Present area of the cloth over that at rest, its wrinkles laid out: fabric that keeps its volume is so many times as thin.
    pub cloth_stretch: f64,
    /// Taut, wrinkled or slack.
    pub state: FabricState,
}

impl TriangleLoad {
    /// Without a membrane law.
    const fn of_network(state: FabricState) -> Self {
        Self {
            principal_tensions_n_m: [f64::NAN; 2],
            direction: DVec3::ZERO,
            shear_tension_n_m: f64::NAN,
            shear_strain: f64::NAN,
            principal_strains: [f64::NAN; 2],
            cloth_stretch: f64::NAN,
            state,
        }
    }

    fn new(strain: &[f64; 3], response: &Response) -> Self {
        // σ h = F T Fᵀ/J has the eigenvalues of T C/J, with C = 2E + I, and J² = det C where nothing is wrinkled.
        let t = response.tension;
        let c = [1.0 + 2.0 * strain[0], 1.0 + 2.0 * strain[1], strain[2]];
        let determinant = c[0] * c[1] - c[2] * c[2];
        let half_trace = 0.5 * (t[0] * c[0] + t[1] * c[1] + 2.0 * t[2] * c[2]);
        let product = (t[0] * t[1] - t[2] * t[2]) * determinant;
        let radius = (half_trace * half_trace - product).max(0.0).sqrt();
        let stretch = cloth_stretch(strain, response);
        let principal_tensions_n_m = if stretch > 0.0 {
            [half_trace + radius, half_trace - radius].map(|value| value / stretch)
        } else {
            // Sheared to a line: per rest width.
            principal(t[0], t[1], t[2])
        };
        Self {
            principal_tensions_n_m,
            direction: DVec3::ZERO,
            shear_tension_n_m: t[2],
            shear_strain: strain[2],
            principal_strains: principal(strain[0], strain[1], 0.5 * strain[2]),
            cloth_stretch: stretch,
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

/// Present area of the cloth over that at rest, its wrinkles laid out.
fn cloth_stretch(strain: &[f64; 3], response: &Response) -> f64 {
    if response.state == FabricState::Slack {
        return 1.0;
    }
    let [xx, yy, xy] = [0, 1, 2].map(|k| strain[k] + response.wrinkle_strain * response.across[k]);
    let square = (1.0 + 2.0 * xx) * (1.0 + 2.0 * yy) - xy * xy;
    square.max(0.0).sqrt()
}

fn load(membrane: &Membrane, triangle: &Triangle, positions: &[DVec3]) -> TriangleLoad {
    let edges = triangle.edge_vectors(positions);
    let strain = triangle.strain(&edges);
    let response = membrane.respond(&strain);
    TriangleLoad {
        direction: principal_direction(triangle, &edges, &response.tension),
        ..TriangleLoad::new(&strain, &response)
    }
}

/// Unit vector along the larger principal tension: of the sum Σ w_i x_i⊗x_i over the edges x_i, which is that of the tensions per present
/// width but for a factor, with w = Bᵀ T the derivative of energy by squared edge lengths.
fn principal_direction(triangle: &Triangle, edges: &[DVec3; 3], tension: &[f64; 3]) -> DVec3 {
    let b = &triangle.strain_from_squares;
    let weight = |i: usize| (0..3).map(|row| b[row][i] * tension[row]).sum::<f64>();
    let Some(x) = edges[0].try_normalize() else {
        return DVec3::ZERO;
    };
    let Some(y) = (edges[1] - x * edges[1].dot(x)).try_normalize() else {
        return x;
    };
    let mut sums = [0.0; 3];
    for (i, edge) in edges.iter().enumerate() {
        let (w, along, across) = (weight(i), edge.dot(x), edge.dot(y));
        sums[0] += w * along * along;
        sums[1] += w * across * across;
        sums[2] += w * along * across;
    }
    if sums == [0.0; 3] {
        return DVec3::ZERO;
    }
    let angle = 0.5 * (2.0 * sums[2]).atan2(sums[0] - sums[1]);
    x * angle.cos() + y * angle.sin()
}

/// Loads of all triangles; without tensions (NaN) where a spring network carries the load.
#[must_use]
pub fn triangle_loads(structure: &Structure, positions: &[DVec3]) -> Vec<TriangleLoad> {
    let load = |triangle| match structure.laws() {
        Some(laws) => load(laws.of(triangle), triangle, positions),
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
        let unbalanced = self.loads_less_pulls_n(input);
        let held = self.structure.held.iter().enumerate();
        held.filter(|(_, held)| **held)
            .map(|(node, _)| (node as u32, -unbalanced[node]))
            .collect()
    }

    /// What is left of loads and pulls at every node that is free \[N\], `[node_count]`; nothing in equilibrium, and at held nodes.
    #[must_use]
    pub fn unbalanced_forces_n(&self, input: &StepInput) -> Vec<DVec3> {
        let mut forces = self.loads_less_pulls_n(input);
        for (force, held) in forces.iter_mut().zip(&self.structure.held) {
            if *held {
                *force = DVec3::ZERO;
            }
        }
        forces
    }

    /// Loads of all nodes where the structure is \[N\], `[node_count]`: gravity, what acts on single nodes, and pressure.
    #[must_use]
    pub fn loads_n(&self, input: &StepInput) -> Vec<DVec3> {
        let mut loads = dead_loads(&self.structure, input);
        let pressure = input.pressure;
        pressure::add_forces(&self.structure, &self.positions_m, pressure, &mut loads);
        loads
    }

    fn loads_less_pulls_n(&self, input: &StepInput) -> Vec<DVec3> {
        let structure = &self.structure;
        let mut pulls = vec![DVec3::ZERO; structure.node_count()];
        let mut elements = super::Pulls::default();
        elastic_gradient(
            structure,
            &self.prepared.gather,
            &self.positions_m,
            &mut elements,
            &mut pulls,
        );
        if let Some(contact) = self.contact_state() {
            for (pull, push) in pulls.iter_mut().zip(&contact.forces_n) {
                *pull -= *push;
            }
        }
        let mut forces = self.loads_n(input);
        for (force, pull) in forces.iter_mut().zip(&pulls) {
            *force -= *pull;
        }
        forces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrinkles_run_along_the_tension() {
        // Pulled along a direction at 30° to the warp, contracted across it, turned in space.
        let membrane = Membrane::new([[1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 500.0]], 0.0);
        let rest = [[0.1, 0.2], [0.9, 0.05], [0.3, 0.8]].map(glam::DVec2::from_array);
        let triangle = Triangle::new([0, 1, 2], rest).unwrap();
        let (s, c) = 30f64.to_radians().sin_cos();
        let (along, across) = (glam::DVec2::new(c, s), glam::DVec2::new(-s, c));
        let turn = glam::DQuat::from_rotation_x(0.7) * glam::DQuat::from_rotation_z(0.4);
        let place = |p: glam::DVec2| {
            let flat = along * (1.1 * p.dot(along)) + across * (0.8 * p.dot(across));
            turn * flat.extend(0.0)
        };
        let load = load(&membrane, &triangle, &rest.map(place));
        assert_eq!(load.state, FabricState::Wrinkled);
        let expected = turn * along.extend(0.0);
        assert!((load.direction.dot(expected).abs() - 1.0).abs() < 1e-12);
    }

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

    #[test]
    fn wrinkles_do_not_concentrate_the_tension() {
        // Pulled to 1.1 times its length; however near the sides have come, the cloth between them is as wide as Poisson's ratio leaves it.
        let nu: f64 = 0.3;
        let k = 1e3 / (1.0 - nu * nu);
        let stiffness = [
            [k, nu * k, 0.0],
            [nu * k, k, 0.0],
            [0.0, 0.0, 0.5 * k * (1.0 - nu)],
        ];
        let membrane = Membrane::new(stiffness, 0.0);
        let along: f64 = 0.5 * (1.1_f64.powi(2) - 1.0);
        let width = (1.0 - 2.0 * nu * along).sqrt();
        let expected = 1e3 * along * 1.1 / width;
        for squeezed in [0.9 * width, 0.5, 0.01, 0.0] {
            let strain = [along, 0.5 * (squeezed * squeezed - 1.0), 0.0];
            let load = TriangleLoad::new(&strain, &membrane.respond(&strain));
            assert_eq!(load.state, FabricState::Wrinkled);
            let [larger, smaller] = load.principal_tensions_n_m;
            assert!(
                (larger / expected - 1.0).abs() < 1e-12,
                "{larger} {expected}"
            );
            assert!(smaller.abs() < 1e-9 * larger);
        }
    }

    #[test]
    fn what_is_sheared_to_a_line_has_a_finite_tension() {
        let membrane = Membrane::new([[1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 1.0]], 0.0);
        for shear in [1.2, 1.2 + 1e-9] {
            let strain = [0.1, 0.1, shear];
            let load = TriangleLoad::new(&strain, &membrane.respond(&strain));
            assert_eq!(load.state, FabricState::Taut);
            assert!(load.principal_tensions_n_m.iter().all(|n| n.is_finite()));
        }
    }
}
