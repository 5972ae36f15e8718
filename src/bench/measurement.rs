//! What is varied for error against seconds, what is computed, and what comes of it.

use serde::Serialize;

use crate::lattice::Operator;
use crate::lattice::grid::Setup;

/// Errors for which the fastest setting is named.
pub(super) const ERROR_LIMITS: [f64; 2] = [0.05, 0.01];

/// What is varied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Setting {
    /// Cells along the reference length.
    pub resolution: usize,
    /// Reference speed [cells per step].
    pub lattice_speed: f64,
    pub operator: Operator,
}

type Velocity = dyn Fn([usize; 3]) -> [f64; 3] + Sync;

type Initial = dyn Fn([usize; 3]) -> (f64, [f64; 3]) + Sync;

/// A flow with a known end.
pub(super) struct Flow {
    pub setup: Setup,
    pub initial: Box<Initial>,
    pub steps: usize,
    /// Velocity at the end [cells per step].
    pub exact: Box<Velocity>,
}

/// One measurement.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// Name of the problem.
    pub problem: &'static str,
    /// Engine and precision.
    pub engine: String,
    /// Collision operator.
    pub operator: Operator,
    /// Cells along the reference length.
    pub resolution: usize,
    /// Reference speed over the speed of sound.
    pub mach: f64,
    /// Cells in all.
    pub cells: usize,
    /// Steps.
    pub steps: u64,
    /// Time of the steps [s].
    pub seconds: f64,
    /// The problem's error, relative; not finite where the flow broke down.
    pub error: f64,
    /// Whether a finer grid of the same Mach number, operator and engine is clearly worse: errors of two signs cancel here, by chance.
    pub cancels: bool,
    /// Whether no other point of the problem is as fast and as accurate, those that cancel left out.
    pub pareto: bool,
}

impl Point {
    /// False if the flow broke down, or is wrong by more than itself: the table keeps it, front and plot leave it out.
    pub(super) const fn is_result(&self) -> bool {
        self.error <= 1.0 && self.seconds.is_finite()
    }
}
