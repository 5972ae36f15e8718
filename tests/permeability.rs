//! Air that passes fabric and rigid surfaces: exact single markers, momentum, both engines alike, checkpoints.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::cloth::{Structure, Triangle};
use ripstop::cpu::cloth::{Cloth, InitialHessian, MarkerReaction, SolverSettings, StepInput};
use ripstop::fabric::permeability::Permeability;
use ripstop::gpu::Device;
use ripstop::gpu::cloth::Cloth as DeviceCloth;
use ripstop::immersed::permeable::{Permeable, Resistance};
use ripstop::measure::{Record, results};
use ripstop::plan::Plan;
use ripstop::run::without_files;
use ripstop::simulation::Simulation;
use ripstop::statics::Statics;

use crate::engines::{Body, Engine, device, needs_device, on_every_engine, plain};
use crate::read_outs::latest;
use crate::resumed::{bits_of_nodes, taken_up};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    let mut trials = [
        plain("permeability::a_free_triangle_in_wind", free_triangle),
        on_every_engine("permeability::a_plate_that_air_passes", Plate),
        on_every_engine("permeability::a_sheet_that_air_passes", Sheet),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>();
    trials.push(needs_device(
        "permeability::reactions_on_a_device".to_owned(),
        || on_device(device().as_ref().unwrap()),
    ));
    trials
}

fn triangle() -> Structure {
    let rest = [
        DVec3::ZERO,
        DVec3::new(0.3, 0.9, 0.1),
        DVec3::new(0.2, 0.1, 1.1),
    ];
    let triangle = Triangle::laid_out([0, 1, 2], rest, DVec3::Y, [0.0; 2]).unwrap();
    Structure {
        positions_m: rest.to_vec(),
        masses_kg: vec![0.01, 0.02, 0.03],
        held: vec![false; 3],
        triangles: vec![triangle],
        thickness_m: 1e-4,
        permeability: Some(Permeability::from_point([124.5, 0.5])),
        ..Structure::default()
    }
}

fn pierced(resistance: Resistance) -> (Vec<MarkerReaction>, Vec<Permeable>) {
    let normal = DVec3::new(0.98, -0.31, -0.15).normalize();
    let markers = [[0.6, 0.3, 0.1], [0.2, 0.2, 0.6], [0.1, 0.7, 0.2]]
        .into_iter()
        .enumerate()
        .map(|(k, weights)| MarkerReaction {
            triangle: 0,
            weights,
            stiffness_kg_s: 0.4 + 0.3 * k as f64,
            air_velocity_m_s: DVec3::new(9.0 - 6.0 * k as f64, 2.0, -1.0),
            across: None,
        })
        .collect();
    let permeable = Permeable {
        normal: normal.to_array(),
        resistance,
    };
    (markers, vec![permeable; 3])
}

const RESISTANCES: [Resistance; 4] = [
    Resistance {
        viscous: 0.7,
        inertial: 0.0,
    },
    Resistance {
        viscous: 0.0,
        inertial: 0.3,
    },
    Resistance {
        viscous: 0.2,
        inertial: 5.0,
    },
    Resistance {
        viscous: 1e12,
        inertial: 0.0,
    },
];

fn settings(initial_hessian: InitialHessian) -> SolverSettings {
    SolverSettings {
        tolerance: 1e-9,
        displacement_floor_m: 0.0,
        evaluation_limit: 500,
        history: 5,
        refresh_every: None,
        initial_hessian,
    }
}

