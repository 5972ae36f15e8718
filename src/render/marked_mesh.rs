//! Pictures of a mesh in grey with something in it marked: all of it at the left, the first mark close by at the right.

use glam::DVec3;
use image::RgbImage;
use image::imageops::overlay;

use super::camera::{bounds, box_corners, fit_orthographic, sight_direction};
use super::colour::{ColourScale, Rgb};
use super::content::INK;
use super::picture::{
    Camera, Label, LineStyle, Picture, PixelRect, Polyline, Projection, Surface, TextAlign,
    TextSize,
};
use super::text::{draw_label, line_height, text_width};
use super::{RenderError, png_bytes, rasterise};

/// Width of a picture [px].
const WIDTH_PX: u32 = 1280;

/// Height of the header, and space around what is seen [px].
const HEADER_PX: u32 = 48;
const MARGIN_PX: u32 = 16;

/// Height of one of the two views [px].
const VIEW_PX: u32 = 560;

/// Directions that are looked from, as azimuth and elevation [°]: the one that shows most of the surface is taken.
const SIGHTS_DEG: [[f64; 2]; 8] = [
    [28.0, 14.0],
    [28.0, 40.0],
    [28.0, 75.0],
    [75.0, 14.0],
    [-62.0, 14.0],
    [-62.0, 40.0],
    [118.0, 25.0],
    [28.0, -40.0],
];

/// Half the width of the view close by, in the longest edge at the first mark; at most so much of the mesh.
const CLOSE: f64 = 3.0;
const CLOSE_SHARE: f64 = 0.2;

/// Most triangles whose edges are drawn over all of the mesh.
const MOST_WITH_EDGES: usize = 40_000;

/// Radius of the ring around the first mark [px].
const RING_PX: f64 = 22.0;

/// What a picture shows.
#[derive(Debug, Clone)]
pub struct MarkedMesh<'a> {
    /// Places of the nodes [m].
    pub positions_m: &'a [DVec3],
    /// Nodes of each triangle.
    pub triangles: &'a [[u32; 3]],
    /// Marked nodes.
    pub nodes: &'a [u32],
    /// Marked edges.
    pub edges: &'a [[u32; 2]],
    /// Marked triangles, by number.
    pub marked: &'a [u32],
    /// Colour of the marks.
    pub colour: Rgb,
    /// Text above.
    pub title: &'a str,
    /// Text below.
    pub caption: &'a str,
}

/// The bytes of a PNG file.
///
/// # Errors
///
/// [`RenderError`] where a mesh has no finite extent, or the encoder fails.
pub fn marked_mesh_png_bytes(mesh: &MarkedMesh) -> Result<Vec<u8>, RenderError> {
    let width = WIDTH_PX;
    let caption = wrapped(mesh.caption, width - 2 * MARGIN_PX);
    let step = line_height(TextSize::Px16) + 5;
    let height = HEADER_PX + VIEW_PX + (caption.len() as u32 + 1) * step;
    let mut page = RgbImage::from_pixel(width, height, image::Rgb([255; 3]));
    let first = mesh.first_place();
    let view_width = if first.is_some() {
        (width - 3 * MARGIN_PX) / 2
    } else {
        width - 2 * MARGIN_PX
    };
    let whole = mesh.view(None, first, view_width);
    overlay(
        &mut page,
        &rasterise(&whole)?,
        MARGIN_PX.into(),
        HEADER_PX.into(),
    );
    if let Some((place, edge_m)) = first {
        let all = bounds(mesh.positions_m.iter().copied());
        let size_m = all.map_or(0.0, |(low, high)| (high - low).length());
        let half_m = (CLOSE * edge_m).min(CLOSE_SHARE * size_m);
        let close = mesh.view(Some((place, half_m)), first, view_width);
        let left = 2 * MARGIN_PX + view_width;
        overlay(
            &mut page,
            &rasterise(&close)?,
            left.into(),
            HEADER_PX.into(),
        );
    }
    let mut label = Label {
        text: mesh.title.to_owned(),
        position_px: [MARGIN_PX.into(), i64::from(HEADER_PX / 2)],
        size: TextSize::Px20,
        bold: true,
        colour: INK,
        align: TextAlign::Left,
    };
    draw_label(&mut page, &label);
    label.bold = false;
    label.size = TextSize::Px16;
    let mut top = HEADER_PX + VIEW_PX + step;
    for line in caption {
        label.text = line;
        label.position_px[1] = top.into();
        draw_label(&mut page, &label);
        top += step;
    }
    png_bytes(&page)
}

