//! Who may begin in a folder: nothing that could be gone on with, and nothing of another case, is lost without being asked for.

use std::path::Path;

use super::{Order, RunError, names};
use crate::case::{Case, changed_outputs, changed_physics};
use crate::checkpoint;
use crate::ledger::{Ledger, Machine, Program, State};
use crate::simulation::Simulation;

/// How a run begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Anew, in a folder that is empty, or holds a run of the very same case that is over.
    New,
    /// Anew, whatever run the folder holds.
    Overwrite,
    /// From the checkpoint in the folder.
    Resume,
}

/// Most differences that a message names.
const TOLD: usize = 4;

/// Looks whether the run may begin; returns the ledger of the run to go on with.
pub(super) fn admit(order: &Order) -> Result<Option<Ledger>, RunError> {
    let found = Ledger::read(order.folder);
    let precision = order.plan.placement.precision_name();
    match order.start {
        Start::New => refuse_others(order.folder, order.case, precision, found).map(|()| None),
        Start::Overwrite => Ok(None),
        Start::Resume => {
            // One that cannot be read is no reason to lose the checkpoint.
            let ledger = found.ok().flatten();
            match &ledger {
                Some(ledger) => refuse_other_physics(ledger, order)?,
                None if checkpoint::exists(order.folder) => {}
                None => {
                    return Err(RunError::Resume(format!(
                        "{} holds no run to resume: start without --resume",
                        order.folder.display()
                    )));
                }
            }
            Ok(ledger)
        }
    }
}

/// Refuses a folder that holds something to be lost.
fn refuse_others(
    folder: &Path,
    case: &Case,
    precision: &str,
    found: Result<Option<Ledger>, String>,
) -> Result<(), RunError> {
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
    let same = ledger.case.hash == case.hash && ledger.precision == precision;
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
pub(super) fn is_unfinished(folder: &Path, ledger: &Ledger) -> bool {
    !matches!(ledger.state, State::Finished | State::Diverged) && checkpoint::exists(folder)
}

/// Refuses to go on with a run of other physics, one that is over, and one that was killed before its first checkpoint.
fn refuse_other_physics(ledger: &Ledger, order: &Order) -> Result<(), RunError> {
    let folder = order.folder.display();
    let mut changed = changed_physics(&ledger.case.text, &order.case.text);
    if changed.is_empty() && ledger.case.physics != order.case.physics {
        changed.push("a file that the case names has changed".to_owned());
    }
    if !changed.is_empty() {
        return Err(RunError::Resume(format!(
            "{folder} belongs to another run: {}; a run goes on with its own physics: only titles, time.end_s, [output] and [comparison] may change",
            shortened(changed)
        )));
    }
    if checkpoint::exists(order.folder) {
        return Ok(());
    }
    Err(RunError::Resume(match ledger.state {
        State::Finished | State::Diverged => format!(
            "the run in {folder} is over ({} at t = {:.6} s): there is nothing to resume",
            ledger.state.name(),
            ledger.reached.time_s
        ),
        _ => {
            format!("the run in {folder} ended before its first checkpoint: start without --resume")
        }
    }))
}

/// Refuses a state that lies behind the end that the case asks for.
pub(super) fn refuse_past_the_end(simulation: &Simulation) -> Result<(), RunError> {
    let planned = simulation.plan().start_steps + simulation.plan().steps;
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
    if let Some(session) = ledger.session() {
        let (program, machine) = (Program::this(), Machine::this());
        let before = (&session.program, session.machine.to_string());
        if before != (&program, machine.to_string()) {
            notes.push(format!(
                "before, the run was computed by {} on {}, now by {program} on {machine}: the bits may differ from those of one run on either",
                before.0, before.1
            ));
        }
    }
    notes
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
    if told.is_empty() {
        told.push(if ledger.case.physics != case.physics {
            "a file that it names has changed".to_owned()
        } else if ledger.case.hash != case.hash {
            "its title, length, outputs, comparisons or variants have changed".to_owned()
        } else {
            format!("precision was {}, is now {precision}", ledger.precision)
        });
    }
    format!(": {}", shortened(told))
}
