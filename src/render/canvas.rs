//! The samples that a picture is drawn on.

use super::colour::Rgb;
use super::error::RenderError;
use super::view::View;

/// Samples per pixel along x and along y.
pub(crate) const SAMPLES: usize = 2;

/// Largest width and height of a picture [px].
pub const MAX_SIZE_PX: u32 = 16_384;

/// The viewport's samples: [`SAMPLES`]² for each pixel, row by row from the top.
pub(super) struct Canvas {
    pub view: View,
    pub width: usize,
    pub height: usize,
    pub colours: Vec<Rgb>,
    /// Nearness of what each sample shows.
    pub keys: Vec<f32>,
    /// Nearest translucent slice over each sample and the light it lets through; empty without.
    pub veils: Vec<Veil>,
}

/// A translucent cover of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Veil {
    /// Nearness of the cover.
    pub key: f32,
    /// Share of the light from behind that passes.
    pub passes: f32,
}

impl Veil {
    /// No cover.
    pub const NONE: Self = Self {
        key: f32::NEG_INFINITY,
        passes: 1.0,
    };
}

/// An error unless `found` is `expected`.
pub(super) fn check_count(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), RenderError> {
    if expected == found {
        Ok(())
    } else {
        Err(RenderError::ValueCount {
            what,
            expected,
            found,
        })
    }
}

/// First and one past the last sample between two places on an axis with `size` samples, whose
/// centres lie at half-integers.
pub(super) fn sample_span(low: f64, high: f64, size: usize) -> std::ops::Range<usize> {
    let first = (low - 0.5).ceil().clamp(0.0, size as f64) as usize;
    let last = (high + 0.5).floor().clamp(0.0, size as f64) as usize;
    first..last.max(first)
}
