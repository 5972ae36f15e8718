//! Fabric feels its loads however short the step: fall, drag and swing against the solutions of backward Euler, which is the scheme of the
//! implicit step, and against exact ones.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::{Cloth, NodalDrag, SolverSettings, StepInput};
use ripstop::frame::CableKind;
use ripstop::geometry::sheet::FabricModel;
use ripstop::gpu;
use ripstop::lines::Cable;
use ripstop::solve::lbfgs::HISTORY;

use crate::engines::{device, needs_device, plain};
use crate::sheets::{fabric, square_at};
use crate::tolerances;

const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);

/// Steps of every run of the ladder on the host, and on a device, a tenth, where tests run on one that is emulated.
const STEPS: u32 = 200;
const STEPS_ON_A_DEVICE: u32 = 20;

/// Time steps on every engine, and those on the host alone, whose positions are finer and whose steps cost less [s].
const TIME_STEPS_S: [f64; 3] = [1e-2, 1e-4, 1e-6];
const ON_THE_HOST_S: [f64; 3] = [1e-3, 1e-5, 1e-7];

pub fn trials() -> Vec<Trial> {
    type Test = fn(Solver);
    let tests: [(&str, Test); 6] = [
        ("time_steps::a_sheet_falls", falling_sheet),
        ("time_steps::a_flat_sheet_leaves_its_corners", held_corners),
        ("time_steps::a_payload_falls_against_drag", falling_payload),
        ("time_steps::a_pendulum_begins_to_swing", swing),
        ("time_steps::a_sheet_swings", swinging_sheet),
        ("time_steps::periods_of_a_pendulum", periods),
    ];
    let mut trials = Vec::new();
    for (name, test) in tests {
        trials.extend(plain(&format!("{name}::host"), move || test(Solver::Host)));
        trials.push(needs_device(format!("{name}::gpu"), move || {
            test(Solver::Device);
        }));
    }
    trials.extend(plain("time_steps::motion_without_loads", without_loads));
    trials
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Solver {
    Host,
    Device,
}

impl Solver {
    fn time_steps_s(self) -> Vec<f64> {
        match self {
            Self::Host => [&TIME_STEPS_S[..], &ON_THE_HOST_S].concat(),
            Self::Device => TIME_STEPS_S.to_vec(),
        }
    }

    const fn steps(self) -> u32 {
        match self {
            Self::Host => STEPS,
            Self::Device => STEPS_ON_A_DEVICE,
        }
    }

    /// The state after so many steps; all solves reach their tolerance.
    fn advance(self, structure: Structure, (steps, input): (u32, &StepInput)) -> Cloth {
        let mut left = steps;
        self.advance_while(structure, (input, &SETTINGS), |_| {
            left = left.wrapping_sub(1);
            left < steps
        })
    }

    /// Goes on as long as `more` says so of the state.
    fn advance_while(
        self,
        structure: Structure,
        (input, settings): (&StepInput, &SolverSettings),
        mut more: impl FnMut(&Cloth) -> bool,
    ) -> Cloth {
        let mut cloth = Cloth::new(structure);
        let mut on_device = (self == Self::Device).then(|| {
            let device = device().as_ref().unwrap().clone();
            gpu::cloth::Cloth::new(device, &cloth.structure, &[]).unwrap()
        });
        while more(&cloth) {
            let outcome = match &mut on_device {
                Some(on_device) => on_device.solve(&mut cloth, input, settings).unwrap(),
                None => cloth.solve_cloth(input, settings),
            };
            assert!(outcome.stop.reached(), "{self:?} {outcome:?}");
        }
        cloth
    }
}

/// As cases of falls have them.
const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-3,
    displacement_floor_m: 0.0,
    evaluation_limit: 2000,
    history: HISTORY,
    refresh_every: None,
    initial_hessian: ripstop::solve::InitialHessian::BlockJacobi,
};

fn falling(time_step_s: f64) -> StepInput<'static> {
    StepInput {
        time_step_s: Some(time_step_s),
        gravity_m_s2: GRAVITY,
        ..StepInput::default()
    }
}

/// A flat sheet some metres from the origin, free but for what a test holds.
fn sheet() -> Structure {
    let mut structure = square_at(
        DVec3::new(0.3, -2.0, 3.7),
        4,
        FabricModel::Membrane,
        &fabric(1e7, 1e-3),
    );
    for x in &mut structure.positions_m {
        *x = DVec3::new(x.x, -2.0 + 0.7 * (x.z - 3.7), 3.7 + 0.01 * (x.z - 3.7));
    }
    structure
}

