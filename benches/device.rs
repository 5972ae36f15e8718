//! What a device does: bandwidth, bare air, the canopy stage by stage, the fabric on host and device; every figure with its error.
//!
//! `cargo bench --bench device [-- FILE]` prints tables and, with FILE, writes the same as JSON. `RIPSTOP_ADAPTER` picks an adapter by
//! name; `RIPSTOP_BENCH_SECONDS` bounds the whole (default 480; parts that would not fit are left out and named).
//! `benches/accelerator.sh` packs this for a machine without a toolchain.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that cannot run should stop"
)]

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ripstop::case::{self, Choices, SHIPPED};
use ripstop::gpu::{AdapterChoice, Device, bandwidth::copy_bandwidth};
use ripstop::immersed::touched::TouchedCells;
use ripstop::lattice::grid::{Setup, Sides, StreamwiseEnds};
use ripstop::lattice::{DIRECTION_COUNT, Operator};
use ripstop::plan::{AirPlacement, ClothPlacement, Placement, Plan, Precision, Storage};
use ripstop::run::without_files;
use ripstop::simulation::{AirEngine, MarkerEngine, Simulation};
use serde_json::{Value, json};

fn load(name: &str, overrides: &[String]) -> case::Case {
    let (_, source) = SHIPPED.iter().find(|(n, _)| *n == name).unwrap();
    let choices = Choices {
        variant: None,
        overrides: overrides.to_vec(),
    };
    case::parse(name, source, Path::new("."), &choices).unwrap()
}

/// Wall clock of the whole benchmark.
struct Budget {
    began: Instant,
    limit: Duration,
    left_out: Vec<String>,
}

impl Budget {
    fn allows(&mut self, what: &str, seconds: f64) -> bool {
        let fits = self.began.elapsed().as_secs_f64() + seconds < self.limit.as_secs_f64();
        if !fits {
            println!("{what} left out: about {seconds:.0} s would exceed the time limit");
            self.left_out.push(what.to_owned());
        }
        fits
    }
}

/// Taylor–Green vortices in a periodic box of n³ cells: updates per second, bandwidth, and the error of their energy after the steps
/// timed, against its exact decay.
fn bare_air(device: &Arc<Device>, copy: f64, budget: &mut Budget) -> Vec<Value> {
    println!(
        "\nbare air, periodic, no eddy viscosity: 152 B per cell and step at most, 76 B with 16-bit storage"
    );
    println!(
        "{:>5} {:>28} {:>9} {:>9} {:>9} {:>12}",
        "side", "operator", "MLUPS", "GB/s", "of copy", "energy error"
    );
    let mut rows = Vec::new();
    let mut rate = 4e6;
    for side in [64usize, 128, 192, 256, 384, 512] {
        for (operator, storage, name) in [
            (
                Operator::TwoRelaxationTimes,
                Storage::F32,
                "two_relaxation_times",
            ),
            (
                Operator::TwoRelaxationTimes,
                Storage::F16,
                "two_relaxation_times 16-bit",
            ),
            (
                Operator::RecursiveRegularised,
                Storage::F32,
                "recursive_regularised",
            ),
            (
                Operator::RecursiveRegularised,
                Storage::F16,
                "recursive_regularised 16-bit",
            ),
        ] {
            let cells = (side as f64).powi(3);
            let what = format!("bare air {side}^3 {name}");
            // Filling costs about 19 evaluations per cell on the host.
            if !budget.allows(&what, 30.0 * cells / rate + cells * 4e-7) {
                continue;
            }
            let tau = 0.6;
            let setup = Setup {
                cells: [side; 3],
                ends: StreamwiseEnds::Periodic,
                sides: Sides::Periodic,
                relaxation_time: tau,
                sponge_cells: None,
                operator,
                eddy_viscosity: None,
            };
            let k = std::f64::consts::TAU / side as f64;
            let speed = 0.02;
            let initial = move |[x, y, _]: [usize; 3]| {
                let (x, y) = (k * (x as f64 + 0.5), k * (y as f64 + 0.5));
                let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
                (
                    excess,
                    [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0],
                )
            };
            let air = AirEngine::build(
                setup,
                Some(&initial),
                AirPlacement::Gpu(storage),
                Some(device),
            );
            let mut air = match air {
                Ok(air) => air,
                Err(error) => {
                    println!("{side:>5} {name:>28} not possible: {error}");
                    rows.push(json!({"side": side, "operator": name, "error": error.to_string()}));
                    continue;
                }
            };
            let AirEngine::Gpu(fluid) = &mut air else {
                continue;
            };
            fluid.collide_stream_steps(4).unwrap();
            device.wait().unwrap();
            let (_, before) = fluid.mass_and_energy().unwrap();
            // As many steps as take about two seconds.
            let start = Instant::now();
            fluid.collide_stream_steps(4).unwrap();
            device.wait().unwrap();
            let steps = ((8.0 / start.elapsed().as_secs_f64()) as usize).clamp(8, 20_000);
            let start = Instant::now();
            fluid.collide_stream_steps(steps).unwrap();
            device.wait().unwrap();
            let seconds = start.elapsed().as_secs_f64();
            let (_, after) = fluid.mass_and_energy().unwrap();
            let exact = 4.0 * (tau - 0.5) / 3.0 * k * k * (steps + 4) as f64;
            let error = after / before / (-exact).exp() - 1.0;
            rate = cells * steps as f64 / seconds;
            let bytes = rate * (2 * DIRECTION_COUNT) as f64 * storage.bytes() as f64;
            println!(
                "{side:>5} {name:>28} {:>9.0} {:>9.1} {:>8.1}% {error:>12.1e}",
                rate / 1e6,
                bytes / 1e9,
                100.0 * bytes / copy
            );
            rows.push(json!({
                "side": side, "operator": name, "steps": steps, "million_lattice_updates_per_s": rate / 1e6,
                "gigabytes_per_s": bytes / 1e9, "share_of_copy_bandwidth": bytes / copy, "energy_error": error,
            }));
        }
    }
    rows
}

