//! From a frame to a picture.
//!
//! Air moves to the right and up is up: the camera looks along +y, turned a little so that the
//! canopy's depth shows. Around the view lie a header with title and time, a strip with the colour
//! bars at the right and a caption below.

use glam::DVec3;

use super::camera::{bounds, box_corners, fit_orthographic, sight_direction};
use super::colour::{ColourScale, Rgb};
use super::content::{Axis, INK, air_box, bodies, cables, thinnest_axis};
use super::fabric;
use super::flow;
use super::picture::{
    Camera, ColourBar, Label, LineStyle, Picture, PixelRect, Polyline, Slice, SliceDepth, Surface,
    TextAlign, TextSize, Tick, nice_ticks,
};
use super::text::{line_height, text_width};
use crate::frame::{FabricQuantity, FlowQuantity, FluidFrame, Frame, StructureFrame};

/// Colour of the page.
const PAGE: Rgb = [255, 255, 255];

/// Gradient behind a scene.
const BACKGROUND: [Rgb; 2] = [[249, 250, 252], [236, 240, 245]];

/// Colour of text.
const TEXT: Rgb = [32, 36, 44];

/// Width of the view in structure lengths, with air.
const VIEW_LENGTHS: f64 = 2.8;

/// Free space upstream of the structure in structure lengths, with air.
const UPSTREAM_LENGTHS: f64 = 0.35;

/// What a picture should look like.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width of the picture [px].
    pub width_px: u32,
    /// Height of the picture [px].
    pub height_px: u32,
    /// Text at the top left.
    pub title: Option<String>,
    /// Text below the view.
    pub caption: Option<String>,
    /// What the fabric's colours show.
    pub fabric: FabricQuantity,
    /// Ends of the fabric's scale [N/m or MPa]; by default 0 and the 98th percentile of this frame.
    pub fabric_range: Option<[f64; 2]>,
    /// What the slice of air shows.
    pub flow: FlowQuantity,
    /// Ends of its scale, in its unit; by default 0 and the 98th percentile of this frame, or as far on both sides of 0.
    pub flow_range: Option<[f64; 2]>,
    /// Speed at which arrows of the air's velocity are as long as their distance [m/s]; `None`: no arrows.
    pub arrow_speed_m_s: Option<f64>,
    /// How far the eye is turned towards upstream from looking along +y [°].
    pub azimuth_deg: f64,
    /// How far the eye is raised [°].
    pub elevation_deg: f64,
    /// Show all of the air rather than the structure and some wake.
    pub whole_domain: bool,
    /// Box that takes the structure's place in choosing the view: lowest and highest corner [m].
    /// Give the same one for all pictures of a run to hold the camera still.
    pub framing_box_m: Option<[DVec3; 2]>,
    /// Whether the slice of air cuts the structure or lies behind it.
    pub slice_depth: SliceDepth,
    /// Draw the edges of the fabric's triangles.
    pub mesh_edges: bool,
    /// A section through the scene, seen squarely, in place of the view in space.
    pub section: Option<Section>,
    /// Whether the time stands in the corner; an equilibrium has none.
    pub time: bool,
}

/// A plane y = const, with what it cuts.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Place of the plane [m].
    pub y_m: f64,
    /// Outlines of fabric in it [m].
    pub outlines_m: Vec<Vec<DVec3>>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self {
            width_px: 1280,
            height_px: 720,
            title: None,
            caption: None,
            fabric: FabricQuantity::Tension,
            fabric_range: None,
            flow: FlowQuantity::Speed,
            flow_range: None,
            arrow_speed_m_s: None,
            azimuth_deg: 28.0,
            elevation_deg: 14.0,
            whole_domain: false,
            framing_box_m: None,
            slice_depth: SliceDepth::Behind,
            mesh_edges: true,
            section: None,
            time: true,
        }
    }
}

