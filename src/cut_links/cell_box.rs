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
        let mut from = [0; 3];
        for a in 0..3 {
            from[a] = usize::try_from(cell[a].wrapping_sub(self.first[a])).ok()?;
            if from[a] >= self.size[a] {
                return None;
            }
        }
        Some(from[0] + self.size[0] * (from[1] + self.size[1] * from[2]))
    }

    /// The cell of a row, rows counted along y, then z.
    pub fn cell(&self, row: usize, x: usize) -> [i32; 3] {
        let rows = self.size[1].max(1);
        let from = [x, row % rows, row / rows];
        std::array::from_fn(|a| self.first[a] + from[a] as i32)
    }
}
