//! Stage `fill`: from the states of the coarse source to the fine shell.

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::lines::{Collided, ask_for_row, padded, populations_of, write_line};
use crate::cpu::fluid::exchanged_ends::{End, EndsOfRow, ExchangedEnds};
use crate::cpu::fluid::slabs::{self, Arrays};
use crate::cpu::fluid::{Fluid, Stored};
use crate::lattice::grid::Grid;
use crate::lattice::level_state::{STATE_NUMBERS, children};
use crate::lattice::nest::{Line, Nest, Planes};
use crate::lattice::{DIRECTION_COUNT, Real};

/// Lower and upper children of the middle ones of three lines of cells side by side. (Indices instead of zipped slices would not be compiled for
/// the CPU's vectors.)
#[inline(always)]
fn children_of_lines<T: Real>([below, middle, above]: [&[T]; 3], [lower, upper]: [&mut [T]; 2]) {
    let three = below.iter().zip(middle).zip(above);
    for ((lower, upper), ((below, middle), above)) in lower.iter_mut().zip(upper).zip(three) {
        [*lower, *upper] = children([*below, *middle, *above]);
    }
}

/// Fine cells of the shell get the averages of the parabolas through the states of the source.
pub(super) fn fill<T: Real, P: Stored<Real = T>>(
    nest: &Nest,
    shell: &Planes,
    states: &[T],
    fine: &mut Fluid<P>,
) {
    let planes = std::iter::repeat_n(2, shell.lines.len());
    let collided = Collided::new(fine, fine.held_eddy_viscosity.as_ref());
    let (grid, odd, instructions) = (fine.grid, fine.odd, fine.instructions);
    let slabs = slabs::split(fine.populations.arrays_mut(), &grid, odd, planes);
    // What arrives at the ends of rows, two planes for each coarse one.
    let mut ends = (fine.exchanged_ends.as_mut()).map(ExchangedEnds::planes_that_arrive);
    let mut pairs = || [(); 2].map(|()| ends.as_mut().and_then(Iterator::next).unwrap_or_default());
    let slabs: Vec<_> = slabs.into_iter().map(|slab| (slab, pairs())).collect();
    let [nx, ny, _] = nest.cells.map(|n| n + 2);
    let plane = STATE_NUMBERS * nx * ny;
    slabs
        .into_par_iter()
        .zip(&shell.lines)
        .enumerate()
        .for_each(|(z, ((arrays, ends), lines))| {
            instructions.dispatch(FillPlane::<P> {
                // Planes below, of, and above these cells.
                states: [0, 1, 2].map(|k| &states[(z + k) * plane..][..plane]),
                row: [nx, nx * ny],
                plane: 2 * z as i64,
                collided,
                grid,
                arrays,
                ends,
                lines,
            });
        });
}

struct FillPlane<'a, P: Stored> {
    states: [&'a [P::Real]; 3],
    /// States from row to row, and from number to number.
    row: [usize; 2],
    /// z of the lower plane of fine cells.
    plane: i64,
    collided: Collided<'a, P::Real>,
    grid: Grid,
    arrays: Arrays<'a, P>,
    ends: [&'a mut [EndsOfRow<P>]; 2],
    lines: &'a [Line],
}

impl<T: Real, P: Stored<Real = T>> WithSimd for FillPlane<'_, P> {
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
        let mut times = self.collided.relaxation_times(room);
        let [nx, per_number] = self.row;
        for line in self.lines {
            let axis = line.axis;
            let (step, aside) = if axis == 0 { (1, nx) } else { (nx, 1) };
            let (count, stride) = (line.length + 2, padded::<S, T>(2 * line.length));
            // The cell before the first of the line beside this one.
            let corner = line.start[0] as usize + nx * line.start[1] as usize;
            for number in 0..STATE_NUMBERS {
                if axis == 0 {
                    // Where these cells are written to, while their states are worked out.
                    for direction in (number..DIRECTION_COUNT).step_by(STATE_NUMBERS) {
                        for row in 0..4 {
                            let [x, y] = [0, 1].map(|a| 2 * line.start[a] as usize);
                            let place = [x, y + row % 2, row / 2];
                            ask_for_row(self.arrays[direction], &self.grid, place, 2 * line.length);
                        }
                    }
                }
                let start = number * per_number + corner;
                for beside in 0..3 {
                    let start = start + beside * aside;
                    let reach = (count - 1) * step + 1;
                    let [below, level, above] = self.states.map(|plane| &plane[start..][..reach]);
                    let (lower, upper) =
                        along_z[2 * beside * count..][..2 * count].split_at_mut(count);
                    if step == 1 {
                        children_of_lines([below, level, above], [lower, upper]);
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
                    children_of_lines([before, beside, behind], [near, far]);
                }
                for (child, states) in states.iter_mut().enumerate() {
                    let coarse = &of_line[child * count..][..count];
                    let (lower, upper) = along[..2 * line.length].split_at_mut(line.length);
                    let neighbours = [0, 1, 2].map(|k| &coarse[k..][..line.length]);
                    children_of_lines(neighbours, [&mut *lower, &mut *upper]);
                    let fine = &mut states[number * stride..][..2 * line.length];
                    let pairs = fine.chunks_exact_mut(2).zip(lower.iter().zip(upper.iter()));
                    for (pair, (lower, upper)) in pairs {
                        (pair[0], pair[1]) = (*lower, *upper);
                    }
                }
            }
            for above in 0..2 {
                for (beside, f) in populations.iter_mut().enumerate() {
                    let mut first = line.start.map(|place| 2 * place);
                    first[2] = self.plane + above as i64;
                    first[1 - axis] += beside as i64;
                    let length = 2 * line.length;
                    self.collided
                        .relaxation_times_of(first, line, length, &mut times);
                    populations_of::<S, T>(
                        simd,
                        &self.collided,
                        &times,
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
                    let (end, plane) = (End::of(line.start[0]), &mut *self.ends[above]);
                    ExchangedEnds::arrive(plane, end, y, length, sides, stride);
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
