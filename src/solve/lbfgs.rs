//! L-BFGS in Gram-matrix form (after Chen, Wang & Zhou 2014, "vector-free" L-BFGS).
//!
//! The two-loop recursion (Nocedal & Wright, algorithm 7.4) runs on scalars: with s_i, y_i the last steps and gradient
//! changes and z_i = H₀ y_i, the direction is a linear combination of {H₀ g, z_i, s_i} whose coefficients need only
//! dot products, gathered in one pass. One application of H₀, one pass of dots and one combination per iteration.
//! *Departure from the cited form*: H₀ is a matrix, not a scalar, so z_i are stored instead of recombining y_i.
//!
//! Steps are accepted on sufficient decrease (Armijo) or, where differences of the objective drown in round-off, on the
//! gradient alone (approximate Wolfe condition, Hager & Zhang 2005).

use std::collections::VecDeque;

use super::VectorSpace;

/// Pairs usually kept.
pub const HISTORY: usize = 8;

/// How hard to try.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Pairs (s, y) kept.
    pub history: usize,
    /// Stop when √(gᵀ H₀ g) ≤ this.
    pub energy_norm: f64,
    /// Stop when the largest node displacement of H₀ g is at most this [m].
    pub displacement_floor_m: f64,
    /// Give up after this many evaluations.
    pub evaluation_limit: usize,
    /// Rebuild H₀ after this many iterations; `None`: only before the first.
    pub refresh_every: Option<usize>,
    /// No node moves farther than this in one iteration [m].
    pub step_limit_m: f64,
}

/// Why the minimiser stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The energy norm, or the displacement floor, was reached.
    Converged,
    /// No acceptable step along any direction.
    Stalled,
    /// Evaluation limit reached.
    LimitReached,
    /// The objective or its gradient is not finite at the start.
    NotFinite,
}

/// What the minimiser did.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Why it stopped.
    pub stop: Stop,
    /// Steps taken.
    pub iterations: usize,
    /// Objective evaluations.
    pub evaluations: usize,
    /// √(gᵀ H₀ g) at the end.
    pub energy_norm: f64,
    /// Objective at the end.
    pub objective: f64,
}

struct Pair<V> {
    step: V,
    change: V,
    preconditioned_change: V,
}

/// Dot products between stored pairs, `[i][j]` for pair i and pair j, oldest first.
struct Gram {
    /// s_i · y_j
    step_change: VecDeque<VecDeque<f64>>,
    /// y_i · z_j (symmetric)
    change_change: VecDeque<VecDeque<f64>>,
}

const ARMIJO: f64 = 1e-4;
/// Below this relative change, differences of the objective are round-off.
const ROUND_OFF: f64 = 1e-10;
const LINE_SEARCH_LIMIT: usize = 30;

