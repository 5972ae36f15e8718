//! Stage `restrict`: from the fine cells to the coarse band; and the states of the source.

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::lines::{
    Collided, Reader, padded, populations_of, read_columns, read_row, states_of, write_line,
};
use crate::cpu::fluid::exchanged_ends::{End, ExchangedEnds};
use crate::cpu::fluid::slabs::{self, Arrays};
use crate::cpu::fluid::{Fluid, Stored};
use crate::lattice::grid::Grid;
use crate::lattice::level_state::{FIRST_STRAIN, STATE_NUMBERS};
use crate::lattice::nest::{BAND, Line, Nest, Planes, SOURCE};
use crate::lattice::{DIRECTION_COUNT, Real};

/// Coarse states of the band become the means of those of the eight fine cells; then the states of the source are read, in fine units. Planes do not
/// wait for each other: a cell's populations are its own.
pub(super) fn restrict_and_read<T: Real, P: Stored<Real = T>>(
    nest: &Nest,
    [band, source]: [&Planes; 2],
    coarse: &mut Fluid<P>,
    fine: &Fluid<P>,
    states: &mut [T],
) {
    let nest = *nest;
    let [nx, ny, _] = nest.cells.map(|n| n + 2);
    let per_plane = STATE_NUMBERS * nx * ny;
    // Of an axis that repeats the planes beyond its ends are those at the other end.
    let beyond = i64::from(nest.spans[2]);
    let first_plane = source.first + beyond;
    let planes = source.lines.len() - 2 * beyond as usize;
    let lines = &source.lines[beyond as usize..][..planes];
    let skipped = (nest.first[2] as i64 + first_plane) as usize;
    let runs = std::iter::once(skipped).chain(std::iter::repeat_n(1, planes));
    let collided_fine = Collided::new(fine, fine.held_eddy_viscosity.as_ref());
    let collided = Collided::new(coarse, coarse.held_eddy_viscosity.as_ref());
    let (grid, odd, instructions) = (coarse.grid, coarse.odd, coarse.instructions);
    let reader = Reader::new(fine);
    let ends = fine.exchanged_ends.as_ref();
    let slabs = slabs::split(coarse.populations.arrays_mut(), &grid, odd, runs);
    slabs
        .into_par_iter()
        .skip(1)
        .zip(lines)
        .zip(states[beyond as usize * per_plane..].par_chunks_mut(per_plane))
        .enumerate()
        .for_each(|(plane, ((mut arrays, lines), states))| {
            let in_band = first_plane + plane as i64 - band.first;
            if let Some(lines) = usize::try_from(in_band)
                .ok()
                .and_then(|z| band.lines.get(z))
            {
                instructions.dispatch(RestrictPlane::<P> {
                    reader: &reader,
                    ends,
                    collided_fine,
                    collided,
                    nest,
                    grid,
                    arrays: &mut arrays,
                    lines,
                });
            }
            instructions.dispatch(ReadPlane::<P> {
                collided,
                nest,
                grid,
                arrays: &arrays,
                states,
                lines,
            });
        });
    if nest.spans[2] {
        let last = planes * per_plane;
        states.copy_within(last..last + per_plane, 0);
        states.copy_within(per_plane..2 * per_plane, last + per_plane);
    }
}

impl<P: Stored> RestrictPlane<'_, '_, P> {
    /// True of a column of the band that the ends of rows hold.
    #[inline(always)]
    const fn is_next_to_shell(&self, line: &Line) -> bool {
        let [depth, last] = [*BAND.end(), self.nest.cells[0] as i64 - 1];
        line.start[0] == depth || line.start[0] == last - depth
    }
}

struct RestrictPlane<'a, 'b, P: Stored> {
    reader: &'a Reader<'a, P>,
    /// Lines along y are found there.
    ends: Option<&'a ExchangedEnds<P>>,
    collided_fine: Collided<'a, P::Real>,
    collided: Collided<'a, P::Real>,
    nest: Nest,
    grid: Grid,
    arrays: &'a mut Arrays<'b, P>,
    lines: &'a [Line],
}

