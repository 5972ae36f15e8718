//! L-BFGS in Gram-matrix form (after Chen, Wang & Zhou 2014, "vector-free" L-BFGS).
//!
//! The two-loop recursion (Nocedal & Wright, algorithm 7.4) runs on scalars: with s_i, y_i the last steps and gradient
//! changes and z_i = H₀ y_i, the direction is a linear combination of {H₀ g, z_i, s_i} whose coefficients need only
//! dot products. A trial returns those of the new gradient and of its change; the others follow by recurrence in `f64`:
//! s·y = α (d·y), and d·y_j from the coefficients of d, since H₀ is symmetric and so H₀g·y_j = g·z_j. One trial, one answer.
//! *Departure from the cited form*: H₀ is a matrix, not a scalar, so z_i are stored instead of recombining y_i. The recursion starts from
//! γ H₀, with the usual scale γ of the newest pair; norms are those of H₀ itself.
//!
//! Steps are accepted on sufficient decrease (Armijo) or, where differences of the objective drown in round-off, on the
//! gradient alone (approximate Wolfe condition, Hager & Zhang 2005).

use serde::{Deserialize, Serialize};

use std::collections::VecDeque;

use glam::DVec3;

use super::{Attempt, Landing, Refreshed, Step, VectorSpace};

/// Pairs usually kept: with a good H₀, more of them cost more cycles at every refresh than they spare.
pub const HISTORY: usize = 5;

/// How hard to try.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Pairs (s, y) kept.
    pub history: usize,
    /// Stop when √(gᵀ H₀ g) is at most this share of the space's reference.
    pub tolerance: f64,
    /// Stop when the largest node displacement of H₀ g is at most this [m]: what positions cannot hold, or what the caller calls nothing.
    pub displacement_floor_m: f64,
    /// True in a time step, see [`Options::scale`]; there what only round-off hides counts as solved ([`Stop::RoundOff`]).
    pub time_step: bool,
    /// Give up after this many evaluations.
    pub evaluation_limit: usize,
    /// Rebuild H₀ after this many iterations; `None`: only before the first.
    pub refresh_every: Option<usize>,
    /// No node moves farther than this in one iteration [m].
    pub step_limit_m: f64,
}

/// Share of the forces out of balance at the start of a time step, which counts as loads.
///
/// Without it a structure that moves under inertia and its own forces alone would have nothing that its tolerance is relative to. The
/// share is small, since a prediction that overshoots stretches stiff elements far beyond what any load does.
pub(crate) const OUT_OF_BALANCE: f64 = 1e-3;

impl Options {
    /// What [`Options::tolerance`] is relative to: the energy norm of the loads; in a time step at least a thousandth of that of all forces
    /// that are out of balance at the start, `norm_at_start`, which are those of the structure and of inertia, too.
    #[must_use]
    pub fn scale(&self, loads: f64, norm_at_start: f64) -> f64 {
        if self.time_step {
            loads.max(OUT_OF_BALANCE * norm_at_start)
        } else {
            loads
        }
    }
}

/// Why the minimiser stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stop {
    /// The energy norm, or the displacement floor, was reached.
    Converged,
    /// In a time step: the objective is as low as its round-off tells, and the energy norm falls no further.
    RoundOff,
    /// No acceptable step along any direction, or none that still changes anything but round-off.
    Stalled,
    /// Evaluation limit reached.
    LimitReached,
    /// The objective or its gradient is not finite at the start.
    NotFinite,
    /// H₀, built anew, is not positive along the gradient, so that it measures no distance from the minimum.
    Indefinite,
    /// The watcher asked for it.
    Interrupted,
}

/// How far the minimiser is.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Objective evaluations so far.
    pub evaluations: usize,
    /// √(gᵀ H₀ g) over the reference of the space; [`Options::tolerance`] is its goal.
    pub relative_norm: f64,
    /// Reads the positions of the present point.
    pub(super) read: &'a dyn Fn() -> Option<Vec<DVec3>>,
}

impl Progress<'_> {
    /// Where the nodes are now [m]; `None` where the space cannot tell. On a device this takes a transfer.
    #[must_use]
    pub fn positions_m(&self) -> Option<Vec<DVec3>> {
        (self.read)()
    }
}

