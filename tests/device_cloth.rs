//! Fabric and cables on the device against the CPU engine in `f64`, kind by kind of element, one evaluation at a time; `device_cloth_steps` has whole steps.

use std::sync::Arc;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cloth::{Guide, Structure};
use ripstop::cpu::cloth::{
    Cloth, InitialHessian, MarkerReaction, Pressure, Probe, SolverSettings, StepInput,
};
use ripstop::fabric::Fabric;
use ripstop::frame::CableKind;
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};
use ripstop::gpu::cloth::Cloth as DeviceCloth;
use ripstop::gpu::{AdapterChoice, Device, Tuning};
use ripstop::lines::{Cable, CableLaw, ForceStrainTable};

use crate::device_cloth_steps::DRIVERS;
use crate::engines::{device, needs_device};
use crate::sheets::{fabric, noise, square_at};
use crate::tolerances::device_cloth as tolerance;

pub fn on_device(name: &str, body: fn(&Arc<Device>)) -> Trial {
    needs_device(name.to_owned(), move || {
        if let Ok(device) = device() {
            body(device);
        }
    })
}

/// The same on a device that solves time steps in one workgroup, whatever its kind.
pub fn in_one_workgroup(name: &str, body: fn(&Arc<Device>)) -> Trial {
    tuned(name, usize::MAX, body)
}

/// The same on a device that solves time steps in batches.
pub fn in_batches(name: &str, body: fn(&Arc<Device>)) -> Trial {
    tuned(name, 0, body)
}

fn tuned(name: &str, small_cloth_nodes: usize, body: fn(&Arc<Device>)) -> Trial {
    needs_device(name.to_owned(), move || {
        let tuning = Tuning {
            small_cloth_nodes: Some(small_cloth_nodes),
            ..Tuning::default()
        };
        if device().is_ok() {
            body(&Device::open_tuned(&AdapterChoice::Any, tuning).unwrap());
        }
    })
}

pub fn trials() -> Vec<Trial> {
    vec![
        on_device("device_cloth::every_kind_of_element", every_kind_of_element),
        in_batches("device_cloth::steps_of_every_kind", steps_of_every_kind),
        in_one_workgroup(
            "device_small_cloth::steps_of_kinds_together",
            steps_of_kinds_together,
        ),
        on_device("device_cloth::wrinkled_orthotropic_fabric", wrinkled_fabric),
        on_device(
            "device_cloth::small_strains_far_from_the_origin",
            small_strains,
        ),
        on_device("device_cloth::force_noise_of_a_large_sheet", force_noise),
        on_device("device_cloth::steps_are_clipped", clipped),
    ]
}

pub const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-3,
    displacement_floor_m: 1e-9,
    evaluation_limit: 2000,
    history: 8,
    refresh_every: None,
    initial_hessian: InitialHessian::BlockJacobi,
};

pub fn square(divisions: usize, model: FabricModel, fabric: &Fabric) -> Structure {
    square_at(DVec3::new(0.3, -0.2, 0.7), divisions, model, fabric)
}

fn scattered(count: usize, size: f64, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    (0..count)
        .map(|_| DVec3::new(random(), random(), random()) * size)
        .collect()
}

/// Two markers per triangle, in air that blows across.
pub fn markers(structure: &Structure, seed: u64) -> Vec<MarkerReaction> {
    let mut random = noise(seed);
    (0..structure.triangles.len() as u32)
        .flat_map(|triangle| [(triangle, [0.6, 0.3, 0.1]), (triangle, [0.2, 0.2, 0.6])])
        .map(|(triangle, weights)| MarkerReaction {
            triangle,
            weights,
            stiffness_kg_s: 0.02 * (1.0 + 0.5 * random()),
            air_velocity_m_s: DVec3::new(2.0 * random(), 15.0 + random(), random()),
            across: None,
        })
        .collect()
}

pub fn on(device: &Arc<Device>, structure: &Structure, markers: &[MarkerReaction]) -> DeviceCloth {
    let fixed: Vec<(u32, [f64; 3])> = markers.iter().map(|m| (m.triangle, m.weights)).collect();
    DeviceCloth::new(Arc::clone(device), structure, &fixed).unwrap()
}

