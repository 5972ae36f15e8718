//! Fabric alone: a hanging sheet, implicit steps and the static equilibrium, on host and device.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::{Value, json};

use super::rows::{Rows, load, pass_milliseconds, placement, short};
use crate::bench::Stop;
use crate::case::SHIPPED;
use crate::cpu::cloth::InitialHessian;
use crate::gpu::Device;
use crate::plan::{AirPlacement, ClothPlacement, Plan, Precision};
use crate::simulation::Simulation;

/// Evaluations after which the equilibrium is left, reached or not, with small and with full sizes: what one costs is what is asked.
const EQUILIBRIUM_EVALUATIONS: [u32; 2] = [15, 60];

/// Cells along a side, steps, and most evaluations of a step: what one costs is what is asked of the largest.
type Size = (u32, u32, u32);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Problem {
    /// So many, each left after so many evaluations, solved or not.
    Steps {
        steps: u32,
        limit: u32,
    },
    Equilibrium,
}

/// Positions at the end of the row on the host, if it reached its tolerance.
type Reference = Option<Vec<DVec3>>;

pub(super) fn rows(device: &Arc<Device>, rows: &mut Rows) -> Result<(), Stop> {
    rows.title("hanging sheet: implicit steps of 0.1 ms, and the static equilibrium with multigrid; fabric on host (f64) and device");
    let line = format!(
        "{:>12} {:>8} {:>8} {:>13} {:>11} {:>8} {:>11} {:>11} {:>10} {:>15}",
        "problem",
        "nodes",
        "place",
        "first Hessian",
        "evaluations",
        "reached",
        "ms/solve",
        "ms/eval",
        "on device",
        "difference [m]"
    );
    rows.watch.observer.note(&line);
    let full = rows.extent.full;
    let sizes: &[Size] = if full {
        &[(100, 10, 2000), (316, 3, 200), (999, 1, 40)]
    } else {
        &[(6, 1, 100), (12, 1, 100)]
    };
    for equilibrium in [false, true] {
        // Milliseconds per evaluation and node, host and device.
        let mut pace = [if equilibrium { 3e-3 } else { 5e-4 }; 2];
        for &(divisions, steps, limit) in sizes {
            let (problem, solves, most) = if equilibrium {
                let most = EQUILIBRIUM_EVALUATIONS[usize::from(full)];
                (Problem::Equilibrium, 1, most)
            } else {
                // One more goes before those that are timed, and one behind.
                (Problem::Steps { steps, limit }, steps + 2, limit.min(60))
            };
            let nodes = f64::from((divisions + 1) * (divisions + 1));
            let mut reference = None;
            for (k, place) in [ClothPlacement::Host, ClothPlacement::Device]
                .into_iter()
                .enumerate()
            {
                let expected_s =
                    1e-3 * pace[k] * nodes * f64::from(solves * most) + 1e-5 * nodes + 0.5;
                let what = format!("hanging sheet of {nodes} nodes, {problem:?} on {place:?}");
                if !rows.allows(&what, expected_s)? {
                    continue;
                }
                let name = if equilibrium { "equilibrium" } else { "steps" };
                let at = match place {
                    ClothPlacement::Host => "host",
                    ClothPlacement::Device => "device",
                };
                let labels = format!("{name:>12} {nodes:>8} {at:>8}");
                let row = json!({"problem": name, "nodes": nodes, "placement": at});
                let measured = one(device, divisions, problem, place, &mut reference, full);
                let measured = measured.map(|(text, entries, per_evaluation)| {
                    pace[k] = per_evaluation / nodes;
                    Some((text, entries))
                });
                rows.add_measured("cloth", &labels, row, measured)?;
            }
        }
    }
    Ok(())
}

