//! `summary.json` of a finished run.

use crate::case::Case;
use crate::case::scene::Air;
use crate::ledger::State;
use crate::measure::shared::FORCE_IMBALANCE;
use crate::measure::{
    FORCE_IMBALANCE_LIMIT, Record, account, averaging_window_s, comparison, results, unsettled_fall,
};
use crate::output::{
    CaseInfo, LatticeSize, MillisecondsPerStep, Processor, SCHEMA_VERSION, StageTime, StopInfo,
    StructureEvery, Summary, Supports, mark,
};
use crate::plan::{ClothPlacement, MARKER_MOTION_LIMIT, Placement, Stage};
use crate::simulation::Coupled;
use crate::simulation::Simulation;
use crate::statics::Statics;
use crate::validity;

/// Names who computes in that precision: the device, or the host.
fn processor(placement: &Placement, on_device: bool, precision: &str) -> Processor {
    match &placement.device {
        Some(device) if on_device => Processor {
            engine: "gpu".to_owned(),
            device: device.clone(),
            precision: precision.to_owned(),
        },
        _ => Processor {
            engine: "cpu".to_owned(),
            device: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            precision: precision.to_owned(),
        },
    }
}

/// Everything that a run leaves to be known about itself.
pub(super) fn summarise(
    case: &Case,
    (simulation, statics): (&Simulation, &Statics),
    record: &Record,
    (state, reason): (State, String),
    mut notes: Vec<String>,
    wall_s: f64,
    resumed_at_step: Option<u64>,
) -> Summary {
    let scene = simulation.scene();
    let plan = simulation.plan();
    let steps = simulation.step_count();
    let cost = simulation.cost();
    let per_step = |duration: std::time::Duration, present: bool| {
        (present && cost.timed_steps > 0)
            .then(|| 1e3 * duration.as_secs_f64() / cost.timed_steps as f64)
    };
    let cells = scene.air.as_ref().map(|air| air.cells);
    let lattices = scene.air.as_ref().map_or_else(Vec::new, lattices);
    let mut details = Vec::new();
    notes.extend(
        plan.warnings(scene)
            .into_iter()
            .map(|warning| format!("warning: {warning}")),
    );
    let fluid_seconds = cost.fluid.as_secs_f64();
    if let Some(opening) = simulation.opening() {
        details.push(format!(
            "canopy opened by loading pressure from D_p/D_0 {:.3} to {:.3} before the wind",
            opening.folded_ratio, opening.opened_ratio
        ));
    }
    if cost.solves > 0 {
        details.push(format!(
            "fabric: {:.1} iterations and {:.1} evaluations per solve",
            cost.iterations as f64 / cost.solves as f64,
            cost.evaluations as f64 / cost.solves as f64
        ));
    }
    if cost.left_to_host > 0 {
        details.push(format!(
            "fabric: {} solves that the device did not end were done on the host",
            cost.left_to_host
        ));
    }
    if cost.own_steps > 0 {
        details.push(format!(
            "device: made {} of {steps} steps by itself",
            cost.own_steps
        ));
    }
    if let (Some(adaptive), Some(time)) = (simulation.adaptive(), scene.time) {
        details.push(format!(
            "adaptive steps: {} parts in {steps} steps of {:e} s, the shortest {:.3e} s; {} were done again in halves, {} of them since the solver \
             did not reach its tolerance",
            adaptive.parts(),
            time.step_s,
            time.step_s / (1_u64 << adaptive.most_halvings()) as f64,
            adaptive.refused(),
            adaptive.failed()
        ));
        if adaptive.coarse() > 0 {
            notes.push(format!(
                "{} parts err more than time.adaptive.tolerance_m allows: lower time.adaptive.smallest_step_s",
                adaptive.coarse()
            ));
        }
    }
    if simulation.largest_marker_motion() > MARKER_MOTION_LIMIT {
        let what = match simulation.coupled() {
            Some(Coupled::Links(_)) => "the sheet",
            _ => "a marker",
        };
        notes.push(format!(
            "{what} moved {:.3} cells between two solves of the fabric; the coupling is meant for less than {MARKER_MOTION_LIMIT}: \
             lower resolution.lattice_speed",
            simulation.largest_marker_motion()
        ));
    }
    let structure_every = simulation.cadence().map(|cadence| StructureEvery {
        planned: cadence.planned(),
        mean: cadence.mean(),
        solves: cadence.spans(),
        shortened: cadence.shortened(),
    });
    if let Some(every) = structure_every.filter(|every| every.shortened > 0) {
        details.push(format!(
            "{} of {} solves of the fabric span fewer than {} steps of the air ({:.2} in the mean), as a marker would have moved more than \
             {MARKER_MOTION_LIMIT} cells",
            every.shortened,
            every.solves,
            every.planned,
            every.mean.unwrap_or(f64::NAN)
        ));
    }
    if let Some(quality) = scene.body.as_ref().and_then(|b| b.quality) {
        details.push(format!(
            "triangle quality: smallest {:.3}, mean {:.3} (1 = equilateral)",
            quality.smallest_shape, quality.mean_shape
        ));
    }
    notes.extend(unsettled_fall(scene, record));
    let placement = &plan.placement;
    let fabric = scene.body.is_some().then(|| match placement.cloth {
        ClothPlacement::Host => processor(placement, false, "f64"),
        ClothPlacement::Device => processor(placement, true, "f32"),
    });
    let air = scene.air.is_some().then(|| {
        processor(
            placement,
            placement.air_on_device(),
            placement.precision_name(),
        )
    });
    let main = air
        .or_else(|| fabric.clone())
        .unwrap_or_else(|| processor(placement, false, placement.precision_name()));
    let mut results = results(simulation, statics, record);
    let structure = simulation.structure_frame().structure;
    // In a fall the time step grows as the air gets slower: the speed on the lattice stays what the case asks for.
    let judged = match &scene.descent {
        Some(_) => &case.scene,
        None => scene,
    };
    let validity = validity::of_run(judged, plan, structure.as_ref(), record);
    mark(&mut results, &validity);
    if simulation.solver_account().out_of_balance() {
        for (name, quantity) in results.iter_mut() {
            if Supports::Everything.covers(name) {
                quantity.mark_unresolved("solves of the fabric missed their tolerance");
            }
        }
    }
    if let Some(imbalance) = results.value(&FORCE_IMBALANCE)
        && imbalance > FORCE_IMBALANCE_LIMIT
    {
        notes.push(format!(
            "the three force routes differ by {:.1} %: average longer{} or lower solver.tolerance",
            100.0 * imbalance,
            if structure_every.is_some() {
                ", use coupling.structure_every = 1,"
            } else {
                ""
            }
        ));
    }
    Summary {
        schema_version: SCHEMA_VERSION,
        ripstop_version: env!("CARGO_PKG_VERSION").to_owned(),
        case: CaseInfo {
            title: scene.title.clone(),
            file: case.name.clone(),
            variant: case.variant.clone(),
            hash: case.hash.clone(),
        },
        engine: main.engine,
        device: main.device,
        precision: main.precision,
        fabric,
        threads: rayon::current_num_threads(),
        cells,
        lattices,
        markers: simulation.coupled().map_or(0, Coupled::point_count),
        nodes: plan.sizes.nodes as usize,
        triangles: plan.sizes.triangles as usize,
        steps,
        resumed_at_step,
        simulated_s: simulation.time_s().max(0.0),
        wall_s,
        million_lattice_updates_per_s: (cells.is_some() && fluid_seconds > 0.0)
            .then(|| cost.timed_cells as f64 / fluid_seconds / 1e6),
        milliseconds_per_step: MillisecondsPerStep {
            fluid: per_step(cost.fluid, scene.air.is_some()),
            coupling: per_step(cost.coupling, scene.coupling.is_some()),
            cloth: per_step(cost.cloth, scene.body.is_some()),
            contact: per_step(
                cost.contact,
                simulation
                    .cloth()
                    .is_some_and(|c| c.contact_state().is_some()),
            ),
            measure: per_step(cost.measure, true),
        },
        structure_every,
        stages: plan
            .stages
            .iter()
            .filter(|planned| cost.timed_steps > 0 && planned.stage != Stage::Output)
            .map(|planned| StageTime {
                stage: planned.stage.name().to_owned(),
                calls: cost.of(planned.stage).calls,
                seconds: cost.of(planned.stage).time.as_secs_f64(),
            })
            .collect(),
        device_use: super::device_use::of(simulation),
        stop: StopInfo {
            state: state.name().to_owned(),
            reason,
            when_s: simulation.time_s(),
        },
        skipped: plan
            .skips
            .iter()
            .map(|s| format!("{}: {}", s.what, s.why))
            .collect(),
        notes,
        details,
        account: account(simulation, statics, &results),
        expected_errors: validity::expected_errors(scene),
        validity,
        comparison: comparison(scene, &results),
        averaging_window_s: averaging_window_s(scene, record),
        results,
    }
}

/// Lattices of the air, in metres.
fn lattices(air: &Air) -> Vec<LatticeSize> {
    let cell_m = air.units.cell_size_m;
    let levels = air.levels().into_iter();
    levels
        .map(|level| LatticeSize {
            cells: level.cells,
            cell_size_m: cell_m * air.finest_cells_across(&level),
            corner_m: level.corner.map(|n| n as f64 * cell_m),
        })
        .collect()
}
