//! Cameras that frame what matters.

use glam::DVec3;

use super::picture::{Camera, Projection};

/// The line of sight that looks along +y, turned by `azimuth_deg` so that the eye moves towards −x
/// and by `elevation_deg` so that it moves up [°]; a unit vector.
#[must_use]
pub fn sight_direction(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    DVec3::new(sin_a * cos_e, cos_a * cos_e, -sin_e)
}

/// A parallel projection along `sight` that just shows all `points_m` [m] in a viewport of the
/// given `aspect` (width over height), with a `margin` on every side as a fraction of the
/// viewport's extent. The eye is `distance_m` away from the points' middle.
///
/// Points that are not finite do not count; without any the unit cube around the origin is shown.
#[must_use]
pub fn fit_orthographic(
    points_m: &[DVec3],
    sight: DVec3,
    up: DVec3,
    aspect: f64,
    margin: f64,
    distance_m: f64,
) -> Camera {
    let forward = sight.normalize_or(DVec3::Y);
    let right = forward.cross(up).normalize_or(DVec3::X);
    let over = right.cross(forward);
    let seen = |p: DVec3| DVec3::new(p.dot(right), p.dot(over), p.dot(forward));
    let (low, high) = bounds(points_m.iter().map(|p| seen(*p)))
        .unwrap_or((DVec3::splat(-0.5), DVec3::splat(0.5)));
    let middle = 0.5 * (low + high);
    let extent = (high - low) / (1.0 - 2.0 * margin.clamp(0.0, 0.4));
    let target_m = middle.x * right + middle.y * over + middle.z * forward;
    let height_m = extent.y.max(extent.x / aspect.max(1e-6));
    Camera {
        eye_m: target_m - distance_m * forward,
        target_m,
        up,
        projection: Projection::Orthographic {
            height_m: if height_m > 0.0 { height_m } else { 1.0 },
        },
    }
}

/// Lowest and highest coordinates of the finite points; `None` without any.
pub(super) fn bounds(points: impl Iterator<Item = DVec3>) -> Option<(DVec3, DVec3)> {
    points
        .filter(|p| p.is_finite())
        .fold(None, |sum, p| match sum {
            None => Some((p, p)),
            Some((low, high)) => Some((low.min(p), high.max(p))),
        })
}

/// The eight corners of a box [m].
pub(super) fn box_corners([low, high]: [DVec3; 2]) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let pick = |bit: usize, low: f64, high: f64| if k & bit == 0 { low } else { high };
        DVec3::new(
            pick(1, low.x, high.x),
            pick(2, low.y, high.y),
            pick(4, low.z, high.z),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sight_turns_towards_upstream_and_up() {
        assert!(sight_direction(0.0, 0.0).abs_diff_eq(DVec3::Y, 1e-12));
        let sight = sight_direction(30.0, 20.0);
        assert!(sight.x > 0.0 && sight.z < 0.0 && (sight.length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn fit_shows_all_points() {
        let corners = box_corners([DVec3::ZERO, DVec3::new(4.0, 1.0, 1.0)]);
        let camera = fit_orthographic(&corners, DVec3::Y, DVec3::Z, 2.0, 0.1, 10.0);
        assert!(
            camera
                .target_m
                .abs_diff_eq(DVec3::new(2.0, 0.5, 0.5), 1e-12)
        );
        let Projection::Orthographic { height_m } = camera.projection else {
            panic!()
        };
        assert!((height_m - 2.5).abs() < 1e-12);
    }

    #[test]
    fn nothing_to_see_still_gives_a_camera() {
        let none = [DVec3::NAN];
        let camera = fit_orthographic(&none, DVec3::ZERO, DVec3::ZERO, 0.0, 9.0, 1.0);
        assert!(camera.eye_m.is_finite());
        let one = fit_orthographic(&[DVec3::ONE], DVec3::Y, DVec3::Z, 1.0, 0.1, 1.0);
        assert_eq!(one.projection, Projection::Orthographic { height_m: 1.0 });
    }
}
