//! The canopy of `benches/uniform-canopy.toml`: milliseconds of a coupled step, by the host's clock and by the device's, and how far results
//! lie apart.
//!
//! The start is short, since no fabric is solved in it; neither it nor the set-up is part of the time of a step.

use std::sync::Arc;
use std::time::Instant;

use serde_json::json;

use super::rows::{BYTES_PER_CELL, Rows, load, pass_milliseconds, placement, short};
use crate::bench::Stop;
use crate::gpu::Device;
use crate::lattice::Storage;
use crate::measure::Record;
use crate::measure::shared::PROJECTED_DIAMETER_RATIO;
use crate::plan::{AirPlacement, ClothPlacement, Plan, Precision};
use crate::simulation::Simulation;

const CASE: &str = include_str!("../../../benches/uniform-canopy.toml");

/// The finest canopy that the CPU is given, too [cells per D_0].
const CPU_CELLS_PER_DIAMETER: f64 = 48.0;

/// Updates per second of a thread of the CPU engine, as a forecast.
const CPU_RATE: f64 = 2e7;

/// Cells per D_0, duration of the start \[s\], and steps: after the start before any is timed, timed by the host's clock, timed by the
/// device's.
type Size = (f64, f64, [u32; 3]);

const SMALL: &[Size] = &[(8.0, 0.001, [1, 4, 4])];
const FULL: &[Size] = &[
    (24.0, 0.0222, [20, 200, 64]),
    (48.0, 0.0111, [20, 200, 64]),
    (96.0, 0.0055, [20, 150, 64]),
    (192.0, 0.0028, [10, 60, 32]),
];