fn mean_speed_m_s(cloth: &Cloth, nodes: impl Iterator<Item = usize> + Clone) -> f64 {
    let count = nodes.clone().count() as f64;
    nodes.map(|n| -cloth.velocities_m_s[n].z).sum::<f64>() / count
}

fn close(found: f64, expected: f64, what: &str) {
    let error = found / expected - 1.0;
    assert!(
        error.abs() <= tolerances::SPEED_OF_A_FALL,
        "{what}: {found:e} in place of {expected:e}, error {error:.1e}"
    );
}

/// Free fall: v = n g dt and, by backward Euler, z = g dt² n (n + 1)/2.
fn falling_sheet(solver: Solver) {
    for time_step_s in solver.time_steps_s() {
        // As it lies it is neither taut nor slack.
        let structure = square_at(
            DVec3::new(0.3, -2.0, 3.7),
            4,
            FabricModel::Membrane,
            &fabric(1e7, 1e-3),
        );
        let start = structure.positions_m.clone();
        let cloth = solver.advance(structure, (solver.steps(), &falling(time_step_s)));
        let nodes = 0..start.len();
        let what = format!("{solver:?}, steps of {time_step_s:e} s");
        let steps = f64::from(solver.steps());
        close(
            mean_speed_m_s(&cloth, nodes.clone()),
            9.81 * steps * time_step_s,
            &what,
        );
        let fallen = |n: usize| start[n].z - cloth.positions_m[n].z;
        let mean_m = nodes.map(fallen).sum::<f64>() / start.len() as f64;
        let expected_m = 0.5 * 9.81 * steps * (steps + 1.0) * time_step_s * time_step_s;
        close(mean_m, expected_m, &format!("way, {what}"));
    }
}

/// A sheet that lies flat between two held corners: until a wave has come from there its nodes fall freely. With an absolute floor of 1 nm
/// for the displacement in a step they did not move at all in steps of 10 µs and less.
fn held_corners(solver: Solver) {
    for time_step_s in solver.time_steps_s() {
        // No farther than a wave of 300 m/s goes in a tenth of the sheet.
        let steps = (3e-4 / time_step_s) as u32;
        if steps == 0 {
            continue;
        }
        let steps = steps.min(solver.steps());
        let mut structure = sheet();
        for x in &mut structure.positions_m {
            // The same sheet, flat.
            *x = DVec3::new(x.x, -2.0 + (x.y + 2.0) / 0.7, 3.7);
        }
        structure.held[0] = true;
        structure.held[4] = true;
        let cloth = solver.advance(structure, (steps, &falling(time_step_s)));
        let what = format!("{solver:?}, steps of {time_step_s:e} s");
        let expected = 9.81 * f64::from(steps) * time_step_s;
        // The rows far from the corners.
        close(mean_speed_m_s(&cloth, 15..25), expected, &what);
    }
}

/// A payload below a fabric that hangs on it, with a drag linear in its speed: by backward Euler v' = (v + g dt)/(1 + c dt/m).
fn falling_payload(solver: Solver) {
    const MASS_KG: f64 = 90.0;
    const DRAG_KG_S: f64 = 30.0;
    for time_step_s in solver.time_steps_s() {
        let structure = Structure {
            positions_m: vec![DVec3::new(0.1, 0.2, 7.3)],
            masses_kg: vec![MASS_KG],
            held: vec![false],
            ..Structure::default()
        };
        let drags = [NodalDrag {
            node: 0,
            coefficient_kg_s: DRAG_KG_S,
            air_velocity_m_s: DVec3::ZERO,
        }];
        let input = StepInput {
            drags: &drags,
            ..falling(time_step_s)
        };
        let cloth = solver.advance(structure, (5 * solver.steps(), &input));
        let expected = (0..5 * solver.steps()).fold(0.0, |v: f64, _| {
            (v + 9.81 * time_step_s) / (1.0 + DRAG_KG_S / MASS_KG * time_step_s)
        });
        let what = format!("{solver:?}, steps of {time_step_s:e} s");
        close(-cloth.velocities_m_s[0].z, expected, &what);
    }
}

