//! What is asked of a device in a step.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::gpu::{AdapterChoice, Device, DeviceWork, Padding, Tuning};
use ripstop::plan::{ClothPlacement, Plan, Stage};
use ripstop::simulation::Simulation;

use crate::collide_ahead::SMALL_TUNNEL;
use crate::command_line::{program, root};
use crate::engines::{air_on_a_device, needs_device};

pub fn trials() -> Vec<Trial> {
    vec![
        needs_device(
            "device_work::a_step_with_fabric_on_the_host".to_owned(),
            || step(ClothPlacement::Host, Reactions::Plain),
        ),
        needs_device(
            "device_work::a_step_with_fabric_on_the_device".to_owned(),
            || step(ClothPlacement::Device, Reactions::Plain),
        ),
        needs_device(
            "device_work::a_step_with_reactions_of_the_host".to_owned(),
            || step(ClothPlacement::Device, Reactions::OfMeans),
        ),
        needs_device(
            "device_work::a_step_with_small_fabric_on_the_device".to_owned(),
            step_with_small_fabric,
        ),
        needs_device(
            "device_work::a_step_with_cut_links".to_owned(),
            step_with_links,
        ),
        needs_device(
            "device_work::a_step_with_walls_that_stand".to_owned(),
            step_with_standing_walls,
        ),
        needs_device(
            "device_work::solves_left_to_the_host".to_owned(),
            left_to_the_host,
        ),
        needs_device("device_work::profile".to_owned(), profile),
    ]
}

/// A device of its own: others would be counted with it.
pub fn own_device(tuning: Tuning) -> Arc<Device> {
    Device::open_tuned(&AdapterChoice::Any, tuning).unwrap()
}

const CANOPY: &str = include_str!("../benches/uniform-canopy.toml");

/// Steps in which the device learns how long its work takes.
const TIMED: u64 = 30;

/// Fewer than the steps after which the sums of the momentum box are fetched.
const STEPS: u64 = 40;

/// Evaluations of a solve in these steps, on average; 20 were found, and rounding of the adapter changes some.
const MOST_EVALUATIONS: u64 = 30;

/// So many submits in [`STEPS`], and those of steps whose stages are timed, one in 31: each is submitted by itself.
fn together(submits: u64, wanted: u64) -> bool {
    (wanted..=wanted + 5 * STEPS.div_ceil(31)).contains(&submits)
}

/// Fabric on the device is solved in batches.
const BATCHES: Tuning = Tuning {
    workgroup: 256,
    padding: Padding::Planes,
    bounds_checks: true,
    small_cloth_nodes: Some(0),
    // Whatever a machine is busy with: the tests count.
    longest_left: Duration::from_secs(3600),
    goes_ahead: true,
};

/// A canopy that was just released, its stages, and its device, whose fabric is solved in batches.
fn released(
    case: &str,
    overrides: &[&str],
    cloth: ClothPlacement,
) -> (Simulation, Vec<Stage>, Arc<Device>) {
    released_on(own_device(BATCHES), case, overrides, (cloth, 1))
}

/// The same on another device, where the fabric feels the air's mean over so many steps.
fn released_on(
    device: Arc<Device>,
    case: &str,
    overrides: &[&str],
    (cloth, averaging_steps): (ClothPlacement, u32),
) -> (Simulation, Vec<Stage>, Arc<Device>) {
    let usual = [
        "air.wind_tunnel.start_time_s=0.002",
        "structure.flat_circular.rings=8",
        "time.end_s=0.1",
    ];
    let choices = Choices {
        variant: None,
        overrides: usual
            .iter()
            .chain(overrides)
            .map(|pair| (*pair).to_owned())
            .collect(),
    };
    let mut case = case::parse("canopy", case, Path::new("."), &choices).unwrap();
    let coupling = case.scene.coupling.as_mut().unwrap();
    coupling.averaging_steps = averaging_steps;
    let plan = Plan::new(&case.scene, air_on_a_device(cloth));
    let stages: Vec<_> = plan.stages.iter().map(|planned| planned.stage).collect();
    let start_steps = plan.start_steps;
    let mut simulation =
        Simulation::new(case.scene.clone(), plan, Some(Arc::clone(&device))).unwrap();
    for _ in 0..start_steps {
        simulation.advance().unwrap();
    }
    (simulation, stages, device)
}

