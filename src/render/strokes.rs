//! Drawing lines: each sample is covered by how near it lies to the line, which smooths the rims.

use std::collections::BTreeMap;

use glam::DVec3;

use super::canvas::{Canvas, SAMPLES, Veil, sample_span};
use super::colour::{Rgb, blend};
use super::picture::{LineStyle, Polyline, Surface};
use super::view::{ScreenPoint, View};

/// How far lines are drawn towards the eye, in line widths, so that a line along a surface is seen
/// over its whole width.
const LIFT: f64 = 2.0;

/// A straight stretch of a line, ready to be drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    /// Its ends on the screen.
    pub points: [ScreenPoint; 2],
    /// Nearness of the ends, lifted towards the eye.
    pub keys: [f64; 2],
    /// Half its width [samples].
    pub radius: f64,
    /// Opacity, 0…1.
    pub opacity: f64,
    /// Colour.
    pub colour: Rgb,
}

impl Stroke {
    /// The part beyond the near plane of the stretch between two points in space [m]; `None` for what cannot be drawn.
    pub fn new(view: View, ends_m: [DVec3; 2], style: LineStyle) -> Option<Self> {
        let mut ends = ends_m.map(|end| view.to_view(end));
        if !ends.iter().all(|end| end.is_finite()) || ends.iter().all(|end| end.z < view.near) {
            return None;
        }
        for k in 0..2 {
            let (end, other) = (ends[k], ends[1 - k]);
            if end.z < view.near {
                ends[k] = end.lerp(other, (view.near - end.z) / (other.z - end.z));
            }
        }
        let width = style.width_px * SAMPLES as f64;
        let keys = ends.map(|end| {
            let lift = LIFT * width * view.pixel_size(end.z);
            view.key((end.z - lift).max(0.5 * end.z))
        });
        let points = ends.map(|end| view.project(end));
        let drawable = points.iter().all(ScreenPoint::is_finite) && width.is_finite();
        (drawable && width > 0.0).then(|| Self {
            points,
            keys,
            // A line thinner than a sample is drawn one sample wide and fainter.
            radius: 0.5 * width.max(1.0),
            opacity: f64::from(style.opacity.clamp(0.0, 1.0)) * width.min(1.0),
            colour: style.colour,
        })
    }
}

/// Draws a line; it hides what is behind it.
pub(super) fn draw_polyline(canvas: &mut Canvas, line: &Polyline) {
    for pair in line.points_m.windows(2) {
        if let Some(stroke) = Stroke::new(canvas.view, [pair[0], pair[1]], line.style) {
            draw_stroke(canvas, &stroke, true);
        }
    }
}

/// Draws the edges of a surface in the styles it asks for.
pub(super) fn draw_edges(canvas: &mut Canvas, surface: &Surface) {
    for (ends_m, style) in edges(surface) {
        if let Some(stroke) = Stroke::new(canvas.view, ends_m, style) {
            draw_stroke(canvas, &stroke, false);
        }
    }
}

/// The edges of a surface that are drawn: their ends [m] and their styles.
pub(crate) fn edges(surface: &Surface) -> Vec<([DVec3; 2], LineStyle)> {
    if surface.mesh_edges.is_none() && surface.boundary.is_none() {
        return Vec::new();
    }
    let mut uses: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for &[a, b, c] in &surface.triangles {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            *uses.entry([p.min(q), p.max(q)]).or_default() += 1;
        }
    }
    let vertex = |index: u32| surface.vertices_m.get(index as usize).copied();
    let styled = |([p, q], count): ([u32; 2], u32)| {
        let style = if count == 1 {
            surface.boundary.or(surface.mesh_edges)
        } else {
            surface.mesh_edges
        };
        Some(([vertex(p)?, vertex(q)?], style?))
    };
    uses.into_iter().filter_map(styled).collect()
}

fn draw_stroke(canvas: &mut Canvas, stroke: &Stroke, hides: bool) {
    let &Stroke {
        points,
        keys,
        radius,
        opacity,
        colour,
    } = stroke;
    let [a, b] = points;
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length_squared = dx * dx + dy * dy;
    let reach = radius + 1.0;
    let rows = sample_span(a.y.min(b.y) - reach, a.y.max(b.y) + reach, canvas.height);
    let whole = [a.x.min(b.x) - reach, a.x.max(b.x) + reach];
    for row in rows {
        let y = row as f64 + 0.5;
        // The stretch of the row that the line can reach.
        let [mut low, mut high] = whole;
        if dy.abs() > 1e-9 {
            let middle = a.x + dx * (y - a.y) / dy;
            let half = reach * length_squared.sqrt() / dy.abs();
            low = low.max(middle - half);
            high = high.min(middle + half);
        }
        for column in sample_span(low, high, canvas.width) {
            let (px, py) = (column as f64 + 0.5 - a.x, y - a.y);
            let t = if length_squared > 0.0 {
                ((px * dx + py * dy) / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let distance = (px - t * dx).hypot(py - t * dy);
            let coverage = (radius + 0.5 - distance).clamp(0.0, 1.0);
            let key = (keys[0] + t * (keys[1] - keys[0])) as f32;
            let sample = row * canvas.width + column;
            if coverage <= 0.0 || key < canvas.keys[sample] {
                continue;
            }
            let veil = canvas.veils.get(sample).copied().unwrap_or(Veil::NONE);
            let passes = if key < veil.key { veil.passes } else { 1.0 };
            let below = &mut canvas.colours[sample];
            *below = blend(*below, colour, (coverage * opacity) as f32 * passes);
            if hides && coverage > 0.5 {
                canvas.keys[sample] = key;
            }
        }
    }
}
