//! Populations that enter through the faces of the domain: through the sides they are copied after each sweep, at inlet and
//! outlet (or from end to end) they are filled in within the sweep, row by row.
//!
//! For cell n and direction d with n − c_d outside:
//! * periodic: what left through the opposite face;
//! * free slip (half-way specular reflection): what left mirrored at the wall midway between cell and ghost;
//! * no slip (half-way bounce-back): what left in the opposite direction, and what a moving wall adds ([`crate::lattice::links`]);
//! * velocity inlet: equilibrium with the inlet's velocity and the density of the second cell (zero pressure gradient), both as after the
//!   collision of the step, like every cell that streams;
//! * pressure outlet: equilibrium with the density and velocity of the last cell, delayed like an outgoing sound wave; a viscous
//!   sponge before it (see [`super::Setup::sponge_cells`]) damps vortices that leave.
//!
//! Beyond the sides the ghosts of inlet and outlet are mirrored (or repeated).
//!
//! The outlet lets sound pass. The density excess at the ghost is that of the last cell a little earlier, δρ_g = δρ − d (δρ − δρ'), where
//! δρ' is that of the step before (kept in the ghost's place among the populations at rest) and d = [`OUTLET_DELAY`]. What changes on
//! the way is an outgoing wave: the incoming one, ½ (δρ − u/c_s), which the outlet itself sent, is taken over by u_g = u + c_s (δρ_g − δρ).
//! Then the ghost loses a share a = [`OUTLET_RELAXATION`] / (cells between inlet and outlet) of its excess, so that the incoming wave adds
//! up −(a/2) δρ per step: the relaxation towards the target pressure of a characteristic outlet (L₁ = K δp: Rudy & Strikwerda 1980,
//! doi:10.1016/0021-9991(80)90174-6; Poinsot & Lele 1992, doi:10.1016/0021-9991(92)90046-2). Our departure: only changes of density, not of
//! velocity, count as sound, so that vortices make no pressure. *Limits*: waves that meet the outlet at an angle are reflected in
//! part, and an inlet of given velocity reflects most of a wave.

use rayon::prelude::*;

use super::Fluid;
use super::sides::FAMILIES;
use crate::lattice::grid::{OUTLET_DELAY, OUTLET_RELAXATION};
use crate::lattice::operators::bare_moments;
use crate::lattice::{
    DIRECTION_COUNT, DIRECTIONS, DOWNSTREAM, Real, SOUND_SPEED_SQUARED, WEIGHTS, opposite,
};

impl<T: Real> Fluid<T> {
    pub(super) fn apply_boundaries(&mut self) {
        let runs = &self.sides.runs[usize::from(self.odd)];
        let mut arrays = self.populations.arrays_mut();
        let families = FAMILIES.map(|family| {
            let mut members: [&mut [T]; DIRECTION_COUNT] =
                std::array::from_fn(|_| Default::default());
            for &array in family {
                members[array] = std::mem::take(&mut arrays[array]);
            }
            members
        });
        families
            .into_par_iter()
            .zip(runs.par_iter())
            .for_each(|(mut arrays, runs)| {
                for run in runs {
                    let (to, from) = (run.to as usize, run.from as usize);
                    let length = run.length as usize;
                    let pair = [usize::from(run.to_array), usize::from(run.from_array)];
                    match arrays.get_disjoint_mut(pair) {
                        Ok([target, origin]) => {
                            target[to..to + length].copy_from_slice(&origin[from..from + length]);
                        }
                        Err(_) => arrays[pair[0]].copy_within(from..from + length, to),
                    }
                    if run.added != 0.0 {
                        let added = T::of(run.added);
                        for population in &mut arrays[pair[0]][to..to + length] {
                            *population += added;
                        }
                    }
                }
            });
    }
}

/// What lies at both ends of a row.
#[derive(Debug, Clone, Copy)]
pub(super) enum RowEnds<T> {
    /// The row repeats.
    Periodic,
    /// Inlet, with its velocity, and outlet.
    InletOutlet([T; 3]),
    /// Walls: among the copies.
    Walls,
}

/// Fills in what enters a row through its ends, right after the row was collided, while it is in the cache. `arrays` are the slab's, by
/// direction read in this step, and the row's cells are the elements `start..start + nx`. Ghost cells stream like any cell: f_i goes
/// to the slot shifted by c_i, here seen from cell −1, and f_{i+1} to the local one.
#[inline(always)]
pub(super) fn fill_row_ends<T: Real>(
    arrays: &mut [&mut [T]; DIRECTION_COUNT],
    start: usize,
    nx: usize,
    ends: &RowEnds<T>,
) {
    let inlet_velocity = match ends {
        RowEnds::Walls => return,
        RowEnds::Periodic => {
            for direction in DOWNSTREAM {
                arrays[direction + 1][start - 1] = arrays[direction + 1][start + nx - 1];
                arrays[direction][start + nx] = arrays[direction][start];
            }
            return;
        }
        RowEnds::InletOutlet(inlet_velocity) => inlet_velocity,
    };
    // The momentum after the collision is what a streaming cell carries.
    let state = |x: usize| {
        let mut f = [T::default(); DIRECTION_COUNT];
        for direction in 0..DIRECTION_COUNT {
            f[direction] = arrays[opposite(direction)][start + x];
        }
        bare_moments(&f)
    };
    let (inlet_excess, _) = state(1.min(nx - 1));
    let (excess, momentum) = state(nx - 1);
    let inverse_density = T::of(1.0) / (T::of(1.0) + excess);
    let [u, v, w] = momentum.map(|j| j * inverse_density);
    let late = -(T::of(OUTLET_DELAY) * (excess - arrays[0][start + nx]));
    arrays[0][start + nx] = excess;
    let outlet_excess = T::of(1.0 - OUTLET_RELAXATION / nx as f64) * (excess + late);
    let outlet_velocity = [u + T::of(SOUND_SPEED_SQUARED.sqrt()) * late, v, w];
    for direction in DOWNSTREAM {
        arrays[direction + 1][start - 1] =
            shifted_equilibrium(direction, inlet_excess, inlet_velocity);
        arrays[direction][start + nx] =
            shifted_equilibrium(direction + 1, outlet_excess, &outlet_velocity);
    }
}

#[inline(always)]
fn shifted_equilibrium<T: Real>(direction: usize, density_excess: T, u: &[T; 3]) -> T {
    let c = DIRECTIONS[direction].map(|c| T::of(f64::from(c)));
    let weight = T::of(WEIGHTS[direction]);
    let density = T::of(1.0) + density_excess;
    let along = c[0] * u[0] + c[1] * u[1] + c[2] * u[2];
    let square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    weight
        * (density_excess
            + density * (T::of(3.0) * along + T::of(4.5) * along * along - T::of(1.5) * square))
}
