//! Steps that a device makes by itself, where it has air and fabric.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::checkpoint;
use ripstop::gpu::{AdapterChoice, Device, Tuning};
use ripstop::plan::{ClothPlacement, Plan, Stage};
use ripstop::simulation::Simulation;

use crate::engines::{air_on_a_device, needs_device};
use crate::tolerances;

const CANOPY: &str = include_str!("../benches/uniform-canopy.toml");

/// Nominal diameter of that canopy [m].
const DIAMETER_M: f64 = 0.997;

/// Steps in which the device learns how long its work takes.
const LEARNING: u64 = 30;

const STEPS: u64 = 40;

/// Steps that are compared before: whole ones where a box has finer cells.
const FIRST: u64 = 2;

/// Steps whose maps are counted.
const COUNTED: u64 = 256;

/// What a step may be made of.
const SCENES: [(&str, &[&str]); 2] = [
    (
        "in_a_box",
        &[
            "resolution.cells_per_diameter=16.0",
            "air.refinement.around=\"structure\"",
            "solver.tolerance=1e-4",
        ],
    ),
    (
        "by_backward_euler",
        &[
            "resolution.cells_per_diameter=10.0",
            "time.integration=\"backward_euler\"",
            "gravity.acceleration_m_s2=[9.81, 0.0, 0.0]",
            "solver.damping_1_s=20.0",
            "solver.tolerance=1e-3",
        ],
    ),
];

/// The lattice of other trials; the solver has the tolerance of the case, 1e-2.
const COARSE: [&str; 1] = ["resolution.cells_per_diameter=10.0"];

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, overrides) in SCENES {
        trials.push(needs_device(
            format!("own_steps::are_those_of_a_device_with_its_host_{name}"),
            move || are_those_with_the_host(overrides),
        ));
    }
    trials.extend([
        needs_device("own_steps::resumed_on_a_device".to_owned(), resumed),
        needs_device("own_steps::counts_on_a_device".to_owned(), counts),
        needs_device(
            "own_steps::solves_that_do_not_end_on_a_device".to_owned(),
            unsolved,
        ),
    ]);
    trials
}

/// Fabric that one workgroup solves.
fn device(goes_ahead: bool) -> Arc<Device> {
    let tuning = Tuning {
        small_cloth_nodes: Some(usize::MAX),
        longest_left: Duration::from_secs(3600),
        goes_ahead,
        ..Tuning::default()
    };
    Device::open_tuned(&AdapterChoice::Any, tuning).unwrap()
}

fn new(device: &Arc<Device>, overrides: &[&str]) -> Simulation {
    let usual = [
        "air.wind_tunnel.start_time_s=0.002",
        "structure.flat_circular.rings=8",
        "time.end_s=0.1",
    ];
    let choices = Choices {
        variant: None,
        overrides: (usual.iter().chain(overrides))
            .map(|&pair| pair.to_owned())
            .collect(),
    };
    let case = case::parse("canopy", CANOPY, Path::new("."), &choices).unwrap();
    let plan = Plan::new(&case.scene, air_on_a_device(ClothPlacement::Device));
    assert!(plan.reacts_on_device());
    Simulation::new(case.scene, plan, Some(Arc::clone(device))).unwrap()
}

/// Just released, its device knowing how long a step takes.
fn released(device: &Arc<Device>, overrides: &[&str]) -> Simulation {
    let mut simulation = new(device, overrides);
    let steps = simulation.plan().start_steps + LEARNING;
    while simulation.step_count() < steps || !simulation.stands_together() {
        simulation.advance().unwrap();
    }
    simulation
}

/// Goes on by so many steps, after which alone somebody reads.
fn go_on(simulation: &mut Simulation, steps: u64) {
    let end = simulation.step_count() + steps;
    simulation.set_next_reading(end);
    while simulation.step_count() < end {
        simulation.advance().unwrap();
    }
    assert!(!simulation.is_ahead());
}

