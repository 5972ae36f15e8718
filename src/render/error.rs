//! Why a picture cannot be drawn.

use thiserror::Error;

use super::picture::Camera;

/// Why a picture cannot be drawn.
#[derive(Debug, Error)]
pub enum RenderError {
    /// The picture has no pixels or too many.
    #[error("a picture of {width_px}×{height_px} px cannot be drawn: allowed are 1 to {max_px} px")]
    Size {
        /// Width asked for [px].
        width_px: u32,
        /// Height asked for [px].
        height_px: u32,
        /// Largest width and height [px].
        max_px: u32,
    },
    /// The viewport is empty or does not lie within the picture.
    #[error("the viewport is empty or reaches beyond the picture")]
    Viewport,
    /// The camera has no direction, no extent or no finite place.
    #[error("the camera looks nowhere: {camera:?}")]
    Camera {
        /// The camera.
        camera: Camera,
    },
    /// A surface or slice does not have one value for each place.
    #[error("a {what} needs {expected} values but has {found}")]
    ValueCount {
        /// What has the values.
        what: &'static str,
        /// Values needed.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// The picture could not be written as PNG.
    #[error("the picture could not be encoded as PNG: {0}")]
    Encode(#[from] image::ImageError),
}
