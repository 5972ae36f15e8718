//! What may be written in `[output]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::frame::{FabricQuantity, FlowQuantity};

/// What to write, and how often.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Time between rows of `history.csv` (docs/read-outs.md) [s]; a 500th of `time.end_s` if absent.
    pub sample_interval_s: Option<f64>,
    /// Time between ParaView files of the structure [s]; only the last state if absent.
    pub canopy_interval_s: Option<f64>,
    /// Time between ParaView files of rigid bodies [s]; only the last state if absent.
    pub bodies_interval_s: Option<f64>,
    /// Time between ParaView files of the air [s]; only the last state if absent.
    pub flow_interval_s: Option<f64>,
    /// Times of pictures besides the last [s]; none if absent.
    pub picture_times_s: Option<Vec<f64>>,
    /// What the colours of the fabric show, one picture each; `tension` if absent. The first is `snapshot_NNN.png`, others
    /// `snapshot_NNN_wrinkles.png` and so on.
    pub picture_fabric: Option<Vec<FabricQuantity>>,
    /// What the slice of air shows, one picture each; `speed` if absent. Named like those of the fabric.
    pub picture_flow: Option<Vec<FlowQuantity>>,
    /// Arrows of the air's velocity on the slice, as long as their distance at the speed of the wind; `false` if absent.
    pub picture_arrows: Option<bool>,
    /// Time between frames of `animation.png`, an animated PNG of the first quantities [s]; absent: none.
    pub animation_interval_s: Option<f64>,
    /// Drag or force, D_p/D_0, line tension, speed and load factor against time as `history_NAME.svg` and `.png`, several bodies in one chart; `false` if absent.
    pub history_plots: Option<bool>,
    /// Panels of a wing laid flat as `panels.svg` (docs/wing-design.md); `false` if absent.
    pub wing_panels: Option<bool>,
}
