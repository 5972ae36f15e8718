//! What the air does to a triangle that cuts its lattice ([`crate::cut_links`]).
//!
//! A cut of direction d gives the fabric the force d (p − k d·v), v its velocity there at the end of the step. Over a triangle that is ½ dt vᵀ S v − dt p·v of the
//! objective, in the velocities of its corners: summed once for a solve, however many links the triangle cuts.

use glam::{DMat3, DVec3};

use super::initial_hessian::outer;

/// What the air does to a triangle through its cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleReaction {
    /// The triangle.
    pub triangle: u32,
    /// Σ k a_i a_j d dᵀ of the corners 00, 11, 22, 01, 12, 20, a the barycentric weights [kg/s].
    pub stiffness_kg_s: [DMat3; 6],
    /// Σ p a_i d of the corners [N].
    pub pull_n: [DVec3; 3],
    /// Σ ½ p²/k, so that the sum is zero where the fabric moves as the air does [W].
    pub rest_w: f64,
}

/// What the air does to a triangle through its cuts where it feels them at its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MiddleReaction {
    /// Σ k d dᵀ [kg/s].
    pub stiffness_kg_s: DMat3,
    /// Σ p d [N].
    pub pull_n: DVec3,
    /// Σ ½ p²/k [W].
    pub rest_w: f64,
}

impl MiddleReaction {
    /// Nothing.
    pub const NONE: Self = Self {
        stiffness_kg_s: DMat3::ZERO,
        pull_n: DVec3::ZERO,
        rest_w: 0.0,
    };

    /// Adds a cut along the unit vector `direction`, of stiffness k [kg/s] and push p [N].
    pub fn add(&mut self, direction: DVec3, [k, p]: [f64; 2]) {
        self.stiffness_kg_s += outer(direction, direction) * k;
        self.pull_n += direction * p;
        self.rest_w += 0.5 * p * p / k;
    }
}

/// Pairs of corners; every block is symmetric.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

/// Number of the pair of two corners.
const fn pair(a: usize, b: usize) -> usize {
    if a == b {
        a
    } else {
        // (0, 1), (1, 2), (2, 0): the missing corner is 2, 0, 1.
        [4, 5, 3][3 - a - b]
    }
}

impl TriangleReaction {
    /// Nothing on a triangle.
    #[must_use]
    pub const fn none(triangle: u32) -> Self {
        Self {
            triangle,
            stiffness_kg_s: [DMat3::ZERO; 6],
            pull_n: [DVec3::ZERO; 3],
            rest_w: 0.0,
        }
    }

    /// Adds a cut at these weights: along the unit vector `direction`, stiffness k [kg/s] and push p [N].
    pub fn add(&mut self, weights: [f64; 3], direction: DVec3, [k, p]: [f64; 2]) {
        let block = outer(direction, direction) * k;
        for (sum, [a, b]) in self.stiffness_kg_s.iter_mut().zip(PAIRS) {
            *sum += block * (weights[a] * weights[b]);
        }
        for (sum, weight) in self.pull_n.iter_mut().zip(weights) {
            *sum += direction * (p * weight);
        }
        self.rest_w += 0.5 * p * p / k;
    }

    /// Adds a force at these weights that does not depend on how the triangle moves [N].
    pub fn add_force(&mut self, weights: [f64; 3], force_n: DVec3) {
        for (sum, weight) in self.pull_n.iter_mut().zip(weights) {
            *sum += force_n * weight;
        }
    }

    /// Adds what else the air does to the same triangle.
    pub fn add_reaction(&mut self, other: &Self) {
        for (sum, block) in self.stiffness_kg_s.iter_mut().zip(other.stiffness_kg_s) {
            *sum += block;
        }
        for (sum, pull) in self.pull_n.iter_mut().zip(other.pull_n) {
            *sum += pull;
        }
        self.rest_w += other.rest_w;
    }

    /// Adds a share of what the air does to a triangle at its middle.
    pub fn add_middle(&mut self, middle: &MiddleReaction, share: f64) {
        let block = middle.stiffness_kg_s * (share / 9.0);
        for sum in &mut self.stiffness_kg_s {
            *sum += block;
        }
        let pull_n = middle.pull_n * (share / 3.0);
        for sum in &mut self.pull_n {
            *sum += pull_n;
        }
        self.rest_w += middle.rest_w * share;
    }

    /// Stiffness between two corners [kg/s].
    #[must_use]
    pub const fn between(&self, a: usize, b: usize) -> DMat3 {
        self.stiffness_kg_s[pair(a, b)]
    }

    /// What resists a corner as the whole triangle moves, the mean over directions [kg/s].
    #[must_use]
    pub fn stiffness_at(&self, corner: usize) -> f64 {
        let trace = |block: DMat3| block.x_axis.x + block.y_axis.y + block.z_axis.z;
        (0..3)
            .map(|other| trace(self.between(corner, other)) / 3.0)
            .sum()
    }

    /// Power [W] and forces [N] at corners that move with these velocities [m/s].
    #[must_use]
    pub fn at(&self, velocities: [DVec3; 3]) -> (f64, [DVec3; 3]) {
        let mut value = self.rest_w;
        let mut forces = [DVec3::ZERO; 3];
        for a in 0..3 {
            let mut force = DVec3::ZERO;
            for (b, velocity) in velocities.iter().enumerate() {
                force += self.between(a, b) * *velocity;
            }
            value += velocities[a].dot(0.5 * force - self.pull_n[a]);
            forces[a] = force - self.pull_n[a];
        }
        (value, forces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cuts along x, y and z at one place resist a motion of the whole triangle alike in all directions, shared among the corners by their weights.
    #[test]
    fn stiffness_is_shared_by_the_weights() {
        let mut reaction = TriangleReaction::none(0);
        let weights = [0.5, 0.3, 0.2];
        for direction in [DVec3::X, DVec3::Y, DVec3::Z] {
            reaction.add(weights, direction, [4.0, 1.0]);
        }
        for (corner, weight) in weights.into_iter().enumerate() {
            assert!((reaction.stiffness_at(corner) - 4.0 * weight).abs() < 1e-12);
        }
    }

    /// Cuts felt at the middle are cuts at equal weights, and shares of them add up.
    #[test]
    fn middles_are_cuts_at_equal_weights() {
        let cuts = [
            (DVec3::new(0.6, 0.0, 0.8), [2.0, 0.3]),
            (DVec3::new(0.0, -0.6, 0.8), [1.5, -0.7]),
        ];
        let mut whole = TriangleReaction::none(3);
        let mut middle = MiddleReaction::NONE;
        for (direction, of) in cuts {
            whole.add([1.0 / 3.0; 3], direction, of);
            middle.add(direction, of);
        }
        let mut shared = TriangleReaction::none(3);
        for share in [0.2, 0.7, 0.1] {
            shared.add_middle(&middle, share);
        }
        let velocities = [
            DVec3::new(0.3, -0.2, 0.9),
            DVec3::new(-1.1, 0.4, 0.5),
            DVec3::new(0.7, 0.8, -0.6),
        ];
        let [(power, forces), (known, known_forces)] = [shared, whole].map(|r| r.at(velocities));
        assert!((power - known).abs() < 1e-14);
        for (force, known) in forces.into_iter().zip(known_forces) {
            assert!((force - known).length() < 1e-14);
        }
    }
}