const LINKS: &str = include_str!("../cases/flat-circular-tunnel.toml");

/// Fabric that one workgroup solves. Before the solve two dispatches form the reactions of the air and five block-Jacobi. Then come the solve, the forces on the air and how they are
/// spread, once more where it did not end. One submission has all that, and one map brings what it did.
fn step_with_small_fabric() {
    let small = Tuning {
        small_cloth_nodes: Some(usize::MAX),
        ..BATCHES
    };
    let cells = ["resolution.cells_per_diameter=10.0"];
    let (mut simulation, stages, _) = released_on(
        own_device(small),
        CANOPY,
        &cells,
        (ClothPlacement::Device, 1),
    );
    assert!(!stages.contains(&Stage::FetchAirVelocities));
    // The first ones are timed, each by itself.
    for _ in 0..TIMED {
        simulation.advance().unwrap();
    }
    let asked = |simulation: &Simulation| {
        let of = |stage: &Stage| simulation.cost().of(*stage).device;
        let mut all = DeviceWork::default();
        stages.iter().for_each(|stage| all += of(stage));
        let mut solve = DeviceWork::default();
        [Stage::SolveCloth, Stage::Spread, Stage::FetchNodes]
            .iter()
            .for_each(|stage| solve += of(stage));
        [all, solve]
    };
    let before = asked(&simulation);
    for _ in 0..STEPS {
        simulation.advance().unwrap();
    }
    let now = asked(&simulation);
    let [all, solve] = [0, 1].map(|which| now[which].since(&before[which]));
    // Software adapters go through eight trials at once, and MOST_EVALUATIONS is a mean.
    assert!((STEPS..6 * STEPS).contains(&solve.maps), "{solve:?}");
    assert_eq!(solve.dispatches, 7 * STEPS + 3 * solve.maps, "{solve:?}");
    assert_eq!(solve.writes, 2 * STEPS, "{solve:?}");
    // One more where the sums of the momentum box are fetched.
    assert!((solve.maps..=solve.maps + 1).contains(&all.maps), "{all:?}");
    // The air by itself first, while the host works on the markers.
    assert!(together(all.submits, STEPS + solve.maps), "{all:?}");
}

/// What a device does not solve in a step, the host solves from the same start: with three evaluations allowed neither ends, and the run is that of fabric on
/// the host, bit by bit.
fn left_to_the_host() {
    let few = [
        "resolution.cells_per_diameter=10.0",
        "solver.evaluation_limit=3",
    ];
    for every in [1, 4] {
        let every = format!("coupling.structure_every={every}");
        let overrides = [few[0], few[1], &every];
        let [on_device, on_host] =
            [ClothPlacement::Device, ClothPlacement::Host].map(|placement| {
                let (mut simulation, ..) = released(CANOPY, &overrides, placement);
                let before = simulation.cost().left_to_host;
                for _ in 0..6 {
                    simulation.advance().unwrap();
                }
                let positions = simulation.cloth().unwrap().positions_m.clone();
                (simulation.cost().left_to_host - before, positions)
            });
        assert!(on_device.0 > 0 && on_host.0 == 0, "{every}");
        assert!(on_device.1 == on_host.1, "{every}");
    }
}

/// With fabric on the host that cuts links a step of the finest cells asks for two submits and one map; a step of coarser cells around them for one submit more: what
/// nobody waits for goes along with what is submitted next.
fn step_with_links() {
    let boxes = ["resolution.cells_per_diameter=12.0"];
    for (around, overrides) in [("nothing", &SMALL_TUNNEL[..]), ("structure", &boxes)] {
        let (mut simulation, stages, _) = released(LINKS, overrides, ClothPlacement::Host);
        let asked = |simulation: &Simulation| {
            let of = |stage: &Stage| simulation.cost().of(*stage).device;
            let mut sum = DeviceWork::default();
            stages.iter().for_each(|stage| sum += of(stage));
            sum
        };
        assert_eq!(
            stages.contains(&Stage::CoarserLevels),
            around == "structure"
        );
        // The first ones are timed, each by itself.
        for _ in 0..TIMED {
            simulation.advance().unwrap();
        }
        // Lattices around boxes have one more in two steps. With cells that go ahead the two are what is read along the links, with all before it, and the next step of those cells.
        let submits = match around {
            "structure" => 2 * STEPS + STEPS / 2,
            _ => 2 * STEPS,
        };
        for next_reading in [0, u64::MAX] {
            simulation.set_next_reading(next_reading);
            let before = asked(&simulation);
            for _ in 0..STEPS {
                simulation.advance().unwrap();
            }
            let work = asked(&simulation).since(&before);
            assert!(together(work.submits, submits), "{around}: {work:?}");
            // One more where the sums of the momentum box are fetched.
            assert!(
                (STEPS..=STEPS + 1).contains(&work.maps),
                "{around}: {work:?}"
            );
        }
    }
}

