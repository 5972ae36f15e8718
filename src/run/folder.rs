//! Who may begin in a folder: nothing that could be gone on with, and nothing of another case, is lost without being asked for.

use std::path::Path;

use super::names;
use super::{Order, RunError, Start};
use crate::case::{Case, Scene, changed_outputs, changed_physics, number_in};
use crate::checkpoint;
use crate::ledger::{Ledger, Machine, Program, State};
use crate::simulation::Simulation;

/// Most differences that a message names.
const TOLD: usize = 4;

/// Looks whether the run may begin; returns the ledger of the run to go on with.
pub(super) fn admit(order: &Order) -> Result<Option<Ledger>, RunError> {
    let found = Ledger::read(order.folder);
    let precision = order.plan.placement.precision_name();
    let refuse = |why: String| Err(RunError::Resume(why));
    if let Start::From(settled) = order.start
        && same_folder(settled, order.folder)
    {
        return refuse(format!(
            "a restart from {} needs another folder: choose one with --out, or go on there with run --resume or --extend",
            settled.display()
        ));
    }
    match order.start {
        Start::New | Start::From(_) if order.overwrite => {}
        Start::New | Start::From(_) => {
            refuse_others(order, precision, found.clone())?;
        }
        Start::Resume | Start::Extend => {}
    }
    match order.start {
        Start::New => Ok(None),
        Start::From(settled) => {
            if !can_go_on(&order.case.scene) {
                return refuse(NO_MOTION.to_owned());
            }
            refuse_other_physics(settled, order.case, Ledger::read(settled).ok().flatten())?;
            Ok(None)
        }
        Start::Resume | Start::Extend => {
            // One that cannot be read is no reason to lose the checkpoint.
            let ledger = found.ok().flatten();
            refuse_other_physics(order.folder, order.case, ledger.clone())?;
            match &ledger {
                Some(ledger) if order.start == Start::Resume => refuse_what_is_over(ledger, order)?,
                _ => {}
            }
            Ok(ledger)
        }
    }
}

/// Why a run without motion has no state to go on from.
const NO_MOTION: &str =
    "the case has no motion to go on with: it seeks an equilibrium, or has no [time]";

/// True if a run of the scene can go on after its end: not from an equilibrium.
pub(super) fn can_go_on(scene: &Scene) -> bool {
    scene.time.is_some() && scene.equilibrium.is_none()
}

fn same_folder(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(std::fs::canonicalize);
    matches!((a, b), (Ok(a), Ok(b)) if a == b)
}

/// Refuses a folder that holds something to be lost.
fn refuse_others(
    order: &Order,
    precision: &str,
    found: Result<Option<Ledger>, String>,
) -> Result<(), RunError> {
    let (folder, case) = (order.folder, order.case);
    let refused = |what: String, ways: &str| {
        Err(RunError::Occupied(format!(
            "{} holds {what}; {ways}--overwrite removes it, --out DIR takes another folder",
            folder.display()
        )))
    };
    let ledger = match found {
        Err(what) => return refused(format!("a run: {what}"), ""),
        Ok(None) => {
            return match names::first_in(folder) {
                None => Ok(()),
                Some(name) => refused(format!("{name} of a run that kept no ledger"), ""),
            };
        }
        Ok(Some(ledger)) => ledger,
    };
    let from = match order.start {
        Start::From(settled) => Some(settled.display().to_string()),
        _ => None,
    };
    let same_start = ledger.begun_from == from;
    let same = ledger.case.hash == case.hash && ledger.precision == precision && same_start;
    let unfinished = is_unfinished(folder, &ledger);
    if same && !unfinished {
        return Ok(());
    }
    let mut what = match (same, unfinished) {
        (true, _) => "an unfinished run of this case".to_owned(),
        (false, true) => format!("an unfinished run of {}", name_of(&ledger)),
        (false, false) => format!("a run of {}", name_of(&ledger)),
    };
    what.push_str(&format!(
        " ({} at t = {:.6} s, begun {})",
        ledger.state.name(),
        ledger.reached.time_s,
        ledger.sessions.first().map_or("", |s| s.began.as_str())
    ));
    if let (false, Some(from)) = (same_start, &ledger.begun_from) {
        what.push_str(&format!(", from the state in {from}"));
    }
    if !same {
        what.push_str(&differences(&ledger, case, precision));
    }
    let ways = match (same, unfinished) {
        (true, _) => "--resume goes on with it, ",
        (false, true) => "--resume with its own case goes on with it, ",
        (false, false) => "",
    };
    refused(what, ways)
}

