//! `summary.json`: what was run, on what, how fast, and what came out.
//!
//! JSON has no NaN or infinity. A number that is not finite is written as `null`; in results and
//! optional numbers that is accompanied by a note.

use std::io;
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize};

use super::account::AccountRow;
use super::atomic::{OutputError, write_atomically};
use super::comparison::ComparisonRow;
use super::device_use::DeviceUse;
use super::quantity::{Results, keep_finite};
use super::validity::{ExpectedError, ValidityRow};

/// Version of the layout of `summary.json`; raised when a field changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// The contents of `summary.json`.
///
/// All fields are always present in the file; `null` means not applicable or not finite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`SCHEMA_VERSION`] of the writer.
    pub schema_version: u32,
    /// Version of Ripstop, such as `0.1.0`.
    pub ripstop_version: String,
    /// What was run.
    pub case: CaseInfo,
    /// Who computed the air (or the fabric, where there is no air): `cpu` or `gpu`.
    pub engine: String,
    /// Its hardware in words.
    pub device: String,
    /// Its precision, such as `f32`.
    pub precision: String,
    /// Who solved the fabric; `None` without any.
    pub fabric: Option<Processor>,
    /// Threads used.
    pub threads: usize,
    /// The box of air along x, y, z, in cells of the size around the structure; `None` without air.
    pub cells: Option<[usize; 3]>,
    /// Lattices of the air, each box of finer cells after those around it; empty without air.
    #[serde(default)]
    pub lattices: Vec<LatticeSize>,
    /// Coupling markers between air and fabric; without any, the links that surfaces cut at the end.
    pub markers: usize,
    /// Nodes of fabric and cables.
    pub nodes: usize,
    /// Fabric triangles.
    pub triangles: usize,
    /// Steps done.
    pub steps: u64,
    /// Step from which the run was resumed; the steps before are not part of its time. `None` for a run in one piece.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resumed_at_step: Option<u64>,
    /// Simulated time in seconds.
    #[serde(deserialize_with = "null_is_nan")]
    pub simulated_s: f64,
    /// Time the run took by the clock, in seconds.
    #[serde(deserialize_with = "null_is_nan")]
    pub wall_s: f64,
    /// Million cells of air updated per second of wall time (1e6/s); `None` without air.
    pub million_lattice_updates_per_s: Option<f64>,
    /// Where the time of a step went.
    pub milliseconds_per_step: MillisecondsPerStep,
    /// Steps of the air between solves of the fabric; `None` where it is solved in each, or where there is none.
    #[serde(default)]
    pub structure_every: Option<StructureEvery>,
    /// Where the time of the steps went, stage by stage in the order of a step.
    #[serde(default)]
    pub stages: Vec<StageTime>,
    /// What the run asked of its device; `None` where none computes.
    #[serde(default)]
    pub device_use: Option<DeviceUse>,
    /// Why and when the run ended.
    pub stop: StopInfo,
    /// What was asked for but not done, one sentence each.
    pub skipped: Vec<String>,
    /// Remarks for the reader, one sentence each.
    pub notes: Vec<String>,
    /// How it was computed, for those who look closer, one sentence each.
    #[serde(default)]
    pub details: Vec<String>,
    /// What every solver and every balance of the run reached.
    #[serde(default)]
    pub account: Vec<AccountRow>,
    /// Whether the set-up supports its results.
    #[serde(default)]
    pub validity: Vec<ValidityRow>,
    /// The errors that were to be expected of lattice and box.
    #[serde(default)]
    pub expected_errors: Vec<ExpectedError>,
    /// From when to when means are taken, in seconds since release; `None` of other scenes than canopies, wings, plates and bodies held in a tunnel. Of several bodies the window that begins last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub averaging_window_s: Option<[f64; 2]>,
    /// What came out, in the order it was put in.
    pub results: Results,
    /// Results beside the values of others that the case names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub comparison: Vec<ComparisonRow>,
}

/// Who computed something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Processor {
    /// `cpu` or `gpu`.
    pub engine: String,
    /// The hardware in words.
    pub device: String,
    /// Floating-point type, such as `f64`.
    pub precision: String,
}

