//! Newton's method with conjugate gradients (Nocedal & Wright, algorithm 7.1), on a positive semidefinite projection of the Hessian and
//! with H₀ as preconditioner.
//!
//! *Departure from the cited form*: since the matrix is semidefinite, directions of negative curvature do not occur but by round-off; the
//! equations are solved to a fixed share of the energy norm, no node moves farther than a limit, and steps end where the slope along them is
//! less than half of that at their start (a bracket narrowed by the secant of the slopes).
//!
//! Where elements switch between taut and slack, the Hessian changes with every step and the pairs of [`super::lbfgs`] remember what no
//! longer holds; there this driver needs fewer cycles. Where the projection leaves much out (springs that push), it needs more.

use super::lbfgs::{Options, Outcome, Progress, Stop, Watch, energy_norm, relative};
use super::{Step, VectorSpace};

/// Each step's equations are solved to this share of the energy norm.
const FORCING: f64 = 0.3;

/// Products with the matrix in one step.
const PRODUCT_LIMIT: usize = 100;

const ARMIJO: f64 = 1e-4;
const LINE_SEARCH_LIMIT: usize = 30;

/// Share of the slope at the start that may be left at the end of a step (strong Wolfe conditions). Wrinkles come and go along a step: with a decrease of the
/// objective alone, steps ended at a tenth of their length where nearly all of the slope was left, and wings took several times as many evaluations.
const SLOPE_LEFT: f64 = 0.5;

/// After so many trials what is low enough is taken.
const ENOUGH_TRIALS: usize = 8;

/// Longest step, in multiples of Newton's.
const LONGEST: f64 = 8.0;

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
    let norm_at_start = norm_square.max(0.0).sqrt();
    let mut longest_m = start.longest_m;
    let mut scale = options.scale(start.reference, norm_at_start);
    let mut outcome = Outcome {
        stop: Stop::Stalled,
        iterations: 0,
        evaluations: 1,
        energy_norm: norm_at_start,
        relative_norm: relative(norm_at_start, scale),
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
        if !norm_square.is_finite() || !longest_m.is_finite() {
            outcome.stop = Stop::NotFinite;
            return Ok(outcome);
        }
        let norm = energy_norm(norm_square);
        outcome.energy_norm = norm;
        outcome.relative_norm = relative(norm, scale);
        outcome.objective = objective;
        if norm_square < 0.0 {
            outcome.stop = Stop::Indefinite;
            return Ok(outcome);
        }
        if norm <= options.tolerance * scale || longest_m <= options.displacement_floor_m {
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
            let hidden = options.time_step && 0.5 * norm_square <= round_off;
            outcome.stop = if hidden {
                Stop::RoundOff
            } else {
                Stop::Stalled
            };
            return Ok(outcome);
        }
        let progress = Progress {
            evaluations: outcome.evaluations,
            relative_norm: outcome.relative_norm,
            read: &|| space.positions_m(point),
        };
        if !watch(&progress) {
            outcome.stop = Stop::Interrupted;
            return Ok(outcome);
        }
        equations.solve(space, &gradient, &preconditioned, norm_square)?;
        let mut search = LineSearch::new();
        let mut accepted = None;
        for attempt in 1..=LINE_SEARCH_LIMIT {
            let step = Step {
                point: &*point,
                gradient: &gradient,
                preconditioned: &preconditioned,
                direction: &equations.solution,
                length: search.length,
                step_limit_m: options.step_limit_m,
            };
            let found = space.advance(&step, &mut trial, &mut trial_gradient)?;
            outcome.evaluations += 1;
            let change = found.objective - objective;
            let measurable = change.abs() > found.round_off.max(round_off);
            if search.judge(&found, change, measurable, attempt) {
                accepted = Some((found, measurable));
                break;
            }
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
        longest_m = refreshed.longest_m;
        scale = options.scale(refreshed.reference, norm_at_start);
    }
}

/// A bracket of the minimum along a direction.
struct LineSearch {
    length: f64,
    /// Length and slope (over that at the start, so 1 at 0) where the objective is low enough and falls.
    low: [f64; 2],
    /// Where it is too high, or rises; the slope is NaN where it is not finite.
    high: Option<[f64; 2]>,
}

impl LineSearch {
    const fn new() -> Self {
        Self {
            length: 1.0,
            low: [0.0, 1.0],
            high: None,
        }
    }

    /// True if the trial is good enough; otherwise the next length is set.
    fn judge(&mut self, found: &Trial, change: f64, measurable: bool, attempt: usize) -> bool {
        let ratio = found.slope / found.slope_before;
        let finite = found.objective.is_finite() && found.slope.is_finite();
        let clipped = found.length < self.length;
        self.length = found.length;
        let low_enough = finite
            && if measurable {
                change <= ARMIJO * found.length * found.slope_before
            } else {
                found.slope <= -0.8 * found.slope_before
            };
        if low_enough {
            let flat = ratio.abs() <= SLOPE_LEFT;
            let far_enough = ratio > 0.0 && (clipped || self.length >= LONGEST);
            if flat || far_enough || !measurable || attempt >= ENOUGH_TRIALS {
                return true;
            }
            if ratio > 0.0 {
                self.low = [self.length, ratio];
            } else {
                self.high = Some([self.length, ratio]);
            }
        } else {
            self.high = Some([self.length, if finite { ratio } else { f64::NAN }]);
        }
        self.length = match self.high {
            None => 2.0 * self.length,
            Some([high, slope]) => {
                let [low, low_slope] = self.low;
                let span = high - low;
                let secant = if slope < 0.0 {
                    low_slope / (low_slope - slope)
                } else {
                    0.5
                };
                low + span * secant.clamp(0.1, 0.7)
            }
        };
        false
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
