//! Boxes that fall with what they hold, and the drag of lines.

use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::scene::Carrier;
use ripstop::case::{self, Case, Choices};
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::line_drag::add_line_drags;
use ripstop::cpu::cloth::{Cloth, InitialHessian, SolverSettings, StepInput};
use ripstop::frame::CableKind;
use ripstop::lattice::Operator;
use ripstop::lattice::grid::{Setup, Sides, StreamwiseEnds};
use ripstop::lines::drag::LineDrag;
use ripstop::lines::{Cable, CableLaw};
use ripstop::measure::{self, Record};
use ripstop::plan::Plan;
use ripstop::run;
use ripstop::simulation::Simulation;
use ripstop::statics::Statics;

use crate::engines::{Body, Engine, on_every_engine, plain, states};
use crate::read_outs::{column, latest};
use crate::resumed::taken_up;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("descent::still_air_stays_still", StillAir),
        on_every_engine("descent::a_payload_under_a_canopy", Drop),
        plain("descent::bodies_below_a_payload", bodies_below),
        plain("descent::a_disk_at_terminal_speed", falling_disk),
        plain("descent::a_taut_line_in_wind", taut_line),
        plain("descent::an_inclined_line", inclined_line),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[derive(Clone, Copy)]
struct StillAir;

impl Body for StillAir {
    /// Seen from a box whose speed falls from 0.06 to 0.03 cells per step, still air has the speed of the box everywhere, at every step:
    /// to round-off in a box without ends, and between inlet and outlet but for what the inlet takes over from its neighbour.
    fn run(self, engine: Engine) {
        let ends = [
            (StreamwiseEnds::Periodic, tolerances::same_flow(engine)),
            (StreamwiseEnds::InletOutlet, tolerances::FALLING_BOX),
        ];
        for (ends, limit) in ends {
            let setup = Setup {
                cells: [32, 6, 6],
                ends,
                sides: Sides::FreeSlip,
                relaxation_time: 0.501,
                inlet_profile: None,
                sponge_cells: None,
                idle: None,
                operator: Operator::RecursiveRegularised,
                eddy_viscosity: None,
            };
            let mut speed: f64 = 0.06;
            let mut air = engine.air(setup, &|_| (0.0, [speed, 0.0, 0.0]));
            for step in 0..300 {
                let gain = -2e-4 * (f64::from(step) * 0.021).sin().max(0.0);
                speed += gain;
                air.set_inlet_velocity([speed, 0.0, 0.0]);
                air.collide_stream(Some([gain, 0.0, 0.0]), None).unwrap();
            }
            assert!(speed < 0.045, "{speed}");
            for (excess, u) in states(&air) {
                let off = (u[0] - speed).abs().max(u[1].abs()).max(u[2].abs());
                assert!(off < limit, "{ends:?}: {off:e} at {speed}");
                assert!(excess.abs() < 10.0 * limit, "{ends:?}: {excess:e}");
            }
        }
    }
}

