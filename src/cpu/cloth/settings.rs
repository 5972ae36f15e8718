//! How hard the minimiser tries, and what positions cannot hold.

use glam::DVec3;

use super::loads::StepInput;
use crate::cloth::Structure;
use crate::solve::InitialHessian;
use crate::solve::lbfgs::Options;

/// How hard the minimiser tries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverSettings {
    /// Tolerance of the energy norm √(gᵀH₀g), relative to that of the applied loads (fluid impulse, gravity, pressure).
    pub tolerance: f64,
    /// Stop when the largest displacement H₀g is below this, whatever the loads [m]; what positions cannot hold always ends a solve.
    pub displacement_floor_m: f64,
    /// Evaluations of the objective allowed in one solve.
    pub evaluation_limit: usize,
    /// Pairs kept by L-BFGS.
    pub history: usize,
    /// Iterations between refreshes of the initial Hessian within one solve.
    pub refresh_every: Option<usize>,
    /// Kind of the initial Hessian.
    pub initial_hessian: InitialHessian,
}

/// Displacement that positions in `f64` cannot hold [m]: two roundings of the farthest coordinate.
pub(super) fn round_off_m(positions_m: &[DVec3]) -> f64 {
    let farthest = |largest: f64, x: &DVec3| largest.max(x.abs().max_element());
    2.0 * f64::EPSILON * positions_m.iter().fold(0.0, farthest)
}

/// The minimiser's options for a structure: no node moves farther than two element lengths in one iteration.
#[must_use]
pub fn options(structure: &Structure, input: &StepInput, settings: &SolverSettings) -> Options {
    let size = structure
        .triangles
        .iter()
        .flat_map(|t| t.rest_squares_m2)
        .chain(
            structure
                .cables
                .iter()
                .map(|c| c.rest_length_m * c.rest_length_m),
        )
        .fold(0.0, f64::max)
        .sqrt();
    Options {
        history: settings.history,
        tolerance: settings.tolerance,
        displacement_floor_m: settings.displacement_floor_m,
        time_step: input.time_step_s.is_some(),
        evaluation_limit: settings.evaluation_limit,
        refresh_every: settings.refresh_every,
        step_limit_m: if size > 0.0 {
            2.0 * size
        } else {
            f64::INFINITY
        },
    }
}
