//! What asking costs: latencies, copying, lists of cells that markers touch.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;

use super::rows::Rows;
use crate::bench::Stop;
use crate::gpu::Device;
use crate::gpu::bandwidth::copy_bandwidth;
use crate::immersed::touched::TouchedCells;
use crate::lattice::grid::Setup;
use crate::lattice::{Operator, Storage};
use crate::plan::AirPlacement;
use crate::simulation::{AirEngine, MarkerEngine};

pub(super) fn latencies(device: &Arc<Device>, rows: &mut Rows) -> Result<(), Stop> {
    rows.title("latencies, medians [µs]");
    let limit = if rows.extent.full { 0.5 } else { 0.02 };
    let latencies = device.measure_latencies(Duration::from_secs_f64(limit))?;
    for (name, seconds, meaning) in latencies.rows() {
        let microseconds = 1e6 * seconds;
        rows.add(
            "latency",
            &format!("{name:<20} {microseconds:>9.2}   {meaning}"),
            json!({"name": name, "microseconds": microseconds, "meaning": meaning}),
        )?;
    }
    Ok(())
}

/// Bytes read and written per second by copying: the bound of everything that streams.
pub(super) fn copy(device: &Arc<Device>, rows: &mut Rows) -> Result<f64, Stop> {
    let info = device.info();
    let wanted = if rows.extent.full { 1 << 30 } else { 1 << 26 };
    let bytes = wanted
        .min(info.binding_limit_bytes)
        .min(info.buffer_limit_bytes)
        / 16
        * 16;
    let rate = copy_bandwidth(device, bytes, 16)?;
    let text = format!(
        "\ncopy of {} MB: {:.1} GB/s read and written",
        bytes >> 20,
        1e-9 * rate
    );
    rows.add(
        "copy",
        &text,
        json!({"bytes": bytes, "gigabytes_per_s": 1e-9 * rate}),
    )?;
    Ok(rate)
}

/// What sending markers costs against the lists of all 64 weights that the CPU engine keeps, for crumpled hemispheres.
pub(super) fn marker_lists(device: &Arc<Device>, rows: &mut Rows) -> Result<(), Stop> {
    rows.title(
        "cells that markers touch: markers sorted on the host and cells marked on the device (what runs do), against lists of all cells and weights \
         made on the host\n markers  sorted [ms]  to send [B]   lists [ms]  to send [B]",
    );
    let sides: &[f64] = if rows.extent.full {
        &[32.0, 128.0, 384.0]
    } else {
        &[16.0, 32.0]
    };
    for &side in sides {
        if !rows.allows(&format!("marker lists {side}"), 3e-9 * side.powi(3) + 1.0)? {
            continue;
        }
        let radius = 0.35 * side;
        let count = (2.0 * std::f64::consts::PI * radius * radius) as usize;
        let positions: Vec<[f64; 3]> = (0..count)
            .map(|k| {
                // A spiral of equal areas.
                let z = k as f64 / count as f64;
                let angle = 2.4 * k as f64;
                let r = radius * (1.0 - z * z).sqrt();
                [
                    8.0 + radius * z,
                    0.5 * side + r * angle.cos(),
                    0.5 * side + r * angle.sin(),
                ]
            })
            .collect();
        let cells = [(radius as usize) + 16, side as usize, side as usize];
        // Cell, marker and weight of every entry, as 4-byte numbers, and the weights in the markers' order again.
        let bytes = [32 * count, 16 * 64 * count];
        let measured = best_of_ten(device, cells, &positions).map(|[sorted, lists]| {
            let text = format!("{sorted:>12.3} {:>12} {lists:>12.3} {:>12}", bytes[0], bytes[1]);
            let entries = json!({
                "sorted_ms": sorted, "sorted_bytes": bytes[0], "lists_ms": lists, "lists_bytes": bytes[1],
            });
            Some((text, entries))
        });
        let labels = format!("{count:>8}");
        rows.add_measured("marker_lists", &labels, json!({"markers": count}), measured)?;
    }
    Ok(())
}

/// Milliseconds of both ways.
fn best_of_ten(
    device: &Arc<Device>,
    cells: [usize; 3],
    positions: &[[f64; 3]],
) -> Result<[f64; 2], Stop> {
    let setup = Setup::periodic(cells, 0.6, Operator::RecursiveRegularised);
    let air = AirEngine::build(setup, None, AirPlacement::Gpu(Storage::F32), Some(device))?;
    let mut markers = MarkerEngine::new(&air, vec![1.0; positions.len()], 1.6)
        .map_err(|error| Stop::Refused(error.to_string()))?;
    let mut lists = TouchedCells::default();
    let mut best = [f64::INFINITY; 2];
    for _ in 0..10 {
        let start = Instant::now();
        markers
            .send_markers(&air, positions)?
            .map_err(|outside| Stop::Refused(format!("{outside:?}")))?;
        device.wait()?;
        best[0] = best[0].min(1e3 * start.elapsed().as_secs_f64());
        let start = Instant::now();
        lists
            .rebuild(positions, cells)
            .map_err(|outside| Stop::Refused(format!("{outside:?}")))?;
        best[1] = best[1].min(1e3 * start.elapsed().as_secs_f64());
    }
    Ok(best)
}
