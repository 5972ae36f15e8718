//! What may be written in `[supports.NAME]`: held nodes that are moved together.

use schemars::JsonSchema;
use serde::Deserialize;

use super::bodies::Motion;

/// Held nodes that are moved together, only without air. Exactly one of `box_m` and `nodes`, and of `displacement_m` and `motion`. The
/// history and the results have their displacement and their force on the structure, `NAME_force_x_n` and so on: what elements pull,
/// without the inertia of the held nodes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Two opposite corners of a box: the held nodes that start inside it [m].
    pub box_m: Option<[[f64; 3]; 2]>,
    /// Numbers of the held nodes, from 1, instead of `box_m`.
    pub nodes: Option<Vec<u32>>,
    /// How far they are moved [m]; without `[time]` at once, for the equilibrium.
    pub displacement_m: Option<[f64; 3]>,
    /// Time in which they are moved by `displacement_m` at constant speed, then they stay [s]; `time.end_s` if absent.
    pub ramp_time_s: Option<f64>,
    /// How they move, instead of `displacement_m`, only with `[time]`. Rotations are about the middle of the nodes unless they name a centre. It begins where the
    /// structure starts; an equilibrium after it is that with the supports where it ended.
    pub motion: Option<Motion>,
}
