//! Bare air: Taylor–Green vortices in a periodic box, over size, operator, storage, and the choices of [`Tuning`].

use std::sync::Arc;
use std::time::Instant;

use serde_json::json;

use super::rows::{BYTES_PER_CELL, Rows};
use crate::bench::Stop;
use crate::gpu::Tuning;
use crate::gpu::fluid::Fluid;
use crate::gpu::{AdapterChoice, Device, DeviceError, Padding};
use crate::lattice::grid::Setup;
use crate::lattice::start::Start;
use crate::lattice::{Operator, Storage};

const RELAXATION_TIME: f64 = 0.6;

/// Opening another device, as a forecast \[s\].
const OPENING_S: f64 = 1.0;

/// Steps after which it is known how long one takes.
const FIRST: usize = 4;

/// Steps so long before any is timed [s]: without, rows of large boxes scattered by half on an NVIDIA H100, as after the idle time in which arrays are filled.
const WARM_UP_S: f64 = 0.3;

/// Bare air: operator and storage.
#[derive(Debug, Clone, Copy)]
struct Variant {
    operator: Operator,
    storage: Storage,
}

impl Variant {
    /// All that runs are meant to take.
    fn all() -> impl Iterator<Item = Self> {
        let stored =
            |operator| [Storage::F32, Storage::F16].map(|storage| Self { operator, storage });
        Operator::in_use().flat_map(stored)
    }

    fn name(self) -> String {
        let name = self.operator.name();
        match self.storage {
            Storage::F32 => name.to_owned(),
            Storage::F16 => format!("{name} 16-bit"),
        }
    }
}

/// The sizes, as runs take them.
pub(super) fn sizes(device: &Arc<Device>, copy: f64, rows: &mut Rows) -> Result<Pace, Stop> {
    rows.title("bare air, periodic, no eddy viscosity: 152 B per cell and step at most, 76 B with 16-bit storage");
    head(rows);
    let sides: &[usize] = if rows.extent.full {
        &[128, 192, 256, 384, 512]
    } else {
        &[12]
    };
    let mut pace = Pace::default();
    for &side in sides {
        for variant in Variant::all() {
            one(device, copy, side, variant, &mut pace, rows)?;
        }
    }
    Ok(pace)
}

/// The choices: all combinations at several sizes, or with small sizes one at a time.
pub(super) fn tunings(
    device: &Arc<Device>,
    copy: f64,
    mut pace: Pace,
    rows: &mut Rows,
) -> Result<(), Stop> {
    rows.title(
        "bare air again, by threads of a workgroup, padding of the arrays, and bounds checks",
    );
    head(rows);
    let full = rows.extent.full;
    let usual = Tuning::default();
    let tunings: Vec<Tuning> = if full {
        let mut all = Vec::new();
        for workgroup in [64, 128, 256] {
            for padding in [Padding::None, Padding::Planes, Padding::Rows] {
                for bounds_checks in [true, false] {
                    all.push(Tuning {
                        workgroup,
                        padding,
                        bounds_checks,
                        ..usual
                    });
                }
            }
        }
        all
    } else {
        let (workgroup, bounds_checks) = (128, false);
        let padding = |padding| Tuning { padding, ..usual };
        vec![
            usual,
            Tuning { workgroup, ..usual },
            padding(Padding::None),
            padding(Padding::Rows),
            Tuning {
                bounds_checks,
                ..usual
            },
        ]
    };
    // The operator of canopies first; sizes between with the operators alone.
    let of = |operator, storage| Variant { operator, storage };
    let [trt, trt_16] = [Storage::F32, Storage::F16].map(|s| of(Operator::TwoRelaxationTimes, s));
    let [regularised, regularised_16] =
        [Storage::F32, Storage::F16].map(|s| of(Operator::RecursiveRegularised, s));
    let order: Vec<(usize, Variant)> = if full {
        [
            (256, regularised),
            (512, regularised),
            (256, regularised_16),
            (256, trt),
            (512, regularised_16),
            (512, trt),
            (256, trt_16),
            (512, trt_16),
            (128, regularised),
            (384, regularised),
            (128, trt),
            (384, trt),
        ]
        .to_vec()
    } else {
        vec![(12, regularised)]
    };
    let choice = AdapterChoice::Named(device.info().name.clone());
    let mut opened: Vec<(Tuning, Arc<Device>)> = Vec::new();
    for (side, variant) in order {
        for &tuning in &tunings {
            let known = opened.iter().position(|(of, _)| *of == tuning);
            let tuned = match known {
                Some(index) => Arc::clone(&opened[index].1),
                None => {
                    if !rows.allows(&format!("a device with {tuning:?}"), OPENING_S)? {
                        continue;
                    }
                    let tuned = Device::open_tuned(&choice, tuning)?;
                    opened.push((tuning, Arc::clone(&tuned)));
                    tuned
                }
            };
            one(&tuned, copy, side, variant, &mut pace, rows)?;
        }
    }
    Ok(())
}