/// What `send_markers` costs against the lists of all 64 weights that the CPU engine keeps, for crumpled hemispheres.
fn marker_lists(device: &Arc<Device>) -> Vec<Value> {
    println!(
        "\nlists of touched cells: sorted on the host and marked on the device, against complete lists made on the host"
    );
    println!(
        "{:>8} {:>12} {:>12} {:>12} {:>12}",
        "markers", "sorted [ms]", "to send [B]", "lists [ms]", "to send [B]"
    );
    let mut rows = Vec::new();
    'sizes: for side in [32.0f64, 128.0, 384.0] {
        let radius = 0.35 * side;
        let count = (2.0 * std::f64::consts::PI * radius * radius) as usize;
        let positions: Vec<[f64; 3]> = (0..count)
            .map(|k| {
                // A spiral of equal areas.
                let z = k as f64 / count as f64;
                let angle = 2.4 * k as f64;
                let r = radius * (1.0 - z * z).sqrt();
                [
                    8.0 + radius * z,
                    0.5 * side + r * angle.cos(),
                    0.5 * side + r * angle.sin(),
                ]
            })
            .collect();
        let cells = [side as usize; 3];
        let setup = Setup {
            cells: [(radius as usize) + 16, cells[1], cells[2]],
            ends: StreamwiseEnds::Periodic,
            sides: Sides::Periodic,
            relaxation_time: 0.6,
            sponge_cells: None,
            operator: Operator::RecursiveRegularised,
            eddy_viscosity: None,
        };
        let cells = setup.cells;
        let air =
            AirEngine::build(setup, None, AirPlacement::Gpu(Storage::F32), Some(device)).unwrap();
        let mut markers = MarkerEngine::new(&air, vec![1.0; count], 1.6).unwrap();
        let mut lists = TouchedCells::default();
        let mut best = [f64::INFINITY; 2];
        for _ in 0..10 {
            let start = Instant::now();
            if let Err(error) = markers.send_markers(&air, &positions) {
                println!("{count:>8} not possible: {error}");
                rows.push(json!({"markers": count, "error": error.to_string()}));
                continue 'sizes;
            }
            device.wait().unwrap();
            best[0] = best[0].min(1e3 * start.elapsed().as_secs_f64());
            let start = Instant::now();
            lists.rebuild(&positions, cells).unwrap();
            best[1] = best[1].min(1e3 * start.elapsed().as_secs_f64());
        }
        // Cell, marker and weight of every entry, as 4-byte numbers, and the weights in the markers' order again.
        let bytes = [32 * count, 16 * 64 * count];
        println!(
            "{count:>8} {:>12.3} {:>12} {:>12.3} {:>12}",
            best[0], bytes[0], best[1], bytes[1]
        );
        rows.push(json!({
            "markers": count, "sorted_ms": best[0], "sorted_bytes": bytes[0], "lists_ms": best[1], "lists_bytes": bytes[1],
        }));
    }
    rows
}

