//! L-BFGS on small vectors whose minimum is known.

use std::convert::Infallible;

use super::super::{Refreshed, Start};
use super::*;

/// ½ xᵀAx − bᵀx on plain vectors, A tridiagonal; optionally with a quartic term.
pub(in crate::solve) struct Quadratic {
    pub(in crate::solve) size: usize,
    pub(in crate::solve) quartic: f64,
    /// H₀ = `inverse` · 1; halved or doubled at every refresh where `drifting`.
    pub(in crate::solve) inverse: f64,
    drifting: bool,
    /// H₀ is no number after a refresh.
    spoilt: bool,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn longest(step: &[f64]) -> f64 {
    step.iter().fold(0.0, |m, v| {
        if v.is_finite() {
            v.abs().max(m)
        } else {
            f64::NAN
        }
    })
}

impl Quadratic {
    pub(in crate::solve) fn new(size: usize, quartic: f64) -> Self {
        Self {
            size,
            quartic,
            inverse: 0.5,
            drifting: false,
            spoilt: false,
        }
    }

    pub(in crate::solve) fn evaluate(&self, x: &[f64], g: &mut [f64]) -> f64 {
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

    fn scaled(&self, v: &[f64]) -> Vec<f64> {
        v.iter().map(|v| self.inverse * v).collect()
    }
}

impl VectorSpace for Quadratic {
    type Point = Vec<f64>;
    type Vector = Vec<f64>;
    type Error = Infallible;

    fn point(&mut self) -> Result<Vec<f64>, Infallible> {
        Ok(vec![0.0; self.size])
    }

    fn vector(&mut self) -> Result<Vec<f64>, Infallible> {
        Ok(vec![0.0; self.size])
    }

    fn start(
        &mut self,
        x: &Vec<f64>,
        g: &mut Vec<f64>,
        h: &mut Vec<f64>,
    ) -> Result<Start, Infallible> {
        let objective = self.evaluate(x, g);
        *h = self.scaled(g);
        Ok(Start {
            objective,
            round_off: 1e-10 * objective.abs(),
            norm_square: dot(g, h),
            longest_m: longest(h),
            reference: 1.0,
        })
    }

    fn attempt(
        &mut self,
        from: &Step<'_, Vec<f64>, Vec<f64>>,
        to: &mut Landing<'_, Vec<f64>, Vec<f64>>,
        stored: &[&Vec<f64>],
    ) -> Result<Attempt, Infallible> {
        let length = from.length.min(from.step_limit_m / longest(from.direction));
        for ((t, x), d) in to.point.iter_mut().zip(from.point).zip(from.direction) {
            *t = x + length * d;
        }
        let objective = self.evaluate(to.point, to.gradient);
        *to.preconditioned = self.scaled(to.gradient);
        let (g, h) = (&*to.gradient, &*to.preconditioned);
        let y = minus(g, from.gradient);
        let z = minus(h, from.preconditioned);
        Ok(Attempt {
            objective,
            round_off: 1e-10 * objective.abs(),
            length,
            slope: dot(g, from.direction),
            slope_change: dot(&y, from.direction),
            norm_square: dot(g, h),
            gradient_change: dot(g, &z),
            change_square: dot(&y, &z),
            longest_m: longest(h),
            stored: stored.iter().map(|v| [dot(g, v), dot(&y, v)]).collect(),
        })
    }

    fn refresh(
        &mut self,
        _: &Vec<f64>,
        g: &Vec<f64>,
        h: &mut Vec<f64>,
        pairs: &mut [(&Vec<f64>, &mut Vec<f64>)],
    ) -> Result<Refreshed, Infallible> {
        if self.spoilt {
            self.inverse = f64::NAN;
        }
        if self.drifting {
            self.inverse = if self.inverse > 0.3 { 0.25 } else { 0.5 };
        }
        *h = self.scaled(g);
        for (y, z) in &mut *pairs {
            **z = self.scaled(y);
        }
        let change_change = (0..pairs.len())
            .flat_map(|i| (0..=i).map(move |j| (i, j)))
            .map(|(i, j)| dot(pairs[i].0, pairs[j].1))
            .collect();
        Ok(Refreshed {
            reference: 1.0,
            norm_square: dot(g, h),
            longest_m: longest(h),
            gradient_change: pairs.iter().map(|(_, z)| dot(g, z)).collect(),
            change_change,
        })
    }