/// A mass on a stiff line that leans by `angle`.
fn pendulum(angle: f64, length_m: f64) -> Structure {
    let top = DVec3::new(0.4, 1.3, 2.2);
    let mut structure = Structure {
        positions_m: vec![
            top,
            top + length_m * DVec3::new(angle.sin(), 0.0, -angle.cos()),
        ],
        masses_kg: vec![0.0, 0.2],
        held: vec![true, false],
        ..Structure::default()
    };
    // Its weight stretches the line by 1e-4; a device tells strains of 6e-8 apart.
    let line = Cable::linear(1e-6, 1e-3, 2e10);
    structure.add_cable(&[0, 1], &[length_m], &line, CableKind::Cable);
    structure
}

/// Let go at 60°, a pendulum gains the speed g sin(60°) t along its way at first.
fn swing(solver: Solver) {
    let angle = std::f64::consts::FRAC_PI_3;
    let along = DVec3::new(-angle.cos(), 0.0, -angle.sin());
    for time_step_s in solver.time_steps_s() {
        let steps = (0.01 / time_step_s) as u32;
        let steps = steps.min(5 * solver.steps());
        let cloth = solver.advance(pendulum(angle, 1.0), (steps, &falling(time_step_s)));
        let expected = 9.81 * angle.sin() * f64::from(steps) * time_step_s;
        let what = format!("{solver:?}, steps of {time_step_s:e} s");
        close(cloth.velocities_m_s[1].dot(along), expected, &what);
    }
}

/// Times at which a signal passes through zero, in steps: values in, one per step.
struct Passages {
    steps: f64,
    last: f64,
    found: Vec<f64>,
}

impl Passages {
    const fn new() -> Self {
        Self {
            steps: -1.0,
            last: 0.0,
            found: Vec::new(),
        }
    }

    /// True until three are found.
    fn more(&mut self, now: f64) -> bool {
        if now * self.last < 0.0 {
            self.found.push(self.steps + self.last / (self.last - now));
        }
        (self.steps, self.last) = (self.steps + 1.0, now);
        self.found.len() < 3
    }

    fn period(&self) -> f64 {
        self.found[2] - self.found[0]
    }
}

/// The time between the first and the third passage of a pendulum through its lowest point, over five decades of the time step, the shorter the
/// line the shorter the step. Of small swings it is 2π √(l/g) (1 + φ²/16); backward Euler makes it longer by (ω dt)²/3, 3e-4 of the longest step.
fn periods(solver: Solver) {
    let angle: f64 = 0.05;
    let mut ladder = vec![(1e-2, 1.0), (1e-3, 0.1), (1e-4, 1e-2)];
    if solver == Solver::Host {
        ladder.extend([(1e-5, 1e-3), (1e-6, 1e-4), (1e-7, 1e-5)]);
    }
    for (time_step_s, length_m) in ladder {
        let exact = std::f64::consts::TAU * (length_m / 9.81_f64).sqrt();
        let exact = exact * (1.0 + angle * angle / 16.0);
        let structure = pendulum(angle, length_m);
        let top = structure.positions_m[0];
        let mut passages = Passages::new();
        solver.advance_while(structure, (&falling(time_step_s), &SETTINGS), |cloth| {
            passages.more(cloth.positions_m[1].x - top.x)
        });
        let what = format!("period, {solver:?}, steps of {time_step_s:e} s");
        close(passages.period() * time_step_s, exact, &what);
    }
}

/// Masses of the rows of a sheet that hangs by its uppermost [kg], the way of each in the lowest mode, and its angular frequency [rad/s]: a
/// chain under the tension of the weight below, by inverse iteration.
fn lowest_mode(structure: &Structure) -> (Vec<f64>, f64) {
    let rows = 4;
    let masses: Vec<f64> = (1..=rows)
        .map(|row| structure.masses_kg[row * 5..row * 5 + 5].iter().sum())
        .collect();
    let mut mode: Vec<f64> = (1..=rows).map(|row| row as f64).collect();
    let mut square = 0.0;
    for _ in 0..100 {
        // The force that each row of the chain takes: K y = m mode, from the free end.
        let forces: Vec<f64> = mode.iter().zip(&masses).map(|(y, m)| y * m).collect();
        let mut next = Vec::new();
        let mut way = 0.0;
        for row in 0..rows {
            let across: f64 = forces[row..].iter().sum();
            let tension: f64 = 9.81 * masses[row..].iter().sum::<f64>();
            way += across / tension * 0.25;
            next.push(way);
        }
        let dot = |a: &[f64], b: &[f64]| -> f64 {
            a.iter()
                .zip(b)
                .zip(&masses)
                .map(|((a, b), m)| a * b * m)
                .sum()
        };
        square = dot(&mode, &next) / dot(&next, &next);
        let largest = next[rows - 1];
        mode = next.iter().map(|y| y / largest).collect();
    }
    (mode, square.sqrt())
}

