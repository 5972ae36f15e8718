//! Steps of fabric alone that choose their own length.

use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices, Scene};
use ripstop::cloth::{Structure, TimeIntegration};
use ripstop::frame::CableKind;
use ripstop::lines::Cable;
use ripstop::plan::{ClothPlacement, Placement, Plan, Precision};
use ripstop::simulation::Simulation;

use crate::engines::{Engine, needs_device, plain};
use crate::motion::after_a_second;
use crate::resumed::{bits_of_nodes, taken_up};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = [
        plain("adaptive::errors_follow_the_tolerance", pendulum),
        plain("adaptive::a_stiff_start_is_solved_in_parts", stiff_start),
        plain("adaptive::steps_lengthen_at_rest", at_rest),
        plain("adaptive::resumed_with_the_same_bits", || {
            resumed(Precision::F64.into(), Engine::CpuF64);
        }),
    ]
    .into_iter()
    .flatten()
    .collect();
    let device = || Placement {
        cloth: ClothPlacement::Device,
        ..Engine::Gpu.plan_placement()
    };
    trials.push(needs_device(
        "adaptive::resumed_with_the_same_bits::gpu".to_owned(),
        move || resumed(device(), Engine::Gpu),
    ));
    trials
}

fn parse(source: &str, changes: &[String]) -> Scene {
    let choices = Choices {
        variant: None,
        overrides: changes.to_vec(),
    };
    case::parse("adaptive", source, Path::new("."), &choices)
        .unwrap()
        .scene
}

const CHAIN: &str = r#"
version = 1

[structure.cable]
ends_m = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
length_m = 1.2
segments = 12
material = { area_m2 = 1e-6, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e9 }

[gravity]
acceleration_m_s2 = [0.0, 0.0, -9.81]

[solver]
tolerance = 1e-8

[time]
end_s = 1.0
step_s = 0.02

[time.adaptive]
tolerance_m = 1e-5
smallest_step_s = 1e-6
"#;

/// A mass on a line of 1 m, let go where the line is horizontal.
fn pendulum_scene(tolerance_m: f64) -> Scene {
    let change = format!("time.adaptive.tolerance_m={tolerance_m:e}");
    let mut scene = parse(CHAIN, &[change]);
    let mut structure = Structure {
        positions_m: vec![DVec3::ZERO, DVec3::X],
        masses_kg: vec![0.0, 1.0],
        held: vec![true, false],
        ..Structure::default()
    };
    // So stiff that its weight stretches the line by 3e-7.
    let line = Cable::linear(1e-4, 1e-3, 1e12);
    structure.add_cable(&[0, 1], &[1.0], &line, CableKind::Cable);
    if let Some(body) = &mut scene.body {
        body.structure = structure;
    }
    scene
}

fn run(scene: Scene) -> Simulation {
    let plan = Plan::new(&scene, Precision::F64);
    let steps = plan.steps;
    let mut simulation = Simulation::new(scene, plan, None).unwrap();
    while simulation.step_count() < steps {
        simulation.advance().unwrap();
    }
    simulation
}

/// The pendulum's place after a second.
fn exact_place_m() -> DVec3 {
    let [angle, _] = after_a_second([0.0, 0.0], |[angle, speed]| [speed, 9.81 * angle.cos()]);
    DVec3::new(angle.cos(), 0.0, -angle.sin())
}

/// Place and energy of a pendulum converge: a quarter of the tolerance halves the error of backward Euler, which stays below what local errors add up to. By
/// BDF2 a quarter of the tolerance leaves 0.4 of it, and each is far smaller for fewer parts.
fn pendulum() {
    let exact = exact_place_m();
    let ladder = |integration: TimeIntegration| {
        [4e-5, 1e-5, 2.5e-6_f64].map(|tolerance_m| {
            let mut scene = pendulum_scene(tolerance_m);
            scene.time.as_mut().unwrap().integration = integration;
            let simulation = run(scene);
            let cloth = simulation.cloth().unwrap();
            let error_m = cloth.positions_m[1].distance(exact);
            let energy_j = cloth.kinetic_energy_j() + 9.81 * cloth.positions_m[1].z;
            let adaptive = simulation.adaptive().unwrap();
            println!(
                "{integration:?}, tolerance {tolerance_m} m: error {error_m:.3e} m, energy {energy_j:.3e} J, {} parts, {} refused",
                adaptive.parts(),
                adaptive.refused()
            );
            // T √(a e/2), with the acceleration of the lowest point.
            let sum_m = (0.5 * 3.0 * 9.81 * tolerance_m).sqrt();
            assert!(error_m < sum_m, "{error_m} m, not below {sum_m} m");
            // Both only lose energy, which was zero.
            assert!(energy_j < 0.0);
            assert_eq!((adaptive.coarse(), adaptive.failed()), (0, 0));
            ([error_m, -energy_j], adaptive.parts())
        })
    };
    let euler = ladder(TimeIntegration::BackwardEuler);
    let bdf2 = ladder(TimeIntegration::Bdf2);
    for (found, [least, most]) in [
        (&euler, tolerances::adaptive::HALVED),
        (&bdf2, tolerances::adaptive::LESS_BY_BDF2),
    ] {
        for pair in found.windows(2) {
            for (coarse, fine) in pair[0].0.iter().zip(pair[1].0) {
                let ratio = coarse / fine;
                assert!((least..most).contains(&ratio), "{found:?}");
            }
        }
    }
    for (bdf2, euler) in bdf2.iter().zip(&euler) {
        assert!(
            4.0 * bdf2.0[0] < euler.0[0] && bdf2.1 < euler.1,
            "{bdf2:?} {euler:?}"
        );
    }
}

