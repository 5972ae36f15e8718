//! A finished run, as its folder holds it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::ledger::{Ledger, State};
use crate::measure::CHARTS;
use crate::measure::shared::{DRAG_COEFFICIENT, FORCE_X};
use crate::output::{ReadOut, Summary};

/// Name of the column with the time.
pub(super) const TIME: &str = "time_s";

/// Why a folder holds no run that can be reported.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// There is no summary.
    #[error("{} holds no finished run: {why}; give the folder that `ripstop run` wrote into with --out", folder.display())]
    NoRun {
        /// The folder.
        folder: PathBuf,
        /// What is wrong.
        why: String,
    },
}

/// A run that has come to an end, whatever it was.
#[derive(Debug, Clone)]
pub struct Finished {
    /// Its folder.
    pub folder: PathBuf,
    /// Its results.
    pub summary: Summary,
    /// What was asked for, and who computed it; `None` where the folder has no ledger that can be read.
    pub ledger: Option<Ledger>,
    /// The time and the charted columns of its history: name and samples.
    pub history: Vec<(String, Vec<f64>)>,
    /// Names of its pictures, in the order of their times.
    pub pictures: Vec<String>,
}

impl Finished {
    /// Reads a run's folder.
    ///
    /// # Errors
    ///
    /// When there is no summary in it that can be read.
    pub fn read(folder: &Path) -> Result<Self, FolderError> {
        let no_run = |why: String| FolderError::NoRun {
            folder: folder.to_owned(),
            why,
        };
        let text = std::fs::read(folder.join("summary.json"))
            .map_err(|error| no_run(format!("summary.json cannot be read ({error})")))?;
        let summary = serde_json::from_slice(&text)
            .map_err(|error| no_run(format!("summary.json cannot be read ({error})")))?;
        Ok(Self {
            folder: folder.to_owned(),
            summary,
            ledger: Ledger::read(folder).ok().flatten(),
            history: history(&folder.join("history.csv")),
            pictures: pictures(folder),
        })
    }

    /// The samples of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let found = self.history.iter().find(|(known, _)| known == name);
        found.map(|(_, samples)| &samples[..])
    }

    /// What names of columns begin with: nothing where columns have no owner, or none is known, and each rigid body's own where there are several, or
    /// fabric beside one.
    pub(super) fn owners(&self) -> Vec<String> {
        let has = |owner: &str, column: &ReadOut| {
            let name = format!("{owner}{}", column.name);
            self.column(&name).is_some()
        };
        let bodies = self.history.iter().filter_map(|(name, _)| {
            let owner = name.strip_suffix(&*DRAG_COEFFICIENT.name)?;
            // Bodies alone have both.
            let is_body = owner.ends_with('_') && has(owner, &FORCE_X);
            is_body.then(|| owner.to_owned())
        });
        let bodies: Vec<String> = bodies.collect();
        let has_own = CHARTS.iter().any(|column| has("", column));
        let own = (has_own || bodies.is_empty()).then(String::new);
        own.into_iter().chain(bodies).collect()
    }
}

/// What tells runs from each other: the last parts of their folders' paths, or where these agree the whole paths.
#[must_use]
pub fn names(runs: &[Finished]) -> Vec<String> {
    let last = |run: &Finished| {
        let name = run.folder.file_name();
        name.map(|name| name.to_string_lossy().into_owned())
    };
    let short: BTreeSet<String> = runs.iter().filter_map(last).collect();
    let whole = |run: &Finished| run.folder.display().to_string();
    let tells = short.len() == runs.len();
    let name = |run: &Finished| {
        let name = last(run).filter(|_| tells).unwrap_or_else(|| whole(run));
        let state = &run.summary.stop.state[..];
        // Those of earlier versions tell none.
        if state.is_empty() || state == State::Finished.name() {
            name
        } else {
            format!("{name} ({state})")
        }
    };
    runs.iter().map(name).collect()
}

/// The time and the charted columns of a history; none of a file that cannot be read. What is no number is not known.
fn history(path: &Path) -> Vec<(String, Vec<f64>)> {
    let Ok(mut reader) = csv::Reader::from_path(path) else {
        return Vec::new();
    };
    let Ok(headers) = reader.headers().cloned() else {
        return Vec::new();
    };
    let is_wanted =
        |name: &str| name == TIME || CHARTS.iter().any(|column| name.ends_with(&*column.name));
    let mut columns: Vec<(usize, String, Vec<f64>)> = (headers.iter().enumerate())
        .filter(|(_, name)| is_wanted(name))
        .map(|(place, name)| (place, name.to_owned(), Vec::new()))
        .collect();
    for record in reader.records().flatten() {
        for (place, _, samples) in &mut columns {
            let number = record.get(*place).and_then(|text| text.parse().ok());
            samples.push(number.unwrap_or(f64::NAN));
        }
    }
    let columns = columns.into_iter();
    columns.map(|(_, name, samples)| (name, samples)).collect()
}

fn pictures(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| {
            let ours = ["snapshot_", "trim", "load_test"];
            name.ends_with(".png") && ours.iter().any(|own| name.starts_with(own))
        })
        .collect();
    names.sort();
    names
}
