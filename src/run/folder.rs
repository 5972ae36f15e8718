//! Who may begin in a folder: nothing that could be gone on with, and nothing of another case, is lost without being asked for.

use std::path::Path;

use super::{Order, RunError, names};
use crate::case::{Case, changed_physics};
use crate::checkpoint;
use crate::ledger::{Ledger, State};

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
        // One that cannot be read is no reason to lose the checkpoint.
        Start::Resume => Ok(found.ok().flatten()),
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
    if told.len() > TOLD {
        let more = told.len() - TOLD;
        told.truncate(TOLD);
        told.push(format!("and {more} more"));
    }
    format!(": {}", told.join(", "))
}