type Place = (&'static str, AirPlacement, ClothPlacement);

const PLACES: [Place; 4] = [
    (
        "cpu",
        AirPlacement::Cpu(Precision::F32),
        ClothPlacement::Host,
    ),
    (
        "device, cloth on host",
        AirPlacement::Gpu(Storage::F32),
        ClothPlacement::Host,
    ),
    (
        "device, cloth on device",
        AirPlacement::Gpu(Storage::F32),
        ClothPlacement::Device,
    ),
    (
        "device 16-bit, cloth on host",
        AirPlacement::Gpu(Storage::F16),
        ClothPlacement::Host,
    ),
];

/// What earlier rows tell of the next: updates per second of the air on the device, and D_p/D_0 of the first row of a size.
struct Earlier {
    rate: f64,
    diameter: Option<f64>,
}

pub(super) fn rows(device: &Arc<Device>, copy: f64, rows: &mut Rows) -> Result<(), Stop> {
    rows.title("canopy, ms of a coupled step: by the host's clock, at the bound of copying, by the device's clock (of further steps); submits and maps per step");
    let line = format!(
        "{:>5} {:>6} {:>28} {:>9} {:>9} {:>9} {:>7} {:>5} {:>9} {:>10}",
        "cells",
        "steps",
        "placement",
        "ms",
        "bound",
        "on device",
        "submits",
        "maps",
        "D_p/D_0",
        "difference"
    );
    rows.watch.observer.note(&line);
    let sizes = if rows.extent.full { FULL } else { SMALL };
    let mut earlier = Earlier {
        rate: 2e7,
        diameter: None,
    };
    for &size in sizes {
        earlier.diameter = None;
        for place in PLACES {
            // The finer ones would take the CPU longer than the device takes for everything.
            let on_cpu = matches!(place.1, AirPlacement::Cpu(_));
            if on_cpu && size.0 > CPU_CELLS_PER_DIAMETER {
                continue;
            }
            let labels = format!("{:>5} {:>6} {:>28}", size.0, size.2[1], place.0);
            let row =
                json!({"cells_per_diameter": size.0, "placement": place.0, "steps": size.2[1]});
            let measured = one(device, copy, size, place, &mut earlier, rows);
            rows.add_measured("canopy", &labels, row, measured)?;
        }
    }
    Ok(())
}

/// Text and entries of a row; `None` where it was left out.
fn one(
    device: &Arc<Device>,
    copy: f64,
    (cells_per_diameter, start_s, [before, timed, clocked]): Size,
    (name, air, cloth): Place,
    earlier: &mut Earlier,
    rows: &mut Rows,
) -> Result<Option<(String, serde_json::Value)>, Stop> {
    let case = load(
        "uniform-canopy",
        CASE,
        &[
            format!("resolution.cells_per_diameter={cells_per_diameter:?}"),
            format!("air.wind_tunnel.start_time_s={start_s:?}"),
        ],
    )?;
    let on_device = matches!(air, AirPlacement::Gpu(_));
    let plan = Plan::new(&case.scene, placement(air, cloth, device));
    let (cells, start_steps) = (plan.sizes.cells, plan.start_steps);
    let planned = start_steps as f64 + f64::from(before + timed + clocked);
    // A step costs latencies, too, and the set-up compiles and opens the canopy.
    let expected_s = if on_device {
        3.0 + planned * (cells as f64 / earlier.rate + 2e-3)
    } else {
        1.0 + planned * cells as f64 / (CPU_RATE * rayon::current_num_threads() as f64)
    };
    let what = format!("canopy {cells_per_diameter} cells per D_0, {name}");
    if !rows.allows(&what, 1.3 * expected_s)? {
        return Ok(None);
    }
    let wait = || if on_device { device.wait() } else { Ok(()) };
    let taken = on_device.then(|| Arc::clone(device));
    let start = Instant::now();
    let mut simulation = Simulation::new(case.scene.clone(), plan, taken)?;
    for _ in 0..start_steps + u64::from(before) {
        simulation.advance_among_threads()?;
    }
    wait()?;
    let set_up_s = start.elapsed().as_secs_f64();
    let (cost, work) = (*simulation.cost(), device.work());
    // Nobody reads the air before the last of them, as in most steps of a run.
    simulation.set_next_reading(simulation.step_count() + u64::from(timed));
    let start = Instant::now();
    for _ in 0..timed {
        simulation.advance_among_threads()?;
    }
    wait()?;
    let milliseconds = 1e3 * start.elapsed().as_secs_f64() / f64::from(timed);
    let work = device.work().since(&work);
    let evaluations = (simulation.cost().evaluations - cost.evaluations) as f64 / f64::from(timed);
    let mut record = Record::new(&simulation);
    record.add(&mut simulation)?;
    let diameter = record.latest(&PROJECTED_DIAMETER_RATIO);
    let diameter = diameter.unwrap_or(f64::NAN);
    let difference = diameter / *earlier.diameter.get_or_insert(diameter) - 1.0;
    if air == AirPlacement::Gpu(Storage::F32) {
        // Latencies count apart.
        let of_air_s = 1e-3 * (milliseconds - 1.0).max(0.2 * milliseconds);
        earlier.rate = cells as f64 / of_air_s;
    }
    let mut row = json!({
        "cells": cells, "markers": simulation.plan().sizes.markers, "start_steps": start_steps, "set_up_and_start_s": set_up_s,
        "ms_per_step": milliseconds, "evaluations_per_step": evaluations,
        "projected_diameter_ratio": diameter, "difference_to_first": difference,
    });
    let (mut bound_ms, mut sum_ms, mut asked) = (None, None, [None; 2]);
    if on_device {
        let bytes = match air {
            AirPlacement::Gpu(Storage::F16) => 0.5 * BYTES_PER_CELL,
            _ => BYTES_PER_CELL,
        };
        bound_ms = Some(1e3 * bytes * cells as f64 / copy);
        row["bound_ms_per_step"] = bound_ms.into();
        let per_step = |count: u64| count as f64 / f64::from(timed);
        asked = [Some(per_step(work.submits)), Some(per_step(work.maps))];
        row["asked_per_step"] = json!({
            "dispatches": per_step(work.dispatches), "submits": asked[0], "writes": per_step(work.writes), "maps": asked[1],
            "written_bytes": per_step(work.written_bytes), "mapped_bytes": per_step(work.mapped_bytes),
            "ms_waited": 1e-6 * per_step(work.waited_ns),
        });
        device.time_passes();
        let start = Instant::now();
        for _ in 0..clocked {
            simulation.advance_among_threads()?;
        }
        device.wait()?;
        let clocked_ms = 1e3 * start.elapsed().as_secs_f64() / f64::from(clocked);
        let passes = pass_milliseconds(device, f64::from(clocked))?;
        device.stop_timing_passes();
        if let Some((passes, sum)) = passes {
            sum_ms = Some(sum);
            row["clocked"] = json!({
                "steps": clocked, "ms_per_step": clocked_ms, "ms_on_device_per_step": sum,
                "share_of_time_that_device_works": sum / clocked_ms, "ms_per_step_of_passes": passes,
            });
        }
    }
    let text = format!(
        "{milliseconds:>9.3} {:>9} {:>9} {:>7} {:>5} {diameter:>9.5} {difference:>+10.1e}",
        short(bound_ms, 3),
        short(sum_ms, 3),
        short(asked[0], 1),
        short(asked[1], 1),
    );
    Ok(Some((text, row)))
}
