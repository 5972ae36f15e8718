//! How a structure's motion is integrated in time (`src/cpu/cloth/integration.rs` has the formulas).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the fabric is integrated in time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeIntegration {
    /// First order: damps all motion that steps do not resolve finely.
    #[default]
    BackwardEuler,
    /// Backward differences of second order.
    Bdf2,
}
