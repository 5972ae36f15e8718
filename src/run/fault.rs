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

/// Environment variable with which tests of the program itself ask for a fault: `between:N` before step N, `within:N` in the midst of it.
///
/// A variable, since the tests start the program that users have: a feature of the build would test another one.
const ON_PURPOSE: &str = "RIPSTOP_TEST_FAULT";

/// A fault that a test asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OnPurpose {
    step: u64,
    /// Where the state is no longer whole.
    within: bool,
}

impl OnPurpose {
    /// What the environment asks for.
    pub(super) fn asked_for() -> Result<Option<Self>, RunError> {
        std::env::var_os(ON_PURPOSE).map_or(Ok(None), |text| {
            let text = text.to_string_lossy();
            Self::read(&text).map(Some).ok_or_else(|| {
                RunError::Start(format!(
                    "{ON_PURPOSE}={text} is neither between:STEP nor within:STEP; unset it, as it is for tests of the program alone"
                ))
            })
        })
    }

    fn read(text: &str) -> Option<Self> {
        let (place, step) = text.split_once(':')?;
        let step = step.parse().ok()?;
        match place {
            "between" => Some(Self {
                step,
                within: false,
            }),
            "within" => Some(Self { step, within: true }),
            _ => None,
        }
    }
}

impl std::fmt::Display for OnPurpose {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let place = if self.within { "in" } else { "before" };
        let step = self.step;
        write!(
            f,
            "warning: {ON_PURPOSE} is set, so the run ends with a fault {place} step {step}"
        )
    }
}

impl Run<'_> {
    /// Panics if a test asks for it at this step, and the state is whole as it asks for.
    #[allow(clippy::panic, reason = "what follows a panic is to be tested")]
    pub(super) fn fail_on_purpose(&self) {
        let now = OnPurpose {
            step: self.simulation.step_count(),
            within: !self.whole,
        };
        if self.on_purpose == Some(now) {
            panic!("a fault on purpose, as {ON_PURPOSE} asks for");
        }
    }

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
    fn faults_on_purpose_are_read_or_refused() {
        let of = |text: &str| OnPurpose::read(text).map(|fault| (fault.step, fault.within));
        assert_eq!(of("between:30"), Some((30, false)));
        assert_eq!(of("within:7"), Some((7, true)));
        for text in ["", "30", "between:", "between:-1", "after:3", "within: 3"] {
            assert_eq!(of(text), None, "{text}");
        }
    }

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
