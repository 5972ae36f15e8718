//! Drawing slices: a ray through every sample, so that they need no clipping and have no seams.

use glam::DVec3;
use rayon::prelude::*;

use super::canvas::{Canvas, Veil, check_count, sample_span};
use super::colour::{Rgb, blend, fraction};
use super::error::RenderError;
use super::picture::{Slice, SliceDepth};
use super::view::View;

impl Slice {
    /// Centre of the parallelogram [m].
    #[must_use]
    pub fn centre_m(&self) -> DVec3 {
        self.origin_m + 0.5 * (self.edges_m[0] + self.edges_m[1])
    }

    /// The four corners [m], in order around the parallelogram.
    #[must_use]
    pub fn corners_m(&self) -> [DVec3; 4] {
        let ([u, v], o) = (self.edges_m, self.origin_m);
        [o, o + u, o + u + v, o + v]
    }

    /// Bilinear interpolation at `place`, which runs from 0 to 1 along either edge; the values are
    /// held constant over the outer half of the cells at the rim. NaN where there is none.
    #[must_use]
    pub fn value_at(&self, place: [f64; 2]) -> f64 {
        let [columns, rows] = self.counts;
        if columns == 0 || rows == 0 || self.values.len() < columns * rows {
            return f64::NAN;
        }
        let (i0, i1, s) = neighbours(place[0], columns);
        let (j0, j1, t) = neighbours(place[1], rows);
        let value = |i: usize, j: usize| f64::from(self.values[j * columns + i]);
        let low = value(i0, j0) * (1.0 - s) + value(i1, j0) * s;
        let high = value(i0, j1) * (1.0 - s) + value(i1, j1) * s;
        low * (1.0 - t) + high * t
    }
}

/// The two of `count` (at least 1) cell centres around a place in 0…1, and the second's share.
fn neighbours(place: f64, count: usize) -> (usize, usize, f64) {
    let position = (place * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
    let first = position as usize;
    (first, (first + 1).min(count - 1), position - first as f64)
}

/// An error unless the slice has one value for each grid point.
pub(super) fn check_slice(slice: &Slice) -> Result<(), RenderError> {
    check_count(
        "slice",
        slice.counts[0].saturating_mul(slice.counts[1]),
        slice.values.len(),
    )
}

/// The plane of a slice in view coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sheet {
    /// Corner of the parallelogram [m].
    pub origin: DVec3,
    /// Normal, of any length.
    pub normal: DVec3,
    /// Vectors whose products with a place relative to the corner are its coordinates along the two edges, 0…1.
    pub dual: [DVec3; 2],
}

impl Sheet {
    /// `None` for a slice without extent or finite place.
    pub fn new(view: View, slice: &Slice) -> Option<Self> {
        let origin = view.to_view(slice.origin_m);
        let [e0, e1] = slice.edges_m.map(|edge| view.direction(edge));
        let normal = e0.cross(e1);
        let dual = [e1.cross(normal), normal.cross(e0)].map(|d| d / normal.length_squared());
        let sound = dual.iter().all(|d| d.is_finite()) && origin.is_finite();
        sound.then_some(Self {
            origin,
            normal,
            dual,
        })
    }
}

/// Colours, depth keys and veils of a row of samples; without veils an empty slice.
type RowOfCanvas<'a> = (&'a mut [Rgb], &'a mut [f32], &'a mut [Veil]);

/// Blends a slice over what the canvas shows.
pub(super) fn draw_slice(canvas: &mut Canvas, slice: &Slice) {
    let view = canvas.view;
    let Some(Sheet {
        origin,
        normal,
        dual,
    }) = Sheet::new(view, slice)
    else {
        return;
    };
    let opacity = slice.opacity.clamp(0.0, 1.0);
    let colours = slice.scale.table();
    let (columns, rows) = screen_bounds(canvas, slice);
    let mut veils = canvas.veils.chunks_mut(canvas.width);
    let rows_of_canvas: Vec<_> = (canvas.colours.chunks_mut(canvas.width))
        .zip(canvas.keys.chunks_mut(canvas.width))
        .map(|(colours, keys)| (colours, keys, veils.next().unwrap_or_default()))
        .enumerate()
        .filter(|(row, _)| rows.contains(row))
        .collect();
    let draw_row = |(row, (below, keys, veils)): (usize, RowOfCanvas<'_>)| {
        for column in columns.clone() {
            let (start, direction) = view.ray(column as f64 + 0.5, row as f64 + 0.5);
            let depth = normal.dot(origin - start) / normal.dot(direction);
            if !(depth >= view.near && depth.is_finite()) {
                continue;
            }
            let offset = start + depth * direction - origin;
            let place = dual.map(|d| d.dot(offset));
            if !place.iter().all(|p| (0.0..=1.0).contains(p)) {
                continue;
            }
            let value = fraction(slice.value_at(place), slice.range);
            if value.is_nan() {
                continue;
            }
            if slice.depth == SliceDepth::Tested {
                let key = view.key(depth) as f32;
                if key <= keys[column] {
                    continue;
                }
                if opacity >= 1.0 {
                    keys[column] = key;
                } else if let Some(veil) = veils.get_mut(column) {
                    let passes = (1.0 - opacity) * veil.passes;
                    *veil = Veil {
                        key: key.max(veil.key),
                        passes,
                    };
                }
            }
            let colour = colours[(value.clamp(0.0, 1.0) * 255.0 + 0.5) as usize];
            below[column] = blend(below[column], colour, opacity);
        }
    };
    rows_of_canvas.into_par_iter().for_each(draw_row);
}

/// Columns and rows of samples that the slice may cover.
fn screen_bounds(
    canvas: &Canvas,
    slice: &Slice,
) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
    let corners = slice.corners_m().map(|corner| canvas.view.to_view(corner));
    if corners.iter().any(|corner| corner.z < canvas.view.near) {
        return (0..canvas.width, 0..canvas.height);
    }
    let points = corners.map(|corner| canvas.view.project(corner));
    let span = |values: [f64; 4], size| {
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        sample_span(low, high, size)
    };
    (
        span(points.map(|p| p.x), canvas.width),
        span(points.map(|p| p.y), canvas.height),
    )
}
