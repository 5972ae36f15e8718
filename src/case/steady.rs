//! Checks of `[steady]`: what can become steady at all.

use super::air::{Air, Flow};
use super::bodies::RigidBody;
use super::body::Body;
use super::file::File;
use super::problem::Problem;
use super::values::within;
use crate::rigid::Motion;

/// Why the flow past a rigid body never becomes steady; `None` if it may.
#[must_use]
pub fn never_steady(air: &Air, falls: bool, body: &RigidBody) -> Option<&'static str> {
    let wind = matches!(air.flow, Flow::WindTunnel { speed_m_s, .. } if speed_m_s > 0.0);
    if falls {
        return Some("what falls changes its speed");
    }
    match &body.motion.motion {
        Motion::ConstantVelocity { .. } => None,
        Motion::Held | Motion::ConstantRotation { .. } if wind => None,
        Motion::Held | Motion::ConstantRotation { .. } => Some("there is no wind"),
        Motion::Oscillation { .. } => Some("the body oscillates"),
        Motion::Ramp { .. } | Motion::Table(_) => Some("the body follows a motion in time"),
    }
}

/// The relative half width of the mean drag's interval at which the run may stop.
pub(super) fn check(
    file: &File,
    air: Option<&Air>,
    body: Option<&Body>,
    rigid_bodies: &[RigidBody],
    falls: bool,
) -> Result<Option<f64>, Problem> {
    let Some(table) = &file.steady else {
        return Ok(None);
    };
    let canopy = body.is_some_and(|body| body.canopy().is_some());
    if let (false, Some(air)) = (canopy, air) {
        if body.is_some() {
            return Err(Problem::new(
                "steady",
                "[steady] stops a run by the drag of a canopy, or of rigid bodies alone: fabric beside them goes on moving",
                "remove [steady]",
            ));
        }
        let never = |body| never_steady(air, falls, body).map(|why| (body, why));
        if let Some((body, why)) = rigid_bodies.iter().find_map(never) {
            return Err(Problem::new(
                "steady",
                format!(
                    "[steady] waits for the mean drag of every rigid body, but that of `{}` never becomes steady: {why}",
                    body.name
                ),
                "remove [steady]: the run then goes to time.end_s, and means are taken over its second half",
            ));
        }
    }
    within("steady.drag_confidence", table.drag_confidence, 1e-4, 0.5).map(Some)
}
