//! Layout of a block matrix on the device: slices of 64 rows, each as wide as its longest row (sliced ELLPACK, Monakov, Lokhmotov &
//! Avetisyan 2010), so that neighbouring threads read neighbouring numbers.

use crate::gpu::shaders::WORKGROUP;
use crate::solve::multigrid::blocks::{Block, BlockMatrix, Pattern};

/// Rows of a slice: those of a workgroup.
const ROWS: usize = WORKGROUP as usize;

/// In place of a row: the place only fills its row up.
const NONE: u32 = u32::MAX;

/// Where the blocks of a pattern are.
#[derive(Debug)]
pub struct Sliced {
    /// First of every slice, in units of 64 places; and the end of the last.
    pub slices: Vec<u32>,
    /// Column of every place; a place that fills its row up stands in the row's own column.
    pub columns: Vec<u32>,
    /// Row of every place, NONE where it fills up.
    pub rows: Vec<u32>,
}

impl Sliced {
    /// Lays a pattern out.
    #[must_use]
    pub fn new(pattern: &Pattern) -> Self {
        let rows = pattern.row_count();
        let mut sliced = Self {
            slices: vec![0],
            columns: Vec::new(),
            rows: Vec::new(),
        };
        for first in (0..rows).step_by(ROWS) {
            let within = first..(first + ROWS).min(rows);
            let width = within.clone().map(|row| pattern.row(row).len()).max();
            for k in 0..width.unwrap_or(0) {
                for lane in 0..ROWS {
                    let row = first + lane;
                    // Lanes beyond the last row are never read.
                    let column = (row < rows).then(|| pattern.columns(row).get(k));
                    sliced.columns.push(match column {
                        Some(Some(&column)) => column,
                        Some(None) => row as u32,
                        None => 0,
                    });
                    let stored = matches!(column, Some(Some(_)));
                    sliced.rows.push(if stored { row as u32 } else { NONE });
                }
            }
            sliced.slices.push((sliced.columns.len() / ROWS) as u32);
        }
        sliced
    }

    /// Numbers of the matrix, 9 per place.
    #[must_use]
    pub fn numbers(&self) -> usize {
        9 * self.columns.len()
    }

    /// Place of the `k`-th block of a row.
    #[must_use]
    pub fn place(&self, row: usize, k: usize) -> usize {
        (self.slices[row / ROWS] as usize + k) * ROWS + row % ROWS
    }

    /// The numbers of a matrix as the device holds them.
    #[must_use]
    pub fn values(&self, matrix: &BlockMatrix) -> Vec<f32> {
        let mut values = vec![0.0; self.numbers()];
        for row in 0..matrix.pattern.row_count() {
            for (k, block) in matrix.row(row).iter().enumerate() {
                let place = self.place(row, k);
                for (c, value) in block.iter().enumerate() {
                    values[component(place, c)] = *value;
                }
            }
        }
        values
    }

    /// The matrix that [`Sliced::values`] laid out.
    #[must_use]
    pub fn matrix(&self, pattern: &Pattern, values: &[f32]) -> BlockMatrix {
        let mut matrix = BlockMatrix::new(pattern.clone());
        matrix.fill_rows(
            || (),
            |(), row, _, blocks: &mut [Block]| {
                for (k, block) in blocks.iter_mut().enumerate() {
                    let place = self.place(row, k);
                    *block = std::array::from_fn(|c| values[component(place, c)]);
                }
            },
        );
        matrix
    }
}

const fn component(place: usize, c: usize) -> usize {
    (place / ROWS * 9 + c) * ROWS + place % ROWS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_has_one_place() {
        // 100 rows of one to four blocks.
        let rows: Vec<Vec<u32>> = (0..100_u32)
            .map(|row| (row.saturating_sub(row % 4)..=row).collect())
            .collect();
        let pattern = Pattern::from_rows(&rows);
        let mut matrix = BlockMatrix::new(pattern.clone());
        matrix.fill_rows(
            || (),
            |(), row, columns, blocks| {
                for (&column, block) in columns.iter().zip(blocks) {
                    *block =
                        std::array::from_fn(|c| (1000 * row + 10 * column as usize + c) as f32);
                }
            },
        );
        let sliced = Sliced::new(&pattern);
        assert_eq!(sliced.slices, [0, 4, 8]);
        let stored = sliced.rows.iter().filter(|row| **row != NONE).count();
        assert_eq!(stored, pattern.block_count());
        let values = sliced.values(&matrix);
        let back = sliced.matrix(&pattern, &values);
        for row in 0..100 {
            assert_eq!(matrix.row(row), back.row(row));
            for (k, &column) in pattern.columns(row).iter().enumerate() {
                assert_eq!(sliced.columns[sliced.place(row, k)], column);
            }
        }
    }
}
