//! Stage `restrict`: from the fine cells to the coarse band.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::lines::{Collided, Reader, padded, populations_of, states_of, write_line};
use crate::cpu::fluid::Fluid;
use crate::cpu::fluid::slabs::{self, Arrays};
use crate::lattice::collision::Collision;
use crate::lattice::grid::Grid;
use crate::lattice::level_state::{FIRST_STRAIN, STATE_NUMBERS};
use crate::lattice::nest::{Line, Nest, Planes};
use crate::lattice::{DIRECTION_COUNT, Real};

/// Coarse states of the band are the means of those of the eight fine cells.
pub(super) fn restrict<T: Real, C: Collision>(
    nest: &Nest,
    band: &Planes,
    coarse: &mut Fluid<T>,
    fine: &Fluid<T>,
) {
    let nest = *nest;
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
        let mut populations: [Vec<T>; 2] =
            std::array::from_fn(|_| vec![T::default(); DIRECTION_COUNT * room]);
        let mut states = vec![T::default(); STATE_NUMBERS * room];
        let mut sums = vec![T::default(); STATE_NUMBERS * room];
        for line in self.lines {
            let axis = line.axis;
            let (length, stride) = (2 * line.length, padded::<S, T>(2 * line.length));
            sums[..STATE_NUMBERS * stride].fill(T::default());
            for above in 0..2 {
                let mut first = line.start.map(|place| 2 * place);
                first[2] += above;
                if axis == 0 {
                    for (beside, f) in (0..).zip(&mut populations) {
                        let first = [first[0], first[1] + beside, first[2]];
                        self.reader.line(first, axis, length, [false; 3], f, stride);
                    }
                } else {
                    (self.reader).columns(first, length, &mut populations, stride);
                }
                let s = &mut states[..STATE_NUMBERS * stride];
                for f in &populations {
                    let f = &f[..DIRECTION_COUNT * stride];
                    states_of::<S, T, C>(simd, &self.collided_fine, f, s, stride);
                    for (sum, value) in sums.iter_mut().zip(s.iter()) {
                        *sum += *value;
                    }
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
            let f = &mut populations[0][..DIRECTION_COUNT * narrow];
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
