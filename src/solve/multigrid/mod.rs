//! One V-cycle of algebraic multigrid as an approximate inverse of a symmetric positive semidefinite matrix of 3×3 blocks.
//!
//! Interpolation is made once from the mesh ([`coarsening`]); the matrices of the levels, A_coarse = PᵀAP, follow every refresh. The
//! smoother is a Chebyshev polynomial in the block-Jacobi preconditioned matrix, the same before and after the coarse correction, so the
//! cycle is a symmetric operator, as a minimiser asks of its initial Hessian. The coarsest level is solved directly.
//!
//! Everything is in single precision: the vector is scaled before, and the result only guides the minimiser.

pub mod blocks;
pub mod coarsening;
pub mod hierarchy;

use glam::Vec3;
use rayon::prelude::*;

use blocks::{Block, BlockMatrix, Pattern};
use coarsening::{Graph, Interpolation};
use hierarchy::{REGULARISATION, coarsest_inverse, hierarchy};

/// Degree of the smoother's polynomial, before and after the coarse correction.
pub const DEGREE: usize = 2;

/// Degree on a coarsest level that is too large to be solved directly.
pub const COARSEST_DEGREE: usize = 20;

/// The smoother damps eigenvalues from the largest down to this share of it.
pub const SMOOTHED_SHARE: f32 = 0.1;

/// Power iterations for the largest eigenvalue, at first and at a refresh.
pub const POWER_ITERATIONS: [usize; 2] = [16, 10];

/// Safety on the largest eigenvalue, which the power iteration approaches from below. Beyond the interval the smoother's polynomial
/// amplifies, and the cycle may lose its sign: over the sheets of `benches/cloth`, whose stiffest places move from refresh to refresh, the
/// true value was at most 1.21 times the estimate after ten iterations (1.41 after three).
pub const EIGENVALUE_MARGIN: f32 = 1.3;

/// Nodes that one task works on.
const NODES_AT_ONCE: usize = 2048;

type Vector = Vec<[f32; 3]>;

#[derive(Debug, Clone)]
struct Level {
    matrix: BlockMatrix,
    inverse_diagonal: Vec<Block>,
    largest_eigenvalue: f32,
    eigenvector: Vector,
    /// To the next coarser level; absent on the coarsest.
    interpolation: Option<[Interpolation; 2]>,
    right: Vector,
    solution: Vector,
    residual: Vector,
    step: Vector,
}

/// The levels, and the inverse of the coarsest.
#[derive(Debug, Clone)]
pub struct Multigrid {
    levels: Vec<Level>,
    /// Dense, row by row; empty where the coarsest level is too large.
    coarsest_inverse: Vec<f32>,
    refreshed: bool,
    cycles: u64,
}

fn inverse(block: &Block) -> Block {
    let b = block.map(f64::from);
    let scale = b[0].max(b[4]).max(b[8]);
    if !(scale > 0.0 && scale.is_finite()) {
        return [0.0; 9];
    }
    let add = f64::from(REGULARISATION) * scale;
    let m = glam::DMat3::from_cols_array(&[
        b[0] + add,
        b[3],
        b[6],
        b[1],
        b[4] + add,
        b[7],
        b[2],
        b[5],
        b[8] + add,
    ]);
    let inverse = m.inverse();
    if inverse.is_finite() {
        inverse.transpose().to_cols_array().map(|v| v as f32)
    } else {
        let d = (1.0 / scale) as f32;
        [d, 0.0, 0.0, 0.0, d, 0.0, 0.0, 0.0, d]
    }
}

#[inline]
fn times(b: &Block, v: [f32; 3]) -> [f32; 3] {
    [
        b[0] * v[0] + b[1] * v[1] + b[2] * v[2],
        b[3] * v[0] + b[4] * v[1] + b[5] * v[2],
        b[6] * v[0] + b[7] * v[1] + b[8] * v[2],
    ]
}

