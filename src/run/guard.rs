//! What a run does about faults: it catches them, tells what is left, and makes one where a test asks for it.

use std::path::Path;

use super::error::RunError;
use super::fault::caught;
use crate::checkpoint;
use crate::ledger::{Ledger, State};

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

/// Environment variable with which tests of the program itself ask for a fault: `between:N` before step N, `within:N` in the midst of it, `device:N` for
/// a device that is lost before step N.
///
/// A variable, since the tests start the program that users have: a feature of the build would test another one.
pub(super) const ON_PURPOSE: &str = "RIPSTOP_TEST_FAULT";

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Failing {
    /// The program, between two steps.
    Between,
    /// The program, where the state is no longer whole.
    Within,
    /// The device, between two steps; once, in a run that was not gone on with.
    Device,
}

/// A fault that a test asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OnPurpose {
    pub(super) step: u64,
    pub(super) what: Failing,
}

impl OnPurpose {
    /// What the environment asks for.
    pub(super) fn asked_for() -> Result<Option<Self>, RunError> {
        std::env::var_os(ON_PURPOSE).map_or(Ok(None), |text| {
            let text = text.to_string_lossy();
            Self::read(&text).map(Some).ok_or_else(|| {
                RunError::Start(format!(
                    "{ON_PURPOSE}={text} is none of between:STEP, within:STEP and device:STEP; unset it, as it is for tests of the program alone"
                ))
            })
        })
    }

    fn read(text: &str) -> Option<Self> {
        let (what, step) = text.split_once(':')?;
        let step = step.parse().ok()?;
        let what = match what {
            "between" => Failing::Between,
            "within" => Failing::Within,
            "device" => Failing::Device,
            _ => return None,
        };
        Some(Self { step, what })
    }

    /// True if a run is to have the fault, which may be `resumed`.
    pub(super) fn is_due(self, resumed: bool) -> bool {
        self.what != Failing::Device || !resumed
    }
}

impl std::fmt::Display for OnPurpose {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let what = match self.what {
            Failing::Between => "the run ends with a fault before",
            Failing::Within => "the run ends with a fault in",
            Failing::Device => "the device is lost before",
        };
        let step = self.step;
        write!(f, "warning: {ON_PURPOSE} is set, so {what} step {step}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_on_purpose_are_read_or_refused() {
        let of = |text: &str| OnPurpose::read(text).map(|fault| (fault.step, fault.what));
        assert_eq!(of("between:30"), Some((30, Failing::Between)));
        assert_eq!(of("within:7"), Some((7, Failing::Within)));
        assert_eq!(of("device:9"), Some((9, Failing::Device)));
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
