//! What an equilibrium of fabric costs, over mesh size and initial Hessian, and beside other minimisers.
//!
//! `cargo bench --bench cloth -- [table|scale|step|cycle|peers|slack] [FILE.json] [SIDE...] [WORD...]` prints a table and, with FILE.json, puts the
//! same there as JSON under the name of the part, with machine, commit and date from the environment (`RIPSTOP_MACHINE`,
//! `RIPSTOP_COMMIT`, `RIPSTOP_DATE`). Words choose problems by their names; `history=5`, `refresh=20`, `tolerance=1e-3` replace settings.
//!
//! * `table`: a square sheet of 1 m² of stiff ripstop nylon (E = 430 MPa, 0.1 mm, 53 g/m²) that hangs at its four corners under a dead
//!   load of 50 Pa, from flat with 10 µm of noise: one implicit step of 10 ms, and the static equilibrium; springs that also push, or
//!   tension-only membrane. To a relative energy norm of 1e-4.
//! * `scale`: the static equilibrium to 1e-2; 1000 cells along a side unless told otherwise.
//! * `step`: five implicit steps from flat, to 1e-3, over the elements that a stretching wave crosses in a step: where multigrid pays.
//! * `cycle`: conjugate gradients with one cycle a step on the projected Hessian, flat and at the equilibrium, to 1e-6: how well the cycle
//!   inverts its matrix, apart from what that lacks of the true Hessian.
//! * `slack`: a sheet that hangs by two corners, which are brought together, under its own weight, to 1e-2; beside the crate liblbfgs.
//! * `peers`: ours, Newton's method, the crate liblbfgs and dynamic relaxation on the same energy, from the same start, to the same norm;
//!   here numbers choose problems. `benches/peers/cloth_compare.py` adds scipy.
//!
//! Every evaluation is one energy with its gradient. Beside it stand the multigrid cycles, the set-up of the levels, the peak of memory,
//! and |g|/|g at the start|: the flat sheet resists with its soft bending only, so that |g| first grows, and says less than the energy norm.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a benchmark that cannot run, or tell, should stop"
)]

mod cycle;
mod meter;
mod newton;
mod ours;
mod peers;
mod serve;
mod sheet;

use ours::Setting;
use ripstop::cpu::cloth::InitialHessian;
use serde_json::{Value, json};
use sheet::Problem;

/// What the command line asks for.
#[derive(Default)]
struct Request {
    part: String,
    file: Option<String>,
    sides: Vec<usize>,
    words: Vec<String>,
    /// `history=5`, `refresh=20`, `tolerance=1e-3`.
    overrides: Vec<(String, f64)>,
}

impl Request {
    fn read() -> Self {
        let mut request = Self {
            part: "table".to_owned(),
            ..Self::default()
        };
        for argument in std::env::args().skip(1).filter(|a| !a.starts_with("--")) {
            if let Ok(side) = argument.parse() {
                request.sides.push(side);
            } else if argument.ends_with(".json") {
                request.file = Some(argument);
            } else if [
                "table", "scale", "peers", "problems", "step", "serve", "cycle", "slack",
            ]
            .contains(&argument.as_str())
            {
                request.part = argument;
            } else if let Some((name, value)) = argument.split_once('=') {
                request
                    .overrides
                    .push((name.to_owned(), value.parse().unwrap()));
            } else {
                request.words.push(argument);
            }
        }
        request
    }

    fn sides(&self, otherwise: &[usize]) -> Vec<usize> {
        if self.sides.is_empty() {
            otherwise.to_vec()
        } else {
            self.sides.clone()
        }
    }

    fn overridden(&self, mut setting: Setting) -> Setting {
        for (name, value) in &self.overrides {
            match name.as_str() {
                "history" => setting.history = *value as usize,
                "refresh" => setting.refresh_every = (*value > 0.0).then_some(*value as usize),
                "tolerance" => setting.tolerance = *value,
                _ => {
                    eprintln!("no setting {name}: history, refresh or tolerance");
                    std::process::exit(2)
                }
            }
        }
        setting
    }

    fn wants(&self, name: &str) -> bool {
        self.words.iter().all(|word| name.contains(word.as_str()))
    }
}

fn table(request: &Request) -> Vec<Value> {
    ours::print_head();
    let mut rows = Vec::new();
    for (fabric, time_step_s) in [
        ("network", Some(1e-2)),
        ("network", None),
        ("tension", None),
    ] {
        for side in request.sides(&[50, 100, 200]) {
            let problem = Problem {
                time_step_s,
                ..Problem::new(fabric, side)
            };
            for initial_hessian in [InitialHessian::Multigrid, InitialHessian::BlockJacobi] {
                let setting = request.overridden(Setting::new(initial_hessian, 1e-4));
                let slow = initial_hessian == InitialHessian::BlockJacobi && side > 60;
                if !slow && request.wants(&format!("{} {}", problem.name(), setting.label())) {
                    rows.push(ours::solve(&problem, &setting));
                }
            }
        }
    }
    rows
}