/// A unit vector with a part along any eigenvector, the same every time.
#[must_use]
pub fn eigenvector_guess(rows: usize) -> Vec<[f32; 3]> {
    let number = |i: usize| {
        let hash = (i as u32).wrapping_mul(2_654_435_761) >> 8;
        hash as f32 / (1 << 24) as f32 - 0.5
    };
    let mut guess: Vec<[f32; 3]> = (0..rows)
        .map(|i| [0, 1, 2].map(|k| number(3 * i + k)))
        .collect();
    let squares = guess.as_flattened().iter().map(|x| f64::from(*x).powi(2));
    let length = squares.sum::<f64>().sqrt() as f32;
    for x in guess.as_flattened_mut() {
        *x /= length;
    }
    guess
}

impl Level {
    fn new(pattern: Pattern) -> Self {
        let rows = pattern.row_count();
        let zeros = || vec![[0.0; 3]; rows];
        Self {
            matrix: BlockMatrix::new(pattern),
            inverse_diagonal: vec![[0.0; 9]; rows],
            largest_eigenvalue: 0.0,
            eigenvector: eigenvector_guess(rows),
            interpolation: None,
            right: zeros(),
            solution: zeros(),
            residual: zeros(),
            step: zeros(),
        }
    }

    fn node_count(&self) -> usize {
        self.right.len()
    }

    fn refresh(&mut self, first: bool) {
        let matrix = &self.matrix;
        self.inverse_diagonal
            .par_iter_mut()
            .with_min_len(NODES_AT_ONCE)
            .enumerate()
            .for_each(|(row, block)| *block = inverse(&matrix.diagonal(row)));
        // The stiffest place may have moved to where the last eigenvector has no part.
        let guess = eigenvector_guess(self.eigenvector.len());
        for (v, g) in self.eigenvector.iter_mut().zip(guess) {
            *v = [0, 1, 2].map(|k| v[k] + g[k]);
        }
        for _ in 0..POWER_ITERATIONS[usize::from(!first)] {
            let (vector, diagonal) = (&self.eigenvector, &self.inverse_diagonal);
            self.step
                .par_iter_mut()
                .with_min_len(NODES_AT_ONCE)
                .enumerate()
                .for_each(|(row, v)| *v = times(&diagonal[row], matrix.multiply_row(row, vector)));
            let square = |v: &Vector| -> f64 {
                v.iter()
                    .flatten()
                    .map(|x| f64::from(*x) * f64::from(*x))
                    .sum()
            };
            let (old, new) = (square(&self.eigenvector), square(&self.step));
            if !(old > 0.0 && new > 0.0 && new.is_finite()) {
                break;
            }
            self.largest_eigenvalue = (new / old).sqrt() as f32;
            let factor = (1.0 / new.sqrt()) as f32;
            for (v, s) in self.eigenvector.iter_mut().zip(&self.step) {
                *v = s.map(|x| factor * x);
            }
        }
    }

    /// Chebyshev steps on `solution` for `right`. Before the coarse correction the solution starts from zero, and the residual of the new
    /// one is left.
    fn smooth(&mut self, degree: usize, before: bool) {
        let upper = EIGENVALUE_MARGIN * self.largest_eigenvalue;
        if upper <= 0.0 {
            self.residual.copy_from_slice(&self.right);
            if before {
                self.solution.fill([0.0; 3]);
            }
            return;
        }
        let lower = SMOOTHED_SHARE * upper;
        let (centre, half_width) = (0.5 * (upper + lower), 0.5 * (upper - lower));
        let sigma = centre / half_width;
        let matrix = &self.matrix;
        let diagonal = &self.inverse_diagonal;
        if before {
            self.solution.fill([0.0; 3]);
            self.residual.copy_from_slice(&self.right);
        } else {
            let (solution, right) = (&self.solution, &self.right);
            self.residual
                .par_iter_mut()
                .with_min_len(NODES_AT_ONCE)
                .enumerate()
                .for_each(|(row, residual)| {
                    let product = matrix.multiply_row(row, solution);
                    *residual = std::array::from_fn(|k| right[row][k] - product[k]);
                });
        }
        let mut rho = 1.0 / sigma;
        for iteration in 0..degree {
            let (keep, add) = if iteration == 0 {
                (0.0, 1.0 / centre)
            } else {
                let next = 1.0 / (2.0 * sigma - rho);
                let factors = (next * rho, 2.0 * next / half_width);
                rho = next;
                factors
            };
            let residual = &self.residual;
            self.step
                .par_iter_mut()
                .zip(&mut self.solution)
                .with_min_len(NODES_AT_ONCE)
                .enumerate()
                .for_each(|(row, (step, solution))| {
                    let z = times(&diagonal[row], residual[row]);
                    for k in 0..3 {
                        step[k] = keep * step[k] + add * z[k];
                        solution[k] += step[k];
                    }
                });
            if !before && iteration + 1 == degree {
                break;
            }
            let step = &self.step;
            self.residual
                .par_iter_mut()
                .with_min_len(NODES_AT_ONCE)
                .enumerate()
                .for_each(|(row, residual)| {
                    let product = matrix.multiply_row(row, step);
                    for k in 0..3 {
                        residual[k] -= product[k];
                    }
                });
        }
    }
}