const SPHERE: &str = include_str!("../cases/sphere.toml");

/// Where no surface moves, places stay on the device, those of even and of odd steps: of cut links, numbers alone go there. The host takes part for a model of boundary layers, which
/// asks for more cells in every fourth step.
fn step_with_standing_walls() {
    let device = own_device(Tuning::default());
    let overrides = [
        "coupling.scheme=links",
        "bodies.sphere.friction=model",
        "resolution.operator=stabilised_regularised",
    ];
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: overrides.map(str::to_owned).to_vec(),
    };
    let case = case::parse("sphere", SPHERE, Path::new("."), &choices).unwrap();
    let plan = Plan::new(&case.scene, air_on_a_device(ClothPlacement::Host));
    let start_steps = plan.start_steps;
    let mut simulation = Simulation::new(case.scene.clone(), plan, Some(device)).unwrap();
    assert!(start_steps > 8);
    for _ in 0..start_steps {
        simulation.advance().unwrap();
    }
    let asked = |simulation: &Simulation| {
        [Stage::ReadLinks, Stage::FetchLinks, Stage::Bounce]
            .map(|stage| simulation.cost().of(stage).device)
    };
    let before = asked(&simulation);
    for _ in 0..STEPS {
        simulation.advance().unwrap();
    }
    let now = asked(&simulation);
    let [read, fetch, bounce] = [0, 1, 2].map(|stage| now[stage].since(&before[stage]));
    assert_eq!(read.written_bytes, 0, "{read:?}");
    // Links, and cells about mirror images.
    assert!(fetch.maps >= 2 * STEPS, "{fetch:?}");
    let links = simulation.coupled().unwrap().point_count() as u64;
    // Both sides of every link, and a number for every cell beside one; a model changes three populations and more of every cell near the wall, too.
    let of_links = 8 * links * STEPS;
    assert!(
        (of_links..6 * of_links).contains(&bounce.written_bytes),
        "{bounce:?}"
    );
}

/// What the fabric feels of the air: the air of the step, or a mean over two, which the host forms.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reactions {
    Plain,
    OfMeans,
}

