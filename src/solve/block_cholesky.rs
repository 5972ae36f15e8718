//! Cholesky factorisation of sparse symmetric matrices of 3×3 blocks in double precision, by supernodes and in an order of minimum degree (faer).
//!
//! The pattern is analysed once. In one thread, so that results do not depend on their number.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};

use super::multigrid::blocks::{BlockMatrix, Pattern};

/// A matrix and its factor.
pub struct BlockCholesky {
    /// Whose diagonal is still without what [`BlockCholesky::factorise`] adds.
    pub matrix: BlockMatrix<f64>,
    /// Which numbers the lower triangle has, column by column, and what they are.
    columns: SymbolicSparseColMat<usize>,
    lower: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl BlockCholesky {
    /// Analyses a symmetric pattern; `None` where memory does not suffice.
    #[must_use]
    pub fn new(pattern: &Pattern) -> Option<Self> {
        let rows = pattern.row_count();
        let mut starts = Vec::with_capacity(3 * rows + 1);
        let mut places = Vec::new();
        starts.push(0);
        for row in 0..rows {
            for k in 0..3 {
                places.extend((k..3).map(|i| 3 * row + i));
                for &other in below(pattern, row) {
                    places.extend([0, 1, 2].map(|i| 3 * other as usize + i));
                }
                starts.push(places.len());
            }
        }
        let count = places.len();
        let columns = SymbolicSparseColMat::new_checked(3 * rows, 3 * rows, starts, None, places);
        let symbolic = factorize_symbolic_cholesky(
            columns.as_ref(),
            Side::Lower,
            SymmetricOrdering::Amd,
            Default::default(),
        )
        .ok()?;
        let need = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::try_new(need).ok()?;
        let mut factor = Vec::new();
        factor.try_reserve_exact(symbolic.len_val()).ok()?;
        factor.resize(symbolic.len_val(), 0.0);
        Some(Self {
            matrix: BlockMatrix::new(pattern.clone()),
            lower: vec![0.0; count],
            columns,
            symbolic,
            factor,
            memory,
        })
    }

    /// Numbers that the factor holds.
    #[must_use]
    pub fn factor_len(&self) -> usize {
        self.factor.len()
    }

    /// Factorises the blocks plus `diagonal(row)` on the diagonal of every row; false if that is not positive definite.
    pub fn factorise(&mut self, diagonal: impl Fn(usize) -> f64) -> bool {
        let mut place = 0;
        let pattern = &self.matrix.pattern;
        for row in 0..pattern.row_count() {
            let Some(own) = pattern.within_row(row, row as u32) else {
                return false;
            };
            // Column k of the lower triangle is row k of the blocks from the diagonal on: the matrix is symmetric.
            let blocks = &self.matrix.row(row)[own..];
            let more = diagonal(row);
            for k in 0..3 {
                for i in k..3 {
                    self.lower[place] = blocks[0][3 * k + i] + if i == k { more } else { 0.0 };
                    place += 1;
                }
                for block in &blocks[1..] {
                    self.lower[place..place + 3].copy_from_slice(&block[3 * k..3 * k + 3]);
                    place += 3;
                }
            }
        }
        let matrix = SparseColMatRef::new(self.columns.as_ref(), &self.lower);
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .is_ok()
    }

    /// Overwrites a vector, three numbers per row, with the inverse of what was factorised last times it.
    pub fn solve(&mut self, vector: &mut [f64]) {
        let rows = vector.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(vector, rows, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }
}

impl std::fmt::Debug for BlockCholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BlockCholesky")
            .field("rows", &self.matrix.pattern.row_count())
            .field("factor_len", &self.factor.len())
            .finish_non_exhaustive()
    }
}

/// Columns of a row beyond the diagonal.
fn below(pattern: &Pattern, row: usize) -> &[u32] {
    let columns = pattern.columns(row);
    let first = columns.partition_point(|&column| column as usize <= row);
    &columns[first..]
}
