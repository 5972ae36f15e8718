//! The device engine against the CPU engine, stage by stage.

use libtest_mimic::Trial;
use ripstop::gpu::{AdapterChoice, Device, DeviceError};
use ripstop::lattice::Operator;
use ripstop::lattice::control_volume::ControlVolume;
use ripstop::lattice::eddy_viscosity::{EddyViscosity, EddyViscosityModel};
use ripstop::lattice::grid::{Faces, InletProfile, Setup, Sides, StreamwiseEnds, Wall};
use ripstop::plan::{AirPlacement, ClothPlacement, Placement, Plan, Precision, Storage};
use ripstop::run::without_files;
use ripstop::simulation::{AirEngine, Balance, Failure, MarkerEngine, Simulation};

use crate::canopy::small_case;
use crate::coupling::exchange;
use crate::engines::{Engine, needs_device, states};
use crate::read_outs::latest;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    let bodies = [
        ("collide_stream_matches", collide_stream as fn()),
        ("balance_of_a_box_matches", balance),
        ("breakdown_is_found_where_it_is", breakdown),
        ("interpolate_and_spread_match", immersed),
        ("first_steps_of_the_canopy_match", first_steps),
        ("canopy_ends_as_on_the_cpu", canopy),
        ("same_bits_twice", same_bits),
        ("a_lost_device_is_reported", lost),
        ("a_grid_beyond_the_limits_is_refused", too_large),
    ];
    bodies
        .into_iter()
        .map(|(name, body)| needs_device(format!("device::{name}"), body))
        .collect()
}

/// A rough start: all moments vary from cell to cell.
fn rough([x, y, z]: [usize; 3]) -> (f64, [f64; 3]) {
    let phase = (3 * x + 5 * y + 7 * z) as f64;
    (
        0.01 * phase.sin(),
        [
            0.05 + 0.02 * phase.cos(),
            0.03 * (2.0 * phase).sin(),
            -0.02 * (0.5 * phase).cos(),
        ],
    )
}

fn setups() -> Vec<Setup> {
    let mut setups = Vec::new();
    let lid = Wall::NoSlip {
        velocity: [0.0, 0.05, 0.0],
    };
    for (of_operator, operator) in Operator::ALL.into_iter().enumerate() {
        for (of_model, eddy_viscosity) in [
            None,
            Some(EddyViscosity::smagorinsky(0.15)),
            Some(EddyViscosity::wale(0.5)),
            Some(EddyViscosity::vreman(0.07)),
        ]
        .into_iter()
        .enumerate()
        {
            // Set-ups are shaders of their own, which a software device compiles for long. Collisions take Vreman's viscosity from the same stage as that of WALE.
            let vreman = eddy_viscosity.is_some_and(|e| e.model == EddyViscosityModel::Vreman);
            if vreman && operator != Operator::StabilisedRegularised {
                continue;
            }
            for (of_faces, (ends, sides, sponge_cells)) in [
                (StreamwiseEnds::Periodic, Sides::Periodic, None),
                (StreamwiseEnds::Periodic, Sides::FreeSlip, None),
                (StreamwiseEnds::InletOutlet, Sides::FreeSlip, Some(5.0)),
                (StreamwiseEnds::InletOutlet, Sides::Periodic, None),
                (
                    StreamwiseEnds::InletOutlet,
                    Sides::Each([
                        Faces::Walls([Wall::Absorbing; 2]),
                        Faces::Walls([Wall::FreeSlip, Wall::Absorbing]),
                    ]),
                    Some(5.0),
                ),
                // Walls, with all kinds of edges and corners; one moves.
                (
                    StreamwiseEnds::Walls([lid, Wall::AT_REST]),
                    Sides::Each([
                        Faces::Walls([Wall::FreeSlip, Wall::AT_REST]),
                        Faces::Walls([lid, Wall::FreeSlip]),
                    ]),
                    None,
                ),
                (
                    StreamwiseEnds::InletOutlet,
                    Sides::Each([Faces::Walls([Wall::AT_REST; 2]), Faces::Periodic]),
                    Some(5.0),
                ),
            ]
            .into_iter()
            .enumerate()
            {
                // A third of all has every pair of operator, faces and the first three models.
                if (of_operator + of_model + of_faces) % 3 != 0 {
                    continue;
                }
                let cells = [19, 12, 11];
                let profiled = ends == StreamwiseEnds::InletOutlet
                    && operator == Operator::StabilisedRegularised;
                setups.push(Setup {
                    cells,
                    ends,
                    inlet_profile: profiled
                        .then(|| InletProfile::new(cells, |y, z| 0.5 + 0.04 * (y + 2 * z) as f64)),
                    sides,
                    relaxation_time: 0.52,
                    sponge_cells,
                    idle: None,
                    operator,
                    eddy_viscosity,
                });
            }
        }
    }
    setups
}

