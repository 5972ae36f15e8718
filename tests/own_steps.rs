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

use crate::engines::{air_on_a_device, needs_device, plain};
use crate::tolerances;

const CANOPY: &str = include_str!("../benches/uniform-canopy.toml");
const FLAG: &str = include_str!("../cases/flag.toml");

/// Nominal diameter of that canopy [m].
const DIAMETER_M: f64 = 0.997;

/// Length of the flag [m].
const FLAG_M: f64 = 1.0;

/// Steps in which the device learns how long its work takes.
const LEARNING: u64 = 30;

const STEPS: u64 = 40;

/// Steps that are compared before: whole ones where a box has finer cells.
const FIRST: u64 = 2;

/// Steps whose maps are counted.
const COUNTED: u64 = 256;

/// What a step may be made of.
const SCENES: [(&str, &[&str]); 4] = [
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
    (
        "of_fabric_that_cuts_links",
        &[
            CUT[0],
            CUT[1],
            CUT[2],
            CUT[3],
            "air.refinement.around=\"structure\"",
            "gravity.acceleration_m_s2=[9.81, 0.0, 0.0]",
        ],
    ),
    // One layer, one edge held, triangles larger than cells.
    (
        OF_A_FLAG,
        &[
            CUT[1],
            "structure.plate.divisions=[8, 8]",
            "solver.tolerance=1e-4",
        ],
    ),
];

/// Name of the scene that is a flag.
const OF_A_FLAG: &str = "of_a_flag_that_cuts_links";

/// Folded fabric, two layers in some links (without the pressures between them the trial fails), whose triangles share what the air does to them.
const CUT: [&str; 4] = [
    "resolution.cells_per_diameter=16.0",
    "coupling.scheme=\"links\"",
    "coupling.over_relaxation=absent",
    "solver.tolerance=1e-4",
];

/// The lattice of other trials; the solver has the tolerance of the case, 1e-2.
const COARSE: [&str; 1] = ["resolution.cells_per_diameter=10.0"];

