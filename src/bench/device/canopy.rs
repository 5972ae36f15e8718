//! The canopy of `benches/uniform-canopy.toml`: milliseconds per step, by the host's clock and by the device's, and how far results lie apart.

use std::sync::Arc;
use std::time::Instant;

use serde_json::json;

use super::{BYTES_PER_CELL, Rows, Stop, load, pass_milliseconds, placement};
use crate::gpu::Device;
use crate::lattice::Storage;
use crate::plan::{AirPlacement, ClothPlacement, Plan, Precision};
use crate::run::without_files;

const CASE: &str = include_str!("../../../benches/uniform-canopy.toml");

/// Steps timed by the device's clock, after the others, with small and with full sizes.
const CLOCKED_STEPS: [u32; 2] = [8, 64];

/// The finest canopy that the CPU is given, too [cells per D_0].
const CPU_CELLS_PER_DIAMETER: f64 = 48.0;

/// Updates per second of a thread of the CPU engine, as a forecast.
const CPU_RATE: f64 = 2e7;

/// Cells per D_0, duration of the start and of what follows \[s\].
type Size = (f64, f64, f64);

const SMALL: &[Size] = &[(8.0, 0.001, 0.001)];
const FULL: &[Size] = &[
    (24.0, 0.0222, 0.02),
    (48.0, 0.0222, 0.02),
    (96.0, 0.0222, 0.01),
    (192.0, 0.0222, 0.004),
];

const PLACES: [(&str, AirPlacement, ClothPlacement); 4] = [
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

pub(super) fn rows(device: &Arc<Device>, copy: f64, rows: &mut Rows) -> Result<(), Stop> {
    rows.title("canopy, ms per step: by the host's clock, at the bound of copying, by the device's clock (of further steps); submits and maps per step");
    let line = format!(
        "{:>5} {:>9} {:>28} {:>9} {:>9} {:>9} {:>7} {:>5} {:>9} {:>10}",
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
    // Updates per second of the air on the device, and seconds per step besides.
    let mut rate = 2e7;
    for &size in sizes {
        let mut reference = None;
        for place in PLACES {
            // The finer ones would take the CPU longer than the device takes for everything.
            let on_cpu = matches!(place.1, AirPlacement::Cpu(_));
            if on_cpu && size.0 > CPU_CELLS_PER_DIAMETER {
                continue;
            }
            one(device, copy, size, place, (&mut rate, &mut reference), rows)?;
        }
    }
    Ok(())
}

fn one(
    device: &Arc<Device>,
    copy: f64,
    (cells_per_diameter, start_s, end_s): Size,
    (name, air, cloth): (&str, AirPlacement, ClothPlacement),
    (rate, reference): (&mut f64, &mut Option<f64>),
    rows: &mut Rows,
) -> Result<(), Stop> {
    let case = load(
        "uniform-canopy",
        CASE,
        &[
            format!("resolution.cells_per_diameter={cells_per_diameter:?}"),
            format!("air.wind_tunnel.start_time_s={start_s:?}"),
            format!("time.end_s={end_s:?}"),
        ],
    )?;
    let on_device = matches!(air, AirPlacement::Gpu(_));
    let plan = Plan::new(&case.scene, placement(air, cloth, device));
    let cells = plan.sizes.cells;
    let planned = (plan.start_steps + plan.steps) as f64;
    // A step costs latencies, too.
    let expected_s = if on_device {
        planned * (cells as f64 / *rate + 2e-3)
    } else {
        planned * cells as f64 / (CPU_RATE * rayon::current_num_threads() as f64)
    };
    let what = format!("canopy {cells_per_diameter} cells per D_0, {name}");
    if !rows.allows(&what, 1.3 * expected_s) {
        return Ok(());
    }
    let labels = format!("{cells_per_diameter:>5}");
    let start = Instant::now();
    let taken = on_device.then(|| Arc::clone(device));
    let mut row = json!({
        "cells_per_diameter": cells_per_diameter, "placement": name, "cells": cells,
    });
    let (mut simulation, record) = match without_files(&case, plan, taken) {
        Ok(done) => done,
        Err(error) => {
            row["error"] = error.to_string().into();
            return rows.add(
                "canopy",
                &format!("{labels} {name:>38} not possible: {error}"),
                row,
            );
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    let steps = simulation.step_count() as f64;
    if air == AirPlacement::Gpu(Storage::F32) {
        // Latencies count apart.
        *rate = cells as f64 / (seconds / steps - 1e-3).max(0.2 * seconds / steps);
    }
    let diameter = record
        .latest("projected_diameter_ratio")
        .unwrap_or(f64::NAN);
    let difference = diameter / *reference.get_or_insert(diameter) - 1.0;
    let bytes = match air {
        AirPlacement::Gpu(Storage::F16) => 0.5 * BYTES_PER_CELL,
        _ => BYTES_PER_CELL,
    };
    let bound_ms = on_device.then(|| 1e3 * bytes * cells as f64 / copy);
    let mut asked = [None; 2];
    let mut clocked = None;
    if on_device {
        let clocked_steps = CLOCKED_STEPS[usize::from(rows.extent.full)];
        let before = device.work();
        device.time_passes();
        let start = Instant::now();
        for _ in 0..clocked_steps {
            simulation.advance()?;
        }
        device.wait()?;
        let host_ms = 1e3 * start.elapsed().as_secs_f64() / f64::from(clocked_steps);
        let work = device.work().since(&before);
        let per_step = |count: u64| count as f64 / f64::from(clocked_steps);
        let (submits, maps) = (per_step(work.submits), per_step(work.maps));
        asked = [Some(submits), Some(maps)];
        row["clocked"] = json!({
            "steps": clocked_steps, "ms_per_step": host_ms, "dispatches_per_step": per_step(work.dispatches),
            "submits_per_step": submits, "writes_per_step": per_step(work.writes), "maps_per_step": maps,
            "bytes_written_per_step": per_step(work.written_bytes), "bytes_mapped_per_step": per_step(work.mapped_bytes),
            "ms_waited_per_step": 1e-6 * per_step(work.waited_ns),
        });
        if let Some((passes, sum_ms)) = pass_milliseconds(device, f64::from(clocked_steps))? {
            row["clocked"]["ms_on_device_per_step"] = sum_ms.into();
            row["clocked"]["share_of_time_that_device_works"] = (sum_ms / host_ms).into();
            row["clocked"]["ms_per_step_of_passes"] = passes;
            clocked = Some(sum_ms);
        }
        device.stop_timing_passes();
    }
    let ms = 1e3 * seconds / steps;
    row["markers"] = simulation.plan().sizes.markers.into();
    row["steps"] = steps.into();
    row["seconds"] = seconds.into();
    row["ms_per_step"] = ms.into();
    row["bound_ms_per_step"] = bound_ms.into();
    row["projected_diameter_ratio"] = diameter.into();
    row["difference_to_first"] = difference.into();
    let or_dash = |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{v:.3}"));
    let short = |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{v:.1}"));
    let text = format!(
        "{labels} {steps:>9} {name:>28} {ms:>9.3} {:>9} {:>9} {:>7} {:>5} {diameter:>9.5} {difference:>+10.1e}",
        or_dash(bound_ms),
        or_dash(clocked),
        short(asked[0]),
        short(asked[1]),
    );
    rows.add("canopy", &text, row)
}
