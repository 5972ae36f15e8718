//! Supports that are moved, in equilibrium and in motion.

use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::cloth::{Spring, Structure};
use ripstop::measure::{Record, catenary, results};
use ripstop::plan::{ClothPlacement, Placement, Plan, Precision};
use ripstop::run::without_files;
use ripstop::simulation::Simulation;
use ripstop::statics::Statics;

use crate::engines::{Engine, needs_device, plain};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = [
        plain("supports::a_bar_pulls_back", || {
            bar(
                Precision::F64.into(),
                Engine::CpuF64,
                tolerances::supports::FORCE,
            );
        }),
        plain("supports::a_chain_hangs_between_moved_ends", chain),
        plain("supports::a_mass_follows_a_shaken_spring", shaken),
        plain("supports::a_clamp_turns", turned),
    ]
    .into_iter()
    .flatten()
    .collect();
    trials.push(needs_device(
        "supports::a_bar_pulls_back::gpu".to_owned(),
        || {
            let placement = Placement {
                cloth: ClothPlacement::Device,
                ..Engine::Gpu.plan_placement()
            };
            bar(placement, Engine::Gpu, tolerances::supports::DEVICE_FORCE);
        },
    ));
    trials
}

fn parse(source: &str) -> Case {
    case::parse("supports", source, Path::new("."), &Choices::default()).unwrap()
}

/// EA = 1e4 N, 1 m long, 0.1 kg.
const BAR: &str = r#"
version = 1

[structure.cable]
ends_m = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
length_m = 1.000001
segments = 4
material = { area_m2 = 1e-4, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e8 }
"#;

/// A bar whose end is moved by u pulls back with EA (u + l)/L − EA, at once and after a motion in time, which is that of the case.
fn bar(placement: Placement, engine: Engine, tolerance: f64) {
    let rest_m = 1.000_001;
    let force_n = |displacement: f64| 1e4 * ((1.0 + displacement) / rest_m - 1.0);
    let equilibrium = "\n[equilibrium]\ntolerance = 1e-9\nevaluation_limit = 20000\n";
    let end =
        |results: &ripstop::output::Results, name: &str| results.get(name).unwrap().value.unwrap();
    let time = "\n[time]\nend_s = 0.05\nstep_s = 1e-3\n";
    let grip = "\n[supports.grip]\nnodes = [5]\n";
    let table = "\n[supports.grip.motion.table]\ntimes_s = [0.0, 0.02, 0.05]\ndisplacements_m = [[0.0, 0.0, 0.0], [0.003, 0.0, 0.0], \
                 [0.01, 0.0, 0.0]]\n";
    let boxed = "\n[supports.grip]\nbox_m = [[1.1, 0.1, 0.1], [0.9, -0.1, -0.1]]\ndisplacement_m = [0.01, 0.0, 0.0]\n";
    for (source, at_once) in [
        (format!("{BAR}{boxed}{equilibrium}"), true),
        (
            format!("{BAR}{boxed}ramp_time_s = 0.03\n{time}{equilibrium}"),
            false,
        ),
        (format!("{BAR}{grip}{table}{time}{equilibrium}"), false),
    ] {
        let case = parse(&source);
        let plan = Plan::new(&case.scene, placement.clone());
        let mut simulation = Simulation::new(case.scene.clone(), plan, engine.device()).unwrap();
        let mut record = Record::new(&simulation);
        let steps = simulation.plan().steps;
        while simulation.step_count() < steps {
            simulation.advance().unwrap();
            record.add(&mut simulation).unwrap();
            // To the last bit.
            let motion = &case.scene.supports[0].motion;
            let start = case.scene.body.as_ref().unwrap().structure.positions_m[4];
            let wanted = motion.at(simulation.time_s()).position_m(start);
            assert_eq!(simulation.cloth().unwrap().positions_m[4], wanted);
        }
        assert_eq!(at_once, steps == 0);
        simulation.equilibrate(&mut |_| true).unwrap().unwrap();
        record.add(&mut simulation).unwrap();
        let results = results(&simulation, &Statics::default(), &record);
        assert!((end(&results, "grip_displacement_x_m") - 0.01).abs() < 1e-12);
        let pull = end(&results, "grip_force_x_n");
        assert!(
            (pull / force_n(0.01) - 1.0).abs() < tolerance,
            "{pull} N instead of {} N:{source}",
            force_n(0.01)
        );
    }
}

