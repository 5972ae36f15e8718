//! Stage `collide_stream`: one in-place step of the whole grid.
//!
//! f*(x, t) = C(f(x, t), F), f_i(x + c_i, t + 1) = f*_i(x, t). The operator C is chosen at run time, its forced variant
//! only for cache lines of cells that markers touch (or under a uniform acceleration); see [`super`] for the slots. The vector
//! instructions of the CPU are chosen at run time. AVX2 and AVX-512 give the same bits; a CPU without fused multiply-add rounds products by
//! themselves and gives others. `benches/README.md` tells what bounds the speed.

use std::marker::PhantomData;
use std::ops::Range;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::boundaries::{Inlet, RowEnds, fill_row_ends};
use super::exchanged_ends::EndsOfSlab;
use super::prefetch::prefetch;
use super::slabs::{self, Arrays};
use super::{Fluid, Stored};
use crate::lattice::collision::{Collision, PerOperator};
use crate::lattice::faces::INLET_MEANS;
use crate::lattice::grid::{Grid, InletProfile, LINE_BYTES, StreamwiseEnds};
use crate::lattice::nest::IdleCells;
use crate::lattice::operators::{self, Local};
use crate::lattice::{DIRECTION_COUNT, Lanes, Real, opposite};

/// Slabs of planes per thread, to balance the load of rows with and without force.
const SLABS_PER_THREAD: usize = 4;

/// Body force of one step, in lattice units (force per cell).
#[derive(Debug, Clone, Copy, Default)]
pub struct BodyForce<'a> {
    /// Uniform acceleration of every cell, e.g. while a wind tunnel starts; times the ratio of its row where the inlet has a profile.
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

/// What all rows of a step share.
#[derive(Clone, Copy)]
struct Common<'a, T> {
    relaxation_time: T,
    /// Relaxation time of every cell of a row, to the end of its last block.
    relaxation_times: &'a [T],
    /// First block in which they are not all `relaxation_time`: of the sponge, or of a row that has its own from the eddy viscosity.
    own_from: usize,
    eddy_factor: T,
    /// What the stage `eddy_viscosity` adds to the relaxation time of every cell, x fastest; `None` without that stage.
    held: Option<&'a [T]>,
    ends: RowEnds<'a, T>,
}

/// The sweep of a step, for whichever operator.
struct Sweep<'a, 'f, P: Stored> {
    fluid: &'a mut Fluid<P>,
    body_force: &'a BodyForce<'f>,
}

