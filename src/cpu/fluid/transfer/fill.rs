//! Stage `fill`: from the coarse source to the fine shell.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::lines::{
    Collided, Reader, padded, populations_of, states_of, write_columns, write_line,
};
use crate::cpu::fluid::Fluid;
use crate::cpu::fluid::slabs::{self, Arrays};
use crate::lattice::collision::Collision;
use crate::lattice::grid::Grid;
use crate::lattice::level_state::{FIRST_STRAIN, STATE_NUMBERS, children};
use crate::lattice::nest::{Line, Nest, Planes};
use crate::lattice::{DIRECTION_COUNT, Real};

/// Reads the states of the source, in fine units.
pub(super) fn read_source<T: Real, C: Collision>(
    nest: &Nest,
    source: &Planes,
    coarse: &Fluid<T>,
    states: &mut [T],
) {
    let [nx, ny, _] = nest.cells.map(|n| n + 2);
    let plane = STATE_NUMBERS * nx * ny;
    let nest = *nest;
    let collided = Collided::new(coarse);
    let reader = Reader::new(coarse);
    states
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
pub(super) fn fill<T: Real, C: Collision>(
    nest: &Nest,
    shell: &Planes,
    states: &[T],
    fine: &mut Fluid<T>,
) {
    let planes = std::iter::repeat_n(2, shell.lines.len());
    let collided = Collided::new(fine);
    let (grid, odd, instructions) = (fine.grid, fine.odd, fine.instructions);
    let slabs = slabs::split(fine.populations.arrays_mut(), &grid, odd, planes);
    let [nx, ny, _] = nest.cells.map(|n| n + 2);
    let plane = STATE_NUMBERS * nx * ny;
    slabs
        .into_par_iter()
        .zip(&shell.lines)
        .enumerate()
        .for_each(|(z, (arrays, lines))| {
            instructions.dispatch(FillPlane::<T, C> {
                // Planes below, of, and above these cells.
                states: [0, 1, 2].map(|k| &states[(z + k) * plane..][..plane]),
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
        let mut populations: [Vec<T>; 2] =
            std::array::from_fn(|_| vec![T::default(); DIRECTION_COUNT * room]);
        let mut states: [Vec<T>; 4] =
            std::array::from_fn(|_| vec![T::default(); STATE_NUMBERS * room]);
        // Children along z of the three lines side by side, then those across of the line itself.
        let mut along_z = vec![T::default(); 6 * (longest + 2)];
        let mut of_line = vec![T::default(); 4 * (longest + 2)];
        let mut along = vec![T::default(); 2 * longest];
        let [nx, per_number] = self.row;
        for line in self.lines {
            let axis = line.axis;
            let (step, aside) = if axis == 0 { (1, nx) } else { (nx, 1) };
            let (count, stride) = (line.length + 2, padded::<S, T>(2 * line.length));
            // The cell before the first of the line beside this one.
            let corner = line.start[0] as usize + nx * line.start[1] as usize;
            for number in 0..STATE_NUMBERS {
                let start = number * per_number + corner;
                for beside in 0..3 {
                    let start = start + beside * aside;
                    let reach = (count - 1) * step + 1;
                    let [below, level, above] = self.states.map(|plane| &plane[start..][..reach]);
                    let (lower, upper) =
                        along_z[2 * beside * count..][..2 * count].split_at_mut(count);
                    if step == 1 {
                        for i in 0..count {
                            [lower[i], upper[i]] = children([below[i], level[i], above[i]]);
                        }
                    } else {
                        for i in 0..count {
                            let k = i * step;
                            [lower[i], upper[i]] = children([below[k], level[k], above[k]]);
                        }
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
                    let (lower, upper) = along[..2 * line.length].split_at_mut(line.length);
                    let (below, middle, above) =
                        (coarse, &coarse[1..], &coarse[2..][..line.length]);
                    for i in 0..line.length {
                        [lower[i], upper[i]] = children([below[i], middle[i], above[i]]);
                    }
                    let fine = &mut states[number * stride..][..2 * line.length];
                    let pairs = fine.chunks_exact_mut(2).zip(lower.iter().zip(upper.iter()));
                    for (pair, (lower, upper)) in pairs {
                        (pair[0], pair[1]) = (*lower, *upper);
                    }
                }
            }
            for above in 0..2 {
                for (beside, f) in populations.iter_mut().enumerate() {
                    populations_of::<S, T, C>(
                        simd,
                        &self.collided,
                        &states[2 * above + beside][..STATE_NUMBERS * stride],
                        &mut f[..DIRECTION_COUNT * stride],
                        stride,
                    );
                }
                let [x, y] = [0, 1].map(|a| 2 * line.start[a] as usize);
                let (arrays, grid) = (&mut self.arrays, &self.grid);
                let length = 2 * line.length;
                if axis == 1 {
                    let sides = [&populations[0][..], &populations[1][..]];
                    write_columns(arrays, grid, [x, y, above], length, sides, stride);
                    continue;
                }
                for (beside, f) in populations.iter().enumerate() {
                    let place = [x, y + beside, above];
                    write_line(arrays, grid, place, axis, length, f, stride);
                }
            }
        }
    }
}
