//! The draw list: what a picture shows, without saying how it gets onto pixels.
//!
//! Pixel coordinates have their origin at the top left corner, x to the right, y down.

use glam::DVec3;

use super::colour::{ColourScale, Rgb};

/// All that one picture shows.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Width of the whole picture [px].
    pub width_px: u32,
    /// Height of the whole picture [px].
    pub height_px: u32,
    /// Colour of the page around the viewport.
    pub page: Rgb,
    /// Part of the picture that the camera fills.
    pub viewport: PixelRect,
    /// Vertical gradient behind the scene: colour at the viewport's top and at its bottom.
    pub background: [Rgb; 2],
    /// From where the scene is seen.
    pub camera: Camera,
    /// Opaque triangle meshes.
    pub surfaces: Vec<Surface>,
    /// Lines in space.
    pub polylines: Vec<Polyline>,
    /// Coloured planes.
    pub slices: Vec<Slice>,
    /// Text on top of everything.
    pub labels: Vec<Label>,
    /// Legends of the colour scales.
    pub colour_bars: Vec<ColourBar>,
}

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelRect {
    /// Leftmost column [px].
    pub x: u32,
    /// Topmost row [px].
    pub y: u32,
    /// Number of columns [px].
    pub width: u32,
    /// Number of rows [px].
    pub height: u32,
}

impl PixelRect {
    /// Width over height; 1 for an empty rectangle.
    #[must_use]
    pub fn aspect(&self) -> f64 {
        if self.height == 0 {
            1.0
        } else {
            f64::from(self.width) / f64::from(self.height)
        }
    }
}

/// Where the scene is seen from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye [m]; only what lies in front of it is seen.
    pub eye_m: DVec3,
    /// Point that appears at the viewport's centre [m].
    pub target_m: DVec3,
    /// Direction that appears upwards; need be neither unit nor normal to the line of sight.
    pub up: DVec3,
    /// How space is flattened.
    pub projection: Projection,
}

/// How space is flattened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Parallel rays.
    Orthographic {
        /// Extent of the scene from the viewport's bottom to its top [m].
        height_m: f64,
    },
    /// Rays through the eye.
    Perspective {
        /// Angle between the viewport's bottom and top [rad], above 0 and below π.
        vertical_fov_rad: f64,
    },
}

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineStyle {
    /// Width on the finished picture [px].
    pub width_px: f64,
    /// Colour.
    pub colour: Rgb,
    /// Opacity, 0…1.
    pub opacity: f32,
}

/// A mesh of triangles, seen from both sides, coloured by one number per triangle.
///
/// A triangle with a vertex that does not exist or is not finite is left out.
#[derive(Debug, Clone)]
pub struct Surface {
    /// Vertex positions [m].
    pub vertices_m: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Number shown on each triangle, `[triangles.len()]`, in the unit of `range`.
    pub values: Vec<f64>,
    /// Values at the ends of the scale.
    pub range: [f64; 2],
    /// Colours of the values.
    pub scale: ColourScale,
    /// Style of the edges between triangles, if they are drawn.
    pub mesh_edges: Option<LineStyle>,
    /// Style of the edges that belong to one triangle only, if they are drawn.
    pub boundary: Option<LineStyle>,
}

/// A line through points in space, hidden by surfaces in front of it.
///
/// A stretch with an end that is not finite is left out.
#[derive(Debug, Clone)]
pub struct Polyline {
    /// Points along the line [m].
    pub points_m: Vec<DVec3>,
    /// Look of the line.
    pub style: LineStyle,
}

/// Whether a slice takes part in hiding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SliceDepth {
    /// A backdrop: surfaces and lines are drawn over it wherever they are.
    #[default]
    Behind,
    /// A sheet in space: it covers what is behind it and is covered by what is in front.
    Tested,
}

/// A parallelogram in space coloured by a grid of numbers.
#[derive(Debug, Clone)]
pub struct Slice {
    /// Corner of the parallelogram [m].
    pub origin_m: DVec3,
    /// Its two edges [m], along which the first and the second grid index run.
    pub edges_m: [DVec3; 2],
    /// Number of values along the two edges.
    pub counts: [usize; 2],
    /// Values at the centres of `counts` equal cells, first index fastest, interpolated bilinearly
    /// in between, in the unit of `range`. Where a value is not a number the slice has a hole.
    pub values: Vec<f32>,
    /// Values at the ends of the scale.
    pub range: [f64; 2],
    /// Colours of the values.
    pub scale: ColourScale,
    /// Opacity, 0…1.
    pub opacity: f32,
    /// Whether the slice takes part in hiding.
    pub depth: SliceDepth,
}

