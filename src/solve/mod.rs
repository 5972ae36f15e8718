//! Minimisation: knows vectors and an objective, nothing of cloth. [`lbfgs`] is what drives most solves, [`newton`] those of tension-only
//! fabric; both start from the initial Hessian of the space, which may be a cycle of [`multigrid`]. [`stiffening`] is for what hardly stretches and
//! easily turns; it solves with a factorisation ([`block_cholesky`]).

pub mod block_cholesky;
pub mod lbfgs;
pub mod multigrid;
pub mod newton;
pub mod stiffening;

use glam::DVec3;

/// Approximate inverse of the Hessian that a minimiser starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InitialHessian {
    /// Inverses of the diagonal blocks: cheap; enough for steps so short that inertia holds every node.
    #[default]
    BlockJacobi,
    /// One multigrid cycle on the whole projected Hessian: evaluations hardly grow with the mesh.
    Multigrid,
}

/// What a minimiser needs of the space it works in: the objective with its gradient and an approximate inverse Hessian H₀,
/// asked for in few, large operations.
///
/// The minimiser never sees an element. The CPU implements the space on host vectors; a device implements it on its buffers and
/// answers every [`VectorSpace::attempt`] with one transfer to the host, because all that the minimiser needs of a trial comes
/// back together.
pub trait VectorSpace {
    /// Where the objective is evaluated; may be stored more finely than a vector.
    type Point;
    /// A gradient or a displacement.
    type Vector;
    /// What can go wrong with the space itself; [`std::convert::Infallible`] on the host.
    type Error;

    /// Room for a point; what it holds is not defined.
    fn point(&mut self) -> Result<Self::Point, Self::Error>;

    /// Room for a vector; what it holds is not defined.
    fn vector(&mut self) -> Result<Self::Vector, Self::Error>;

    /// Builds H₀ around `point` and evaluates there; writes the gradient g and H₀ g.
    fn start(
        &mut self,
        point: &Self::Point,
        gradient: &mut Self::Vector,
        preconditioned: &mut Self::Vector,
    ) -> Result<Start, Self::Error>;

    /// Moves from a point along a direction, clipped so that no node moves farther than allowed, and evaluates there.
    fn attempt(
        &mut self,
        from: &Step<'_, Self::Point, Self::Vector>,
        to: &mut Landing<'_, Self::Point, Self::Vector>,
        stored: &[&Self::Vector],
    ) -> Result<Attempt, Self::Error>;

    /// Rebuilds H₀ around `point`; writes H₀ g for the gradient g, and z_i = H₀ y_i for all `pairs` (y_i, z_i).
    fn refresh(
        &mut self,
        point: &Self::Point,
        gradient: &Self::Vector,
        preconditioned: &mut Self::Vector,
        pairs: &mut [(&Self::Vector, &mut Self::Vector)],
    ) -> Result<Refreshed, Self::Error>;

    /// Told at the end of a time step how far the point is from the minimum, −H₀ g, where that is too little for positions to hold; velocities can.
    fn remainder(&mut self, preconditioned: &Self::Vector) -> Result<(), Self::Error> {
        let _ = preconditioned;
        Ok(())
    }

    /// Where the nodes are at `point` \[m\], for who watches; `None` where a space has no nodes, or cannot tell.
    fn positions_m(&self, point: &Self::Point) -> Option<Vec<DVec3>> {
        let _ = point;
        None
    }

    /// `result = Σ coefficient · vector`; `result` is none of the terms.
    fn combine(
        &mut self,
        result: &mut Self::Vector,
        terms: &[(f64, &Self::Vector)],
    ) -> Result<(), Self::Error>;
}

/// What the minimiser learns at the start.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// Objective.
    pub objective: f64,
    /// Estimate of the error of `objective` by round-off.
    pub round_off: f64,
    /// gᵀ H₀ g.
    pub norm_square: f64,
    /// Largest displacement of a node in H₀ g \[m\]; NaN if an element is not finite.
    pub longest_m: f64,
    /// Energy norm of what drives the minimisation; tolerances are relative to it.
    pub reference: f64,
}

/// Where a trial starts.
#[derive(Debug)]
pub struct Step<'a, P, V> {
    /// Present point.
    pub point: &'a P,
    /// Its gradient g.
    pub gradient: &'a V,
    /// H₀ g.
    pub preconditioned: &'a V,
    /// Where to go.
    pub direction: &'a V,
    /// How far, in multiples of `direction`.
    pub length: f64,
    /// No node moves farther than this \[m\]; may be infinite.
    pub step_limit_m: f64,
}

/// What a trial writes.
#[derive(Debug)]
pub struct Landing<'a, P, V> {
    /// point + length · direction.
    pub point: &'a mut P,
    /// The gradient g⁺ there.
    pub gradient: &'a mut V,
    /// H₀ g⁺.
    pub preconditioned: &'a mut V,
}

/// What the minimiser learns of a trial; y = g⁺ − g.
#[derive(Debug, Clone)]
pub struct Attempt {
    /// Objective.
    pub objective: f64,
    /// Estimate of the error of `objective` by round-off.
    pub round_off: f64,
    /// Length of the step after clipping, in multiples of the direction d.
    pub length: f64,
    /// g⁺ · d.
    pub slope: f64,
    /// y · d.
    pub slope_change: f64,
    /// g⁺ · H₀ g⁺.
    pub norm_square: f64,
    /// g⁺ · H₀ y.
    pub gradient_change: f64,
    /// y · H₀ y.
    pub change_square: f64,
    /// Largest displacement of a node in H₀ g⁺ \[m\]; NaN if an element is not finite.
    pub longest_m: f64,
    /// (g⁺ · v, y · v) of every stored vector v.
    pub stored: Vec<[f64; 2]>,
}

/// What the minimiser learns of a new H₀.
#[derive(Debug, Clone)]
pub struct Refreshed {
    /// gᵀ H₀ g.
    pub norm_square: f64,
    /// Largest displacement of a node in H₀ g \[m\]; NaN if an element is not finite.
    pub longest_m: f64,
    /// g · z_i.
    pub gradient_change: Vec<f64>,
    /// y_i · z_j for j ≤ i, row by row.
    pub change_change: Vec<f64>,
    /// See [`Start::reference`].
    pub reference: f64,
}