/// Period of a sheet that hangs by its upper edge and swings in its lowest mode [s].
fn period_of_a_sheet_s(solver: Solver, time_step_s: f64) -> f64 {
    const AMPLITUDE_M: f64 = 0.02;
    let mut structure = square_at(
        DVec3::new(0.3, -2.0, 3.7),
        4,
        FabricModel::Membrane,
        &fabric(1e7, 1e-3),
    );
    let (mode, _) = lowest_mode(&structure);
    structure.held[..5].fill(true);
    // Rows stay as far apart as they were.
    let (mut before, mut z) = (0.0, 3.7);
    for (row, share) in mode.iter().enumerate() {
        let aside: f64 = AMPLITUDE_M * share - before;
        z -= (0.25 * 0.25 - aside * aside).sqrt();
        for x in &mut structure.positions_m[5 * row + 5..5 * row + 10] {
            (x.y, x.z) = (-2.0 + AMPLITUDE_M * share, z);
        }
        before += aside;
    }
    let mut passages = Passages::new();
    // So little of the weight swings it that the usual tolerance shows.
    let settings = SolverSettings {
        tolerance: 1e-5,
        ..SETTINGS
    };
    solver.advance_while(structure, (&falling(time_step_s), &settings), |cloth| {
        let lowest = cloth.positions_m[20..25].iter();
        passages.more(lowest.map(|x| x.y + 2.0).sum())
    });
    passages.period() * time_step_s
}

/// A sheet swings with the same period in steps of every length, which is that of a chain but for what nodes of a row move apart.
fn swinging_sheet(solver: Solver) {
    let fine_s = period_of_a_sheet_s(Solver::Host, 1e-3);
    let structure = square_at(DVec3::ZERO, 4, FabricModel::Membrane, &fabric(1e7, 1e-3));
    let chain_s = std::f64::consts::TAU / lowest_mode(&structure).1;
    let error = fine_s / chain_s - 1.0;
    assert!(error.abs() < tolerances::SHEET_FOR_A_CHAIN, "{error:e}");
    let time_steps_s: &[f64] = match solver {
        Solver::Host => &[1e-2, 1e-4],
        Solver::Device => &[1e-2, 2e-3],
    };
    for &time_step_s in time_steps_s {
        let what = format!("period, {solver:?}, steps of {time_step_s:e} s");
        close(period_of_a_sheet_s(solver, time_step_s), fine_s, &what);
    }
}

/// A mass on a line, pulled and let go without any load: the tolerance is relative to forces of the structure and of inertia. By backward
/// Euler the elongation e follows (1 + ω² dt²) e'' = 2 e' − e.
fn without_loads() {
    let (stiffness_n_m, mass_kg) = (1e4, 0.2);
    for time_step_s in [1e-3, 1e-4, 1e-5] {
        let mut structure = pendulum(0.0, 1.0);
        structure.cables.clear();
        let line = Cable::linear(1e-6, 1e-3, stiffness_n_m / 1e-6);
        structure.add_cable(&[0, 1], &[1.0], &line, CableKind::Cable);
        let top = structure.positions_m[0];
        structure.positions_m[1].z -= 1e-3;
        let mut cloth = Cloth::new(structure);
        let input = StepInput {
            time_step_s: Some(time_step_s),
            ..StepInput::default()
        };
        let square = stiffness_n_m / mass_kg * time_step_s * time_step_s;
        let (mut before, mut now) = (1e-3, 1e-3);
        let mut steps = 0;
        // As long as it is taut.
        while now > 1e-4 {
            (before, now) = (now, (2.0 * now - before) / (1.0 + square));
            let outcome = cloth.solve_cloth(&input, &SETTINGS);
            assert!(outcome.stop.reached(), "{outcome:?}");
            steps += 1;
            let elongation = top.z - cloth.positions_m[1].z - 1.0;
            let error = (elongation - now) / 1e-3;
            assert!(
                error.abs() < tolerances::FREE_OSCILLATION,
                "steps of {time_step_s:e} s, step {steps}: {elongation:e}, {now:e}"
            );
        }
    }
}
