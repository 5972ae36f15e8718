//! How far a minimiser is that knows nothing of our norm.

use std::time::{Duration, Instant};

use glam::DVec3;
use ripstop::cpu::cloth::Evaluator;
use serde_json::{Value, json};

use crate::sheet::Problem;

/// What a method may spend.
pub const EVALUATION_LIMIT: usize = 20_000;
pub const SECONDS_LIMIT: f64 = 60.0;

/// Counts evaluations, and tells now and then whether the energy norm is reached; that takes no time of the method.
pub struct Meter<'a> {
    pub evaluator: Evaluator<'a>,
    pub evaluations: usize,
    tolerance: f64,
    began: Instant,
    outside: Duration,
    next: usize,
    norm: f64,
    reached: bool,
}

impl<'a> Meter<'a> {
    pub fn new(evaluator: Evaluator<'a>, tolerance: f64) -> Self {
        Self {
            evaluator,
            evaluations: 0,
            tolerance,
            began: Instant::now(),
            outside: Duration::ZERO,
            next: 0,
            norm: f64::NAN,
            reached: false,
        }
    }

    pub fn evaluate(&mut self, point: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        self.evaluations += 1;
        self.evaluator.evaluate(point, gradient)
    }

    fn seconds(&self) -> f64 {
        (self.began.elapsed() - self.outside).as_secs_f64()
    }

    /// True where the method may end; to be asked once per iteration. The norm is looked at every 2 % of the evaluations.
    pub fn ends(&mut self, point: &[DVec3], gradient: &[DVec3]) -> bool {
        if self.evaluations >= self.next {
            let outside = Instant::now();
            self.norm = self.evaluator.relative_energy_norm(point, gradient);
            self.reached = self.norm <= self.tolerance;
            self.outside += outside.elapsed();
            self.next = self.evaluations + 1 + self.evaluations / 50;
        }
        self.reached || self.evaluations >= EVALUATION_LIMIT || self.seconds() > SECONDS_LIMIT
    }

    /// Prints a row and returns it; `cycles` are those of the method, not of the norm.
    pub fn row(&self, problem: &Problem, method: &str, stop: &str, cycles: Option<usize>) -> Value {
        let seconds = self.seconds();
        let stop = if self.reached { "reached" } else { stop };
        print_row(
            problem,
            method,
            stop,
            self.evaluations,
            cycles,
            seconds,
            self.norm,
        );
        json!({
            "problem": problem, "method": method, "stop": stop, "evaluations": self.evaluations, "cycles": cycles,
            "seconds": seconds, "relative_energy_norm": self.norm,
        })
    }
}

pub fn print_row(
    problem: &Problem,
    method: &str,
    stop: &str,
    evaluations: usize,
    cycles: Option<usize>,
    seconds: f64,
    norm: f64,
) {
    let cycles = cycles.map_or("-".to_owned(), |c| c.to_string());
    println!(
        "{:>28} {:>4} {method:>28} {stop:>12} {evaluations:>7} {cycles:>6} {seconds:>9.3} {norm:>9.1e}",
        problem.name(),
        problem.side,
    );
}
