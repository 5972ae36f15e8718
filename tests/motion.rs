//! Motion of fabric alone: energy that free oscillations keep, waves, orders of convergence, for both ways to integrate it in time.

use std::f64::consts::TAU;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cloth::{Spring, Structure, TimeIntegration};
use ripstop::cpu::cloth::integration::FIRST_PARTS;
use ripstop::cpu::cloth::{Cloth, SolverSettings, StepInput};
use ripstop::frame::CableKind;
use ripstop::geometry::sheet::FabricModel;
use ripstop::gpu;
use ripstop::lines::Cable;
use ripstop::solve::lbfgs::HISTORY;

use crate::engines::{device, needs_device, plain};
use crate::sheets::{fabric, square_at};
use crate::tolerances;

const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);

const STEPS_PER_PERIOD: u32 = 100;
const PERIODS: u32 = 10;
/// A software device takes 30 ms for a step of three nodes.
const PERIODS_ON_DEVICE: u32 = 3;

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    trials.extend(plain("motion::a_pendulum_keeps_its_energy::host", || {
        swinging_pendulum(false);
    }));
    // On the host these two are part of `ripstop validate free-oscillations`.
    for (name, test) in [
        (
            "motion::a_pendulum_keeps_its_energy::gpu",
            swinging_pendulum as fn(bool),
        ),
        (
            "motion::a_mass_on_springs_keeps_its_energy::gpu",
            mass_on_springs,
        ),
    ] {
        trials.push(needs_device(name.to_owned(), move || test(true)));
    }
    let others: [(&str, fn()); 4] = [
        ("motion::a_taut_sheet_keeps_its_energy", taut_sheet),
        ("motion::orders_of_convergence", orders),
        ("motion::orders_with_steps_that_change", changing_steps),
        ("motion::what_is_stiff_is_forgotten", stiff),
    ];
    for (name, test) in others {
        trials.extend(plain(name, test));
    }
    trials
}

/// So tight that what is lost is the integration's.
const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-8,
    displacement_floor_m: 0.0,
    evaluation_limit: 5000,
    history: HISTORY,
    refresh_every: None,
    initial_hessian: ripstop::solve::InitialHessian::BlockJacobi,
};

fn input(
    time_step_s: f64,
    integration: TimeIntegration,
    gravity_m_s2: DVec3,
) -> StepInput<'static> {
    StepInput {
        time_step_s: Some(time_step_s),
        integration,
        gravity_m_s2,
        ..StepInput::default()
    }
}

/// Kinetic, elastic and potential energy [J].
fn energy_j(cloth: &Cloth, gravity_m_s2: DVec3) -> f64 {
    let height = cloth.positions_m.iter().zip(&cloth.structure.masses_kg);
    let potential: f64 = height.map(|(x, m)| -m * gravity_m_s2.dot(*x)).sum();
    cloth.kinetic_energy_j() + cloth.elastic_energy_j() + potential
}

/// Goes through periods of 100 steps each; the share of the energy above that `at_rest_j` that is lost in ten of them.
fn lost_in_ten_periods(
    structure: Structure,
    (period_s, gravity_m_s2, at_rest_j): (f64, DVec3, f64),
    (integration, on_device): (TimeIntegration, bool),
) -> f64 {
    let mut cloth = Cloth::new(structure);
    let mut engine = on_device.then(|| {
        let device = device().as_ref().unwrap().clone();
        gpu::cloth::Cloth::new(device, &cloth.structure, &[]).unwrap()
    });
    let dt = period_s / f64::from(STEPS_PER_PERIOD);
    let input = input(dt, integration, gravity_m_s2);
    let settings = if on_device {
        SolverSettings {
            tolerance: 1e-5,
            ..SETTINGS
        }
    } else {
        SETTINGS
    };
    let start_j = energy_j(&cloth, gravity_m_s2) - at_rest_j;
    let first = FIRST_PARTS.map(|share| share * dt);
    let periods = if on_device {
        PERIODS_ON_DEVICE
    } else {
        PERIODS
    };
    let steps = std::iter::repeat_n(dt, (periods * STEPS_PER_PERIOD - 1) as usize);
    for dt in first.into_iter().chain(steps) {
        let input = StepInput {
            time_step_s: Some(dt),
            ..input
        };
        let outcome = match &mut engine {
            Some(engine) => engine.solve(&mut cloth, &input, &settings).unwrap(),
            None => cloth.solve_cloth(&input, &settings),
        };
        assert!(outcome.stop.reached(), "{outcome:?}");
    }
    let left = (energy_j(&cloth, gravity_m_s2) - at_rest_j) / start_j;
    1.0 - left.powf(f64::from(PERIODS) / f64::from(periods))
}