/// Text in lines of at most a width [px].
fn wrapped(text: &str, width_px: u32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line)
                if text_width(&format!("{line} {word}"), TextSize::Px16, false) <= width_px =>
            {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

impl MarkedMesh<'_> {
    fn place(&self, node: u32) -> Option<DVec3> {
        self.positions_m.get(node as usize).copied()
    }

    fn corners(&self, nodes: [u32; 3]) -> Option<[DVec3; 3]> {
        let [a, b, c] = nodes.map(|node| self.place(node));
        Some([a?, b?, c?])
    }

    /// Middle of the first mark, and the longest edge there [m].
    fn first_place(&self) -> Option<(DVec3, f64)> {
        let marked = self.marked.first();
        let marked = marked.and_then(|number| self.triangles.get(*number as usize));
        let nodes: Vec<u32> = if let Some(edge) = self.edges.first() {
            edge.to_vec()
        } else if let Some(node) = self.nodes.first() {
            vec![*node]
        } else {
            marked?.to_vec()
        };
        let places: Vec<DVec3> = nodes.iter().filter_map(|node| self.place(*node)).collect();
        let middle = places.iter().sum::<DVec3>() / places.len().max(1) as f64;
        let at = self.triangles.iter().filter(|t| t.contains(&nodes[0]));
        let longest_m = at
            .filter_map(|nodes| self.corners(*nodes))
            .flat_map(|[a, b, c]| [a.distance(b), b.distance(c), c.distance(a)])
            .fold(0.0, f64::max);
        (longest_m > 0.0 && middle.is_finite()).then_some((middle, longest_m))
    }

    /// Direction under which most of the surface within a distance of a place is seen.
    fn sight(&self, around: Option<(DVec3, f64)>) -> DVec3 {
        let near = |corners: &[DVec3; 3]| {
            around.is_none_or(|(place, reach)| corners.iter().any(|c| c.distance(place) < reach))
        };
        let areas: Vec<DVec3> = self
            .triangles
            .iter()
            .filter_map(|nodes| self.corners(*nodes))
            .filter(near)
            .map(|[a, b, c]| (b - a).cross(c - a))
            .collect();
        let seen = |sight: DVec3| -> f64 { areas.iter().map(|area| area.dot(sight).abs()).sum() };
        let sights = SIGHTS_DEG.map(|[azimuth, elevation]| sight_direction(azimuth, elevation));
        let mut best = sights[0];
        for sight in sights {
            // Another view than the usual one must be worth it.
            if seen(sight) > 1.2 * seen(best) {
                best = sight;
            }
        }
        best
    }

    /// A view of all, or of what is around a place.
    fn view(
        &self,
        around: Option<(DVec3, f64)>,
        first: Option<(DVec3, f64)>,
        width_px: u32,
    ) -> Picture {
        let viewport = PixelRect {
            x: 0,
            y: 0,
            width: width_px,
            height: VIEW_PX,
        };
        let all = bounds(self.positions_m.iter().copied());
        let (low, high) = all.unwrap_or((DVec3::ZERO, DVec3::ONE));
        let distance_m = 4.0 * (high - low).length().max(f64::MIN_POSITIVE);
        let sight = self.sight(around);
        let shown = around.map_or_else(
            || self.positions_m.to_vec(),
            |(place, half_m)| {
                let half = DVec3::splat(half_m / 3f64.sqrt());
                box_corners([place - half, place + half]).to_vec()
            },
        );
        let camera = fit_orthographic(&shown, sight, DVec3::Z, viewport.aspect(), 0.08, distance_m);
        Picture {
            width_px,
            height_px: VIEW_PX,
            page: [255; 3],
            viewport,
            background: [[249, 250, 252], [236, 240, 245]],
            camera,
            surfaces: self.surfaces(),
            polylines: self.marks(&camera, 0.5 * distance_m, first.map(|f| f.0)),
            slices: Vec::new(),
            labels: Vec::new(),
            colour_bars: Vec::new(),
        }
    }

    /// The mesh in grey, marked triangles in orange red.
    fn surfaces(&self) -> Vec<Surface> {
        let mut is_marked = vec![false; self.triangles.len()];
        for number in self.marked {
            if let Some(marked) = is_marked.get_mut(*number as usize) {
                *marked = true;
            }
        }
        let style = |width_px, opacity| LineStyle {
            width_px,
            colour: INK,
            opacity,
        };
        let edges = (self.triangles.len() <= MOST_WITH_EDGES).then(|| style(0.8, 0.3));
        [false, true]
            .map(|marked| {
                let triangles: Vec<[u32; 3]> = self
                    .triangles
                    .iter()
                    .zip(&is_marked)
                    .filter(|(_, is_marked)| **is_marked == marked)
                    .map(|(nodes, _)| *nodes)
                    .collect();
                Surface {
                    vertices_m: self.positions_m.to_vec(),
                    // What has no value is grey.
                    values: vec![if marked { 0.85 } else { f64::NAN }; triangles.len()],
                    triangles,
                    range: [0.0, 1.0],
                    scale: ColourScale::BlueRed,
                    mesh_edges: edges,
                    boundary: (!marked).then(|| style(1.4, 0.7)),
                }
            })
            .into_iter()
            .filter(|surface| !surface.triangles.is_empty())
            .collect()
    }

    /// Marks over all that would hide them: moved towards the eye of a parallel projection they stay where they are seen.
    fn marks(&self, camera: &Camera, lift_m: f64, first: Option<DVec3>) -> Vec<Polyline> {
        let sight = (camera.target_m - camera.eye_m).normalize_or(DVec3::Y);
        let lift = -lift_m * sight;
        let line = |points: Vec<DVec3>, width_px: f64, colour: Rgb| Polyline {
            points_m: points.into_iter().map(|p| p + lift).collect(),
            style: LineStyle {
                width_px,
                colour,
                opacity: 1.0,
            },
        };
        let mut lines = Vec::new();
        for edge in self.edges {
            let ends: Vec<DVec3> = edge.iter().filter_map(|node| self.place(*node)).collect();
            lines.push(line(ends, 3.0, self.colour));
        }
        for node in self.nodes {
            lines.extend(
                self.place(*node)
                    .map(|p| line(vec![p, p], 8.0, self.colour)),
            );
        }
        for number in self.marked {
            let nodes = self.triangles.get(*number as usize);
            if let Some([a, b, c]) = nodes.and_then(|nodes| self.corners(*nodes)) {
                lines.push(line(vec![a, b, c, a], 1.2, self.colour));
            }
        }
        if let (Some(place), Projection::Orthographic { height_m }) = (first, camera.projection) {
            let right = sight.cross(camera.up).normalize_or(DVec3::X);
            let up = right.cross(sight);
            let radius_m = RING_PX * height_m / f64::from(VIEW_PX);
            let ring = (0..=48).map(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 48.0).sin_cos();
                place + radius_m * (cos * right + sin * up)
            });
            lines.push(line(ring.collect(), 2.5, INK));
        }
        lines
    }
}