impl Multigrid {
    /// Levels for a mesh; the finest matrix has the pattern of the graph. Nothing is known of stiffness yet: see
    /// [`Multigrid::refresh`].
    #[must_use]
    pub fn new(graph: Graph) -> Self {
        let levels = hierarchy(graph)
            .into_iter()
            .map(|shape| Level {
                interpolation: shape.interpolation,
                ..Level::new(shape.pattern)
            })
            .collect();
        Self {
            levels,
            coarsest_inverse: Vec::new(),
            refreshed: false,
            cycles: 0,
        }
    }

    /// Nodes and stored blocks of every level, finest first.
    #[must_use]
    pub fn sizes(&self) -> Vec<[usize; 2]> {
        self.levels
            .iter()
            .map(|level| [level.node_count(), level.matrix.pattern.block_count()])
            .collect()
    }

    /// Takes a new matrix: `assemble` fills the finest one, the coarser ones follow.
    pub fn refresh(&mut self, assemble: impl FnOnce(&mut BlockMatrix)) {
        assemble(&mut self.levels[0].matrix);
        let first = !self.refreshed;
        self.refreshed = true;
        for i in 0..self.levels.len() {
            if i > 0 {
                let (fine, coarse) = self.levels.split_at_mut(i);
                let fine = &fine[i - 1];
                if let Some([interpolation, from_coarse]) = &fine.interpolation {
                    galerkin(
                        &fine.matrix,
                        interpolation,
                        from_coarse,
                        &mut coarse[0].matrix,
                    );
                }
            }
            self.levels[i].refresh(first);
        }
        if let Some(level) = self.levels.last() {
            self.coarsest_inverse = coarsest_inverse(&level.matrix);
        }
    }

    /// One V-cycle for `right`, from zero. Vectors have one entry per node of the finest level.
    pub fn apply(&mut self, right: &[Vec3], result: &mut [Vec3]) {
        self.cycles += 1;
        let (finite, largest) = right
            .par_chunks(NODES_AT_ONCE)
            .map(|chunk| {
                let largest = chunk
                    .iter()
                    .fold(0.0, |m: f32, v| m.max(v.abs().max_element()));
                (chunk.iter().all(|v| v.is_finite()), largest)
            })
            .reduce(|| (true, 0.0), |a, b| (a.0 && b.0, a.1.max(b.1)));
        if !finite || largest == 0.0 {
            // NaN goes on to the minimiser, which stops at it.
            let filling = if finite { 0.0 } else { f32::NAN };
            result.fill(Vec3::splat(filling));
            return;
        }
        self.levels[0]
            .right
            .par_iter_mut()
            .zip(right)
            .with_min_len(NODES_AT_ONCE)
            .for_each(|(r, v)| *r = (*v / largest).to_array());
        self.cycle();
        result
            .par_iter_mut()
            .zip(&self.levels[0].solution)
            .with_min_len(NODES_AT_ONCE)
            .for_each(|(r, s)| *r = Vec3::from_array(*s) * largest);
    }

