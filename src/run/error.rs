//! Why a run could not deliver.

use super::fault::Fault;
use crate::checkpoint::CheckpointError;
use crate::gpu::DeviceError;
use crate::ledger::LockError;
use crate::output::OutputError;
use crate::render;
use crate::simulation::{Diverged, Failure};
use crate::statics::RestoreError;

/// Why a run could not deliver.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The physics broke down; files up to then are kept.
    #[error("{0}")]
    Diverged(Diverged),
    /// The start state that the case asks for could not be reached.
    #[error("the run cannot start: {0}")]
    Start(String),
    /// The device failed; files up to then, the last checkpoint included, are kept.
    #[error("{0}")]
    Device(#[from] DeviceError),
    /// A file could not be written.
    #[error("{0}")]
    Output(#[from] OutputError),
    /// A picture could not be drawn.
    #[error("cannot draw a picture: {0}")]
    Picture(#[from] render::RenderError),
    /// There is nothing to resume from.
    #[error("{0}")]
    Checkpoint(#[from] CheckpointError),
    /// What is to be gone on with is a run of another case, or over.
    #[error("{0}")]
    Resume(String),
    /// The folder holds another run, or one that is not over.
    #[error("{0}")]
    Occupied(String),
    /// The program failed: what was computed since the last checkpoint may be lost.
    #[error("{0}")]
    Fault(Box<Fault>),
}

impl From<LockError> for RunError {
    fn from(error: LockError) -> Self {
        match error {
            LockError::Output(error) => Self::Output(error),
            held @ LockError::Held { .. } => Self::Occupied(held.to_string()),
        }
    }
}

impl From<Failure> for RunError {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Diverged(diverged) => Self::Diverged(diverged),
            Failure::Start(why) => Self::Start(why),
            Failure::Lacking(lacking) => Self::Start(lacking.to_string()),
            Failure::Device(error) => Self::Device(error),
        }
    }
}

impl From<RestoreError> for RunError {
    fn from(error: RestoreError) -> Self {
        match error {
            RestoreError::Checkpoint(error) => error.into(),
            RestoreError::Failure(failure) => failure.into(),
        }
    }
}
