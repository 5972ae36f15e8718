//! Faults of the program itself: a panic ends a run with what can be kept, and with one message.
//!
//! Between two steps, before anything of the next one has been sampled, the state is whole, and a checkpoint of it is written; where a device has begun the next step, after that. In a step, a
//! sample or a change of the lattice nobody knows how much of the state has been replaced: then the last checkpoint stays as it is.

use std::any::Any;
use std::backtrace::Backtrace;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::{Mutex, PoisonError};

/// Where faults are told at length: the log of a run, in its folder.
pub(super) const LOG_NAME: &str = "run.log";

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
            write!(f, "; {}; please report it, with {LOG_NAME}", self.kept)
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