/// Sheets that hang slack, over their mesh, how far their corners are brought together, and the step; beside liblbfgs on small ones.
fn slack(request: &Request) -> Vec<Value> {
    let mut problems = Vec::new();
    for fabric in ["tension", "network"] {
        for side in request.sides(&[12, 25, 50, 100]) {
            problems.push(Problem::slack(fabric, side, 0.8));
        }
    }
    for width_m in [0.6, 0.9, 0.98, 1.0] {
        problems.push(Problem::slack("tension", request.sides(&[25])[0], width_m));
    }
    for time_step_s in [0.1, 0.01, 0.001] {
        problems.push(Problem {
            time_step_s: Some(time_step_s),
            ..Problem::slack("tension", request.sides(&[25])[0], 0.8)
        });
    }
    ours::print_head();
    let mut rows = Vec::new();
    for problem in &problems {
        if request.wants(&problem.name()) {
            let setting = request.overridden(Setting {
                evaluation_limit: 20_000,
                ..Setting::new(InitialHessian::Multigrid, 1e-2)
            });
            rows.push(ours::solve(problem, &setting));
        }
    }
    for problem in problems.iter().filter(|problem| problem.side <= 25) {
        if request.wants(&problem.name()) {
            rows.push(peers::liblbfgs(problem, 1e-2));
        }
    }
    rows
}

fn scale(request: &Request) -> Vec<Value> {
    ours::print_head();
    let mut rows = Vec::new();
    for fabric in ["network", "membrane", "tension"] {
        for side in request.sides(&[1000]) {
            let problem = Problem::new(fabric, side);
            if request.wants(&problem.name()) {
                let setting = request.overridden(Setting::new(InitialHessian::Multigrid, 1e-2));
                rows.push(ours::solve(&problem, &setting));
            }
        }
    }
    rows
}

/// What of the work is the cycle's, and what that of the minimiser.
fn cycles(request: &Request) -> Vec<Value> {
    println!(
        "{:>24} {:>5} {:>12} {:>15} {:>11} {:>8}",
        "problem", "side", "cycles, flat", "cycles, solved", "push", "eval."
    );
    let mut rows = Vec::new();
    for fabric in ["network", "membrane", "tension"] {
        for side in request.sides(&[50, 100, 200]) {
            let problem = Problem::new(fabric, side);
            if request.wants(&problem.name()) {
                let setting = request.overridden(Setting::new(InitialHessian::Multigrid, 1e-4));
                rows.push(cycle::measure(&problem, &setting.solver()));
            }
        }
    }
    rows
}

/// Where multigrid begins to pay in implicit steps.
fn steps(request: &Request) -> Vec<Value> {
    println!(
        "{:>32} {:>4} {:>10} {:>12} conv. {:>4} {:>6} {:>9} {:>9}",
        "problem", "side", "cells/step", "initial", "eval.", "cycles", "seconds", "CPU s"
    );
    let mut rows = Vec::new();
    for (fabric, softness) in [("network", 1.0), ("network", 1e-2), ("tension", 1.0)] {
        for side in request.sides(&[25, 50, 100]) {
            for time_step_s in [1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2] {
                let problem = Problem {
                    time_step_s: Some(time_step_s),
                    softness,
                    ..Problem::new(fabric, side)
                };
                if !request.wants(&problem.name()) || problem.cells_crossed() > 300.0 {
                    continue;
                }
                for initial_hessian in [InitialHessian::BlockJacobi, InitialHessian::Multigrid] {
                    let setting = Setting {
                        refresh_every: (initial_hessian == InitialHessian::Multigrid).then_some(10),
                        ..Setting::new(initial_hessian, 1e-3)
                    };
                    rows.push(ours::motion(&problem, &request.overridden(setting)));
                }
            }
        }
    }
    rows
}

/// Ours and others, problem by problem; the numbers on the command line choose problems of the list.
fn compare(request: &Request) -> Vec<Value> {
    let problems = peers::problems();
    let all: Vec<usize> = (0..problems.len()).collect();
    let mut rows = Vec::new();
    for number in request.sides(&all) {
        let problem = &problems[number];
        let methods: [(&str, &dyn Fn() -> Value); 6] = [
            ("multigrid", &|| {
                ours::compared(problem, InitialHessian::Multigrid)
            }),
            ("block-Jacobi", &|| {
                ours::compared(problem, InitialHessian::BlockJacobi)
            }),
            ("newton", &|| newton::newton(problem, 0.1)),
            ("newton", &|| newton::newton(problem, 0.5)),
            ("liblbfgs", &|| peers::liblbfgs(problem, peers::TOLERANCE)),
            ("relaxation", &|| peers::dynamic_relaxation(problem)),
        ];
        for (name, method) in methods {
            if request.wants(name) {
                rows.push(method());
            }
        }
    }
    rows
}

fn main() {
    let request = Request::read();
    let rows = match request.part.as_str() {
        "step" => steps(&request),
        "peers" => compare(&request),
        "problems" => {
            println!("{}", serde_json::to_string(&peers::problems()).unwrap());
            return;
        }
        "serve" => {
            serve::serve(&peers::problems()[request.sides[0]]);
            return;
        }
        "scale" => scale(&request),
        "slack" => slack(&request),
        "cycle" => cycles(&request),
        _ => table(&request),
    };
    if let Some(file) = &request.file {
        let mut report: Value = std::fs::read_to_string(file)
            .map_or_else(|_| json!({}), |text| serde_json::from_str(&text).unwrap());
        report[&request.part] = json!({
            "machine": std::env::var("RIPSTOP_MACHINE").ok(), "commit": std::env::var("RIPSTOP_COMMIT").ok(),
            "date": std::env::var("RIPSTOP_DATE").ok(), "threads": rayon::current_num_threads(), "rows": rows,
        });
        std::fs::write(file, serde_json::to_string_pretty(&report).unwrap()).unwrap();
    }
}