/// One per cent by BDF2; backward Euler, which takes 1 − exp(−2πω dt) in a period, loses nearly all, and is left to the host.
fn keeps(lost: impl Fn(TimeIntegration) -> f64, (what, on_device): (&str, bool)) {
    let bdf2 = lost(TimeIntegration::Bdf2);
    println!("{what}: lost {bdf2:.5} by BDF2");
    let allowed = 0.0..=tolerances::ENERGY_OF_TEN_PERIODS;
    assert!(allowed.contains(&bdf2), "{what}: {bdf2}");
    if on_device {
        return;
    }
    let euler = lost(TimeIntegration::BackwardEuler);
    println!("{what}: lost {euler:.4} by backward Euler");
    let expected = 1.0 - (-TAU * TAU / 100.0 * 10.0_f64).exp();
    assert!(
        (euler - expected).abs() < tolerances::ENERGY_BY_BACKWARD_EULER,
        "{what}: {euler}, {expected}"
    );
}

/// A mass on a stiff line that leans by `angle`.
fn pendulum(angle: f64) -> Structure {
    let top = DVec3::new(0.4, 1.3, 2.2);
    let mut structure = Structure {
        positions_m: vec![top, top + DVec3::new(angle.sin(), 0.0, -angle.cos())],
        masses_kg: vec![0.0, 0.2],
        held: vec![true, false],
        ..Structure::default()
    };
    // Its weight stretches the line by 1e-6.
    let line = Cable::linear(1e-6, 1e-3, 2e12);
    structure.add_cable(&[0, 1], &[1.0], &line, CableKind::Cable);
    structure
}

fn swinging_pendulum(on_device: bool) {
    let angle: f64 = 0.2;
    let period_s = TAU * (1.0 / 9.81_f64).sqrt() * (1.0 + angle * angle / 16.0);
    let lost = |integration| {
        let at_rest_j = 0.2 * 9.81 * (2.2 - 1.0);
        let motion = (period_s, GRAVITY, at_rest_j);
        lost_in_ten_periods(pendulum(angle), motion, (integration, on_device))
    };
    keeps(lost, ("pendulum", on_device));
}

/// A mass between two springs that push and pull.
fn mass_on_springs(on_device: bool) {
    let (stiffness_n_m, mass_kg) = (500.0_f64, 0.3);
    let structure = || {
        let spring = |a: u32, b: u32| Spring {
            nodes: [a, b],
            rest_length_m: 1.0,
            stiffness_n_m,
            compressive_stiffness_n_m: stiffness_n_m,
        };
        Structure {
            positions_m: vec![DVec3::ZERO, DVec3::X * 1.1, DVec3::X * 2.0],
            masses_kg: vec![0.0, mass_kg, 0.0],
            held: vec![true, false, true],
            springs: vec![spring(0, 1), spring(1, 2)],
            ..Structure::default()
        }
    };
    let period_s = TAU * (mass_kg / (2.0 * stiffness_n_m)).sqrt();
    let lost = |integration| {
        let motion = (period_s, DVec3::ZERO, 0.0);
        lost_in_ten_periods(structure(), motion, (integration, on_device))
    };
    keeps(lost, ("mass on springs", on_device));
}

/// A sheet of 12 by 12 cells, stretched by 1 % between two held sides and plucked in its first transverse mode.
fn taut_sheet() {
    const CELLS: usize = 12;
    const AMPLITUDE_M: f64 = 1e-3;
    let mut structure = square_at(DVec3::ZERO, CELLS, FabricModel::Membrane, &fabric(1e7, 1.0));
    for (node, x) in structure.positions_m.iter_mut().enumerate() {
        x.x *= 1.01;
        structure.held[node] = node % (CELLS + 1) == 0 || node % (CELLS + 1) == CELLS;
    }
    let mut flat = Cloth::new(structure.clone());
    // It narrows as it likes.
    let settings = SolverSettings {
        displacement_floor_m: 1e-10,
        ..SETTINGS
    };
    let rest = flat.solve_cloth(&StepInput::default(), &settings);
    assert!(rest.stop.reached(), "{rest:?}");
    let at_rest_j = flat.elastic_energy_j();
    structure.positions_m = flat.positions_m;
    for x in &mut structure.positions_m {
        x.y += AMPLITUDE_M * (std::f64::consts::PI * x.x / 1.01).sin();
    }
    // By Rayleigh's quotient.
    let gained_j = Cloth::new(structure.clone()).elastic_energy_j() - at_rest_j;
    let nodes = structure.positions_m.iter().zip(&structure.masses_kg);
    let inertia: f64 = nodes.map(|(x, m)| 0.5 * m * x.y * x.y).sum();
    let period_s = TAU * (inertia / gained_j).sqrt();
    let lost = |integration| {
        let motion = (period_s, DVec3::ZERO, at_rest_j);
        lost_in_ten_periods(structure.clone(), motion, (integration, false))
    };
    keeps(lost, ("taut sheet", false));
}

