//! What can go wrong.

use crate::geometry::profile::ProfileError;

/// Why there is no flow.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AeroError {
    /// A surface cannot be made from what was given.
    #[error("{0}")]
    Surface(String),
    /// A profile is wrong.
    #[error("profile: {0}")]
    Profile(#[from] ProfileError),
    /// The onset flow is wrong.
    #[error("{0}")]
    Onset(String),
    /// The dense matrix would not fit.
    #[error(
        "{unknowns} unknowns need {needed_mib} MiB for their matrix; {limit_mib} MiB are allowed: take fewer panels, or a symmetric half"
    )]
    TooLarge {
        /// Panels, each with one unknown.
        unknowns: usize,
        /// Memory that they need [MiB].
        needed_mib: u64,
        /// Memory allowed [MiB].
        limit_mib: u64,
    },
    /// The equations have no solution.
    #[error(
        "the equations of the panels are singular (row {0}): look for panels that coincide, or a section that is thinner than rounding"
    )]
    Singular(usize),
    /// A polar is wrong.
    #[error("polar: {0}")]
    Polar(String),
}
