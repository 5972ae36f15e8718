//! Rows of the table of a device, and what several of them need.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::bench::{Stop, Watch, go_on};
use crate::case::{self, Case, Choices};
use crate::gpu::Device;
use crate::lattice::DIRECTION_COUNT;
use crate::output::OutputError;
use crate::plan::{AirPlacement, ClothPlacement, Placement};

/// Bytes that a step moves per cell at least: every population read and written once, in 32 bits.
pub(super) const BYTES_PER_CELL: f64 = (2 * DIRECTION_COUNT * 4) as f64;

/// A table of the benchmark; latencies and copying, which others stand beside, are always measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Table {
    /// Bare air over size, operator and storage.
    BareAir,
    /// A coupled canopy over cells per D_0.
    Canopy,
    /// Fabric on host and device.
    Cloth,
    /// Ways to tell the device which cells markers touch.
    MarkerLists,
    /// Bare air over threads of a workgroup, padding, and bounds checks.
    Tunings,
}

/// How long, and how large.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Sizes of a graphics card instead of those of a software adapter.
    pub full: bool,
    /// No row begins that would not end within this time.
    pub limit: Duration,
    /// One table alone.
    pub table: Option<Table>,
}

/// Where rows go, and what is left of the time.
pub(super) struct Rows<'a, 'w> {
    pub(super) file: File,
    pub(super) path: PathBuf,
    pub(super) rows: Vec<Value>,
    pub(super) left_out: Vec<String>,
    pub(super) began: Instant,
    pub(super) extent: Extent,
    pub(super) watch: &'a mut Watch<'w>,
}

impl Rows<'_, '_> {
    /// Prints a headline.
    pub(super) fn title(&mut self, text: &str) {
        self.watch.observer.note(&format!("\n{text}"));
    }

    /// Prints a row, and appends it to the file.
    pub(super) fn add(&mut self, table: &str, text: &str, mut row: Value) -> Result<(), Stop> {
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
    pub(super) fn add_measured(
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
    pub(super) fn allows(&mut self, what: &str, seconds: f64) -> Result<bool, Stop> {
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

/// A case with other values.
pub(super) fn load(name: &str, source: &str, overrides: &[String]) -> Result<Case, Stop> {
    let choices = Choices {
        variant: None,
        overrides: overrides.to_vec(),
    };
    case::parse(name, source, Path::new("."), &choices)
        .map_err(|error| Stop::Refused(error.to_string()))
}

pub(super) fn placement(air: AirPlacement, cloth: ClothPlacement, device: &Device) -> Placement {
    Placement {
        air,
        cloth,
        device: Some(device.info().name.clone()),
        shared_memory: false,
    }
}

/// A number with so many digits, or a dash.
pub(super) fn short(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
}

/// Milliseconds that every pass took per step, by the device's own clock, the longest first, and their sum.
pub(super) fn pass_milliseconds(device: &Device, steps: f64) -> Result<Option<(Value, f64)>, Stop> {
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