/// A state after a second, by Runge and Kutta's method.
pub fn after_a_second(start: [f64; 2], rate: impl Fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
    let (mut state, steps) = (start, 20_000);
    let h = 1.0 / f64::from(steps);
    for _ in 0..steps {
        let at = |k: [f64; 2], share: f64| [0, 1].map(|i| state[i] + share * h * k[i]);
        let k1 = rate(state);
        let k2 = rate(at(k1, 0.5));
        let k3 = rate(at(k2, 0.5));
        let k4 = rate(at(k3, 1.0));
        for i in 0..2 {
            state[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
    state
}

/// Angle and speed of a pendulum of 1 m after a second, let go at 1 rad.
fn exact_swing() -> [f64; 2] {
    after_a_second([1.0, 0.0], |[angle, speed]| [speed, -9.81 * angle.sin()])
}

/// Error of angle and speed after a second in steps of these lengths, taken in turn.
fn error_of_a_swing(integration: TimeIntegration, lengths_s: &[f64]) -> f64 {
    let mut cloth = Cloth::new(pendulum(1.0));
    let (mut time_s, mut steps) = (0.0, lengths_s.iter().cycle());
    while time_s < 1.0 - 1e-9 {
        let dt = *steps.next().unwrap();
        let outcome = cloth.solve_cloth(&input(dt, integration, GRAVITY), &SETTINGS);
        assert!(outcome.stop.reached(), "{outcome:?}");
        time_s += dt;
    }
    let arm = cloth.positions_m[1] - cloth.positions_m[0];
    let angle = arm.x.atan2(-arm.z);
    let along = DVec3::new(-arm.z, 0.0, arm.x);
    let speed = cloth.velocities_m_s[1].dot(along);
    let [exact_angle, exact_speed] = exact_swing();
    (angle - exact_angle).hypot((speed - exact_speed) / 9.81_f64.sqrt())
}

fn order_of(integration: TimeIntegration, ladder: [&[f64]; 3]) -> [f64; 2] {
    let errors = ladder.map(|lengths| error_of_a_swing(integration, lengths));
    println!("{integration:?}: errors {errors:?}");
    [0, 1].map(|i| (errors[i] / errors[i + 1]).log2())
}

fn expect_order(integration: TimeIntegration, ladder: [&[f64]; 3], expected: f64) {
    for order in order_of(integration, ladder) {
        assert!(
            (order - expected).abs() < tolerances::ORDER_IN_TIME,
            "{integration:?}: {order}, not {expected}"
        );
    }
}

fn orders() {
    let ladder: [&[f64]; 3] = [&[5e-3], &[2.5e-3], &[1.25e-3]];
    expect_order(TimeIntegration::Bdf2, ladder, 2.0);
    expect_order(TimeIntegration::BackwardEuler, ladder, 1.0);
}

/// Steps that double and halve, as adaptive ones and changes of the lattice do, and one that is 2.5 times as long as the one before, which begins anew.
fn changing_steps() {
    let ladder = [1.0, 0.5, 0.25].map(|h| [0.004, 0.002, 0.002, 0.004, 0.008].map(|dt| dt * h));
    let ladder = [&ladder[0][..], &ladder[1], &ladder[2]];
    expect_order(TimeIntegration::Bdf2, ladder, 2.0);
    // One in three is of backward Euler, which has its order.
    let ladder = [1.0, 0.5, 0.25].map(|h| [0.002, 0.005, 0.003].map(|dt| dt * h));
    let ladder = [&ladder[0][..], &ladder[1], &ladder[2]];
    expect_order(TimeIntegration::Bdf2, ladder, 1.0);
}

/// A mass on springs of a period of a thousandth of the step comes to rest in a few steps, without swinging about.
fn stiff() {
    for integration in [TimeIntegration::Bdf2, TimeIntegration::BackwardEuler] {
        let spring = Spring {
            nodes: [0, 1],
            rest_length_m: 1.0,
            stiffness_n_m: 1e4,
            compressive_stiffness_n_m: 1e4,
        };
        let structure = Structure {
            positions_m: vec![DVec3::ZERO, DVec3::X * 1.1],
            masses_kg: vec![0.0, 1e-4],
            held: vec![true, false],
            springs: vec![spring],
            ..Structure::default()
        };
        let period_s = TAU * (1e-4 / 1e4_f64).sqrt();
        let mut cloth = Cloth::new(structure);
        let step = input(1e3 * period_s, integration, DVec3::ZERO);
        let ways: Vec<f64> = (0..5)
            .map(|_| {
                cloth.solve_cloth(&step, &SETTINGS);
                cloth.positions_m[1].x - 1.0
            })
            .collect();
        println!("{integration:?}: {ways:?}");
        for way in &ways[1..] {
            assert!(
                way.abs() < tolerances::STIFF_REST,
                "{integration:?}: {ways:?}"
            );
        }
    }
}