/// A disk that falls until its drag is its weight: measured speed, that of its drag area and that of the last drag coefficient agree; a fall
/// that is cut short says that it has not settled.
fn falling_disk() {
    let fallen = |end_s: f64| {
        let source = format!(
            "version = 1\n[air]\ndensity_kg_m3 = 1.2\nkinematic_viscosity_m2_s = 0.01\n\
             [air.descent]\nrelease_speed_m_s = 1.2\nsize_m = [5.0, 4.0, 4.0]\nstart_time_s = 1.0\nsponge_length_m = 1.0\n\
             [gravity]\nacceleration_m_s2 = [-0.5, 0.0, 0.0]\n\
             [resolution]\ncells_per_diameter = 4.0\nreference_speed_m_s = 1.0\nlattice_speed = 0.1\noperator = \"recursive_regularised\"\n\
             [bodies.disk]\nposition_m = [2.0, 2.0, 2.0]\ndisk.diameter_m = 1.0\nmotion.free_fall.mass_kg = 1.2\n\
             [coupling]\nover_relaxation = 1.6\n[time]\nend_s = {end_s:?}\n[output]\nsample_interval_s = 0.25\n"
        );
        let case = case::parse("disk", &source, Path::new("."), &Choices::default()).unwrap();
        let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
        let (simulation, record) = run::without_files(&case, plan, None).unwrap();
        (
            measure::results(&simulation, &Statics::default(), &record),
            record,
            case,
        )
    };
    let (results, record, case) = fallen(34.0);
    assert_eq!(measure::unsettled_fall(&case.scene, &record), None);
    let found = |name: &str| results.get(name).unwrap();
    let value = |name: &str| found(name).value.unwrap();
    let speed = value("terminal_speed_m_s");
    let of_area = value("terminal_speed_of_drag_area_m_s");
    let apart = (speed / of_area - 1.0).abs();
    assert!(apart < tolerances::TERMINAL_SPEEDS, "{speed} {of_area}");
    assert!(found("terminal_speed_m_s").confidence.unwrap() < 0.01 * speed);
    let area_m2 = 0.25 * std::f64::consts::PI;
    // Weight over ½ ρ v² S.
    let balance = 1.2 * 0.5 / (0.5 * 1.2 * of_area * of_area * area_m2);
    let coefficient = value("drag_coefficient_terminal");
    assert!((coefficient / balance - 1.0).abs() < 1e-9);
    let present = latest(&record, "drag_coefficient_present").unwrap();
    let area = latest(&record, "drag_area_m2").unwrap();
    assert!((area / present / area_m2 - 1.0).abs() < 1e-9);
    assert!((present / coefficient - 1.0).abs() < 0.02, "{present}");
    assert!(results.get("riser_force_n").is_none() && latest(&record, "riser_force_n").is_none());
    let (results, record, case) = fallen(8.0);
    let why = measure::unsettled_fall(&case.scene, &record).unwrap();
    assert!(why.contains("not settled"), "{why}");
    let terminal = results.get("terminal_speed_m_s").unwrap();
    assert!(terminal.unresolved.clone().unwrap().contains("not settled"));
}

const TETHER: &str =
    "tether = { area_m2 = 4.42e-6, density_kg_m3 = 462.0, youngs_modulus_pa = 9.7e9 }";

/// The canopy of a case with a payload, and two bodies in a row below it.
fn drop_case() -> Case {
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: vec![
            "resolution.cells_per_diameter=10.0".to_owned(),
            "air.descent.start_time_s=0.01".to_owned(),
            "coupling.mass_factor=1.0".to_owned(),
            format!(
                "payload.bodies.lower={{ mass_kg = 0.2, hangs_from = \"upper\", tether_length_m = 0.2, {TETHER} }}"
            ),
            format!(
                "payload.bodies.upper={{ mass_kg = 0.4, drag_area_m2 = 0.01, tether_length_m = 0.3, {TETHER} }}"
            ),
        ],
    };
    let source = include_str!("../cases/finite-mass-drop.toml");
    case::parse("drop", source, Path::new("."), &choices).unwrap()
}

/// Bodies in a row below a payload: each is slowed by its tether, less its weight, the tether below it and its own drag, as Newton says.
fn bodies_below() {
    let case = drop_case();
    let descent = case.scene.descent.clone().unwrap();
    let [lower, upper] = ["lower", "upper"].map(|name| {
        let found = descent.bodies.iter().find(|body| body.name == name);
        found.unwrap().clone()
    });
    assert!((descent.all_masses_kg() - 2.6).abs() < 1e-12);
    let plan = Plan::new(&case.scene, Engine::CpuF64.plan_placement());
    let mut simulation = Simulation::new(case.scene.clone(), plan, None).unwrap();
    while !simulation.released() {
        simulation.advance().unwrap();
    }
    let state = |simulation: &Simulation| {
        let cloth = simulation.cloth().unwrap();
        [&lower, &upper].map(|body| {
            let cable = &cloth.structure.cables[body.tether];
            let [above, below] = cable.nodes.map(|n| cloth.positions_m[n as usize]);
            let tension_n = cloth
                .structure
                .cable_state(cable, above.distance(below))
                .tension_n;
            let mass_kg = cloth.structure.masses_kg[body.node as usize];
            let speed_m_s =
                simulation.wind_speed_m_s() - cloth.velocities_m_s[body.node as usize].x;
            [tension_n, mass_kg, speed_m_s, below.x - above.x]
        })
    };
    let start = state(&simulation);
    let (from_s, mut sums) = (simulation.time_s(), [0.0; 3]);
    let mut last_s = from_s;
    for _ in 0..200 {
        simulation.advance().unwrap();
        let dt = simulation.time_s() - last_s;
        last_s = simulation.time_s();
        let now = state(&simulation);
        sums[0] += dt * now[0][0];
        sums[1] += dt * now[1][0];
        // 0.01 m² of the upper one; the air comes with the speed of the box.
        sums[2] += dt
            * 0.5
            * case.scene.air.as_ref().unwrap().units.density_kg_m3
            * 0.01
            * now[1][2].powi(2);
    }
    let time_s = simulation.time_s() - from_s;
    let end = state(&simulation);
    let slowed_by = |k: usize| {
        let [[_, mass, before, _], [_, _, after, way]] = [start[k], end[k]];
        assert!(way < 0.0);
        mass * (9.81 * time_s - (after - before))
    };
    let [of_lower, of_upper] = [slowed_by(0), slowed_by(1)];
    assert!(sums[0] > 0.1, "{sums:?}");
    let error = sums[0] / of_lower - 1.0;
    assert!(error.abs() < tolerances::TETHERS, "{error:e}");
    let error = (sums[1] - sums[0] + sums[2]) / of_upper - 1.0;
    assert!(error.abs() < tolerances::TETHERS, "{error:e}");
}