fn are_those_with_the_host(overrides: &[&str]) {
    let [mut with_host, mut alone] = [false, true].map(|own| released(&device(own), overrides));
    // From the same state.
    for (steps, [of_impulses, of_nodes]) in [
        (FIRST, tolerances::OWN_STEP),
        (STEPS, tolerances::OWN_STEPS),
    ] {
        let own_steps = |simulation: &Simulation| simulation.cost().own_steps;
        let before = own_steps(&alone);
        go_on(&mut with_host, steps);
        go_on(&mut alone, steps);
        assert_eq!(own_steps(&with_host), 0);
        assert_eq!(own_steps(&alone) - before, steps);
        let samples = [&mut with_host, &mut alone].map(|s| s.impulse_sample().unwrap().unwrap());
        let scale = samples[0].markers.length();
        let same = |what: &str, [a, b]: [DVec3; 2], scale: f64, tolerance: f64| {
            let off = (a - b).length() / scale;
            assert!(off < tolerance, "{what} after {steps} steps: {off:e}");
        };
        let [a, b] = &samples;
        for (route, [a, b]) in [
            ("markers", [a.markers, b.markers]),
            ("supports", [a.supports, b.supports].map(Option::unwrap)),
            (
                "momentum box",
                [a.momentum_box, b.momentum_box].map(Option::unwrap),
            ),
        ] {
            same(route, [a, b], scale, of_impulses);
        }
        let [a, b] = [&with_host, &alone].map(|s| &s.cloth().unwrap().positions_m);
        let squares: Vec<f64> = (a.iter().zip(b))
            .map(|(a, b)| (*a - *b).length_squared())
            .collect();
        let mean = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        same(
            "nodes",
            [DVec3::X * mean, DVec3::ZERO],
            DIAMETER_M,
            of_nodes,
        );
        let [a, b] = [&with_host, &alone].map(|simulation| simulation.cost().evaluations as f64);
        assert!((b / a - 1.0).abs() < 0.1, "{a} and {b} evaluations");
    }
}

/// Places, velocities and impulses, to the last bit.
fn bits(simulation: &mut Simulation) -> Vec<u64> {
    let impulses = simulation.impulse_sample().unwrap().unwrap();
    let cloth = simulation.cloth().unwrap();
    let places = cloth.positions_m.iter().chain(&cloth.velocities_m_s);
    places
        .chain([&impulses.markers, &impulses.supports.unwrap()])
        .flat_map(|place| place.to_array().map(f64::to_bits))
        .collect()
}

/// A run that goes on from what was saved has the bits of one that was not broken off, and whichever steps are made at once.
fn resumed() {
    let device = device(true);
    let (_, boxed) = SCENES[0];
    let mut unbroken = released(&device, boxed);
    go_on(&mut unbroken, 20);
    let folder = tempfile::tempdir().unwrap();
    checkpoint::write(folder.path(), "test", |out| unbroken.save(out)).unwrap();
    let stored = checkpoint::open(folder.path(), "test").unwrap().reader;
    go_on(&mut unbroken, 30);
    let wanted = bits(&mut unbroken);
    let mut resumed = new(&device, boxed);
    resumed.restore(&stored).unwrap();
    for part in [1, 7, 22] {
        go_on(&mut resumed, part);
    }
    assert!(bits(&mut resumed) == wanted);
}

/// A series asks for one map, and a step for less than two submissions. Looks for a flow that breaks down wait for the end of a series, and ask for maps of their own; so
/// do steps whose stages are timed, which end one.
fn counts() {
    let device = device(true);
    let mut simulation = released(&device, &COARSE);
    go_on(&mut simulation, 20);
    let of_series = |simulation: &Simulation| simulation.cost().of(Stage::FetchNodes).device.maps;
    let (maps, before) = (of_series(&simulation), device.work());
    go_on(&mut simulation, COUNTED);
    let (maps, work) = (of_series(&simulation) - maps, device.work().since(&before));
    assert!(32 * maps <= COUNTED, "{maps} maps of series");
    assert!(10 * work.maps <= COUNTED, "{work:?}");
    assert!(work.submits < 2 * COUNTED, "{work:?}");
}

/// A solve that the device does not end stands as it is and is counted. Then the host takes part for a while, from the same step on whichever steps are made at once.
fn unsolved() {
    let device = device(true);
    let few = [
        COARSE[0],
        "solver.tolerance=1e-4",
        "solver.evaluation_limit=5",
    ];
    let runs = [&[120][..], &[7, 40, 73]].map(|parts| {
        let mut simulation = new(&device, &few);
        while !simulation.released() {
            simulation.advance().unwrap();
        }
        // Everything is said before the first step whose solve does not end.
        for part in parts {
            go_on(&mut simulation, *part);
        }
        let cost = simulation.cost();
        assert_eq!(cost.unconverged, 120);
        // Those up to the first border, but for the first of all, which has none before it.
        assert_eq!(cost.own_steps, 63);
        bits(&mut simulation)
    });
    assert!(runs[0] == runs[1]);
}
