//! Which walls a device answers along by itself.

use crate::case::Scene;
use crate::plan::Plan;

/// Walls along whose cut links a device answers by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OnDevice {
    /// None: the host answers.
    Nothing,
    /// All stand still.
    Standing,
    /// Some move.
    Moving,
}

impl OnDevice {
    pub(super) fn of(scene: &Scene, plan: &Plan) -> Self {
        match plan.answers_on_device() {
            false => Self::Nothing,
            true if scene.rigid_bodies.iter().any(|body| body.motion.moves()) => Self::Moving,
            true => Self::Standing,
        }
    }

    pub(super) const fn answers(self) -> bool {
        !matches!(self, Self::Nothing)
    }
}
