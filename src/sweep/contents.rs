//! The contents of `sweep.json`: runs, how they ended, what came out of them, and what lattices tell of that.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::vary::{Point, Vary};
use crate::output::{AccountRow, ComparisonRow, Results, Summary};

/// How a run of a sweep ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Not begun.
    Waiting,
    /// Interrupted; a checkpoint is in its folder.
    Interrupted,
    /// Done.
    Done,
    /// Without results, or with those of a run that broke down.
    Failed,
}

impl Status {
    /// Its word in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Interrupted => "interrupted",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}

/// One run and what came out of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Folder below that of the sweep.
    pub folder: String,
    /// Varied keys and their values.
    pub values: BTreeMap<String, String>,
    /// Hash of the case as it was run.
    pub hash: String,
    /// How it ended.
    pub status: Status,
    /// Why it failed.
    pub message: Option<String>,
    /// Size of its cells of air [m]; `None` without air.
    #[serde(default)]
    pub cell_size_m: Option<f64>,
    /// Its results; empty before it is done.
    pub results: Results,
    /// Rows of its account that were not met, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missed: Vec<String>,
    /// Results beside the values of others, as the run alone judges them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub comparison: Vec<ComparisonRow>,
}

impl Outcome {
    /// A run that has not begun.
    #[must_use]
    pub fn waiting(point: &Point, hash: &str, cell_size_m: Option<f64>) -> Self {
        Self {
            folder: point.folder.clone(),
            values: point.values.iter().cloned().collect(),
            hash: hash.to_owned(),
            status: Status::Waiting,
            message: None,
            cell_size_m,
            results: Results::new(),
            missed: Vec::new(),
            comparison: Vec::new(),
        }
    }

    /// Takes the results of a run that is done.
    pub fn done(&mut self, summary: &Summary) {
        self.status = Status::Done;
        self.message = None;
        self.results = summary.results.clone();
        let missed = (summary.account.iter()).filter(|row| row.reached == Some(false));
        self.missed = missed.map(AccountRow::line).collect();
        self.comparison.clone_from(&summary.comparison);
    }
}

/// The contents of `sweep.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// 1.
    pub schema_version: u32,
    /// Title of the case.
    pub title: String,
    /// Case file as given.
    pub case: String,
    /// Variant of the case.
    pub variant: Option<String>,
    /// Keys that lead: one for each `--vary`; those that vary together with them follow from them.
    pub leading_keys: Vec<String>,
    /// The one of them that changes the size of cells, or leads one that does.
    #[serde(default)]
    pub lattice_key: Option<String>,
    /// All runs.
    pub runs: Vec<Outcome>,
    /// What the lattices tell of the results; empty before it is written, and where neither lattice nor start varies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ladders: Vec<Ladder>,
}

impl Sweep {
    /// Leading keys of `varies`.
    #[must_use]
    pub fn leading(varies: &[Vary]) -> Vec<String> {
        let first = |vary: &Vary| vary.keys.first().cloned();
        varies.iter().filter_map(first).collect()
    }

    /// The leading key of those of `varies` that changes the size of cells.
    #[must_use]
    pub fn lattice_key(varies: &[Vary]) -> Option<String> {
        let vary = varies.iter().find(|vary| vary.changes_lattice())?;
        vary.keys.first().cloned()
    }

    /// What an earlier sweep into the same folder left; `None` if there is nothing readable.
    #[must_use]
    pub fn read(folder: &Path) -> Option<Self> {
        let text = std::fs::read(folder.join("sweep.json")).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// Names of all results of all runs, in the order of the first that has each.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for (name, _) in self.runs.iter().flat_map(|run| run.results.iter()) {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        names
    }

    /// The word that a run has for a key.
    #[must_use]
    pub fn value<'a>(&self, run: &'a Outcome, key: &str) -> &'a str {
        run.values.get(key).map_or("", String::as_str)
    }

    /// Values of the leading keys but the first: runs that agree in them form a series.
    pub(super) fn series(&self, run: &Outcome) -> String {
        let words = self.leading_keys.iter().skip(1);
        let words = words.map(|key| format!("{} = {}", last(key), self.value(run, key)));
        words.collect::<Vec<_>>().join(", ")
    }
}

/// One result on all lattices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// Name of the result.
    pub result: String,
    /// Its unit.
    pub unit: String,
    /// Value on each lattice, coarsest first: of the run, or the mean over its starts.
    pub values: Vec<Option<f64>>,
    /// Half width of the 95 % interval of each.
    pub intervals: Vec<Option<f64>>,
    /// What the intervals are of, in a few words; empty without any.
    pub interval_of: String,
    /// Observed order of the three finest lattices.
    pub order: Option<f64>,
    /// What the value tends to with that order.
    pub tends_to: Option<f64>,
    /// Error of the lattice on the finest one, a half width.
    pub lattice_error: Option<f64>,
    /// The same in quadrature with the interval on the finest one.
    pub error: Option<f64>,
    /// Whether `error` is below [`super::RESOLVED_SHARE`] of the value; `None` where that is not known.
    pub resolved: Option<bool>,
    /// The answer in words.
    pub verdict: String,
}

/// All results on the lattices of one series of runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ladder {
    /// Values of the other varied keys; empty without any.
    pub series: String,
    /// The lattices, coarsest first, as the varied key names them.
    pub lattices: Vec<String>,
    /// Sizes of their cells [m].
    pub cell_sizes_m: Vec<f64>,
    /// Runs done on each.
    pub starts: Vec<usize>,
    /// One row for each result.
    pub rungs: Vec<Rung>,
    /// Results of the finest lattice beside the values of others, with the error of the lattice.
    pub comparison: Vec<ComparisonRow>,
}

pub(super) fn last(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}