/// Called once per iteration; false ends the minimisation at the present point.
pub type Watch<'a> = &'a mut dyn FnMut(&Progress<'_>) -> bool;

impl Stop {
    /// True if the minimiser found what it was asked for, as far as its numbers can hold it.
    #[must_use]
    pub const fn reached(self) -> bool {
        matches!(self, Self::Converged | Self::RoundOff)
    }
}

/// The share `norm / scale`; 0 where neither is anything.
pub(crate) fn relative(norm: f64, scale: f64) -> f64 {
    if norm == 0.0 { 0.0 } else { norm / scale }
}

/// What the minimiser did.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Outcome {
    /// Why it stopped.
    pub stop: Stop,
    /// Steps taken.
    pub iterations: usize,
    /// Objective evaluations.
    pub evaluations: usize,
    /// √(gᵀ H₀ g) at the end.
    pub energy_norm: f64,
    /// The same over what the tolerance is relative to; 0 where neither is anything.
    pub relative_norm: f64,
    /// Objective at the end.
    pub objective: f64,
}

struct Pair<V> {
    step: V,
    change: V,
    preconditioned_change: V,
}

/// Dot products of stored pairs, oldest first: with the present gradient, and `[i][j]` between pair i and pair j.
#[derive(Default)]
struct Products {
    /// g · s_i
    gradient_step: VecDeque<f64>,
    /// g · z_i
    gradient_change: VecDeque<f64>,
    /// s_i · y_j
    step_change: VecDeque<VecDeque<f64>>,
    /// y_i · z_j (symmetric)
    change_change: VecDeque<VecDeque<f64>>,
}

/// A direction d = −γ H₀ g + Σ change_i z_i − step_i s_i.
struct Direction {
    /// γ
    scale: f64,
    change: Vec<f64>,
    step: Vec<f64>,
    /// g · d
    slope: f64,
    /// d · y_j
    along_changes: Vec<f64>,
}

/// Share of the decrease that the slope promises, which is enough.
pub(crate) const ARMIJO: f64 = 1e-4;

/// Share of the slope, with its sign turned, that the slope at the end of a step may have where the objective tells nothing.
pub(crate) const WOLFE: f64 = 0.8;

/// Trials along one direction.
pub(crate) const LINE_SEARCH_LIMIT: usize = 30;

/// Share of a trial's length that is tried next where it ends beyond all numbers.
pub(crate) const RETREAT: f64 = 0.25;

/// Least and largest share of a trial's length that is tried next.
pub(crate) const SHORTER: [f64; 2] = [0.1, 0.5];

/// A pair is kept where s·y is more than this share of y·H₀y.
pub(crate) const LEAST_CURVATURE: f64 = 1e-12;

/// Share of the lowest norm that a norm has to be below to count as progress.
pub(crate) const PROGRESS: f64 = 0.9;

/// Iterations in a row without a measurable change of the objective and without a norm lower by a tenth, after which more of them
/// are taken to be of no use: round-off is all that is left.
pub(crate) const STAGNATION_LIMIT: usize = 5000;

/// Displacements of H₀ g up to so many times what positions cannot hold are told to the space.
pub(crate) const REMAINDER: f64 = 16.0;

/// [`STAGNATION_LIMIT`] in a time step, where what is left of the objective, half the square of the norm, lies within its round-off.
pub(crate) const ROUND_OFF_LIMIT: usize = 100;

/// Root of its square: 0 of a negative one, which an indefinite H₀ gives, and no number of what is none.
pub(crate) fn energy_norm(square: f64) -> f64 {
    if square < 0.0 { 0.0 } else { square.sqrt() }
}

/// Minimises the objective of `space` from `point`, in place.
pub fn minimise<S: VectorSpace>(
    space: &mut S,
    point: &mut S::Point,
    options: &Options,
) -> Result<Outcome, S::Error> {
    minimise_watched(space, point, options, &mut |_| true)
}

