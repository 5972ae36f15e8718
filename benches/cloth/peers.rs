//! Other minimisers on the same energy, from the same start, to the same norm.

use std::cell::RefCell;

use glam::{DMat3, DVec3};
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::{InitialHessian, initial_hessian};
use serde_json::Value;

use crate::meter::Meter;
use crate::ours;
use crate::sheet::Problem;

pub const TOLERANCE: f64 = 1e-4;

/// What is compared: the sheets of the table, and cases kind to methods without a preconditioner.
pub fn problems() -> Vec<Problem> {
    let mut problems = Vec::new();
    for side in [50, 100] {
        for (fabric, time_step_s) in [
            ("network", None),
            ("network", Some(1e-2)),
            ("tension", None),
        ] {
            problems.push(Problem {
                time_step_s,
                ..Problem::new(fabric, side)
            });
        }
    }
    problems.push(Problem {
        softness: 1e-3,
        ..Problem::new("network", 16)
    });
    problems.push(Problem {
        softness: 1e-3,
        ..Problem::new("network", 50)
    });
    problems.push(Problem {
        warm_pressure_pa: Some(49.5),
        ..Problem::new("network", 50)
    });
    for softness in [1.0, 1e-3] {
        problems.push(Problem {
            time_step_s: Some(1e-4),
            softness,
            ..Problem::new("network", 100)
        });
    }
    problems
}

/// The crate `liblbfgs` with its defaults (6 pairs, Moré–Thuente line search), its own stopping rule off.
pub fn liblbfgs(problem: &Problem, tolerance: f64) -> Value {
    let mut cloth = ours::start(problem);
    let input = problem.input();
    let evaluator = cloth.evaluator(&input, InitialHessian::Multigrid);
    let mut x: Vec<f64> = bytemuck::cast_slice(evaluator.prediction_m()).to_vec();
    let meter = RefCell::new(Meter::new(evaluator, tolerance));
    let outcome = liblbfgs::lbfgs().with_epsilon(1e-300).minimize(
        &mut x,
        |x, gx| {
            let mut meter = meter.borrow_mut();
            Ok(meter.evaluate(bytemuck::cast_slice(x), bytemuck::cast_slice_mut(gx)))
        },
        |progress| {
            let mut meter = meter.borrow_mut();
            meter.ends(
                bytemuck::cast_slice(progress.x),
                bytemuck::cast_slice(progress.gx),
            )
        },
    );
    let stop = if outcome.is_err() {
        "line search"
    } else {
        "limit"
    };
    meter.into_inner().row(problem, "liblbfgs", stop, None)
}

/// Fictitious masses for steps of length 1: half of what the elements at a node are stiff, Σ k, which is the trace of its block
/// (Barnes 1999, equation 3); twice that for triangles, with which the motion diverges else.
fn masses(structure: &Structure, problem: &Problem, point: &[DVec3]) -> Vec<f64> {
    let mut blocks = vec![DMat3::ZERO; point.len()];
    initial_hessian::add_elastic_blocks(structure, point, &mut blocks);
    let factor = if structure.springs.is_empty() {
        1.0
    } else {
        0.5
    };
    let inertia = problem.time_step_s.map_or(0.0, |dt| 1.0 / (dt * dt));
    blocks
        .iter()
        .zip(&structure.masses_kg)
        .map(|(b, m)| factor * (b.x_axis.x + b.y_axis.y + b.z_axis.z + inertia * m))
        .collect()
}

/// Dynamic relaxation with kinetic damping (Barnes 1999): explicit motion with fictitious masses, which stops dead at every peak of
/// the kinetic energy.
pub fn dynamic_relaxation(problem: &Problem) -> Value {
    let mut cloth = ours::start(problem);
    let structure = cloth.structure.clone();
    let input = problem.input();
    let mut meter = Meter::new(
        cloth.evaluator(&input, InitialHessian::Multigrid),
        TOLERANCE,
    );
    let mut point = meter.evaluator.prediction_m().to_vec();
    let mut gradient = vec![DVec3::ZERO; point.len()];
    let mut velocities = gradient.clone();
    let mut mass = masses(&structure, problem, &point);
    meter.evaluate(&point, &mut gradient);
    let mut kinetic = 0.0;
    let mut fresh = true;
    while !meter.ends(&point, &gradient) {
        for ((v, g), m) in velocities.iter_mut().zip(&gradient).zip(&mass) {
            // After a stop, half a step from rest.
            *v = if fresh { *g * (-0.5 / m) } else { *v - *g / *m };
        }
        let energy: f64 = velocities
            .iter()
            .zip(&mass)
            .map(|(v, m)| 0.5 * m * v.length_squared())
            .sum();
        if energy < kinetic && !fresh {
            // The peak was half a step before the last one: back to it.
            for ((x, v), (g, m)) in point
                .iter_mut()
                .zip(&velocities)
                .zip(gradient.iter().zip(&mass))
            {
                let before = *v + *g / *m;
                *x -= before * 1.5 - *g * (0.5 / m);
            }
            mass = masses(&structure, problem, &point);
            velocities.fill(DVec3::ZERO);
            (kinetic, fresh) = (0.0, true);
        } else {
            for (x, v) in point.iter_mut().zip(&velocities) {
                *x += *v;
            }
            (kinetic, fresh) = (energy, false);
        }
        if !meter.evaluate(&point, &mut gradient).is_finite() {
            return meter.row(problem, "dynamic relaxation", "diverged", None);
        }
    }
    meter.row(problem, "dynamic relaxation", "limit", None)
}
