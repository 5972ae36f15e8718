//! Newton's method on small vectors whose minimum is known.

use std::convert::Infallible;

use super::super::lbfgs::tests::Quadratic;
use super::super::{Attempt, Landing, Refreshed, Start};
use super::*;

type Vector = Vec<f64>;

/// The problem of the L-BFGS tests, whose matrix is known at every point.
struct Known {
    space: Quadratic,
    /// Where the matrix was built.
    at: Vector,
}

impl Known {
    fn new(size: usize, quartic: f64) -> Self {
        Self {
            space: Quadratic::new(size, quartic),
            at: Vec::new(),
        }
    }
}

impl VectorSpace for Known {
    type Point = Vector;
    type Vector = Vector;
    type Error = Infallible;

    fn point(&mut self) -> Result<Vector, Infallible> {
        self.space.point()
    }

    fn vector(&mut self) -> Result<Vector, Infallible> {
        self.space.vector()
    }

    fn start(&mut self, x: &Vector, g: &mut Vector, h: &mut Vector) -> Result<Start, Infallible> {
        self.at.clone_from(x);
        self.space.start(x, g, h)
    }

    fn attempt(
        &mut self,
        from: &Step<'_, Vector, Vector>,
        to: &mut Landing<'_, Vector, Vector>,
        stored: &[&Vector],
    ) -> Result<Attempt, Infallible> {
        self.space.attempt(from, to, stored)
    }

    fn refresh(
        &mut self,
        x: &Vector,
        g: &Vector,
        h: &mut Vector,
        pairs: &mut [(&Vector, &mut Vector)],
    ) -> Result<Refreshed, Infallible> {
        self.at.clone_from(x);
        self.space.refresh(x, g, h, pairs)
    }

    fn combine(&mut self, result: &mut Vector, terms: &[(f64, &Vector)]) -> Result<(), Infallible> {
        self.space.combine(result, terms)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Curvature for Known {
    fn multiply(&mut self, v: &Vector, product: &mut Vector) -> Result<f64, Infallible> {
        let n = v.len();
        for i in 0..n {
            let left = if i > 0 { v[i - 1] } else { 0.0 };
            let right = if i + 1 < n { v[i + 1] } else { 0.0 };
            let diagonal = 2.0 + 3.0 * self.space.quartic * self.at[i].powi(2);
            product[i] = diagonal * v[i] - left - right;
        }
        Ok(dot(v, product))
    }

    fn precondition(&mut self, v: &Vector, result: &mut Vector) -> Result<f64, Infallible> {
        for (r, v) in result.iter_mut().zip(v) {
            *r = self.space.inverse * v;
        }
        Ok(dot(v, result))
    }

    fn advance(
        &mut self,
        from: &Step<'_, Vector, Vector>,
        point: &mut Vector,
        gradient: &mut Vector,
    ) -> Result<Trial, Infallible> {
        let mut unused = vec![0.0; point.len()];
        let mut to = Landing {
            point,
            gradient,
            preconditioned: &mut unused,
        };
        let attempt = self.space.attempt(from, &mut to, &[])?;
        Ok(Trial {
            objective: attempt.objective,
            round_off: attempt.round_off,
            length: attempt.length,
            slope_before: attempt.slope - attempt.slope_change,
            slope: attempt.slope,
        })
    }
}

fn solved(mut space: Known, step_limit_m: f64, evaluation_limit: usize) -> (Vector, Outcome) {
    let options = Options {
        history: 0,
        tolerance: 1e-10,
        displacement_floor_m: 0.0,
        time_step: false,
        evaluation_limit,
        refresh_every: None,
        step_limit_m,
    };
    let mut x = vec![0.0; space.space.size];
    let Ok(outcome) = minimise_watched(&mut space, &mut x, &options, &mut |_| true);
    (x, outcome)
}

/// On a quadratic each step leaves at most the share of the norm to which its equations are solved.
#[test]
fn reaches_the_exact_solution_of_a_poisson_problem() {
    let (x, outcome) = solved(Known::new(50, 0.0), f64::INFINITY, 1000);
    assert_eq!(outcome.stop, Stop::Converged);
    for (i, value) in x.iter().enumerate() {
        let exact = 0.5 * (i as f64 + 1.0) * (50.0 - i as f64);
        assert!((value - exact).abs() < 1e-6 * exact, "{i}: {value} {exact}");
    }
    let steps = (1e-11f64.ln() / FORCING.ln()).ceil() as usize;
    assert!(outcome.iterations <= steps, "{}", outcome.iterations);
}

#[test]
fn a_quartic_takes_few_steps() {
    let (x, outcome) = solved(Known::new(40, 1.0), f64::INFINITY, 1000);
    assert_eq!(outcome.stop, Stop::Converged);
    assert!(outcome.iterations <= 30, "{}", outcome.iterations);
    let mut gradient = vec![0.0; 40];
    Quadratic::new(40, 1.0).evaluate(&x, &mut gradient);
    assert!(gradient.iter().all(|g| g.abs() < 1e-9));
}

#[test]
fn no_node_moves_farther_than_the_limit() {
    let (x, outcome) = solved(Known::new(40, 0.0), 0.01, 11);
    assert_eq!(outcome.stop, Stop::LimitReached);
    assert_eq!(outcome.evaluations, 11);
    let longest = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(longest <= 0.1 + 1e-12 && longest > 0.05, "{longest}");
}

#[test]
fn a_start_that_is_not_finite_is_refused() {
    let options = Options {
        history: 0,
        tolerance: 1e-9,
        displacement_floor_m: 0.0,
        time_step: false,
        evaluation_limit: 10,
        refresh_every: None,
        step_limit_m: f64::INFINITY,
    };
    let mut x = vec![0.0, f64::NAN, 0.0];
    let Ok(outcome) = minimise_watched(&mut Known::new(3, 0.0), &mut x, &options, &mut |_| true);
    assert_eq!(outcome.stop, Stop::NotFinite);
}
