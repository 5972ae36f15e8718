//! Populations that enter through the faces of the domain. Through the sides they are copied after each sweep. At inlet and
//! outlet (or from end to end) they are filled in within the sweep, row by row.
//!
//! For cell n and direction d with n − c_d outside:
//! * periodic: what left through the opposite face;
//! * free slip (half-way specular reflection): what left mirrored at the wall midway between cell and ghost;
//! * no slip (half-way bounce-back): what left in the opposite direction, and what a moving wall adds ([`crate::lattice::links`]);
//! * absorbing sides: as free slip, then less what sound takes out ([`crate::lattice::faces`]);
//! * velocity inlet: equilibrium with the inlet's velocity and the density that the leaving populations tell of, but for what sound takes
//!   out and along with it (there, too). To it comes the stress of an inlet profile's shear;
//! * pressure outlet: equilibrium with the density and velocity of the last cell, delayed like an outgoing sound wave; a viscous
//!   sponge before it (see [`super::Setup::sponge_cells`]) damps vortices that leave.
//!
//! Beyond the sides the ghosts of inlet and outlet are mirrored (or repeated).
//!
//! The outlet lets sound pass. The density excess at the ghost is that of the last cell a little earlier, δρ_g = δρ − d (δρ − δρ'). Here
//! δρ' is that of the step before (kept in the ghost's place among the populations at rest) and d = [`OUTLET_DELAY`]. What changes on
//! the way is an outgoing wave. The incoming one, ½ (δρ − u/c_s), which the outlet itself sent, is taken over by
//! u_g = u + c_s cos θ (δρ_g − δρ), cos θ = [`OUTLET_COSINE`].
//! Then the ghost loses a share a = [`OUTLET_RELAXATION`] / (cells between inlet and outlet) of its excess. So the incoming wave adds up
//! −(a/2) δρ per step. That is the relaxation towards the target pressure of a characteristic outlet (L₁ = K δp: Rudy & Strikwerda 1980,
//! doi:10.1016/0021-9991(80)90174-6; Poinsot & Lele 1992, doi:10.1016/0021-9991(92)90046-2). Our departure: only changes of density, not of
//! velocity, count as sound, so that vortices make no pressure. *Limits*: of waves at 45° a tenth comes back.

use rayon::prelude::*;

use super::Fluid;
use super::sides::FAMILIES;
use super::stored::Stored;
use crate::lattice::faces::{
    INLET_IMPEDANCE, INLET_MEANS, InletAnswer, SIDE_FLOW, inlet_tangential, present_share,
};
use crate::lattice::grid::{
    InletProfile, OUTLET_COSINE, OUTLET_DELAY, OUTLET_RELAXATION, ProfileRow,
};
use crate::lattice::operators::bare_moments;
use crate::lattice::{
    DIRECTION_COUNT, DIRECTIONS, DOWNSTREAM, Operator, Real, SOUND_SPEED_SQUARED, WEIGHTS, opposite,
};

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    pub(super) fn apply_boundaries(&mut self) {
        let runs = &self.sides.runs[usize::from(self.odd)];
        let mut arrays = self.populations.arrays_mut();
        let families = FAMILIES.map(|family| {
            let mut members: [&mut [P]; DIRECTION_COUNT] =
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
                            *population = P::packed(population.unpacked() + added);
                        }
                    }
                }
            });
    }
}

impl<T: Real> RowEnds<'_, T> {
    /// Those of a row by its number, y fastest.
    #[inline(always)]
    pub(super) fn of_row(&self, row: usize, relaxation_time: T) -> Self {
        match self {
            Self::InletOutlet(inlet, Some(profile)) => {
                Self::InletOutlet(inlet.at(&profile.rows()[row], relaxation_time), None)
            }
            ends => *ends,
        }
    }
}

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Takes away what sound takes out through the sides, after the copies.
    pub(super) fn absorb_at_sides(&mut self) {
        let (cells, share) = (self.setup.cells, T::of(present_share(self.setup.cells)));
        let (grid, odd) = (self.grid, self.odd);
        let sides = self.absorbing_sides.iter().zip(&mut self.face_means.sides);
        for (side, means) in sides {
            absorb(
                self.populations.arrays_mut(),
                &side.slots(&grid, odd),
                side.row_stride(&grid),
                means,
                cells[0],
                share,
            );
        }
    }
}

