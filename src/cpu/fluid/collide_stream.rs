//! Stage `collide_stream`: one in-place step of the whole grid.
//!
//! f*(x, t) = C(f(x, t), F), f_i(x + c_i, t + 1) = f*_i(x, t). The operator C is chosen at run time, its forced variant
//! only for rows that hold cells touched by markers (or under a uniform acceleration); see [`super`] for the slots.

use rayon::prelude::*;

use super::Fluid;
use super::boundaries::RowEnds;
use crate::lattice::Operator;
use crate::lattice::grid::{Grid, StreamwiseEnds};
use crate::lattice::operators::{self, Local, Populations};
use crate::lattice::{DIRECTION_COUNT, Real, opposite};

/// Cells handled at once; the compiler turns loops of this width into vector instructions.
const LANES: usize = 8;

/// Slabs of planes per thread, to balance the load of rows with and without force.
const SLABS_PER_THREAD: usize = 4;

/// Body force of one step, in lattice units (force per cell).
#[derive(Debug, Clone, Copy, Default)]
pub struct BodyForce<'a> {
    /// Uniform acceleration of every cell, e.g. while a wind tunnel starts.
    pub acceleration: Option<[f64; 3]>,
    /// Cells that carry a force of their own, ordered by array row, then x.
    pub cells: ForcedCells<'a>,
}

/// A sparse force field: only rows that hold touched cells appear.
#[derive(Debug, Clone, Copy, Default)]
pub struct ForcedCells<'a> {
    /// (row = y + z · ny, first entry, end of entries), ascending rows.
    pub rows: &'a [(u32, u32, u32)],
    /// x of every entry.
    pub x: &'a [u32],
    /// Force of every entry.
    pub force: &'a [[f64; 3]],
}

trait Collision<T: Real> {
    fn collide<const FORCED: bool>(f: &Populations<T>, local: &Local<T>) -> Populations<T>;
}

struct TwoRelaxationTimes<const EDDY: bool>;

impl<T: Real, const EDDY: bool> Collision<T> for TwoRelaxationTimes<EDDY> {
    #[inline(always)]
    fn collide<const FORCED: bool>(f: &Populations<T>, local: &Local<T>) -> Populations<T> {
        operators::two_relaxation_times::<T, FORCED, EDDY>(f, local)
    }
}

struct RecursiveRegularised<const EDDY: bool>;

impl<T: Real, const EDDY: bool> Collision<T> for RecursiveRegularised<EDDY> {
    #[inline(always)]
    fn collide<const FORCED: bool>(f: &Populations<T>, local: &Local<T>) -> Populations<T> {
        operators::recursive_regularised::<T, FORCED, EDDY>(f, local)
    }
}

/// What all rows of a step share.
struct Common<'a, T> {
    relaxation_time: T,
    relaxation_profile: Option<&'a [T]>,
    eddy_factor: T,
    /// Velocity at the inlet; `None` in periodic scenes.
    inlet_velocity: Option<[T; 3]>,
}

impl<T: Real> Fluid<T> {
    /// Advances the air by one step under `body_force`, then fills in what enters through the faces, so that all moments are whole.
    pub fn collide_stream(&mut self, body_force: &BodyForce) {
        let eddy = self.setup.smagorinsky_constant.is_some();
        match (self.setup.operator, eddy) {
            (Operator::TwoRelaxationTimes, false) => {
                self.sweep::<TwoRelaxationTimes<false>>(body_force)
            }
            (Operator::TwoRelaxationTimes, true) => {
                self.sweep::<TwoRelaxationTimes<true>>(body_force)
            }
            (Operator::RecursiveRegularised, false) => {
                self.sweep::<RecursiveRegularised<false>>(body_force)
            }
            (Operator::RecursiveRegularised, true) => {
                self.sweep::<RecursiveRegularised<true>>(body_force)
            }
        }
        self.odd = !self.odd;
        self.steps += 1;
        self.apply_boundaries();
    }

    fn sweep<C: Collision<T>>(&mut self, body_force: &BodyForce) {
        let nz = self.setup.cells[2];
        let grid = self.grid;
        let odd = self.odd;
        let smagorinsky = self.setup.smagorinsky_constant.unwrap_or(0.0);
        let common = Common {
            relaxation_time: T::of(self.setup.relaxation_time),
            relaxation_profile: self.relaxation_profile.as_deref(),
            eddy_factor: T::of(operators::eddy_factor(smagorinsky)),
            inlet_velocity: (self.setup.ends == StreamwiseEnds::InletOutlet)
                .then(|| self.inlet_velocity.map(T::of)),
        };
        let planes = nz
            .div_ceil(SLABS_PER_THREAD * rayon::current_num_threads())
            .max(1);
        let slab_count = nz.div_ceil(planes);
        let mut slabs: Vec<Slab<T>> = (0..slab_count)
            .map(|s| Slab {
                first_plane: s * planes,
                planes: planes.min(nz - s * planes),
                arrays: std::array::from_fn(|_| Default::default()),
            })
            .collect();
        for (array, data) in self.populations.iter_mut().enumerate() {
            // The direction that reads this array in this step: 'local' slots are read by the first of a pair.
            let direction = if array == 0 || odd {
                array
            } else {
                opposite(array)
            };
            let shift = if direction % 2 == 0 && direction > 0 {
                grid.pair_shifts()[direction / 2 - 1]
            } else {
                0
            };
            // One element earlier, so that the ghost cells at both ends of a row lie in its slab.
            let first = (grid.index([0, 0, 0]) - 1).wrapping_add_signed(shift);
            let mut rest = data.split_at_mut(first).1;
            for slab in &mut slabs {
                let length = (slab.planes * grid.stride_z).min(rest.len());
                let (head, tail) = rest.split_at_mut(length);
                slab.arrays[direction] = head;
                rest = tail;
            }
        }
        slabs.into_par_iter().for_each(|mut slab| {
            vectorised(
                #[inline(always)]
                || sweep_slab::<T, C>(&grid, &mut slab, body_force, &common),
            );
        });
    }
}

