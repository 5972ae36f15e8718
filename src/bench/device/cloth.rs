//! Fabric alone: a hanging sheet, implicit steps and the static equilibrium, on host and device.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::json;

use super::{Rows, Stop, load, pass_milliseconds, placement};
use crate::case::SHIPPED;
use crate::gpu::Device;
use crate::plan::{AirPlacement, ClothPlacement, Plan, Precision};
use crate::simulation::Simulation;

/// Evaluations after which the equilibrium is left, reached or not, with small and with full sizes: what one costs is what is asked.
const EQUILIBRIUM_EVALUATIONS: [u32; 2] = [15, 60];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Problem {
    /// So many, each left after so many evaluations, solved or not.
    Steps {
        steps: u32,
        limit: u32,
    },
    Equilibrium,
}

/// Cells along a side, steps, and most evaluations of a step: what one costs is what is asked of the largest.
type Size = (u32, u32, u32);

pub(super) fn rows(device: &Arc<Device>, rows: &mut Rows) -> Result<(), Stop> {
    rows.title("hanging sheet: implicit steps of 0.1 ms, and the static equilibrium with multigrid; fabric on host (f64) and device");
    let line = format!(
        "{:>12} {:>8} {:>8} {:>12} {:>12} {:>12} {:>12} {:>12} {:>15}",
        "problem",
        "nodes",
        "place",
        "evaluations",
        "ms/solve",
        "ms/eval",
        "on device",
        "norm reached",
        "difference [m]"
    );
    rows.watch.observer.note(&line);
    let sizes: &[Size] = if rows.extent.full {
        &[(100, 10, 2000), (316, 3, 200), (999, 1, 40)]
    } else {
        &[(6, 1, 100), (12, 1, 100)]
    };
    for equilibrium in [false, true] {
        // Milliseconds per evaluation and node, host and device.
        let mut pace = [2e-3; 2];
        let mut evaluations = 40.0;
        for &(divisions, steps, limit) in sizes {
            let problem = if equilibrium {
                Problem::Equilibrium
            } else {
                Problem::Steps { steps, limit }
            };
            let mut reference = None;
            for (k, place) in [ClothPlacement::Host, ClothPlacement::Device]
                .into_iter()
                .enumerate()
            {
                let nodes = f64::from((divisions + 1) * (divisions + 1));
                let solves = f64::from(if equilibrium { 1 } else { steps });
                let expected_s =
                    1e-3 * pace[k] * nodes * solves * (2.0 * evaluations) + 2e-6 * nodes;
                let what = format!("hanging sheet of {nodes} nodes, {problem:?} on {place:?}");
                if !rows.allows(&what, expected_s) {
                    continue;
                }
                let (per_solve, per_evaluation) =
                    one(device, divisions, problem, place, &mut reference, rows)?;
                pace[k] = per_evaluation / nodes;
                evaluations = f64::max(evaluations, per_solve);
            }
        }
    }
    Ok(())
}

/// Returns evaluations per solve and milliseconds per evaluation.
fn one(
    device: &Arc<Device>,
    divisions: u32,
    problem: Problem,
    place: ClothPlacement,
    reference: &mut Option<Vec<DVec3>>,
    rows: &mut Rows,
) -> Result<(f64, f64), Stop> {
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
            "time.end_s=0.001".to_owned(),
            format!("solver.evaluation_limit={step_limit}"),
            "equilibrium.tolerance=1e-2".to_owned(),
            format!(
                "equilibrium.evaluation_limit={}",
                EQUILIBRIUM_EVALUATIONS[usize::from(rows.extent.full)]
            ),
        ],
    )?;
    let air = AirPlacement::Cpu(Precision::F32);
    let plan = Plan::new(&case.scene, placement(air, place, device));
    let mut simulation = Simulation::new(case.scene.clone(), plan, Some(Arc::clone(device)))?;
    if matches!(problem, Problem::Steps { .. }) {
        // What is compiled at its first use is not timed.
        simulation.advance()?;
    }
    let on_device = place == ClothPlacement::Device && device.time_passes();
    let before = simulation.cost().evaluations;
    let mut norm = None;
    let start = Instant::now();
    let (solves, evaluations, reached) = match problem {
        Problem::Steps { steps, .. } => {
            for _ in 0..steps {
                simulation.advance()?;
            }
            let cost = simulation.cost();
            (
                f64::from(steps),
                (cost.evaluations - before) as f64,
                cost.unconverged == 0,
            )
        }
        Problem::Equilibrium => match simulation.equilibrate(&mut |_| true) {
            Some(outcome) => {
                let outcome = outcome?;
                norm = Some(outcome.relative_norm);
                (1.0, outcome.evaluations as f64, outcome.stop.reached())
            }
            None => return Err(Stop::Refused("the sheet has no equilibrium".to_owned())),
        },
    };
    let seconds = start.elapsed().as_secs_f64();
    let passes = if on_device {
        pass_milliseconds(device, evaluations)?
    } else {
        None
    };
    device.stop_timing_passes();
    let positions = simulation
        .cloth()
        .map(|cloth| cloth.positions_m.clone())
        .unwrap_or_default();
    let difference = reference.as_ref().map_or(0.0, |host| {
        host.iter()
            .zip(&positions)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f64::max)
    });
    let name = match problem {
        Problem::Steps { .. } => "steps",
        Problem::Equilibrium => "equilibrium",
    };
    let place = match place {
        ClothPlacement::Host => "host",
        ClothPlacement::Device => "device",
    };
    let (ms_solve, ms_evaluation) = (1e3 * seconds / solves, 1e3 * seconds / evaluations);
    let nodes = positions.len();
    let text = format!(
        "{name:>12} {nodes:>8} {place:>8} {:>12.1} {ms_solve:>12.2} {ms_evaluation:>12.4} {:>12} {:>12} {difference:>15.1e}",
        evaluations / solves,
        passes
            .as_ref()
            .map_or("–".to_owned(), |(_, sum)| format!("{sum:.4}")),
        norm.map_or("–".to_owned(), |norm| format!("{norm:.1e}")),
    );
    let mut row = json!({
        "problem": name, "nodes": nodes, "placement": place, "solves": solves, "evaluations_per_solve": evaluations / solves,
        "reached_tolerance": reached, "energy_norm_over_that_of_the_loads": norm, "ms_per_solve": ms_solve, "ms_per_evaluation": ms_evaluation, "largest_difference_m": difference,
    });
    if let Some((passes, sum)) = passes {
        row["ms_on_device_per_evaluation"] = sum.into();
        row["ms_per_evaluation_of_passes"] = passes;
    }
    rows.add("cloth", &text, row)?;
    reference.get_or_insert(positions);
    Ok((evaluations / solves, ms_evaluation))
}
