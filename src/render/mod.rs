//! Pictures of a frame.
//!
//! [`scene`] turns a frame into a [`picture`], a draw list that knows nothing of pixels' making;
//! [`raster`] draws that list in software, on any machine and always alike.

use thiserror::Error;

use crate::frame::Frame;

pub(crate) mod annotate;
mod camera;
pub mod colour;
mod content;
mod fabric;
mod flow;
mod marked_mesh;
pub mod picture;
pub mod raster;
pub mod scene;
pub(crate) mod sheets;
pub(crate) mod strokes;
pub mod text;
pub(crate) mod view;

pub use camera::{fit_orthographic, sight_direction};
pub use colour::ColourScale;
pub use content::range_from_zero;
pub use marked_mesh::{MarkedMesh, marked_mesh_png_bytes};
pub use picture::Picture;
pub use raster::rasterise;
pub use scene::{PictureOptions, Section, picture_of};

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
        camera: picture::Camera,
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

/// The bytes of a PNG file that shows `frame`.
///
/// # Errors
///
/// [`RenderError`] where the options ask for an impossible size or the frame's arrays do not match.
pub fn snapshot_png_bytes(frame: &Frame, options: &PictureOptions) -> Result<Vec<u8>, RenderError> {
    png_bytes(&rasterise(&picture_of(frame, options))?)
}

/// The bytes of a PNG file.
///
/// # Errors
///
/// [`RenderError::Encode`] where the encoder fails.
pub fn png_bytes(image: &image::RgbImage) -> Result<Vec<u8>, RenderError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png)?;
    Ok(bytes.into_inner())
}
