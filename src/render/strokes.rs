//! Drawing lines: each sample is covered by how near it lies to the line, which smooths the rims.

use std::collections::BTreeMap;

use glam::DVec3;

use super::colour::blend;
use super::picture::{LineStyle, Polyline, Surface};
use super::raster::{Canvas, SAMPLES, Veil, sample_span};

/// How far lines are drawn towards the eye, in line widths, so that a line along a surface is seen
/// over its whole width.
const LIFT: f64 = 2.0;

/// Draws a line; it hides what is behind it.
pub(super) fn draw_polyline(canvas: &mut Canvas, line: &Polyline) {
    for pair in line.points_m.windows(2) {
        draw_segment(canvas, [pair[0], pair[1]], line.style, true);
    }
}

/// Draws the edges of a surface in the styles it asks for.
pub(super) fn draw_edges(canvas: &mut Canvas, surface: &Surface) {
    if surface.mesh_edges.is_none() && surface.boundary.is_none() {
        return;
    }
    let mut uses: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for &[a, b, c] in &surface.triangles {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            *uses.entry([p.min(q), p.max(q)]).or_default() += 1;
        }
    }
    let vertex = |index: u32| surface.vertices_m.get(index as usize).copied();
    for ([p, q], count) in uses {
        let style = if count == 1 {
            surface.boundary.or(surface.mesh_edges)
        } else {
            surface.mesh_edges
        };
        if let (Some(style), Some(p), Some(q)) = (style, vertex(p), vertex(q)) {
            draw_segment(canvas, [p, q], style, false);
        }
    }
}

fn draw_segment(canvas: &mut Canvas, ends_m: [DVec3; 2], style: LineStyle, hides: bool) {
    let view = canvas.view;
    let mut ends = ends_m.map(|end| view.to_view(end));
    if !ends.iter().all(|end| end.is_finite()) || ends.iter().all(|end| end.z < view.near) {
        return;
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
    let drawable = points.iter().all(|point| point.is_finite()) && width.is_finite();
    if !drawable || width <= 0.0 {
        return;
    }
    // A line thinner than a sample is drawn one sample wide and fainter.
    let radius = 0.5 * width.max(1.0);
    let opacity = f64::from(style.opacity.clamp(0.0, 1.0)) * width.min(1.0);

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
            *below = blend(*below, style.colour, (coverage * opacity) as f32 * passes);
            if hides && coverage > 0.5 {
                canvas.keys[sample] = key;
            }
        }
    }
}