/// True if a run can be gone on with that is not over.
fn is_unfinished(folder: &Path, ledger: &Ledger) -> bool {
    !matches!(ledger.state, State::Finished | State::Diverged) && checkpoint::exists(folder)
}

/// Refuses to go on with a run of other physics, and where there is no checkpoint.
fn refuse_other_physics(
    folder: &Path,
    case: &Case,
    ledger: Option<Ledger>,
) -> Result<(), RunError> {
    let refuse = |why: String| Err(RunError::Resume(why));
    let checkpoints = checkpoint::exists(folder);
    let at = folder.display();
    let Some(ledger) = ledger else {
        return if checkpoints {
            Ok(())
        } else {
            refuse(format!(
                "{at} holds no run to go on with: look at the folder's name, or begin anew (`ripstop run` without --resume)"
            ))
        };
    };
    let mut changed = changed_physics(&ledger.case.text, &case.text);
    if changed.is_empty() && ledger.case.physics != case.physics {
        changed.push("a file that the case names has changed".to_owned());
    }
    if !changed.is_empty() {
        return refuse(format!(
            "{at} belongs to another run: {}; a run goes on with its own physics: only titles, time.end_s, [output] and [comparison] may change",
            shortened(changed)
        ));
    }
    if checkpoints {
        return Ok(());
    }
    refuse(match ledger.state {
        State::Finished | State::Diverged => format!(
            "the run in {at} is over ({} at t = {:.6} s) and left no state to go on from",
            ledger.state.name(),
            ledger.reached.time_s
        ),
        _ => format!(
            "the run in {at} ended before its first checkpoint: begin anew, with --overwrite in place of --resume"
        ),
    })
}

/// Refuses to resume a finished run whose end has not been put off.
fn refuse_what_is_over(ledger: &Ledger, order: &Order) -> Result<(), RunError> {
    let before = number_in(&ledger.case.text, "time.end_s");
    let now = order.case.scene.time.map(|time| time.end_s);
    if ledger.state != State::Finished || now > before {
        return Ok(());
    }
    Err(RunError::Resume(format!(
        "the run in {} is over (finished at t = {:.6} s): raise time.end_s, or give --extend SECONDS in place of --resume",
        order.folder.display(),
        ledger.reached.time_s
    )))
}

/// Overrides with which a run that goes on keeps what follows from its length as it was begun, or ends later as asked for; and whether it is an
/// extension.
///
/// # Errors
///
/// When a run is to be extended that is not over, or left no state.
pub fn carried_over(
    folder: &Path,
    case: &Case,
    extend_s: Option<f64>,
) -> Result<(Vec<String>, bool), RunError> {
    let refuse = |why: String| Err(RunError::Resume(format!("--extend: {why}")));
    let at = folder.display();
    let ledger = match (Ledger::read(folder).ok().flatten(), extend_s) {
        (Some(ledger), _) => ledger,
        (None, None) => return Ok((Vec::new(), false)),
        (None, Some(_)) => return refuse(format!("{at} holds no run that is over")),
    };
    let unfinished = is_unfinished(folder, &ledger);
    let end_s = case.scene.time.map(|time| time.end_s);
    let to_s = match extend_s {
        Some(_) if !can_go_on(&case.scene) => return refuse(NO_MOTION.to_owned()),
        Some(_) if unfinished => {
            return refuse(format!(
                "the run in {at} is not over: --resume goes on with it"
            ));
        }
        Some(_) if ledger.state != State::Finished || !checkpoint::exists(folder) => {
            return refuse(format!("the run in {at} left no state to go on from"));
        }
        Some(seconds) => Some(ledger.reached.time_s + seconds),
        // An extension that was interrupted.
        None => ledger
            .extended_to_s
            .filter(|to| unfinished && end_s.is_some_and(|end| end < *to)),
    };
    let mut overrides = Vec::new();
    overrides.extend(to_s.map(|to| format!("time.end_s={to:?}")));
    let sampled = "output.sample_interval_s";
    let other = to_s.is_some() || case.scene.output.sample_interval_s != ledger.sample_interval_s;
    if other && can_go_on(&case.scene) && number_in(&case.text, sampled).is_none() {
        overrides.push(format!("{sampled}={:?}", ledger.sample_interval_s));
    }
    Ok((overrides, to_s.is_some()))
}

/// True if `folder` holds a run of another case, or of a version without a ledger.
#[must_use]
pub fn holds_another(folder: &Path, case: &Case) -> bool {
    match Ledger::read(folder) {
        Ok(Some(ledger)) => ledger.case.hash != case.hash,
        Ok(None) => names::first_in(folder).is_some(),
        Err(_) => true,
    }
}

