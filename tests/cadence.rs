//! Several steps of the air between solves of the fabric.

use libtest_mimic::Trial;
use ripstop::plan::{
    AirPlacement, ClothPlacement, MARKER_MOTION_LIMIT, Placement, Plan, Precision, Stage, Storage,
};
use ripstop::simulation::Simulation;

use crate::canopy::small_case;
use crate::engines::{Engine, needs_device, plain};
use crate::resumed::{bits_of_nodes, taken_up};

pub fn trials() -> Vec<Trial> {
    let mut trials = plain(
        "cadence::spans_shorten_where_the_sheet_moves_fast::cpu",
        || shortens(Precision::F32.into(), Engine::CpuF32),
    );
    trials.push(needs_device(
        "cadence::spans_shorten_where_the_sheet_moves_fast::gpu".to_owned(),
        || {
            let placement = Placement {
                air: AirPlacement::Gpu(Storage::F32),
                cloth: ClothPlacement::Device,
                ..Engine::Gpu.plan_placement()
            };
            shortens(placement, Engine::Gpu);
        },
    ));
    trials.extend(plain(
        "cadence::the_plan_chooses_where_the_case_does_not",
        chosen,
    ));
    trials.extend(plain(
        "cadence::engines_take_intervals_from_the_plan",
        obeyed,
    ));
    trials
}

/// A plan whose intervals are changed is obeyed, whatever the case says.
fn obeyed() {
    let case = small_case(&[
        "coupling.structure_every=1",
        "resolution.eddy_viscosity={ model = \"wale\", constant = 0.325 }",
    ]);
    let mut plan = Plan::new(&case.scene, Precision::F32);
    assert_eq!(plan.every(Stage::SolveCloth), Some(1));
    for planned in &mut plan.stages {
        planned.every = match planned.stage {
            Stage::EddyViscosity => 7,
            Stage::SolveCloth => 5,
            _ => continue,
        };
    }
    let mut simulation = Simulation::new(case.scene.clone(), plan, None).unwrap();
    assert_eq!(simulation.cadence().unwrap().planned(), 5);
    let mut evaluated = Vec::new();
    let mut before = None;
    for step in 0..40 {
        simulation.advance().unwrap();
        let now = simulation
            .air()
            .unwrap()
            .engine()
            .eddy_viscosities()
            .unwrap();
        if now != before {
            evaluated.push(step);
        }
        before = now;
    }
    // Air at rest has none in the first step; from then on every seventh.
    evaluated.retain(|step| *step > 0);
    assert_eq!(evaluated, [7, 14, 21, 28, 35]);
}

/// Opening at 10 steps per solve, with a lattice so fast that the sheet would move farther than a quarter of a cell: spans are shortened,
/// the limit holds, and a run resumed within a shortened span goes on with the same bits.
fn shortens(placement: Placement, engine: Engine) {
    // Fabric on a software device takes its time.
    let rings = if engine == Engine::Gpu { 5 } else { 8 };
    let case = small_case(&[
        "coupling.structure_every=10",
        "resolution.lattice_speed=0.14",
        &format!("structure.flat_circular.rings={rings}"),
    ]);
    let start = || {
        let plan = Plan::new(&case.scene, placement.clone());
        Simulation::new(case.scene.clone(), plan, engine.device()).unwrap()
    };
    let mut straight = start();
    let mut stored = None;
    let mut left = 200;
    while left > 0 {
        straight.advance().unwrap();
        let cadence = straight.cadence().unwrap();
        if straight.released() {
            left -= 1;
        }
        if stored.is_none() && cadence.shortened() > 3 && cadence.every() > 2 {
            stored = Some((straight.step_count(), taken_up(&mut straight, start())));
            // There the run ends while all spans are short.
            if engine == Engine::Gpu {
                left = 20;
            }
        }
    }
    let cadence = *straight.cadence().unwrap();
    assert!(
        cadence.shortened() > 3 && (cadence.shortened() < cadence.spans() || engine == Engine::Gpu),
        "{cadence:?}"
    );
    let mean = cadence.mean().unwrap();
    assert!(mean > 3.0 && mean < 10.0, "{mean}");
    let farthest = straight.largest_marker_motion();
    assert!(
        farthest > 0.5 * MARKER_MOTION_LIMIT && farthest <= MARKER_MOTION_LIMIT,
        "{farthest}"
    );
    let (steps, mut resumed) = stored.unwrap();
    assert_eq!(resumed.step_count(), steps);
    while resumed.step_count() < straight.step_count() {
        resumed.advance().unwrap();
    }
    assert_eq!(*resumed.cadence().unwrap(), cadence);
    assert_eq!(resumed.largest_marker_motion(), farthest);
    assert!(bits_of_nodes(&straight) == bits_of_nodes(&resumed));
}

/// Without `coupling.structure_every` the fabric is solved in every step, and nothing is kept for spans of several.
fn chosen() {
    let mut case = small_case(&[]);
    let run = |case: &ripstop::case::Case| {
        let plan = Plan::new(&case.scene, Precision::F32);
        let report = plan.report(&case.scene, &case.coarser, 1);
        let mut simulation = Simulation::new(case.scene.clone(), plan, None).unwrap();
        while simulation.step_count() < 130 {
            simulation.advance().unwrap();
        }
        assert!(simulation.cadence().is_none());
        (simulation.cloth().unwrap().positions_m.clone(), report)
    };
    let (given, asked) = run(&case);
    case.scene.coupling.as_mut().unwrap().structure_every = None;
    let (free, chosen) = run(&case);
    assert!(given == free);
    assert!(
        asked.contains("structure every     1 step (asked for)"),
        "{asked}"
    );
    assert!(
        chosen.contains("structure every     1 step (chosen: "),
        "{chosen}"
    );
}