impl<T: Real, P: Stored<Real = T>> WithSimd for RestrictPlane<'_, '_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let longest = self.lines.iter().map(|line| line.length).max().unwrap_or(0);
        let room = padded::<S, T>(2 * longest);
        let mut populations: [Vec<T>; 2] =
            std::array::from_fn(|_| vec![T::default(); DIRECTION_COUNT * room]);
        let mut states = vec![T::default(); STATE_NUMBERS * room];
        let mut sums = vec![T::default(); STATE_NUMBERS * room];
        let mut fine_times = self.collided_fine.relaxation_times(room);
        let mut times = self.collided.relaxation_times(room);
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
                        self.reader.row(first, length, f, stride);
                    }
                } else if let (Some(ends), true) = (self.ends, self.is_next_to_shell(line)) {
                    let end = End::of(line.start[0]);
                    let place = [first[1], first[2]];
                    ends.read_band(end, place, length, &mut populations, stride);
                } else {
                    // Deeper columns lie in place.
                    for (beside, f) in (0..).zip(&mut populations) {
                        for i in 0..length {
                            let cell = [first[0] + beside, first[1] + i as i64, first[2]];
                            self.reader.row(cell, 1, &mut f[i..], stride);
                        }
                    }
                }
                let s = &mut states[..STATE_NUMBERS * stride];
                for (beside, f) in (0..).zip(&populations) {
                    let mut first = first;
                    first[1 - axis] += beside;
                    self.collided_fine
                        .relaxation_times_of(first, line, length, &mut fine_times);
                    let f = &f[..DIRECTION_COUNT * stride];
                    states_of::<S, T>(simd, &self.collided_fine, &fine_times, f, s, stride);
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
            let place = std::array::from_fn(|a| self.nest.first[a] as i64 + line.start[a]);
            self.collided
                .relaxation_times_of(place, line, line.length, &mut times);
            populations_of::<S, T>(
                simd,
                &self.collided,
                &times,
                &states[..STATE_NUMBERS * narrow],
                f,
                narrow,
            );
            let place = [
                self.nest.first[0] + line.start[0] as usize,
                self.nest.first[1] + line.start[1] as usize,
                0,
            ];
            write_line(self.arrays, &self.grid, place, axis, line.length, f, narrow);
        }
    }
}

/// Columns of the source that lie side by side at a face.
const COLUMNS: usize = (*SOURCE.end() - *SOURCE.start() + 1) as usize;

struct ReadPlane<'a, 'b, P: Stored> {
    collided: Collided<'a, P::Real>,
    nest: Nest,
    grid: Grid,
    arrays: &'a Arrays<'b, P>,
    states: &'a mut [P::Real],
    lines: &'a [Line],
}

impl<T: Real, P: Stored<Real = T>> WithSimd for ReadPlane<'_, '_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let longest = self.lines.iter().map(|line| line.length).max().unwrap_or(0);
        let room = padded::<S, T>(longest);
        let mut populations: [Vec<T>; COLUMNS] =
            std::array::from_fn(|_| vec![T::default(); DIRECTION_COUNT * room]);
        let mut states = vec![T::default(); STATE_NUMBERS * room];
        let mut times = self.collided.relaxation_times(room);
        let [nx, ny, _] = self.nest.cells.map(|n| n + 2);
        let spans = self.nest.spans;
        let mut rest = self.lines;
        while let Some(line) = rest.first() {
            let (length, stride) = (line.length, padded::<S, T>(line.length));
            let first = [0, 1].map(|a| self.nest.first[a] as i64 + line.start[a]);
            let count = if line.axis == 0 {
                1
            } else {
                COLUMNS.min(rest.len())
            };
            if line.axis == 0 {
                let f = &mut populations[0];
                read_row(self.arrays, &self.grid, first, length, spans, f, stride);
            } else {
                let f = &mut populations[..count];
                read_columns(self.arrays, &self.grid, first, length, spans[1], f, stride);
            }
            let (side_by_side, behind) = rest.split_at(count);
            rest = behind;
            for (line, f) in side_by_side.iter().zip(&populations) {
                let f = &f[..DIRECTION_COUNT * stride];
                let s = &mut states[..STATE_NUMBERS * stride];
                let place = std::array::from_fn(|a| self.nest.first[a] as i64 + line.start[a]);
                self.collided
                    .relaxation_times_of(place, line, length, &mut times);
                states_of::<S, T>(simd, &self.collided, &times, f, s, stride);
                let start = (line.start[0] + 1) as usize + nx * (line.start[1] + 1) as usize;
                for number in 0..STATE_NUMBERS {
                    let share = T::of(if number < FIRST_STRAIN { 1.0 } else { 0.5 });
                    let into = self.states[number * nx * ny + start..].iter_mut();
                    let values = &s[number * stride..][..length];
                    if line.axis == 0 {
                        for (into, value) in into.zip(values) {
                            *into = share * *value;
                        }
                    } else {
                        for (into, value) in into.step_by(nx).zip(values) {
                            *into = share * *value;
                        }
                    }
                }
            }
        }
    }
}
