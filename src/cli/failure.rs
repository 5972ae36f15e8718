//! What ends a command early.

use crate::case::CaseError;

/// What ends a command early.
pub(super) enum Failure {
    Case(Box<CaseError>),
    NoDevice(String),
    Other(u8, String),
}

impl From<Box<CaseError>> for Failure {
    fn from(error: Box<CaseError>) -> Self {
        Self::Case(error)
    }
}