fn largest(vectors: &[DVec3]) -> f64 {
    vectors.iter().map(|v| v.length()).fold(0.0, f64::max)
}

pub fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, f64::max)
}

/// The trial of both engines must agree; differences are measured against the largest of their kind.
pub fn compare(
    what: &str,
    cpu: &Probe,
    gpu: &Probe,
    position_scale: f64,
    [of_gradient, of_steps]: [f64; 2],
) {
    let gradient = farthest(&cpu.gradient, &gpu.gradient) / largest(&cpu.gradient);
    let step = farthest(&cpu.preconditioned, &gpu.preconditioned) / largest(&cpu.preconditioned);
    let position = farthest(&cpu.positions_m, &gpu.positions_m);
    let energy = (cpu.attempt.objective - gpu.attempt.objective).abs() / gpu.attempt.round_off;
    assert!(gradient < of_gradient, "{what}: gradient {gradient:e}");
    assert!(step < of_steps, "{what}: H0 g {step:e}");
    assert!(position < tolerance::POSITION_M, "{what}: {position:e}");
    // The device's own estimate of its round-off must hold.
    assert!(energy < 1.0, "{what}: energy {energy:e}");
    let g = cpu.gradient.iter().map(|g| g.length_squared()).sum::<f64>();
    let h = cpu
        .preconditioned
        .iter()
        .map(|h| h.length_squared())
        .sum::<f64>();
    let products = |p: &Probe| {
        let a = &p.attempt;
        [
            a.norm_square,
            a.gradient_change,
            a.change_square,
            a.stored[0][0],
            a.stored[0][1],
        ]
    };
    let scale = (g * h).sqrt();
    // Products of random vectors nearly cancel: errors count against the vectors' lengths.
    let along = (g * cpu.positions_m.len() as f64).sqrt() * position_scale;
    for (k, (a, b)) in products(cpu).into_iter().zip(products(gpu)).enumerate() {
        let error = (a - b).abs() / scale.max(a.abs());
        assert!(error < of_steps, "{what}: product {k}: {a:e} {b:e}");
    }
    let scalars = [
        (cpu.attempt.length, gpu.attempt.length, 0.0),
        (cpu.start.reference, gpu.start.reference, 0.0),
        (cpu.attempt.longest_m, gpu.attempt.longest_m, 0.0),
        (cpu.attempt.slope, gpu.attempt.slope, along),
        (cpu.attempt.slope_change, gpu.attempt.slope_change, along),
    ];
    for (k, (a, b, scale)) in scalars.into_iter().enumerate() {
        let allowed = of_steps * scale.max(a.abs());
        assert!((a - b).abs() <= allowed, "{what}: {k}: {a:e} {b:e}");
    }
}

fn probes(
    device: &Arc<Device>,
    structure: Structure,
    (input, kind): (&StepInput, InitialHessian),
    direction: &[DVec3],
    lengths: [f64; 2],
) -> (Probe, Probe) {
    let settings = SolverSettings {
        initial_hessian: kind,
        ..SETTINGS
    };
    let mut gpu = on(device, &structure, input.markers);
    let mut cpu = Cloth::new(structure);
    cpu.velocities_m_s = scattered(direction.len(), 3.0, 5);
    for (v, held) in cpu.velocities_m_s.iter_mut().zip(&cpu.structure.held) {
        if *held {
            *v = DVec3::ZERO;
        }
    }
    let of_device = gpu
        .probe(&cpu, (input, &settings), direction, lengths)
        .unwrap();
    (cpu.probe((input, &settings), direction, lengths), of_device)
}

