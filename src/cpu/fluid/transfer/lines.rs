//! Lines of cells: their populations, and states of these ([`crate::lattice::level_state`]).

use pulp::Simd;

use crate::cpu::fluid::held_eddy_viscosity::HeldEddyViscosity;
use crate::cpu::fluid::prefetch::prefetch_behind;
use crate::cpu::fluid::slabs::{self, Arrays};
use crate::cpu::fluid::{Fluid, Stored};
use crate::lattice::collision::Operator;
use crate::lattice::grid::{Grid, LINE_BYTES};
use crate::lattice::level_state::{self, STATE_NUMBERS};
use crate::lattice::nest::Line;
use crate::lattice::operators::{self, Local};
use crate::lattice::{DIRECTION_COUNT, Lanes, Real};

/// Reads populations of lines of cells.
pub(super) struct Reader<'a, P> {
    grid: Grid,
    arrays: [(&'a [P], isize); DIRECTION_COUNT],
}

impl<'a, P: Stored> Reader<'a, P> {
    /// Of a lattice as it stands.
    pub fn new(fluid: &'a Fluid<P>) -> Self {
        let grid = fluid.grid;
        let arrays = std::array::from_fn(|direction| {
            let index = grid.index([0; 3]);
            let (array, element) = grid.slot(index, direction, fluid.odd);
            (
                &fluid.populations[array],
                element.wrapping_sub(index) as isize,
            )
        });
        Self { grid, arrays }
    }

    /// Populations of `length` cells from `first` on along x, direction after direction, each `stride` long.
    #[inline(always)]
    pub fn row(&self, first: [i64; 3], length: usize, into: &mut [P::Real], stride: usize) {
        let start = self.grid.index(first);
        for (direction, (array, shift)) in self.arrays.iter().enumerate() {
            let start = start.wrapping_add_signed(*shift);
            let into = &mut into[direction * stride..][..length];
            P::unpack(&array[start..start + length], into);
        }
    }
}

/// Rows ahead of a column that are asked for.
const ROWS_AHEAD: usize = 12;

/// Populations of `length` cells of a plane from `first` (x, y) on along x, direction after direction, each `stride` long. Along an axis that
/// repeats cells come from the other end.
#[inline(always)]
pub(super) fn read_row<P: Stored>(
    plane: &Arrays<'_, P>,
    grid: &Grid,
    first: [i64; 2],
    length: usize,
    wraps: [bool; 3],
    into: &mut [P::Real],
    stride: usize,
) {
    let [mut x, y] = [0, 1].map(|a| wrapped(first[a], grid.cells[a], wraps[a]));
    let mut done = 0;
    while done < length {
        let run = if wraps[0] {
            (length - done).min(grid.cells[0] - x)
        } else {
            length - done
        };
        let start = slabs::lead::<P>() + x + y * grid.stride_y;
        for (direction, array) in plane.iter().enumerate() {
            let into = &mut into[direction * stride + done..][..run];
            P::unpack(&array[start..start + run], into);
        }
        done += run;
        x = 0;
    }
}

/// The same of columns of `length` cells along y, as many as there are buffers, side by side along x: each cache line is touched once for all.
#[inline(always)]
pub(super) fn read_columns<P: Stored>(
    plane: &Arrays<'_, P>,
    grid: &Grid,
    [x, y]: [i64; 2],
    length: usize,
    wraps: bool,
    into: &mut [Vec<P::Real>],
    stride: usize,
) {
    let first = slabs::lead::<P>() + x as usize;
    let count = into.len();
    for (direction, array) in plane.iter().enumerate() {
        let mut row = wrapped(y, grid.cells[1], wraps);
        for i in 0..length {
            let cells = &array[first + row * grid.stride_y..][..count];
            prefetch_behind(&cells[0], ROWS_AHEAD * grid.stride_y * size_of::<P>());
            for (column, value) in into.iter_mut().zip(cells) {
                column[direction * stride + i] = value.unpacked();
            }
            row = if row + 1 == grid.cells[1] { 0 } else { row + 1 };
        }
    }
}

/// A place along an axis of `n` cells.
#[inline(always)]
const fn wrapped(place: i64, n: usize, wraps: bool) -> usize {
    if wraps {
        place.rem_euclid(n as i64) as usize
    } else {
        place as usize
    }
}

/// What the cells of one lattice are collided with next to a box.
#[derive(Clone, Copy)]
pub(super) struct Collided<'a, T> {
    operator: Operator,
    relaxation_time: T,
    force: [T; 3],
    eddy_factor: T,
    /// Eddy part of every cell's relaxation time, where a stage of its own evaluates it.
    held: Option<&'a [T]>,
    cells: [usize; 3],
}