/// The work on one side: rows of `nx` cells, `stride` elements apart, with the slots of the five populations that enter the first cell.
fn absorb<T: Real, P: Stored<Real = T>>(
    mut arrays: [&mut [P]; DIRECTION_COUNT],
    slots: &[(usize, usize); 5],
    stride: usize,
    means: &mut [f32],
    nx: usize,
    share: T,
) {
    let [axis, a, b, c, d] =
        slots.map(|(array, first)| std::mem::take(&mut arrays[array]).split_at_mut(first).1);
    let weights = [1.0 / 18.0, 1.0 / 36.0, 1.0 / 36.0, 1.0 / 36.0, 1.0 / 36.0].map(T::of);
    let (flow, sixth) = (T::of(SIDE_FLOW), T::of(1.0 / 6.0));
    means
        .par_chunks_mut(nx)
        .zip(axis.par_chunks_mut(stride))
        .zip(a.par_chunks_mut(stride))
        .zip(b.par_chunks_mut(stride))
        .zip(c.par_chunks_mut(stride))
        .zip(d.par_chunks_mut(stride))
        .with_min_len(ROWS_PER_TASK)
        .for_each_init(
            || [(); 5].map(|()| vec![T::default(); nx]),
            |rows, (((((means, axis), a), b), c), d)| {
                let mut kept = [axis, a, b, c, d].map(|row| &mut row[..nx]);
                for (row, kept) in rows.iter_mut().zip(&kept) {
                    P::unpack(kept, row);
                }
                for (x, mean) in means.iter_mut().enumerate() {
                    let past = T::of(f64::from(*mean));
                    let met = (rows[0][x] + rows[1][x]) + (rows[2][x] + rows[3][x]) + rows[4][x];
                    let over_mean = met - past;
                    *mean = (past + share * over_mean).to_f64() as f32;
                    let taken = flow * over_mean / (sixth + met);
                    for k in 0..5 {
                        rows[k][x] = rows[k][x] - taken * (rows[k][x] + weights[k]);
                    }
                }
                for (row, kept) in rows.iter().zip(&mut kept) {
                    P::pack(row, kept);
                }
            },
        );
}

/// Rows of a side that one task works on at least: shorter ones cost more to hand out than to do.
const ROWS_PER_TASK: usize = 16;

/// The inlet in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inlet<T> {
    velocity: [T; 3],
    wave: T,
    of_wind: T,
    /// Share of the present that a running mean takes.
    share: T,
    /// Share of the first cell's tangential momentum over its mean that the ghost has.
    along: T,
    /// 3(1 − τ) times the rates of change of the wind along y and z: what is beyond equilibrium after a collision.
    shear: [T; 2],
}

impl<T: Real> Inlet<T> {
    pub(super) fn new(velocity: [f64; 3], cells: [usize; 3], operator: Operator) -> Self {
        let answer = InletAnswer::new(velocity[0]);
        Self {
            velocity: velocity.map(T::of),
            wave: T::of(answer.wave),
            of_wind: T::of(answer.of_wind),
            share: T::of(present_share(cells)),
            along: T::of(inlet_tangential(operator)),
            shear: [T::default(); 2],
        }
    }

    /// The same at a row of a profile.
    fn at(&self, row: &ProfileRow, relaxation_time: T) -> Self {
        let velocity = self.velocity.map(|u| u * T::of(row.ratio));
        let answer = InletAnswer::new(velocity[0].to_f64());
        let of_rate = T::of(3.0) * (T::of(1.0) - relaxation_time) * self.velocity[0];
        Self {
            velocity,
            shear: row.shear.map(|rate| of_rate * T::of(rate)),
            wave: T::of(answer.wave),
            of_wind: T::of(answer.of_wind),
            ..*self
        }
    }

    /// What `now` is over a running mean, which it then is taken into.
    #[inline(always)]
    fn over_mean(&self, now: T, mean: &mut f32) -> (T, T) {
        let past = T::of(f64::from(*mean));
        let over = now - past;
        *mean = (past + self.share * over).to_f64() as f32;
        (past, over)
    }

    /// Density and velocity of the ghost, from the populations that leave, along the normal first, the momentum of the first cell, and the
    /// running means.
    #[inline(always)]
    fn ghost(
        &self,
        leaving: [T; 5],
        momentum: [T; 3],
        means: &mut [f32; INLET_MEANS],
    ) -> (T, [T; 3]) {
        let [x, xy, xz, x_y, x_z] = leaving;
        let met = x + ((xy + x_y) + (xz + x_z));
        let [of_density, of_y, of_z] = means;
        let (past, over) = self.over_mean(T::of(6.0) * met + self.of_wind, of_density);
        let wave = self.wave * over;
        let (_, along_y) = self.over_mean(momentum[1], of_y);
        let (_, along_z) = self.over_mean(momentum[2], of_z);
        let [u, v, w] = self.velocity;
        let velocity = [
            u - T::of(INLET_IMPEDANCE) * wave,
            v + self.along * along_y,
            w + self.along * along_z,
        ];
        (past + wave, velocity)
    }
}

/// What lies at both ends of a row.
#[derive(Debug, Clone, Copy)]
pub(super) enum RowEnds<'a, T> {
    /// The row repeats.
    Periodic,
    /// Inlet and outlet, and the inlet's profile.
    InletOutlet(Inlet<T>, Option<&'a InletProfile>),
    /// Walls: among the copies.
    Walls,
}

