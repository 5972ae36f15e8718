//! The clock of a device, and choices about its kernels that must not change a bit.

use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use ripstop::gpu::fluid::Fluid;
use ripstop::gpu::{Padding, Tuning};
use ripstop::lattice::eddy_viscosity::EddyViscosity;
use ripstop::lattice::grid::{Setup, Sides, StreamwiseEnds};
use ripstop::lattice::start::Start;
use ripstop::lattice::{Operator, Storage};

use crate::device_work::own_device;
use crate::engines::needs_device;

pub fn trials() -> Vec<Trial> {
    vec![
        needs_device("device_kernels::passes_are_timed".to_owned(), passes),
        needs_device("device_kernels::latencies".to_owned(), latencies),
        needs_device(
            "device_kernels::tuned_kernels_same_bits".to_owned(),
            tunings,
        ),
        needs_device("device_kernels::planes_alike".to_owned(), planes_alike),
    ]
}

fn vortex(cells: [usize; 3], ends: StreamwiseEnds) -> Setup {
    Setup {
        cells,
        ends,
        sides: Sides::Periodic,
        relaxation_time: 0.52,
        inlet_profile: None,
        sponge_cells: None,
        idle: None,
        operator: Operator::RecursiveRegularised,
        eddy_viscosity: None,
    }
}

fn initial([x, y, z]: [usize; 3]) -> (f64, [f64; 3]) {
    let phase = |k: usize| (0.4 * k as f64).sin();
    (
        1e-3 * phase(x + 2 * y),
        [
            0.05 * phase(y + z),
            0.04 * phase(x + 3),
            0.03 * phase(x + y),
        ],
    )
}

/// Every pass that was counted is timed, also where timestamps have to be fetched in between; none takes longer than all took by
/// the host's clock.
fn passes() {
    let device = own_device(Tuning::default());
    if !device.time_passes() {
        eprintln!("{} has no timestamps", device.info().name);
        return;
    }
    let setup = vortex([8, 8, 8], StreamwiseEnds::Periodic);
    let mut fluid = Fluid::new(&device, setup, Storage::F32, Some(&initial)).unwrap();
    device.time_passes();
    let before = device.work();
    let start = Instant::now();
    for _ in 0..1501 {
        fluid.collide_stream(None, None).unwrap();
    }
    let times = device.pass_times().unwrap().unwrap();
    let whole = start.elapsed().as_secs_f64();
    let counted = device.work().since(&before).passes;
    assert!(counted >= 1501, "{counted}");
    assert_eq!(times.len(), 1, "{times:?}");
    assert_eq!(
        (times[0].pass.as_str(), times[0].passes),
        ("collide_stream", counted)
    );
    assert!(
        times[0].seconds > 0.0 && times[0].seconds < whole,
        "{times:?} in {whole} s"
    );
    device.stop_timing_passes();
    assert!(device.pass_times().unwrap().is_none());
}

fn latencies() {
    let device = own_device(Tuning::default());
    assert!(device.latencies().is_none());
    let measured = device.measure_latencies(Duration::from_millis(5)).unwrap();
    for (name, seconds, _) in measured.rows() {
        assert!((0.0..1.0).contains(&seconds), "{name} {seconds}");
    }
    for seconds in [
        measured.submit_s,
        measured.write_s,
        measured.wait_s,
        measured.spin_s,
        measured.map_s,
        measured.map_spin_s,
    ] {
        assert!(seconds > 0.0, "{measured:?}");
    }
    assert_eq!(device.latencies(), Some(measured));
}

/// Threads of a workgroup, padding and bounds checks decide where and when a cell is computed, not what comes out.
fn tunings() {
    let set_ups = [
        (StreamwiseEnds::Periodic, Storage::F32),
        (StreamwiseEnds::InletOutlet, Storage::F32),
        (StreamwiseEnds::Periodic, Storage::F16),
    ];
    let usual = Tuning::default();
    let mut reference = Vec::new();
    for tuning in [
        usual,
        Tuning {
            workgroup: 128,
            ..usual
        },
        Tuning {
            workgroup: 64,
            padding: Padding::Rows,
            bounds_checks: false,
            ..usual
        },
        Tuning {
            padding: Padding::None,
            ..usual
        },
        Tuning {
            bounds_checks: false,
            ..usual
        },
    ] {
        let device = own_device(tuning);
        assert_eq!(device.tuning(), tuning);
        for (k, (ends, storage)) in set_ups.into_iter().enumerate() {
            if storage == Storage::F16 && device.require_f16().is_err() {
                eprintln!("{} has no numbers of 16 bits", device.info().name);
                continue;
            }
            let mut setup = vortex([21, 10, 11], ends);
            setup.eddy_viscosity = Some(if k == 0 {
                EddyViscosity::wale(0.5)
            } else {
                EddyViscosity::smagorinsky(0.15)
            });
            let mut fluid = Fluid::new(&device, setup, storage, Some(&initial)).unwrap();
            fluid.set_inlet_velocity([0.05, 0.01, 0.0]);
            for _ in 0..3 {
                fluid.collide_stream(None, None).unwrap();
            }
            fluid.collide_stream_steps(5).unwrap();
            let states = fluid.macroscopic().unwrap();
            assert!(states.iter().any(|(_, u)| u[0].abs() > 1e-3));
            if reference.len() <= k {
                reference.push(states);
            } else {
                assert!(reference[k] == states, "{tuning:?} {ends:?} {storage:?}");
            }
        }
    }
}

/// A plane repeated on the device is the start that the host would have sent, in boxes of even and odd sizes, padded or not.
fn planes_alike() {
    let plane = |[x, y, _]: [usize; 3]| initial([x, y, 0]);
    for padding in [Padding::None, Padding::Planes, Padding::Rows] {
        let device = own_device(Tuning {
            padding,
            ..Tuning::default()
        });
        for (storage, cells) in [
            (Storage::F32, [9, 6, 8]),
            (Storage::F16, [9, 6, 8]),
            (Storage::F16, [9, 7, 7]),
        ] {
            if storage == Storage::F16 && device.require_f16().is_err() {
                eprintln!("{} has no numbers of 16 bits", device.info().name);
                continue;
            }
            let setup = vortex(cells, StreamwiseEnds::Periodic);
            let one = Setup {
                cells: [cells[0], cells[1], 1],
                ..setup.clone()
            };
            let mut sent = Fluid::new(&device, setup.clone(), storage, Some(&plane)).unwrap();
            let mut repeated = Fluid::new(&device, setup, storage, None).unwrap();
            repeated
                .fill_planes_alike(&Start::new(&one, &plane))
                .unwrap();
            for steps in [0, 3] {
                for _ in 0..steps {
                    sent.collide_stream(None, None).unwrap();
                    repeated.collide_stream(None, None).unwrap();
                }
                assert!(
                    sent.macroscopic().unwrap() == repeated.macroscopic().unwrap(),
                    "{storage:?} {cells:?} {padding:?} after {steps} steps"
                );
            }
        }
    }
}
