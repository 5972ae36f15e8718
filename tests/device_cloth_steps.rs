//! Whole steps and equilibria of fabric on a device against the same on the CPU: motion, supports, known answers, hostile starts.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::gather::Gather;
use ripstop::cpu::cloth::nodal_forces::{Pulls, elastic_gradient};
use ripstop::cpu::cloth::{
    Cloth, InitialHessian, Pressure, SolverSettings, StepInput, TriangleReaction,
};
use ripstop::fabric::Fabric;
use ripstop::geometry::cable;
use ripstop::geometry::sheet::FabricModel;
use ripstop::gpu::cloth::Cloth as DeviceCloth;
use ripstop::gpu::{Device, DeviceError};
use ripstop::lines::Cable;
use ripstop::measure::catenary;
use ripstop::solve::lbfgs::{Outcome, Stop};

use crate::device_cloth::{
    SETTINGS, farthest, in_batches, in_one_workgroup, markers, on, on_device, square,
};
use crate::sheets::{HOSTILE, fabric, hostile, noise};
use crate::tolerances::device_cloth as tolerance;

pub fn trials() -> Vec<Trial> {
    vec![
        on_device(
            "device_cloth_steps::one_step_with_markers",
            one_step_with_markers,
        ),
        on_device(
            "device_cloth_steps::one_step_of_triangles_that_cut_links",
            one_step_of_cut_triangles,
        ),
        on_device("device_cloth_steps::sheet_in_motion", sheet_in_motion),
        on_device("device_cloth_steps::supports_that_move", moved_supports),
        on_device("device_cloth_steps::catenary", hanging_cable),
        on_device("device_cloth_steps::hanging_sheet", hanging_sheet),
        on_device("device_cloth_steps::free_fall", free_fall),
        on_device("device_cloth_steps::hostile_starts", hostile_starts),
        in_batches("device_cloth_steps::device_drives", device_drives),
        in_one_workgroup("device_small_cloth::device_drives", device_drives),
        in_one_workgroup(
            "device_small_cloth::triangles_that_cut_links",
            one_step_of_cut_triangles,
        ),
        in_one_workgroup("device_small_cloth::same_bits_twice", same_bits_twice),
        on_device("device_cloth_steps::same_bits_twice", same_bits_twice),
        on_device(
            "device_cloth_steps::oversized_structures_are_refused",
            oversized,
        ),
    ]
}

/// A sheet held at two corners.
pub fn curtain(divisions: usize, model: FabricModel) -> Structure {
    let soft = Fabric {
        warp_modulus_pa: 5e6,
        weft_modulus_pa: 5e6,
        ..fabric(2e6, 1e-3)
    };
    let mut structure = square(divisions, model, &soft);
    structure.held[0] = true;
    structure.held[divisions] = true;
    for (i, p) in structure.positions_m.iter_mut().enumerate() {
        p.y += 0.01 * (i as f64 * 0.7).sin();
    }
    structure
}

/// Who decides between two evaluations on the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Driver {
    /// The L-BFGS of the host.
    Host,
    /// That of the device, where it has one: in time steps with block-Jacobi that is not built anew.
    Device,
}

pub const DRIVERS: [Driver; 2] = [Driver::Host, Driver::Device];

