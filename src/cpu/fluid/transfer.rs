//! What passes between a lattice and a box of finer cells in it: *restrict* from the fine cells to the coarse band, *fill* the fine shell from the
//! coarse source ([`crate::lattice::nest`], [`crate::lattice::level_state`]).
//!
//! Work goes by planes of coarse cells, within a plane by lines of cells, along x where there are long ones, else along y; a line is a
//! run of vectors.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::Fluid;
use super::slabs::{self, Arrays};
use crate::lattice::collision::{Collision, PerOperator};
use crate::lattice::grid::Grid;
use crate::lattice::level_state::{FIRST_STRAIN, STATE_NUMBERS, children};
use crate::lattice::nest::{BAND, Line, Nest, Planes, SHELL, SOURCE};
use crate::lattice::operators::{self, Local};
use crate::lattice::{DIRECTION_COUNT, Lanes, Real};

/// A box of finer cells, and the cells that tie it to the lattice around it.
#[derive(Debug, Clone)]
pub struct Tie<T> {
    nest: Nest,
    source: Planes,
    shell: Planes,
    band: Planes,
    /// States of the coarse cells in and around the box, in fine units where they are of the source: by planes, then numbers of the state, rows, cells.
    states: Vec<T>,
}

impl<T: Real> Tie<T> {
    /// Of a box.
    #[must_use]
    pub fn new(nest: Nest) -> Self {
        let [x, y, z] = nest.cells.map(|n| n + 2);
        Self {
            source: nest.cells_of(&SOURCE),
            shell: nest.cells_of(&SHELL),
            band: nest.cells_of(&BAND),
            states: vec![T::default(); STATE_NUMBERS * x * y * z],
            nest,
        }
    }

    /// Where the box lies.
    #[must_use]
    pub const fn nest(&self) -> &Nest {
        &self.nest
    }

    /// Restricts, then fills: both lattices stand at one time.
    pub fn exchange(&mut self, coarse: &mut Fluid<T>, fine: &mut Fluid<T>) {
        let operator = coarse.setup.operator;
        let eddy = coarse.smagorinsky_constant().is_some();
        operator.with(
            eddy,
            Exchange {
                tie: self,
                coarse,
                fine,
            },
        );
    }
}

struct Exchange<'a, T: Real> {
    tie: &'a mut Tie<T>,
    coarse: &'a mut Fluid<T>,
    fine: &'a mut Fluid<T>,
}

impl<T: Real> PerOperator for Exchange<'_, T> {
    fn run<C: Collision>(self) {
        let Self { tie, coarse, fine } = self;
        restrict::<T, C>(tie, coarse, fine);
        read_source::<T, C>(tie, coarse);
        fill::<T, C>(tie, fine);
    }
}