fn placement(air: AirPlacement, cloth: ClothPlacement, device: &Device) -> Placement {
    Placement {
        air,
        cloth,
        device: Some(device.info().name.clone()),
        shared_memory: false,
    }
}

fn ms_per_step(simulation: &Simulation) -> Value {
    let cost = simulation.cost();
    let ms = |d: Duration| 1e3 * d.as_secs_f64() / cost.timed_steps.max(1) as f64;
    json!({
        "fluid": ms(cost.fluid), "coupling": ms(cost.coupling), "cloth": ms(cost.cloth), "measure": ms(cost.measure),
    })
}

/// The shipped canopy to 0.02 s on CPU and device: milliseconds per stage, and how far the results lie apart.
fn canopy(device: &Arc<Device>, budget: &mut Budget) -> Vec<Value> {
    let mut rows = Vec::new();
    println!(
        "\nshipped canopy to t = 0.02 s: ms per step of every stage (waiting for the device after each), and of the whole"
    );
    for cells_per_diameter in [24.0, 48.0, 96.0] {
        let case = load(
            "flat-circular-tunnel",
            &[
                "time.end_s=0.02".to_owned(),
                format!("resolution.cells_per_diameter={cells_per_diameter:?}"),
            ],
        );
        let mut reference = f64::NAN;
        let mut device_rate = 1e7;
        for (name, air, cloth) in [
            (
                "device, cloth on host",
                AirPlacement::Gpu(Storage::F32),
                ClothPlacement::Host,
            ),
            (
                "device, cloth on device",
                AirPlacement::Gpu(Storage::F32),
                ClothPlacement::Device,
            ),
            (
                "cpu",
                AirPlacement::Cpu(Precision::F32),
                ClothPlacement::Host,
            ),
        ] {
            let plan = Plan::new(&case.scene, placement(air, cloth, device));
            let updates = plan.sizes.cells as f64 * (plan.start_steps + plan.steps) as f64;
            let rate = match air {
                AirPlacement::Gpu(_) => device_rate,
                AirPlacement::Cpu(_) => 4e7 * rayon::current_num_threads() as f64,
            };
            let what = format!("canopy {cells_per_diameter} cells per D_0, {name}");
            if !budget.allows(&what, 1.5 * updates / rate) {
                continue;
            }
            let taken = Some(device)
                .filter(|_| air == AirPlacement::Gpu(Storage::F32))
                .cloned();
            let cells = plan.sizes.cells;
            let start = Instant::now();
            let (simulation, record) = without_files(&case, plan, taken).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            let steps = simulation.step_count() as f64;
            if air == AirPlacement::Gpu(Storage::F32) {
                device_rate = updates / seconds;
            }
            let diameter = record.latest("projected_diameter_ratio").unwrap();
            if reference.is_nan() {
                reference = diameter;
            }
            let ms = ms_per_step(&simulation);
            println!(
                "{cells_per_diameter:>4} {name:>24} {cells} cells: whole {:.2}, stages {ms}, D_p/D_0 {diameter:.5} ({:+.1e} to the first)",
                1e3 * seconds / steps,
                diameter / reference - 1.0
            );
            rows.push(json!({
                "cells_per_diameter": cells_per_diameter, "placement": name, "cells": cells, "markers": simulation.plan().sizes.markers,
                "steps": steps, "seconds": seconds, "ms_per_step": 1e3 * seconds / steps, "ms_per_stage": ms,
                "projected_diameter_ratio": diameter, "difference_to_first": diameter / reference - 1.0,
            }));
        }
    }
    rows
}