/// Name of a structure of [`every_kind`], itself, and whether markers act on it.
type Kinds = (&'static str, Structure, bool);

/// Membrane, springs, bending, cables (taut and slack), guides, inertia, with markers or without: each alone, then together.
fn every_kind() -> Vec<Kinds> {
    let rope = Cable::linear(1e-6, 1000.0, 1e9);
    // A table of four pieces, reached at the second and beyond the last.
    let table = vec![[0.01, 5.0], [0.02, 25.0], [0.1, 40.0], [0.2, 300.0]];
    let damped = Cable {
        law: CableLaw::Table(ForceStrainTable::new(table).unwrap()),
        damping_n_s: 3.0,
        ..rope.clone()
    };
    type Change = fn(&mut Structure);
    let network: Change = |s| s.bendings.clear();
    let bending: Change = |s| s.springs.clear();
    let nothing: Change = |_| ();
    let bare: Change = |s| {
        s.springs.clear();
        s.bendings.clear();
    };
    let stiff: Change = |s| {
        let flat = s.positions_m.clone();
        let isotropic = [[1.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.35]];
        s.add_curvatures(&flat, DVec3::X, isotropic.map(|row| row.map(|d| 10.0 * d)));
    };
    let plate: Change = |s| {
        let flat = s.positions_m.clone();
        let isotropic = [[1.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.35]];
        s.add_curvatures(&flat, DVec3::X, isotropic);
        s.membrane = None;
    };
    let cases: [(&str, FabricModel, Change, bool, bool); 10] = [
        ("membrane", FabricModel::Membrane, nothing, false, false),
        ("springs", FabricModel::Network, network, false, false),
        ("bending", FabricModel::Network, bending, false, false),
        ("cables and guides", FabricModel::Network, bare, true, false),
        ("curvatures", FabricModel::Membrane, plate, false, false),
        ("markers", FabricModel::Network, bare, false, true),
        ("inertia", FabricModel::Network, bare, false, false),
        (
            "a stiff membrane",
            FabricModel::Membrane,
            stiff,
            false,
            false,
        ),
        (
            "all of a membrane",
            FabricModel::Membrane,
            nothing,
            true,
            true,
        ),
        (
            "all of a network",
            FabricModel::Network,
            nothing,
            true,
            true,
        ),
    ];
    let of_case = |(what, model, change, lines, air): (_, _, Change, _, _)| {
        let mut structure = square(12, model, &fabric(3e6, 1e-2));
        change(&mut structure);
        let count = structure.node_count();
        for (p, by) in structure
            .positions_m
            .iter_mut()
            .zip(scattered(count, 0.02, 7))
        {
            *p += by;
        }
        structure.held[4] = true;
        if lines {
            let kind = CableKind::Belt;
            structure.add_cable(&[0, 14, 28], &[0.1, 0.3], &rope, kind);
            // Stretched by a third and, where the mesh is flat, by little.
            structure.add_cable(&[40, 54, 55], &[0.09, 0.08], &damped, kind);
            structure.guides.push(Guide {
                node: 3,
                anchor_m: DVec3::new(0.1, 0.2, 0.3),
                stiffness_n_m: DVec3::new(1.0, 20.0, 3.0),
            });
        }
        (what, structure, air)
    };
    cases.into_iter().map(of_case).collect()
}

/// A load of everything.
fn loaded(time_step_s: Option<f64>, markers: &[MarkerReaction]) -> StepInput<'_> {
    StepInput {
        time_step_s,
        gravity_m_s2: DVec3::new(1.0, 2.0, -9.81),
        pressure: match time_step_s {
            Some(_) => Pressure::Uniform(30.0),
            None => Pressure::None,
        },
        damping_1_s: 2.0,
        markers,
        ..StepInput::default()
    }
}

/// Two steps of every kind of element: the minimiser of the device ends where that of the host does.
fn steps_of_every_kind(device: &Arc<Device>) {
    steps_of(device, every_kind());
}

/// The same of structures that hold several kinds, and of curvatures, which takes less time.
fn steps_of_kinds_together(device: &Arc<Device>) {
    let together = |(what, ..): &Kinds| what.starts_with("all") || *what == "curvatures";
    steps_of(device, every_kind().into_iter().filter(together).collect());
}

fn steps_of(device: &Arc<Device>, kinds: Vec<Kinds>) {
    for (what, structure, air) in kinds {
        let markers = if air {
            markers(&structure, 11)
        } else {
            Vec::new()
        };
        let input = loaded(Some(1e-3), &markers);
        let settings = SolverSettings {
            tolerance: 1e-5,
            ..SETTINGS
        };
        let [host, on_device] = DRIVERS.map(|driver| {
            let mut engine = on(device, &structure, &markers);
            let mut cloth = Cloth::new(structure.clone());
            for step in 0..2 {
                let outcome = driver.solve(&mut engine, &mut cloth, &input, &settings);
                assert!(
                    outcome.stop.reached(),
                    "{what} {driver:?} {step} {outcome:?}"
                );
            }
            cloth.positions_m
        });
        let moved = farthest(&structure.positions_m, &host);
        let error = farthest(&host, &on_device);
        assert!(
            error < tolerance::EVERY_KIND * moved,
            "{what}: {error:e} of {moved:e}"
        );
    }
}

