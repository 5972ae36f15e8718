//! Populations at the start of a flow: equilibrium plus the non-equilibrium part that the flow's own shear makes,
//!
//! f_i = f_i^eq − 3 w_i ρ τ (c_i c_i − I/3) : ∇u,
//!
//! the first order of the Chapman–Enskog expansion (Krüger et al. 2017, The Lattice Boltzmann Method, eqs. 4.35 and 5.88), with
//! differences of the given velocity. At equilibrium alone the stress would build up during the first steps, and all decay lag behind.

use rayon::prelude::*;

use super::grid::{Faces, Initial, Setup, Sides, StreamwiseEnds};
use super::{DIRECTION_COUNT, DIRECTIONS, WEIGHTS, equilibrium};

/// What lies beyond the first and the last cell of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Beyond {
    /// The other end.
    Repeats,
    /// The mirror image.
    Mirrors,
    /// Nothing that is known.
    Ends,
}

/// Density excess and velocity of every cell, and how cells neighbour each other.
#[derive(Debug)]
pub struct Start {
    cells: [usize; 3],
    beyond: [Beyond; 3],
    relaxation_time: f64,
    states: Vec<(f64, [f64; 3])>,
    /// Stress of every cell beyond equilibrium, where it is known better than by differences.
    stresses: Option<Vec<Stress>>,
}

/// Stress beyond equilibrium, Σ f c_a c_b − ρ u_a u_b − δρ/3 δ_ab: xx, yy, zz, xy, xz, yz [lattice units].
pub type Stress = [f32; 6];

/// Axes of the components of a [`Stress`].
pub const STRESS_AXES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

/// Contributes a shifted population to the stress of its cell.
pub fn add_to_stress(stress: &mut Stress, direction: usize, population: f32) {
    let c = DIRECTIONS[direction];
    for (sum, [a, b]) in stress.iter_mut().zip(STRESS_AXES) {
        *sum += (c[a] * c[b]) as f32 * population;
    }
}

/// Takes the part of equilibrium off the sum over all populations.
pub fn less_equilibrium(sum: &mut Stress, density_excess: f64, velocity: [f64; 3]) {
    for (sum, [a, b]) in sum.iter_mut().zip(STRESS_AXES) {
        let isotropic = if a == b { density_excess / 3.0 } else { 0.0 };
        let equilibrium = (1.0 + density_excess) * velocity[a] * velocity[b] + isotropic;
        *sum = (f64::from(*sum) - equilibrium) as f32;
    }
}

impl Start {
    /// Asks `initial` for the state of every cell.
    #[must_use]
    pub fn new(setup: &Setup, initial: &Initial) -> Self {
        let [nx, ny, nz] = setup.cells;
        let across = |faces: Faces| match faces {
            Faces::Periodic => Beyond::Repeats,
            Faces::Walls(walls) if walls.iter().all(|wall| wall.is_frictionless()) => {
                Beyond::Mirrors
            }
            Faces::Walls(_) => Beyond::Ends,
        };
        let [y, z] = match setup.sides {
            Sides::Periodic => [Beyond::Repeats; 2],
            Sides::FreeSlip => [Beyond::Mirrors; 2],
            Sides::Each(faces) => faces.map(across),
        };
        let x = if setup.ends == StreamwiseEnds::Periodic {
            Beyond::Repeats
        } else {
            Beyond::Ends
        };
        let states = (0..nx * ny * nz)
            .into_par_iter()
            .map(|i| initial([i % nx, i / nx % ny, i / nx / ny]))
            .collect();
        Self {
            cells: setup.cells,
            beyond: [x, y, z],
            relaxation_time: setup.relaxation_time,
            states,
            stresses: None,
        }
    }

    /// Begins with a known density excess, velocity and stress of every cell.
    #[must_use]
    pub fn with_stresses(
        setup: &Setup,
        state: impl Fn([usize; 3]) -> (f64, [f64; 3], Stress) + Sync,
    ) -> Self {
        let [nx, ny, nz] = setup.cells;
        let (states, stresses) = (0..nx * ny * nz)
            .into_par_iter()
            .map(|i| {
                let (excess, velocity, stress) = state([i % nx, i / nx % ny, i / nx / ny]);
                ((excess, velocity), stress)
            })
            .unzip();
        Self {
            cells: setup.cells,
            beyond: [Beyond::Ends; 3],
            relaxation_time: setup.relaxation_time,
            states,
            stresses: Some(stresses),
        }
    }

    fn state(&self, [x, y, z]: [usize; 3]) -> (f64, [f64; 3]) {
        self.states[x + self.cells[0] * (y + self.cells[1] * z)]
    }

    /// Density excess of a cell.
    #[must_use]
    pub fn density_excess(&self, cell: [usize; 3]) -> f64 {
        self.state(cell).0
    }

    /// ∂u_b/∂x_a as [a][b]: central differences of fourth order, of second order next to a wall or an open end,
    /// one-sided at it.
    fn velocity_gradient(&self, cell: [usize; 3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|a| {
            let n = self.cells[a];
            // Velocity `distance` cells further along the axis, if it is known.
            let at = |distance: isize| {
                let (place, end) = (cell[a] as isize + distance, n as isize);
                let inside = (0..end).contains(&place);
                let mut neighbour = cell;
                neighbour[a] = match self.beyond[a] {
                    Beyond::Repeats => place.rem_euclid(end),
                    Beyond::Mirrors if place < 0 => (-1 - place).min(end - 1),
                    Beyond::Mirrors if !inside => (2 * end - 1 - place).max(0),
                    Beyond::Ends if !inside => return None,
                    _ => place,
                } as usize;
                let mut velocity = self.state(neighbour).1;
                if self.beyond[a] == Beyond::Mirrors && !inside {
                    velocity[a] = -velocity[a];
                }
                Some(velocity)
            };
            let here = self.state(cell).1;
            std::array::from_fn(|b| match (at(-2), at(-1), at(1), at(2)) {
                (Some(below_2), Some(below), Some(above), Some(above_2)) => {
                    (8.0 * (above[b] - below[b]) - (above_2[b] - below_2[b])) / 12.0
                }
                (_, Some(below), Some(above), _) => (above[b] - below[b]) / 2.0,
                (_, None, Some(above), _) => above[b] - here[b],
                (_, Some(below), None, _) => here[b] - below[b],
                (_, None, None, _) => 0.0,
            })
        })
    }

