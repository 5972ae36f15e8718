//! The fastest cell of a box, and the one whose density is farthest off: what a watch over the flow looks at.

use rayon::prelude::*;

use super::{Fluid, Stored};
use crate::lattice::grid::{CellState, Extremes};
use crate::lattice::operators::bare_moments;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real};

/// A value with the cell that has it.
type Ranked = (f64, [usize; 3]);

/// What stands out so far: by squared speed among finite cells, and by |δρ|, infinite where a cell is not finite.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    fastest: Option<Ranked>,
    farthest: Option<Ranked>,
}

/// The larger value; of equal ones that of the first cell, x fastest.
fn larger(a: Option<Ranked>, b: Option<Ranked>) -> Option<Ranked> {
    let (Some((value, [x, y, z])), Some((other, [ox, oy, oz]))) = (a, b) else {
        return a.or(b);
    };
    let second_wins = other > value || (other == value && [oz, oy, ox] < [z, y, x]);
    if second_wins { b } else { a }
}

impl Found {
    fn with(self, other: Self) -> Self {
        Self {
            fastest: larger(self.fastest, other.fastest),
            farthest: larger(self.farthest, other.farthest),
        }
    }
}

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// What stands out among the cells from `first` to before `end`; `None` in an empty box. The same bits for any number of threads.
    #[must_use]
    pub fn extremes(&self, first: [usize; 3], end: [usize; 3]) -> Option<Extremes> {
        let rows = end[1].saturating_sub(first[1]);
        let planes = end[2].saturating_sub(first[2]);
        let length = end[0].saturating_sub(first[0]);
        let found = (0..rows * planes)
            .into_par_iter()
            .map_init(
                || {
                    let moments = [(); 4].map(|()| vec![T::default(); length]);
                    (moments, P::room(length))
                },
                |(moments, room), row| {
                    let start = [first[0], first[1] + row % rows, first[2] + row / rows];
                    self.extremes_of_row(start, moments, room)
                },
            )
            .reduce(Found::default, Found::with);
        let state = |(_, cell): Ranked| {
            let (density_excess, velocity) = self.bare_state(cell);
            CellState {
                cell,
                density_excess,
                speed: velocity.iter().map(|u| u * u).sum::<f64>().sqrt(),
            }
        };
        Some(Extremes {
            fastest: found.fastest.map(state),
            farthest: found.farthest.map(state)?,
        })
    }

    /// The same of the cells from `start` on along x, as many as `moments` (density excess and momentum) have room for.
    fn extremes_of_row(
        &self,
        start: [usize; 3],
        moments: &mut [Vec<T>; 4],
        room: &mut [T],
    ) -> Found {
        let index = self.grid.index(start.map(|c| c as i64));
        let length = moments[0].len();
        for moment in moments.iter_mut() {
            moment.fill(T::default());
        }
        // One population after the other: each is a stream along the row.
        for direction in 0..DIRECTION_COUNT {
            let (array, element) = self.grid.slot(index, direction, self.odd);
            let populations = &self.populations[array][element..element + length];
            let populations = P::values(populations, room);
            let [density, momentum @ ..] = &mut *moments;
            for (sum, f) in density.iter_mut().zip(populations) {
                *sum += *f;
            }
            for (sums, c) in momentum.iter_mut().zip(DIRECTIONS[direction]) {
                match c {
                    1 => sums.iter_mut().zip(populations).for_each(|(j, f)| *j += *f),
                    -1 => {
                        for (j, f) in sums.iter_mut().zip(populations) {
                            *j = *j - *f;
                        }
                    }
                    _ => {}
                }
            }
        }
        let ends = self.exchanged_ends.as_ref();
        let mut found = Found::default();
        for x in 0..length {
            let [excess, j @ ..] =
                match ends.and_then(|ends| ends.waiting_at([start[0] + x, start[1], start[2]])) {
                    None => [0, 1, 2, 3].map(|k: usize| moments[k][x].to_f64()),
                    Some(waiting) => {
                        let (excess, j) = bare_moments(&waiting);
                        [excess, j[0], j[1], j[2]].map(T::to_f64)
                    }
                };
            let density = 1.0 + excess;
            let square = (j[0] * j[0] + j[1] * j[1] + j[2] * j[2]) / (density * density);
            let cell = [start[0] + x, start[1], start[2]];
            let is_finite = excess.is_finite() && square.is_finite();
            let off = if is_finite {
                excess.abs()
            } else {
                f64::INFINITY
            };
            // Only the first of equal ones counts.
            if is_finite && found.fastest.is_none_or(|(most, _)| square > most) {
                found.fastest = Some((square, cell));
            }
            if found.farthest.is_none_or(|(most, _)| off > most) {
                found.farthest = Some((off, cell));
            }
        }
        found
    }
}
