//! Where the populations of a cut link lie in memory.

use super::bounce::Side;
use super::search::CutLink;
use crate::lattice::grid::{Grid, Setup};
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, opposite};

/// Number of an array and element in it.
pub type Place = (usize, usize);

/// Cells of the lattice that a link's populations are looked for in.
#[derive(Debug, Clone, Copy)]
pub struct Places {
    /// Layout of the arrays.
    grid: Grid,
    /// Axes along which the domain repeats.
    repeats: [bool; 3],
    /// The step to come is an odd one.
    odd: bool,
    /// For each direction the array of what leaves a cell, and how far its element lies from that of the cell, where no side repeats between.
    leaving: [(usize, isize); DIRECTION_COUNT],
}

impl Places {
    /// Of a lattice of this layout and set-up.
    #[must_use]
    pub fn new(grid: Grid, setup: &Setup, odd: bool) -> Self {
        let own = grid.index([0; 3]);
        let leaving = std::array::from_fn(|direction| {
            let next = grid.index(DIRECTIONS[direction].map(i64::from));
            let (array, element) = grid.slot(next, direction, odd);
            (array, element.wrapping_sub(own) as isize)
        });
        Self {
            grid,
            repeats: setup.repeats(),
            odd,
            leaving,
        }
    }

    fn of(&self, cell: [i32; 3], direction: usize) -> Place {
        let index = self.grid.index(cell.map(i64::from));
        self.grid.slot(index, direction, self.odd)
    }

    /// The cell beside one, or that which it repeats.
    fn beside(&self, cell: [i32; 3], by: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|a| {
            let place = cell[a] + by[a];
            if self.repeats[a] {
                place.rem_euclid(self.grid.cells[a] as i32)
            } else {
                place
            }
        })
    }

    /// What left a side's cell along the link: it has arrived at the other cell.
    #[must_use]
    pub fn out(&self, link: &CutLink, side: usize) -> Place {
        self.of(link.cells[1 - side], link.leaving(side))
    }

    /// The further population that a side needs; `None` half-way.
    #[must_use]
    pub fn further(&self, link: &CutLink, side: usize) -> Option<Place> {
        let (cell, leaving) = (link.cells[side], link.leaving(side));
        match link.side(side) {
            Side::HalfWay => None,
            Side::Near => Some(self.of(cell, leaving)),
            Side::Far => {
                let behind = self.beside(cell, DIRECTIONS[opposite(leaving)]);
                Some(self.of(behind, opposite(leaving)))
            }
        }
    }

    /// What left a cell, by direction.
    #[inline]
    pub fn leaving(&self, cell: [i32; 3]) -> impl Fn(usize) -> Place {
        let index = self.index_inside(cell);
        move |direction| match index {
            Some(index) => {
                let (array, by) = self.leaving[direction];
                (array, index.wrapping_add_signed(by))
            }
            None => self.of(self.beside(cell, DIRECTIONS[direction]), direction),
        }
    }

    /// Index of a cell, unless a side next to it repeats.
    #[inline(always)]
    #[must_use]
    pub fn index_inside(&self, cell: [i32; 3]) -> Option<usize> {
        let at_a_side = (0..3)
            .any(|a| self.repeats[a] && (cell[a] == 0 || cell[a] + 1 == self.grid.cells[a] as i32));
        (!at_a_side).then(|| self.grid.index(cell.map(i64::from)))
    }

    /// By direction, the array of what left a cell there, and how far its element lies from the cell's index.
    #[must_use]
    pub const fn offsets(&self) -> &[(usize, isize); DIRECTION_COUNT] {
        &self.leaving
    }

    /// What comes back to a side's cell.
    #[must_use]
    pub fn back(&self, link: &CutLink, side: usize) -> Place {
        self.of(link.cells[side], opposite(link.leaving(side)))
    }

    /// Element of the population at rest of a side's cell.
    #[must_use]
    pub fn rest(&self, link: &CutLink, side: usize) -> usize {
        self.grid.index(link.cells[side].map(i64::from))
    }
}