    /// The finest matrix times a vector.
    pub fn multiply(&self, vector: &[Vec3], product: &mut [Vec3]) {
        let matrix = &self.levels[0].matrix;
        let vector: &[[f32; 3]] = bytemuck::cast_slice(vector);
        product
            .par_iter_mut()
            .with_min_len(NODES_AT_ONCE)
            .enumerate()
            .for_each(|(row, p)| *p = matrix.multiply_row(row, vector).into());
    }

    /// Forgets what the last refresh has found: the next one does not depend on it.
    pub fn forget(&mut self) {
        if self.refreshed {
            self.refreshed = false;
            for level in &mut self.levels {
                level.eigenvector = eigenvector_guess(level.node_count());
            }
        }
    }

    /// V-cycles since the levels were made.
    #[must_use]
    pub const fn cycles(&self) -> u64 {
        self.cycles
    }

    fn cycle(&mut self) {
        let last = self.levels.len() - 1;
        for i in 0..last {
            let (fine, coarse) = self.levels.split_at_mut(i + 1);
            let fine = &mut fine[i];
            fine.smooth(DEGREE, true);
            let Some([_, from_coarse]) = &fine.interpolation else {
                continue;
            };
            let residual = &fine.residual;
            coarse[0]
                .right
                .par_iter_mut()
                .with_min_len(NODES_AT_ONCE)
                .enumerate()
                .for_each(|(node, right)| {
                    let mut sum = [0.0; 3];
                    for &(fine, weight) in from_coarse.row(node) {
                        for k in 0..3 {
                            sum[k] += weight * residual[fine as usize][k];
                        }
                    }
                    *right = sum;
                });
        }
        self.solve_coarsest();
        for i in (0..last).rev() {
            let (fine, coarse) = self.levels.split_at_mut(i + 1);
            let fine = &mut fine[i];
            if let Some([interpolation, _]) = &fine.interpolation {
                let correction = &coarse[0].solution;
                fine.solution
                    .par_iter_mut()
                    .with_min_len(NODES_AT_ONCE)
                    .enumerate()
                    .for_each(|(node, solution)| {
                        for &(coarse, weight) in interpolation.row(node) {
                            for k in 0..3 {
                                solution[k] += weight * correction[coarse as usize][k];
                            }
                        }
                    });
            }
            fine.smooth(DEGREE, false);
        }
    }

    fn solve_coarsest(&mut self) {
        let Some(level) = self.levels.last_mut() else {
            return;
        };
        if self.coarsest_inverse.is_empty() {
            level.smooth(COARSEST_DEGREE, true);
            return;
        }
        let size = 3 * level.node_count();
        let right = level.right.as_flattened();
        for (value, row) in level
            .solution
            .as_flattened_mut()
            .iter_mut()
            .zip(self.coarsest_inverse.chunks_exact(size))
        {
            *value = row.iter().zip(right).map(|(a, b)| a * b).sum();
        }
    }
}

/// A_coarse = PᵀAP.
fn galerkin(
    fine: &BlockMatrix,
    interpolation: &Interpolation,
    from_coarse: &Interpolation,
    coarse: &mut BlockMatrix,
) {
    let nodes = coarse.pattern.row_count();
    coarse.fill_rows(
        || vec![0u32; nodes],
        |places, row, columns, blocks| {
            for (place, &column) in columns.iter().enumerate() {
                places[column as usize] = place as u32;
            }
            for &(node, share) in from_coarse.row(row) {
                let node = node as usize;
                for (&column, block) in fine.pattern.columns(node).iter().zip(fine.row(node)) {
                    for &(other, weight) in interpolation.row(column as usize) {
                        let factor = share * weight;
                        let sum = &mut blocks[places[other as usize] as usize];
                        for k in 0..9 {
                            sum[k] += factor * block[k];
                        }
                    }
                }
            }
        },
    );
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