/// Calls `work` compiled for AVX2 where the CPU has it: twice the lanes of the baseline, the same bits (no fused operations).
/// AVX-512 is left alone: the same loops compiled for it were measured three times slower.
#[inline(always)]
fn vectorised(work: impl FnOnce()) {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        avx2.vectorize(work);
        return;
    }
    work();
}

#[inline(always)]
fn sweep_slab<T: Real, C: Collision<T>>(
    grid: &Grid,
    slab: &mut Slab<T>,
    body_force: &BodyForce,
    common: &Common<T>,
) {
    let [nx, ny, _] = grid.cells;
    let first_row = (slab.first_plane * ny) as u32;
    let forced = body_force.cells;
    let mut next = forced.rows.partition_point(|row| row.0 < first_row);
    let acceleration = body_force.acceleration.map(|a| a.map(T::of));
    let mut force = [const { Vec::new() }; 3];
    for plane in 0..slab.planes {
        for y in 0..ny {
            let row = ((slab.first_plane + plane) * ny + y) as u32;
            let here = forced.rows.get(next).filter(|entry| entry.0 == row);
            let start = plane * grid.stride_z + y * grid.stride_y + 1;
            let mut rows = slab
                .arrays
                .each_mut()
                .map(|array| &mut array[start..start + nx]);
            if here.is_none() && acceleration.is_none() {
                collide_row::<T, C, false>(&mut rows, common, None);
                if let Some(inlet) = common.inlet_velocity {
                    RowEnds::read(&rows, inlet).write(&mut slab.arrays, start, nx);
                }
                continue;
            }
            for (a, component) in force.iter_mut().enumerate() {
                component.clear();
                component.resize(nx, acceleration.map_or(T::default(), |g| g[a]));
            }
            if let Some(&(_, first, end)) = here {
                next += 1;
                for entry in first as usize..end as usize {
                    let x = forced.x[entry] as usize;
                    for (a, component) in force.iter_mut().enumerate() {
                        component[x] += T::of(forced.force[entry][a]);
                    }
                }
            }
            collide_row::<T, C, true>(&mut rows, common, Some(&force));
            if let Some(inlet) = common.inlet_velocity {
                RowEnds::read(&rows, inlet).write(&mut slab.arrays, start, nx);
            }
        }
    }
}

/// A run of planes with, per direction, the part of its array that these planes touch.
struct Slab<'a, T> {
    first_plane: usize,
    planes: usize,
    arrays: [&'a mut [T]; DIRECTION_COUNT],
}

#[inline(always)]
fn collide_row<T: Real, C: Collision<T>, const FORCED: bool>(
    rows: &mut [&mut [T]; DIRECTION_COUNT],
    common: &Common<T>,
    force: Option<&[Vec<T>; 3]>,
) {
    let nx = rows[0].len();
    let mut x = 0;
    while x < nx {
        let count = LANES.min(nx - x);
        let mut block = [[T::default(); LANES]; DIRECTION_COUNT];
        let mut tau = [common.relaxation_time; LANES];
        let mut body = [[T::default(); LANES]; 3];
        for direction in 0..DIRECTION_COUNT {
            load(&mut block[direction], &rows[direction][x..]);
        }
        if let Some(profile) = common.relaxation_profile {
            load(&mut tau, &profile[x..]);
        }
        if FORCED && let Some(force) = force {
            for a in 0..3 {
                load(&mut body[a], &force[a][x..]);
            }
        }
        collide_block::<T, C, FORCED>(&mut block, &tau, &body, common.eddy_factor);
        for direction in 0..DIRECTION_COUNT {
            let target = &mut rows[opposite(direction)][x..x + count];
            match target.first_chunk_mut::<LANES>() {
                Some(chunk) => *chunk = block[direction],
                None => target.copy_from_slice(&block[direction][..count]),
            }
        }
        x += count;
    }
}

/// Fills the lanes from the start of `source`, as far as it reaches.
#[inline(always)]
fn load<T: Copy>(lanes: &mut [T; LANES], source: &[T]) {
    match source.first_chunk::<LANES>() {
        Some(chunk) => *lanes = *chunk,
        None => lanes[..source.len()].copy_from_slice(source),
    }
}

#[inline(always)]
fn collide_block<T: Real, C: Collision<T>, const FORCED: bool>(
    block: &mut [[T; LANES]; DIRECTION_COUNT],
    tau: &[T; LANES],
    body: &[[T; LANES]; 3],
    eddy_factor: T,
) {
    for lane in 0..LANES {
        let f: Populations<T> = std::array::from_fn(|direction| block[direction][lane]);
        let local = Local {
            relaxation_time: tau[lane],
            force: [body[0][lane], body[1][lane], body[2][lane]],
            eddy_factor,
        };
        let out = C::collide::<FORCED>(&f, &local);
        for direction in 0..DIRECTION_COUNT {
            block[direction][lane] = out[direction];
        }
    }
}
