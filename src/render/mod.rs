//! Pictures of a frame.
//!
//! [`scene`] turns a frame into a [`picture`], a draw list that knows nothing of pixels' making;
//! [`raster`] draws that list in software, on any machine and always alike.

use crate::frame::Frame;

pub(crate) mod annotate;
mod camera;
pub(crate) mod canvas;
pub mod colour;
mod content;
mod error;
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
pub use error::RenderError;
pub use marked_mesh::{MarkedMesh, marked_mesh_png_bytes};
pub use picture::Picture;
pub use raster::rasterise;
pub use scene::{PictureOptions, Section, picture_of};

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
