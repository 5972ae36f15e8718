//! What a device does: latencies, copying, bare air, a canopy, fabric; every speed beside its error, and beside the bound of copying.
//!
//! Rows are printed and appended to `device.jsonl` as they are measured, so that a call that is cut off keeps what it has; `device.json`
//! holds them all. A row that would not end in time is left out and named.
//!
//! Sizes are small, so that a software adapter goes through them in seconds, or with `full` those of a graphics card:
//!
//! * bare air of 128³ to 512³ cells, over operator, storage and the choices of [`crate::gpu::Tuning`];
//! * the canopy of `benches/uniform-canopy.toml` at 24 to 192 cells per D_0;
//! * fabric of 10⁴ to 10⁶ nodes.

mod air;
mod asking;
mod canopy;
mod cloth;
mod rows;

use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde_json::json;

use super::{Stop, Watch};
use crate::gpu::Device;
use crate::output::{OutputError, write_atomically};
use rows::{BYTES_PER_CELL, Rows};
pub use rows::{Extent, Table};

/// Measures a device; returns the path of the table.
pub fn measure(
    device: &Arc<Device>,
    extent: Extent,
    folder: &Path,
    watch: &mut Watch,
) -> Result<String, Stop> {
    let path = folder.join("device.jsonl");
    let file = File::create(&path).map_err(|cause| OutputError::new("write", &path, cause))?;
    let info = device.info().clone();
    let mut rows = Rows {
        file,
        path,
        rows: Vec::new(),
        left_out: Vec::new(),
        began: Instant::now(),
        extent,
        watch,
    };
    rows.title(&format!(
        "{}, {}, {}",
        info.name,
        info.kind.name(),
        info.driver
    ));
    let mut copy = None;
    let ended = all_tables(device, &mut copy, &mut rows);
    let report = json!({
        "benchmark": "device", "ripstop": env!("CARGO_PKG_VERSION"),
        "device": info.name, "kind": info.kind.name(), "driver": info.driver,
        "threads": rayon::current_num_threads(),
        "machine": std::env::var("RIPSTOP_MACHINE").ok(), "commit": std::env::var("RIPSTOP_COMMIT").ok(),
        "date": std::env::var("RIPSTOP_DATE").ok(),
        "full": extent.full, "seconds": rows.began.elapsed().as_secs_f64(),
        "bytes_per_cell_and_step": BYTES_PER_CELL, "copy_gigabytes_per_s": copy.map(|copy: f64| 1e-9 * copy),
        "ended_by": ended.as_ref().err().map(ToString::to_string),
        "rows": rows.rows, "left_out": rows.left_out,
    });
    write_atomically(&folder.join("device.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, &report)?;
        writeln!(out)
    })?;
    ended?;
    Ok(format!(
        "{} rows measured, {} left out for want of time\n",
        rows.rows.len(),
        rows.left_out.len()
    ))
}

/// All tables, the most telling first; `copy` is known as soon as it is measured.
fn all_tables(device: &Arc<Device>, copy: &mut Option<f64>, rows: &mut Rows) -> Result<(), Stop> {
    asking::latencies(device, rows)?;
    let rate = *copy.insert(asking::copy(device, rows)?);
    let of = rows.extent.table;
    let wanted = |table| of.is_none_or(|only| only == table);
    let mut pace = air::Pace::default();
    if wanted(Table::BareAir) {
        pace = air::sizes(device, rate, rows)?;
    }
    if wanted(Table::Canopy) {
        canopy::rows(device, rate, rows)?;
    }
    if wanted(Table::Cloth) {
        cloth::rows(device, rows)?;
    }
    if wanted(Table::MarkerLists) {
        asking::marker_lists(device, rows)?;
    }
    if wanted(Table::Tunings) {
        air::tunings(device, rate, pace, rows)?;
    }
    Ok(())
}