impl<'a, T: Real> Collided<'a, T> {
    /// Of a lattice as it stands, with what its `eddy_viscosity` keeps.
    pub fn new(
        fluid: &Fluid<impl Stored<Real = T>>,
        held: Option<&'a HeldEddyViscosity<T>>,
    ) -> Self {
        let smagorinsky = fluid.smagorinsky_constant().unwrap_or(0.0);
        Self {
            operator: fluid.setup.operator,
            relaxation_time: T::of(fluid.setup.relaxation_time),
            force: fluid.last_acceleration.map(T::of),
            eddy_factor: T::of(operators::eddy_factor(smagorinsky)),
            held: held.map(|held| &held.relaxation_times[..]),
            cells: fluid.setup.cells,
        }
    }

    /// Room for the relaxation times of a line of at most so many cells.
    pub fn relaxation_times(&self, room: usize) -> Vec<T> {
        vec![self.relaxation_time; room]
    }

    /// Relaxation times of a line from `first` on along x or y, which goes round the lattice, apart from what a collision evaluates itself.
    #[inline(always)]
    pub fn relaxation_times_of(&self, first: [i64; 3], line: &Line, length: usize, out: &mut [T]) {
        let Some(held) = self.held else {
            return;
        };
        let [nx, ny, _] = self.cells;
        let mut cell: [usize; 3] =
            std::array::from_fn(|a| first[a].rem_euclid(self.cells[a] as i64) as usize);
        for time in &mut out[..length] {
            *time = self.relaxation_time + held[cell[0] + nx * (cell[1] + ny * cell[2])];
            cell[line.axis] += 1;
            if cell[line.axis] == self.cells[line.axis] {
                cell[line.axis] = 0;
            }
        }
    }

    #[inline(always)]
    fn local<S: Simd>(&self, simd: S) -> Local<Lanes<S, T>> {
        Local {
            relaxation_time: Lanes::splat(simd, self.relaxation_time),
            force: [
                Lanes::splat(simd, self.force[0]),
                Lanes::splat(simd, self.force[1]),
                Lanes::splat(simd, self.force[2]),
            ],
            eddy_factor: Lanes::splat(simd, self.eddy_factor),
        }
    }
}

/// Whole vectors that hold so many values.
#[inline(always)]
pub(super) fn padded<S: Simd, T: Real>(length: usize) -> usize {
    length.next_multiple_of(T::lanes::<S>())
}

/// States of a line of populations, number after number, each `stride` long, a multiple of a vector's lanes. The operator is asked for once a line. Compiled
/// into all that is done with a plane, this stage took a third of the time that LLVM spends on this crate's functions of 20 ms and more.
#[inline(always)]
pub(super) fn states_of<S: Simd, T: Real>(
    simd: S,
    collided: &Collided<'_, T>,
    relaxation_times: &[T],
    populations: &[T],
    states: &mut [T],
    stride: usize,
) {
    let (times, f, into) = (relaxation_times, populations, states);
    let operator = collided.operator;
    match (operator.is_recursive(), operator.reads_residual()) {
        (false, _) => states_by::<S, T, false, false>(simd, collided, times, f, into, stride),
        (true, false) => states_by::<S, T, true, false>(simd, collided, times, f, into, stride),
        (true, true) => states_by::<S, T, true, true>(simd, collided, times, f, into, stride),
    }
}