/// Which case a summary belongs to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaseInfo {
    /// Title from the case file.
    pub title: String,
    /// Path of the case file as the user gave it.
    pub file: String,
    /// Variant of the case; `None` for the case as written.
    pub variant: Option<String>,
    /// Hash of the case as it was run.
    pub hash: String,
}

/// Mean wall time of one step by part, in milliseconds; `None` for a part the scene does not have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MillisecondsPerStep {
    /// Air (ms).
    pub fluid: Option<f64>,
    /// Exchange between air and structure (ms).
    pub coupling: Option<f64>,
    /// Fabric and cables (ms).
    pub cloth: Option<f64>,
    /// Contact of fabric with itself, part of `cloth` (ms).
    #[serde(default)]
    pub contact: Option<f64>,
    /// Everything else, output included (ms).
    pub measure: Option<f64>,
}

/// Steps of the air between solves of the fabric.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StructureEvery {
    /// At most, as planned.
    pub planned: u32,
    /// In the mean; `None` without any solve.
    pub mean: Option<f64>,
    /// Solves that ended a span of steps.
    pub solves: u64,
    /// Those that span fewer steps than planned, as the fabric moved fast.
    pub shortened: u64,
}

/// Wall time of one stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: String,
    /// Calls that were timed: all, or those of one step in 31 where a device works while the host goes on.
    pub calls: u64,
    /// Time of those calls (s).
    pub seconds: f64,
}

/// Why and when a run ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StopInfo {
    /// `finished`, `interrupted`, `diverged`, or `failed`: then results are those of what was sampled before.
    #[serde(default)]
    pub state: String,
    /// One sentence or key word.
    pub reason: String,
    /// Simulated time of the end, in seconds.
    #[serde(deserialize_with = "null_is_nan")]
    pub when_s: f64,
}

/// A lattice of the air.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatticeSize {
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// Edge length of a cell [m].
    pub cell_size_m: f64,
    /// Its lowest corner [m].
    pub corner_m: [f64; 3],
}

impl Summary {
    /// A copy without numbers that are not finite: optional ones become `None`, and a note tells
    /// of each. The other ones stay and are `null` in JSON.
    pub(super) fn finite(&self) -> Self {
        let mut summary = self.clone();
        let notes = &mut summary.notes;
        let parts = &mut summary.milliseconds_per_step;
        let speed = &mut summary.million_lattice_updates_per_s;
        keep_finite("million_lattice_updates_per_s", speed, notes);
        keep_finite("milliseconds_per_step.fluid", &mut parts.fluid, notes);
        keep_finite("milliseconds_per_step.coupling", &mut parts.coupling, notes);
        keep_finite("milliseconds_per_step.cloth", &mut parts.cloth, notes);
        keep_finite("milliseconds_per_step.contact", &mut parts.contact, notes);
        keep_finite("milliseconds_per_step.measure", &mut parts.measure, notes);
        keep_finite("simulated_s", &mut Some(summary.simulated_s), notes);
        keep_finite("wall_s", &mut Some(summary.wall_s), notes);
        keep_finite("stop.when_s", &mut Some(summary.stop.when_s), notes);
        for (_, quantity) in summary.results.iter_mut() {
            *quantity = std::mem::take(quantity).finite();
        }
        summary
    }
}

/// Reads `null`, which is how JSON holds a number that is not finite, as NaN.
fn null_is_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Writes `summary` as indented JSON, atomically.
///
/// Numbers that are not finite become `null`, with a note.
///
/// # Errors
///
/// When the file cannot be written; `path` is then unchanged.
pub fn write_summary(path: &Path, summary: &Summary) -> Result<(), OutputError> {
    let summary = summary.finite();
    write_atomically(path, |out| {
        serde_json::to_writer_pretty(&mut *out, &summary).map_err(io::Error::from)?;
        out.write_all(b"\n")
    })
}

#[cfg(test)]
#[path = "summary_tests.rs"]
mod tests;
