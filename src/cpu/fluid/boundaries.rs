//! Populations that enter through the faces of the domain: through the sides they are copied after each sweep, at inlet and
//! outlet ghost cells stream them within the sweep.
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

use super::Fluid;
use crate::lattice::grid::{OUTLET_DELAY, OUTLET_RELAXATION};
use crate::lattice::operators::bare_moments;
use crate::lattice::{
    DIRECTION_COUNT, DIRECTIONS, DOWNSTREAM, Real, SOUND_SPEED_SQUARED, WEIGHTS, opposite,
};

impl<T: Real> Fluid<T> {
    pub(super) fn apply_boundaries(&mut self) {
        for run in &self.boundaries.copies[usize::from(self.odd)] {
            let (to, from, length) = (run.to as usize, run.from as usize, run.length as usize);
            let (to_array, from_array) = (usize::from(run.to_array), usize::from(run.from_array));
            match self.populations.get_disjoint_mut([to_array, from_array]) {
                Ok([target, origin]) => {
                    target[to..to + length].copy_from_slice(&origin[from..from + length])
                }
                Err(_) => self.populations[to_array].copy_within(from..from + length, to),
            }
            if run.added != 0.0 {
                let added = T::of(run.added);
                for population in &mut self.populations[to_array][to..to + length] {
                    *population += added;
                }
            }
        }
    }
}

/// The ghost cells at both ends of a row: they are at equilibrium and stream like any cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowEnds<T> {
    inlet_density_excess: T,
    inlet_velocity: [T; 3],
    /// Of the last cell.
    last_density_excess: T,
    last_velocity: [T; 3],
}

impl<T: Real> RowEnds<T> {
    /// Reads what they take from their neighbours off a row just collided, while it is in the cache; the momentum after the collision
    /// is what a streaming cell carries.
    #[inline(always)]
    pub(super) fn read(rows: &[&mut [T]; DIRECTION_COUNT], inlet_velocity: [T; 3]) -> Self {
        let nx = rows[0].len();
        let (inlet, last) = (1.min(nx - 1), nx - 1);
        let mut states = [[T::default(); DIRECTION_COUNT]; 2];
        for direction in 0..DIRECTION_COUNT {
            states[0][direction] = rows[opposite(direction)][inlet];
            states[1][direction] = rows[opposite(direction)][last];
        }
        let (inlet_density_excess, _) = bare_moments(&states[0]);
        let (excess, momentum) = bare_moments(&states[1]);
        let inverse_density = T::of(1.0) / (T::of(1.0) + excess);
        Self {
            inlet_density_excess,
            inlet_velocity,
            last_density_excess: excess,
            last_velocity: momentum.map(|j| j * inverse_density),
        }
    }

    /// Density excess and velocity of the outlet's ghost; `before` is the density excess of the last cell a step ago.
    #[inline(always)]
    fn outlet(&self, before: T, nx: usize) -> (T, [T; 3]) {
        let sound = T::of(SOUND_SPEED_SQUARED.sqrt());
        let change = self.last_density_excess - before;
        let late = -(T::of(OUTLET_DELAY) * change);
        let [u, v, w] = self.last_velocity;
        let kept = T::of(1.0 - OUTLET_RELAXATION / nx as f64);
        (
            kept * (self.last_density_excess + late),
            [u + sound * late, v, w],
        )
    }

    /// Streams their populations into the domain: `arrays` are the slab's, by direction read in this step, and the row's cells
    /// are the elements `start..start + nx`.
    #[inline(always)]
    pub(super) fn write(&self, arrays: &mut [&mut [T]; DIRECTION_COUNT], start: usize, nx: usize) {
        let (outlet_density_excess, outlet_velocity) = self.outlet(arrays[0][start + nx], nx);
        arrays[0][start + nx] = self.last_density_excess;
        for direction in DOWNSTREAM {
            // As for any cell, f_i goes to the slot shifted by c_i, here seen from cell −1, and f_{i+1} to the local one.
            arrays[direction + 1][start - 1] =
                shifted_equilibrium(direction, self.inlet_density_excess, &self.inlet_velocity);
            arrays[direction][start + nx] =
                shifted_equilibrium(direction + 1, outlet_density_excess, &outlet_velocity);
        }
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