/// A triangle without elasticity, in three winds: the momentum of every node changes by what the air delivers, K (u* − V − v n), and v
/// obeys the law. Nothing passes where the resistance is huge.
fn free_triangle() {
    let dt = 2e-3;
    for resistance in RESISTANCES {
        let (markers, permeable) = pierced(resistance);
        let input = StepInput {
            time_step_s: Some(dt),
            markers: &markers,
            permeable: &permeable,
            ..StepInput::default()
        };
        let mut found = Vec::new();
        for kind in [InitialHessian::BlockJacobi, InitialHessian::Multigrid] {
            let mut cloth = Cloth::new(triangle());
            let outcome = cloth.solve_cloth(&input, &settings(kind));
            assert!(
                outcome.evaluations < 60,
                "{kind:?} {resistance:?} {outcome:?}"
            );
            let mut forces = [DVec3::ZERO; 3];
            for (marker, permeable) in markers.iter().zip(&permeable) {
                let own: DVec3 = (0..3)
                    .map(|i| cloth.velocities_m_s[i] * marker.weights[i])
                    .sum();
                let air = marker.air_velocity_m_s;
                let through = DVec3::from_array(permeable.through(own.to_array(), air.to_array()));
                let normal = DVec3::from_array(permeable.normal);
                let (v, w) = (through.dot(normal), (air - own).dot(normal));
                let law = v + resistance.viscous * v + resistance.inertial * v * v.abs();
                assert!((law - w).abs() < 1e-9 * w.abs().max(1.0));
                let force = (air - own - through) * marker.stiffness_kg_s;
                for (sum, weight) in forces.iter_mut().zip(marker.weights) {
                    *sum += force * weight;
                }
            }
            for (node, force) in forces.iter().enumerate() {
                let gain = cloth.velocities_m_s[node] * cloth.structure.masses_kg[node];
                let error = (gain - *force * dt).length() / (force.length() * dt);
                // The gradient is handed on in single precision.
                assert!(
                    error < 1e-5,
                    "{kind:?} {resistance:?} node {node}: {error:e}"
                );
            }
            found.push(cloth.velocities_m_s[0]);
        }
        assert!((found[0] - found[1]).length() < 1e-4 * found[0].length());
    }
    let (markers, permeable) = pierced(RESISTANCES[3]);
    let solved = |permeable: &[Permeable]| {
        let mut cloth = Cloth::new(triangle());
        let input = StepInput {
            time_step_s: Some(dt),
            markers: &markers,
            permeable,
            ..StepInput::default()
        };
        cloth.solve_cloth(&input, &settings(InitialHessian::BlockJacobi));
        cloth.velocities_m_s[1]
    };
    let difference = (solved(&permeable) - solved(&[])).length();
    assert!(difference < 1e-6, "{difference:e}");
}

/// The step of the same triangle on the device.
fn on_device(device: &Arc<Device>) {
    for resistance in RESISTANCES {
        let (markers, permeable) = pierced(resistance);
        let fixed: Vec<_> = markers.iter().map(|m| (m.triangle, m.weights)).collect();
        let input = StepInput {
            time_step_s: Some(2e-3),
            markers: &markers,
            permeable: &permeable,
            ..StepInput::default()
        };
        for kind in [InitialHessian::BlockJacobi, InitialHessian::Multigrid] {
            let settings = SolverSettings {
                tolerance: 1e-5,
                ..settings(kind)
            };
            let mut cloth = Cloth::new(triangle());
            let direction = [0.01, -0.02, 0.015].map(|x| DVec3::new(x, 0.3 * x, -x));
            let mut of_device = DeviceCloth::new(Arc::clone(device), &triangle(), &fixed).unwrap();
            let cpu = cloth.probe((&input, &settings), &direction, [0.7, 1e9]);
            let gpu = of_device
                .probe(&cloth, (&input, &settings), &direction, [0.7, 1e9])
                .unwrap();
            let off = |a: &[DVec3], b: &[DVec3]| {
                let largest = a.iter().map(|v| v.length()).fold(0.0, f64::max);
                let apart = a.iter().zip(b).map(|(a, b)| a.distance(*b));
                apart.fold(0.0, f64::max) / largest
            };
            let name = format!("{kind:?} {resistance:?}");
            let gradient = off(&cpu.gradient, &gpu.gradient);
            assert!(
                gradient < tolerances::device_cloth::GRADIENT,
                "{name} {gradient:e}"
            );
            let step = off(&cpu.preconditioned, &gpu.preconditioned);
            assert!(
                step < tolerances::device_cloth::MULTIGRID,
                "{name} {step:e}"
            );
            let objective = (cpu.attempt.objective - gpu.attempt.objective).abs();
            let scale = cpu.attempt.objective.abs() + cpu.start.objective.abs();
            assert!(
                objective < 1e-5 * scale,
                "{name} {objective:e} of {scale:e}"
            );
            cloth.solve_cloth(&input, &settings);
            let mut state = Cloth::new(triangle());
            of_device.solve(&mut state, &input, &settings).unwrap();
            let apart = off(&cloth.velocities_m_s, &state.velocities_m_s);
            assert!(apart < 1e-4, "{name} {apart:e}");
        }
    }
}

const PLATE: &str = r#"
version = 1
title = "Plate that air passes"
[air]
density_kg_m3 = 1.2
kinematic_viscosity_m2_s = 1.5e-5
[air.wind_tunnel]
speed_m_s = 6.0
size_m = [1.3, 1.0, 1.0]
start_time_s = 0.02
[resolution]
cell_size_m = 0.05
lattice_speed = 0.06
operator = "stabilised_regularised"
[bodies.plate]
position_m = [0.5, 0.5, 0.5]
plate.size_m = [0.35, 0.35]
permeability.measured = { pressures_pa = [124.5], air_speeds_m_s = [8.0] }
[coupling]
over_relaxation = 1.6
[time]
end_s = 0.1
[output]
sample_interval_s = 0.01
"#;

