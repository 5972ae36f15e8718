//! Our minimiser on one problem.

use std::time::Instant;

use glam::DVec3;
use ripstop::cpu::cloth::{Cloth, InitialHessian, SolverSettings};
use ripstop::solve::lbfgs::{HISTORY, Stop};
use serde_json::{Value, json};

use crate::meter::{EVALUATION_LIMIT, print_row};
use crate::peers::TOLERANCE;
use crate::sheet::Problem;

/// How we solve it.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    pub initial_hessian: InitialHessian,
    pub refresh_every: Option<usize>,
    pub history: usize,
    pub tolerance: f64,
    pub evaluation_limit: usize,
}

impl Setting {
    pub const fn new(initial_hessian: InitialHessian, tolerance: f64) -> Self {
        Self {
            initial_hessian,
            refresh_every: Some(match initial_hessian {
                InitialHessian::Multigrid => 10,
                InitialHessian::BlockJacobi => 1,
            }),
            history: HISTORY,
            tolerance,
            evaluation_limit: 5000,
        }
    }

    pub const fn label(&self) -> &'static str {
        match self.initial_hessian {
            InitialHessian::Multigrid => "multigrid",
            InitialHessian::BlockJacobi => "block-Jacobi",
        }
    }

    pub fn solver(&self) -> SolverSettings {
        SolverSettings {
            tolerance: self.tolerance,
            displacement_floor_m: 0.0,
            evaluation_limit: self.evaluation_limit,
            history: self.history,
            refresh_every: self.refresh_every,
            initial_hessian: self.initial_hessian,
        }
    }
}

/// The structure at the start of a problem: flat, or in equilibrium with another pressure.
pub fn start(problem: &Problem) -> Cloth {
    let mut cloth = problem.cloth();
    if let Some(pressure_pa) = problem.warm_pressure_pa {
        let before = Problem {
            time_step_s: None,
            pressure_pa,
            ..*problem
        };
        let setting = Setting::new(InitialHessian::Multigrid, 1e-6);
        let outcome = cloth.solve_cloth(&before.input(), &setting.solver());
        assert!(outcome.energy_norm.is_finite());
    }
    cloth
}

/// Peak of the resident memory since the last call [MB]; `None` where the system does not tell.
pub fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    Some(kilobytes / 1e3)
}

/// Processor time of this process so far, all threads [s]; `None` where the system does not tell.
pub fn processor_s() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in brackets: user and system time are the fields 14 and 15 of all, in hundredths.
    let mut fields = stat.rsplit(')').next()?.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

fn gradient_norm(cloth: &mut Cloth, problem: &Problem, at: &[DVec3]) -> f64 {
    let input = problem.input();
    let mut evaluator = cloth.evaluator(&input, InitialHessian::BlockJacobi);
    let mut gradient = vec![DVec3::ZERO; at.len()];
    evaluator.evaluate(at, &mut gradient);
    gradient
        .iter()
        .map(|g| g.length_squared())
        .sum::<f64>()
        .sqrt()
}

pub fn print_head() {
    println!(
        "{:>24} {:>5} {:>12} {:>11} {:>6} {:>6} {:>7} {:>9} {:>9} {:>9} {:>7} {:>8} {:>9} {:>9}",
        "problem",
        "side",
        "initial",
        "stop",
        "iter.",
        "eval.",
        "cycles",
        "seconds",
        "CPU s",
        "s/eval.",
        "set-up",
        "peak MB",
        "|g|/|g0|",
        "sag [m]"
    );
}

