//! A box of cells whose balance of mass and momentum is kept: which populations cross its faces in a step.

use super::grid::Grid;
use super::{DIRECTION_COUNT, DIRECTIONS};

/// Mass and momentum [lattice units].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MassMomentum {
    /// Σ δρ.
    pub mass_excess: f64,
    /// Σ f c.
    pub momentum: [f64; 3],
}

impl MassMomentum {
    /// Adds another.
    pub fn add(&mut self, other: &Self) {
        self.mass_excess += other.mass_excess;
        for a in 0..3 {
            self.momentum[a] += other.momentum[a];
        }
    }
}

/// Addresses of all populations that cross the faces of a box of cells in a step.
#[derive(Debug, Clone)]
pub struct ControlVolume {
    /// First cell.
    pub first: [usize; 3],
    /// One past the last cell.
    pub end: [usize; 3],
    /// Per parity and direction: (array, elements leaving, elements entering).
    pub crossings: [Vec<Crossing>; 2],
}

/// Populations of one direction that cross the faces.
#[derive(Debug, Clone)]
pub struct Crossing {
    /// The direction.
    pub direction: usize,
    /// Array of those that leave.
    pub leaving_array: usize,
    /// Their elements.
    pub leaving: Vec<u32>,
    /// Array of those that enter.
    pub entering_array: usize,
    /// Their elements.
    pub entering: Vec<u32>,
}

impl ControlVolume {
    /// Box of cells `first..end`, inside the domain of `grid`.
    #[must_use]
    pub fn new(grid: &Grid, first: [usize; 3], end: [usize; 3]) -> Self {
        let crossings = [false, true].map(|odd| {
            (1..DIRECTION_COUNT)
                .map(|direction| crossing(grid, first, end, direction, odd))
                .collect()
        });
        Self {
            first,
            end,
            crossings,
        }
    }

    /// Cells inside.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        (0..3).map(|a| self.end[a] - self.first[a]).product()
    }
}

fn crossing(
    grid: &Grid,
    first: [usize; 3],
    end: [usize; 3],
    direction: usize,
    odd: bool,
) -> Crossing {
    let c = DIRECTIONS[direction];
    let mut result = Crossing {
        direction,
        leaving_array: 0,
        leaving: Vec::new(),
        entering_array: 0,
        entering: Vec::new(),
    };
    let inside =
        |cell: [i64; 3]| (0..3).all(|a| cell[a] >= first[a] as i64 && cell[a] < end[a] as i64);
    for z in first[2]..end[2] {
        for y in first[1]..end[1] {
            // Of rows inside only the ends lie beside a face.
            let between = |a: usize, i: usize| i > first[a] && i + 1 < end[a];
            let whole = !(between(1, y) && between(2, z));
            let step = if whole {
                1
            } else {
                (end[0] - 1 - first[0]).max(1)
            };
            for x in (first[0]..end[0]).step_by(step) {
                let cell = [x as i64, y as i64, z as i64];
                let next: [i64; 3] = std::array::from_fn(|a| cell[a] + i64::from(c[a]));
                if !inside(next) {
                    let (array, element) = grid.slot(grid.index(next), direction, odd);
                    result.leaving_array = array;
                    result.leaving.push(element as u32);
                }
                let previous: [i64; 3] = std::array::from_fn(|a| cell[a] - i64::from(c[a]));
                if !inside(previous) {
                    let (array, element) = grid.slot(grid.index(cell), direction, odd);
                    result.entering_array = array;
                    result.entering.push(element as u32);
                }
            }
        }
    }
    result
}