/// True unless the ledger in `folder` tells that another build of the program worked on the run.
#[must_use]
pub fn is_of_this_build(folder: &Path) -> bool {
    let ledger = Ledger::read(folder).ok().flatten();
    ledger.is_none_or(|ledger| {
        let mut sessions = ledger.sessions.iter();
        sessions.all(|session| session.program == Program::this())
    })
}

/// True if `folder` holds a run of that very case that can be gone on with and is not over.
#[must_use]
pub fn is_unfinished_run(folder: &Path, case: &Case) -> bool {
    let ledger = Ledger::read(folder).ok().flatten();
    ledger.is_some_and(|l| l.case.hash == case.hash && is_unfinished(folder, &l))
}

/// Refuses a state that lies behind the end that the case asks for.
pub(super) fn refuse_past_the_end(simulation: &Simulation) -> Result<(), RunError> {
    let plan = simulation.plan();
    let planned = plan.start_steps.saturating_add(plan.steps);
    let Some(time) = simulation.scene().time else {
        return Ok(());
    };
    if simulation.step_count() <= planned {
        return Ok(());
    }
    Err(RunError::Resume(format!(
        "the run has come to t = {:.6} s, behind time.end_s = {} s: raise it, as with --set time.end_s={}",
        simulation.time_s(),
        time.end_s,
        // With room to go on.
        (1.25 * simulation.time_s() * 1e3).ceil() / 1e3
    )))
}

/// True if pictures are asked for at other times than the run was begun with.
pub(super) fn has_other_pictures(ledger: &Ledger, case: &Case) -> bool {
    let changed = changed_outputs(&ledger.case.text, &case.text);
    changed
        .iter()
        .any(|line| line.starts_with("output.picture_times_s "))
}

/// What is not as it was when the run was worked on last: notes for who resumes it.
pub(super) fn what_changed(ledger: &Ledger, case: &Case) -> Vec<String> {
    let mut notes = Vec::new();
    let outputs = changed_outputs(&ledger.case.text, &case.text);
    if !outputs.is_empty() {
        notes.push(format!("since before: {}", shortened(outputs)));
    }
    let sampled_s = case.scene.output.sample_interval_s;
    if ledger.sample_interval_s != sampled_s {
        notes.push(format!(
            "warning: samples before lie {} s apart, those from here on {sampled_s} s: spectra and intervals count on one distance",
            ledger.sample_interval_s
        ));
    }
    notes.extend(another_computer(ledger, "the run"));
    notes
}

/// A note if another program or machine computed `what`, which is gone on with, than computes now.
pub(super) fn another_computer(ledger: &Ledger, what: &str) -> Option<String> {
    let session = ledger.session()?;
    let (program, machine) = (Program::this(), Machine::this());
    let before = (&session.program, session.machine.to_string());
    (before != (&program, machine.to_string())).then(|| {
        format!(
            "before, {what} was computed by {} on {}, now by {program} on {machine}: the bits may differ from those of one run on either",
            before.0, before.1
        )
    })
}

/// The first of many lines.
fn shortened(mut lines: Vec<String>) -> String {
    if lines.len() > TOLD {
        let more = lines.len() - TOLD;
        lines.truncate(TOLD);
        lines.push(format!("and {more} more"));
    }
    lines.join(", ")
}

/// Case file, variant and overrides of a run, as they were given.
fn name_of(ledger: &Ledger) -> String {
    let case = &ledger.case;
    let variant = case.variant.as_ref();
    let mut text = case.file.clone();
    text.push_str(&variant.map_or_else(String::new, |v| format!(" --variant {v}")));
    for change in case.overrides.iter().take(TOLD) {
        text.push_str(&format!(" --set {change}"));
    }
    if case.overrides.len() > TOLD {
        text.push_str(" …");
    }
    text
}

/// What of a case differs from that of a run, where it is the same file.
fn differences(ledger: &Ledger, case: &Case, precision: &str) -> String {
    if ledger.case.file != case.name {
        return String::new();
    }
    let mut told = changed_physics(&ledger.case.text, &case.text);
    if told.is_empty() && ledger.case.physics != case.physics {
        told.push("a file that it names has changed".to_owned());
    }
    told.extend(changed_outputs(&ledger.case.text, &case.text));
    if told.is_empty() {
        told.push(if ledger.precision == precision {
            "its variants or its start have changed".to_owned()
        } else {
            format!("precision was {}, is now {precision}", ledger.precision)
        });
    }
    format!(": {}", shortened(told))
}