fn case(source: &str, changes: &[&str]) -> Case {
    let choices = Choices {
        variant: None,
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    case::parse("case", source, Path::new("."), &choices).unwrap()
}

fn simulate(case: &Case, engine: Engine) -> (Simulation, Record) {
    let plan = Plan::new(&case.scene, engine.plan_placement());
    without_files(case, plan, engine.device()).unwrap()
}

fn value(of: &(Simulation, Record), name: &str) -> f64 {
    results(&of.0, &Statics::default(), &of.1)
        .get(name)
        .unwrap()
        .value
        .unwrap()
}

#[derive(Clone, Copy)]
struct Plate;

impl Body for Plate {
    /// Momentum closes as without permeability; the mean pressure difference, drag over area, lies where the law has it at the mean
    /// velocity through the plate; the drag falls.
    fn run(self, engine: Engine) {
        let tight = simulate(
            &case(
                PLATE,
                &["bodies.plate.permeability.measured.air_speeds_m_s=[1e-3]"],
            ),
            engine,
        );
        let open = simulate(&case(PLATE, &[]), engine);
        for run in [&tight, &open] {
            assert!(value(run, "force_imbalance") < tolerances::momentum_closure(engine));
        }
        let drags = [&tight, &open].map(|run| value(run, "drag_coefficient"));
        assert!(drags[1] < 0.9 * drags[0], "{drags:?}");
        let area = open.0.scene().rigid_bodies[0].marker_surface.area_m2();
        let force = latest(&open.1, "force_x_n").or_else(|| latest(&open.1, "plate_force_x_n"));
        let pressure = force.unwrap() / area;
        let through = latest(&open.1, "through_velocity_m_s").unwrap();
        let law = Permeability::from_point([124.5, 8.0]);
        // The mean of the square is not the square of the mean: the pressure is not the same all over the plate.
        let ratio = law.pressure_pa(through.abs()) / pressure.abs();
        assert!((0.85..1.05).contains(&ratio), "{ratio} at {through} m/s");
        let of_slip = latest(&open.1, "through_velocity_of_slip_m_s").unwrap();
        assert!(
            of_slip / through > 0.0 && of_slip / through < 0.2,
            "{of_slip} {through}"
        );
    }
}

const SHEET: &str = r#"
version = 1
title = "Sheet that air passes"
[air]
density_kg_m3 = 1.2
kinematic_viscosity_m2_s = 1.5e-5
[air.wind_tunnel]
speed_m_s = 8.0
size_m = [1.4, 0.9, 1.1]
start_time_s = 0.01
[resolution]
cell_size_m = 0.05
lattice_speed = 0.06
operator = "stabilised_regularised"
[structure.sheet]
size_m = [0.4, 0.4]
divisions = [6, 6]
model = "membrane"
corner_m = [0.45, 0.45, 0.75]
hung_width_m = 0.4
[fabric]
thickness_m = 1e-4
density_kg_m3 = 500.0
youngs_modulus_pa = 4e7
poisson_ratio = 0.2
permeability.material = "mil_c_7020_type_3"
[coupling]
over_relaxation = 1.6
structure_every = 1
[solver]
tolerance = 1e-4
[time]
end_s = 0.02
"#;

#[derive(Clone, Copy)]
struct Sheet;

impl Body for Sheet {
    /// A sheet along the wind that starts to flutter: what the air gets is what the sheet felt, with permeability as without, so the
    /// momentum box and the markers agree. A run that stops halfway goes on with the same bits.
    fn run(self, engine: Engine) {
        let links = ["coupling.scheme=links", "coupling.over_relaxation=absent"];
        for changes in [&[][..], &links] {
            Self::goes_on(engine, changes);
        }
    }
}

impl Sheet {
    fn goes_on(engine: Engine, changes: &[&str]) {
        let case = case(SHEET, changes);
        let plan = || Plan::new(&case.scene, engine.plan_placement());
        let mut straight = Simulation::new(case.scene.clone(), plan(), engine.device()).unwrap();
        let start = straight.plan().start_steps;
        for _ in 0..start + 20 {
            straight.advance().unwrap();
        }
        let fresh = Simulation::new(case.scene.clone(), plan(), engine.device()).unwrap();
        let mut resumed = taken_up(&mut straight, fresh);
        let through = [&straight, &resumed].map(Simulation::through_velocities_m_s);
        assert_eq!(through[0], through[1]);
        for _ in 0..20 {
            straight.advance().unwrap();
            resumed.advance().unwrap();
        }
        assert_eq!(bits_of_nodes(&straight), bits_of_nodes(&resumed));
        assert_eq!(
            straight.through_velocities_m_s(),
            resumed.through_velocities_m_s()
        );
        let sample = straight.impulse_sample().unwrap().unwrap();
        let apart = (sample.momentum_box.unwrap() - sample.markers).length();
        let scale = sample.markers.length();
        assert!(
            apart < tolerances::momentum_closure(engine) * scale,
            "{apart:e} of {scale:e}"
        );
    }
}
