//! What is asked of a run while it goes on.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Flags between a run and who may interrupt it, such as handlers of signals.
#[derive(Debug, Clone, Default)]
pub struct Requests {
    /// Write a checkpoint and end, after the present step or iteration of a minimiser.
    pub stop: Arc<AtomicBool>,
    /// Write a checkpoint after the present step or iteration, and go on.
    pub checkpoint: Arc<AtomicBool>,
    /// Set by the run: its folder holds a checkpoint to go on from.
    pub resumable: Arc<AtomicBool>,
}

impl Requests {
    /// True if the run is to end.
    #[must_use]
    pub fn to_stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// True until [`Requests::takes_checkpoint`].
    pub(super) fn wants_checkpoint(&self) -> bool {
        self.checkpoint.load(Ordering::Relaxed)
    }

    /// True once for each request of a checkpoint.
    pub(super) fn takes_checkpoint(&self) -> bool {
        self.checkpoint.swap(false, Ordering::Relaxed)
    }

    pub(super) fn set_resumable(&self, resumable: bool) {
        self.resumable.store(resumable, Ordering::Relaxed);
    }
}