    fn combine(
        &mut self,
        result: &mut Vec<f64>,
        terms: &[(f64, &Vec<f64>)],
    ) -> Result<(), Infallible> {
        for (i, r) in result.iter_mut().enumerate() {
            *r = terms.iter().map(|(c, v)| c * v[i]).sum();
        }
        Ok(())
    }
}

fn options(history: usize, tolerance: f64) -> Options {
    Options {
        history,
        tolerance,
        displacement_floor_m: 0.0,
        time_step: false,
        evaluation_limit: 10_000,
        refresh_every: None,
        step_limit_m: f64::INFINITY,
    }
}

fn solved(mut space: Quadratic, options: &Options) -> (Vec<f64>, Outcome) {
    let mut x = vec![0.0; space.size];
    let Ok(outcome) = minimise(&mut space, &mut x, options);
    (x, outcome)
}

#[test]
fn reaches_the_exact_solution_of_a_poisson_problem() {
    let (x, outcome) = solved(Quadratic::new(50, 0.0), &options(8, 1e-10));
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
    let (_, outcome) = solved(Quadratic::new(30, 0.0), &options(60, 1e-9));
    assert!(outcome.iterations <= 60, "{}", outcome.iterations);
}

#[test]
fn refreshing_the_initial_hessian_changes_nothing_when_it_is_constant() {
    let (a, plain) = solved(Quadratic::new(40, 0.1), &options(6, 1e-9));
    for every in [1, 3] {
        let refreshed = Options {
            refresh_every: Some(every),
            ..options(6, 1e-9)
        };
        let (b, outcome) = solved(Quadratic::new(40, 0.1), &refreshed);
        assert_eq!(outcome.stop, Stop::Converged);
        assert!(outcome.evaluations.abs_diff(plain.evaluations) <= 5);
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-6);
        }
    }
}

/// An H₀ that halves and doubles between iterations must not spoil the recursion; products with old z_i would.
#[test]
fn a_changing_initial_hessian_stays_quasi_newton() {
    let space = Quadratic {
        drifting: true,
        ..Quadratic::new(30, 0.0)
    };
    let refreshed = Options {
        refresh_every: Some(1),
        ..options(60, 1e-9)
    };
    let (_, outcome) = solved(space, &refreshed);
    assert_eq!(outcome.stop, Stop::Converged);
    assert!(outcome.iterations <= 60, "{}", outcome.iterations);
}

/// The recursion against the dense matrix that it stands for, H⁺ = (1 − ρ s yᵀ) H (1 − ρ y sᵀ) + ρ s sᵀ from γ H₀.
#[test]
fn the_direction_is_that_of_the_dense_formula() {
    const H0: [f64; 4] = [0.3, 1.7, 0.9, 2.2];
    let steps = [
        [1.0, 0.2, -0.4, 0.3],
        [0.1, -0.8, 0.5, 0.2],
        [0.6, 0.3, 0.9, -0.7],
    ];
    // y = A s, A tridiagonal and positive definite.
    let changes = steps.map(|s| {
        let at = |i: usize| s.get(i).copied().unwrap_or(0.0);
        [0, 1, 2, 3].map(|i| 3.0 * s[i] - at(i + 1) - if i > 0 { s[i - 1] } else { 0.0 })
    });
    let scaled = changes.map(|y| [0, 1, 2, 3].map(|i| H0[i] * y[i]));
    let table = |a: &[[f64; 4]], b: &[[f64; 4]]| -> VecDeque<VecDeque<f64>> {
        let row = |v: &[f64; 4]| b.iter().map(|w| dot(v, w)).collect();
        a.iter().map(row).collect()
    };
    let gradient = [0.7, -0.2, 1.1, 0.4];
    let preconditioned = [0, 1, 2, 3].map(|i| H0[i] * gradient[i]);
    let products = Products {
        gradient_step: steps.iter().map(|s| dot(&gradient, s)).collect(),
        gradient_change: scaled.iter().map(|z| dot(&gradient, z)).collect(),
        step_change: table(&steps, &changes),
        change_change: table(&changes, &scaled),
    };
    let plan = products.direction(dot(&gradient, &preconditioned));
    let direction: Vec<f64> = (0..4)
        .map(|k| {
            let pairs = (0..3).map(|i| plan.change[i] * scaled[i][k] - plan.step[i] * steps[i][k]);
            pairs.sum::<f64>() - plan.scale * preconditioned[k]
        })
        .collect();
    let scale = dot(&steps[2], &changes[2]) / dot(&changes[2], &scaled[2]);
    let mut dense =
        [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| if i == j { scale * H0[i] } else { 0.0 }));
    for (s, y) in steps.iter().zip(&changes) {
        let rho = 1.0 / dot(s, y);
        let of_change = dense.map(|row| dot(&row, y));
        let square = dot(y, &of_change);
        for i in 0..4 {
            for j in 0..4 {
                dense[i][j] += rho
                    * ((1.0 + rho * square) * s[i] * s[j]
                        - s[i] * of_change[j]
                        - of_change[i] * s[j]);
            }
        }
    }
    for k in 0..4 {
        let expected = -dot(&dense[k], &gradient);
        assert!(
            (direction[k] - expected).abs() < 1e-12,
            "{k}: {} {expected}",
            direction[k]
        );
    }
    assert!((plan.slope - dot(&gradient, &direction)).abs() < 1e-12);
    for (found, change) in plan.along_changes.iter().zip(&changes) {
        assert!((found - dot(&direction, change)).abs() < 1e-12);
    }
}

