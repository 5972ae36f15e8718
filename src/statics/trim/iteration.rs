//! One outer iteration of a trim.

use serde::{Deserialize, Serialize};

use crate::solve::lbfgs::Outcome;

/// One outer iteration.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct TrimIteration {
    /// Nodes of the mesh: coarser ones come first.
    pub nodes: usize,
    /// From 1.
    pub number: usize,
    /// Speed along the path [m/s].
    pub speed_m_s: f64,
    /// Speed of sinking [m/s].
    pub sink_m_s: f64,
    /// Horizontal over vertical speed.
    pub glide_ratio: f64,
    /// Angle of attack of the chord in the middle [rad].
    pub attack_rad: f64,
    /// Coefficient of the pressure inside.
    pub inside: f64,
    /// Pitch of that chord after the solve [rad].
    pub pitch_rad: f64,
    /// By how much the balance turned the wing [rad].
    pub turn_rad: f64,
    /// Pull of the guide along x after the solve [N].
    pub guide_n: f64,
    /// How far the outlines moved beyond a turn about the hang points: root of the mean square, over the mean chord.
    pub shape_change: f64,
    /// Of the fabric's solve.
    pub outcome: Outcome,
    /// What the risers carry less what acts on the wing, over the weight.
    pub balance_error: f64,
    /// Largest difference of a strip's lift coefficient from its polar's.
    pub section_residual: f64,
    /// Energy norm of the fabric's forces at its end, over the loads'; NaN where nothing was left to solve.
    pub relative_norm: f64,
    /// Seconds for the air, and for the fabric.
    pub seconds: [f64; 2],
}
