//! Newton's method with conjugate gradients (Nocedal & Wright, algorithm 7.1), on a positive semidefinite projection of the Hessian and
//! with H₀ as preconditioner.
//!
//! *Departure from the cited form*: since the matrix is semidefinite, directions of negative curvature do not occur but by round-off; the
//! equations are solved to a fixed share of the energy norm, and no node moves farther than a limit.
//!
//! Where elements switch between taut and slack, the Hessian changes with every step and the pairs of [`super::lbfgs`] remember what no
//! longer holds; there this driver needs fewer cycles. Where the projection leaves much out (springs that push), it needs more.

use super::lbfgs::{Options, Outcome, Progress, Stop, Watch};
use super::{Step, VectorSpace};

/// Each step's equations are solved to this share of the energy norm.
const FORCING: f64 = 0.3;

/// Products with the matrix in one step.
const PRODUCT_LIMIT: usize = 100;

const ARMIJO: f64 = 1e-4;
const LINE_SEARCH_LIMIT: usize = 30;

/// Steps in a row without a measurable change of the objective and without a norm lower by a tenth.
const STAGNATION_LIMIT: usize = 50;

/// A space that also knows the matrix that H₀ approximates the inverse of.
pub trait Curvature: VectorSpace {
    /// Writes `matrix · vector`, the matrix built where H₀ was; returns vector · matrix · vector.
    fn multiply(
        &mut self,
        vector: &Self::Vector,
        product: &mut Self::Vector,
    ) -> Result<f64, Self::Error>;

    /// Writes H₀ · vector; returns vector · H₀ · vector.
    fn precondition(
        &mut self,
        vector: &Self::Vector,
        result: &mut Self::Vector,
    ) -> Result<f64, Self::Error>;

    /// Moves like [`VectorSpace::attempt`], and evaluates there; nothing is asked of H₀.
    fn advance(
        &mut self,
        from: &Step<'_, Self::Point, Self::Vector>,
        point: &mut Self::Point,
        gradient: &mut Self::Vector,
    ) -> Result<Trial, Self::Error>;
}

/// What is learnt of a trial.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    /// Objective.
    pub objective: f64,
    /// Estimate of the error of `objective` by round-off.
    pub round_off: f64,
    /// Length of the step after clipping, in multiples of the direction d.
    pub length: f64,
    /// g · d, where the step starts.
    pub slope_before: f64,
    /// g⁺ · d.
    pub slope: f64,
}