#[derive(Clone, Copy)]
struct Drop;

impl Body for Drop {
    /// The three force routes agree in the accelerated box; the payload loses speed as it pulls the canopy; a resumed run has the same bits.
    fn run(self, engine: Engine) {
        let case = drop_case();
        let plan = || Plan::new(&case.scene, engine.plan_placement());
        let new = || Simulation::new(case.scene.clone(), plan(), engine.device()).unwrap();
        let mut straight = new();
        let mut record = Record::new(&straight);
        let start = straight.plan().start_steps;
        for _ in 0..start + 120 {
            straight.advance().unwrap();
        }
        record.add(&mut straight).unwrap();
        let mut resumed = taken_up(&mut straight, new());
        assert_eq!(straight.line_drag_n(), resumed.line_drag_n());
        for _ in 0..40 {
            straight.advance().unwrap();
            resumed.advance().unwrap();
        }
        record.add(&mut straight).unwrap();
        assert_eq!(straight.fall(), resumed.fall());
        assert_eq!(
            straight.cloth().unwrap().positions_m,
            resumed.cloth().unwrap().positions_m
        );
        let fall = straight.fall().unwrap();
        assert!(fall.fallen_m > 0.8 && fall.fallen_m < 1.4, "{fall:?}");
        let sample = straight.impulse_sample().unwrap().unwrap();
        let (markers, supports) = (sample.markers.x, sample.supports.unwrap().x);
        let momentum_box = sample.momentum_box.unwrap().x;
        assert!(markers > 0.0, "{markers}");
        for (route, impulse) in [("box", momentum_box), ("supports", supports)] {
            let off = (impulse / markers - 1.0).abs();
            assert!(
                off < tolerances::FORCE_IMBALANCE,
                "{route}: {impulse} of {markers}"
            );
        }
        // The payload stays within half a cell of its place while the box slows down: the box lags behind by 20 g times the square of 50 steps.
        let Carrier::Confluence { node, .. } = case.scene.descent.as_ref().unwrap().carrier else {
            panic!("a payload carries")
        };
        let confluence = straight.cloth().unwrap().positions_m[node as usize];
        assert!((confluence.x - 1.67).abs() < 0.05, "{confluence}");
        let factor = latest(&record, "load_factor_g").unwrap();
        assert!(factor.is_finite() && factor > -1.0, "{factor}");
        assert!(latest(&record, "line_drag_n").unwrap() > 0.0);
        let [present, area, riser_n, tension_n] = [
            "drag_coefficient_present",
            "drag_area_m2",
            "riser_force_n",
            "line_tension_mean_n",
        ]
        .map(|name| latest(&record, name).unwrap());
        assert!(
            (area / present / 0.78 - 1.0).abs() < 1e-9,
            "{area} {present}"
        );
        // Mean drag of the last 40 steps over the mean dynamic pressure at their ends.
        let [drags, speeds] = ["drag_coefficient", "descent_speed_m_s"].map(|n| column(&record, n));
        let mean_square = 0.5 * (speeds[0].powi(2) + speeds[1].powi(2));
        let expected = drags[1] * 25.0_f64.powi(2) / mean_square;
        assert!((present / expected - 1.0).abs() < 1e-9, "{present}");
        // Eight lines lean towards the payload.
        let leaning = riser_n / (8.0 * tension_n);
        assert!(leaning > 0.8 && leaning < 1.0, "{leaning}");
    }
}