/// Largest difference of density excess and velocity of two airs.
fn difference(a: &AirEngine, b: &AirEngine) -> f64 {
    states(a)
        .iter()
        .zip(states(b))
        .map(|((p, u), (q, v))| {
            (0..3)
                .map(|k| (u[k] - v[k]).abs())
                .fold((p - q).abs(), f64::max)
        })
        // A NaN must not pass for zero.
        .fold(
            0.0,
            |worst: f64, d| if d > worst || d.is_nan() { d } else { worst },
        )
}

/// Operators, eddy viscosity, boundaries, sponge, with and without a uniform acceleration.
fn collide_stream() {
    for setup in setups() {
        let mut pair = [Engine::CpuF32, Engine::Gpu].map(|e| e.air(setup.clone(), &rough));
        for acceleration in [None, Some([1e-4, -2e-4, 5e-5])] {
            for air in &mut pair {
                air.set_inlet_velocity([0.05, 0.01, 0.0]);
                for _ in 0..10 {
                    air.collide_stream(acceleration, None).unwrap();
                }
            }
            let worst = difference(&pair[0], &pair[1]);
            assert!(
                worst < tolerances::DEVICE_AIR,
                "{setup:?}, {acceleration:?}: {worst:e}"
            );
        }
    }
}

fn balance() {
    let mut setup = setups().remove(0);
    setup.cells = [21, 18, 17];
    let mut results = Vec::new();
    for engine in [Engine::CpuF32, Engine::Gpu] {
        let mut air = engine.air(setup.clone(), &rough);
        let volume = ControlVolume::new(&air.grid(), [4, 3, 5], [15, 14, 13]);
        let mut balance = Balance::new(&air, volume.clone()).unwrap();
        // More steps than wait on the device, so that the ring goes round.
        for _ in 0..150 {
            air.collide_stream(None, None).unwrap();
            balance.add_step(&air).unwrap();
        }
        let out = balance.outflow(&air).unwrap();
        let stored = air.storage(&volume).unwrap();
        let (mass, energy) = air.mass_and_energy().unwrap();
        results.push([
            out.mass_excess,
            out.momentum[0],
            out.momentum[1],
            out.momentum[2],
            stored.mass_excess,
            stored.momentum[0],
            stored.momentum[1],
            stored.momentum[2],
            mass,
            energy,
        ]);
    }
    for (k, (a, b)) in results[0].iter().zip(&results[1]).enumerate() {
        assert!(
            (a - b).abs() < tolerances::DEVICE_BALANCE,
            "{k}: {a} against {b}"
        );
    }
}

fn breakdown() {
    let fast = [13, 5, 7];
    let wild = move |cell: [usize; 3]| {
        if cell == fast {
            (0.0, [0.5, 0.0, 0.0])
        } else {
            (0.0, [0.02; 3])
        }
    };
    let hollow = move |cell: [usize; 3]| {
        if cell == fast {
            (f64::NAN, [0.0; 3])
        } else {
            (0.0, [0.02; 3])
        }
    };
    let setup = setups().remove(0);
    let sound = Engine::Gpu.air(setup.clone(), &rough);
    assert_eq!(sound.breakdown(0.4).unwrap(), None);
    for engine in [Engine::CpuF32, Engine::CpuF64, Engine::Gpu] {
        stand_out(engine, setup.clone());
        let found = |state: &ripstop::lattice::grid::Initial| {
            engine
                .air(setup.clone(), state)
                .breakdown(0.4)
                .unwrap()
                .unwrap()
        };
        let too_fast = found(&wild);
        assert_eq!(too_fast.cell, fast);
        assert!((too_fast.speed - 0.5).abs() < 1e-6);
        let not_finite = found(&hollow);
        assert_eq!(not_finite.cell, fast);
        assert!(not_finite.density_excess.is_nan());
    }
}

