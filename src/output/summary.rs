//! `summary.json`: what was run, on what, how fast, and what came out.
//!
//! JSON has no NaN or infinity. A number that is not finite is written as `null`; in results and
//! optional numbers that is accompanied by a note.

use std::fmt;
use std::io;
use std::path::Path;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::account::AccountRow;
use super::atomic::{OutputError, write_atomically};
use super::comparison::ComparisonRow;
use super::device_use::DeviceUse;
use super::read_out::ReadOut;
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
    /// Cells of air along x, y, z; `None` without air.
    pub cells: Option<[usize; 3]>,
    /// Coupling markers between air and fabric.
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
    /// What every solver and every balance of the run reached.
    #[serde(default)]
    pub account: Vec<AccountRow>,
    /// Whether the set-up supports its results.
    #[serde(default)]
    pub validity: Vec<ValidityRow>,
    /// The errors that were to be expected of lattice and box.
    #[serde(default)]
    pub expected_errors: Vec<ExpectedError>,
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

/// One result with its uncertainty and, where one exists, a reference to compare it with.
///
/// In the file `value` and `unit` are always present; the others are left out when `None`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The number in `unit`; `None` when it could not be determined, and then `note` says why.
    pub value: Option<f64>,
    /// SI unit, `1` for a plain number.
    pub unit: String,
    /// Half width of the 95 % confidence interval, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// Interval between samples where the number was read from single ones, such as a time, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampling_error: Option<f64>,
    /// Measured or analytic number to compare with, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<f64>,
    /// Where the reference comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Relative error `(value - reference) / |reference|`, a plain number; `None` for a reference of zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Why the run cannot support the number, such as too few cells; `None` where nothing is known against it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unresolved: Option<String>,
    /// Remark for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Quantity {
    /// The number `value`; one that is not finite becomes `None` with a note. Its unit comes with the read-out that it is put in as.
    #[must_use]
    pub fn new(value: f64) -> Self {
        Self {
            value: Some(value),
            ..Self::default()
        }
        .finite()
    }

    /// A number with the details of its read-out's meaning, or all of a short one, as a note.
    #[must_use]
    pub fn told(read_out: &ReadOut, value: f64) -> Self {
        Self::new(value).with_note(read_out.detail().unwrap_or(read_out.meaning))
    }

    /// A quantity that could not be determined because of `why`.
    #[must_use]
    pub fn missing(why: &str) -> Self {
        Self {
            note: Some(why.to_owned()),
            ..Self::default()
        }
    }

    /// Adds the half width of the 95 % confidence interval, in the unit of the value.
    #[must_use]
    pub fn with_confidence(mut self, half_width: f64) -> Self {
        self.confidence = Some(half_width);
        self.finite()
    }

    /// Adds the interval between the samples that the value was read from, in the unit of the value.
    #[must_use]
    pub fn with_sampling_error(mut self, interval: f64) -> Self {
        self.sampling_error = Some(interval);
        self.finite()
    }

    /// Adds the reference from `source`, in the unit of the value, and the relative error.
    #[must_use]
    pub fn with_reference(mut self, reference: f64, source: &str) -> Self {
        self.reference = Some(reference);
        self.source = Some(source.to_owned());
        self.error = match self.value {
            Some(value) if reference != 0.0 => Some((value - reference) / reference.abs()),
            _ => None,
        };
        self.finite()
    }

    /// Marks the number as one that the run cannot support, because of `why`; a second reason joins the first.
    pub fn mark_unresolved(&mut self, why: &str) {
        self.unresolved = match self.unresolved.take() {
            Some(earlier) if earlier.contains(why) => Some(earlier),
            Some(earlier) => Some(format!("{earlier}; {why}")),
            None => Some(why.to_owned()),
        };
    }

    /// Adds a remark behind those already there.
    #[must_use]
    pub fn with_note(mut self, remark: &str) -> Self {
        self.note = match self.note.take() {
            Some(earlier) => Some(format!("{earlier}; {remark}")),
            None => Some(remark.to_owned()),
        };
        self
    }

    /// Replaces every number that is not finite by `None` and a note.
    fn finite(mut self) -> Self {
        let mut remarks = Vec::new();
        for (name, number) in [
            ("value", &mut self.value),
            ("confidence", &mut self.confidence),
            ("sampling_error", &mut self.sampling_error),
            ("reference", &mut self.reference),
            ("error", &mut self.error),
        ] {
            keep_finite(name, number, &mut remarks);
        }
        remarks
            .iter()
            .fold(self, |quantity, remark| quantity.with_note(remark))
    }
}

/// Named results in the order they were put in; a JSON object.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Results {
    entries: Vec<(String, Quantity)>,
}

impl Results {
    /// No results.
    pub fn new() -> Self {
        Self::default()
    }

    /// Puts in `quantity` as a read-out, in its unit: at the end, or in place of an earlier one of that name.
    pub fn insert(&mut self, read_out: &ReadOut, mut quantity: Quantity) {
        read_out.unit.clone_into(&mut quantity.unit);
        self.put(&read_out.name, quantity);
    }

    /// The same of a number with a note from its meaning.
    pub fn tell(&mut self, read_out: &ReadOut, value: f64) {
        self.insert(read_out, Quantity::told(read_out, value));
    }

    fn put(&mut self, name: &str, quantity: Quantity) {
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some((_, earlier)) => *earlier = quantity,
            None => self.entries.push((name.to_owned(), quantity)),
        }
    }

    /// The number of a read-out; `None` where there is no such result, or it could not be determined.
    #[must_use]
    pub fn value(&self, read_out: &ReadOut) -> Option<f64> {
        self.get(&read_out.name)?.value
    }

    /// The result of that name.
    pub fn get(&self, name: &str) -> Option<&Quantity> {
        let mut entries = self.iter();
        entries.find_map(|(known, quantity)| (known == name).then_some(quantity))
    }

    /// All results with their names, in order, to be changed in place.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&str, &mut Quantity)> {
        let entries = self.entries.iter_mut();
        entries.map(|(name, quantity)| (name.as_str(), quantity))
    }

    /// All results with their names, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Quantity)> {
        let entries = self.entries.iter();
        entries.map(|(name, quantity)| (name.as_str(), quantity))
    }

    /// Number of results.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are no results.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

impl Serialize for Results {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Results {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ResultsVisitor)
    }
}

struct ResultsVisitor;

impl<'de> Visitor<'de> for ResultsVisitor {
    type Value = Results;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a map from names to quantities")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Results, A::Error> {
        let mut results = Results::new();
        while let Some((name, quantity)) = map.next_entry::<String, Quantity>()? {
            results.put(&name, quantity);
        }
        Ok(results)
    }
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
        keep_finite("milliseconds_per_step.measure", &mut parts.measure, notes);
        keep_finite("simulated_s", &mut Some(summary.simulated_s), notes);
        keep_finite("wall_s", &mut Some(summary.wall_s), notes);
        keep_finite("stop.when_s", &mut Some(summary.stop.when_s), notes);
        for (_, quantity) in &mut summary.results.entries {
            *quantity = std::mem::take(quantity).finite();
        }
        summary
    }
}

/// Replaces `number` by `None` and a remark if it is not finite.
fn keep_finite(name: &str, number: &mut Option<f64>, remarks: &mut Vec<String>) {
    if let Some(strange) = number.take_if(|number| !number.is_finite()) {
        remarks.push(format!("{name} was not finite ({strange})"));
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