/// [`minimise`] that tells `watch` of every iteration, and ends when it answers false.
pub fn minimise_watched<S: VectorSpace>(
    space: &mut S,
    point: &mut S::Point,
    options: &Options,
    watch: Watch,
) -> Result<Outcome, S::Error> {
    let mut gradient = space.vector()?;
    let mut preconditioned = space.vector()?;
    let start = space.start(point, &mut gradient, &mut preconditioned)?;
    let mut objective = start.objective;
    let mut round_off = start.round_off;
    let mut indefinite = start.norm_square < 0.0;
    let mut norm = energy_norm(start.norm_square);
    let mut longest_m = start.longest_m;
    let norm_at_start = norm;
    let mut scale = options.scale(start.reference, norm_at_start);
    let mut outcome = Outcome {
        stop: Stop::Stalled,
        iterations: 0,
        evaluations: 1,
        energy_norm: norm,
        relative_norm: relative(norm, scale),
        objective,
    };
    if !objective.is_finite() || !start.norm_square.is_finite() || !longest_m.is_finite() {
        outcome.stop = Stop::NotFinite;
        return Ok(outcome);
    }
    let mut pairs: VecDeque<Pair<S::Vector>> = VecDeque::new();
    let mut products = Products::default();
    let mut spare: Vec<Pair<S::Vector>> = Vec::new();
    let mut direction = space.vector()?;
    let mut trial = space.point()?;
    let mut trial_gradient = space.vector()?;
    let mut trial_preconditioned = space.vector()?;
    let mut since_refresh = 0;
    let mut lowest_norm = norm;
    let mut stagnant = 0;

    loop {
        // Of an H₀ that was taken anew, too.
        if !norm.is_finite() || !longest_m.is_finite() {
            outcome.stop = Stop::NotFinite;
            return Ok(outcome);
        }
        outcome.energy_norm = norm;
        outcome.relative_norm = relative(norm, scale);
        outcome.objective = objective;
        let converged =
            norm <= options.tolerance * scale || longest_m <= options.displacement_floor_m;
        if indefinite || converged {
            if options.refresh_every.is_none() || since_refresh == 0 {
                if indefinite {
                    outcome.stop = Stop::Indefinite;
                    return Ok(outcome);
                }
                if options.time_step && longest_m <= REMAINDER * options.displacement_floor_m {
                    space.remainder(&preconditioned)?;
                }
                outcome.stop = Stop::Converged;
                return Ok(outcome);
            }
            // An H₀ that was built elsewhere does not measure the distance from here.
            since_refresh = 0;
            let renewed = renew(
                space,
                (&*point, &gradient, &mut preconditioned),
                &mut pairs,
                &mut products,
            )?;
            indefinite = renewed.norm_square < 0.0;
            norm = energy_norm(renewed.norm_square);
            longest_m = renewed.longest_m;
            scale = options.scale(renewed.reference, norm_at_start);
            continue;
        }
        if outcome.evaluations >= options.evaluation_limit {
            outcome.stop = Stop::LimitReached;
            return Ok(outcome);
        }
        let hidden = options.time_step && 0.5 * norm * norm <= round_off;
        if hidden && stagnant >= ROUND_OFF_LIMIT {
            outcome.stop = Stop::RoundOff;
            return Ok(outcome);
        }
        if stagnant >= STAGNATION_LIMIT {
            outcome.stop = Stop::Stalled;
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
        let mut plan = products.direction(norm * norm);
        let descends = plan.slope < 0.0 && plan.slope.is_finite();
        if !descends {
            spare.extend(pairs.drain(..));
            products = Products::default();
            plan = products.direction(norm * norm);
        }
        let mut terms = vec![(-plan.scale, &preconditioned)];
        for (i, pair) in pairs.iter().enumerate() {
            terms.push((plan.change[i], &pair.preconditioned_change));
            terms.push((-plan.step[i], &pair.step));
        }
        space.combine(&mut direction, &terms)?;
        let refresh = options
            .refresh_every
            .is_some_and(|every| since_refresh + 1 >= every);
        let mut stored: Vec<&S::Vector> = pairs.iter().map(|pair| &pair.step).collect();
        if !refresh {
            // A new H₀ makes new z_i.
            stored.extend(pairs.iter().map(|pair| &pair.preconditioned_change));
        }
        let mut length = 1.0;
        let mut accepted = None;
        for _ in 0..LINE_SEARCH_LIMIT {
            let step = Step {
                point: &*point,
                gradient: &gradient,
                preconditioned: &preconditioned,
                direction: &direction,
                length,
                step_limit_m: options.step_limit_m,
            };
            let mut landing = Landing {
                point: &mut trial,
                gradient: &mut trial_gradient,
                preconditioned: &mut trial_preconditioned,
            };
            let attempt = space.attempt(&step, &mut landing, &stored)?;
            outcome.evaluations += 1;
            length = attempt.length;
            if !attempt.objective.is_finite() || !attempt.norm_square.is_finite() {
                length *= RETREAT;
                continue;
            }
            let change = attempt.objective - objective;
            let measurable = change.abs() > attempt.round_off.max(round_off);
            let enough = if measurable {
                change <= ARMIJO * length * plan.slope
            } else {
                attempt.slope <= -WOLFE * plan.slope
            };
            if enough {
                accepted = Some(attempt);
                break;
            }
            // Minimum of the parabola through the old value and slope and the new value (or slope), within bounds.
            let parabola = if measurable {
                -plan.slope * length * length / (2.0 * (change - length * plan.slope))
            } else {
                -length * plan.slope / attempt.slope_change
            };
            length = if parabola.is_finite() {
                parabola.clamp(SHORTER[0] * length, SHORTER[1] * length)
            } else {
                SHORTER[1] * length
            };
        }
        let Some(attempt) = accepted else {
            if pairs.is_empty() {
                outcome.stop = if hidden {
                    Stop::RoundOff
                } else {
                    Stop::Stalled
                };
                return Ok(outcome);
            }
            spare.extend(pairs.drain(..));
            products = Products::default();
            continue;
        };
        outcome.iterations += 1;
        since_refresh += 1;
        let mut pair = match spare.pop() {
            Some(pair) => pair,
            None => Pair {
                step: space.vector()?,
                change: space.vector()?,
                preconditioned_change: space.vector()?,
            },
        };
        space.combine(&mut pair.step, &[(attempt.length, &direction)])?;
        space.combine(
            &mut pair.change,
            &[(1.0, &trial_gradient), (-1.0, &gradient)],
        )?;
        if !refresh {
            space.combine(
                &mut pair.preconditioned_change,
                &[(1.0, &trial_preconditioned), (-1.0, &preconditioned)],
            )?;
        }
        pairs.push_back(pair);
        products.push(&plan, &attempt);
        let mut norm_square = attempt.norm_square;
        longest_m = attempt.longest_m;
        if refresh {
            since_refresh = 0;
            let renewed = renew(
                space,
                (&trial, &trial_gradient, &mut trial_preconditioned),
                &mut pairs,
                &mut products,
            )?;
            norm_square = renewed.norm_square;
            longest_m = renewed.longest_m;
            scale = options.scale(renewed.reference, norm_at_start);
        }
        indefinite = norm_square < 0.0;
        norm = energy_norm(norm_square);
        if !products.newest_curves() {
            products.remove(pairs.len() - 1);
            spare.extend(pairs.pop_back());
        } else if pairs.len() > options.history {
            products.remove(0);
            spare.extend(pairs.pop_front());
        }
        let change = (attempt.objective - objective).abs();
        if change > attempt.round_off.max(round_off) || norm < PROGRESS * lowest_norm {
            stagnant = 0;
        } else {
            stagnant += 1;
        }
        lowest_norm = lowest_norm.min(norm);
        std::mem::swap(point, &mut trial);
        std::mem::swap(&mut gradient, &mut trial_gradient);
        std::mem::swap(&mut preconditioned, &mut trial_preconditioned);
        objective = attempt.objective;
        round_off = attempt.round_off;
    }
}

/// Rebuilds H₀ around a point with its gradient g; writes H₀ g, renews all z_i and what depends on them, and returns what the space told.
fn renew<S: VectorSpace>(
    space: &mut S,
    (point, gradient, preconditioned): (&S::Point, &S::Vector, &mut S::Vector),
    pairs: &mut VecDeque<Pair<S::Vector>>,
    products: &mut Products,
) -> Result<Refreshed, S::Error> {
    let mut changes: Vec<_> = pairs
        .iter_mut()
        .map(|pair| (&pair.change, &mut pair.preconditioned_change))
        .collect();
    let refreshed = space.refresh(point, gradient, preconditioned, &mut changes)?;
    products.gradient_change = refreshed.gradient_change.iter().copied().collect();
    let mut entries = refreshed.change_change.iter().copied();
    for i in 0..pairs.len() {
        for j in 0..=i {
            let entry = entries.next().unwrap_or(f64::NAN);
            products.change_change[i][j] = entry;
            products.change_change[j][i] = entry;
        }
    }
    Ok(refreshed)
}

impl Products {
    /// The two-loop recursion; `norm_square` is g · H₀ g.
    fn direction(&self, norm_square: f64) -> Direction {
        let m = self.gradient_step.len();
        let mut alpha = vec![0.0; m];
        for i in (0..m).rev() {
            let mut projection = self.gradient_step[i];
            for j in i + 1..m {
                projection -= alpha[j] * self.step_change[i][j];
            }
            alpha[i] = projection / self.step_change[i][i];
        }
        let mut gain = vec![0.0; m];
        let scale = self.scale();
        for i in 0..m {
            let mut projection = self.gradient_change[i];
            for j in 0..m {
                projection -= alpha[j] * self.change_change[i][j];
            }
            projection *= scale;
            for j in 0..i {
                projection += gain[j] * self.step_change[j][i];
            }
            gain[i] = alpha[i] - projection / self.step_change[i][i];
        }
        let mut slope = -scale * norm_square;
        let mut along_changes = vec![0.0; m];
        for i in 0..m {
            slope += scale * alpha[i] * self.gradient_change[i] - gain[i] * self.gradient_step[i];
            along_changes[i] = -scale * self.gradient_change[i];
            for j in 0..m {
                along_changes[i] +=
                    scale * alpha[j] * self.change_change[j][i] - gain[j] * self.step_change[j][i];
            }
        }
        Direction {
            scale,
            change: alpha.iter().map(|a| scale * a).collect(),
            step: gain,
            slope,
            along_changes,
        }
    }

    /// γ = s·y / y·H₀y of the newest pair (Nocedal & Wright, equation 7.20, with H₀ for the identity): how much too soft or too stiff H₀ is
    /// along the last step. It spares a quarter to a half of the evaluations of sheets that stiffen as they are stretched.
    fn scale(&self) -> f64 {
        let last = |matrix: &VecDeque<VecDeque<f64>>| matrix.back()?.back().copied();
        match (last(&self.step_change), last(&self.change_change)) {
            (Some(curvature), Some(change_square)) if curvature > 0.0 && change_square > 0.0 => {
                curvature / change_square
            }
            _ => 1.0,
        }
    }

    /// Adds the pair of an accepted attempt; products with z_i are left open where H₀ is about to be rebuilt.
    fn push(&mut self, plan: &Direction, attempt: &Attempt) {
        let m = self.gradient_step.len();
        let stored = |i: usize| attempt.stored.get(i).copied().unwrap_or([f64::NAN; 2]);
        let mut step_row = VecDeque::with_capacity(m + 1);
        let mut change_row = VecDeque::with_capacity(m + 1);
        for i in 0..m {
            let ([gradient_step, step_change], [gradient_change, change_change]) =
                (stored(i), stored(m + i));
            self.gradient_step[i] = gradient_step;
            self.gradient_change[i] = gradient_change;
            self.step_change[i].push_back(step_change);
            self.change_change[i].push_back(change_change);
            step_row.push_back(attempt.length * plan.along_changes[i]);
            change_row.push_back(change_change);
        }
        step_row.push_back(attempt.length * attempt.slope_change);
        change_row.push_back(attempt.change_square);
        self.gradient_step.push_back(attempt.length * attempt.slope);
        self.gradient_change.push_back(attempt.gradient_change);
        self.step_change.push_back(step_row);
        self.change_change.push_back(change_row);
    }

    /// True if the curvature along the newest step is positive.
    fn newest_curves(&self) -> bool {
        let last = |matrix: &VecDeque<VecDeque<f64>>| {
            let row = matrix.back();
            row.and_then(|row| row.back().copied()).unwrap_or(f64::NAN)
        };
        let (curvature, change_square) = (last(&self.step_change), last(&self.change_change));
        curvature > LEAST_CURVATURE * change_square && curvature > 0.0
    }

    /// Forgets pair `i`.
    fn remove(&mut self, i: usize) {
        self.gradient_step.remove(i);
        self.gradient_change.remove(i);
        for matrix in [&mut self.step_change, &mut self.change_change] {
            matrix.remove(i);
            for row in matrix {
                row.remove(i);
            }
        }
    }
}

#[cfg(test)]
#[path = "lbfgs_tests.rs"]
pub(super) mod tests;
