//! Multigrid on the device against the host: one cycle on the same matrix, then the whole initial Hessian, then equilibria.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use libtest_mimic::Trial;
use ripstop::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::geometry::sheet::FabricModel;
use ripstop::gpu::Device;
use ripstop::gpu::cloth::Cloth as DeviceCloth;
use ripstop::gpu::multigrid::Multigrid as DeviceMultigrid;
use ripstop::solve::lbfgs::Stop;
use ripstop::solve::multigrid::Multigrid;
use ripstop::solve::multigrid::blocks::{BlockMatrix, Pattern};
use ripstop::solve::multigrid::coarsening::Graph;
use ripstop::solve::multigrid::hierarchy::hierarchy;

use crate::device_cloth::{compare, farthest, markers, on, on_device, square};
use crate::device_cloth_steps::{Driver, both, curtain};
use crate::sheets::{fabric, noise};
use crate::tolerances::device_cloth as tolerance;

pub fn trials() -> Vec<Trial> {
    vec![
        on_device("device_cloth::multigrid_cycle_matches", cycle),
        on_device(
            "device_cloth::multigrid_without_coarse_levels",
            smoother_alone,
        ),
        on_device("device_cloth::equilibrium_matches", equilibrium),
        on_device("device_cloth::long_steps_with_multigrid", long_steps),
        on_device("device_cloth::pressure_follows", following_pressure),
        on_device("device_cloth::multigrid_is_absent_unless_asked_for", absent),
    ]
}

/// A grid of `n`² nodes, stretched along its edges; the first column is held, unless `held` says all.
fn grid(n: usize, all_held: bool) -> (Graph, BlockMatrix) {
    let node = |x: usize, y: usize| (x + n * y) as u32;
    let mut edges = Vec::new();
    for y in 0..n {
        for x in 0..n {
            if x + 1 < n {
                edges.push([node(x, y), node(x + 1, y)]);
            }
            if y + 1 < n {
                edges.push([node(x, y), node(x, y + 1)]);
            }
        }
    }
    let pattern = Pattern::from_groups(n * n, edges.iter().map(|e| &e[..]));
    let held = |node: usize| node.is_multiple_of(n);
    let mut matrix = BlockMatrix::new(pattern.clone());
    matrix.fill_rows(
        || (),
        |(), row, columns, blocks| {
            if held(row) {
                return;
            }
            let own = columns.binary_search(&(row as u32)).unwrap();
            for (place, &column) in columns.iter().enumerate() {
                let column = column as usize;
                if column == row {
                    continue;
                }
                // k nnᵀ + (1 − nnᵀ) along a direction that turns from edge to edge.
                let angle = 0.1 * (row + column) as f32;
                let n = [angle.cos(), angle.sin(), 0.3];
                for a in 0..3 {
                    for b in 0..3 {
                        let k = 30.0 * n[a] * n[b] + if a == b { 1.0 } else { 0.0 };
                        blocks[own][3 * a + b] += k;
                        if !held(column) {
                            blocks[place][3 * a + b] -= k;
                        }
                    }
                }
            }
        },
    );
    let fixed = (0..n * n).map(|node| all_held || held(node)).collect();
    (Graph::new(pattern, fixed, |_, _| 1.0), matrix)
}

/// Largest difference of one cycle, over its largest result, after one and after two refreshes.
fn cycle_error(device: &Arc<Device>, n: usize, all_held: bool) -> f64 {
    let (graph, matrix) = grid(n, all_held);
    let shapes = hierarchy(graph);
    let on_device = DeviceMultigrid::new(device, shapes).unwrap();
    let mut host = Multigrid::new(grid(n, all_held).0);
    let mut random = noise(7);
    let right: Vec<Vec3> = (0..n * n)
        .map(|_| DVec3::new(random(), random(), random()).as_vec3())
        .collect();
    let narrow: Vec<[f32; 3]> = right.iter().map(|v| v.to_array()).collect();
    let mut cycled = vec![Vec3::ZERO; right.len()];
    let mut worst: f64 = 0.0;
    for first in [true, false] {
        host.refresh(|fine| fine.clone_from(&matrix));
        on_device.set_matrix(device, &matrix, first).unwrap();
        host.apply(&right, &mut cycled);
        let expected: Vec<DVec3> = cycled.iter().map(|v| v.as_dvec3()).collect();
        let found: Vec<DVec3> = on_device
            .apply(device, &narrow)
            .unwrap()
            .iter()
            .map(|v| DVec3::from_array(v.map(f64::from)))
            .collect();
        let largest = expected.iter().map(|v| v.length()).fold(0.0, f64::max);
        assert!(largest > 0.0);
        worst = worst.max(farthest(&expected, &found) / largest);
        // A number that is none goes through, so that the minimiser stops at it.
        let mut broken = narrow.clone();
        broken[n + 1][0] = f32::NAN;
        let broken = on_device.apply(device, &broken).unwrap();
        assert!(broken.iter().flatten().any(|x| x.is_nan()));
        // What it left behind must not touch the next cycle.
        let zero = on_device
            .apply(device, &vec![[0.0; 3]; right.len()])
            .unwrap();
        assert!(zero.iter().flatten().all(|x| *x == 0.0));
    }
    worst
}