/// Elements of every kind, damping and loads: one trial.
fn every_kind_of_element(device: &Arc<Device>) {
    for (what, structure, air) in every_kind() {
        let count = structure.node_count();
        for time_step_s in [Some(1e-3), None] {
            if time_step_s.is_none() && matches!(what, "markers" | "inertia") {
                continue;
            }
            let markers = if air {
                markers(&structure, 11)
            } else {
                Vec::new()
            };
            let input = loaded(time_step_s, &markers);
            let direction = scattered(count, 0.01, 9);
            for (kind, of_steps) in [
                (InitialHessian::BlockJacobi, tolerance::INITIAL_HESSIAN),
                (InitialHessian::Multigrid, tolerance::MULTIGRID),
            ] {
                // Cables that nothing holds: the whole matrix is singular, and its inverse is that of round-off.
                let singular = what == "cables and guides" && time_step_s.is_none();
                if singular && kind == InitialHessian::Multigrid {
                    continue;
                }
                let (cpu, gpu) = probes(
                    device,
                    structure.clone(),
                    (&input, kind),
                    &direction,
                    [0.7, 1e9],
                );
                let name = format!("{what}, dt {time_step_s:?}, {kind:?}");
                compare(&name, &cpu, &gpu, 0.01, [tolerance::GRADIENT, of_steps]);
                assert_eq!(gpu.gradient[4], DVec3::ZERO, "{name}");
                assert_eq!(gpu.preconditioned[4], DVec3::ZERO, "{name}");
            }
        }
    }
}

/// Random deformations from a hundredth to a third of an edge: taut, wrinkled and slack triangles of fabrics from soft to stiff in shear.
fn wrinkled_fabric(device: &Arc<Device>) {
    // α of 2ε₁₂ = τ/G + ατ³, at which the shear compliance has doubled at 1 % strain.
    let cubic = |shear: f64| 1e4 / (shear * shear * shear);
    let kinds = [5e5, 3e6, 4e7].map(|shear| (shear, None));
    for (shear, cubic) in kinds.into_iter().chain([(3e6, Some(cubic(3e6)))]) {
        for residual in [0.0, 1e-3] {
            for size in [1e-3, 1e-2, 3e-2] {
                let law = Fabric {
                    cubic_shear_compliance_1_pa3: cubic,
                    ..fabric(shear, residual)
                };
                let mut structure = square(12, FabricModel::Membrane, &law);
                let count = structure.node_count();
                let moves = scattered(count, size, (shear + size * 1e6) as u64);
                for (p, by) in structure.positions_m.iter_mut().zip(moves) {
                    *p += by;
                }
                let input = StepInput {
                    time_step_s: Some(1e-3),
                    ..StepInput::default()
                };
                let direction = scattered(count, 0.3 * size, 3);
                let block_jacobi = (&input, InitialHessian::BlockJacobi);
                let (cpu, gpu) = probes(device, structure, block_jacobi, &direction, [1.0, 1e9]);
                let name = format!("shear {shear:e} {cubic:?} residual {residual:e} size {size:e}");
                compare(
                    &name,
                    &cpu,
                    &gpu,
                    0.3 * size,
                    [tolerance::WRINKLED, tolerance::WRINKLED_HESSIAN],
                );
            }
        }
    }
}