/// The same by one formula. (No closures here: they would not be compiled for the CPU's vectors.)
#[inline(always)]
fn states_by<S: Simd, T: Real, const RECURSIVE: bool, const RESIDUAL: bool>(
    simd: S,
    collided: &Collided<'_, T>,
    relaxation_times: &[T],
    populations: &[T],
    states: &mut [T],
    stride: usize,
) {
    let mut local = collided.local(simd);
    let times = T::vectors::<S>(&relaxation_times[..stride]).0;
    let (from, stride) = (T::vectors::<S>(populations).0, stride / T::lanes::<S>());
    let into = T::vectors_mut::<S>(states).0;
    for i in 0..stride {
        let mut f = [Lanes::new(simd, from[i]); DIRECTION_COUNT];
        for direction in 1..DIRECTION_COUNT {
            f[direction] = Lanes::new(simd, from[direction * stride + i]);
        }
        local.relaxation_time = Lanes::new(simd, times[i]);
        let state = level_state::level_state::<_, RESIDUAL, RECURSIVE>(&f, &local);
        for number in 0..STATE_NUMBERS {
            into[number * stride + i] = state[number].vector;
        }
    }
}

/// Populations of a line of states, laid out likewise.
#[inline(always)]
pub(super) fn populations_of<S: Simd, T: Real>(
    simd: S,
    collided: &Collided<'_, T>,
    relaxation_times: &[T],
    states: &[T],
    populations: &mut [T],
    stride: usize,
) {
    let (times, from, into) = (relaxation_times, states, populations);
    if collided.operator.is_recursive() {
        populations_by::<S, T, true>(simd, collided, times, from, into, stride);
    } else {
        populations_by::<S, T, false>(simd, collided, times, from, into, stride);
    }
}

/// The same by one formula.
#[inline(always)]
fn populations_by<S: Simd, T: Real, const RECURSIVE: bool>(
    simd: S,
    collided: &Collided<'_, T>,
    relaxation_times: &[T],
    states: &[T],
    populations: &mut [T],
    stride: usize,
) {
    let mut local = collided.local(simd);
    let times = T::vectors::<S>(&relaxation_times[..stride]).0;
    let (from, stride) = (T::vectors::<S>(states).0, stride / T::lanes::<S>());
    let into = T::vectors_mut::<S>(populations).0;
    for i in 0..stride {
        let mut state = [Lanes::new(simd, from[i]); STATE_NUMBERS];
        for number in 1..STATE_NUMBERS {
            state[number] = Lanes::new(simd, from[number * stride + i]);
        }
        local.relaxation_time = Lanes::new(simd, times[i]);
        let f = level_state::populations_of::<_, RECURSIVE>(&state, &local);
        for direction in 0..DIRECTION_COUNT {
            into[direction * stride + i] = f[direction].vector;
        }
    }
}

/// Writes populations of `length` cells of a slab from `first` on (x, y, plane of the slab), along x or y.
#[inline(always)]
pub(super) fn write_line<P: Stored>(
    arrays: &mut Arrays<'_, P>,
    grid: &Grid,
    [x, y, plane]: [usize; 3],
    axis: usize,
    length: usize,
    populations: &[P::Real],
    stride: usize,
) {
    let start = slabs::lead::<P>() + x + y * grid.stride_y + plane * grid.stride_z;
    for (direction, array) in arrays.iter_mut().enumerate() {
        let from = &populations[direction * stride..][..length];
        if axis == 0 {
            P::pack(from, &mut array[start..start + length]);
        } else {
            let column = array[start..].iter_mut().step_by(grid.stride_y);
            for (into, value) in column.zip(from) {
                *into = P::packed(*value);
            }
        }
    }
}

/// Asks for the cache lines of `length` cells of a slab from `first` on along x.
#[inline(always)]
pub(super) fn ask_for_row<P: Stored>(
    array: &[P],
    grid: &Grid,
    [x, y, plane]: [usize; 3],
    length: usize,
) {
    let start = slabs::lead::<P>() + x + y * grid.stride_y + plane * grid.stride_z;
    for line in array[start..start + length].chunks(LINE_BYTES / size_of::<P>()) {
        prefetch_behind(&line[0], 0);
    }
}