/// Coarsening to three levels, the last solved directly.
fn cycle(device: &Arc<Device>) {
    let levels = hierarchy(grid(40, false).0).len();
    assert!(levels >= 3, "{levels}");
    let error = cycle_error(device, 40, false);
    assert!(error < tolerance::cycle(device.info().kind), "{error:e}");
}

/// A mesh that does not coarsen, too large to be solved directly: the smoother alone.
fn smoother_alone(device: &Arc<Device>) {
    assert_eq!(hierarchy(grid(14, true).0).len(), 1);
    let error = cycle_error(device, 14, true);
    assert!(error < tolerance::cycle(device.info().kind), "{error:e}");
}

const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-3,
    displacement_floor_m: 0.0,
    evaluation_limit: 5000,
    history: 8,
    refresh_every: Some(10),
    initial_hessian: InitialHessian::Multigrid,
};

/// A sheet of 41² nodes held at its corners, under its weight and a load across: the same shape, and nearly the same number of evaluations.
fn equilibrium(device: &Arc<Device>) {
    let stiff = Fabric {
        residual_stiffness: 0.1,
        ..fabric(2e6, 0.1)
    };
    for model in [FabricModel::Membrane, FabricModel::Network] {
        let mut structure = square(40, model, &stiff);
        for corner in [0, 40, 40 * 41, 41 * 41 - 1] {
            structure.held[corner] = true;
        }
        let input = StepInput {
            // Its weight, and fifty times a light sheet's weight across: a dead load of 50 Pa.
            gravity_m_s2: DVec3::new(0.0, 1000.0, -9.81),
            ..StepInput::default()
        };
        let mut on_device = on(device, &structure, &[]);
        let start = structure.positions_m.clone();
        let mut cpu = Cloth::new(structure);
        let mut gpu = cpu.clone();
        let a = cpu.solve_cloth(&input, &SETTINGS);
        let b = on_device.solve(&mut gpu, &input, &SETTINGS).unwrap();
        let moved = farthest(&start, &cpu.positions_m);
        let error = farthest(&cpu.positions_m, &gpu.positions_m) / moved;
        assert_eq!(a.stop, Stop::Converged, "{model:?} {a:?}");
        assert_eq!(b.stop, Stop::Converged, "{model:?} {b:?}");
        assert!(error < tolerance::EQUILIBRIUM, "{model:?} {error:e}");
        assert!(
            2 * b.evaluations < 3 * a.evaluations,
            "{model:?} {} {}",
            a.evaluations,
            b.evaluations
        );
    }
}

/// Steps so long that stretching waves cross the sheet, with the air's markers on it: as on the host, in a fraction of block-Jacobi's evaluations.
fn long_steps(device: &Arc<Device>) {
    for model in [FabricModel::Membrane, FabricModel::Network] {
        let structure = curtain(16, model);
        let markers = markers(&structure, 5);
        let input = StepInput {
            time_step_s: Some(0.05),
            gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
            markers: &markers,
            ..StepInput::default()
        };
        let start = structure.positions_m.clone();
        let mut evaluations = [0; 2];
        let kinds = [InitialHessian::BlockJacobi, InitialHessian::Multigrid];
        for (kind, spent) in kinds.into_iter().zip(&mut evaluations) {
            let settings = SolverSettings {
                tolerance: 1e-5,
                initial_hessian: kind,
                ..SETTINGS
            };
            let ([cpu, gpu], [_, on_device]) = both(
                (device, Driver::Device),
                structure.clone(),
                &input,
                &settings,
                2,
            );
            *spent = on_device;
            let moved = farthest(&start, &cpu.positions_m);
            let error = farthest(&cpu.positions_m, &gpu.positions_m) / moved;
            assert!(
                error < tolerance::LONG_STEPS,
                "{model:?} {kind:?} {error:e}"
            );
        }
        let [jacobi, multigrid] = evaluations;
        assert!(2 * multigrid < jacobi, "{model:?} {evaluations:?}");
    }
}

