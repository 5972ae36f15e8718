//! From space to pixels.

use glam::DVec3;

use super::picture::{Camera, Projection};

/// Nearest visible depth as a fraction of the distance from eye to target.
const NEAR_FRACTION: f64 = 1e-3;

/// A camera bound to a number of pixels.
///
/// View coordinates [m] are x to the right, y up and z the depth along the line of sight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Whether the rays meet in the eye.
    pub perspective: bool,
    /// Pixels per metre, for a perspective view at a depth of one metre.
    pub scale: f64,
    centre: [f64; 2],
    /// Depth of the near plane [m].
    pub near: f64,
}

/// A point on the screen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScreenPoint {
    /// Column [px].
    pub x: f64,
    /// Row [px].
    pub y: f64,
    /// Nearness: larger is nearer; runs linearly over the screen along planes.
    pub key: f64,
    /// Weight for perspective-correct interpolation.
    pub weight: f64,
}

impl ScreenPoint {
    /// Whether the point can be drawn.
    pub fn is_finite(&self) -> bool {
        (self.x + self.y + self.key).is_finite()
    }
}

impl View {
    /// Binds `camera` to a screen; `None` for a camera without direction, extent or finite place.
    pub fn new(camera: &Camera, width_px: usize, height_px: usize) -> Option<Self> {
        let sight = camera.target_m - camera.eye_m;
        let forward = sight.try_normalize()?;
        let right = forward.cross(camera.up).try_normalize()?;
        let rows = height_px as f64;
        let (perspective, scale) = match camera.projection {
            Projection::Orthographic { height_m } => (false, rows / height_m),
            Projection::Perspective { vertical_fov_rad } => {
                (true, 0.5 * rows / (0.5 * vertical_fov_rad).tan())
            }
        };
        let sound = scale.is_finite() && scale > 0.0 && camera.eye_m.is_finite();
        sound.then(|| Self {
            eye: camera.eye_m,
            right,
            up: right.cross(forward),
            forward,
            perspective,
            scale,
            centre: [0.5 * width_px as f64, 0.5 * rows],
            near: NEAR_FRACTION * sight.length(),
        })
    }

    /// View coordinates of a point in space [m].
    pub fn to_view(self, point: DVec3) -> DVec3 {
        self.direction(point - self.eye)
    }

    /// View components of a direction in space.
    pub fn direction(self, d: DVec3) -> DVec3 {
        DVec3::new(d.dot(self.right), d.dot(self.up), d.dot(self.forward))
    }

    /// Place on the screen of a point in view coordinates, which must not be nearer than `near`.
    pub fn project(self, v: DVec3) -> ScreenPoint {
        let weight = if self.perspective { 1.0 / v.z } else { 1.0 };
        ScreenPoint {
            x: self.centre[0] + self.scale * weight * v.x,
            y: self.centre[1] - self.scale * weight * v.y,
            key: self.key(v.z),
            weight,
        }
    }

    /// Nearness of a depth [m].
    pub fn key(self, depth: f64) -> f64 {
        if self.perspective {
            1.0 / depth
        } else {
            -depth
        }
    }

    /// Size of a pixel at a depth, both [m].
    pub fn pixel_size(self, depth: f64) -> f64 {
        if self.perspective {
            depth / self.scale
        } else {
            1.0 / self.scale
        }
    }

    /// Start and direction, in view coordinates, of the ray through a place on the screen; the
    /// direction has unit depth and the start none, so the ray parameter is the depth [m].
    pub fn ray(self, x: f64, y: f64) -> (DVec3, DVec3) {
        let lateral = DVec3::new(x - self.centre[0], self.centre[1] - y, 0.0) / self.scale;
        if self.perspective {
            (DVec3::ZERO, lateral + DVec3::Z)
        } else {
            (lateral, DVec3::Z)
        }
    }

    /// Direction from the eye towards a point, both in view coordinates.
    pub fn ray_through(self, v: DVec3) -> DVec3 {
        if self.perspective { v } else { DVec3::Z }
    }
}