impl<P: Stored> PerOperator for Sweep<'_, '_, P> {
    fn run<C: Collision>(self) {
        self.fluid.sweep::<C>(self.body_force);
    }
}

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Advances the air by one step under `body_force`, then fills in what enters through the faces, so that all moments are whole. Begins
    /// with the stage `eddy_viscosity` where it is due and the caller has left it out.
    pub fn collide_stream(&mut self, body_force: &BodyForce) {
        self.eddy_viscosity();
        self.last_acceleration = body_force.acceleration.unwrap_or_default();
        let eddy = self.smagorinsky_constant().is_some();
        let operator = self.setup.operator;
        operator.with(
            eddy,
            Sweep {
                fluid: self,
                body_force,
            },
        );
        if let Some(ends) = &mut self.exchanged_ends {
            ends.stepped(self.odd);
        }
        self.odd = !self.odd;
        self.steps += 1;
        self.apply_boundaries();
        self.absorb_at_sides();
    }

    pub(super) fn smagorinsky_constant(&self) -> Option<f64> {
        self.setup.eddy_viscosity?.smagorinsky_constant()
    }

    fn sweep<C: Collision>(&mut self, body_force: &BodyForce) {
        let nz = self.setup.cells[2];
        let grid = self.grid;
        let odd = self.odd;
        let instructions = self.instructions;
        let smagorinsky = self.smagorinsky_constant().unwrap_or(0.0);
        let relaxation_time = T::of(self.setup.relaxation_time);
        let block = LINE_BYTES / size_of::<P>();
        let common = Common {
            relaxation_time,
            relaxation_times: &self.relaxation_times,
            own_from: (self.relaxation_times).partition_point(|tau| *tau <= relaxation_time)
                / block
                * block,
            eddy_factor: T::of(operators::eddy_factor(smagorinsky)),
            held: self
                .held_eddy_viscosity
                .as_ref()
                .map(|held| held.relaxation_times.as_slice()),
            ends: match self.setup.ends {
                StreamwiseEnds::Periodic => RowEnds::Periodic,
                StreamwiseEnds::InletOutlet => RowEnds::InletOutlet(
                    Inlet::new(self.inlet_velocity, self.setup.cells, self.setup.operator),
                    self.setup.inlet_profile.as_ref(),
                ),
                StreamwiseEnds::Walls(_) => RowEnds::Walls,
            },
        };
        let planes = nz
            .div_ceil(SLABS_PER_THREAD * rayon::current_num_threads())
            .max(1);
        let slab_count = nz.div_ceil(planes);
        let counts = (0..slab_count).map(|s| planes.min(nz - s * planes));
        let rows = planes * self.setup.cells[1];
        let (inlet_means, _) = self.face_means.inlet.as_chunks_mut();
        let mut inlet_means = inlet_means.chunks_mut(rows);
        let mut ends = (self.exchanged_ends.as_mut()).map(|ends| ends.of_slabs(grid, planes, odd));
        let slabs: Vec<Slab<P>> =
            slabs::split(self.populations.arrays_mut(), &grid, odd, counts.clone())
                .into_iter()
                .zip(counts)
                .enumerate()
                .map(|(s, (arrays, count))| Slab {
                    first_plane: s * planes,
                    planes: count,
                    arrays,
                    inlet_means: inlet_means.next().unwrap_or_default(),
                    ends: ends.as_mut().and_then(Iterator::next),
                })
                .collect();
        slabs.into_par_iter().for_each(|slab| {
            let work = SweepSlab::<P, C> {
                grid: &grid,
                slab,
                body_force,
                profile: self.setup.inlet_profile.as_ref(),
                idle: self.setup.idle,
                common: &common,
                operator: PhantomData,
            };
            P::dispatch(instructions, work);
        });
    }
}

/// A run of planes with, per direction, the part of its array that these planes touch.
struct Slab<'a, P: Stored> {
    first_plane: usize,
    planes: usize,
    arrays: Arrays<'a, P>,
    /// Running means at the inlet, row by row; empty without one.
    inlet_means: &'a mut [[f32; INLET_MEANS]],
    /// What it does for an exchange at the ends of rows.
    ends: Option<EndsOfSlab<'a, P>>,
}

/// The work on one slab, compiled once per instruction set.
struct SweepSlab<'a, P: Stored, C> {
    grid: &'a Grid,
    slab: Slab<'a, P>,
    body_force: &'a BodyForce<'a>,
    /// Of the wind, and of the acceleration.
    profile: Option<&'a InletProfile>,
    /// What is left out, in whole blocks.
    idle: Option<IdleCells>,
    common: &'a Common<'a, P::Real>,
    operator: PhantomData<C>,
}