/// The sag of a chain whose ends come nearer is that of the catenary over the shorter span.
fn chain() {
    let source = include_str!("../cases/cloth/hanging-chain.toml");
    let moved = "[supports.right]\nbox_m = [[0.9, -1.0, 0.0], [1.1, 1.0, 2.0]]\ndisplacement_m = [-0.2, 0.0, 0.0]\n";
    let case = parse(&format!("{source}\n{moved}"));
    let plan = Plan::new(&case.scene, Precision::F64);
    let (mut simulation, mut record) = without_files(&case, plan, None).unwrap();
    simulation.equilibrate(&mut |_| true).unwrap().unwrap();
    record.add(&mut simulation).unwrap();
    let results = results(&simulation, &Statics::default(), &record);
    let weight_n_m = 1e-4 * 1000.0 * 9.81;
    let exact = catenary::solve(0.8, 1.2, weight_n_m).unwrap();
    let near = |name: &str, exact: f64| {
        let value = results.get(name).unwrap().value.unwrap();
        assert!(
            (value / exact - 1.0).abs() < tolerances::CATENARY,
            "{name}: {value} instead of {exact}"
        );
    };
    near("sag_m", exact.sag_m);
    near("right_force_x_n", exact.horizontal_tension_n);
    near("right_force_z_n", 0.5 * 1.2 * weight_n_m);
    // The last segment carries the weight of the chain but for its own half.
    let largest = results.get("cable_tension_max_n").unwrap().value.unwrap();
    let share = largest / exact.end_tension_n;
    assert!((0.985..1.0).contains(&share), "{share}");
    // The reference of the case is that of ends which stay.
    assert!(results.get("sag_m").unwrap().reference.is_none());
}

/// A mass between two springs, one end of which is shaken: m x¨ = k (u − x) − k x from rest, u = a sin(ω t).
fn shaken() {
    let (mass_kg, stiffness_n_m, amplitude_m, frequency_hz) = (0.1, 200.0, 0.02, 5.0);
    let case = parse(&format!(
        "{BAR}\n[supports.shaker]\nnodes = [3]\n[supports.shaker.motion.oscillation]\nfrequency_hz = {frequency_hz:?}\n\
         displacement_m = [{amplitude_m}, 0.0, 0.0]\n[time]\nend_s = 0.3\nstep_s = 2e-5\n[solver]\ntolerance = 1e-9\n"
    )
    .replace("segments = 4", "segments = 2"));
    let mut scene = case.scene.clone();
    let spring = |a: u32| Spring {
        nodes: [a, a + 1],
        rest_length_m: 1.0,
        stiffness_n_m,
        compressive_stiffness_n_m: stiffness_n_m,
    };
    scene.body.as_mut().unwrap().structure = Structure {
        positions_m: (0..3).map(|i| DVec3::X * f64::from(i)).collect(),
        masses_kg: vec![mass_kg; 3],
        held: vec![true, false, true],
        springs: vec![spring(0), spring(1)],
        ..Structure::default()
    };
    let plan = Plan::new(&scene, Precision::F64);
    let steps = plan.steps;
    let mut simulation = Simulation::new(scene, plan, None).unwrap();
    let natural = (2.0 * stiffness_n_m / mass_kg).sqrt();
    let forced = TAU * frequency_hz;
    let share = amplitude_m * stiffness_n_m / (mass_kg * (natural.powi(2) - forced.powi(2)));
    let mut worst: f64 = 0.0;
    for _ in 0..steps {
        simulation.advance().unwrap();
        let t = simulation.time_s();
        let exact = share * ((forced * t).sin() - forced / natural * (natural * t).sin());
        let found = simulation.cloth().unwrap().positions_m[1].x - 1.0;
        worst = worst.max((found - exact).abs());
    }
    assert!(
        worst < tolerances::supports::SHAKEN * amplitude_m,
        "{worst:e} m"
    );
}

/// A support that turns about its own middle takes its nodes along a circle.
fn turned() {
    let case = parse(&format!(
        "{BAR}\n[supports.ends]\nnodes = [1, 5]\n[supports.ends.motion.constant_rotation]\naxis = [0.0, 0.0, 2.0]\nrate_rad_s = 3.0\n\
         [time]\nend_s = 0.1\nstep_s = 0.01\n"
    ));
    let plan = Plan::new(&case.scene, Precision::F64);
    let (simulation, _) = without_files(&case, plan, None).unwrap();
    let cloth = simulation.cloth().unwrap();
    let middle = DVec3::X * 0.5;
    let arm = DVec3::new(0.3_f64.cos(), 0.3_f64.sin(), 0.0) * 0.5;
    for (node, place) in [(0, middle - arm), (4, middle + arm)] {
        assert!(cloth.positions_m[node].distance(place) < 1e-12);
    }
    // Held nodes move at the speed of the step's chord.
    assert!((cloth.velocities_m_s[4].length() / 1.5 - 1.0).abs() < 1e-3);
}
