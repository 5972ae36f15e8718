//! Boxes of cells half as large inside a lattice, and the cells through which two lattices know of each other.
//!
//! Eight fine cells fill a coarse one. Cells are told apart by their depth: that of a coarse cell is the number of coarse cells between it and the
//! nearest face of the box, negative outside.
//!
//! | depth | cells | what becomes of them when both lattices stand at one time |
//! |---|---|---|
//! | −1 to 1 | coarse | *source*: their states make the shell |
//! | 0 | fine, in layers of two | *shell*: filled from the source |
//! | 1 | coarse | *band*: restricted from the eight fine cells of each |
//!
//! A fine step spoils one layer of fine cells at the faces, so that two use up the shell. What lies deeper in the coarse lattice than the band
//! influences nothing, and is left out of its steps ([`IdleCells`]). Where the eddy viscosity of a cell follows from the velocities of its
//! neighbours, the band is two cells deep: the coarse air below the box knows nothing of what stands in it.

use std::ops::{Range, RangeInclusive};

use super::eddy_viscosity::EddyViscosity;

/// Where a box of finer cells lies in a lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nest {
    /// Its first cell of the lattice around it.
    pub first: [usize; 3],
    /// Cells of that lattice that it covers.
    pub cells: [usize; 3],
    /// Axes along which it covers all of a lattice that repeats, and repeats itself.
    pub spans: [bool; 3],
}

/// Neighbouring cells along x or y, in cells of the lattice around the box, counted from the box's first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line {
    /// 0 or 1.
    pub axis: usize,
    /// The first.
    pub start: [i64; 3],
    /// Their number.
    pub length: usize,
}

/// Cells of some depths, by planes of constant z.
#[derive(Debug, Clone)]
pub struct Planes {
    /// z of the first plane.
    pub first: i64,
    /// Lines of every plane.
    pub lines: Vec<Vec<Line>>,
}

impl Planes {
    /// Every cell.
    pub fn cells(&self) -> impl Iterator<Item = [i64; 3]> {
        self.lines.iter().flatten().flat_map(|line| {
            (0..line.length as i64).map(|i| {
                let mut cell = line.start;
                cell[line.axis] += i;
                cell
            })
        })
    }
}

/// Depths of the source.
pub const SOURCE: RangeInclusive<i64> = -1..=1;

/// Depth of the shell.
pub const SHELL: RangeInclusive<i64> = 0..=0;

/// Depth of the band.
pub const BAND: RangeInclusive<i64> = 1..=1;

/// The same where gradients of velocity are taken there.
pub const BAND_OF_GRADIENTS: RangeInclusive<i64> = 1..=2;

/// Depths of the band of a lattice of that kind.
#[must_use]
pub fn band(eddy_viscosity: Option<EddyViscosity>) -> RangeInclusive<i64> {
    match eddy_viscosity.and_then(|model| model.gradient_model()) {
        Some(_) => BAND_OF_GRADIENTS,
        None => BAND,
    }
}

/// Fine cells at the faces of a box that it exchanges with the lattice around it: shell and band.
pub const EXCHANGED_CELLS: usize = 4;

/// Cells beyond that of a cut link which a model of the boundary layer changes: from the next but one what leaves it arrives one further.
pub const CHANGED_BY_LAYERS: usize = 3;

/// Coarse cells that lie at least between a box and the faces of the lattice around it: source, and a cell whose populations its outermost cells stream from.
pub const CLEARANCE: usize = 3;

/// Coarse cells that a box is wide at least: two shells, two bands, and a cell between them.
pub const NARROWEST: usize = 5;

impl Nest {
    /// Cells of the box.
    #[must_use]
    pub fn fine_cells(&self) -> [usize; 3] {
        self.cells.map(|n| 2 * n)
    }

    /// True if it covers a cell of the lattice around it.
    #[must_use]
    pub fn covers(&self, cell: [usize; 3]) -> bool {
        (0..3).all(|a| (self.first[a]..self.first[a] + self.cells[a]).contains(&cell[a]))
    }

    /// True if another box in the same lattice is far enough away for both.
    #[must_use]
    pub fn is_apart_from(&self, other: &Self) -> bool {
        (0..3).any(|a| {
            let ends = |nest: &Self| nest.first[a] + nest.cells[a] + CLEARANCE;
            !self.spans[a] && (ends(self) <= other.first[a] || ends(other) <= self.first[a])
        })
    }