/// However wrong the scale of H₀, the first pair puts it right.
#[test]
fn the_scale_of_the_initial_hessian_does_not_matter() {
    let counts = [0.5, 0.5e-3, 0.5e-6].map(|inverse| {
        let space = Quadratic {
            inverse,
            ..Quadratic::new(40, 0.0)
        };
        // The norm √(gᵀH₀g) has the scale, too.
        let (_, outcome) = solved(space, &options(6, 1e-6 * inverse.sqrt()));
        assert_eq!(outcome.stop, Stop::Converged);
        outcome.evaluations
    });
    assert!(counts[1] <= counts[0] + counts[0] / 2, "{counts:?}");
    assert!(counts[2] <= counts[0] + counts[0] / 2, "{counts:?}");
}

/// A negative gᵀH₀g is no small norm.
#[test]
fn an_indefinite_initial_hessian_is_no_convergence() {
    let space = Quadratic {
        inverse: -0.5,
        ..Quadratic::new(40, 0.0)
    };
    let (_, outcome) = solved(space, &options(6, 1e-6));
    assert_eq!(outcome.stop, Stop::Indefinite);
}

#[test]
fn no_node_moves_farther_than_the_limit() {
    let limited = Options {
        step_limit_m: 0.01,
        evaluation_limit: 11,
        ..options(6, 1e-9)
    };
    let (x, outcome) = solved(Quadratic::new(40, 0.0), &limited);
    assert_eq!(outcome.stop, Stop::LimitReached);
    assert!(longest(&x) <= 0.1 + 1e-12, "{}", longest(&x));
}

#[test]
fn a_tolerance_below_round_off_ends_in_a_stall() {
    let unreachable = Options {
        evaluation_limit: 1_000_000,
        ..options(8, 0.0)
    };
    let (_, outcome) = solved(Quadratic::new(50, 0.0), &unreachable);
    assert_eq!(outcome.stop, Stop::Stalled);
    assert!(outcome.energy_norm < 1e-9, "{}", outcome.energy_norm);
}

#[test]
fn a_watcher_may_end_it() {
    let mut x = vec![0.0; 50];
    let mut told = Vec::new();
    let mut watch = |progress: &Progress| {
        told.push(progress.relative_norm);
        told.len() < 5
    };
    let mut space = Quadratic::new(50, 0.0);
    let Ok(outcome) = minimise_watched(&mut space, &mut x, &options(8, 1e-10), &mut watch);
    assert_eq!(outcome.stop, Stop::Interrupted);
    assert_eq!(outcome.iterations, 4);
    assert_eq!(told.len(), 5);
    assert!(longest(&x) > 0.0);
}

#[test]
fn a_start_that_is_not_finite_is_refused() {
    let mut x = vec![0.0, f64::NAN, 0.0];
    let Ok(outcome) = minimise(&mut Quadratic::new(3, 0.0), &mut x, &options(3, 1e-9));
    assert_eq!(outcome.stop, Stop::NotFinite);
}

/// An H₀ that a refresh spoils is no convergence, whether the refresh is due or the end is looked at again.
#[test]
fn a_refresh_that_is_not_finite_is_refused() {
    for every in [1, 1000] {
        let space = Quadratic {
            spoilt: true,
            ..Quadratic::new(20, 0.1)
        };
        let refreshed = Options {
            refresh_every: Some(every),
            ..options(6, 1e-6)
        };
        let (_, outcome) = solved(space, &refreshed);
        assert_eq!(outcome.stop, Stop::NotFinite, "{every}");
    }
}