/// A hanging sheet in motion, ten implicit steps of 0.1 ms on host and device: milliseconds per solve and evaluation.
fn cloth(device: &Arc<Device>, budget: &mut Budget) -> Vec<Value> {
    println!("\nhanging sheet, 10 implicit steps of 0.1 ms: fabric on host (f64) and device");
    println!(
        "{:>8} {:>8} {:>10} {:>14} {:>12} {:>14}",
        "nodes", "place", "ms/solve", "evaluations", "ms/eval", "difference [m]"
    );
    let mut rows = Vec::new();
    let mut seconds_per_node = [2e-5; 2];
    for divisions in [16, 32, 64, 128, 256, 512] {
        let nodes = (divisions + 1) * (divisions + 1);
        let case = load(
            "hanging-sheet",
            &[
                format!("structure.sheet.divisions=[{divisions}, {divisions}]"),
                "time.step_s=0.0001".to_owned(),
                "time.end_s=0.001".to_owned(),
            ],
        );
        let mut reference: Option<Vec<glam::DVec3>> = None;
        for (k, (name, place)) in [
            ("host", ClothPlacement::Host),
            ("device", ClothPlacement::Device),
        ]
        .into_iter()
        .enumerate()
        {
            let what = format!("hanging sheet of {nodes} nodes on the {name}");
            if !budget.allows(&what, 2.0 * seconds_per_node[k] * f64::from(nodes)) {
                continue;
            }
            let plan = Plan::new(
                &case.scene,
                placement(AirPlacement::Cpu(Precision::F32), place, device),
            );
            let mut simulation =
                Simulation::new(case.scene.clone(), plan, Some(Arc::clone(device))).unwrap();
            let start = Instant::now();
            for _ in 0..10 {
                simulation.advance().unwrap();
            }
            let seconds = start.elapsed().as_secs_f64();
            seconds_per_node[k] = seconds / f64::from(nodes);
            let cost = simulation.cost();
            let positions = &simulation.cloth().unwrap().positions_m;
            let difference = reference.as_ref().map_or(0.0, |host| {
                host.iter()
                    .zip(positions)
                    .map(|(a, b)| a.distance(*b))
                    .fold(0.0, f64::max)
            });
            let evaluations = cost.evaluations as f64 / 10.0;
            println!(
                "{nodes:>8} {name:>8} {:>10.2} {evaluations:>14.1} {:>12.3} {difference:>14.1e}",
                100.0 * seconds,
                100.0 * seconds / evaluations
            );
            rows.push(json!({
                "nodes": nodes, "placement": name, "ms_per_solve": 100.0 * seconds, "evaluations_per_solve": evaluations,
                "ms_per_evaluation": 100.0 * seconds / evaluations, "largest_difference_m": difference,
            }));
            reference.get_or_insert_with(|| positions.clone());
        }
    }
    rows
}

fn main() {
    let choice = std::env::var("RIPSTOP_ADAPTER").map_or(AdapterChoice::Any, AdapterChoice::Named);
    let seconds = std::env::var("RIPSTOP_BENCH_SECONDS")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(480);
    let device = Device::open(&choice).unwrap();
    let info = device.info().clone();
    println!("{}, {}, {}", info.name, info.kind.name(), info.driver);
    let mut budget = Budget {
        began: Instant::now(),
        limit: Duration::from_secs(seconds),
        left_out: Vec::new(),
    };
    let bytes = (1u64 << 30)
        .min(info.binding_limit_bytes)
        .min(info.buffer_limit_bytes)
        / 16
        * 16;
    let copy = copy_bandwidth(&device, bytes, 16).unwrap();
    println!(
        "copy of {} MB: {:.1} GB/s read and written",
        bytes >> 20,
        copy / 1e9
    );
    let markers = marker_lists(&device);
    let cloth = cloth(&device, &mut budget);
    let canopy = canopy(&device, &mut budget);
    let air = bare_air(&device, copy, &mut budget);
    let report = json!({
        "benchmark": "device", "ripstop": env!("CARGO_PKG_VERSION"),
        "device": info.name, "kind": info.kind.name(), "driver": info.driver,
        "threads": rayon::current_num_threads(),
        "machine": std::env::var("RIPSTOP_MACHINE").ok(), "commit": std::env::var("RIPSTOP_COMMIT").ok(),
        "date": std::env::var("RIPSTOP_DATE").ok(),
        "copy_gigabytes_per_s": copy / 1e9, "copied_bytes": bytes,
        "marker_lists": markers, "bare_air": air, "canopy": canopy, "cloth": cloth, "left_out": budget.left_out,
    });
    // Cargo passes `--bench`.
    if let Some(file) = std::env::args().skip(1).find(|a| !a.starts_with("--")) {
        std::fs::write(&file, serde_json::to_string_pretty(&report).unwrap()).unwrap();
        println!("written to {file}");
    }
}