/// Minimises the objective of `space` from `point`, in place. H₀ is used as it stands: call [`VectorSpace::refresh`] before.
pub fn minimise<S: VectorSpace>(
    space: &mut S,
    point: &mut S::Vector,
    options: &Options,
) -> Outcome {
    let mut gradient = space.zeros();
    let mut objective = space.evaluate(point, &mut gradient);
    let mut preconditioned = space.zeros();
    space.precondition(&gradient, &mut preconditioned);
    let mut norm = space.dots(&[(&gradient, &preconditioned)])[0]
        .max(0.0)
        .sqrt();
    let mut outcome = Outcome {
        stop: Stop::Stalled,
        iterations: 0,
        evaluations: 1,
        energy_norm: norm,
        objective,
    };
    if !objective.is_finite() || !norm.is_finite() || !space.longest(&gradient).is_finite() {
        outcome.stop = Stop::NotFinite;
        return outcome;
    }
    let mut pairs: VecDeque<Pair<S::Vector>> = VecDeque::new();
    let mut gram = Gram {
        step_change: VecDeque::new(),
        change_change: VecDeque::new(),
    };
    let mut spare: Vec<Pair<S::Vector>> = Vec::new();
    let mut direction = space.zeros();
    let mut trial = space.zeros();
    let mut trial_gradient = space.zeros();
    let mut trial_preconditioned = space.zeros();
    let mut since_refresh = 0;

    loop {
        outcome.energy_norm = norm;
        outcome.objective = objective;
        if norm <= options.energy_norm
            || space.longest(&preconditioned) <= options.displacement_floor_m
        {
            outcome.stop = Stop::Converged;
            return outcome;
        }
        if outcome.evaluations >= options.evaluation_limit {
            outcome.stop = Stop::LimitReached;
            return outcome;
        }
        let mut slope = build_direction(
            space,
            &gradient,
            &preconditioned,
            &pairs,
            &gram,
            &mut direction,
        );
        let descends = slope < 0.0 && slope.is_finite();
        if !descends {
            forget(&mut pairs, &mut gram, &mut spare);
            space.combine(&mut direction, &[(-1.0, &preconditioned)]);
            slope = -norm * norm;
        }
        let reach = space.longest(&direction);
        let clip = if reach > options.step_limit_m {
            options.step_limit_m / reach
        } else {
            1.0
        };
        let mut length = clip;
        let mut accepted = None;
        for _ in 0..LINE_SEARCH_LIMIT {
            space.combine(&mut trial, &[(1.0, point), (length, &direction)]);
            let value = space.evaluate(&trial, &mut trial_gradient);
            outcome.evaluations += 1;
            if !value.is_finite() {
                length *= 0.25;
                continue;
            }
            let change = value - objective;
            let measurable = change.abs() > ROUND_OFF * objective.abs();
            if measurable && change <= ARMIJO * length * slope {
                accepted = Some(value);
                break;
            }
            let trial_slope = space.dots(&[(&trial_gradient, &direction)])[0];
            if !measurable && trial_slope <= -0.8 * slope {
                accepted = Some(value);
                break;
            }
            // Minimum of the parabola through the old value and slope and the new value (or slope), kept in [0.1, 0.5].
            let parabola = if measurable {
                -slope * length * length / (2.0 * (change - length * slope))
            } else {
                length * slope / (slope - trial_slope)
            };
            length = if parabola.is_finite() {
                parabola.clamp(0.1 * length, 0.5 * length)
            } else {
                0.5 * length
            };
        }
        let Some(value) = accepted else {
            if pairs.is_empty() {
                outcome.stop = Stop::Stalled;
                return outcome;
            }
            forget(&mut pairs, &mut gram, &mut spare);
            continue;
        };
        outcome.iterations += 1;
        since_refresh += 1;
        let refresh = options
            .refresh_every
            .is_some_and(|every| since_refresh >= every);
        if refresh {
            space.refresh(&trial);
            since_refresh = 0;
            for pair in &mut pairs {
                space.precondition(&pair.change, &mut pair.preconditioned_change);
            }
            space.precondition(&gradient, &mut preconditioned);
            refill_change_products(space, &pairs, &mut gram);
        }
        space.precondition(&trial_gradient, &mut trial_preconditioned);
        let mut pair = spare.pop().unwrap_or_else(|| Pair {
            step: space.zeros(),
            change: space.zeros(),
            preconditioned_change: space.zeros(),
        });
        space.combine(&mut pair.step, &[(length, &direction)]);
        space.combine(
            &mut pair.change,
            &[(1.0, &trial_gradient), (-1.0, &gradient)],
        );
        space.combine(
            &mut pair.preconditioned_change,
            &[(1.0, &trial_preconditioned), (-1.0, &preconditioned)],
        );
        remember(
            space,
            pair,
            options.history,
            &mut pairs,
            &mut gram,
            &mut spare,
        );
        std::mem::swap(point, &mut trial);
        std::mem::swap(&mut gradient, &mut trial_gradient);
        std::mem::swap(&mut preconditioned, &mut trial_preconditioned);
        objective = value;
        norm = space.dots(&[(&gradient, &preconditioned)])[0]
            .max(0.0)
            .sqrt();
    }
}

