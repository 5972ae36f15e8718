//! Solver of the fabric: `[solver]`.

use super::file::File;
use super::problem::Problem;
use super::usual;
use super::values::{at_least_one, within};

/// Solver of the fabric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// Tolerance of one step, relative to the loads.
    pub tolerance: f64,
    /// Evaluations allowed in one step.
    pub evaluation_limit: usize,
    /// Mass-proportional damping [1/s].
    pub damping_1_s: f64,
    /// Solves that miss their tolerance do not make a run count as out of balance.
    pub allow_unsolved: bool,
}

/// Tolerance of a step of the fabric without one in the case. A payload hides in the energy norm, which its mass makes small: with 1e-2 the
/// lines of `cases/finite-mass-drop.toml` pulled 3.5 % less than the canopy.
const fn usual_tolerance(file: &File) -> f64 {
    match file.payload {
        Some(_) => 1e-3,
        None => 1e-2,
    }
}

/// Checks `[solver]`.
pub(super) fn check(file: &File) -> Result<Solver, Problem> {
    let written = file.solver.as_ref();
    let damping_1_s = written.and_then(|s| s.damping_1_s);
    let tolerance = written.and_then(|s| s.tolerance);
    let evaluation_limit = written.and_then(|s| s.evaluation_limit);
    let allow_unsolved = written.and_then(|s| s.allow_unsolved);
    let damping_1_s = usual::or("solver.damping_1_s", damping_1_s, 0.0);
    if !(damping_1_s >= 0.0 && damping_1_s.is_finite()) {
        return Err(Problem::new(
            "solver.damping_1_s",
            format!("solver.damping_1_s = {damping_1_s} must not be negative"),
            "damping takes energy out; give zero or a positive rate",
        ));
    }
    Ok(Solver {
        tolerance: within(
            "solver.tolerance",
            usual::or("solver.tolerance", tolerance, usual_tolerance(file)),
            1e-12,
            0.5,
        )?,
        evaluation_limit: at_least_one(
            "solver.evaluation_limit",
            usual::or("solver.evaluation_limit", evaluation_limit, 2_000),
        )?,
        damping_1_s,
        allow_unsolved: usual::or("solver.allow_unsolved", allow_unsolved, false),
    })
}