/// Height of a line of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TextSize {
    /// 16 px.
    Px16,
    /// 20 px.
    Px20,
    /// 24 px.
    Px24,
    /// 32 px.
    Px32,
}

impl TextSize {
    /// The largest size not above `height_px`, or else the smallest.
    #[must_use]
    pub fn fitting(height_px: f64) -> Self {
        match height_px {
            h if h >= 32.0 => Self::Px32,
            h if h >= 24.0 => Self::Px24,
            h if h >= 20.0 => Self::Px20,
            _ => Self::Px16,
        }
    }
}

/// On which side of its anchor a text lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextAlign {
    /// Starts at the anchor.
    Left,
    /// Is centred on the anchor.
    Centre,
    /// Ends at the anchor.
    Right,
}

/// One line of text.
#[derive(Debug, Clone)]
pub struct Label {
    /// The text; ASCII and Latin-1.
    pub text: String,
    /// Anchor: x of the alignment point, y of the line's vertical middle [px].
    pub position_px: [i64; 2],
    /// Height of the line.
    pub size: TextSize,
    /// Bold rather than regular.
    pub bold: bool,
    /// Colour.
    pub colour: Rgb,
    /// Side of the anchor.
    pub align: TextAlign,
}

/// The legend of a colour scale: an upright bar with its title above and its ticks at the right.
#[derive(Debug, Clone)]
pub struct ColourBar {
    /// What is shown, with its unit.
    pub title: String,
    /// Values at the bottom and at the top, in that unit.
    pub range: [f64; 2],
    /// Colours.
    pub scale: ColourScale,
    /// The bar itself, without title and ticks.
    pub rect: PixelRect,
    /// Values that are marked, with their texts; see [`nice_ticks`].
    pub ticks: Vec<Tick>,
    /// Height of title and ticks.
    pub text_size: TextSize,
    /// Colour of title and ticks.
    pub text_colour: Rgb,
}

/// A marked value of a [`ColourBar`].
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// The value, in the bar's unit.
    pub value: f64,
    /// The value as text.
    pub text: String,
}

/// At most `max_count` (at least 2) ticks within `range` at multiples of 1, 2 or 5 times a power
/// of ten. Empty for a range that is empty, reversed or not finite.
#[must_use]
pub fn nice_ticks(range: [f64; 2], max_count: usize) -> Vec<Tick> {
    let width = range[1] - range[0];
    if !(width.is_finite() && width > 0.0) {
        return Vec::new();
    }
    let rough = width / (max_count.max(2) - 1) as f64;
    let exponent = rough.log10().floor();
    let step_of = |mantissa: f64| mantissa * 10f64.powf(exponent);
    let step = [1.0, 2.0, 5.0]
        .into_iter()
        .map(step_of)
        .find(|step| *step >= rough * (1.0 - 1e-9))
        .unwrap_or_else(|| step_of(10.0));
    let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    let scientific = decimals > 4 || range[0].abs().max(range[1].abs()) >= 1e6;
    let first = (range[0] / step - 1e-9).ceil();
    (0..=max_count)
        .map(|i| (first + i as f64) * step)
        .take_while(|value| *value <= range[1] + 1e-9 * width)
        .map(|value| {
            let value = if value == 0.0 { 0.0 } else { value };
            let text = if scientific {
                format!("{value:.1e}")
            } else {
                format!("{value:.decimals$}")
            };
            Tick { value, text }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(range: [f64; 2], max_count: usize) -> Vec<String> {
        nice_ticks(range, max_count)
            .into_iter()
            .map(|tick| tick.text)
            .collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(texts([0.0, 10.0], 6), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(texts([0.0, 0.93], 6), ["0.0", "0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(texts([-1.3, 117.0], 4), ["0", "50", "100"]);
        assert_eq!(texts([0.0, 2e-5], 3), ["0.0e0", "1.0e-5", "2.0e-5"]);
    }

    #[test]
    fn odd_ranges_have_no_ticks() {
        for range in [
            [1.0, 1.0],
            [2.0, 1.0],
            [0.0, f64::NAN],
            [0.0, f64::INFINITY],
        ] {
            assert!(nice_ticks(range, 6).is_empty());
        }
    }
}
