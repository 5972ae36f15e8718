//! How well one multigrid cycle inverts the matrix that it is made for, apart from what the matrix lacks of the true Hessian.

use glam::DVec3;
use ripstop::cpu::cloth::{InitialHessian, SolverSettings};
use serde_json::{Value, json};

use crate::sheet::Problem;

/// Residual to which the equations are solved, in the energy norm.
const REDUCTION: f64 = 1e-6;

const CYCLE_LIMIT: usize = 500;

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Cycles of conjugate gradients on the projected Hessian at the start and at the equilibrium, for the loads as right side; prints a row and returns it.
pub fn measure(problem: &Problem, settings: &SolverSettings) -> Value {
    let mut cloth = problem.cloth();
    let input = problem.input();
    let flat = cycles(&mut cloth, problem);
    let outcome = cloth.solve_cloth(&input, settings);
    let solved = cycles(&mut cloth, problem);
    let springs = &cloth.structure.springs;
    let pushing = springs.iter().filter(|spring| {
        let [a, b] = spring.nodes.map(|n| cloth.positions_m[n as usize]);
        a.distance(b) < spring.rest_length_m
    });
    let share = pushing.count() as f64 / springs.len().max(1) as f64;
    println!(
        "{:>24} {:>5} {flat:>12} {solved:>15} {:>9.1} % {:>8}",
        problem.name(),
        problem.side,
        100.0 * share,
        outcome.evaluations
    );
    json!({
        "problem": problem, "reduction": REDUCTION, "cycles_flat": flat, "cycles_at_equilibrium": solved,
        "share_of_springs_that_push": share, "evaluations": outcome.evaluations, "stop": format!("{:?}", outcome.stop),
    })
}

fn cycles(cloth: &mut ripstop::cpu::cloth::Cloth, problem: &Problem) -> usize {
    let point = cloth.positions_m.clone();
    let loads: Vec<DVec3> = cloth
        .structure
        .masses_kg
        .iter()
        .zip(&cloth.structure.held)
        .map(|(&mass, &held)| {
            if held {
                DVec3::ZERO
            } else {
                problem.input().gravity_m_s2 * mass
            }
        })
        .collect();
    let input = problem.input();
    let mut evaluator = cloth.evaluator(&input, InitialHessian::Multigrid);
    evaluator.rebuild(&point);
    let mut residual = loads;
    let mut z = evaluator.precondition(&residual);
    let mut direction = z.clone();
    let mut square = dot(&residual, &z);
    let goal = REDUCTION * REDUCTION * square;
    for cycle in 1..CYCLE_LIMIT {
        let product = evaluator.stiffness_times(&direction).unwrap();
        let length = square / dot(&direction, &product);
        for (r, p) in residual.iter_mut().zip(&product) {
            *r -= *p * length;
        }
        z = evaluator.precondition(&residual);
        let new = dot(&residual, &z);
        if new <= goal {
            return cycle;
        }
        for (d, z) in direction.iter_mut().zip(&z) {
            *d = *z + *d * (new / square);
        }
        square = new;
    }
    CYCLE_LIMIT
}
