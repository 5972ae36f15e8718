//! Air and fabric that meet at markers: what one feels the other gets, also where one device has both and forms reactions and forces itself.

use std::path::Path;
use std::sync::Arc;

use libtest_mimic::Trial;
use ripstop::case::coupling::Scheme;
use ripstop::case::{self, Choices, Scene};
use ripstop::checkpoint;
use ripstop::gpu::{AdapterChoice, Device, Tuning};
use ripstop::plan::{ClothPlacement, Placement, Plan, Stage};
use ripstop::simulation::Simulation;

use crate::engines::{Body, Engine, air_on_a_device, needs_device, on_every_engine, plain};
use crate::tolerances;

const CANOPY: &str = include_str!("../benches/uniform-canopy.toml");
const WING: &str = include_str!("../cases/ram-air-parachute.toml");
const PERMEABLE: &str = include_str!("../cases/slotted-drop.toml");

const STEPS: u64 = 60;

/// Fabric on the host, in the air of an engine.
#[derive(Clone, Copy)]
struct OnHost;

impl Body for OnHost {
    fn run(self, engine: Engine) {
        what_one_feels_the_other_gets(engine.plan_placement(), engine.device());
    }
}

pub fn trials() -> Vec<Trial> {
    let mut trials = on_every_engine("meeting::with_fabric_on_the_host", OnHost);
    for (how, nodes) in [("batches", 0), ("one_workgroup", usize::MAX)] {
        trials.push(needs_device(
            format!("meeting::solved_in_{how}_on_a_device"),
            move || on_one_device(nodes),
        ));
    }
    trials.push(needs_device(
        "meeting::resumed_on_a_device".to_owned(),
        resumed,
    ));
    trials.extend(plain("meeting::plans", plans));
    trials
}

fn parsed(case: &str, overrides: &[&str]) -> case::Case {
    variant(case, None, overrides)
}

fn variant(case: &str, name: Option<&str>, overrides: &[&str]) -> case::Case {
    let choices = Choices {
        variant: name.map(str::to_owned),
        overrides: overrides.iter().map(|&pair| pair.to_owned()).collect(),
    };
    case::parse("canopy", case, Path::new("."), &choices).unwrap()
}

fn on_one_device(small_cloth_nodes: usize) {
    let tuning = Tuning {
        small_cloth_nodes: Some(small_cloth_nodes),
        ..Tuning::default()
    };
    let device = Device::open_tuned(&AdapterChoice::Any, tuning).unwrap();
    what_one_feels_the_other_gets(air_on_a_device(ClothPlacement::Device), Some(device));
}

/// Air and fabric change momentum with each other, and nothing is lost between them, from the first step after the release on: what the markers gave the air is what supports and the
/// fabric's own momentum tell, and what is found in the air. The routes share no data. The wind rises at once, so that the air is owed much of what held the fabric.
fn what_one_feels_the_other_gets(placement: Placement, device: Option<Arc<Device>>) {
    let case = parsed(
        CANOPY,
        &[
            "resolution.cells_per_diameter=10.0",
            "air.wind_tunnel.start_time_s=0.002",
            "structure.flat_circular.rings=8",
            "solver.tolerance=1e-4",
            "time.end_s=0.1",
        ],
    );
    let on_one_device = placement.cloth == ClothPlacement::Device;
    let plan = Plan::new(&case.scene, placement);
    assert_eq!(plan.reacts_on_device(), on_one_device);
    let mut simulation = Simulation::new(case.scene, plan, device).unwrap();
    while !simulation.released() {
        simulation.advance().unwrap();
    }
    for step in 1..=STEPS {
        simulation.advance().unwrap();
        if step != 1 && step != STEPS {
            continue;
        }
        let sample = simulation.impulse_sample().unwrap().unwrap();
        let markers = sample.markers;
        assert!(markers.x > 0.1, "{markers}");
        for (route, impulse) in [
            ("supports", sample.supports),
            ("momentum box", sample.momentum_box),
        ] {
            let off = (impulse.unwrap() - markers).length() / markers.length();
            assert!(off < tolerances::MEETING, "step {step}, {route}: {off:e}");
        }
    }
}

