//! Panel shaping: panels of a wing cut anew, wider or narrower, until they fly as they were designed.

use serde::{Deserialize, Serialize};

use crate::case::wing_design::Ballooning;

/// A cut of the panels, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapingStep {
    /// Ballooning that the panels are cut with.
    pub cut: Ballooning,
    /// Ballooning flown: points as in `cut`, where it can be read.
    pub flown: Ballooning,
    /// Distance of neighbouring ribs over the designed one: points as in `cut`, where there are panels.
    pub widths: Ballooning,
    /// Largest difference of what is aimed at.
    pub error_max: f64,
    /// Root of the mean square of it.
    pub error_rms: f64,
    /// Width of cells over the designed one, mean.
    pub cell_width_ratio: f64,
}

/// A panel shaping as far as it has come.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PanelShaping {
    /// Cuts whose flight was read.
    pub steps: Vec<ShapingStep>,
    /// The cut that is sewn now; `None`: that of the plan.
    pub(super) cut: Option<Ballooning>,
    /// The equilibrium of that cut is not found yet.
    pub(super) is_unbalanced: bool,
}
