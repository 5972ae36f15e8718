//! Density and velocity read back from the populations.

use rayon::prelude::*;

use super::{Fluid, Stored};
use crate::lattice::Real;
use crate::lattice::operators::bare_moments;
use crate::lattice::start::{Stress, add_to_stress, less_equilibrium};

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Density excess δρ and *bare* velocity u* = Σ f c / ρ (no F/2) of one cell, as the next collision will find it.
    #[must_use]
    pub fn bare_state(&self, cell: [usize; 3]) -> (f64, [f64; 3]) {
        let (density_excess, momentum) = bare_moments(&self.gather(cell));
        let density_excess = density_excess.to_f64();
        (
            density_excess,
            momentum.map(|j| j.to_f64() / (1.0 + density_excess)),
        )
    }

    /// Density excess and bare velocity of every cell, x fastest, `[cell_count]`.
    #[must_use]
    pub fn macroscopic(&self) -> Vec<(f32, [f32; 3])> {
        let [nx, ny, nz] = self.setup.cells;
        (0..ny * nz)
            .into_par_iter()
            .flat_map_iter(|row| (0..nx).map(move |x| [x, row % ny, row / ny]))
            .map(|cell| {
                let (density_excess, velocity) = self.bare_state(cell);
                (density_excess as f32, velocity.map(|u| u as f32))
            })
            .collect()
    }

    /// Stress of every cell beyond equilibrium, x fastest.
    #[must_use]
    pub fn stresses(&self) -> Vec<Stress> {
        let [nx, ny, nz] = self.setup.cells;
        (0..ny * nz)
            .into_par_iter()
            .flat_map_iter(|row| (0..nx).map(move |x| [x, row % ny, row / ny]))
            .map(|cell| {
                let populations = self.gather(cell);
                let mut stress = Stress::default();
                for (direction, population) in populations.into_iter().enumerate() {
                    add_to_stress(&mut stress, direction, population.to_f64() as f32);
                }
                let (density_excess, velocity) = self.bare_state(cell);
                less_equilibrium(&mut stress, density_excess, velocity);
                stress
            })
            .collect()
    }

    /// Total mass excess Σ δρ and kinetic energy Σ ½ ρ u² of all cells; the same bits for any number of threads.
    #[must_use]
    pub fn mass_and_energy(&self) -> (f64, f64) {
        let [nx, ny, nz] = self.setup.cells;
        let rows: Vec<(f64, f64)> = (0..ny * nz)
            .into_par_iter()
            .map(|row| {
                let mut sum = (0.0, 0.0);
                for x in 0..nx {
                    let (density_excess, u) = self.bare_state([x, row % ny, row / ny]);
                    sum.0 += density_excess;
                    sum.1 +=
                        0.5 * (1.0 + density_excess) * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
                }
                sum
            })
            .collect();
        rows.iter()
            .fold((0.0, 0.0), |total, row| (total.0 + row.0, total.1 + row.1))
    }
}
