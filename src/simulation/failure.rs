//! What can end a run, or keep it from beginning.

use crate::gpu::DeviceError;
use crate::plan::capabilities::Lacking;

/// A run that broke down, or could not begin.
#[derive(Debug, Clone, thiserror::Error)]
pub enum Failure {
    /// The physics broke down.
    #[error("{0}")]
    Diverged(Diverged),
    /// The device failed.
    #[error("{0}")]
    Device(#[from] DeviceError),
    /// The start state that the case asks for could not be reached.
    #[error("the run cannot start: {0}")]
    Start(String),
    /// An engine of the plan cannot compute the scene.
    #[error("{0}")]
    Lacking(#[from] Lacking),
}

impl From<Diverged> for Failure {
    fn from(diverged: Diverged) -> Self {
        Self::Diverged(diverged)
    }
}

/// A run that broke down.
#[derive(Debug, Clone, thiserror::Error)]
#[error("the run diverged at t = {time_s:.6} s (step {step}): {what}")]
pub struct Diverged {
    /// Time since release [s].
    pub time_s: f64,
    /// Step since the start.
    pub step: u64,
    /// What broke, and where.
    pub what: String,
}