    /// Shifted population of a cell.
    #[must_use]
    pub fn population(&self, cell: [usize; 3], direction: usize) -> f64 {
        match &self.stresses {
            Some(stresses) => self.with_stress(cell, stresses, direction),
            None => self.with_gradient(cell, &self.velocity_gradient(cell), direction),
        }
    }

    /// All shifted populations of a cell; its velocity gradient is worked out once for all.
    #[must_use]
    pub fn populations(&self, cell: [usize; 3]) -> [f64; DIRECTION_COUNT] {
        if let Some(stresses) = &self.stresses {
            return std::array::from_fn(|direction| self.with_stress(cell, stresses, direction));
        }
        let gradient = self.velocity_gradient(cell);
        std::array::from_fn(|direction| self.with_gradient(cell, &gradient, direction))
    }

    /// f_i = f_i^eq + (9/2) w_i (c_i c_i − I/3) : Π, the regularised population of that stress (Latt & Chopard 2006).
    fn with_stress(&self, cell: [usize; 3], stresses: &[Stress], direction: usize) -> f64 {
        let (density_excess, velocity) = self.state(cell);
        let stress = stresses[cell[0] + self.cells[0] * (cell[1] + self.cells[1] * cell[2])];
        let c = DIRECTIONS[direction].map(f64::from);
        let mut sum = 0.0;
        for (component, [a, b]) in stress.into_iter().zip(STRESS_AXES) {
            let (isotropic, times) = if a == b { (1.0 / 3.0, 1.0) } else { (0.0, 2.0) };
            sum += times * (c[a] * c[b] - isotropic) * f64::from(component);
        }
        equilibrium(direction, density_excess, velocity) + 4.5 * WEIGHTS[direction] * sum
    }

    fn with_gradient(&self, cell: [usize; 3], gradient: &[[f64; 3]; 3], direction: usize) -> f64 {
        let (density_excess, velocity) = self.state(cell);
        let c = DIRECTIONS[direction].map(f64::from);
        let mut strain = 0.0;
        for a in 0..3 {
            for b in 0..3 {
                let isotropic = if a == b { 1.0 / 3.0 } else { 0.0 };
                strain += (c[a] * c[b] - isotropic) * gradient[a][b];
            }
        }
        let density = 1.0 + density_excess;
        equilibrium(direction, density_excess, velocity)
            - 3.0 * WEIGHTS[direction] * density * self.relaxation_time * strain
    }
}

#[cfg(test)]
mod tests {
    use super::super::Operator;
    use super::super::grid::Wall;
    use super::*;

    /// The stress beyond equilibrium is −2/3 ρ τ S for a flow without divergence; density and momentum are untouched.
    #[test]
    fn the_stress_is_that_of_the_strain() {
        let setup = Setup {
            cells: [6, 5, 4],
            ends: StreamwiseEnds::InletOutlet,
            sides: Sides::Each([Faces::Walls([Wall::AT_REST; 2]); 2]),
            relaxation_time: 0.8,
            inlet_profile: None,
            sponge_cells: None,
            idle: None,
            operator: Operator::TwoRelaxationTimes,
            eddy_viscosity: None,
        };
        // Linear, so that differences are exact everywhere.
        let velocity = |[x, y, z]: [usize; 3]| {
            let [x, y, z] = [x as f64, y as f64, z as f64];
            [
                0.01 * x + 0.002 * y,
                -0.004 * y + 0.003 * z,
                -0.006 * z + 0.001 * x,
            ]
        };
        let start = Start::new(&setup, &|cell| (0.02, velocity(cell)));
        for cell in [[0, 0, 0], [2, 2, 1], [5, 4, 3]] {
            let f = start.populations(cell);
            for direction in 0..DIRECTION_COUNT {
                assert!(f[direction] == start.population(cell, direction));
            }
            let c = |i: usize, a: usize| f64::from(DIRECTIONS[i][a]);
            let mass: f64 = f.iter().sum();
            assert!((mass - 0.02).abs() < 1e-15);
            let u = velocity(cell);
            let strain = [
                [0.01, 0.001, 0.0005],
                [0.001, -0.004, 0.0015],
                [0.0005, 0.0015, -0.006],
            ];
            for a in 0..3 {
                let momentum: f64 = (0..DIRECTION_COUNT).map(|i| f[i] * c(i, a)).sum();
                assert!((momentum - 1.02 * u[a]).abs() < 1e-15);
                for b in 0..3 {
                    let stress: f64 = (0..DIRECTION_COUNT)
                        .map(|i| (f[i] + WEIGHTS[i]) * c(i, a) * c(i, b))
                        .sum();
                    let isotropic = if a == b { 1.0 / 3.0 } else { 0.0 };
                    let beyond = stress - 1.02 * (u[a] * u[b] + isotropic);
                    let expected = -2.0 / 3.0 * 1.02 * 0.8 * strain[a][b];
                    assert!(
                        (beyond - expected).abs() < 1e-15,
                        "{a}{b}: {beyond} {expected}"
                    );
                }
            }
        }
    }
}
