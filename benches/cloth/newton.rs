//! Projected Newton steps by conjugate gradients on the projected Hessian, preconditioned with our multigrid cycle: measured, not adopted.

use glam::DVec3;
use ripstop::cpu::cloth::InitialHessian;
use serde_json::Value;

use crate::meter::Meter;
use crate::ours;
use crate::peers::TOLERANCE;
use crate::sheet::Problem;

const PRODUCTS_PER_STEP: usize = 100;

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Newton with the equations solved to `forcing` in the energy norm.
pub fn newton(problem: &Problem, forcing: f64) -> Value {
    let mut cloth = ours::start(problem);
    let step_limit_m = 2.0 * 2.0f64.sqrt() / problem.side as f64;
    let input = problem.input();
    let mut meter = Meter::new(
        cloth.evaluator(&input, InitialHessian::Multigrid),
        TOLERANCE,
    );
    let mut point = meter.evaluator.prediction_m().to_vec();
    let count = point.len();
    let mut gradient = vec![DVec3::ZERO; count];
    let mut objective = meter.evaluate(&point, &mut gradient);
    let (mut cycles, mut refreshes) = (0, 0);
    let mut stop = "limit";
    'steps: while !meter.ends(&point, &gradient) {
        meter.evaluator.rebuild(&point);
        refreshes += 1;
        let mut step = vec![DVec3::ZERO; count];
        let mut residual: Vec<DVec3> = gradient.iter().map(|g| -*g).collect();
        let mut z = meter.evaluator.precondition(&residual);
        cycles += 1;
        let mut direction = z.clone();
        let mut square = dot(&residual, &z);
        let goal = forcing * forcing * square;
        for _ in 0..PRODUCTS_PER_STEP {
            let product = meter.evaluator.stiffness_times(&direction).unwrap();
            let curvature = dot(&direction, &product);
            if curvature <= 0.0 {
                break;
            }
            let length = square / curvature;
            for i in 0..count {
                step[i] += direction[i] * length;
                residual[i] -= product[i] * length;
            }
            z = meter.evaluator.precondition(&residual);
            cycles += 1;
            let new = dot(&residual, &z);
            if new <= goal {
                break;
            }
            for i in 0..count {
                direction[i] = z[i] + direction[i] * (new / square);
            }
            square = new;
        }
        let slope = dot(&gradient, &step);
        let longest = step.iter().map(|s| s.length()).fold(0.0, f64::max);
        let mut length = (step_limit_m / longest).min(1.0);
        loop {
            let trial: Vec<DVec3> = point
                .iter()
                .zip(&step)
                .map(|(x, s)| *x + *s * length)
                .collect();
            let mut new_gradient = vec![DVec3::ZERO; count];
            let value = meter.evaluate(&trial, &mut new_gradient);
            if value <= objective + 1e-4 * length * slope
                || (value - objective).abs() < 1e-10 * objective.abs()
            {
                (point, gradient, objective) = (trial, new_gradient, value);
                break;
            }
            let parabola = -slope * length * length / (2.0 * (value - objective - length * slope));
            length = parabola.clamp(0.1 * length, 0.5 * length);
            if length < 1e-8 {
                stop = "line search";
                break 'steps;
            }
        }
    }
    let name = format!("Newton-PCG {forcing}, {refreshes} steps");
    meter.row(problem, &name, stop, Some(cycles))
}