/// What a step asks for today. Whoever keeps more of the step on the device lowers these numbers.
fn step(cloth: ClothPlacement, reactions: Reactions) {
    let averaging = match reactions {
        Reactions::Plain => 1,
        Reactions::OfMeans => 2,
    };
    let cells = ["resolution.cells_per_diameter=10.0"];
    let (mut simulation, stages, device) =
        released_on(own_device(BATCHES), CANOPY, &cells, (cloth, averaging));
    let asked = |simulation: &Simulation| {
        let mut sum = DeviceWork::default();
        for &stage in &stages {
            sum += simulation.cost().of(stage).device;
        }
        (sum, simulation.cost().solves, simulation.cost().evaluations)
    };
    let parts =
        |simulation: &Simulation| simulation.cost().of(Stage::CollideStream).device.dispatches;
    let parts_before = parts(&simulation);
    let before = asked(&simulation);
    let all_before = device.work();
    for _ in 0..STEPS {
        simulation.advance().unwrap();
    }
    let after = asked(&simulation);
    let (work, solves, evaluations) = (
        after.0.since(&before.0),
        after.1 - before.1,
        after.2 - before.2,
    );
    assert_eq!(solves, STEPS);
    // Nothing is asked for outside the stages but one look at all cells, at most, and two around the markers: each a dispatch and a read,
    // and those around the markers as much again for the slip.
    let besides = device.work().since(&all_before).since(&work);
    assert!(besides.submits <= 10 && besides.maps <= 5, "{besides:?}");
    // A slow device gets its air in several parts, each a dispatch, a submit and a write; in one part it takes five dispatches.
    let more = parts(&simulation) - parts_before - 5 * STEPS;
    let submits = work.submits - more;
    match (cloth, reactions) {
        // The outflow, spread and collide_stream together, then the markers and what is interpolated to them; one map of the air's velocities. The
        // inlet and the sides of y and of z take a dispatch each.
        (ClothPlacement::Host, _) => {
            assert!(together(submits, 2 * STEPS), "{work:?}");
            let counts = (work.maps, work.dispatches - more, work.writes - more);
            assert_eq!(counts, (STEPS, 10 * STEPS, 5 * STEPS), "{work:?}");
        }
        // Besides: one submit and one map per batch of trials, which most solves need one of: 51 were found in 40 steps, on Mesa's software adapter
        // and on an NVIDIA H100. A solve at the edge of a batch needs one more or less by round-off.
        // Where the device forms reactions and forces itself, these are all that there is of either: forces are formed and spread after every batch.
        (ClothPlacement::Device, _) => {
            let of_host = if reactions == Reactions::Plain {
                0
            } else {
                STEPS
            };
            let batches = work.maps - of_host;
            assert!(batches >= STEPS && 2 * batches <= 3 * STEPS, "{work:?}");
            // The air by itself first, while the host works on the markers.
            assert!(together(submits, STEPS + of_host + batches), "{work:?}");
            // Loads are written again where they have changed.
            let writes = work.writes - more - of_host;
            assert!((13 * STEPS..=14 * STEPS).contains(&writes), "{work:?}");
            // Start and trials of four kinds of elements; trials beyond the last that is needed have no workgroups.
            let others = match reactions {
                Reactions::Plain => 24 * STEPS + 3 * batches,
                Reactions::OfMeans => 23 * STEPS + batches,
            };
            let in_trials = work.dispatches - more - others;
            assert_eq!(in_trials % 9, 0, "{work:?}");
            let (trials, needed) = (in_trials / 9, evaluations - STEPS);
            assert!(
                (needed..3 * needed).contains(&trials),
                "{trials} trials, {needed} needed"
            );
            assert!(evaluations <= MOST_EVALUATIONS * STEPS, "{evaluations}");
        }
    }
    // Velocities of the markers, 16 bytes each, come back in every step.
    let markers = simulation.plan().sizes.markers;
    assert!(work.mapped_bytes >= 16 * markers * STEPS, "{work:?}");
    assert!(work.waited_ns > 0);
}

/// What `--profile` prints and `summary.json` keeps.
fn profile() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = Command::new(program())
        .args(["run", "cases/flat-circular-tunnel.toml", "--engine", "gpu"])
        .args(["--profile", "--variant", "quick", "--set"])
        .args(["resolution.cells_per_diameter=8.0", "--set"])
        .args(["air.wind_tunnel.start_time_s=0.001", "--set"])
        .args(["time.end_s=0.002", "--out"])
        .arg(&out)
        .current_dir(root())
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    for part in ["asked of the device, per step", "latencies of the device"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let asked = &summary["device_use"];
    let steps = asked["steps"].as_f64().unwrap();
    assert!(steps >= 3.0 && steps < summary["steps"].as_f64().unwrap());
    for count in ["dispatches", "submits", "writes", "maps", "mapped_bytes"] {
        let stages = asked["stages"].as_array().unwrap();
        let sum: f64 = stages.iter().map(|s| s[count].as_f64().unwrap()).sum();
        let per_step = asked["per_step"][count].as_f64().unwrap();
        assert!((sum / steps - per_step).abs() < 1e-9 * sum, "{count}");
    }
    assert_eq!(asked["per_step"]["maps"].as_f64().unwrap(), 1.0);
    assert!(asked["besides_the_stages"]["submits"].as_f64().unwrap() > steps);
    assert!(asked["latencies"].as_array().unwrap().len() >= 8);
    if let Some(passes) = asked["passes"].as_array() {
        assert!(text.contains("by the device's own clock"), "{text}");
        let air = passes.iter().find(|p| p["pass"] == "collide_stream");
        let timed = air.unwrap()["passes"].as_f64().unwrap();
        assert!(timed >= summary["steps"].as_f64().unwrap());
    }
}