/// A run that goes on from what was saved has the bits of one that was not broken off, where the device forms reactions itself; also where it leaves some solves to the host.
fn resumed() {
    let device = Device::open(&AdapterChoice::Any).unwrap();
    for limit in [10_000, 12] {
        let limit = format!("solver.evaluation_limit={limit}");
        let case = parsed(
            CANOPY,
            &[
                "resolution.cells_per_diameter=10.0",
                "air.wind_tunnel.start_time_s=0.002",
                "structure.flat_circular.rings=8",
                "time.end_s=0.1",
                &limit,
            ],
        );
        let new = || {
            let plan = Plan::new(&case.scene, air_on_a_device(ClothPlacement::Device));
            Simulation::new(case.scene.clone(), plan, Some(Arc::clone(&device))).unwrap()
        };
        let mut unbroken = new();
        while !unbroken.released() {
            unbroken.advance().unwrap();
        }
        for _ in 0..9 {
            unbroken.advance().unwrap();
        }
        let folder = tempfile::tempdir().unwrap();
        checkpoint::write(folder.path(), "test", |out| unbroken.save(out)).unwrap();
        let stored = checkpoint::open(folder.path(), "test").unwrap().reader;
        let mut resumed = new();
        resumed.restore(&stored).unwrap();
        let bits = |simulation: &mut Simulation| -> Vec<u64> {
            for _ in 0..7 {
                simulation.advance().unwrap();
            }
            let impulses = simulation.impulse_sample().unwrap().unwrap();
            let cloth = simulation.cloth().unwrap();
            let places = cloth.positions_m.iter().chain(&cloth.velocities_m_s);
            places
                .chain([&impulses.markers, &impulses.supports.unwrap()])
                .flat_map(|place| place.to_array().map(f64::to_bits))
                .collect()
        };
        assert!(bits(&mut unbroken) == bits(&mut resumed), "{limit}");
        let left = unbroken.cost().left_to_host;
        assert_eq!(
            left > 0,
            limit.ends_with("=12"),
            "{left} solves left to the host"
        );
    }
}

/// What is fetched before the fabric is solved, and what is sent after, where the host has a part in what happens at the markers.
fn plans() {
    let reacts = |case: &str, overrides: &[&str], cloth| {
        let scene = parsed(case, overrides).scene;
        let plan = Plan::new(&scene, air_on_a_device(cloth));
        let fetched = plan.every(Stage::FetchAirVelocities).is_some();
        let sent = plan.every(Stage::SendMarkerForces).is_some();
        assert_eq!(fetched, sent);
        assert_eq!(plan.reacts_on_device(), !fetched);
        let order: Vec<_> = plan.stages.iter().map(|planned| planned.stage).collect();
        let at = |stage| order.iter().position(|other| *other == stage).unwrap();
        assert!(at(Stage::SolveCloth) < at(Stage::Spread));
        if cloth == ClothPlacement::Device {
            assert_eq!(!fetched, at(Stage::Spread) < at(Stage::FetchNodes));
        }
        !fetched
    };
    let kernel = [
        "coupling.scheme=\"kernel\"",
        "coupling.narrow_openings=absent",
    ];
    assert!(reacts(CANOPY, &[], ClothPlacement::Device));
    assert!(!reacts(CANOPY, &[], ClothPlacement::Host));
    let spans = ["coupling.structure_every=2"];
    assert!(!reacts(CANOPY, &spans, ClothPlacement::Device));
    // Air passes this fabric.
    assert!(!reacts(PERMEABLE, &kernel, ClothPlacement::Device));
    let ball = [
        "bodies.ball.position_m=[3.5, 1.5, 1.5]",
        "bodies.ball.sphere.diameter_m=0.3",
    ];
    assert!(!reacts(CANOPY, &ball, ClothPlacement::Device));
    // A stretching wave crosses more than ten elements in a step: multigrid.
    let fine = [
        "resolution.cells_per_diameter=10.0",
        "structure.flat_circular.rings=32",
    ];
    assert!(!reacts(CANOPY, &fine, ClothPlacement::Device));
    let on_device = |scene: &Scene| Plan::new(scene, air_on_a_device(ClothPlacement::Device));
    // Air slides along this fabric; at cut links there are no markers; the fabric feels a mean.
    let wing = variant(WING, Some("filling"), &[]).scene;
    assert!(wing.coupling.unwrap().scheme == Scheme::Kernel);
    let mut of_means = parsed(CANOPY, &[]).scene;
    of_means.coupling.as_mut().unwrap().averaging_steps = 2;
    for scene in [wing, parsed(PERMEABLE, &[]).scene, of_means] {
        assert!(!on_device(&scene).reacts_on_device());
    }
}