/// Strains of 1e-6 on a stiff sheet hundreds of metres from the origin: single precision would see none of them.
fn small_strains(device: &Arc<Device>) {
    for model in [FabricModel::Membrane, FabricModel::Network] {
        let stiff = Fabric {
            warp_modulus_pa: 4e9,
            weft_modulus_pa: 4e9,
            ..fabric(1e9, 1.0)
        };
        let mut structure = square(20, model, &stiff);
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.1);
        for p in &mut structure.positions_m {
            let strained = DVec3::new(1.000_001 * p.x, 0.0, 1.000_000_5 * p.z + 1e-6 * p.x);
            *p = turn * strained + DVec3::new(300.0, -200.0, 500.0);
        }
        let still = vec![DVec3::ZERO; structure.node_count()];
        let mut gpu = on(device, &structure, &[]);
        let cpu = Cloth::new(structure);
        let input = StepInput::default();
        let of_device = gpu
            .probe(&cpu, (&input, &SETTINGS), &still, [1.0, 1e9])
            .unwrap();
        let exact = cpu.probe((&input, &SETTINGS), &still, [1.0, 1e9]);
        let error = farthest(&exact.gradient, &of_device.gradient) / largest(&exact.gradient);
        assert!(error < tolerance::SMALL_STRAIN, "{model:?} {error:e}");
    }
}

/// A patch of 10 mm mesh, 10 m from the origin, on a sphere of 10 m under the tension that carries 50 Pa: forces must not be noisier than
/// a hundredth of the nodal load, though they are differences of numbers hundreds of times larger.
fn force_noise(device: &Arc<Device>) {
    let ripstop = Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 533.77,
        warp_modulus_pa: 4.31e8,
        weft_modulus_pa: 4.31e8,
        poisson_ratio: 0.14,
        ..fabric(1e7, 1e-3)
    };
    let (divisions, spacing_m, pressure_pa) = (48, 0.01, 50.0);
    let load_n = pressure_pa * spacing_m * spacing_m;
    for (model, radius_m) in [
        (FabricModel::Membrane, f64::INFINITY),
        (FabricModel::Membrane, 10.0),
        (FabricModel::Network, 10.0),
    ] {
        let shape = SheetShape {
            size_m: [spacing_m * divisions as f64; 2],
            divisions: [divisions, divisions],
            corner_m: DVec3::ZERO,
            across: DVec3::X,
            down: -DVec3::Z,
        };
        let mut structure = sheet::build(&shape, &ripstop, model).unwrap();
        // Equal biaxial tension p R / 2, that of 10 m where the sheet is flat.
        let strain = 0.5 * pressure_pa * radius_m.min(10.0) * (1.0 - 0.14) / (4.31e8 * 1e-4);
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.1);
        for p in &mut structure.positions_m {
            let (x, z) = ((1.0 + strain) * p.x, (1.0 + strain) * p.z);
            let sagitta = 0.5 * (x * x + z * z) / radius_m;
            *p = turn * DVec3::new(x, sagitta, z) + DVec3::new(10.0, -10.0, 10.0);
        }
        let still = vec![DVec3::ZERO; structure.node_count()];
        let mut gpu = on(device, &structure, &[]);
        let cpu = Cloth::new(structure);
        let input = (&StepInput::default(), &SETTINGS);
        let of_device = gpu.probe(&cpu, input, &still, [1.0, 1e9]).unwrap();
        let exact = cpu.probe(input, &still, [1.0, 1e9]);
        let noise = farthest(&exact.gradient, &of_device.gradient) / load_n;
        // The same forces at positions in single precision.
        let mut rounded = cpu.clone();
        for p in &mut rounded.positions_m {
            *p = p.as_vec3().as_dvec3();
        }
        let single = rounded.probe(input, &still, [1.0, 1e9]);
        let single = farthest(&exact.gradient, &single.gradient) / load_n;
        assert!(noise < tolerance::FORCE_NOISE, "{model:?} {noise:e}");
        assert!(single > 1.0, "{model:?} {single:e}");
    }
}

fn clipped(device: &Arc<Device>) {
    let structure = square(12, FabricModel::Membrane, &fabric(3e6, 1e-2));
    let mut direction = scattered(structure.node_count(), 0.01, 9);
    direction[70] = DVec3::new(-30.0, 0.0, 40.0);
    let input = StepInput {
        time_step_s: Some(1e-2),
        ..StepInput::default()
    };
    let block_jacobi = (&input, InitialHessian::BlockJacobi);
    let (cpu, gpu) = probes(device, structure, block_jacobi, &direction, [0.5, 0.2]);
    assert!((gpu.attempt.length * 50.0 - 0.2).abs() < 1e-7);
    let error = farthest(&cpu.positions_m, &gpu.positions_m);
    assert!(error < 1e-7, "{error:e}");
}
