//! What may be written as `friction` of fabric, bodies and parts of wings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the air passes along a surface (docs/cut-links.md#walls-along-which-the-air-slides).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Friction {
    /// It slides.
    None,
    /// It slides, and a model of the boundary layer gives the shear stress; only with `coupling.scheme = "links"`.
    Model,
    /// It sticks, and the cells hold the boundary layer.
    NoSlip,
}

impl Friction {
    /// Name in case files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Model => "model",
            Self::NoSlip => "no_slip",
        }
    }
}