/// Writes the L-BFGS direction and returns its slope gᵀd.
fn build_direction<S: VectorSpace>(
    space: &S,
    gradient: &S::Vector,
    preconditioned: &S::Vector,
    pairs: &VecDeque<Pair<S::Vector>>,
    gram: &Gram,
    direction: &mut S::Vector,
) -> f64 {
    let m = pairs.len();
    let mut requests = vec![(gradient, preconditioned)];
    for pair in pairs {
        requests.push((gradient, &pair.step));
        requests.push((gradient, &pair.preconditioned_change));
    }
    let products = space.dots(&requests);
    let gradient_step = |i: usize| products[1 + 2 * i];
    let gradient_change = |i: usize| products[2 + 2 * i];
    let mut alpha = vec![0.0; m];
    for i in (0..m).rev() {
        let mut projection = gradient_step(i);
        for j in i + 1..m {
            projection -= alpha[j] * gram.step_change[i][j];
        }
        alpha[i] = projection / gram.step_change[i][i];
    }
    let mut gain = vec![0.0; m];
    for i in 0..m {
        let mut projection = gradient_change(i);
        for j in 0..m {
            projection -= alpha[j] * gram.change_change[i][j];
        }
        for j in 0..i {
            projection += gain[j] * gram.step_change[j][i];
        }
        gain[i] = alpha[i] - projection / gram.step_change[i][i];
    }
    let mut terms = vec![(-1.0, preconditioned)];
    let mut slope = -products[0];
    for (i, pair) in pairs.iter().enumerate() {
        terms.push((alpha[i], &pair.preconditioned_change));
        terms.push((-gain[i], &pair.step));
        slope += alpha[i] * gradient_change(i) - gain[i] * gradient_step(i);
    }
    space.combine(direction, &terms);
    slope
}

/// Appends a pair if its curvature is positive, dropping the oldest beyond `history`.
fn remember<S: VectorSpace>(
    space: &S,
    pair: Pair<S::Vector>,
    history: usize,
    pairs: &mut VecDeque<Pair<S::Vector>>,
    gram: &mut Gram,
    spare: &mut Vec<Pair<S::Vector>>,
) {
    let own = space.dots(&[
        (&pair.step, &pair.change),
        (&pair.change, &pair.preconditioned_change),
    ]);
    let (curvature, change_square) = (own[0], own[1]);
    if !(curvature > 1e-12 * change_square && curvature > 0.0) {
        spare.push(pair);
        return;
    }
    if pairs.len() >= history {
        if let Some(oldest) = pairs.pop_front() {
            spare.push(oldest);
        }
        for matrix in [&mut gram.step_change, &mut gram.change_change] {
            matrix.pop_front();
            for row in matrix.iter_mut() {
                row.pop_front();
            }
        }
    }
    let mut requests = Vec::with_capacity(3 * pairs.len());
    for old in pairs.iter() {
        requests.push((&old.step, &pair.change));
        requests.push((&pair.step, &old.change));
        requests.push((&old.change, &pair.preconditioned_change));
    }
    let products = space.dots(&requests);
    let m = pairs.len();
    let mut step_row = VecDeque::with_capacity(m + 1);
    let mut change_row = VecDeque::with_capacity(m + 1);
    for i in 0..m {
        gram.step_change[i].push_back(products[3 * i]);
        step_row.push_back(products[3 * i + 1]);
        gram.change_change[i].push_back(products[3 * i + 2]);
        change_row.push_back(products[3 * i + 2]);
    }
    step_row.push_back(curvature);
    change_row.push_back(change_square);
    gram.step_change.push_back(step_row);
    gram.change_change.push_back(change_row);
    pairs.push_back(pair);
}

/// Recomputes y_i · z_j after H₀ changed.
fn refill_change_products<S: VectorSpace>(
    space: &S,
    pairs: &VecDeque<Pair<S::Vector>>,
    gram: &mut Gram,
) {
    let m = pairs.len();
    let mut requests = Vec::with_capacity(m * m);
    for i in 0..m {
        for j in 0..m {
            requests.push((&pairs[i].change, &pairs[j].preconditioned_change));
        }
    }
    let products = space.dots(&requests);
    for i in 0..m {
        for j in 0..m {
            gram.change_change[i][j] = products[i * m + j];
        }
    }
}

