//! Dense equations by LU with partial pivoting: faer's factorisation and products on blocks of columns, which rayon's threads share.
//!
//! Right-looking and blocked (Golub & Van Loan 2013, section 3.6). faer could share the work itself with its feature `rayon`, which brings
//! thirty more packages; dealing out the columns takes the lines below.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::AeroError;

/// Columns factorised at once.
const BLOCK: usize = 96;

/// Columns per piece of work.
const PIECE: usize = 128;

/// A factorised square matrix.
#[derive(Debug)]
pub struct Factors {
    /// L below the diagonal, U on and above it, column by column.
    columns: Vec<f64>,
    size: usize,
    /// Row of the matrix that each row of the factors came from.
    rows: Vec<usize>,
}

impl Factors {
    /// Factorises a matrix given column by column.
    pub fn new(mut columns: Vec<f64>, size: usize) -> Result<Self, AeroError> {
        let mut rows: Vec<usize> = (0..size).collect();
        for first in (0..size).step_by(BLOCK) {
            let count = BLOCK.min(size - first);
            let (before, rest) = columns.split_at_mut(first * size);
            let (panel, after) = rest.split_at_mut(count * size);
            let order = factorise(panel, size, first, count);
            let exchange = |column: &mut [f64]| {
                let old = column[first..].to_vec();
                for (value, &from) in column[first..].iter_mut().zip(&order) {
                    *value = old[from];
                }
            };
            before.par_chunks_mut(size).for_each(exchange);
            let panel = MatRef::from_column_major_slice(panel, size, count);
            let lower = panel.subrows(first, count);
            let below = panel.subrows(first + count, size - first - count);
            after.par_chunks_mut(PIECE * size).for_each(|piece| {
                piece.chunks_mut(size).for_each(exchange);
                let width = piece.len() / size;
                let piece = MatMut::from_column_major_slice_mut(piece, size, width);
                let (_, active) = piece.split_at_row_mut(first);
                let (mut upper, rest) = active.split_at_row_mut(count);
                solve_unit_lower_triangular_in_place(lower, upper.as_mut(), Par::Seq);
                matmul(rest, Accum::Add, below, upper.as_ref(), -1.0, Par::Seq);
            });
            let old = rows[first..].to_vec();
            for (row, &from) in rows[first..].iter_mut().zip(&order) {
                *row = old[from];
            }
        }
        let pivots = || (0..size).map(|k| columns[k * (size + 1)].abs());
        let largest = pivots().fold(0.0, f64::max);
        match pivots().position(|pivot| !(pivot > 1e-14 * largest && pivot.is_finite())) {
            Some(row) => Err(AeroError::Singular(row)),
            None => Ok(Self {
                columns,
                size,
                rows,
            }),
        }
    }

    /// Solves for right-hand sides given one after the other.
    #[must_use]
    pub fn solve(&self, sides: &[f64]) -> Vec<f64> {
        let size = self.size;
        let factors = MatRef::from_column_major_slice(&self.columns, size, size);
        let mut solutions: Vec<f64> = sides
            .par_chunks(size)
            .flat_map_iter(|side| self.rows.iter().map(|&row| side[row]))
            .collect();
        let pieces = (solutions.len() / size.max(1)).div_ceil(rayon::current_num_threads());
        solutions
            .par_chunks_mut(size * pieces.max(1))
            .for_each(|piece| {
                let width = piece.len() / size;
                let mut piece = MatMut::from_column_major_slice_mut(piece, size, width);
                solve_unit_lower_triangular_in_place(factors, piece.as_mut(), Par::Seq);
                solve_upper_triangular_in_place(factors, piece, Par::Seq);
            });
        solutions
    }
}

/// Factorises the rows from `first` on of some columns; returns the new order of those rows, counted from `first`.
fn factorise(panel: &mut [f64], size: usize, first: usize, count: usize) -> Vec<usize> {
    let matrix = MatMut::from_column_major_slice_mut(panel, size, count);
    let (_, active) = matrix.split_at_row_mut(first);
    let length = size - first;
    let mut order = vec![0usize; length];
    let mut inverse = vec![0usize; length];
    let scratch = lu_in_place_scratch::<usize, f64>(length, count, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    lu_in_place(
        active,
        &mut order,
        &mut inverse,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    );
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(size: usize) -> Vec<f64> {
        let mut state = 7u64;
        (0..size * size)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
            })
            .collect()
    }

    /// Random matrices, which need pivots, smaller and larger than a block.
    #[test]
    fn solutions_fulfil_the_equations() {
        for size in [1, 5, BLOCK, 2 * BLOCK + 37, 3 * PIECE] {
            let columns = matrix(size);
            let sides: Vec<f64> = matrix(size)[..size]
                .iter()
                .cycle()
                .take(3 * size)
                .copied()
                .collect();
            let factors = Factors::new(columns.clone(), size).unwrap();
            let solutions = factors.solve(&sides);
            for (side, solution) in sides.chunks(size).zip(solutions.chunks(size)) {
                for i in 0..size {
                    let sum: f64 = (0..size).map(|j| columns[j * size + i] * solution[j]).sum();
                    assert!((sum - side[i]).abs() < 1e-9 * size as f64, "{size} {i}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut columns = matrix(150);
        let (first, rest) = columns.split_at_mut(150);
        rest[..150].copy_from_slice(first);
        assert!(matches!(
            Factors::new(columns, 150),
            Err(AeroError::Singular(_))
        ));
    }
}
