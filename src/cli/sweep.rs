//! `ripstop sweep CASE.toml --vary key.path=a,b,c`, `ripstop sweep CASE.toml --ensemble N`

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::case_arguments::{CaseArguments, Prepared, refuse_bare_wing};
use super::exit;
use super::failure::Failure;
use super::log::{emit, say};
use super::progress::Progress;
use super::run::seconds;
use super::signals::requests;
use crate::case::{Case, Problem};
use crate::measure;
use crate::output::{OutputError, Summary, prepare_directory};
use crate::report;
use crate::run::{self, Observer, Order, Requests, Start};
use crate::sweep::{self, Chosen, Outcome, Point, Status, Sweep, Vary, points};

/// Results in air that are shown where nothing is chosen, if the case has them, beside those that it compares.
const USUAL_RESULTS: [&str; 9] = [
    "drag_coefficient",
    "drag_n",
    "line_tension_max_n",
    "riser_force_terminal_n",
    "descent_rate_m_s",
    "terminal_speed_m_s",
    "projected_diameter_ratio",
    "fill_time_s",
    "largest_projected_diameter_time_s",
];

/// Columns of histories that are drawn where nothing is chosen, if the case has them.
const USUAL_HISTORIES: [&str; 2] = ["projected_diameter_ratio", "drag_coefficient"];

/// Key of the pull on a wing's brakes.
pub(super) const BRAKE_PULL: &str = "structure.wing.brake_pull_m";

#[derive(Debug, Args)]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub(super) case: CaseArguments,
    /// Key and its values; may be given several times, and then every combination runs. Keys that belong together vary together:
    /// "a=1,2; b=3,4" makes two runs. The value `absent` removes a key or table, `as_written` leaves it.
    #[arg(
        long,
        value_name = "KEY.PATH=A,B,C",
        required_unless_present = "ensemble"
    )]
    pub(super) vary: Vec<Vary>,
    /// Starts of every run, each with all that stands in the air moved by other parts of a cell; extremes get an interval from them.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=64))]
    pub(super) ensemble: Option<u8>,
    /// Result for the table and a chart; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub(super) result: Vec<String>,
    /// Column of history.csv for a chart of all runs over time; may be given several times.
    #[arg(long, value_name = "COLUMN")]
    pub(super) history: Vec<String>,
    /// Folder for the table, the charts, and a folder for each run. Runs found there that are done are kept.
    #[arg(long, default_value = "sweep")]
    pub(super) out: PathBuf,
    /// Begin runs anew whose folders hold another case's, as after a change of the case file.
    #[arg(long)]
    pub(super) overwrite: bool,
    /// Seconds of wall time between checkpoints of a run.
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = seconds)]
    pub(super) checkpoint_every: f64,
}

pub(super) fn sweep(arguments: &SweepArguments) -> Result<u8, Failure> {
    sweep_of(arguments, None)
}

/// A sweep that shows what is chosen; `None`: by its arguments.
pub(super) fn sweep_of(arguments: &SweepArguments, chosen: Option<Chosen>) -> Result<u8, Failure> {
    let usage = |why: String| Failure::Other(exit::BAD_CASE, format!("--vary: {why}"));
    let starts = arguments.ensemble.map(|n| Vary::ensemble(n.into()));
    let varies: Vec<Vary> = arguments.vary.iter().cloned().chain(starts).collect();
    let points = points(&varies).map_err(usage)?;
    // All cases first: a wrong value of the last must not show after hours.
    let mut cases = Vec::new();
    for point in &points {
        cases.push(arguments.case.load(&point.overrides())?);
    }
    for (point, case) in points.iter().zip(&cases) {
        refuse_bare_wing(case)?;
        refuse_brakes(point, case)?;
    }
    let Some(first) = cases.first() else {
        return Err(usage("there is no run".to_owned()));
    };
    let chosen = chosen.map_or_else(|| choose(arguments, first), Ok)?;
    prepare_directory(&arguments.out).map_err(output_failed)?;
    let earlier = Sweep::read(&arguments.out);
    let mut sweep = Sweep {
        schema_version: 1,
        title: first.scene.title.clone(),
        case: first.name.clone(),
        variant: first.variant.clone(),
        leading_keys: Sweep::leading(&varies),
        lattice_key: Sweep::lattice_key(&varies),
        runs: (points.iter().zip(&cases))
            .map(|(point, case)| known(arguments, earlier.as_ref(), point, case))
            .collect(),
        ladders: Vec::new(),
    };
    refuse_others(arguments, &points, &cases)?;
    let requests = requests("the sweep");
    let mut code = 0;
    let mut of_others = Vec::new();
    for (number, (point, case)) in points.iter().zip(cases).enumerate() {
        let heading = format!("run {} of {}: {}", number + 1, points.len(), point.folder);
        if sweep.runs[number].status == Status::Done {
            let by = if run::is_of_this_build(&arguments.out.join(&point.folder)) {
                ""
            } else {
                of_others.push(point.folder.as_str());
                " by another build of the program"
            };
            say(&format!("{heading}: kept, it is done{by}"));
            continue;
        }
        say(&heading);
        let ended = one(arguments, case, &mut sweep.runs[number], &requests);
        sweep::write(&arguments.out, &sweep, &chosen).map_err(output_failed)?;
        match ended {
            0 => {}
            exit::INTERRUPTED => {
                code = exit::INTERRUPTED;
                break;
            }
            other => {
                if let Some(message) = &sweep.runs[number].message {
                    say(&format!("{}: {message}", point.folder));
                }
                code = if code == 0 { other } else { code };
            }
        }
    }
    if !of_others.is_empty() {
        say(&format!(
            "runs of another build of the program were kept: {}; remove their folders to compute them anew",
            of_others.join(", ")
        ));
    }
    sweep::mark_unresolved(&mut sweep);
    sweep::write(&arguments.out, &sweep, &chosen).map_err(output_failed)?;
    report::write_sweep(&arguments.out, &sweep, &chosen).map_err(output_failed)?;
    emit(&sweep::markdown(&sweep, &chosen))?;
    emit(&format!(
        "tables, charts and runs: {}\nreport: {}\n",
        arguments.out.display(),
        arguments.out.join(report::FILE_NAME).display()
    ))?;
    Ok(code)
}