/// Steps on block-Jacobi make nothing of multigrid; the first solve that asks for it does.
fn absent(device: &Arc<Device>) {
    let structure = curtain(12, FabricModel::Membrane);
    let mut on_device: DeviceCloth = on(device, &structure, &[]);
    let mut cloth = Cloth::new(structure);
    let input = StepInput {
        time_step_s: Some(1e-3),
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        ..StepInput::default()
    };
    for kind in [InitialHessian::BlockJacobi, InitialHessian::Multigrid] {
        let settings = SolverSettings {
            initial_hessian: kind,
            ..SETTINGS
        };
        let outcome = on_device.solve(&mut cloth, &input, &settings).unwrap();
        assert_eq!(outcome.stop, Stop::Converged, "{kind:?} {outcome:?}");
        let asked = kind == InitialHessian::Multigrid;
        assert_eq!(on_device.multigrid_traffic().is_some(), asked);
    }
}

/// A square sheet held along its rim under 2 kPa, which bulges it by a tenth of its side; far from the origin.
fn following_pressure(device: &Arc<Device>) {
    let n = 20;
    let mut structure = square(n, FabricModel::Membrane, &fabric(8e6, 0.1));
    for node in 0..(n + 1) * (n + 1) {
        let (x, y) = (node % (n + 1), node / (n + 1));
        structure.held[node] = x == 0 || y == 0 || x == n || y == n;
        // Taut from the start: without strain, round-off would say whether it wrinkles.
        let place = 1.01 * structure.positions_m[node];
        structure.positions_m[node] = place + DVec3::new(300.0, -200.0, 100.0);
    }
    let input = StepInput {
        pressure: Pressure::Uniform(2e3),
        ..StepInput::default()
    };
    let mut on_device = on(device, &structure, &[]);
    let mut cpu = Cloth::new(structure.clone());
    let mut random = noise(3);
    let direction: Vec<DVec3> = (0..structure.node_count())
        .map(|_| DVec3::new(random(), 1.0 + random(), random()) * 0.02)
        .collect();
    for initial_hessian in [InitialHessian::BlockJacobi, InitialHessian::Multigrid] {
        let settings = SolverSettings {
            initial_hessian,
            ..SETTINGS
        };
        let orders = (&input, &settings);
        let exact = cpu.probe(orders, &direction, [1.0, 1e9]);
        let found = on_device
            .probe(&cpu, orders, &direction, [1.0, 1e9])
            .unwrap();
        let name = format!("following pressure, {initial_hessian:?}");
        let allowed = [tolerance::GRADIENT, tolerance::MULTIGRID];
        compare(&name, &exact, &found, 0.02, allowed);
    }
    let mut gpu = cpu.clone();
    let a = cpu.solve_cloth(&input, &SETTINGS);
    let b = on_device.solve(&mut gpu, &input, &SETTINGS).unwrap();
    assert_eq!(a.stop, Stop::Converged, "{a:?}");
    assert_eq!(b.stop, Stop::Converged, "{b:?}");
    let moved = farthest(&structure.positions_m, &cpu.positions_m);
    assert!(moved > 0.05, "{moved}");
    let error = farthest(&cpu.positions_m, &gpu.positions_m) / moved;
    assert!(error < tolerance::EQUILIBRIUM, "{error:e}");
    // An edge that moves is refused, with its node.
    structure.held[n / 2] = false;
    let mut open = Cloth::new(structure.clone());
    let refused = on(device, &structure, &[]).solve(&mut open, &input, &SETTINGS);
    let message = refused.unwrap_err().to_string();
    assert!(message.contains(&format!("node {}", n / 2)), "{message}");
}