impl Driver {
    /// A solve of one step.
    pub fn solve(
        self,
        engine: &mut DeviceCloth,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Outcome {
        match self {
            Self::Host => engine.solve_watched(cloth, input, settings, &mut |_| true),
            Self::Device => engine.solve(cloth, input, settings),
        }
        .unwrap()
    }
}

/// Advances both engines by `steps` and returns them with the evaluations that each needed.
pub fn both(
    (device, driver): (&Arc<Device>, Driver),
    structure: Structure,
    input: &StepInput,
    settings: &SolverSettings,
    steps: usize,
) -> ([Cloth; 2], [usize; 2]) {
    let mut on_device = if input.cut_triangles.is_empty() {
        on(device, &structure, input.markers)
    } else {
        DeviceCloth::new_cut(Arc::clone(device), &structure).unwrap()
    };
    let mut cpu = Cloth::new(structure);
    let mut gpu = cpu.clone();
    let mut evaluations = [0; 2];
    for step in 0..steps {
        let a = cpu.solve_cloth(input, settings);
        let b = driver.solve(&mut on_device, &mut gpu, input, settings);
        assert_eq!(a.stop, Stop::Converged, "step {step}: {a:?}");
        assert_eq!(b.stop, Stop::Converged, "step {step}: {b:?}");
        evaluations[0] += a.evaluations;
        evaluations[1] += b.evaluations;
    }
    ([cpu, gpu], evaluations)
}

fn one_step_with_markers(device: &Arc<Device>) {
    let models = [FabricModel::Membrane, FabricModel::Network];
    for (model, driver) in models.into_iter().flat_map(|m| DRIVERS.map(|d| (m, d))) {
        let structure = curtain(16, model);
        let markers = markers(&structure, 1);
        let input = StepInput {
            time_step_s: Some(2e-3),
            gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
            damping_1_s: 1.0,
            markers: &markers,
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-5,
            ..SETTINGS
        };
        let start = structure.positions_m.clone();
        let ([cpu, gpu], evaluations) = both((device, driver), structure, &input, &settings, 1);
        let moved = farthest(&start, &cpu.positions_m);
        let error = farthest(&cpu.positions_m, &gpu.positions_m);
        assert!(
            error < tolerance::ONE_STEP * moved,
            "{error:e} of {moved:e}"
        );
        let error = farthest(&cpu.velocities_m_s, &gpu.velocities_m_s);
        assert!(error < tolerance::ONE_STEP * moved / 2e-3, "{error:e}");
        for held in [0, 16] {
            assert_eq!(gpu.positions_m[held], start[held]);
            assert_eq!(gpu.velocities_m_s[held], DVec3::ZERO);
        }
        assert!(evaluations[1] < 2 * evaluations[0] + 10, "{evaluations:?}");
    }
}

/// Reactions of the air at cuts in all directions: nine and a force on most triangles, none on every fifth.
fn cut_triangles(structure: &Structure) -> Vec<TriangleReaction> {
    let mut random = noise(7);
    let of = |triangle: u32| {
        let mut sum = TriangleReaction::none(triangle);
        for weights in [[0.6, 0.3, 0.1], [0.1, 0.2, 0.7], [0.3, 0.6, 0.1]] {
            for axis in DVec3::AXES {
                let direction = (axis + 0.3 * DVec3::new(random(), random(), random())).normalize();
                let stiffness_kg_s = 0.1 * (1.0 + 0.5 * random());
                let air_m_s = DVec3::new(0.2 * random(), 2.0 + random(), 0.1);
                let push_n = stiffness_kg_s * air_m_s.dot(direction);
                sum.add(weights, direction, [stiffness_kg_s, push_n]);
            }
        }
        sum.add_force([0.2, 0.5, 0.3], DVec3::new(1e-3 * random(), 0.0, 1e-3));
        sum
    };
    let all = 0..structure.triangles.len() as u32;
    all.filter(|triangle| triangle % 5 != 0).map(of).collect()
}

/// Fabric that cuts links of the lattice, whose air is stiffer than its inertia: an initial Hessian that left the cuts out would take many times the evaluations of the host.
fn one_step_of_cut_triangles(device: &Arc<Device>) {
    let kinds = [
        (InitialHessian::BlockJacobi, Driver::Host),
        (InitialHessian::BlockJacobi, Driver::Device),
        (InitialHessian::Multigrid, Driver::Host),
    ];
    for (initial_hessian, driver) in kinds {
        let step_s = 2e-3;
        let mut structure = curtain(16, FabricModel::Membrane);
        // In motion, so that what the air does depends on the velocities of the prediction.
        let place = |x: &DVec3| DVec3::new(0.0, 0.5 * (3.0 * x.x).sin(), 0.2 * x.x);
        structure.start_velocities_m_s = structure.positions_m.iter().map(place).collect();
        let reactions = cut_triangles(&structure);
        let input = StepInput {
            time_step_s: Some(step_s),
            gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
            cut_triangles: &reactions,
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-4,
            initial_hessian,
            ..SETTINGS
        };
        let start = structure.positions_m.clone();
        let ([cpu, gpu], evaluations) = both((device, driver), structure, &input, &settings, 1);
        let moved = farthest(&start, &cpu.positions_m);
        // It has nearly the speed of the air, which it would not have without.
        assert!(moved > step_s, "{moved:e}");
        let error = farthest(&cpu.positions_m, &gpu.positions_m) / moved;
        assert!(error < tolerance::CUT_STEP, "{initial_hessian:?} {error:e}");
        assert!(
            evaluations[1] < 2 * evaluations[0] + 10,
            "{initial_hessian:?} {evaluations:?}"
        );
    }
}

/// Fifty steps of a sheet that falls into its supports under a gust of pressure.
fn sheet_in_motion(device: &Arc<Device>) {
    let kinds = [
        (None, Driver::Host),
        (None, Driver::Device),
        (Some(2), Driver::Host),
    ];
    for (refresh_every, driver) in kinds {
        let structure = curtain(12, FabricModel::Membrane);
        let start = structure.positions_m.clone();
        let input = StepInput {
            time_step_s: Some(2e-3),
            gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
            pressure: Pressure::Uniform(2.0),
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-4,
            refresh_every,
            ..SETTINGS
        };
        let ([cpu, gpu], evaluations) = both((device, driver), structure, &input, &settings, 50);
        let moved = farthest(&start, &cpu.positions_m);
        let error = farthest(&cpu.positions_m, &gpu.positions_m);
        assert!(error < tolerance::MOTION * moved, "{error:e} of {moved:e}");
        assert!(2 * evaluations[1] < 3 * evaluations[0], "{evaluations:?}");
        let energies = [cpu.kinetic_energy_j(), gpu.kinetic_energy_j()];
        assert!(
            (energies[0] / energies[1] - 1.0).abs() < tolerance::MOTION,
            "{energies:?}"
        );
    }
}

/// As the static equilibrium of a case asks.
const STATIC: SolverSettings = SolverSettings {
    tolerance: 1e-3,
    displacement_floor_m: 0.0,
    evaluation_limit: 20_000,
    refresh_every: Some(10),
    initial_hessian: InitialHessian::Multigrid,
    ..SETTINGS
};

/// One corner of a curtain is led away, with markers in the wind and damping, which feel its speed.
fn moved_supports(device: &Arc<Device>) {
    let structure = curtain(12, FabricModel::Membrane);
    let start = structure.positions_m.clone();
    let markers = markers(&structure, 1);
    let mut on_device = on(device, &structure, &markers);
    let mut cpu = Cloth::new(structure);
    let mut gpu = cpu.clone();
    for step in 1..=5 {
        let place = start[0] + DVec3::new(-1e-3, 2e-3, 0.5e-3) * f64::from(step);
        let input = StepInput {
            time_step_s: Some(1e-3),
            damping_1_s: 3.0,
            markers: &markers,
            moved_supports: &[(0, place)],
            ..StepInput::default()
        };
        let settings = SolverSettings {
            tolerance: 1e-5,
            ..SETTINGS
        };
        let a = cpu.solve_cloth(&input, &settings);
        let b = on_device.solve(&mut gpu, &input, &settings).unwrap();
        assert_eq!(a.stop, Stop::Converged, "{a:?}");
        assert_eq!(b.stop, Stop::Converged, "{b:?}");
        let energy = (a.objective - b.objective).abs() / a.objective.abs();
        assert!(energy < tolerance::MOTION, "{energy:e}");
        assert_eq!(gpu.positions_m[0], place);
    }
    let moved = farthest(&start, &cpu.positions_m);
    let error = farthest(&cpu.positions_m, &gpu.positions_m);
    assert!(error < tolerance::MOTION * moved, "{error:e} of {moved:e}");
}

fn equilibrium(
    device: &Arc<Device>,
    structure: Structure,
    settings: &SolverSettings,
) -> (Cloth, Outcome) {
    let mut on_device = on(device, &structure, &[]);
    let mut cloth = Cloth::new(structure);
    let input = StepInput {
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        ..StepInput::default()
    };
    let outcome = on_device.solve(&mut cloth, &input, settings).unwrap();
    (cloth, outcome)
}

/// The gate of the CPU engine, C2, at the same tolerance of the gate.
fn hanging_cable(device: &Arc<Device>) {
    let rope = Cable::linear(1e-4, 1000.0, 1e8);
    let ends = [DVec3::new(0.0, 0.0, 1.0), DVec3::new(1.0, 0.0, 1.0)];
    // 2⁻²⁴ √(EA/T), with T the tension, is what forces in single precision can reach: 8e-6 here.
    let settings = SolverSettings {
        tolerance: 2e-5,
        evaluation_limit: 10_000,
        ..STATIC
    };
    let (cloth, outcome) = equilibrium(device, cable::build(ends, 1.2, 100, &rope), &settings);
    let exact = catenary::solve(1.0, 1.2, 0.1 * 9.81).unwrap();
    let lowest = cloth
        .positions_m
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    let sag = (1.0 - lowest) / exact.sag_m - 1.0;
    let tension = |k: usize| {
        let [a, b] = cloth.structure.cables[k]
            .nodes
            .map(|n| cloth.positions_m[n as usize]);
        (b - a).normalize() * cloth.cable_tension_n(k)
    };
    let horizontal = tension(50).x / exact.horizontal_tension_n - 1.0;
    let end = tension(0) - DVec3::Z * (0.5 * 0.1 * 9.81 * 0.012);
    let end = end.length() / exact.end_tension_n - 1.0;
    assert_eq!(outcome.stop, Stop::Converged, "{outcome:?}");
    for error in [sag, horizontal, end] {
        assert!(error.abs() < crate::tolerances::CATENARY, "{error:e}");
    }
}

fn hanging_sheet(device: &Arc<Device>) {
    for model in [FabricModel::Membrane, FabricModel::Network] {
        let (cloth, outcome) = equilibrium(device, curtain(8, model), &STATIC);
        assert_eq!(outcome.stop, Stop::Converged, "{model:?} {outcome:?}");
        let masses = &cloth.structure.masses_kg;
        let free: f64 = 9.81 * (masses.iter().sum::<f64>() - masses[0] - masses[8]);
        let mut gradient = vec![DVec3::ZERO; masses.len()];
        elastic_gradient(
            &cloth.structure,
            &Gather::new(&cloth.structure),
            &cloth.positions_m,
            &mut Pulls::default(),
            &mut gradient,
        );
        let carried = gradient[0] + gradient[8];
        assert!((carried.z / free - 1.0).abs() < 5e-3, "{carried} of {free}");
        assert!(cloth.velocities_m_s.iter().all(|v| *v == DVec3::ZERO));
    }
}

/// Implicit Euler falls exactly g t (t + dt)/2; single precision must not add up over the steps.
fn free_fall(device: &Arc<Device>) {
    let structure = square(3, FabricModel::Membrane, &fabric(3e6, 1e-3));
    let mut on_device = on(device, &structure, &[]);
    let mut cloth = Cloth::new(structure);
    let start = cloth.positions_m.clone();
    let (dt, steps) = (0.01, 20);
    let gravity_m_s2 = DVec3::new(0.0, 0.0, -9.81);
    let input = StepInput {
        time_step_s: Some(dt),
        gravity_m_s2,
        ..StepInput::default()
    };
    let settings = SolverSettings {
        tolerance: 1e-7,
        displacement_floor_m: 1e-12,
        evaluation_limit: 20_000,
        ..SETTINGS
    };
    for _ in 0..steps {
        let outcome = on_device.solve(&mut cloth, &input, &settings).unwrap();
        assert_eq!(outcome.stop, Stop::Converged, "{outcome:?}");
    }
    let t = f64::from(steps) * dt;
    let fallen = gravity_m_s2 * (0.5 * t * (t + dt));
    let error = cloth
        .positions_m
        .iter()
        .zip(&start)
        .map(|(x, x0)| x.distance(*x0 + fallen))
        .fold(0.0, f64::max);
    assert!(error < tolerance::FREE_FALL_M, "{error:e}");
}

/// Random, collapsed and inverted starts: finite, or refused.
fn hostile_starts(device: &Arc<Device>) {
    for modulus in [1e1, 1e5, 1e8] {
        let stiff = Fabric {
            warp_modulus_pa: modulus,
            weft_modulus_pa: modulus,
            ..fabric(0.4 * modulus, 1e-3)
        };
        for kind in HOSTILE {
            let mut structure = square(4, FabricModel::Membrane, &stiff);
            hostile(&mut structure, kind);
            let mut on_device = on(device, &structure, &[]);
            for time_step_s in [1e-5, 1e-3, 1e-1] {
                let input = StepInput {
                    time_step_s: Some(time_step_s),
                    gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
                    ..StepInput::default()
                };
                let settings = SolverSettings {
                    tolerance: 1e-2,
                    evaluation_limit: 200,
                    ..SETTINGS
                };
                for driver in DRIVERS {
                    let mut cloth = Cloth::new(structure.clone());
                    for _ in 0..2 {
                        let outcome = driver.solve(&mut on_device, &mut cloth, &input, &settings);
                        assert!(outcome.objective.is_finite(), "{driver:?} {outcome:?}");
                        assert!(outcome.evaluations <= 200 + 30, "{driver:?} {outcome:?}");
                        assert!(cloth.positions_m.iter().all(|p| p.is_finite()));
                        assert_eq!(cloth.positions_m[0], structure.positions_m[0]);
                    }
                }
            }
        }
    }
    for model in [FabricModel::Membrane, FabricModel::Network] {
        let kinds = [SETTINGS, STATIC];
        let bad = [f64::NAN, f64::INFINITY, 1e30];
        for (bad, settings) in bad.into_iter().flat_map(|b| kinds.map(|k| (b, k))) {
            let mut structure = square(2, model, &fabric(3e6, 1e-3));
            let mut on_device = on(device, &structure, &[]);
            structure.positions_m[4].y = bad;
            let mut cloth = Cloth::new(structure);
            for time_step_s in [None, Some(1e-3)] {
                let input = StepInput {
                    time_step_s,
                    ..StepInput::default()
                };
                let outcome = on_device.solve(&mut cloth, &input, &settings).unwrap();
                assert_eq!(outcome.stop, Stop::NotFinite, "{bad} {time_step_s:?}");
            }
        }
    }
}

/// The minimiser of the device beside that of the host, on the same device: where it ends, why, and after how many evaluations. The step is so long that
/// it takes several batches; with too few evaluations both are at their limit, and with a tolerance that nothing reaches both see round-off.
fn device_drives(device: &Arc<Device>) {
    let structure = curtain(10, FabricModel::Membrane);
    let input = StepInput {
        time_step_s: Some(2e-2),
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        pressure: Pressure::Uniform(2.0),
        ..StepInput::default()
    };
    let solved = |driver: Driver, tolerance: f64, evaluation_limit: usize| {
        let mut engine = on(device, &structure, &[]);
        let mut cloth = Cloth::new(structure.clone());
        let settings = SolverSettings {
            tolerance,
            evaluation_limit,
            ..SETTINGS
        };
        let outcome = driver.solve(&mut engine, &mut cloth, &input, &settings);
        (outcome, cloth)
    };
    let [(by_host, host), (by_device, on_device)] = DRIVERS.map(|d| solved(d, 1e-4, 20_000));
    assert_eq!([by_host.stop, by_device.stop], [Stop::Converged; 2]);
    assert!(by_host.evaluations > 80, "{by_host:?}");
    let ratio = by_device.evaluations as f64 / by_host.evaluations as f64;
    assert!((0.7..1.4).contains(&ratio), "{by_host:?} {by_device:?}");
    let moved = farthest(&structure.positions_m, &host.positions_m);
    let error = farthest(&host.positions_m, &on_device.positions_m);
    assert!(error < tolerance::MOTION * moved, "{error:e} of {moved:e}");
    let objectives = [by_host.objective, by_device.objective];
    let change = (objectives[0] - objectives[1]).abs();
    assert!(change < 1e-4 * objectives[0].abs(), "{objectives:?}");

    for outcome in DRIVERS.map(|d| solved(d, 1e-4, 9).0) {
        assert_eq!(outcome.stop, Stop::LimitReached, "{outcome:?}");
        assert!((9..=9 + 30).contains(&outcome.evaluations), "{outcome:?}");
        assert!(outcome.relative_norm > 1e-4, "{outcome:?}");
    }
    for outcome in DRIVERS.map(|d| solved(d, 0.0, 20_000).0) {
        let ends = [Stop::RoundOff, Stop::Converged];
        assert!(ends.contains(&outcome.stop), "{outcome:?}");
        assert!(outcome.relative_norm < 1e-4, "{outcome:?}");
    }
}

fn same_bits_twice(device: &Arc<Device>) {
    let structure = curtain(20, FabricModel::Membrane);
    let markers = markers(&structure, 1);
    let input = StepInput {
        time_step_s: Some(2e-3),
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        markers: &markers,
        ..StepInput::default()
    };
    let run = || {
        let mut on_device = on(device, &structure, &markers);
        let mut cloth = Cloth::new(structure.clone());
        let mut energy = 0;
        for _ in 0..5 {
            let outcome = on_device.solve(&mut cloth, &input, &SETTINGS).unwrap();
            energy = outcome.objective.to_bits();
        }
        let bits = |v: &DVec3| v.to_array().map(f64::to_bits);
        let positions: Vec<_> = cloth.positions_m.iter().map(bits).collect();
        (positions, energy)
    };
    assert!(run() == run());
    // Multigrid: a solve does not depend on those before it.
    let input = StepInput {
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        ..StepInput::default()
    };
    let mut on_device = on(device, &structure, &[]);
    let mut solve = || {
        let mut cloth = Cloth::new(structure.clone());
        on_device.solve(&mut cloth, &input, &STATIC).unwrap();
        cloth.positions_m
    };
    assert!(solve() == solve());
}

/// Something larger than a buffer may be is an error that says so, and nothing panics.
fn oversized(device: &Arc<Device>) {
    let limit = device.info().binding_limit_bytes;
    if limit > 1 << 30 {
        return;
    }
    let nodes = (limit / 24 + 1) as usize;
    let structure = Structure {
        positions_m: vec![DVec3::ZERO; nodes],
        masses_kg: vec![1.0; nodes],
        held: vec![false; nodes],
        ..Structure::default()
    };
    let refused = catch_unwind(AssertUnwindSafe(|| {
        DeviceCloth::new(Arc::clone(device), &structure, &[]).map(|_| ())
    }));
    assert!(matches!(refused, Ok(Err(DeviceError::Limit { .. }))));
}