fn output_failed(error: OutputError) -> Failure {
    Failure::Other(exit::OUTPUT_FAILED, error.to_string())
}

/// Refuses brakes of a sweep on sections whose polars are given: these do not know the turned trailing edge.
fn refuse_brakes(point: &Point, case: &Case) -> Result<(), Failure> {
    let is_pulled = point.values.iter().any(|(key, value)| {
        key == BRAKE_PULL && value.parse::<f64>().is_ok_and(|pull_m| pull_m > 0.0)
    });
    let trim = case.scene.wing().and_then(|wing| wing.trim.as_ref());
    let is_given = trim.is_some_and(|trim| trim.sections.polars.iter().any(Option::is_some));
    if !(is_pulled && is_given) {
        return Ok(());
    }
    Err(Failure::Case(case.error(Problem::new(
        "equilibrium.trim.polars",
        format!(
            "in {}: a sweep of brakes needs polars of turned trailing edges; those of equilibrium.trim.polars are of sections as drawn",
            case.name
        ),
        "leave the brakes out, or the polars (`--set equilibrium.trim.polars=absent`): they are computed then, at every turn of the trailing edge",
    ))))
}

/// The results and histories to show: those asked for, which must exist, or the usual ones.
fn choose(arguments: &SweepArguments, case: &Case) -> Result<Chosen, Failure> {
    let names = measure::result_names(&case.scene);
    let columns = measure::history_columns(&case.scene);
    let unknown = |flag: &str, wanted: &str, known: &[&str]| {
        let known = known.join(", ");
        let text = format!("{flag} {wanted}: the case has only {known}");
        Failure::Other(exit::BAD_CASE, text)
    };
    if let Some(wanted) = arguments.result.iter().find(|name| !names.contains(name)) {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        return Err(unknown("--result", wanted, &known));
    }
    let column = |wanted: &str| columns.iter().find(|column| column.name == wanted).cloned();
    let histories = arguments.history.iter().map(|wanted| {
        column(wanted).ok_or_else(|| {
            let known: Vec<&str> = columns.iter().map(|column| &*column.name).collect();
            unknown("--history", wanted, &known)
        })
    });
    let mut chosen = Chosen {
        results: arguments.result.clone(),
        pairs: Vec::new(),
        histories: histories.collect::<Result<_, _>>()?,
    };
    if chosen.results.is_empty() {
        chosen.results = usual_results(case, names);
    }
    if chosen.histories.is_empty() {
        chosen.histories = USUAL_HISTORIES.into_iter().filter_map(column).collect();
    }
    Ok(chosen)
}

/// Those of the results of a case, `names`, that are shown where nothing is chosen.
fn usual_results(case: &Case, names: Vec<String>) -> Vec<String> {
    let mut shown: Vec<String> = Vec::new();
    if case.scene.equilibrium.is_some() {
        // What such a run prints first.
        let first = measure::headline(names.iter().map(String::as_str));
        shown = first.into_iter().map(str::to_owned).collect();
    }
    if shown.is_empty() {
        let in_air = USUAL_RESULTS.into_iter();
        let in_air = in_air.filter(|_| case.scene.air.is_some());
        let compared = case.scene.comparisons.iter().map(|c| c.quantity.as_str());
        for name in in_air.chain(compared) {
            let known = names.iter().any(|n| n == name);
            if known && !shown.iter().any(|n| n == name) {
                shown.push(name.to_owned());
            }
        }
    }
    if shown.is_empty() {
        shown = names.into_iter().take(6).collect();
    }
    shown
}