impl<T: Real, P: Stored<Real = T>, C: Collision> WithSimd for SweepSlab<'_, P, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let grid = self.grid;
        let block = LINE_BYTES / size_of::<P>();
        let [nx, ny, _] = grid.cells;
        let first_row = (self.slab.first_plane * ny) as u32;
        let forced = self.body_force.cells;
        let mut next = forced.rows.partition_point(|row| row.0 < first_row);
        let acceleration = self.body_force.acceleration.map(|a| a.map(T::of));
        // Force of every cell of a row; where nothing acts it stays zero (or the acceleration).
        let mut resting = acceleration.unwrap_or_default();
        let profile = self.profile.filter(|_| acceleration.is_some());
        let length = self.common.relaxation_times.len();
        let mut force = resting.map(|component| vec![component; length]);
        // Relaxation time of every cell of a row, where they all differ.
        let mut relaxation_times = vec![T::default(); self.common.held.map_or(0, |_| length)];
        for plane in 0..self.slab.planes {
            for y in 0..ny {
                let row = ((self.slab.first_plane + plane) * ny + y) as u32;
                if let (Some(profile), Some(acceleration)) = (profile, acceleration) {
                    let ratio = T::of(profile.rows()[row as usize].ratio);
                    resting = acceleration.map(|a| a * ratio);
                    for (force, resting) in force.iter_mut().zip(resting) {
                        force.fill(resting);
                    }
                }
                let mut touched: &[u32] = &[];
                let mut entries = 0..0;
                if let Some(&(_, first, end)) = forced.rows.get(next).filter(|entry| entry.0 == row)
                {
                    next += 1;
                    entries = first as usize..end as usize;
                    touched = &forced.x[entries.clone()];
                }
                for entry in entries.clone() {
                    let x = forced.x[entry] as usize;
                    for a in 0..3 {
                        force[a][x] += T::of(forced.force[entry][a]);
                    }
                }
                let common = match self.common.held {
                    None => *self.common,
                    Some(held) => {
                        let held = &held[row as usize * nx..][..nx];
                        self.common.add_up(held, &mut relaxation_times);
                        Common {
                            relaxation_times: &relaxation_times,
                            own_from: 0,
                            ..*self.common
                        }
                    }
                };
                let start = block + plane * grid.stride_z + y * grid.stride_y;
                let idle = self.idle.map_or(0..0, |idle| {
                    idle.blocks_of_row([y, self.slab.first_plane + plane], block)
                });
                let whole = 0..nx;
                let parts = match &self.slab.ends {
                    None => [whole, nx..nx],
                    Some(ends) => ends.parts_of_row(),
                };
                for (number, part) in parts.into_iter().enumerate() {
                    if let Some(ends) = &self.slab.ends {
                        let row = plane * ny + y;
                        ends.put_in_place_before(&mut self.slab.arrays, row, number);
                    }
                    for part in around(part, &idle) {
                        collide_part::<S, P, C>(
                            simd,
                            &mut self.slab.arrays,
                            start..start + nx,
                            part,
                            &common,
                            &force,
                            touched,
                            acceleration.is_some(),
                        );
                    }
                }
                fill_row_ends(
                    &mut self.slab.arrays,
                    start,
                    nx,
                    &self
                        .common
                        .ends
                        .of_row(row as usize, self.common.relaxation_time),
                    self.slab.inlet_means.get_mut(plane * ny + y),
                );
                if let Some(ends) = &mut self.slab.ends {
                    ends.take_down(&self.slab.arrays, plane * ny + y);
                }
                for &x in touched {
                    for a in 0..3 {
                        force[a][x as usize] = resting[a];
                    }
                }
            }
        }
    }
}

impl<T: Real> Common<'_, T> {
    /// Relaxation times of a row: molecular or the sponge's, plus the held eddy part.
    #[inline(always)]
    fn add_up(&self, held: &[T], sums: &mut [T]) {
        for ((sum, &held), &base) in sums.iter_mut().zip(held).zip(self.relaxation_times) {
            *sum = base + held;
        }
    }
}

/// What of a part of a row lies before and behind its `idle` cells.
#[inline(always)]
fn around(part: Range<usize>, idle: &Range<usize>) -> [Range<usize>; 2] {
    if idle.is_empty() {
        return [part.clone(), part.end..part.end];
    }
    let [end, start] = [idle.start, idle.end].map(|place| place.clamp(part.start, part.end));
    [part.start..end, start..part.end]
}

/// Collides a part of one row, which begins with a whole block, in runs of blocks that are alike. They are with or without force, before or where
/// every cell has a relaxation time of its own. A block is a cache line of cells,
/// which no vector exceeds; it does not depend on the CPU, so neither do the results. `touched` are the x of the cells with a force of
/// their own, ascending.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "a struct of them would be made for every row"
)]
fn collide_part<S: Simd, P: Stored, C: Collision>(
    simd: S,
    arrays: &mut Arrays<'_, P>,
    row: Range<usize>,
    part: Range<usize>,
    common: &Common<P::Real>,
    force: &[Vec<P::Real>; 3],
    touched: &[u32],
    accelerated: bool,
) {
    let block = LINE_BYTES / size_of::<P>();
    let mut touched = touched
        .iter()
        .map(|&x| x as usize / block * block)
        .skip_while(|first| *first < part.start)
        .peekable();
    let mut x = part.start;
    while x < part.end {
        let mut end = if x < common.own_from {
            common.own_from.min(part.end)
        } else {
            part.end
        };
        let mut forced = accelerated;
        if !accelerated && let Some(&first) = touched.peek() {
            if first > x {
                end = end.min(first);
            } else {
                forced = true;
                let mut last = x + block;
                while let Some(&another) = touched.peek()
                    && another < end
                    && another <= last
                {
                    last = another + block;
                    touched.next();
                }
                end = end.min(last);
            }
        }
        let cells = row.start + x..row.start + end;
        let tau = &common.relaxation_times[x..];
        let body = [&force[0][x..], &force[1][x..], &force[2][x..]];
        match (forced, x >= common.own_from) {
            (false, false) => {
                collide_run::<S, P, C, false, false>(simd, arrays, cells, common, tau, body);
            }
            (false, true) => {
                collide_run::<S, P, C, false, true>(simd, arrays, cells, common, tau, body);
            }
            (true, _) => collide_run::<S, P, C, true, true>(simd, arrays, cells, common, tau, body),
        }
        x = end;
    }
}

