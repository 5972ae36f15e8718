//! What a device does: latencies, copying, bare air, a canopy, fabric; every speed beside its error, and beside the bound of copying.
//!
//! Rows are printed and appended to `device.jsonl` as they are measured, so that a call that is cut off keeps what it has; `device.json`
//! holds them all. A row that would not end in time is left out and named.
//!
//! Sizes are small, so that a software adapter goes through them in seconds, or with `full` those of a graphics card:
//!
//! * bare air of 128³ to 512³ cells, over operator, storage and the choices of [`Tuning`];
//! * the canopy of `benches/uniform-canopy.toml` at 24 to 192 cells per D_0;
//! * fabric of 10⁴ to 10⁶ nodes.

mod air;
mod asking;
mod canopy;
mod cloth;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{Stop, Watch, go_on};
use crate::case::{self, Case, Choices};
use crate::gpu::{Device, Tuning};
use crate::lattice::DIRECTION_COUNT;
use crate::output::{OutputError, write_atomically};
use crate::plan::{AirPlacement, ClothPlacement, Placement};

/// Bytes that a step moves per cell at least: every population read and written once, in 32 bits.
const BYTES_PER_CELL: f64 = (2 * DIRECTION_COUNT * 4) as f64;

/// How long, and how large.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Sizes of a graphics card instead of those of a software adapter.
    pub full: bool,
    /// No row begins that would not end within this time.
    pub limit: Duration,
}

/// Where rows go, and what is left of the time.
struct Rows<'a, 'w> {
    file: File,
    path: PathBuf,
    rows: Vec<Value>,
    left_out: Vec<String>,
    began: Instant,
    extent: Extent,
    watch: &'a mut Watch<'w>,
}

impl Rows<'_, '_> {
    /// Prints a headline.
    fn title(&mut self, text: &str) {
        self.watch.observer.note(&format!("\n{text}"));
    }

    /// Prints a row, and appends it to the file.
    fn add(&mut self, table: &str, text: &str, mut row: Value) -> Result<(), Stop> {
        self.watch.observer.note(text);
        row["table"] = table.into();
        let line = format!("{row}\n");
        let written = self.file.write_all(line.as_bytes());
        written.map_err(|cause| OutputError::new("write", &self.path, cause))?;
        self.rows.push(row);
        go_on(self.watch.interrupt)
    }

    /// The same of a row with labels and what was measured: its text and entries, `None` where it was left out. A device that cannot have it
    /// gets a row that says why, and the others go on.
    fn add_measured(
        &mut self,
        table: &str,
        labels: &str,
        mut row: Value,
        measured: Result<Option<(String, Value)>, Stop>,
    ) -> Result<(), Stop> {
        let text = match measured {
            Ok(None) => return Ok(()),
            Ok(Some((text, mut entries))) => {
                if let (Some(row), Some(entries)) = (row.as_object_mut(), entries.as_object_mut()) {
                    row.append(entries);
                }
                text
            }
            Err(stop @ (Stop::Interrupted | Stop::Output(_))) => return Err(stop),
            Err(stop) => {
                row["error"] = stop.to_string().into();
                format!("not possible: {stop}")
            }
        };
        self.add(table, &format!("{labels} {text}"), row)
    }

    /// True if a row of so many seconds still fits; else it is named.
    fn allows(&mut self, what: &str, seconds: f64) -> Result<bool, Stop> {
        go_on(self.watch.interrupt)?;
        let fits = self.began.elapsed().as_secs_f64() + seconds < self.extent.limit.as_secs_f64();
        if !fits {
            let line = format!("left out: {what}, about {seconds:.0} s");
            self.watch.observer.note(&line);
            self.left_out.push(what.to_owned());
        }
        Ok(fits)
    }
}

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
    let pace = air::sizes(device, rate, rows)?;
    canopy::rows(device, rate, rows)?;
    cloth::rows(device, rows)?;
    asking::marker_lists(device, rows)?;
    air::tunings(device, rate, pace, rows)
}

/// A case with other values.
fn load(name: &str, source: &str, overrides: &[String]) -> Result<Case, Stop> {
    let choices = Choices {
        variant: None,
        overrides: overrides.to_vec(),
    };
    case::parse(name, source, Path::new("."), &choices)
        .map_err(|error| Stop::Refused(error.to_string()))
}

fn placement(air: AirPlacement, cloth: ClothPlacement, device: &Device) -> Placement {
    Placement {
        air,
        cloth,
        device: Some(device.info().name.clone()),
        shared_memory: false,
    }
}

/// A number with so many digits, or a dash.
fn short(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
}

/// Milliseconds that every pass took per step, by the device's own clock, the longest first, and their sum.
fn pass_milliseconds(device: &Device, steps: f64) -> Result<Option<(Value, f64)>, Stop> {
    let Some(times) = device.pass_times()? else {
        return Ok(None);
    };
    let mut sum = 0.0;
    let mut passes = serde_json::Map::new();
    for time in times {
        let milliseconds = 1e3 * time.seconds / steps;
        sum += milliseconds;
        passes.insert(time.pass, milliseconds.into());
    }
    Ok(Some((Value::Object(passes), sum)))
}
