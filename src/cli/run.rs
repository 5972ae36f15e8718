//! `ripstop run CASE.toml`

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::answer::{answer_text, broken_down_text};
use super::case_arguments::{CaseArguments, Prepared};
use super::exit;
use super::failure::Failure;
use super::log::emit;
use super::profile;
use super::progress::Progress;
use super::signals::requests;
use crate::measure::headline;
use crate::output::{AccountRow, ExpectedError, Summary, ValidityRow, comparison_text};
use crate::report::Finished;
use crate::run::{self, Order, Report, RunError, Start};

#[derive(Debug, Args)]
pub(super) struct RunArguments {
    #[command(flatten)]
    case: CaseArguments,
    /// Folder for all results.
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// Continue an interrupted run from the checkpoint in its folder; titles, time.end_s, outputs and comparisons may be others than before.
    #[arg(long)]
    resume: bool,
    /// Go on with a finished run for so many seconds after its end, however steady it is.
    #[arg(long, value_name = "SECONDS", conflicts_with = "resume", value_parser = seconds)]
    extend: Option<f64>,
    /// Begin anew in a folder that holds another run, or one that is not over: its files are removed, those of others stay.
    #[arg(long, conflicts_with_all = ["resume", "extend"])]
    overwrite: bool,
    /// Do not keep the state at the end (final.checkpoint), from which a run can be extended and others can begin.
    #[arg(long)]
    no_final_state: bool,
    /// Seconds of wall time between checkpoints.
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = seconds)]
    checkpoint_every: f64,
    /// Print what every stage of a step took; with a device also what it was asked for, its own clock, and its latencies.
    #[arg(long)]
    profile: bool,
    /// Print all results with their notes, what the set-up supports and what was solved, not only the headline.
    #[arg(long)]
    all: bool,
    /// End with exit code 1 where the set-up does not support its results, or a solver or balance misses its limit.
    #[arg(long)]
    strict: bool,
}

#[derive(Debug, Args)]
pub(super) struct RestartArguments {
    /// Folder of the run whose newest state is the start.
    #[arg(value_name = "FROM")]
    from: PathBuf,
    #[command(flatten)]
    run: RunArguments,
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (1e-3..=1e9).contains(&value) => Ok(value),
        _ => Err("a number of seconds from 0.001 to 1e9 is needed".to_owned()),
    }
}

pub(super) fn restart(arguments: &RestartArguments) -> Result<u8, Failure> {
    let run = &arguments.run;
    if run.resume || run.extend.is_some() {
        let text = "restart begins a new run: --resume and --extend belong to `ripstop run`";
        return Err(Failure::Other(exit::BAD_CASE, text.to_owned()));
    }
    begin(run, Start::From(&arguments.from))
}

pub(super) fn run(arguments: &RunArguments) -> Result<u8, Failure> {
    let start = match (arguments.resume, arguments.extend) {
        (true, _) => Start::Resume,
        (false, Some(_)) => Start::Extend,
        (false, None) => Start::New,
    };
    begin(arguments, start)
}

/// The case of a run that begins, or goes on: what follows from its length stays as it was begun.
fn prepare<'a>(
    arguments: &RunArguments,
    start: Start<'a>,
) -> Result<(Prepared, Start<'a>), Failure> {
    let case = arguments.case.load(&[])?;
    if !matches!(start, Start::Resume | Start::Extend) {
        return Ok((arguments.case.plan(case)?, start));
    }
    let (more, extended) = run::carried_over(&arguments.out, &case, arguments.extend)
        .map_err(|error| Failure::Other(exit_code(&error), error.to_string()))?;
    let case = if more.is_empty() {
        case
    } else {
        arguments.case.load(&more)?
    };
    let start = if extended { Start::Extend } else { start };
    Ok((arguments.case.plan(case)?, start))
}

fn begin(arguments: &RunArguments, start: Start<'_>) -> Result<u8, Failure> {
    let (prepared, start) = prepare(arguments, start)?;
    let Prepared {
        case,
        plan,
        device,
        fallback,
    } = prepared;
    let requests = requests("the run");
    let mut progress = Progress::new();
    if let (true, Some(device)) = (arguments.profile, &device) {
        device.measure_latencies(profile::LATENCY_TIME)?;
        device.time_passes();
    }
    let result = run::run(
        Order {
            case: &case,
            plan,
            device,
            fallback,
            folder: &arguments.out,
            start,
            overwrite: arguments.overwrite,
            keep_final: !arguments.no_final_state,
            checkpoint_interval: Duration::from_secs_f64(arguments.checkpoint_every),
        },
        &requests,
        &mut progress,
    );
    progress.finish();
    match result {
        Ok(report) => {
            emit(&if arguments.all {
                report_text(&report, &arguments.out)
            } else {
                answer_text(&report, &arguments.out)
            })?;
            if arguments.profile {
                emit(&profile::text(&report.summary))?;
            }
            if let Some(what) = &report.unbalanced {
                return Err(Failure::Other(
                    exit::DIVERGED,
                    format!("{what}; the results are those of a state out of balance"),
                ));
            }
            if report.interrupted {
                return Ok(exit::INTERRUPTED);
            }
            if arguments.strict {
                let account = report.summary.account.iter();
                let missed = account.filter(|row| row.reached == Some(false));
                let others = unsettled(&report.summary);
                return strict(
                    &report.summary.validity,
                    missed.map(AccountRow::line).chain(others),
                );
            }
            Ok(0)
        }
        Err(error) => {
            let code = exit_code(&error);
            let kept = if code == exit::DIVERGED {
                // An opening that breaks down after its peak has told its loads.
                if let Ok(run) = Finished::read(&arguments.out) {
                    emit(&broken_down_text(&run.summary))?;
                }
                format!("\nresults up to then are in {}", arguments.out.display())
            } else {
                String::new()
            };
            Err(Failure::Other(code, format!("{error}{kept}")))
        }
    }
}