/// What an earlier sweep left of a run: kept if it is done, or can be resumed, and was made of the very same case.
fn known(
    arguments: &SweepArguments,
    earlier: Option<&Sweep>,
    point: &Point,
    case: &Case,
) -> Outcome {
    let hash = &case.hash;
    let cell_size_m = case.scene.air.as_ref().map(|air| air.units.cell_size_m);
    let mut outcome = Outcome::waiting(point, hash, cell_size_m);
    let before = earlier.and_then(|sweep| {
        let mut runs = sweep.runs.iter();
        runs.find(|run| run.folder == point.folder && run.hash == *hash)
    });
    if let Some(Status::Done) = before.map(|run| run.status) {
        let path = arguments.out.join(&point.folder).join("summary.json");
        let summary: Option<Summary> = std::fs::read(path)
            .ok()
            .and_then(|text| serde_json::from_slice(&text).ok());
        if let Some(summary) = summary.filter(|summary| summary.case.hash == *hash) {
            outcome.done(&summary);
        }
    }
    // Interrupted, or killed: its own folder tells.
    let folder = arguments.out.join(&point.folder);
    if outcome.status == Status::Waiting && run::is_unfinished_run(&folder, case) {
        outcome.status = Status::Interrupted;
    }
    outcome
}

/// Refuses a sweep that would replace runs of another case.
fn refuse_others(
    arguments: &SweepArguments,
    points: &[Point],
    cases: &[Case],
) -> Result<(), Failure> {
    if arguments.overwrite {
        return Ok(());
    }
    let others: Vec<&str> = (points.iter().zip(cases))
        .filter(|(point, case)| run::holds_another(&arguments.out.join(&point.folder), case))
        .map(|(point, _)| point.folder.as_str())
        .collect();
    if others.is_empty() {
        return Ok(());
    }
    let text = format!(
        "{} holds runs of another case: {}; --overwrite removes them, --out DIR takes another folder",
        arguments.out.display(),
        others.join(", ")
    );
    Err(Failure::Other(exit::OCCUPIED, text))
}

/// Computes one run; returns its exit code.
fn one(arguments: &SweepArguments, case: Case, outcome: &mut Outcome, requests: &Requests) -> u8 {
    let start = match outcome.status {
        Status::Interrupted => Start::Resume,
        _ => Start::New,
    };
    let folder = arguments.out.join(&outcome.folder);
    let mut fail = |code: u8, message: String| {
        outcome.status = Status::Failed;
        outcome.message = Some(message);
        code
    };
    let Prepared {
        case,
        plan,
        device,
        fallback,
    } = match arguments.case.plan(case) {
        Ok(prepared) => prepared,
        Err(Failure::Case(error)) => return fail(exit::BAD_CASE, error.to_string()),
        Err(Failure::NoDevice(message)) => return fail(exit::NO_DEVICE, message),
        Err(Failure::Other(code, message)) => return fail(code, message),
    };
    let mut progress = Progress::new();
    let result = run::run(
        Order {
            case: &case,
            plan,
            device,
            fallback,
            folder: &folder,
            start,
            // The folder has been looked at before the first run.
            overwrite: true,
            keep_final: false,
            checkpoint_interval: Duration::from_secs_f64(arguments.checkpoint_every),
        },
        requests,
        &mut progress,
    );
    progress.finish();
    match result {
        Ok(report) if report.interrupted => {
            outcome.status = Status::Interrupted;
            exit::INTERRUPTED
        }
        Ok(report) if report.unbalanced.is_some() => {
            outcome.done(&report.summary);
            outcome.status = Status::Failed;
            outcome.message = report.unbalanced;
            exit::DIVERGED
        }
        Ok(report) => {
            progress.note(&format!(
                "done: {} (t = {:.4} s, {:.1} s)",
                report.summary.stop.reason, report.summary.stop.when_s, report.summary.wall_s
            ));
            outcome.done(&report.summary);
            0
        }
        Err(error) => fail(super::run::exit_code(&error), error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Choices, SHIPPED, parse};

    /// What a sweep of a shipped case shows where nothing is chosen.
    fn shown(name: &str) -> Vec<String> {
        let (_, text) = SHIPPED.iter().find(|(known, _)| *known == name).unwrap();
        let case = parse(
            name,
            text,
            std::path::Path::new("cases"),
            &Choices::default(),
        )
        .unwrap();
        let names = measure::result_names(&case.scene);
        usual_results(&case, names)
    }

    #[test]
    fn canopies_show_their_loads() {
        let tunnel = shown("flat-circular-tunnel");
        let first = ["drag_coefficient", "drag_n", "line_tension_max_n"];
        assert_eq!(tunnel[..3], first);
        assert!(!tunnel.iter().any(|name| name == "riser_force_terminal_n"));
        let drop = shown("finite-mass-drop");
        assert_eq!(drop[..3], first);
        assert_eq!(drop[3], "riser_force_terminal_n");
        assert!(shown("sphere").iter().all(|name| !name.ends_with("_n")));
    }
}
