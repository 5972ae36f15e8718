//! Minimisation: knows vectors and an objective, nothing of cloth.

pub mod lbfgs;

/// What a minimiser needs of the space it works in: the objective with its gradient, an approximate inverse Hessian,
/// and two bulk operations. The CPU implements it on host vectors; a GPU can implement it on device buffers, because
/// the minimiser never sees an element.
pub trait VectorSpace {
    /// A point or a gradient.
    type Vector;

    /// A vector of zeros.
    fn zeros(&self) -> Self::Vector;

    /// Objective at `point`, with its gradient written to `gradient`.
    fn evaluate(&mut self, point: &Self::Vector, gradient: &mut Self::Vector) -> f64;

    /// Rebuilds the approximate inverse Hessian H₀ around `point`.
    fn refresh(&mut self, point: &Self::Vector);

    /// `result = H₀ · vector`.
    fn precondition(&self, vector: &Self::Vector, result: &mut Self::Vector);

    /// Dot products of all `pairs`, in one pass.
    fn dots(&self, pairs: &[(&Self::Vector, &Self::Vector)]) -> Vec<f64>;

    /// `result = Σ coefficient · vector`; `result` is none of the terms.
    fn combine(&self, result: &mut Self::Vector, terms: &[(f64, &Self::Vector)]);

    /// Largest displacement of a node in `step` [m]; NaN if an element is not finite.
    fn longest(&self, step: &Self::Vector) -> f64;
}