fn line(kind: CableKind, nodes: usize, end: DVec3, stretch: f64) -> Structure {
    let cable = Cable {
        area_m2: 1e-6,
        density_kg_m3: 1000.0,
        law: CableLaw::Linear {
            axial_stiffness_n: 1e5,
        },
        damping_n_s: 0.0,
        breaking_load_n: None,
    };
    let positions_m: Vec<DVec3> = (0..nodes)
        .map(|i| end * (i as f64 / (nodes - 1) as f64))
        .collect();
    let rest = end.length() / (nodes - 1) as f64 / (1.0 + stretch);
    let mut structure = Structure {
        masses_kg: vec![0.0; nodes],
        held: (0..nodes).map(|i| i == 0 || i + 1 == nodes).collect(),
        positions_m,
        ..Structure::default()
    };
    let numbers: Vec<u32> = (0..nodes as u32).collect();
    structure.add_cable(&numbers, &vec![rest; nodes - 1], &cable, kind);
    structure.give_lines_drag(|_| LineDrag {
        coefficient: 1.1,
        diameter_m: 0.002,
    });
    structure
}

/// A line of 2 m across a wind of 20 m/s: the load ½ ρ C_d d u² per length, and the parabola f = w L²/(8 T) of a taut line under it.
fn taut_line() {
    let length = 2.0;
    let mut cloth = Cloth::new(line(CableKind::SuspensionLine, 41, DVec3::Z * length, 1e-3));
    let wind = DVec3::X * 20.0;
    let settings = SolverSettings {
        tolerance: 1e-8,
        displacement_floor_m: 1e-14,
        evaluation_limit: 5000,
        history: 10,
        refresh_every: None,
        initial_hessian: InitialHessian::BlockJacobi,
    };
    let mut drags = Vec::new();
    for _ in 0..60 {
        drags.clear();
        add_line_drags(
            &cloth.structure,
            &cloth.positions_m,
            &cloth.velocities_m_s,
            (1.2, |_| wind),
            &mut drags,
        );
        let input = StepInput {
            // Long steps: backward Euler leaves what is steady.
            time_step_s: Some(0.2),
            drags: &drags,
            ..StepInput::default()
        };
        cloth.solve_cloth(&input, &settings);
    }
    let load = 0.5 * 1.2 * 1.1 * 0.002 * 400.0;
    let force: DVec3 = drags
        .iter()
        .map(|drag| {
            let own = cloth.velocities_m_s[drag.node as usize];
            (drag.air_velocity_m_s - own) * drag.coefficient_kg_s
        })
        .sum();
    assert!((force.x / (load * length) - 1.0).abs() < 1e-3, "{force}");
    let sag = cloth.positions_m[20].x;
    let exact = load * length * length / (8.0 * cloth.cable_tension_n(20));
    assert!((sag / exact - 1.0).abs() < 2e-3, "{sag} {exact}");
}

/// Only the wind across an inclined line counts; belts have no drag.
fn inclined_line() {
    let end = DVec3::new(1.0, 0.0, 1.0);
    let wind = DVec3::X * 10.0;
    let total = |kind| {
        let structure = line(kind, 5, end, 0.0);
        let still = vec![DVec3::ZERO; 5];
        let mut drags = Vec::new();
        let places = structure.positions_m.clone();
        add_line_drags(&structure, &places, &still, (1.2, |_| wind), &mut drags);
        drags
            .iter()
            .map(|drag| drag.air_velocity_m_s * drag.coefficient_kg_s)
            .sum::<DVec3>()
    };
    let across = DVec3::new(5.0, 0.0, -5.0);
    let exact = across * (0.5 * 1.2 * 1.1 * 0.002 * end.length() * across.length());
    let found = total(CableKind::SuspensionLine);
    assert!((found - exact).length() < 1e-12, "{found} {exact}");
    assert_eq!(total(CableKind::Belt), DVec3::ZERO);
}