/// Fills in what enters a row through its ends, right after the row was collided, while it is in the cache. `arrays` are the slab's, by
/// direction read in this step, and the row's cells are the elements `start..start + nx`. Ghost cells stream like any cell: f_i goes
/// to the slot shifted by c_i, here seen from cell −1, and f_{i+1} to the local one.
#[inline(always)]
pub(super) fn fill_row_ends<T: Real, P: Stored<Real = T>>(
    arrays: &mut [&mut [P]; DIRECTION_COUNT],
    start: usize,
    nx: usize,
    ends: &RowEnds<'_, T>,
    inlet_means: Option<&mut [f32; INLET_MEANS]>,
) {
    let inlet = match ends {
        RowEnds::Walls => return,
        RowEnds::Periodic => {
            for direction in DOWNSTREAM {
                arrays[direction + 1][start - 1] = arrays[direction + 1][start + nx - 1];
                arrays[direction][start + nx] = arrays[direction][start];
            }
            return;
        }
        RowEnds::InletOutlet(inlet, _) => inlet,
    };
    let Some(inlet_means) = inlet_means else {
        return;
    };
    // The momentum after the collision is what a streaming cell carries.
    let state = |x: usize| {
        let mut f = [T::default(); DIRECTION_COUNT];
        for direction in 0..DIRECTION_COUNT {
            f[direction] = arrays[opposite(direction)][start + x].unpacked();
        }
        bare_moments(&f)
    };
    let (_, first_momentum) = state(0);
    let (excess, momentum) = state(nx - 1);
    let inverse_density = T::of(1.0) / (T::of(1.0) + excess);
    let [u, v, w] = momentum.map(|j| j * inverse_density);
    let late = -(T::of(OUTLET_DELAY) * (excess - arrays[0][start + nx].unpacked()));
    arrays[0][start + nx] = P::packed(excess);
    let outlet_excess = T::of(1.0 - OUTLET_RELAXATION / nx as f64) * (excess + late);
    let outlet_velocity = [
        u + T::of(OUTLET_COSINE * SOUND_SPEED_SQUARED.sqrt()) * late,
        v,
        w,
    ];
    let leaving = DOWNSTREAM.map(|direction| arrays[direction][start].unpacked());
    let (inlet_excess, inlet_velocity) = inlet.ghost(leaving, first_momentum, inlet_means);
    for direction in DOWNSTREAM {
        let [_, y, z] = DIRECTIONS[direction].map(|c| T::of(f64::from(c)));
        let sheared = T::of(WEIGHTS[direction]) * (y * inlet.shear[0] + z * inlet.shear[1]);
        let entering = shifted_equilibrium(direction, inlet_excess, &inlet_velocity) + sheared;
        arrays[direction + 1][start - 1] = P::packed(entering);
        let entering = shifted_equilibrium(direction + 1, outlet_excess, &outlet_velocity);
        arrays[direction][start + nx] = P::packed(entering);
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

#[cfg(test)]
mod tests {
    use half::f16;

    use super::*;

    fn slices<P>(arrays: &mut [Vec<P>]) -> [&mut [P]; DIRECTION_COUNT] {
        let mut arrays = arrays.iter_mut();
        std::array::from_fn(|_| arrays.next().map(|a| &mut a[..]).unwrap_or_default())
    }

    /// In 16 bits a side takes out the same, rounded once; what lies between its rows stays.
    #[test]
    fn sides_absorb_in_sixteen_bits_what_they_do_in_single_precision() {
        let (nx, stride, rows, first) = (37, 41, 3, 2);
        let slots = [1, 4, 6, 9, 12].map(|array| (array, first));
        let before: Vec<Vec<f16>> = (0..DIRECTION_COUNT)
            .map(|d| {
                (0..first + rows * stride)
                    .map(|i| f16::packed(((d * 7 + i * 3) % 50) as f32 * 1e-3 - 0.02))
                    .collect()
            })
            .collect();
        let mut kept = before.clone();
        let mut values: Vec<Vec<f32>> = before
            .iter()
            .map(|array| array.iter().map(|kept| kept.unpacked()).collect())
            .collect();
        let mut means = [vec![0.01_f32; rows * nx], vec![0.01; rows * nx]];
        absorb(slices(&mut kept), &slots, stride, &mut means[0], nx, 0.1);
        absorb(slices(&mut values), &slots, stride, &mut means[1], nx, 0.1);
        assert_eq!(means[0], means[1]);
        for array in 0..DIRECTION_COUNT {
            let of_side = slots.iter().any(|(own, _)| *own == array);
            for (i, now) in kept[array].iter().enumerate() {
                let in_row = i >= first && (i - first) % stride < nx;
                let expected = match of_side && in_row {
                    true => f16::packed(values[array][i]),
                    false => before[array][i],
                };
                assert_eq!(*now, expected, "{array}, {i}");
            }
            assert_eq!(kept[array] != before[array], of_side, "{array}");
        }
    }
}
