//! `ripstop report FOLDER` and `ripstop compare FOLDER FOLDER …`: pages of finished runs.

use std::path::PathBuf;

use clap::Args;

use super::exit;
use super::failure::Failure;
use super::log::emit;
use crate::output::{NOTHING, OutputError, Quantity, UNRESOLVED, aligned, with_interval};
use crate::report::{self, Difference, Finished};

#[derive(Debug, Args)]
pub(super) struct ReportArguments {
    /// Folder of a finished run.
    folder: PathBuf,
}

#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// Folders of two or more finished runs; the others are set against the first.
    #[arg(required = true, num_args = 2..)]
    folders: Vec<PathBuf>,
    /// Page to write.
    #[arg(long, value_name = "FILE", default_value = "compare.html")]
    out: PathBuf,
    /// All results, not only those that a run prints first.
    #[arg(long)]
    all: bool,
}

fn failed(error: &OutputError) -> Failure {
    Failure::Other(exit::OUTPUT_FAILED, error.to_string())
}

fn read(folder: &std::path::Path) -> Result<Finished, Failure> {
    Finished::read(folder).map_err(|error| Failure::Other(exit::BAD_CASE, error.to_string()))
}

pub(super) fn report(arguments: &ReportArguments) -> Result<u8, Failure> {
    let run = read(&arguments.folder)?;
    report::write(&run).map_err(|error| failed(&error))?;
    emit(&format!(
        "report: {}\n",
        arguments.folder.join(report::FILE_NAME).display()
    ))?;
    Ok(0)
}

pub(super) fn compare(arguments: &CompareArguments) -> Result<u8, Failure> {
    let folders = arguments.folders.iter();
    let runs: Vec<Finished> = folders
        .map(|folder| read(folder))
        .collect::<Result<_, _>>()?;
    let rows = report::differences(&runs, arguments.all);
    emit(&table(&runs, &rows))?;
    report::write_comparison(&runs, &arguments.out).map_err(|error| failed(&error))?;
    emit(&format!("page: {}\n", arguments.out.display()))?;
    Ok(0)
}

/// Names, values of every run, and differences from the first.
fn table(runs: &[Finished], rows: &[Difference]) -> String {
    let mut lines = vec![vec!["result".to_owned(), "unit".to_owned()]];
    for (number, name) in report::names(runs).into_iter().enumerate() {
        lines[0].push(name);
        if number > 0 {
            lines[0].push("against the first".to_owned());
        }
    }
    for row in rows {
        let mut line = vec![row.name.clone(), row.unit.clone()];
        for (number, found) in row.values.iter().enumerate() {
            line.push(found.as_ref().map_or_else(|| NOTHING.to_owned(), cell));
            if number > 0 {
                line.push(against(row, number));
            }
        }
        lines.push(line);
    }
    aligned(&lines)
}

fn cell(quantity: &Quantity) -> String {
    match &quantity.unresolved {
        Some(_) => format!("{} ({UNRESOLVED})", with_interval(quantity)),
        None => with_interval(quantity),
    }
}

fn against(row: &Difference, number: usize) -> String {
    let share = row.relative(number);
    let share = share.map_or_else(
        || NOTHING.to_owned(),
        |share| format!("{:+.1} %", 100.0 * share),
    );
    match row.beyond_intervals(number) {
        Some(true) => format!("{share}, beyond the intervals (in quadrature)"),
        Some(false) => format!("{share}, within the intervals"),
        None => share,
    }
}