/// Reads populations of lines of cells.
struct Reader<'a, T> {
    grid: Grid,
    arrays: [(&'a [T], isize); DIRECTION_COUNT],
}

impl<'a, T: Real> Reader<'a, T> {
    fn new(fluid: &'a Fluid<T>) -> Self {
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

    /// Populations of `length` cells from `first` on along x or y, direction after direction, each `stride` long. Along an axis that
    /// repeats cells come from the other end.
    #[inline(always)]
    fn line(
        &self,
        first: [i64; 3],
        axis: usize,
        length: usize,
        wraps: [bool; 3],
        into: &mut [T],
        stride: usize,
    ) {
        let n = self.grid.cells.map(|n| n as i64);
        let mut cell: [i64; 3] = std::array::from_fn(|a| {
            if wraps[a] {
                first[a].rem_euclid(n[a])
            } else {
                first[a]
            }
        });
        let mut done = 0;
        while done < length {
            let run = if wraps[axis] {
                (length - done).min((n[axis] - cell[axis]) as usize)
            } else {
                length - done
            };
            let start = self.grid.index(cell);
            for (direction, (array, shift)) in self.arrays.iter().enumerate() {
                let into = &mut into[direction * stride + done..][..run];
                let start = start.wrapping_add_signed(*shift);
                if axis == 0 {
                    into.copy_from_slice(&array[start..start + run]);
                } else {
                    let column = array[start..].iter().step_by(self.grid.stride_y);
                    for (into, value) in into.iter_mut().zip(column) {
                        *into = *value;
                    }
                }
            }
            done += run;
            cell[axis] = 0;
        }
    }
}

/// What the cells of one lattice are collided with next to a box.
#[derive(Clone, Copy)]
struct Collided<T> {
    relaxation_time: T,
    force: [T; 3],
    eddy_factor: T,
}

impl<T: Real> Collided<T> {
    fn new(fluid: &Fluid<T>) -> Self {
        let smagorinsky = fluid.smagorinsky_constant().unwrap_or(0.0);
        Self {
            relaxation_time: T::of(fluid.setup.relaxation_time),
            force: fluid.last_acceleration.map(T::of),
            eddy_factor: T::of(operators::eddy_factor(smagorinsky)),
        }
    }

    #[inline(always)]
    fn local<S: Simd>(&self, simd: S) -> Local<Lanes<S, T>> {
        Local {
            relaxation_time: Lanes::splat(simd, self.relaxation_time),
            force: self.force.map(|f| Lanes::splat(simd, f)),
            eddy_factor: Lanes::splat(simd, self.eddy_factor),
        }
    }
}

/// Whole vectors that hold so many values.
#[inline(always)]
fn padded<S: Simd, T: Real>(length: usize) -> usize {
    length.next_multiple_of(T::lanes::<S>())
}

/// Maps a line of cells with so many numbers each, number after number, each `stride` long, a multiple of a vector's lanes.
#[inline(always)]
fn mapped<S: Simd, T: Real, const FROM: usize, const INTO: usize>(
    simd: S,
    from: &[T],
    into: &mut [T],
    stride: usize,
    map: impl Fn(&[Lanes<S, T>; FROM]) -> [Lanes<S, T>; INTO],
) {
    let (from, stride) = (T::vectors::<S>(from).0, stride / T::lanes::<S>());
    let into = T::vectors_mut::<S>(into).0;
    for i in 0..stride {
        let cell = std::array::from_fn(|number| Lanes::new(simd, from[number * stride + i]));
        for (number, value) in map(&cell).into_iter().enumerate() {
            into[number * stride + i] = value.vector;
        }
    }
}

/// States of a line of populations, as in [`mapped`].
#[inline(always)]
fn states_of<S: Simd, T: Real, C: Collision>(
    simd: S,
    collided: &Collided<T>,
    populations: &[T],
    states: &mut [T],
    stride: usize,
) {
    let local = collided.local(simd);
    mapped(simd, populations, states, stride, |f| {
        C::level_state(f, &local)
    });
}

/// Populations of a line of states, as in [`mapped`].
#[inline(always)]
fn populations_of<S: Simd, T: Real, C: Collision>(
    simd: S,
    collided: &Collided<T>,
    states: &[T],
    populations: &mut [T],
    stride: usize,
) {
    let local = collided.local(simd);
    mapped(simd, states, populations, stride, |state| {
        C::populations_of(state, &local)
    });
}

/// Writes populations of `length` cells of a slab from `first` on (x, y, plane of the slab), along x or y.
#[inline(always)]
fn write_line<T: Real>(
    arrays: &mut Arrays<'_, T>,
    grid: &Grid,
    [x, y, plane]: [usize; 3],
    axis: usize,
    length: usize,
    populations: &[T],
    stride: usize,
) {
    let start = slabs::lead::<T>() + x + y * grid.stride_y + plane * grid.stride_z;
    for (direction, array) in arrays.iter_mut().enumerate() {
        let from = &populations[direction * stride..][..length];
        if axis == 0 {
            array[start..start + length].copy_from_slice(from);
        } else {
            let column = array[start..].iter_mut().step_by(grid.stride_y);
            for (into, value) in column.zip(from) {
                *into = *value;
            }
        }
    }
}

/// Coarse states of the band are the means of those of the eight fine cells.
fn restrict<T: Real, C: Collision>(tie: &Tie<T>, coarse: &mut Fluid<T>, fine: &Fluid<T>) {
    let (nest, band) = (tie.nest, &tie.band);
    let first_plane = (nest.first[2] as i64 + band.first) as usize;
    let planes = std::iter::once(first_plane).chain(std::iter::repeat_n(1, band.lines.len()));
    let (collided_fine, collided) = (Collided::new(fine), Collided::new(coarse));
    let (grid, odd, instructions) = (coarse.grid, coarse.odd, coarse.instructions);
    let reader = Reader::new(fine);
    let slabs = slabs::split(coarse.populations.arrays_mut(), &grid, odd, planes);
    slabs
        .into_par_iter()
        .skip(1)
        .zip(&band.lines)
        .for_each(|(arrays, lines)| {
            instructions.dispatch(RestrictPlane::<T, C> {
                reader: &reader,
                collided_fine,
                collided,
                nest,
                grid,
                arrays,
                lines,
                operator: PhantomData,
            });
        });
}

struct RestrictPlane<'a, T: Real, C> {
    reader: &'a Reader<'a, T>,
    collided_fine: Collided<T>,
    collided: Collided<T>,
    nest: Nest,
    grid: Grid,
    arrays: Arrays<'a, T>,
    lines: &'a [Line],
    operator: PhantomData<C>,
}

impl<T: Real, C: Collision> WithSimd for RestrictPlane<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let longest = self.lines.iter().map(|line| line.length).max().unwrap_or(0);
        let room = padded::<S, T>(2 * longest);
        let mut populations = vec![T::default(); DIRECTION_COUNT * room];
        let mut states = vec![T::default(); STATE_NUMBERS * room];
        let mut sums = vec![T::default(); STATE_NUMBERS * room];
        for line in self.lines {
            let (axis, across) = (line.axis, 1 - line.axis);
            let (length, stride) = (2 * line.length, padded::<S, T>(2 * line.length));
            sums[..STATE_NUMBERS * stride].fill(T::default());
            for child in 0..4 {
                let mut first = line.start.map(|place| 2 * place);
                first[across] += child % 2;
                first[2] += child / 2;
                let (f, s) = (
                    &mut populations[..DIRECTION_COUNT * stride],
                    &mut states[..STATE_NUMBERS * stride],
                );
                self.reader.line(first, axis, length, [false; 3], f, stride);
                states_of::<S, T, C>(simd, &self.collided_fine, f, s, stride);
                for (sum, value) in sums.iter_mut().zip(s.iter()) {
                    *sum += *value;
                }
            }
            let narrow = padded::<S, T>(line.length);
            for number in 0..STATE_NUMBERS {
                // Rates of strain are per step, and a coarse one is twice as long.
                let share = T::of(if number < FIRST_STRAIN { 0.125 } else { 0.25 });
                let fine = &sums[number * stride..][..length];
                let coarse = &mut states[number * narrow..][..line.length];
                for (coarse, pair) in coarse.iter_mut().zip(fine.chunks_exact(2)) {
                    *coarse = share * (pair[0] + pair[1]);
                }
            }
            let f = &mut populations[..DIRECTION_COUNT * narrow];
            populations_of::<S, T, C>(
                simd,
                &self.collided,
                &states[..STATE_NUMBERS * narrow],
                f,
                narrow,
            );
            let place = [
                self.nest.first[0] + line.start[0] as usize,
                self.nest.first[1] + line.start[1] as usize,
                0,
            ];
            write_line(
                &mut self.arrays,
                &self.grid,
                place,
                axis,
                line.length,
                f,
                narrow,
            );
        }
    }
}

