//! What can go wrong.

/// Why a section has no flow.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SectionError {
    /// The outline is no section.
    #[error("outline: {0}")]
    Outline(String),
    /// The conditions or angles make no sense.
    #[error("conditions: {0}")]
    Conditions(String),
    /// The panels' equations have no solution.
    #[error("the equations of the panels are singular: look for points that nearly coincide")]
    Singular,
    /// Newton's method found no solution at this angle.
    #[error(
        "no solution at {degrees:.2} degrees: the largest residual is {residual:.1e} after {steps} steps, as it is when flow separates widely"
    )]
    NotConverged {
        /// Angle of attack [degrees].
        degrees: f64,
        /// Largest residual left.
        residual: f64,
        /// Newton steps done.
        steps: usize,
    },
    /// Too many angles before it, outwards from no lift, have no solution.
    #[error("{degrees:.2} degrees was not tried: the angles before it have no solution")]
    GivenUp {
        /// Angle of attack [degrees].
        degrees: f64,
    },
}