    /// True if it lies well inside a lattice of so many cells.
    #[must_use]
    pub fn fits(&self, outer: [usize; 3]) -> bool {
        (0..3).all(|a| {
            if self.spans[a] {
                self.first[a] == 0 && self.cells[a] == outer[a]
            } else {
                self.cells[a] >= NARROWEST
                    && self.first[a] >= CLEARANCE
                    && self.first[a] + self.cells[a] + CLEARANCE <= outer[a]
            }
        })
    }

    /// Depth of a cell counted from the box's first, by one axis; endless along one that it spans.
    const fn depth(&self, axis: usize, place: i64) -> i64 {
        if self.spans[axis] {
            return i64::MAX;
        }
        let from_end = self.cells[axis] as i64 - 1 - place;
        if place < from_end { place } else { from_end }
    }

    /// Places along an axis that are `least` deep, with those beyond the ends of an axis that repeats where `beyond`.
    const fn places(&self, axis: usize, least: i64, beyond: bool) -> (i64, i64) {
        let end = self.cells[axis] as i64;
        match (self.spans[axis], beyond) {
            (true, true) => (-1, end + 1),
            (true, false) => (0, end),
            (false, _) => (least, end - least),
        }
    }

    /// Cells of the given depths.
    #[must_use]
    pub fn cells_of(&self, depths: &RangeInclusive<i64>) -> Planes {
        let (least, most) = (*depths.start(), *depths.end());
        let beyond = least < 0;
        let [(x, x_end), (y, y_end), (z, z_end)] =
            [0, 1, 2].map(|axis| self.places(axis, least, beyond));
        let lines = (z..z_end)
            .map(|z| {
                let mut lines = Vec::new();
                let whole_plane = self.depth(2, z) <= most;
                for y in y..y_end {
                    if whole_plane || self.depth(1, y) <= most {
                        lines.push(Line {
                            axis: 0,
                            start: [x, y, z],
                            length: (x_end - x) as usize,
                        });
                    }
                }
                let inner: Vec<i64> = (y..y_end).filter(|y| self.depth(1, *y) > most).collect();
                if let (Some(first), false) = (inner.first(), whole_plane) {
                    for x in (x..x_end).filter(|x| self.depth(0, *x) <= most) {
                        lines.push(Line {
                            axis: 1,
                            start: [x, *first, z],
                            length: inner.len(),
                        });
                    }
                }
                lines
            })
            .collect();
        Planes { first: z, lines }
    }
}

/// Cells of a lattice deep below a box of finer cells, which no step needs to compute.
///
/// Where cells next to them are computed, they find there what they sent themselves, as at a wall: all stays finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IdleCells {
    /// The first.
    pub first: [usize; 3],
    /// One beyond the last.
    pub end: [usize; 3],
}

impl IdleCells {
    /// Those below the largest of some boxes in a lattice of that kind: deeper than the band. `None` where none are.
    #[must_use]
    pub fn below(boxes: &[Refinement], eddy_viscosity: Option<EddyViscosity>) -> Option<Self> {
        let depth = (*band(eddy_viscosity).end() + 1) as usize;
        let largest = boxes.iter().map(|refinement| &refinement.nest);
        let largest = largest.max_by_key(|nest| nest.cells.iter().product::<usize>())?;
        let margin = largest.spans.map(|spans| if spans { 0 } else { depth });
        (0..3)
            .all(|a| largest.cells[a] > 2 * margin[a])
            .then(|| Self {
                first: std::array::from_fn(|a| largest.first[a] + margin[a]),
                end: std::array::from_fn(|a| largest.first[a] + largest.cells[a] - margin[a]),
            })
    }

    /// Cells of a row at these y and z, in whole blocks of so many.
    #[must_use]
    pub fn blocks_of_row(&self, [y, z]: [usize; 2], block: usize) -> Range<usize> {
        let holds = |a: usize, place: usize| (self.first[a]..self.end[a]).contains(&place);
        if !holds(1, y) || !holds(2, z) {
            return 0..0;
        }
        let first = self.first[0].next_multiple_of(block);
        first..(self.end[0] / block * block).max(first)
    }
}

/// A box of finer cells, and the boxes in it. Of the boxes in a lattice the first holds all that acts on the air, in its finest cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refinement {
    /// Where it lies in the lattice around it.
    pub nest: Nest,
    /// Boxes in it.
    pub inner: Vec<Self>,
}

/// A lattice among those of nested boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Level {
    /// How often cells were halved from those of the outermost lattice.
    pub depth: usize,
    /// Corner [cells of the outermost lattice's size halved `finest` times, where `finest` is the depth around the structure].
    pub corner: [usize; 3],
    /// Its cells.
    pub cells: [usize; 3],
    /// Axes along which it repeats since it spans all of a lattice that does; none of the outermost.
    pub spans: [bool; 3],
}

