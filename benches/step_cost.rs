//! What a step costs, and what it is worth: pairs of seconds and errors.
//!
//! `cargo bench --bench step_cost [-- FILE]` prints a table and, with FILE, writes the same as JSON, with machine, commit and date
//! from the environment (`RIPSTOP_MACHINE`, `RIPSTOP_COMMIT`, `RIPSTOP_DATE`).
//!
//! * Taylor–Green vortices: error of the decay rate against wall seconds, over resolution, precision and operator.
//! * The shipped canopy case at 24 and 48 cells per D₀, and in a wider tunnel: milliseconds per step of fluid, interpolation, spreading
//!   and cloth in the first steps after release.
//!
//! `-- --canopy` leaves the vortices out.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a benchmark that cannot run, or tell, should stop"
)]

use std::time::Instant;

use ripstop::case::{self, Choices};
use ripstop::measure::{Record, results};
use ripstop::plan::{Plan, Precision, Stage};
use ripstop::run::without_files;
use ripstop::simulation::Simulation;
use ripstop::statics::Statics;
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
                let results = results(&simulation, &Statics::default(), &record);
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

/// The canopy at so many cells per D_0, in a tunnel `wider` times as wide and high; times are medians of single steps after release, which
/// other work on the machine disturbs little.
fn canopy(cells_per_diameter: f64, wider: f64) -> Value {
    const D_0: f64 = 0.997;
    let width = 3.0 * wider * D_0;
    let case = load(
        "flat-circular-tunnel",
        &[
            format!("resolution.cells_per_diameter={cells_per_diameter:?}"),
            format!(
                "air.wind_tunnel.size_m=[{:?}, {width:?}, {width:?}]",
                5.0 * D_0
            ),
            format!(
                "structure.flat_circular.confluence_m=[0.6, {0:?}, {0:?}]",
                0.5 * width
            ),
            // Held while the wind rises, as briefly as serves to warm up.
            "air.wind_tunnel.start_time_s=0.002".to_owned(),
            "coupling.scheme=kernel".to_owned(),
            format!("time.end_s={:?}", 0.3 / cells_per_diameter),
        ],
    );
    let plan = Plan::new(&case.scene, Precision::F32);
    let steps = plan.start_steps + plan.steps;
    let mut simulation = Simulation::new(case.scene, plan, None).unwrap();
    const STAGES: [Stage; 4] = [
        Stage::CollideStream,
        Stage::Interpolate,
        Stage::SolveCloth,
        Stage::Spread,
    ];
    let mut times: [Vec<f64>; 4] = Default::default();
    while simulation.step_count() < steps {
        let before = *simulation.cost();
        let released = simulation.released();
        simulation.advance().unwrap();
        if released {
            for (times, stage) in times.iter_mut().zip(STAGES) {
                let time = simulation.cost().of(stage).time - before.of(stage).time;
                times.push(1e3 * time.as_secs_f64());
            }
        }
    }
    let [fluid, interpolate, cloth, spread] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    let sizes = &simulation.plan().sizes;
    let share = (interpolate + cloth + spread) / (fluid + interpolate + cloth + spread);
    let per_marker = |ms: f64| 1e3 * ms / sizes.markers as f64;
    println!(
        "{cells_per_diameter:>6} {:>10} {:>8} {fluid:>9.2} {interpolate:>12.3} {spread:>8.3} {cloth:>8.3} {:>8.1} % {:>12.3} {:>8.3}",
        sizes.cells,
        sizes.markers,
        100.0 * share,
        per_marker(interpolate),
        per_marker(spread),
    );
    json!({
        "cells_per_diameter": cells_per_diameter, "cells": sizes.cells, "markers": sizes.markers,
        "ms_per_step": { "fluid": fluid, "interpolate": interpolate, "spread": spread, "cloth": cloth },
        "share_of_coupling_and_cloth": share,
        "us_per_marker": { "interpolate": per_marker(interpolate), "spread": per_marker(spread) },
    })
}

fn canopies() -> Vec<Value> {
    println!(
        "\ncanopy: ms per step (medians), share of coupling and cloth, us per marker; in the wider tunnel nothing but the air may cost more"
    );
    println!(
        "{:>6} {:>10} {:>8} {:>9} {:>12} {:>8} {:>8} {:>10} {:>12} {:>8}",
        "cells",
        "air",
        "markers",
        "fluid",
        "interpolate",
        "spread",
        "cloth",
        "share",
        "interpolate",
        "spread"
    );
    [(24.0, 1.0), (24.0, 1.5), (48.0, 1.0)]
        .map(|(cells, wider)| canopy(cells, wider))
        .to_vec()
}

fn main() {
    let threads = rayon::current_num_threads();
    println!(
        "{} {}, {threads} threads",
        std::env::consts::OS,
        std::env::consts::ARCH
    );
    let canopy_alone = std::env::args().any(|argument| argument == "--canopy");
    let vortices = if canopy_alone {
        Vec::new()
    } else {
        taylor_green()
    };
    let report = json!({
        "benchmark": "step_cost", "ripstop": env!("CARGO_PKG_VERSION"), "threads": threads,
        "machine": std::env::var("RIPSTOP_MACHINE").ok(), "commit": std::env::var("RIPSTOP_COMMIT").ok(),
        "date": std::env::var("RIPSTOP_DATE").ok(),
        "taylor_green": vortices, "canopy": canopies(),
    });
    // Cargo passes `--bench`.
    if let Some(file) = std::env::args().skip(1).find(|a| !a.starts_with("--")) {
        std::fs::write(&file, serde_json::to_string_pretty(&report).unwrap()).unwrap();
        println!("written to {file}");
    }
}