/// A picture of a frame: fabric coloured by one of its quantities, lines, and one of the air's on
/// the plane y = const through the structure's centre.
///
/// Without air the structure fills the view; without a structure the air does, seen squarely on the
/// middle plane across its thinnest direction. Values that are not finite are left out. Fabric without
/// strain is grey, without a bar.
#[must_use]
pub fn picture_of(frame: &Frame, options: &PictureOptions) -> Picture {
    let section = options.section.as_ref();
    let structure = frame.structure.as_ref().filter(|_| section.is_none());
    let zoom = zoom(options);
    let solid: Vec<DVec3> = structure
        .iter()
        .flat_map(|s| &s.positions_m)
        .chain(frame.bodies.iter().flat_map(|b| &b.positions_m))
        .copied()
        .collect();
    let normal = match &frame.fluid {
        Some(fluid) if solid.is_empty() && section.is_none() => thinnest_axis(fluid),
        _ => Axis::Y,
    };
    let plane = frame.fluid.as_ref().and_then(|fluid| {
        let place = section.map(|section| section.y_m);
        let place = place.or_else(|| centre_y(&solid).filter(|_| normal == Axis::Y));
        let [low, high] = air_box(fluid);
        let middle = 0.5 * (low + high)[normal as usize];
        flow::Section::new(fluid, normal, place.unwrap_or(middle))
    });
    let slices = plane.as_ref().map_or_else(Vec::new, |plane| {
        let mut slices = plane.slices(options.flow, options.slice_depth);
        let automatic = || flow::range(options.flow, &slices);
        let range = options.flow_range.unwrap_or_else(automatic);
        for slice in &mut slices {
            slice.range = range;
        }
        slices
    });
    let slice = slices.first();
    let surface = structure.and_then(|structure| {
        let values = fabric::values(options.fabric, structure);
        let automatic = || fabric::range(options.fabric, &values);
        let range = options.fabric_range.unwrap_or_else(automatic);
        let (quantity, edges) = (options.fabric, options.mesh_edges);
        fabric::surface(structure, quantity, &values, range, edges, zoom)
    });

    let mut bars = Vec::new();
    // Where the range is given, pictures of a series keep their bar, and with it their place.
    let is_coloured = |surface: &&Surface| {
        options.fabric_range.is_some() || surface.values.iter().any(|value| value.is_finite())
    };
    if let Some(surface) = surface.as_ref().filter(is_coloured) {
        bars.push(Legend {
            title: fabric::title(options.fabric),
            range: surface.range,
            scale: surface.scale,
            ticks: fabric::ticks(options.fabric, surface.range),
        });
    }
    if let Some(slice) = slice {
        bars.push(Legend {
            title: flow::title(options.flow),
            range: slice.range,
            scale: slice.scale,
            ticks: nice_ticks(slice.range, 6),
        });
    }
    let mut layout = Layout::new(options, zoom, &bars);
    let camera = match (slice, section.zip(options.framing_box_m)) {
        (_, Some((section, framing))) => {
            section_camera(section.y_m, framing, layout.viewport.aspect())
        }
        (Some(slice), _) if solid.is_empty() => square_camera(slice, normal, &mut layout.viewport),
        _ => camera(
            &solid,
            frame.fluid.as_ref(),
            slice,
            options,
            layout.viewport.aspect(),
        ),
    };
    Picture {
        width_px: options.width_px,
        height_px: options.height_px,
        page: PAGE,
        viewport: layout.viewport,
        background: BACKGROUND,
        camera,
        surfaces: surface
            .into_iter()
            .chain(frame.bodies.as_ref().map(|b| bodies(b, zoom)))
            .collect(),
        polylines: lines(structure, plane.as_ref(), options, zoom)
            .into_iter()
            .chain(
                section
                    .into_iter()
                    .flat_map(|section| outlines(section, zoom)),
            )
            .collect(),
        slices,
        labels: layout.labels(frame.time_s, options),
        colour_bars: layout.colour_bars(bars),
    }
}

/// Cables, wrinkles and arrows.
fn lines(
    structure: Option<&StructureFrame>,
    plane: Option<&flow::Section>,
    options: &PictureOptions,
    zoom: f64,
) -> Vec<Polyline> {
    let mut lines = plane.map_or_else(Vec::new, |plane| plane.outlines(zoom));
    if let (Some(plane), Some(speed)) = (plane, options.arrow_speed_m_s) {
        lines.extend(plane.arrows(speed, zoom));
    }
    if let Some(structure) = structure {
        lines.extend(cables(structure, zoom));
        if options.fabric == FabricQuantity::Wrinkles {
            lines.extend(fabric::wrinkle_strokes(structure, zoom));
        }
    }
    lines
}