/// Reads the states of the source, in fine units.
fn read_source<T: Real, C: Collision>(tie: &mut Tie<T>, coarse: &Fluid<T>) {
    let [nx, ny, _] = tie.nest.cells.map(|n| n + 2);
    let plane = STATE_NUMBERS * nx * ny;
    let (nest, source) = (tie.nest, &tie.source);
    let collided = Collided::new(coarse);
    let reader = Reader::new(coarse);
    tie.states
        .par_chunks_mut(plane)
        .zip(&source.lines)
        .for_each(|(states, lines)| {
            coarse.instructions.dispatch(ReadPlane::<T, C> {
                reader: &reader,
                collided,
                nest,
                states,
                lines,
                operator: PhantomData,
            });
        });
}

struct ReadPlane<'a, T: Real, C> {
    reader: &'a Reader<'a, T>,
    collided: Collided<T>,
    nest: Nest,
    states: &'a mut [T],
    lines: &'a [Line],
    operator: PhantomData<C>,
}

impl<T: Real, C: Collision> WithSimd for ReadPlane<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let longest = self.lines.iter().map(|line| line.length).max().unwrap_or(0);
        let room = padded::<S, T>(longest);
        let mut populations = vec![T::default(); DIRECTION_COUNT * room];
        let mut states = vec![T::default(); STATE_NUMBERS * room];
        let [nx, ny, _] = self.nest.cells.map(|n| n + 2);
        for line in self.lines {
            let stride = padded::<S, T>(line.length);
            let first = std::array::from_fn(|a| self.nest.first[a] as i64 + line.start[a]);
            let (f, s) = (
                &mut populations[..DIRECTION_COUNT * stride],
                &mut states[..STATE_NUMBERS * stride],
            );
            self.reader
                .line(first, line.axis, line.length, self.nest.spans, f, stride);
            states_of::<S, T, C>(simd, &self.collided, f, s, stride);
            let start = (line.start[0] + 1) as usize + nx * (line.start[1] + 1) as usize;
            let step = if line.axis == 0 { 1 } else { nx };
            for number in 0..STATE_NUMBERS {
                let share = T::of(if number < FIRST_STRAIN { 1.0 } else { 0.5 });
                let into = self.states[number * nx * ny + start..].iter_mut();
                for (into, value) in into.step_by(step).zip(&s[number * stride..][..line.length]) {
                    *into = share * *value;
                }
            }
        }
    }
}