/// What stands out in a box is what the states of all cells say.
fn stand_out(engine: Engine, setup: Setup) {
    let cells = setup.cells;
    let mut air = engine.air(setup, &rough);
    // In both parities.
    for _ in 0..2 {
        let states = air.macroscopic().unwrap();
        for (first, end) in [([0; 3], cells), ([3, 1, 2], cells.map(|n| n - 1))] {
            let found = air.extremes(first, end).unwrap().unwrap();
            let inside = |i: &usize| {
                let cell = [
                    i % cells[0],
                    i / cells[0] % cells[1],
                    i / cells[0] / cells[1],
                ];
                (0..3).all(|a| (first[a]..end[a]).contains(&cell[a]))
            };
            let speed = |i: usize| {
                let square: f32 = states[i].1.iter().map(|u| u * u).sum();
                f64::from(square).sqrt()
            };
            let most = |of: &dyn Fn(usize) -> f64| {
                let all = (0..states.len()).filter(inside);
                all.map(of).fold(0.0, f64::max)
            };
            let number = |[x, y, z]: [usize; 3]| x + cells[0] * (y + cells[1] * z);
            let fastest = found.fastest.unwrap();
            let excess = |i: usize| f64::from(states[i].0.abs());
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{engine:?} {a} {b}");
            close(fastest.speed, most(&speed));
            close(fastest.speed, speed(number(fastest.cell)));
            close(found.farthest.density_excess.abs(), most(&excess));
            close(
                found.farthest.density_excess,
                states[number(found.farthest.cell)].0.into(),
            );
            assert!(inside(&number(fastest.cell)) && inside(&number(found.farthest.cell)));
        }
        assert!(air.extremes([2; 3], [2; 3]).unwrap().is_none());
        air.collide_stream(None, None).unwrap();
    }
}

/// A crumpled sheet, several layers under one kernel, held in rough air for ten exchanges.
fn immersed() {
    let setup = Setup {
        cells: [24, 22, 20],
        ..setups().remove(5)
    };
    let positions: Vec<[f64; 3]> = (0..600)
        .map(|k| {
            let t = f64::from(k) * 0.37;
            [
                10.0 + 4.0 * t.sin(),
                10.0 + 5.0 * (1.7 * t).cos(),
                6.0 + 0.012 * t,
            ]
        })
        .collect();
    let velocities: Vec<[f64; 3]> = positions
        .iter()
        .map(|p| p.map(|x| 0.01 * (3.0 * x).sin()))
        .collect();
    let mut results = Vec::new();
    for engine in [Engine::CpuF32, Engine::Gpu] {
        let mut air = engine.air(setup.clone(), &rough);
        let mut markers = MarkerEngine::new(&air, vec![0.7; positions.len()], 1.6).unwrap();
        let mut totals = Vec::new();
        for _ in 0..10 {
            totals.push(exchange(&air, &mut markers, &positions, &velocities));
            air.collide_stream(None, Some(&markers)).unwrap();
        }
        results.push((air, markers, totals));
    }
    let [(cpu_air, cpu, cpu_totals), (gpu_air, gpu, gpu_totals)] =
        <[_; 2]>::try_from(results).unwrap();
    for k in 0..positions.len() {
        let ratio = gpu.stiffness(k) / cpu.stiffness(k);
        assert!(
            (ratio - 1.0).abs() < tolerances::DEVICE_WEIGHTS,
            "strength of {k}: {ratio}"
        );
        for a in 0..3 {
            let off = (gpu.air_velocities()[k][a] - cpu.air_velocities()[k][a]).abs();
            assert!(off < tolerances::DEVICE_AIR, "u* of {k}: {off:e}");
        }
    }
    let slips = [&cpu, &gpu].map(|m| m.slip(&velocities).unwrap());
    assert!(
        (slips[1] - slips[0]).abs() < tolerances::DEVICE_AIR,
        "{slips:?}"
    );
    for (a, b) in cpu_totals.iter().flatten().zip(gpu_totals.iter().flatten()) {
        assert!(
            (a - b).abs() < tolerances::DEVICE_AIR * positions.len() as f64,
            "{a} against {b}"
        );
    }
    let worst = difference(&cpu_air, &gpu_air);
    assert!(worst < tolerances::DEVICE_AIR, "{worst:e}");
}

fn placed(air: AirPlacement, cloth: ClothPlacement) -> Placement {
    Placement {
        air,
        cloth,
        device: Some("test device".to_owned()),
        shared_memory: true,
    }
}

/// Coupled steps of the folded canopy from its release: the sheet is where the CPU engine puts it. Fifty through a kernel; at cut links five, for what rounding changes there grows faster:
/// after fifty, engines and precisions lie a quarter of a cell apart. After ten the impulse passes through zero.
fn first_steps() {
    first_steps_by("kernel", ("0.0111", 50), tolerances::DEVICE_CANOPY_IMPULSE);
    first_steps_by("links", ("0.0011", 5), tolerances::DEVICE_LINKS_IMPULSE);
}

