//! Interrupts: what the signals of a terminal, a scheduler or a user ask of a command.

use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::exit;
use super::log::say;
use crate::run::Requests;

/// Interrupts that follow the first one within this time are the same one: process groups and schedulers send several.
const SAME: Duration = Duration::from_millis(500);

/// Requests that signals make, so that `what` ends with what it has after the present step. A later interrupt ends it at once: with code 75 where
/// there is a checkpoint to go on from, and 130 where there is none. Files are never half written. On Unix, SIGUSR1 asks for a checkpoint.
pub(super) fn requests(what: &str) -> Requests {
    let requests = Requests::default();
    let asked = requests.clone();
    let first: Mutex<Option<Instant>> = Mutex::new(None);
    let handler = move || {
        asked.stop.store(true, Ordering::Relaxed);
        let Ok(mut first) = first.lock() else {
            return;
        };
        if first.get_or_insert_with(Instant::now).elapsed() > SAME {
            let resumable = asked.resumable.load(Ordering::Relaxed);
            let code = if resumable {
                exit::INTERRUPTED
            } else {
                exit::ABORTED
            };
            std::process::exit(i32::from(code));
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        say(&format!(
            "warning: an interrupt will stop {what} without its results: {error}"
        ));
    }
    #[cfg(unix)]
    {
        let flag = std::sync::Arc::clone(&requests.checkpoint);
        if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGUSR1, flag) {
            say(&format!("warning: SIGUSR1 will stop {what}: {error}"));
        }
    }
    requests
}