/// Fine cells of the shell get the averages of the parabolas through the states of the source.
fn fill<T: Real, C: Collision>(tie: &Tie<T>, fine: &mut Fluid<T>) {
    let shell = &tie.shell;
    let planes = std::iter::repeat_n(2, shell.lines.len());
    let collided = Collided::new(fine);
    let (grid, odd, instructions) = (fine.grid, fine.odd, fine.instructions);
    let slabs = slabs::split(fine.populations.arrays_mut(), &grid, odd, planes);
    let [nx, ny, _] = tie.nest.cells.map(|n| n + 2);
    let plane = STATE_NUMBERS * nx * ny;
    slabs
        .into_par_iter()
        .zip(&shell.lines)
        .enumerate()
        .for_each(|(z, (arrays, lines))| {
            instructions.dispatch(FillPlane::<T, C> {
                // Planes below, of, and above these cells.
                states: [0, 1, 2].map(|k| &tie.states[(z + k) * plane..][..plane]),
                row: [nx, nx * ny],
                collided,
                grid,
                arrays,
                lines,
                operator: PhantomData,
            });
        });
}

struct FillPlane<'a, T: Real, C> {
    states: [&'a [T]; 3],
    /// States from row to row, and from number to number.
    row: [usize; 2],
    collided: Collided<T>,
    grid: Grid,
    arrays: Arrays<'a, T>,
    lines: &'a [Line],
    operator: PhantomData<C>,
}

impl<T: Real, C: Collision> WithSimd for FillPlane<'_, T, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let longest = self.lines.iter().map(|line| line.length).max().unwrap_or(0);
        let room = padded::<S, T>(2 * longest);
        let mut populations = vec![T::default(); DIRECTION_COUNT * room];
        let mut states: [Vec<T>; 4] =
            std::array::from_fn(|_| vec![T::default(); STATE_NUMBERS * room]);
        // Children along z of the three lines side by side, then those across of the line itself.
        let mut along_z = vec![T::default(); 6 * (longest + 2)];
        let mut of_line = vec![T::default(); 4 * (longest + 2)];
        let [nx, per_number] = self.row;
        for line in self.lines {
            let (axis, across) = (line.axis, 1 - line.axis);
            let (step, aside) = if axis == 0 { (1, nx) } else { (nx, 1) };
            let (count, stride) = (line.length + 2, padded::<S, T>(2 * line.length));
            // The cell before the first of the line beside this one.
            let corner = line.start[0] as usize + nx * line.start[1] as usize;
            for number in 0..STATE_NUMBERS {
                let start = number * per_number + corner;
                for beside in 0..3 {
                    let start = start + beside * aside;
                    let [below, level, above] = self.states.map(|plane| &plane[start..]);
                    let (lower, upper) =
                        along_z[2 * beside * count..][..2 * count].split_at_mut(count);
                    for i in 0..count {
                        let k = i * step;
                        [lower[i], upper[i]] = children([below[k], level[k], above[k]]);
                    }
                }
                for z in 0..2 {
                    let [before, beside, behind] =
                        [0, 1, 2].map(|b| &along_z[(2 * b + z) * count..][..count]);
                    let (near, far) = of_line[2 * z * count..][..2 * count].split_at_mut(count);
                    for i in 0..count {
                        [near[i], far[i]] = children([before[i], beside[i], behind[i]]);
                    }
                }
                for (child, states) in states.iter_mut().enumerate() {
                    let coarse = &of_line[child * count..][..count];
                    let fine = &mut states[number * stride..][..2 * line.length];
                    for (pair, three) in fine.chunks_exact_mut(2).zip(coarse.windows(3)) {
                        [pair[0], pair[1]] = children([three[0], three[1], three[2]]);
                    }
                }
            }
            for (child, states) in states.iter().enumerate() {
                let f = &mut populations[..DIRECTION_COUNT * stride];
                populations_of::<S, T, C>(
                    simd,
                    &self.collided,
                    &states[..STATE_NUMBERS * stride],
                    f,
                    stride,
                );
                let mut place = [
                    2 * line.start[0] as usize,
                    2 * line.start[1] as usize,
                    child / 2,
                ];
                place[across] += child % 2;
                write_line(
                    &mut self.arrays,
                    &self.grid,
                    place,
                    axis,
                    2 * line.length,
                    f,
                    stride,
                );
            }
        }
    }
}