fn forget<V>(pairs: &mut VecDeque<Pair<V>>, gram: &mut Gram, spare: &mut Vec<Pair<V>>) {
    spare.extend(pairs.drain(..));
    gram.step_change.clear();
    gram.change_change.clear();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ½ xᵀAx − bᵀx on plain vectors, A tridiagonal; optionally with a quartic term.
    struct Quadratic {
        size: usize,
        quartic: f64,
    }

    impl VectorSpace for Quadratic {
        type Vector = Vec<f64>;
        fn zeros(&self) -> Vec<f64> {
            vec![0.0; self.size]
        }
        fn evaluate(&mut self, x: &Vec<f64>, g: &mut Vec<f64>) -> f64 {
            let n = self.size;
            let mut value = 0.0;
            for i in 0..n {
                let left = if i > 0 { x[i - 1] } else { 0.0 };
                let right = if i + 1 < n { x[i + 1] } else { 0.0 };
                let ax = 2.0 * x[i] - left - right;
                g[i] = ax - 1.0 + self.quartic * x[i].powi(3);
                value += 0.5 * x[i] * ax - x[i] + 0.25 * self.quartic * x[i].powi(4);
            }
            value
        }
        fn refresh(&mut self, _: &Vec<f64>) {}
        fn precondition(&self, v: &Vec<f64>, r: &mut Vec<f64>) {
            for (r, v) in r.iter_mut().zip(v) {
                *r = 0.5 * v;
            }
        }
        fn dots(&self, pairs: &[(&Vec<f64>, &Vec<f64>)]) -> Vec<f64> {
            pairs
                .iter()
                .map(|(a, b)| a.iter().zip(*b).map(|(a, b)| a * b).sum())
                .collect()
        }
        fn combine(&self, result: &mut Vec<f64>, terms: &[(f64, &Vec<f64>)]) {
            for (i, r) in result.iter_mut().enumerate() {
                *r = terms.iter().map(|(c, v)| c * v[i]).sum();
            }
        }
        fn longest(&self, step: &Vec<f64>) -> f64 {
            step.iter().fold(0.0, |m, v| {
                if v.is_finite() {
                    v.abs().max(m)
                } else {
                    f64::NAN
                }
            })
        }
    }

    fn options(history: usize, norm: f64) -> Options {
        Options {
            history,
            energy_norm: norm,
            displacement_floor_m: 0.0,
            evaluation_limit: 10_000,
            refresh_every: None,
            step_limit_m: f64::INFINITY,
        }
    }

    #[test]
    fn reaches_the_exact_solution_of_a_poisson_problem() {
        let mut space = Quadratic {
            size: 50,
            quartic: 0.0,
        };
        let mut x = space.zeros();
        let outcome = minimise(&mut space, &mut x, &options(8, 1e-10));
        assert_eq!(outcome.stop, Stop::Converged);
        for (i, value) in x.iter().enumerate() {
            let exact = 0.5 * (i as f64 + 1.0) * (50.0 - i as f64);
            assert!((value - exact).abs() < 1e-6 * exact, "{i}: {value} {exact}");
        }
    }

    /// With full history and exact arithmetic, n iterations or a few more suffice on a quadratic; plain preconditioned
    /// descent needs thousands here. A wrong coefficient in the recursion shows as a loss of this property.
    #[test]
    fn full_history_is_quasi_newton() {
        let mut space = Quadratic {
            size: 30,
            quartic: 0.0,
        };
        let mut x = space.zeros();
        let outcome = minimise(&mut space, &mut x, &options(60, 1e-9));
        assert!(outcome.iterations <= 60, "{}", outcome.iterations);
    }

    #[test]
    fn refreshing_the_initial_hessian_changes_nothing_when_it_is_constant() {
        let mut plain = Quadratic {
            size: 40,
            quartic: 0.1,
        };
        let mut a = plain.zeros();
        minimise(&mut plain, &mut a, &options(6, 1e-9));
        let mut b = plain.zeros();
        let refreshed = Options {
            refresh_every: Some(3),
            ..options(6, 1e-9)
        };
        let outcome = minimise(&mut plain, &mut b, &refreshed);
        assert_eq!(outcome.stop, Stop::Converged);
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn a_start_that_is_not_finite_is_refused() {
        let mut space = Quadratic {
            size: 3,
            quartic: 0.0,
        };
        let mut x = vec![0.0, f64::NAN, 0.0];
        assert_eq!(
            minimise(&mut space, &mut x, &options(3, 1e-9)).stop,
            Stop::NotFinite
        );
    }
}
