//! A box of cells, each with its place in the order of memory.

/// The smallest box that holds some cells.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CellBox {
    first: [i32; 3],
    size: [usize; 3],
}

impl CellBox {
    /// Around `cells`; empty without any.
    pub fn around(cells: impl Iterator<Item = [i32; 3]>) -> Self {
        let mut bounds = [[i32::MAX; 3], [i32::MIN; 3]];
        for cell in cells {
            for a in 0..3 {
                bounds[0][a] = bounds[0][a].min(cell[a]);
                bounds[1][a] = bounds[1][a].max(cell[a]);
            }
        }
        let [first, last] = bounds;
        Self {
            first,
            size: std::array::from_fn(|a| {
                usize::try_from(i64::from(last[a]) - i64::from(first[a]) + 1).unwrap_or(0)
            }),
        }
    }

    /// The smallest box that holds this one and another.
    pub fn with(self, other: Self) -> Self {
        if self.count() == 0 {
            return other;
        }
        if other.count() == 0 {
            return self;
        }
        Self::around([self, other].into_iter().flat_map(Self::corners))
    }

    /// This box and the cells up to `by` from it that the air has; the whole axis where it passes a side that repeats. Empty if this is.
    pub fn grown(self, by: usize, cells: [usize; 3], repeats: [bool; 3]) -> Self {
        let Some([first, last]) = self.bounds() else {
            return self;
        };
        let (by, mut corners) = (by as i32, [first, last]);
        for a in 0..3 {
            let end = cells[a] as i32 - 1;
            let bounds = [first[a] - by, last[a] + by];
            let passes = bounds[0] < 0 || bounds[1] > end;
            let all = passes && repeats[a];
            corners[0][a] = if all { 0 } else { bounds[0].max(0) };
            corners[1][a] = if all { end } else { bounds[1].min(end) };
        }
        Self::around(corners.into_iter())
    }

    fn corners(self) -> [[i32; 3]; 2] {
        let last = std::array::from_fn(|a| self.first[a] + self.size[a] as i32 - 1);
        [self.first, last]
    }

    /// Least and largest places of its cells; `None` without any.
    pub fn bounds(self) -> Option<[[i32; 3]; 2]> {
        (self.count() > 0).then(|| self.corners())
    }

    /// Number of its cells.
    pub fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Cells of a row along x.
    pub const fn row_length(&self) -> usize {
        self.size[0]
    }

    /// Place of a cell, x fastest; `None` outside.
    #[inline]
    pub fn place(&self, cell: [i32; 3]) -> Option<usize> {
        // Below the first it wraps round to far beyond the last.
        let from: [usize; 3] =
            std::array::from_fn(|a| cell[a].wrapping_sub(self.first[a]) as u32 as usize);
        let inside = from[0] < self.size[0] && from[1] < self.size[1] && from[2] < self.size[2];
        inside.then(|| from[0] + self.size[0] * (from[1] + self.size[1] * from[2]))
    }

    /// The cell of a row, rows counted along y, then z.
    pub fn cell(&self, row: usize, x: usize) -> [i32; 3] {
        let rows = self.size[1].max(1);
        let from = [x, row % rows, row / rows];
        std::array::from_fn(|a| self.first[a] + from[a] as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the middle, at faces, across one that repeats, and of nothing.
    #[test]
    fn grown_boxes_hold_the_cells_around() {
        let grown = |cells: &[[i32; 3]], repeats| {
            let own = CellBox::around(cells.iter().copied());
            own.grown(2, [9, 7, 5], repeats).bounds()
        };
        let two = [[4, 1, 3], [5, 1, 3]];
        assert_eq!(grown(&two, [false; 3]), Some([[2, 0, 1], [7, 3, 4]]));
        assert_eq!(grown(&two, [true; 3]), Some([[2, 0, 0], [7, 6, 4]]));
        assert_eq!(grown(&[], [true; 3]), None);
    }
}
