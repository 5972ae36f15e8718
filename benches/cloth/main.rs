//! What an equilibrium of fabric costs, over mesh size and initial Hessian, and beside other minimisers.
//!
//! `cargo bench --bench cloth -- [table|scale|peers|step] [FILE.json] [SIDE...]` prints a table and, with FILE.json, writes the same as
//! JSON. Other words choose problems by their names.
//!
//! * `table`: a square sheet of 1 m² of stiff ripstop nylon (E = 430 MPa, 0.1 mm, 53 g/m²) that hangs at its four corners under a dead
//!   load of 50 Pa, from flat with 10 µm of noise: one implicit step of 10 ms, and the static equilibrium; springs that also push, or
//!   tension-only membrane. To a relative energy norm of 1e-4.
//! * `scale`: the static equilibrium to 1e-2; 1000 cells along a side unless told otherwise.
//!
//! Every evaluation is one energy with its gradient; beside it stands |g|/|g at the start|.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that cannot run should stop"
)]

mod ours;
mod sheet;

use ours::Setting;
use ripstop::cpu::cloth::InitialHessian;
use serde_json::Value;
use sheet::Problem;

/// What the command line asks for.
#[derive(Default)]
struct Request {
    part: String,
    file: Option<String>,
    sides: Vec<usize>,
    words: Vec<String>,
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
            } else if ["table", "scale", "peers", "step", "serve"].contains(&argument.as_str()) {
                request.part = argument;
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

    fn wants(&self, name: &str) -> bool {
        self.words.iter().all(|word| name.contains(word.as_str()))
    }
}

fn table(request: &Request) -> Vec<Value> {
    ours::print_head();
    let mut rows = Vec::new();
    for (fabric, time_step_s) in [("network", Some(1e-2)), ("network", None), ("tension", None)] {
        for side in request.sides(&[50, 100, 200]) {
            let problem = Problem {
                time_step_s,
                ..Problem::new(fabric, side)
            };
            for initial_hessian in [InitialHessian::Multigrid, InitialHessian::BlockJacobi] {
                let setting = Setting::new(initial_hessian, 1e-4);
                let slow = initial_hessian == InitialHessian::BlockJacobi && side > 60;
                if !slow && request.wants(&format!("{} {}", problem.name(), setting.label())) {
                    rows.push(ours::solve(&problem, &setting));
                }
            }
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
                let setting = Setting::new(InitialHessian::Multigrid, 1e-2);
                rows.push(ours::solve(&problem, &setting));
            }
        }
    }
    rows
}

fn main() {
    let request = Request::read();
    let rows = match request.part.as_str() {
        "scale" => scale(&request),
        _ => table(&request),
    };
    if let Some(file) = &request.file {
        std::fs::write(file, serde_json::to_string_pretty(&rows).unwrap()).unwrap();
    }
}
