//! Faults of the program itself: a panic ends a run with what can be kept, and with one message.
//!
//! Between two steps, before anything of the next one has been sampled, the state is whole, and a checkpoint of it is written. In a step, a
//! sample or a change of the lattice nobody knows how much of the state has been replaced: then the last checkpoint stays as it is.

use std::any::Any;
use std::backtrace::Backtrace;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use super::{Run, RunError, log};
use crate::checkpoint;
use crate::ledger::{Ledger, State};

/// A panic that was caught.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Fault {
    /// What was said.
    pub message: String,
    /// Where in the program; absent without [`record_panics`].
    pub place: Option<String>,
    /// The calls that led there; absent without [`record_panics`].
    pub backtrace: Option<String>,
    /// What was kept of the run; empty where there was none.
    pub kept: String,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "internal fault: {}", self.message)?;
        if let Some(place) = &self.place {
            write!(f, " ({place})")?;
        }
        if self.kept.is_empty() {
            write!(f, "; please report it")
        } else {
            let name = log::FILE_NAME;
            write!(f, "; {}; please report it, with {name}", self.kept)
        }
    }
}

/// Place and backtrace of the last panic.
static LAST: Mutex<Option<(String, String)>> = Mutex::new(None);

/// From now on panics are remembered for whoever catches them, and print nothing themselves.
pub fn record_panics() {
    set_hook(Box::new(|panic| {
        let place = panic.location().map_or_else(String::new, |at| {
            format!("{}:{}:{}", at.file(), at.line(), at.column())
        });
        let backtrace = Backtrace::force_capture().to_string();
        *LAST.lock().unwrap_or_else(PoisonError::into_inner) = Some((place, backtrace));
    }));
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "nothing was said about it".to_owned())
}

/// The result of `work`, or the panic that ended it.
///
/// # Errors
///
/// When `work` panics.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let last = LAST.lock().unwrap_or_else(PoisonError::into_inner).take();
        let (place, backtrace) = last.unzip();
        Fault {
            message: message(&*payload),
            place,
            backtrace,
            kept: String::new(),
        }
    })
}

/// The same for what has errors of its own.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, RunError>) -> Result<T, RunError> {
    caught(work).unwrap_or_else(|fault| Err(RunError::Fault(Box::new(fault))))
}

/// After a fault: tells what is there to go on from, and brings a ledger up to date that still says `running`.
pub(super) fn settle<T>(folder: &Path, result: &mut Result<T, RunError>) {
    let Err(RunError::Fault(fault)) = result else {
        return;
    };
    if fault.kept.is_empty() {
        fault.kept = if checkpoint::exists(folder) {
            "the last checkpoint stays: --resume goes on from it".to_owned()
        } else {
            "there was no checkpoint to keep".to_owned()
        };
    }
    if let Ok(Some(mut ledger)) = Ledger::read(folder)
        && ledger.state == State::Running
        && (ledger.session()).is_some_and(|session| session.pid == std::process::id())
    {
        ledger.end_session(State::Failed, &fault.to_string());
        // The fault is told anyway.
        let _ = ledger.write(folder);
    }
}

impl Run<'_> {
    /// After a fault: writes a checkpoint, if the state is whole.
    pub(super) fn rescue(&mut self, fault: &mut Fault) {
        if self.whole && matches!(caught(|| self.save()), Ok(Ok(()))) {
            fault.kept = format!(
                "a checkpoint was written at t = {:.6} s: --resume goes on from it",
                self.simulation.time_s()
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error() {
        let result: Result<(), RunError> = guarded(|| panic!("{} is odd", 3));
        let Err(RunError::Fault(fault)) = result else {
            panic!("{result:?}");
        };
        assert_eq!(fault.message, "3 is odd");
        assert!(
            fault
                .to_string()
                .starts_with("internal fault: 3 is odd; please report it")
        );
        assert_eq!(guarded(|| Ok(4)).unwrap(), 4);
        let nothing = caught(|| std::panic::panic_any(5)).unwrap_err();
        assert_eq!(nothing.message, "nothing was said about it");
    }
}