/// Such fabric with room to move for a whole series on all sides.
const ROOMY: [&str; 5] = [
    COARSE[0],
    CUT[1],
    CUT[2],
    "air.wind_tunnel.size_m=[5.0, 4.0, 4.0]",
    "structure.flat_circular.confluence_m=[1.0, 2.0, 2.0]",
];

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, overrides) in SCENES {
        trials.push(needs_device(
            format!("own_steps::are_those_of_a_device_with_its_host_{name}"),
            move || are_those_with_the_host((name, overrides)),
        ));
    }
    for (name, overrides) in [("in_a_box", SCENES[0].1), ("cut_links", &CUT)] {
        trials.push(needs_device(
            format!("own_steps::resumed_on_a_device_{name}"),
            move || resumed(overrides),
        ));
    }
    trials.extend(plain("own_steps::plans", plans));
    trials.extend([
        needs_device("own_steps::counts_on_a_device".to_owned(), || {
            counts(&COARSE, COUNTED);
        }),
        needs_device(
            "own_steps::counts_of_a_device_with_cut_links".to_owned(),
            || counts(&ROOMY, COUNTED / 2),
        ),
        needs_device(
            "own_steps::solves_that_do_not_end_on_a_device".to_owned(),
            || unsolved(&COARSE),
        ),
        needs_device(
            "own_steps::solves_that_do_not_end_of_a_device_with_cut_links".to_owned(),
            || unsolved(&ROOMY),
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

/// What a scene consists of, and its plan on a device.
fn planned(overrides: &[&str], of_a_flag: bool) -> (case::Scene, Plan) {
    let usual: &[&str] = match of_a_flag {
        true => &["air.wind_tunnel.start_time_s=0.2"],
        false => &[
            "air.wind_tunnel.start_time_s=0.002",
            "structure.flat_circular.rings=8",
            "time.end_s=0.1",
        ],
    };
    let choices = Choices {
        variant: of_a_flag.then(|| "quick".to_owned()),
        overrides: (usual.iter().chain(overrides))
            .map(|&pair| pair.to_owned())
            .collect(),
    };
    let text = if of_a_flag { FLAG } else { CANOPY };
    let case = case::parse("case", text, Path::new("."), &choices).unwrap();
    let plan = Plan::new(&case.scene, air_on_a_device(ClothPlacement::Device));
    (case.scene, plan)
}

fn new(device: &Arc<Device>, overrides: &[&str], of_a_flag: bool) -> Simulation {
    let (scene, plan) = planned(overrides, of_a_flag);
    assert!(plan.may_make_series(&scene));
    Simulation::new(scene, plan, Some(Arc::clone(device))).unwrap()
}

/// Just released, its device knowing how long a step takes.
fn released(device: &Arc<Device>, overrides: &[&str], of_a_flag: bool) -> Simulation {
    let mut simulation = new(device, overrides, of_a_flag);
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

fn are_those_with_the_host((name, overrides): (&str, &[&str])) {
    let of_a_flag = name == OF_A_FLAG;
    let [mut with_host, mut alone] =
        [false, true].map(|own| released(&device(own), overrides, of_a_flag));
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
            if of_a_flag { FLAG_M } else { DIAMETER_M },
            of_nodes,
        );
        let [a, b] = [&with_host, &alone].map(|s| s.energies().unwrap());
        let off = (a.work.of_air_j - b.work.of_air_j).abs() / a.kinetic_j.max(a.elastic_j);
        // Hardly any energy is in the fabric yet: up to 2.6e-3 after 42 steps was found.
        assert!(off < 10.0 * of_impulses, "work of the air: {off:e}");
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
fn resumed(overrides: &[&str]) {
    let device = device(true);
    let mut unbroken = released(&device, overrides, false);
    go_on(&mut unbroken, 20);
    let folder = tempfile::tempdir().unwrap();
    checkpoint::write(folder.path(), "test", |out| unbroken.save(out)).unwrap();
    let stored = checkpoint::open(folder.path(), "test").unwrap().reader;
    go_on(&mut unbroken, 30);
    let wanted = bits(&mut unbroken);
    let mut resumed = new(&device, overrides, false);
    resumed.restore(&stored).unwrap();
    for part in [1, 7, 22] {
        go_on(&mut resumed, part);
    }
    assert!(bits(&mut resumed) == wanted);
}

/// A series asks for one map, and a step for less than two submissions. Looks for a flow that breaks down wait for the end of a series, and ask for maps of their own; so
/// do steps whose stages are timed, which end one.
fn counts(overrides: &[&str], counted: u64) {
    let device = device(true);
    let mut simulation = released(&device, overrides, false);
    go_on(&mut simulation, 20);
    let of_series = |simulation: &Simulation| simulation.cost().of(Stage::FetchNodes).device.maps;
    let (maps, before) = (of_series(&simulation), device.work());
    go_on(&mut simulation, counted);
    let (maps, work) = (of_series(&simulation) - maps, device.work().since(&before));
    assert!(32 * maps <= counted, "{maps} maps of series");
    assert!(10 * work.maps <= counted, "{work:?}");
    assert!(work.submits < 2 * counted, "{work:?}");
}

/// A solve that the device does not end stands as it is and is counted. Then the host takes part for a while, from the same step on whichever steps are made at once.
fn unsolved(overrides: &[&str]) {
    let device = device(true);
    let few = [
        overrides,
        &["solver.tolerance=1e-4", "solver.evaluation_limit=5"],
    ]
    .concat();
    let runs = [&[120][..], &[7, 40, 73]].map(|parts| {
        let mut simulation = new(&device, &few, false);
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

/// Where fabric cuts links, whatever needs the host in a step keeps it.
fn plans() {
    let alone = |further: &[&str]| {
        let overrides = [&CUT, further].concat();
        let (scene, plan) = planned(&overrides, false);
        plan.may_make_series(&scene)
    };
    assert!(alone(&[]));
    let slides = "resolution.operator=\"stabilised_regularised\"";
    for further in [
        &["fabric.friction=\"none\"", slides][..],
        &["fabric.friction=\"model\"", slides],
        &["fabric.permeability={material=\"mil_c_7020_type_1\"}"],
        &["air.faces={y_lower=\"periodic\", y_upper=\"periodic\"}"],
        &[
            "structure.flat_circular.rings=2",
            "resolution.cells_per_diameter=96.0",
        ],
        &["coupling.narrow_openings=\"law\""],
        &["bodies.payload={position_m=[0.5, 1.4955, 1.4955], sphere={diameter_m=0.3}}"],
    ] {
        assert!(!alone(further), "{further:?}");
    }
}
