//! The D3Q19 lattice: directions, weights and the collision formulas.
//!
//! Everything here is a pure formula in lattice units (cell = time step = reference density = 1).
//!
//! Directions come in opposite pairs (1, 2), (3, 4) … (17, 18); the first of a pair never points towards −x, and
//! the streaming scheme of [`grid`] relies on that order.

pub mod collision;
pub mod control_volume;
pub mod eddy_viscosity;
pub mod faces;
pub mod grid;
pub mod level_state;
pub mod links;
pub mod nest;
pub mod operators;
mod real;
pub mod stability;
pub mod start;

pub use collision::Operator;
pub use real::{Lanes, Number, Real};

/// Number of discrete velocities.
pub const DIRECTION_COUNT: usize = 19;

/// Speed of sound squared, cs² = 1/3.
pub const SOUND_SPEED_SQUARED: f64 = 1.0 / 3.0;

/// Discrete velocities; direction 0 is rest, `i` odd and `i + 1` are opposite.
pub const DIRECTIONS: [[i32; 3]; DIRECTION_COUNT] = [
    [0, 0, 0],
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
    [0, 0, 1],
    [0, 0, -1],
    [1, 1, 0],
    [-1, -1, 0],
    [1, 0, 1],
    [-1, 0, -1],
    [0, 1, 1],
    [0, -1, -1],
    [1, -1, 0],
    [-1, 1, 0],
    [1, 0, -1],
    [-1, 0, 1],
    [0, 1, -1],
    [0, -1, 1],
];

/// Quadrature weights: 1/3 at rest, 1/18 along axes, 1/36 along face diagonals.
pub const WEIGHTS: [f64; DIRECTION_COUNT] = {
    let mut weights = [1.0 / 36.0; DIRECTION_COUNT];
    weights[0] = 1.0 / 3.0;
    let mut i = 1;
    while i < 7 {
        weights[i] = 1.0 / 18.0;
        i += 1;
    }
    weights
};

/// Directions that enter through −x; the entering ones at +x are their opposites.
pub const DOWNSTREAM: [usize; 5] = [1, 7, 9, 13, 15];

/// The direction opposite to `direction`.
#[must_use]
#[inline(always)]
pub const fn opposite(direction: usize) -> usize {
    match direction {
        0 => 0,
        d if d % 2 == 1 => d + 1,
        d => d - 1,
    }
}

/// The direction with the given velocity, if the lattice has it.
#[must_use]
pub fn direction_of(velocity: [i32; 3]) -> Option<usize> {
    DIRECTIONS.iter().position(|&c| c == velocity)
}

/// Second-order equilibrium of `direction`, shifted by its weight: w (δρ + 3 ρ c·u + 4.5 ρ (c·u)² − 1.5 ρ u²).
///
/// `density_excess` is δρ = ρ − 1.
#[must_use]
pub fn equilibrium(direction: usize, density_excess: f64, velocity: [f64; 3]) -> f64 {
    let c = DIRECTIONS[direction].map(f64::from);
    let density = 1.0 + density_excess;
    let along = c[0] * velocity[0] + c[1] * velocity[1] + c[2] * velocity[2];
    let square = velocity.iter().map(|u| u * u).sum::<f64>();
    WEIGHTS[direction]
        * (density_excess + density * (3.0 * along + 4.5 * along * along - 1.5 * square))
}

/// By how much populations in 16 bits are scaled.
pub const F16_SCALE: f32 = 32768.0;

/// How a device stores populations between steps; arithmetic is in single precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Storage {
    /// As computed: 152 bytes move per cell and step.
    #[default]
    F32,
    /// In 16 bits: 76 bytes, at the price of 11 bits of each population's distance from rest.
    F16,
}

impl Storage {
    /// Bytes of a population.
    #[must_use]
    pub const fn bytes(self) -> u64 {
        match self {
            Self::F32 => 4,
            Self::F16 => 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_the_weights_are_isotropic() {
        assert!((WEIGHTS.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        for a in 0..3 {
            for b in 0..3 {
                let second: f64 = (0..DIRECTION_COUNT)
                    .map(|i| WEIGHTS[i] * f64::from(DIRECTIONS[i][a] * DIRECTIONS[i][b]))
                    .sum();
                let expected = if a == b { SOUND_SPEED_SQUARED } else { 0.0 };
                assert!((second - expected).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn pairs_are_opposite() {
        for i in 0..DIRECTION_COUNT {
            assert_eq!(DIRECTIONS[opposite(i)], DIRECTIONS[i].map(|c| -c));
        }
    }
}