/// Solves, prints a row and returns it.
pub fn solve(problem: &Problem, setting: &Setting) -> Value {
    peak_megabytes();
    let mut cloth = start(problem);
    let input = problem.input();
    let flat = cloth.positions_m.clone();
    let first_norm = gradient_norm(&mut cloth, problem, &flat);
    let cycles_before = cloth.multigrid_cycles();
    let began = Instant::now();
    cloth.prepare(setting.initial_hessian);
    let setup_s = began.elapsed().as_secs_f64();
    let (began, processor) = (Instant::now(), processor_s());
    let verbose = std::env::var_os("RIPSTOP_BENCH_PROGRESS").is_some();
    let mut next = 0;
    let outcome = cloth.solve_cloth_watched(&input, &setting.solver(), &mut |progress| {
        if verbose && progress.evaluations >= next {
            eprintln!(
                "{:>6} {:.3e} {:.1} s",
                progress.evaluations,
                progress.relative_norm,
                began.elapsed().as_secs_f64()
            );
            next = progress.evaluations + 10;
        }
        true
    });
    let seconds = began.elapsed().as_secs_f64();
    let processor_s = processor_s()
        .zip(processor)
        .map(|(after, before)| after - before);
    let peak = peak_megabytes();
    let cycles = cloth.multigrid_cycles() - cycles_before;
    let sag = cloth.positions_m.iter().map(|x| x.z).fold(0.0, f64::max);
    let solution = std::mem::replace(&mut cloth.positions_m, flat);
    cloth.velocities_m_s.fill(DVec3::ZERO);
    let gradient = gradient_norm(&mut cloth, problem, &solution) / first_norm;
    let stop = format!("{:?}", outcome.stop);
    let seconds_per_evaluation = seconds / outcome.evaluations as f64;
    println!(
        "{:>24} {:>5} {:>12} {stop:>11} {:>6} {:>6} {cycles:>7} {seconds:>9.2} {:>9.2} {seconds_per_evaluation:>9.4} {setup_s:>7.2} {:>8.0} {gradient:>9.1e} {sag:>9.6}",
        problem.name(),
        problem.side,
        setting.label(),
        outcome.iterations,
        outcome.evaluations,
        processor_s.unwrap_or(f64::NAN),
        peak.unwrap_or(f64::NAN),
    );
    json!({
        "problem": problem, "nodes": cloth.positions_m.len(), "method": "ours", "initial_hessian": setting.label(),
        "tolerance": setting.tolerance, "history": setting.history, "refresh_every": setting.refresh_every,
        "stop": stop, "iterations": outcome.iterations, "evaluations": outcome.evaluations, "cycles": cycles,
        "seconds": seconds, "processor_s": processor_s, "seconds_per_evaluation": seconds_per_evaluation, "setup_s": setup_s,
        "peak_megabytes": peak, "relative_gradient": gradient, "sag_m": sag,
    })
}

/// The same as a row of the comparison with others.
pub fn compared(problem: &Problem, initial_hessian: InitialHessian) -> Value {
    let mut cloth = start(problem);
    let input = problem.input();
    let setting = Setting::new(initial_hessian, TOLERANCE);
    let at_start = cloth.positions_m.clone();
    let before = cloth.multigrid_cycles();
    let began = Instant::now();
    let outcome = cloth.solve_cloth(
        &input,
        &Setting {
            evaluation_limit: EVALUATION_LIMIT,
            ..setting
        }
        .solver(),
    );
    let seconds = began.elapsed().as_secs_f64();
    let cycles = (cloth.multigrid_cycles() - before) as usize;
    let reached = std::mem::replace(&mut cloth.positions_m, at_start);
    cloth.velocities_m_s.fill(DVec3::ZERO);
    let mut evaluator = cloth.evaluator(&input, InitialHessian::Multigrid);
    let mut gradient = vec![DVec3::ZERO; reached.len()];
    evaluator.evaluate(&reached, &mut gradient);
    let norm = evaluator.relative_energy_norm(&reached, &gradient);
    let method = format!("ours, {}", setting.label());
    let stop = if outcome.stop == Stop::Converged {
        "reached"
    } else {
        "stalled"
    };
    print_row(
        problem,
        &method,
        stop,
        outcome.evaluations,
        Some(cycles),
        seconds,
        norm,
    );
    json!({
        "problem": problem, "method": method, "stop": stop, "evaluations": outcome.evaluations, "cycles": cycles,
        "seconds": seconds, "relative_energy_norm": norm,
    })
}

/// Steps of a motion that are timed.
const STEPS: usize = 5;

/// Some steps of the motion from flat; prints a row and returns it.
pub fn motion(problem: &Problem, setting: &Setting) -> Value {
    let mut cloth = start(problem);
    let input = problem.input();
    cloth.prepare(setting.initial_hessian);
    let (began, processor) = (Instant::now(), processor_s());
    let (mut evaluations, mut converged) = (0, 0);
    for _ in 0..STEPS {
        let outcome = cloth.solve_cloth(&input, &setting.solver());
        evaluations += outcome.evaluations;
        converged += usize::from(outcome.stop == Stop::Converged);
    }
    let seconds = began.elapsed().as_secs_f64();
    let processor_s = processor_s()
        .zip(processor)
        .map_or(f64::NAN, |(after, before)| after - before);
    let crossing = problem.cells_crossed();
    println!(
        "{:>32} {:>4} {crossing:>10.2} {:>12} {converged}/{STEPS} {evaluations:>6} {:>6} {seconds:>9.3} {processor_s:>9.3}",
        problem.name(),
        problem.side,
        setting.label(),
        cloth.multigrid_cycles(),
    );
    json!({
        "problem": problem, "cells_crossed_per_step": crossing, "initial_hessian": setting.label(), "steps": STEPS,
        "converged": converged, "evaluations": evaluations, "cycles": cloth.multigrid_cycles(), "seconds": seconds,
        "processor_s": processor_s,
    })
}