fn first_steps_by(scheme: &str, (end_s, least): (&str, u64), of_impulse: f64) {
    let [end, interval] = ["time.end_s", "output.sample_interval_s"];
    let changes = [
        format!("{end}={end_s}"),
        format!("{interval}={end_s}"),
        format!("coupling.scheme={scheme}"),
    ];
    let case = small_case(&changes.each_ref().map(String::as_str));
    let run = |placement: Placement| {
        let plan = Plan::new(&case.scene, placement);
        assert!(plan.steps >= least, "{}", plan.steps);
        let device = Engine::Gpu.device();
        without_files(&case, plan, device).unwrap()
    };
    let (cpu, cpu_record) = run(Precision::F32.into());
    let cell = case.scene.air.as_ref().unwrap().units.cell_size_m;
    let kind = Engine::Gpu.device().unwrap().info().kind;
    for cloth in [ClothPlacement::Host, ClothPlacement::Device] {
        let (gpu, gpu_record) = run(placed(AirPlacement::Gpu(Storage::F32), cloth));
        let (a, b) = (cpu.cloth().unwrap(), gpu.cloth().unwrap());
        let farthest = a
            .positions_m
            .iter()
            .zip(&b.positions_m)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f64::max);
        let cells = farthest / cell;
        assert!(
            cells < tolerances::device_canopy_cells(kind),
            "{scheme}, {cloth:?}: {cells:e} cells"
        );
        let impulse = |record| latest(record, "impulse_markers_n_s");
        let ratio = impulse(&gpu_record).unwrap() / impulse(&cpu_record).unwrap();
        assert!(
            (ratio - 1.0).abs() < of_impulse,
            "{scheme}, {cloth:?}: {ratio}"
        );
    }
}

/// The opening, coarse: drag and diameter end where the CPU's do, although the wake is chaotic.
fn canopy() {
    let case = small_case(&["time.end_s=0.1"]);
    let run = |placement: Placement| {
        let plan = Plan::new(&case.scene, placement);
        let (_, record) = without_files(&case, plan, Engine::Gpu.device()).unwrap();
        [
            latest(&record, "projected_diameter_ratio").unwrap(),
            latest(&record, "impulse_markers_n_s").unwrap(),
        ]
    };
    let cpu = run(Precision::F32.into());
    let gpu = run(placed(
        AirPlacement::Gpu(Storage::F32),
        ClothPlacement::Host,
    ));
    for (a, b) in cpu.iter().zip(gpu) {
        assert!(
            (b / a - 1.0).abs() < tolerances::DEVICE_OPENING,
            "{cpu:?} against {gpu:?}"
        );
    }
}

fn same_bits() {
    let case = small_case(&["time.end_s=0.004", "output.sample_interval_s=0.004"]);
    let bits = || {
        let plan = Plan::new(
            &case.scene,
            placed(AirPlacement::Gpu(Storage::F32), ClothPlacement::Device),
        );
        let (simulation, _) = without_files(&case, plan, Engine::Gpu.device()).unwrap();
        let sheet: Vec<u64> = simulation
            .cloth()
            .unwrap()
            .positions_m
            .iter()
            .flat_map(|p| p.to_array().map(f64::to_bits))
            .collect();
        let air: Vec<u64> = states(simulation.air().unwrap().engine())
            .iter()
            .flat_map(|(p, u)| [p.to_bits(), u[0].to_bits(), u[1].to_bits(), u[2].to_bits()])
            .collect();
        (sheet, air)
    };
    assert!(bits() == bits());
}

/// A device of its own, since it does not survive.
fn lost() {
    let device = Device::open(&AdapterChoice::Any).unwrap();
    let case = small_case(&["time.end_s=0.004"]);
    let plan = Plan::new(
        &case.scene,
        placed(AirPlacement::Gpu(Storage::F32), ClothPlacement::Host),
    );
    let mut simulation = Simulation::new(case.scene.clone(), plan, Some(device.clone())).unwrap();
    for _ in 0..3 {
        simulation.advance().unwrap();
    }
    device.destroy();
    let error = (0..5)
        .find_map(|_| simulation.advance().err())
        .expect("a destroyed device must be noticed");
    assert!(
        matches!(error, Failure::Device(DeviceError::Lost(_))),
        "{error:?}"
    );
    assert!(error.to_string().contains("--resume"), "{error}");
}

fn too_large() {
    let device = Engine::Gpu.device().unwrap();
    let limit = device
        .info()
        .binding_limit_bytes
        .min(device.info().buffer_limit_bytes);
    let side = (((limit / 4) as f64).cbrt() as usize) + 8;
    let setup = Setup {
        cells: [side; 3],
        ..setups().remove(0)
    };
    let error =
        AirEngine::build(setup, None, AirPlacement::Gpu(Storage::F32), Some(&device)).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, DeviceError::Limit { .. }), "{text}");
    let allowed = format!("{:.1} MB", limit as f64 / 1e6);
    for part in [allowed.as_str(), "max_", "coarser"] {
        assert!(text.contains(part), "{part} is missing in: {text}");
    }
}