/// A chain that starts from nodes strewn about, of lines so stiff that the whole step is not solved within its evaluations; in parts it is.
fn stiff_start() {
    let scene = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|&c| c.to_owned()).collect();
        let mut scene = parse(CHAIN, &changes);
        let body = scene.body.as_mut().unwrap();
        for (i, place) in body.structure.positions_m.iter_mut().enumerate() {
            if !body.structure.held[i] {
                let i = i as f64;
                *place += DVec3::new((7.0 * i).sin(), (11.0 * i).cos(), (5.0 * i).sin()) * 0.5;
            }
        }
        scene
    };
    let common = [
        "solver.evaluation_limit=60",
        "time.end_s=0.1",
        "solver.tolerance=1e-3",
    ];
    let fixed = run(scene(&[&common[..], &["time.adaptive=absent"]].concat()));
    assert!(fixed.adaptive().is_none());
    assert!(fixed.cost().unconverged > 0, "{:?}", fixed.cost());
    let loose = "time.adaptive.tolerance_m=10.0";
    let parts = run(scene(&[&common[..], &[loose]].concat()));
    let adaptive = parts.adaptive().unwrap();
    println!(
        "fixed: {} of {} solves not converged; adaptive: {adaptive:?}",
        fixed.cost().unconverged,
        fixed.cost().solves
    );
    assert!(
        adaptive.failed() > 0 && adaptive.coarse() == 0,
        "{adaptive:?}"
    );
    // Only what was done again was left unsolved.
    assert_eq!(parts.cost().unconverged, adaptive.failed());
    assert!(
        parts
            .cloth()
            .unwrap()
            .positions_m
            .iter()
            .all(|x| x.is_finite())
    );
}

/// Once the chain has come to rest, a step is one part again.
fn at_rest() {
    let changes = ["solver.damping_1_s=20.0", "time.end_s=3.0"].map(str::to_owned);
    let scene = parse(CHAIN, &changes);
    let plan = Plan::new(&scene, Precision::F64);
    let steps = plan.steps;
    let mut simulation = Simulation::new(scene, plan, None).unwrap();
    let mut parts = Vec::new();
    while simulation.step_count() < steps {
        simulation.advance().unwrap();
        parts.push(simulation.adaptive().unwrap().parts());
    }
    let of_step = |step: usize| parts[step] - parts[step - 1];
    println!("{} parts in {steps} steps", parts[parts.len() - 1]);
    assert!((1..10).map(of_step).max() > Some(4), "{parts:?}");
    assert_eq!(of_step(parts.len() - 1), 1, "{parts:?}");
}

/// A run that goes on from a checkpoint in the midst of divided steps delivers the bits of one that was never interrupted.
fn resumed(placement: Placement, engine: Engine) {
    let source = include_str!("../cases/cloth/shaken-rope.toml");
    let scene = parse(source, &["time.end_s=0.2".to_owned()]);
    let start = || {
        let plan = Plan::new(&scene, placement.clone());
        Simulation::new(scene.clone(), plan, engine.device()).unwrap()
    };
    let mut straight = start();
    let steps = straight.plan().steps;
    while straight.step_count() < steps / 2 {
        straight.advance().unwrap();
    }
    let mut resumed = taken_up(&mut straight, start());
    assert!(resumed.adaptive().unwrap().parts() > resumed.step_count());
    for simulation in [&mut straight, &mut resumed] {
        while simulation.step_count() < steps {
            simulation.advance().unwrap();
        }
    }
    assert!(bits_of_nodes(&straight) == bits_of_nodes(&resumed));
    assert_eq!(
        straight.adaptive().unwrap().parts(),
        resumed.adaptive().unwrap().parts()
    );
}
