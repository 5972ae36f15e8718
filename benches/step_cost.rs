//! What a step costs, and what it is worth: pairs of seconds and errors.
//!
//! `cargo bench --bench step_cost [-- FILE]` prints a table and, with FILE, writes the same as JSON, with machine, commit and date
//! from the environment (`RIPSTOP_MACHINE`, `RIPSTOP_COMMIT`, `RIPSTOP_DATE`).
//!
//! * Taylor–Green vortices: error of the decay rate against wall seconds, over resolution, precision and operator.
//! * The shipped canopy case, 24 cells per D₀: milliseconds per step of fluid, coupling and cloth over its first 0.1 s, with the
//!   imbalance of its force routes beside them.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that cannot run should stop"
)]

use std::time::Instant;

use ripstop::case::{self, Choices};
use ripstop::measure::{Record, results};
use ripstop::plan::{Plan, Precision};
use ripstop::run::without_files;
use ripstop::simulation::Simulation;
use serde_json::{Value, json};

fn load(name: &str, overrides: &[String]) -> case::Case {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("cases/{name}.toml"));
    case::load(
        &path,
        &Choices {
            variant: None,
            overrides: overrides.to_vec(),
        },
    )
    .unwrap()
}

/// Runs a case without writing files; returns simulation, record and wall seconds.
fn run(case: &case::Case, precision: Precision) -> (Simulation, Record, f64) {
    let began = Instant::now();
    let (simulation, record) =
        without_files(case, Plan::new(&case.scene, precision), None).unwrap();
    (simulation, record, began.elapsed().as_secs_f64())
}

fn taylor_green() -> Vec<Value> {
    println!("Taylor–Green vortices to 0.2 s: error of the decay rate against time");
    println!(
        "{:>6} {:>9} {:>22} {:>10} {:>9} {:>7}",
        "cells", "precision", "operator", "error", "seconds", "MLUPS"
    );
    let mut rows = Vec::new();
    for operator in ["two_relaxation_times", "recursive_regularised"] {
        for precision in [Precision::F32, Precision::F64] {
            for cells in [16, 32, 64, 96] {
                let case = load(
                    "taylor-green",
                    &[
                        format!("resolution.cell_size_m={}", 1.0 / f64::from(cells)),
                        format!("resolution.lattice_speed={}", 0.96 / f64::from(cells)),
                        format!("resolution.operator={operator}"),
                        "air.taylor_green.depth_m=0.25".to_owned(),
                        "time.end_s=0.2".to_owned(),
                    ],
                );
                let (simulation, record, seconds) = run(&case, precision);
                let results = results(&simulation, &record);
                let error = results
                    .get("velocity_decay_rate_1_s")
                    .unwrap()
                    .error
                    .unwrap();
                let updates = simulation.plan().sizes.cells as f64 * simulation.step_count() as f64;
                let rate = updates / simulation.cost().fluid.as_secs_f64() / 1e6;
                println!(
                    "{cells:>6} {:>9} {operator:>22} {error:>+10.2e} {seconds:>9.3} {rate:>7.0}",
                    precision.name()
                );
                rows.push(json!({
                    "cells_per_side": cells, "precision": precision.name(), "operator": operator,
                    "decay_rate_error": error, "seconds": seconds, "million_lattice_updates_per_s": rate,
                }));
            }
        }
    }
    rows
}

fn canopy() -> Value {
    let case = load("flat-circular-tunnel", &["time.end_s=0.1".to_owned()]);
    let (simulation, record, seconds) = run(&case, Precision::F32);
    let results = results(&simulation, &record);
    let steps = simulation.step_count() as f64;
    let cost = simulation.cost();
    let per_step = |d: std::time::Duration| 1e3 * d.as_secs_f64() / steps;
    let imbalance = results.get("force_imbalance").unwrap().value;
    println!(
        "\ncanopy, 24 cells per D_0, {} cells, {} markers",
        simulation.plan().sizes.cells,
        simulation.plan().sizes.markers
    );
    println!(
        "ms per step: fluid {:.2}, coupling {:.2}, cloth {:.2}, measure {:.2}; {steps} steps in {seconds:.1} s; force imbalance {:.2e}",
        per_step(cost.fluid),
        per_step(cost.coupling),
        per_step(cost.cloth),
        per_step(cost.measure),
        imbalance.unwrap_or(f64::NAN)
    );
    json!({
        "cells": simulation.plan().sizes.cells, "markers": simulation.plan().sizes.markers, "steps": steps,
        "seconds": seconds, "force_imbalance": imbalance,
        "ms_per_step": {
            "fluid": per_step(cost.fluid), "coupling": per_step(cost.coupling),
            "cloth": per_step(cost.cloth), "measure": per_step(cost.measure),
        },
    })
}

fn main() {
    let threads = rayon::current_num_threads();
    println!(
        "{} {}, {threads} threads",
        std::env::consts::OS,
        std::env::consts::ARCH
    );
    let report = json!({
        "benchmark": "step_cost", "ripstop": env!("CARGO_PKG_VERSION"), "threads": threads,
        "machine": std::env::var("RIPSTOP_MACHINE").ok(), "commit": std::env::var("RIPSTOP_COMMIT").ok(),
        "date": std::env::var("RIPSTOP_DATE").ok(),
        "taylor_green": taylor_green(), "canopy": canopy(),
    });
    // Cargo passes `--bench`.
    if let Some(file) = std::env::args().skip(1).find(|a| !a.starts_with("--")) {
        std::fs::write(&file, serde_json::to_string_pretty(&report).unwrap()).unwrap();
        println!("written to {file}");
    }
}