/// Text and entries of a row, and milliseconds per evaluation.
fn one(
    device: &Arc<Device>,
    divisions: u32,
    problem: Problem,
    place: ClothPlacement,
    reference: &mut Reference,
    full: bool,
) -> Result<(String, Value, f64), Stop> {
    let (_, source) = SHIPPED
        .iter()
        .find(|(name, _)| *name == "hanging-sheet")
        .ok_or_else(|| Stop::Refused("no shipped case is called hanging-sheet".to_owned()))?;
    let step_limit = match problem {
        Problem::Steps { limit, .. } => limit,
        Problem::Equilibrium => 100,
    };
    let case = load(
        "hanging-sheet",
        source,
        &[
            format!("structure.sheet.divisions=[{divisions}, {divisions}]"),
            "time.step_s=0.0001".to_owned(),
            "time.end_s=0.01".to_owned(),
            format!("solver.evaluation_limit={step_limit}"),
            "equilibrium.tolerance=1e-2".to_owned(),
            format!(
                "equilibrium.evaluation_limit={}",
                EQUILIBRIUM_EVALUATIONS[usize::from(full)]
            ),
        ],
    )?;
    let air = AirPlacement::Cpu(Precision::F32);
    let plan = Plan::new(&case.scene, placement(air, place, device));
    let hessian = match problem {
        Problem::Steps { .. } => plan.step_hessian,
        Problem::Equilibrium => InitialHessian::Multigrid,
    };
    let hessian = match hessian {
        InitialHessian::BlockJacobi => "block-Jacobi",
        InitialHessian::Multigrid => "multigrid",
    };
    let on_device = place == ClothPlacement::Device;
    let mut simulation = Simulation::new(case.scene.clone(), plan, Some(Arc::clone(device)))?;
    simulation.leave_nothing_to_host();
    if let Problem::Steps { .. } = problem {
        // What is compiled at its first use is not timed.
        simulation.advance()?;
    } else if on_device {
        // There is one equilibrium only, so its passes are timed along with it.
        device.time_passes();
    }
    let before = *simulation.cost();
    let start = Instant::now();
    let (solves, evaluations, reached, norm) = match problem {
        Problem::Steps { steps, .. } => {
            for _ in 0..steps {
                simulation.advance()?;
            }
            let cost = simulation.cost();
            let evaluations = (cost.evaluations - before.evaluations) as f64;
            let reached = cost.unconverged == before.unconverged;
            (f64::from(steps), evaluations, reached, None)
        }
        Problem::Equilibrium => match simulation.equilibrate(&mut |_| true) {
            Some(outcome) => {
                let outcome = outcome?;
                let norm = Some(outcome.relative_norm);
                (
                    1.0,
                    outcome.evaluations as f64,
                    outcome.stop.reached(),
                    norm,
                )
            }
            None => return Err(Stop::Refused("the sheet has no equilibrium".to_owned())),
        },
    };
    let seconds = start.elapsed().as_secs_f64();
    let positions = simulation
        .cloth()
        .map(|cloth| cloth.positions_m.clone())
        .unwrap_or_default();
    let difference = reference.as_ref().filter(|_| reached).map(|host| {
        let distances = host.iter().zip(&positions).map(|(a, b)| a.distance(*b));
        distances.fold(0.0, f64::max)
    });
    let mut passes = None;
    if on_device {
        let mut clocked = evaluations;
        if let Problem::Steps { .. } = problem {
            let before = simulation.cost().evaluations;
            device.time_passes();
            simulation.advance()?;
            clocked = (simulation.cost().evaluations - before) as f64;
        }
        passes = pass_milliseconds(device, clocked)?;
        device.stop_timing_passes();
    }
    let (ms_solve, ms_evaluation) = (1e3 * seconds / solves, 1e3 * seconds / evaluations);
    let text = format!(
        "{hessian:>13} {:>11.1} {:>8} {ms_solve:>11.2} {ms_evaluation:>11.4} {:>10} {:>15}",
        evaluations / solves,
        if reached { "yes" } else { "NO" },
        short(passes.as_ref().map(|(_, sum)| *sum), 4),
        difference.map_or("–".to_owned(), |d| format!("{d:.1e}")),
    );
    let mut row = json!({
        "first_hessian": hessian, "solves": solves, "evaluations_per_solve": evaluations / solves, "reached_tolerance": reached,
        "energy_norm_over_that_of_the_loads": norm, "ms_per_solve": ms_solve, "ms_per_evaluation": ms_evaluation,
        "largest_difference_m": difference,
    });
    if let Some((passes, sum)) = passes {
        row["ms_on_device_per_evaluation"] = sum.into();
        row["ms_per_evaluation_of_passes"] = passes;
    }
    if reached && !on_device {
        *reference = Some(positions);
    }
    Ok((text, row, ms_evaluation))
}