/// Minimises the objective of `space` from `point`, in place; tells `watch` of every step, and ends when it answers false. The history and
/// the refreshes of the options are not used: the matrix is new in every step.
pub fn minimise_watched<S: Curvature>(
    space: &mut S,
    point: &mut S::Point,
    options: &Options,
    watch: Watch,
) -> Result<Outcome, S::Error> {
    let mut gradient = space.vector()?;
    let mut preconditioned = space.vector()?;
    let start = space.start(point, &mut gradient, &mut preconditioned)?;
    let (mut objective, mut round_off) = (start.objective, start.round_off);
    let mut norm_square = start.norm_square;
    let (mut longest_m, mut reference) = (start.longest_m, start.reference);
    let mut outcome = Outcome {
        stop: Stop::Stalled,
        iterations: 0,
        evaluations: 1,
        energy_norm: norm_square.max(0.0).sqrt(),
        objective,
    };
    if !objective.is_finite() || !start.norm_square.is_finite() || !longest_m.is_finite() {
        outcome.stop = Stop::NotFinite;
        return Ok(outcome);
    }
    let mut equations = Equations::new(space)?;
    let mut trial = space.point()?;
    let mut trial_gradient = space.vector()?;
    let mut lowest_norm = f64::INFINITY;
    let mut stagnant = 0;
    loop {
        let norm = norm_square.max(0.0).sqrt();
        outcome.energy_norm = norm;
        outcome.objective = objective;
        if norm_square < 0.0 {
            outcome.stop = Stop::Indefinite;
            return Ok(outcome);
        }
        if norm <= options.tolerance * reference || longest_m <= options.displacement_floor_m {
            outcome.stop = Stop::Converged;
            return Ok(outcome);
        }
        if outcome.evaluations >= options.evaluation_limit {
            outcome.stop = Stop::LimitReached;
            return Ok(outcome);
        }
        stagnant = if norm < 0.9 * lowest_norm {
            0
        } else {
            stagnant
        };
        lowest_norm = lowest_norm.min(norm);
        if stagnant >= STAGNATION_LIMIT {
            outcome.stop = Stop::Stalled;
            return Ok(outcome);
        }
        let progress = Progress {
            evaluations: outcome.evaluations,
            relative_norm: norm / reference,
        };
        if !watch(&progress) {
            outcome.stop = Stop::Interrupted;
            return Ok(outcome);
        }
        equations.solve(space, &gradient, &preconditioned, norm_square)?;
        let mut length = 1.0;
        let mut accepted = None;
        for _ in 0..LINE_SEARCH_LIMIT {
            let step = Step {
                point: &*point,
                gradient: &gradient,
                preconditioned: &preconditioned,
                direction: &equations.solution,
                length,
                step_limit_m: options.step_limit_m,
            };
            let found = space.advance(&step, &mut trial, &mut trial_gradient)?;
            outcome.evaluations += 1;
            length = found.length;
            if !found.objective.is_finite() || !found.slope.is_finite() {
                length *= 0.25;
                continue;
            }
            let change = found.objective - objective;
            let measurable = change.abs() > found.round_off.max(round_off);
            let enough = if measurable {
                change <= ARMIJO * length * found.slope_before
            } else {
                found.slope <= -0.8 * found.slope_before
            };
            if enough {
                accepted = Some((found, measurable));
                break;
            }
            // Minimum of the parabola through the old value and slope and the new value, kept in [0.1, 0.5].
            let parabola = -found.slope_before * length * length
                / (2.0 * (change - length * found.slope_before));
            length = if parabola.is_finite() {
                parabola.clamp(0.1 * length, 0.5 * length)
            } else {
                0.5 * length
            };
        }
        let Some((found, measurable)) = accepted else {
            outcome.stop = Stop::Stalled;
            return Ok(outcome);
        };
        outcome.iterations += 1;
        stagnant = if measurable { 0 } else { stagnant + 1 };
        (objective, round_off) = (found.objective, found.round_off);
        std::mem::swap(point, &mut trial);
        std::mem::swap(&mut gradient, &mut trial_gradient);
        let refreshed = space.refresh(point, &gradient, &mut preconditioned, &mut [])?;
        norm_square = refreshed.norm_square;
        (longest_m, reference) = (refreshed.longest_m, refreshed.reference);
    }
}

/// The equations of a step, matrix · solution = −g, and what solving them takes.
struct Equations<V> {
    solution: V,
    residual: V,
    direction: V,
    product: V,
    spare: V,
}

impl<V> Equations<V> {
    fn new<S: Curvature<Vector = V>>(space: &mut S) -> Result<Self, S::Error> {
        Ok(Self {
            solution: space.vector()?,
            residual: space.vector()?,
            direction: space.vector()?,
            product: space.vector()?,
            spare: space.vector()?,
        })
    }

    /// Conjugate gradients from zero; `preconditioned` is H₀ g, and `square` g · H₀ g.
    fn solve<S: Curvature<Vector = V>>(
        &mut self,
        space: &mut S,
        gradient: &V,
        preconditioned: &V,
        mut square: f64,
    ) -> Result<(), S::Error> {
        let goal = FORCING * FORCING * square;
        space.combine(&mut self.residual, &[(-1.0, gradient)])?;
        space.combine(&mut self.direction, &[(-1.0, preconditioned)])?;
        for product in 0..PRODUCT_LIMIT {
            let curvature = space.multiply(&self.direction, &mut self.product)?;
            let length = square / curvature;
            if !(curvature > 0.0 && length.is_finite()) {
                if product == 0 {
                    space.combine(&mut self.solution, &[(1.0, &self.direction)])?;
                }
                return Ok(());
            }
            if product == 0 {
                space.combine(&mut self.solution, &[(length, &self.direction)])?;
            } else {
                let terms = [(1.0, &self.solution), (length, &self.direction)];
                space.combine(&mut self.spare, &terms)?;
                std::mem::swap(&mut self.solution, &mut self.spare);
            }
            let terms = [(1.0, &self.residual), (-length, &self.product)];
            space.combine(&mut self.spare, &terms)?;
            std::mem::swap(&mut self.residual, &mut self.spare);
            let new = space.precondition(&self.residual, &mut self.product)?;
            if new <= goal || new.is_nan() {
                return Ok(());
            }
            let terms = [(1.0, &self.product), (new / square, &self.direction)];
            space.combine(&mut self.spare, &terms)?;
            std::mem::swap(&mut self.direction, &mut self.spare);
            square = new;
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "newton_tests.rs"]
mod tests;
