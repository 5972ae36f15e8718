//! Forces of a surface pressure.

use glam::DVec3;

use super::surface::{PanelSurface, mirrored};

/// Force and moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forces {
    /// Force [N].
    pub force_n: DVec3,
    /// Moment about the point asked for [N m].
    pub moment_n_m: DVec3,
}

impl Forces {
    /// Lift, across the stream in the plane of stream and z axis, and drag along it [N].
    #[must_use]
    pub fn lift_and_drag_n(&self, stream: DVec3) -> (f64, f64) {
        let along = stream.normalize_or_zero();
        let up = (DVec3::Z - along * along.z).normalize_or_zero();
        (self.force_n.dot(up), self.force_n.dot(along))
    }
}

/// −∫ p n dA of panels with the given pressure coefficients; of a symmetric surface both halves.
pub(super) fn of_pressure(
    surface: &PanelSurface,
    coefficients: &[f64],
    dynamic_pa: f64,
    about_m: DVec3,
) -> Forces {
    let mut sum = Forces {
        force_n: DVec3::ZERO,
        moment_n_m: DVec3::ZERO,
    };
    for (panel, coefficient) in surface.panels.iter().zip(coefficients) {
        let force = -dynamic_pa * coefficient * panel.area_m2;
        sum.force_n += force;
        sum.moment_n_m += (panel.centre_m - about_m).cross(force);
        if surface.is_symmetric {
            let force = mirrored(force);
            sum.force_n += force;
            sum.moment_n_m += (mirrored(panel.centre_m) - about_m).cross(force);
        }
    }
    sum
}