/// Collides neighbouring cells, from a whole vector on. `tau` is read only where `OWN_TIMES`, `force` only where `FORCED`; both begin at the first cell
/// and reach to the end of a block. The operator stands here once, for whole vectors and for what is left at the end. It is compiled for each operator,
/// kind of population and set of instructions.
#[inline(always)]
fn collide_run<S: Simd, P: Stored, C: Collision, const FORCED: bool, const OWN_TIMES: bool>(
    simd: S,
    arrays: &mut Arrays<'_, P>,
    cells: Range<usize>,
    common: &Common<P::Real>,
    tau: &[P::Real],
    force: [&[P::Real]; 3],
) {
    let zero = Lanes::splat(simd, <P::Real>::default());
    let mut local = Local {
        relaxation_time: Lanes::splat(simd, common.relaxation_time),
        force: [zero; 3],
        eddy_factor: Lanes::splat(simd, common.eddy_factor),
    };
    let lanes = <P::Real>::lanes::<S>();
    let (whole, count) = (cells.len() / lanes, cells.len().div_ceil(lanes));
    let vectors_per_line = (LINE_BYTES / size_of::<P>() / lanes).max(1);
    let first = cells.start;
    // All are of one length, in a plain loop, and indexed alike: then the compiler checks once and needs one counter, not 19.
    let end = first + count * lanes;
    let mut kept: [&mut [P]; DIRECTION_COUNT] = std::array::from_fn(|_| Default::default());
    for (direction, array) in arrays.iter_mut().enumerate() {
        kept[direction] = &mut array[..end];
    }
    let tau_vectors = &<P::Real>::vectors::<S>(tau).0[..if OWN_TIMES { count } else { 0 }];
    let mut force_vectors: [&[<P::Real as Real>::Vector<S>]; 3] = Default::default();
    for a in 0..3 {
        force_vectors[a] = &<P::Real>::vectors::<S>(force[a]).0[..if FORCED { count } else { 0 }];
    }
    // What is written of it are the cells of the run alone; behind them lie ghost cells.
    let mut last = [zero; DIRECTION_COUNT];
    for i in 0..count {
        // Opaque, so that the compiler keeps one counter: else it counts 19 addresses in memory, and their stores hold up those of the cells
        // (a fifth slower).
        let place = std::hint::black_box(first + i * lanes);
        let vector = place..place + lanes;
        if i % vectors_per_line == 0 {
            for direction in 0..DIRECTION_COUNT {
                prefetch(&kept[direction][place]);
            }
        }
        let mut f = [zero; DIRECTION_COUNT];
        for direction in 0..DIRECTION_COUNT {
            let kept = &kept[direction][vector.clone()];
            f[direction] = Lanes::new(simd, P::load(simd, kept));
        }
        if OWN_TIMES {
            local.relaxation_time = Lanes::new(simd, tau_vectors[i]);
        }
        if FORCED {
            for a in 0..3 {
                local.force[a] = Lanes::new(simd, force_vectors[a][i]);
            }
        }
        let out = C::collide::<_, FORCED>(&f, &local);
        if i == whole {
            last = out;
            break;
        }
        for direction in 0..DIRECTION_COUNT {
            let kept = &mut kept[opposite(direction)][vector.clone()];
            P::store(simd, out[direction].vector, kept);
        }
    }
    if whole == count {
        return;
    }
    let part = cells.start + whole * lanes..cells.end;
    for direction in 0..DIRECTION_COUNT {
        let into = &mut arrays[opposite(direction)][part.clone()];
        P::store_part(simd, last[direction].vector, into);
    }
}

#[cfg(test)]
#[path = "collide_stream_tests.rs"]
mod tests;
