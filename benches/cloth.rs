//! What an equilibrium of fabric costs, over mesh size and initial Hessian.
//!
//! `cargo bench --bench cloth [-- FILE] [SIDE...]` prints a table and, with FILE.json, writes the same as JSON.
//!
//! One implicit step of 10 ms of a square sheet of 1 m² of stiff ripstop nylon (E = 430 MPa, 0.1 mm, 53 g/m²) that hangs at its four
//! corners under a dead load of 50 Pa, from flat with 10 µm of noise; springs that also push, or tension-only membrane. Every evaluation is
//! one energy with its gradient. The solve ends at a relative energy norm of 1e-4; beside it stands |g|/|g at the start|.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that cannot run should stop"
)]

use std::time::Instant;

use glam::DVec3;
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};
use serde_json::json;

const FABRIC: Fabric = Fabric {
    thickness_m: 1e-4,
    density_kg_m3: 530.0,
    warp_modulus_pa: 4.3e8,
    weft_modulus_pa: 4.3e8,
    poisson_ratio: 1.0 / 3.0,
    shear_modulus_pa: 4.3e8 / (2.0 * (1.0 + 1.0 / 3.0)),
    residual_stiffness: 1.0,
    cubic_shear_compliance_1_pa3: None,
    initial_strain: [0.0; 2],
    yield_stress_pa: None,
};

/// A sheet of `side` × `side` cells.
fn structure(side: usize, model: FabricModel, residual_stiffness: f64) -> Structure {
    let shape = SheetShape {
        size_m: [1.0, 1.0],
        divisions: [side, side],
        corner_m: DVec3::ZERO,
        across: DVec3::X,
        down: DVec3::Y,
    };
    let fabric = Fabric {
        residual_stiffness,
        ..FABRIC
    };
    let mut structure = sheet::build(&shape, &fabric, model).unwrap();
    for (i, j) in [(0, 0), (side, 0), (0, side), (side, side)] {
        structure.held[shape.node(i, j) as usize] = true;
    }
    let mut state = 1u32;
    for (x, held) in structure.positions_m.iter_mut().zip(&structure.held) {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if !held {
            x.z += 2e-5 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5);
        }
    }
    structure
}

fn main() {
    let mut file = None;
    let mut sides = Vec::new();
    for argument in std::env::args().skip(1) {
        match argument.parse::<usize>() {
            Ok(side) => sides.push(side),
            Err(_) if argument.ends_with(".json") => file = Some(argument),
            Err(_) => {}
        }
    }
    if sides.is_empty() {
        sides = vec![50, 100, 200];
    }
    println!(
        "{:>10} {:>9} {:>12} {:>14} {:>7} {:>6} {:>11} {:>10} {:>9} {:>11}",
        "model",
        "time step",
        "side",
        "initial",
        "stop",
        "iter.",
        "evaluations",
        "seconds",
        "|g|/|g0|",
        "sag"
    );
    let mut rows = Vec::new();
    let settings = [
        ("network", FabricModel::Network, 1.0, Some(1e-2)),
        ("network", FabricModel::Network, 1.0, None),
        ("tension", FabricModel::Membrane, 1e-3, None),
    ];
    for (name, model, residual, time_step_s) in settings {
        for &side in &sides {
            for (label, initial_hessian, refresh_every) in [
                ("multigrid", InitialHessian::Multigrid, 10),
                ("block-Jacobi", InitialHessian::BlockJacobi, 1),
            ] {
                if label == "block-Jacobi" && side > 60 {
                    continue;
                }
                let mut cloth = Cloth::new(structure(side, model, residual));
                let input = StepInput {
                    time_step_s,
                    pressure: Pressure::Uniform(50.0),
                    ..StepInput::default()
                };
                let settings = SolverSettings {
                    tolerance: 1e-4,
                    displacement_floor_m: 0.0,
                    evaluation_limit: 5000,
                    history: 8,
                    refresh_every: Some(refresh_every),
                    initial_hessian,
                };
                let began = Instant::now();
                let outcome = cloth.solve_cloth(&input, &settings);
                let seconds = began.elapsed().as_secs_f64();
                let sag = cloth.positions_m.iter().map(|x| x.z).fold(0.0, f64::max);
                let step = time_step_s.map_or("static".to_owned(), |dt| format!("{dt} s"));
                println!(
                    "{name:>10} {step:>9} {side:>12} {label:>14} {:>7} {:>6} {:>11} {seconds:>10.2} {:>9} {sag:>11.6}",
                    format!("{:?}", outcome.stop),
                    outcome.iterations,
                    outcome.evaluations,
                    "-"
                );
                rows.push(json!({
                    "model": name, "time_step_s": time_step_s, "side": side, "initial_hessian": label,
                    "converged": format!("{:?}", outcome.stop), "iterations": outcome.iterations,
                    "evaluations": outcome.evaluations, "seconds": seconds, "sag_m": sag,
                }));
            }
        }
    }
    if let Some(file) = file {
        std::fs::write(file, serde_json::to_string_pretty(&rows).unwrap()).unwrap();
    }
}
