//! Part of stage `solve_cloth`: reactions of the air at impermeable markers, summed once a solve.
//!
//! Along a triangle of velocities v_a at its corners, Σ_k ½ K_k |Σ_a w_ka v_a − u*_k|² is a quadratic function with fixed coefficients. An evaluation no
//! longer knows how many markers there are.

use glam::DVec3;

use super::loads::{MarkerReaction, StepInput};
use crate::cloth::Structure;

/// What the markers of a triangle do together.
#[derive(Debug, Clone)]
struct MarkerSum {
    triangle: u32,
    nodes: [u32; 3],
    /// Unit normal along which alone the air pulls; `None`: along all axes.
    across: Option<DVec3>,
    /// Σ K w_a w_b of the corners 00, 11, 22, 01, 12, 20 [kg/s].
    stiffness_kg_s: [f64; 6],
    /// Σ K w_a u*, as far as it is felt [N].
    pull_n: [DVec3; 3],
    /// Σ ½ K u*², as far as it is felt [W].
    rest_w: f64,
}

/// Of all triangles with markers.
#[derive(Debug, Clone, Default)]
pub(super) struct MarkerSums(Vec<MarkerSum>);

impl MarkerSum {
    const fn new(nodes: [u32; 3], marker: &MarkerReaction) -> Self {
        Self {
            triangle: marker.triangle,
            nodes,
            across: marker.across,
            stiffness_kg_s: [0.0; 6],
            pull_n: [DVec3::ZERO; 3],
            rest_w: 0.0,
        }
    }

    fn add(&mut self, marker: &MarkerReaction) {
        let (w, k) = (marker.weights, marker.stiffness_kg_s);
        let air = marker.felt(marker.air_velocity_m_s);
        for (a, b) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
            .into_iter()
            .enumerate()
        {
            self.stiffness_kg_s[a] += k * w[b.0] * w[b.1];
        }
        for (pull, weight) in self.pull_n.iter_mut().zip(w) {
            *pull += air * (k * weight);
        }
        self.rest_w += 0.5 * k * air.length_squared();
    }

    /// Power [W] and forces [N] at corners that move with these velocities [m/s].
    fn at(&self, velocities: [DVec3; 3]) -> (f64, [DVec3; 3]) {
        let [u, v, w] = match self.across {
            None => velocities,
            Some(normal) => velocities.map(|velocity| normal * normal.dot(velocity)),
        };
        let [uu, vv, ww, uv, vw, wu] = self.stiffness_kg_s;
        let forces = [
            u * uu + v * uv + w * wu,
            u * uv + v * vv + w * vw,
            u * wu + v * vw + w * ww,
        ];
        let mut power = self.rest_w;
        let mut net = [DVec3::ZERO; 3];
        for (a, velocity) in [u, v, w].into_iter().enumerate() {
            power += velocity.dot(0.5 * forces[a] - self.pull_n[a]);
            net[a] = forces[a] - self.pull_n[a];
        }
        (power, net)
    }
}

impl MarkerSums {
    /// Those of a step; none in the static limit.
    pub(super) fn new(structure: &Structure, input: &StepInput) -> Self {
        let mut sums: Vec<MarkerSum> = Vec::new();
        if input.time_step_s.is_none() {
            return Self(sums);
        }
        for marker in input.impermeable_markers() {
            let same = |sum: &&mut MarkerSum| {
                sum.triangle == marker.triangle && sum.across == marker.across
            };
            if let Some(sum) = sums.last_mut().filter(same) {
                sum.add(marker);
                continue;
            }
            let nodes = structure.triangles[marker.triangle as usize].nodes;
            let mut sum = MarkerSum::new(nodes, marker);
            sum.add(marker);
            sums.push(sum);
        }
        Self(sums)
    }

    /// Adds the reactions at `point`, with velocities (x − x̂)/dt, to the gradient [N]; returns their part of the objective [J].
    pub(super) fn add_reactions(
        &self,
        [base, point]: [&[DVec3]; 2],
        dt: f64,
        gradient: &mut [DVec3],
    ) -> f64 {
        let mut value = 0.0;
        for sum in &self.0 {
            let nodes = sum.nodes.map(|node| node as usize);
            let (power, forces) = sum.at(nodes.map(|node| (point[node] - base[node]) / dt));
            value += dt * power;
            for (node, force) in nodes.into_iter().zip(forces) {
                gradient[node] += force;
            }
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power and forces of the sum are those of its markers one by one, along all axes and across alone.
    #[test]
    fn a_triangle_does_what_its_markers_do() {
        for across in [None, Some(DVec3::new(0.6, 0.0, 0.8))] {
            let marker = |weights, stiffness_kg_s, air| MarkerReaction {
                triangle: 0,
                weights,
                stiffness_kg_s,
                air_velocity_m_s: DVec3::from_array(air),
                across,
            };
            let markers = [
                marker([0.2, 0.5, 0.3], 2.0, [1.0, -2.0, 0.5]),
                marker([0.7, 0.1, 0.2], 0.5, [0.3, 0.1, 4.0]),
            ];
            let velocities = [
                DVec3::new(0.1, -0.4, 0.3),
                DVec3::new(-0.2, 0.6, 0.5),
                DVec3::new(0.9, 0.1, -0.7),
            ];
            let mut sum = MarkerSum::new([0, 1, 2], &markers[0]);
            let (mut value, mut forces) = (0.0, [DVec3::ZERO; 3]);
            for marker in &markers {
                sum.add(marker);
                let v: DVec3 = (0..3).map(|a| velocities[a] * marker.weights[a]).sum();
                let slip = marker.felt(v - marker.air_velocity_m_s);
                value += 0.5 * marker.stiffness_kg_s * slip.length_squared();
                for a in 0..3 {
                    forces[a] += slip * (marker.stiffness_kg_s * marker.weights[a]);
                }
            }
            let (power, found) = sum.at(velocities);
            assert!((power - value).abs() < 1e-13, "{power} {value}");
            for (found, force) in found.iter().zip(forces) {
                assert!((*found - force).length() < 1e-13);
            }
        }
    }
}