/// Why results of the headline are not resolved, besides rows of the table of validity: what had not settled. A drop that opens is computed for its
/// opening, and may end before its fall has settled.
fn unsettled(summary: &Summary) -> Vec<String> {
    let mut names = headline(summary.results.iter().map(|(name, _)| name));
    if summary.results.get("peak_load_factor_g").is_some() {
        names.retain(|name| !name.contains("terminal"));
    }
    let told: Vec<String> = summary.validity.iter().map(ValidityRow::finding).collect();
    let of_headline = (summary.results.iter()).filter(|(name, _)| names.contains(name));
    let mut reasons: Vec<String> = of_headline
        .filter_map(|(_, quantity)| quantity.unresolved.as_deref())
        .flat_map(|why| why.split("; "))
        .map(str::to_owned)
        .filter(|why| !told.iter().any(|finding| finding.contains(why)))
        .collect();
    reasons.sort_unstable();
    reasons.dedup();
    reasons
}

/// What `--strict` makes of a table: an error that names all that does not keep to it.
pub(super) fn strict(
    validity: &[ValidityRow],
    missed: impl Iterator<Item = String>,
) -> Result<u8, Failure> {
    let invalid = validity.iter().filter(|row| row.valid == Some(false));
    let mut found: Vec<String> = invalid.map(ValidityRow::finding).collect();
    found.extend(missed);
    if found.is_empty() {
        return Ok(0);
    }
    let text = format!(
        "--strict: the results are not supported:\n  {}",
        found.join("\n  ")
    );
    Err(Failure::Other(exit::GATE_FAILED, text))
}

/// The table of validity and the expected errors as lines.
pub(super) fn validity_text(validity: &[ValidityRow], expected: &[ExpectedError]) -> String {
    let mut lines = Vec::new();
    if !validity.is_empty() {
        lines.push("validity:".to_owned());
        lines.extend(validity.iter().map(|row| format!("  {}", row.line())));
    }
    if !expected.is_empty() {
        lines.push("error to be expected (bodies: within a factor of two; canopies, wings: from one case each):".to_owned());
        lines.extend(expected.iter().map(|error| format!("  {}", error.line())));
    }
    lines.join("\n")
}

pub(super) const fn exit_code(error: &RunError) -> u8 {
    match error {
        RunError::Diverged(_) => exit::DIVERGED,
        RunError::Occupied(_) => exit::OCCUPIED,
        RunError::Checkpoint(_) | RunError::Resume(_) | RunError::Start(_) => exit::BAD_CASE,
        RunError::Device(_) => exit::NO_DEVICE,
        RunError::Output(_) | RunError::Picture(_) => exit::OUTPUT_FAILED,
        RunError::Fault(_) => exit::FAULT,
    }
}

fn report_text(report: &Report, out: &Path) -> String {
    let mut lines = Vec::new();
    let summary = &report.summary;
    lines.push(summary.case.title.clone());
    lines.push(summary.table().trim_end().to_owned());
    if !summary.comparison.is_empty() {
        lines.push("beside the values of others:".to_owned());
        lines.push(comparison_text(&summary.comparison).trim_end().to_owned());
    }
    lines.push(format!(
        "stopped: {} (t = {:.4} s)",
        summary.stop.reason, summary.stop.when_s
    ));
    let validity = validity_text(&summary.validity, &summary.expected_errors);
    if !validity.is_empty() {
        lines.push(validity);
    }
    if !summary.account.is_empty() {
        lines.push("what was solved, and how well:".to_owned());
        let rows = summary.account.iter();
        lines.extend(rows.map(|row| format!("  {}", row.line())));
    }
    let cost = &summary.milliseconds_per_step;
    let text: Vec<String> = [
        ("fluid", cost.fluid),
        ("coupling", cost.coupling),
        ("cloth", cost.cloth),
        ("of which contact", cost.contact),
        ("measure", cost.measure),
    ]
    .iter()
    .filter_map(|(name, value)| value.map(|v| format!("{name} {v:.2}")))
    .collect();
    if !text.is_empty() {
        lines.push(format!("ms per step: {}", text.join(", ")));
    }
    let mut line = match summary.resumed_at_step {
        Some(earlier) => format!(
            "{} steps after {earlier} of an earlier run, in {:.1} s",
            summary.steps - earlier.min(summary.steps),
            summary.wall_s
        ),
        None => format!("{} steps in {:.1} s", summary.steps, summary.wall_s),
    };
    let on = |engine: &str, device: &str, precision: &str| {
        if engine == "gpu" {
            format!("on {device} ({precision})")
        } else {
            format!("on {} threads ({precision})", summary.threads)
        }
    };
    if let Some(rate) = summary.million_lattice_updates_per_s {
        line.push_str(&format!(
            "; air: {rate:.0} million lattice updates per second {}",
            on(&summary.engine, &summary.device, &summary.precision)
        ));
    }
    if let Some(fabric) = summary.fabric.as_ref().filter(|f| f.engine == "gpu") {
        line.push_str(&format!(
            "; fabric {}",
            on(&fabric.engine, &fabric.device, &fabric.precision)
        ));
    }
    lines.push(line);
    for note in summary.notes.iter().chain(&summary.details) {
        lines.push(format!("note: {note}"));
    }
    if let Some(picture) = &report.last_picture {
        lines.push(format!("picture: {}", picture.display()));
    }
    lines.push(format!("all results: {}", out.display()));
    lines.join("\n") + "\n"
}
