//! Sparse symmetric matrices of 3×3 blocks, and which entries they have.

use std::ops::Range;

use glam::Vec4;
use rayon::prelude::*;

/// A 3×3 block, row by row.
pub type Block<T = f32> = [T; 9];

/// What a block is made of.
pub trait Entry: Copy + Default + Send + Sync + std::ops::AddAssign {
    /// Rounded, if need be.
    fn of(value: f64) -> Self;
}

impl Entry for f32 {
    fn of(value: f64) -> Self {
        value as Self
    }
}

impl Entry for f64 {
    fn of(value: f64) -> Self {
        value
    }
}

/// Rows that one task fills.
const ROWS_AT_ONCE: usize = 512;

/// Which blocks of a matrix are stored: compressed rows with ascending columns; the diagonal is always there.
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    starts: Vec<u32>,
    columns: Vec<u32>,
}

impl Pattern {
    /// From the columns of every row, ascending.
    #[must_use]
    pub fn from_rows(rows: &[Vec<u32>]) -> Self {
        let mut starts = Vec::with_capacity(rows.len() + 1);
        starts.push(0);
        let mut columns = Vec::with_capacity(rows.iter().map(Vec::len).sum());
        for row in rows {
            columns.extend_from_slice(row);
            starts.push(columns.len() as u32);
        }
        Self { starts, columns }
    }

    /// Every row joined with every other of the same group (the nodes of an element).
    #[must_use]
    pub fn from_groups<'a>(rows: usize, groups: impl Iterator<Item = &'a [u32]>) -> Self {
        let mut columns: Vec<Vec<u32>> = (0..rows as u32).map(|row| vec![row]).collect();
        for group in groups {
            for &a in group {
                for &b in group {
                    if a != b {
                        columns[a as usize].push(b);
                    }
                }
            }
        }
        columns.par_iter_mut().for_each(|row| {
            row.sort_unstable();
            row.dedup();
        });
        Self::from_rows(&columns)
    }

    /// Number of rows.
    #[must_use]
    pub const fn row_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of stored blocks.
    #[must_use]
    pub const fn block_count(&self) -> usize {
        self.columns.len()
    }

    /// Places of a row's blocks.
    #[inline]
    #[must_use]
    pub fn row(&self, row: usize) -> Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// Columns of a row.
    #[inline]
    #[must_use]
    pub fn columns(&self, row: usize) -> &[u32] {
        &self.columns[self.row(row)]
    }

    /// Place of a block within its row.
    #[inline]
    #[must_use]
    pub fn within_row(&self, row: usize, column: u32) -> Option<usize> {
        self.columns(row).binary_search(&column).ok()
    }
}

/// A symmetric matrix of 3×3 blocks: in single precision good enough to precondition with, and half the bytes.
#[derive(Debug, Clone, Default)]
pub struct BlockMatrix<T = f32> {
    /// Which blocks there are.
    pub pattern: Pattern,
    /// One more than the pattern has, so that four numbers can be read from where the last row of a block begins.
    values: Vec<Block<T>>,
}

impl<T: Entry> BlockMatrix<T> {
    /// All zero.
    #[must_use]
    pub fn new(pattern: Pattern) -> Self {
        let values = vec![[T::default(); 9]; pattern.block_count() + 1];
        Self { pattern, values }
    }

    /// Blocks of a row, in the order of its columns.
    #[inline]
    #[must_use]
    pub fn row(&self, row: usize) -> &[Block<T>] {
        &self.values[self.pattern.row(row)]
    }

    /// Calls `fill` for every row, in parallel, with its blocks set to zero; `scratch` makes what a thread may keep between rows.
    pub fn fill_rows<S>(
        &mut self,
        scratch: impl Fn() -> S + Sync + Send,
        fill: impl Fn(&mut S, usize, &[u32], &mut [Block<T>]) + Sync + Send,
    ) {
        let pattern = &self.pattern;
        let rows = pattern.row_count();
        let mut chunks = Vec::with_capacity(rows.div_ceil(ROWS_AT_ONCE));
        let mut rest = &mut self.values[..];
        for first in (0..rows).step_by(ROWS_AT_ONCE) {
            let end = (first + ROWS_AT_ONCE).min(rows);
            let length = (pattern.starts[end] - pattern.starts[first]) as usize;
            let (head, tail) = rest.split_at_mut(length);
            chunks.push((first..end, head));
            rest = tail;
        }
        chunks
            .into_par_iter()
            .for_each_init(scratch, |scratch, (range, mut values)| {
                for row in range {
                    let columns = pattern.columns(row);
                    let (own, rest) = values.split_at_mut(columns.len());
                    own.fill([T::default(); 9]);
                    fill(scratch, row, columns, own);
                    values = rest;
                }
            });
    }

    /// Diagonal block of a row.
    #[must_use]
    pub fn diagonal(&self, row: usize) -> Block<T> {
        match self.pattern.within_row(row, row as u32) {
            Some(place) => self.row(row)[place],
            None => [T::default(); 9],
        }
    }
}

impl BlockMatrix {
    /// One row of the product with a vector.
    #[inline]
    #[must_use]
    pub fn multiply_row(&self, row: usize, vector: &[[f32; 3]]) -> [f32; 3] {
        let range = self.pattern.row(row);
        let columns = &self.pattern.columns[range.clone()];
        // Rows of blocks times (x, y, z, 0), side by side; the fourth lane holds the next row's beginning and is dropped.
        let blocks = &self.values.as_flattened()[9 * range.start..9 * range.end + 3];
        let mut sums = [Vec4::ZERO; 3];
        for (place, &column) in columns.iter().enumerate() {
            let [x, y, z] = vector[column as usize];
            let v = Vec4::new(x, y, z, 0.0);
            let block = &blocks[9 * place..9 * place + 10];
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += Vec4::from_slice(&block[3 * k..3 * k + 4]) * v;
            }
        }
        sums.map(|sum| sum.x + sum.y + sum.z)
    }
}