impl Level {
    /// Cells of a box that are filled from the lattice around it at every exchange; none of the outermost.
    #[must_use]
    pub fn shell_cells(&self) -> f64 {
        if self.depth == 0 {
            return 0.0;
        }
        let across = |a: usize| self.cells[a] as f64;
        let inside = |a: usize| across(a) - if self.spans[a] { 0.0 } else { 4.0 };
        (0..3).map(across).product::<f64>() - (0..3).map(inside).product::<f64>()
    }
}

/// Depth of the boxes around the structure.
#[must_use]
pub fn depth(boxes: &[Refinement]) -> usize {
    boxes.first().map_or(0, |first| 1 + depth(&first.inner))
}

/// All lattices, each before those in it: first the outermost of `cells`, then the first box with what is in it, and so on.
#[must_use]
pub fn levels(cells: [usize; 3], boxes: &[Refinement]) -> Vec<Level> {
    let mut found = Vec::new();
    let outermost = Level {
        depth: 0,
        corner: [0; 3],
        cells,
        spans: [false; 3],
    };
    add_levels(outermost, boxes, depth(boxes), &mut found);
    found
}

fn add_levels(level: Level, boxes: &[Refinement], finest: usize, found: &mut Vec<Level>) {
    found.push(level);
    for Refinement { nest, inner } in boxes {
        let size = 1 << (finest - level.depth);
        let inside = Level {
            depth: level.depth + 1,
            corner: std::array::from_fn(|a| level.corner[a] + size * nest.first[a]),
            cells: nest.fine_cells(),
            spans: nest.spans,
        };
        add_levels(inside, inner, finest, found);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Below the largest box, deeper than its band; along an axis that it spans everywhere. Rows lose whole blocks.
    #[test]
    fn cells_below_the_largest_box_are_idle() {
        let refinement = |first: [usize; 3], cells: [usize; 3], spans: [bool; 3]| Refinement {
            nest: Nest {
                first,
                cells,
                spans,
            },
            inner: Vec::new(),
        };
        let small = refinement([4; 3], [8; 3], [false; 3]);
        let large = refinement([20, 0, 5], [40, 16, 9], [false, true, false]);
        let boxes = [small.clone(), large, small];
        let idle = IdleCells::below(&boxes, None).unwrap();
        assert_eq!([idle.first, idle.end], [[22, 0, 7], [58, 16, 12]]);
        assert_eq!(idle.blocks_of_row([15, 11], 16), 32..48);
        assert_eq!(idle.blocks_of_row([15, 11], 1), 22..58);
        assert!(idle.blocks_of_row([15, 12], 1).is_empty());
        assert!(idle.blocks_of_row([15, 11], 64).is_empty());
        let wale = IdleCells::below(&boxes, Some(EddyViscosity::wale(0.5))).unwrap();
        assert_eq!([wale.first, wale.end], [[23, 0, 8], [57, 16, 11]]);
        assert_eq!(IdleCells::below(&[], None), None);
        let narrow = refinement([4; 3], [8, 5, 5], [false; 3]);
        let wale = Some(EddyViscosity::wale(0.5));
        assert_eq!(IdleCells::below(&[narrow], wale), None);
    }

    /// Every cell of a depth is in one line, and no other.
    #[test]
    fn lines_cover_every_cell_of_a_depth_once() {
        for spans in [[false; 3], [false, false, true], [false, true, true]] {
            let nest = Nest {
                first: [4; 3],
                cells: [8, 7, 6],
                spans,
            };
            for depths in [SOURCE, SHELL, BAND] {
                let planes = nest.cells_of(&depths);
                let mut found = BTreeSet::new();
                for (z, lines) in (planes.first..).zip(&planes.lines) {
                    for line in lines {
                        for i in 0..line.length as i64 {
                            let mut cell = line.start;
                            cell[line.axis] += i;
                            assert_eq!(cell[2], z);
                            assert!(found.insert(cell), "{cell:?} twice");
                        }
                    }
                }
                let mut expected = BTreeSet::new();
                let reach = |axis: usize| {
                    let beyond = i64::from(!spans[axis] || depths == SOURCE);
                    -beyond..nest.cells[axis] as i64 + beyond
                };
                for z in reach(2) {
                    for y in reach(1) {
                        for x in reach(0) {
                            let cell = [x, y, z];
                            let depth = (0..3).map(|a| nest.depth(a, cell[a])).min().unwrap();
                            if depths.contains(&depth) {
                                expected.insert(cell);
                            }
                        }
                    }
                }
                assert_eq!(found, expected, "{spans:?} {depths:?}");
            }
        }
    }
}