fn head(rows: &mut Rows) {
    let line = format!(
        "{:>5} {:>28} {:>9} {:>8} {:>7} {:>9} {:>9} {:>9} {:>13}",
        "side",
        "operator",
        "workgroup",
        "padding",
        "checks",
        "MLUPS",
        "GB/s",
        "of copy",
        "energy error"
    );
    rows.watch.observer.note(&line);
}

/// What rows took so far, to foretell the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// Updates per second.
    rate: f64,
    /// Seconds besides the steps, by cell, of the row before.
    set_up_of_a_cell: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            rate: 5e6,
            set_up_of_a_cell: 1e-7,
        }
    }
}

fn one(
    device: &Arc<Device>,
    copy: f64,
    side: usize,
    variant: Variant,
    pace: &mut Pace,
    rows: &mut Rows,
) -> Result<(), Stop> {
    let (name, Variant { operator, storage }) = (variant.name(), variant);
    let cells = (side as f64).powi(3);
    let aim_s = if rows.extent.full { 0.2 } else { 0.02 };
    let tuning = device.tuning();
    let what = format!("bare air {side}^3 {name} {tuning:?}");
    let warm_up_s = if rows.extent.full { WARM_UP_S } else { 0.0 };
    let expected_s = aim_s + warm_up_s + 12.0 * cells / pace.rate + pace.set_up_of_a_cell * cells;
    if !rows.allows(&what, expected_s)? {
        return Ok(());
    }
    let padding = format!("{:?}", tuning.padding).to_lowercase();
    let checks = if tuning.bounds_checks { "on" } else { "off" };
    let labels = format!(
        "{side:>5} {name:>28} {:>9} {padding:>8} {checks:>7}",
        tuning.workgroup
    );
    let row = json!({
        "side": side, "operator": name, "workgroup": tuning.workgroup, "padding": padding, "bounds_checks": tuning.bounds_checks,
    });
    let start = Instant::now();
    let measured = vortices(device, side, operator, storage, [warm_up_s, aim_s]).map(|timed| {
        let rate = cells * timed.steps as f64 / timed.seconds;
        pace.rate = rate;
        pace.set_up_of_a_cell = (start.elapsed().as_secs_f64() - timed.seconds) / cells;
        let bytes = rate * BYTES_PER_CELL / 4.0 * storage.bytes() as f64;
        let text = format!(
            "{:>9.0} {:>9.1} {:>8.1}% {:>13.1e}",
            1e-6 * rate,
            1e-9 * bytes,
            100.0 * bytes / copy,
            timed.energy_error
        );
        let entries = json!({
            "steps": timed.steps, "million_lattice_updates_per_s": 1e-6 * rate, "gigabytes_per_s": 1e-9 * bytes,
            "share_of_copy_bandwidth": bytes / copy, "energy_error": timed.energy_error,
        });
        Some((text, entries))
    });
    rows.add_measured("bare_air", &labels, row, measured.map_err(Stop::from))
}

struct Timed {
    steps: usize,
    seconds: f64,
    /// Of the kinetic energy after the steps, against its exact decay.
    energy_error: f64,
}

fn vortices(
    device: &Arc<Device>,
    side: usize,
    operator: Operator,
    storage: Storage,
    [warm_up_s, aim_s]: [f64; 2],
) -> Result<Timed, DeviceError> {
    let setup = Setup::periodic([side; 3], RELAXATION_TIME, operator);
    let k = std::f64::consts::TAU / side as f64;
    let speed = 0.02;
    let initial = move |[x, y, _]: [usize; 3]| {
        let (x, y) = (k * (x as f64 + 0.5), k * (y as f64 + 0.5));
        let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
        (
            excess,
            [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0],
        )
    };
    let plane = Setup {
        cells: [side, side, 1],
        ..setup.clone()
    };
    let mut fluid = Fluid::new(device, setup, storage, None)?;
    fluid.fill_planes_alike(&Start::new(&plane, &initial))?;
    // Energy falls by exp(−4 ν k² t); over more than one of these times what is left is too little to measure.
    let decay = 4.0 * (RELAXATION_TIME - 0.5) / 3.0 * k * k;
    let most = (1.0 / decay) as usize;
    fluid.collide_stream_steps(FIRST)?;
    device.wait()?;
    let start = Instant::now();
    fluid.collide_stream_steps(FIRST)?;
    device.wait()?;
    let per_step = start.elapsed().as_secs_f64() / FIRST as f64;
    let as_many = |seconds: f64| ((seconds / per_step) as usize).clamp(FIRST, most.max(8) / 2);
    fluid.collide_stream_steps(as_many(warm_up_s))?;
    let (_, before) = fluid.mass_and_energy()?;
    let steps = as_many(aim_s);
    let start = Instant::now();
    fluid.collide_stream_steps(steps)?;
    device.wait()?;
    let seconds = start.elapsed().as_secs_f64();
    let (_, after) = fluid.mass_and_energy()?;
    let exact = (-decay * steps as f64).exp();
    Ok(Timed {
        steps,
        seconds,
        energy_error: after / before / exact - 1.0,
    })
}