/// Outlines of fabric in a section.
fn outlines(section: &Section, zoom: f64) -> impl Iterator<Item = Polyline> {
    section.outlines_m.iter().map(move |points| Polyline {
        points_m: points.clone(),
        style: LineStyle {
            width_px: 2.5 * zoom,
            colour: INK,
            opacity: 1.0,
        },
    })
}

/// A camera that looks along +y and sees all of a box.
fn section_camera(y_m: f64, framing: [DVec3; 2], aspect: f64) -> Camera {
    let corners = framing.map(|corner| corner.with_y(y_m));
    let (sight, up) = Axis::Y.square_view();
    let distance = 2.0 * corners[0].distance(corners[1]);
    fit_orthographic(&box_corners(corners), sight, up, aspect, 0.0, distance)
}

/// Size of text and lines relative to a picture of 1280×720 px.
fn zoom(options: &PictureOptions) -> f64 {
    let zoom = (f64::from(options.width_px) / 1280.0).min(f64::from(options.height_px) / 720.0);
    zoom.clamp(0.3, 4.0)
}

/// Mean y of places [m].
fn centre_y(places: &[DVec3]) -> Option<f64> {
    let (sum, count) = (places.iter())
        .filter(|p| p.is_finite())
        .fold((0.0, 0usize), |(sum, count), p| (sum + p.y, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// A camera that sees a slice squarely, in a viewport cut to the slice's shape.
fn square_camera(slice: &Slice, normal: Axis, viewport: &mut PixelRect) -> Camera {
    let (sight, up) = normal.square_view();
    let extents = slice.edges_m.map(|edge| edge.length());
    let aspect = extents[0] / extents[1];
    let PixelRect {
        x,
        y,
        width,
        height,
    } = *viewport;
    let shrunk = |size: f64, limit: u32| (size.round() as u32).clamp(limit.min(1), limit);
    if aspect.is_finite() && aspect > 0.0 {
        viewport.width = shrunk(f64::from(height) * aspect, width);
        viewport.height = shrunk(f64::from(width) / aspect, height);
        viewport.x = x + (width - viewport.width) / 2;
        viewport.y = y + (height - viewport.height) / 2;
    }
    let distance = 2.0 * (extents[0] + extents[1]);
    fit_orthographic(
        &slice.corners_m(),
        sight,
        up,
        viewport.aspect(),
        0.0,
        distance,
    )
}

/// A camera that shows the structure, with air also some wake, or all of the air if so asked.
fn camera(
    solid: &[DVec3],
    fluid: Option<&FluidFrame>,
    slice: Option<&Slice>,
    options: &PictureOptions,
    aspect: f64,
) -> Camera {
    let air = fluid.map(air_box);
    let bodies = bounds(solid.iter().copied());
    let body = options
        .framing_box_m
        .or(bodies.map(|(low, high)| [low, high]));
    let (points, margin) = match (body, air) {
        (None, None) => (Vec::new(), 0.0),
        (Some(body), None) => (box_corners(body).to_vec(), 0.09),
        (Some(body), Some(air)) if !options.whole_domain => (with_wake(body, air), 0.0),
        (body, Some(_)) => {
            let sheet = slice.into_iter().flat_map(Slice::corners_m);
            (
                sheet
                    .chain(body.into_iter().flat_map(box_corners))
                    .collect(),
                0.02,
            )
        }
    };
    let all = points.iter().chain(air.iter().flatten()).copied();
    let size = bounds(all).map_or(1.0, |(low, high)| (high - low).length());
    let distance = 2.0 * if size > 0.0 { size } else { 1.0 };
    let sight = sight_direction(options.azimuth_deg, options.elevation_deg);
    fit_orthographic(&points, sight, DVec3::Z, aspect, margin, distance)
}

/// Points around the structure and a stretch of its wake, within the air.
fn with_wake([low, high]: [DVec3; 2], air: [DVec3; 2]) -> Vec<DVec3> {
    let length = (high - low).max_element();
    let middle = 0.5 * (low + high);
    let end = |x: f64| DVec3::new(x.clamp(air[0].x, air[1].x), middle.y, middle.z);
    let start = low.x - UPSTREAM_LENGTHS * length;
    let room = DVec3::splat(0.12 * length);
    let mut points = box_corners([low - room, high + room]).to_vec();
    points.extend([end(start), end(start + VIEW_LENGTHS * length)]);
    points
}

/// What one colour bar says.
struct Legend {
    title: &'static str,
    range: [f64; 2],
    scale: ColourScale,
    ticks: Vec<Tick>,
}

/// Where things go on the page.
struct Layout {
    page: [u32; 2],
    viewport: PixelRect,
    margin: u32,
    strip: u32,
    text: TextSize,
    heading: TextSize,
}

impl Layout {
    fn new(options: &PictureOptions, zoom: f64, bars: &[Legend]) -> Self {
        let px = |size: f64| (size * zoom).round() as u32;
        let (width, height) = (options.width_px, options.height_px);
        let margin = px(16.0);
        let text = TextSize::fitting(20.0 * zoom);
        let heading = TextSize::fitting(26.0 * zoom);
        // Ticks stand beside the bar, one margin and a half wide.
        let beside = |tick: &Tick| 5 * margin / 2 + text_width(&tick.text, text, false);
        let widest = bars
            .iter()
            .flat_map(|bar| {
                let title = text_width(bar.title, text, true);
                bar.ticks.iter().map(beside).chain([title])
            })
            .max();
        let strip = widest.map_or(margin, |widest| 2 * margin + widest);
        let (top, bottom) = (
            px(46.0).max(line_height(heading) + 2),
            if options.caption.is_some() {
                px(44.0).max(line_height(text) + 4)
            } else {
                margin
            },
        );
        let framed = PixelRect {
            x: margin,
            y: top,
            width: width.saturating_sub(margin + strip),
            height: height.saturating_sub(top + bottom),
        };
        let whole = PixelRect {
            x: 0,
            y: 0,
            width,
            height,
        };
        let viewport = if framed.width > 0 && framed.height > 0 {
            framed
        } else {
            whole
        };
        Self {
            page: [width, height],
            viewport,
            margin,
            strip,
            text,
            heading,
        }
    }

    fn labels(&self, time_s: f64, options: &PictureOptions) -> Vec<Label> {
        let [width, height] = self.page.map(i64::from);
        let margin = i64::from(self.margin);
        let header = (options.height_px.min(self.viewport.y) / 2).max(1);
        let label = |text: &str, position_px, align, size, bold| Label {
            text: text.to_owned(),
            position_px,
            size,
            bold,
            colour: TEXT,
            align,
        };
        let y = i64::from(header);
        let right = width - i64::from(self.strip);
        let mut labels = Vec::new();
        if options.time {
            let time = format!("t = {time_s:.4} s");
            labels.push(label(&time, [right, y], TextAlign::Right, self.text, false));
        }
        if let Some(title) = &options.title {
            labels.push(label(
                title,
                [margin, y],
                TextAlign::Left,
                self.heading,
                true,
            ));
        }
        if let Some(caption) = &options.caption {
            let below = i64::from(self.viewport.y + self.viewport.height);
            let y = (below + height) / 2;
            labels.push(label(
                caption,
                [margin, y],
                TextAlign::Left,
                self.text,
                false,
            ));
        }
        labels
    }

    fn colour_bars(&self, bars: Vec<Legend>) -> Vec<ColourBar> {
        let title = line_height(self.text) + 2 * self.margin / 3;
        let count = (bars.len() as u32).max(2);
        let port = self.viewport;
        let share = port.height / count;
        let x = (self.page[0] - self.strip.min(self.page[0])) + self.margin;
        let bar = |(k, legend): (usize, Legend)| ColourBar {
            title: legend.title.to_owned(),
            range: legend.range,
            scale: legend.scale,
            rect: PixelRect {
                x,
                y: port.y + share * k as u32 + title,
                width: self.margin * 3 / 2,
                height: share.saturating_sub(title + self.margin),
            },
            ticks: legend.ticks,
            text_size: self.text,
            text_colour: TEXT,
        };
        bars.into_iter().enumerate().map(bar).collect()
    }
}

#[cfg(test)]
#[path = "scene_tests.rs"]
mod tests;
