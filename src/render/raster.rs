//! The software rasteriser: z-buffer, four samples per pixel, one thread, no randomness.

use glam::DVec3;
use image::RgbImage;

use super::annotate::draw_annotations;
use super::canvas::{Canvas, MAX_SIZE_PX, SAMPLES, Veil, check_count, sample_span};
use super::colour::{Rgb, blend};
use super::error::RenderError;
use super::picture::{Picture, Slice, SliceDepth, Surface};
use super::sheets::{check_slice, draw_slice};
use super::strokes::{draw_edges, draw_polyline};
use super::view::{ScreenPoint, View};

/// Share of light that reaches every face; the rest depends on how the face is turned.
pub(crate) const AMBIENT: f64 = 0.64;

/// Direction towards the lamp in view coordinates: from above, the left and the viewer's side.
pub(crate) const LAMP: DVec3 = DVec3::new(-0.48, 0.64, -0.60);

/// Share of the directed light that comes from the lamp; the rest comes from the eye.
pub(crate) const LAMP_SHARE: f64 = 0.62;

/// How far outside, in barycentric terms, a sample still belongs to a triangle: more than rounding,
/// so that neighbours leave no gap along their common edge.
const ON_EDGE: f64 = 1e-9;

/// A picture whose arguments are in order, bound to samples.
pub(crate) struct Prepared<'a> {
    /// The camera, bound to the viewport's samples.
    pub view: View,
    /// Number of samples in a row.
    pub width: usize,
    /// Number of samples in a column.
    pub height: usize,
    /// Backdrops, farthest first.
    pub behind: Vec<&'a Slice>,
    /// Sheets in space, farthest first.
    pub tested: Vec<&'a Slice>,
}

/// Checks all that a picture asks for.
pub(crate) fn prepare(picture: &Picture) -> Result<Prepared<'_>, RenderError> {
    let (width_px, height_px) = (picture.width_px, picture.height_px);
    if ![width_px, height_px]
        .iter()
        .all(|size| (1..=MAX_SIZE_PX).contains(size))
    {
        return Err(RenderError::Size {
            width_px,
            height_px,
            max_px: MAX_SIZE_PX,
        });
    }
    let port = picture.viewport;
    let fits = |start: u32, size: u32, limit: u32| {
        size > 0 && start.checked_add(size).is_some_and(|end| end <= limit)
    };
    if !(fits(port.x, port.width, width_px) && fits(port.y, port.height, height_px)) {
        return Err(RenderError::Viewport);
    }
    let (width, height) = (
        port.width as usize * SAMPLES,
        port.height as usize * SAMPLES,
    );
    let view = View::new(&picture.camera, width, height).ok_or(RenderError::Camera {
        camera: picture.camera,
    })?;
    for surface in &picture.surfaces {
        check_count("surface", surface.triangles.len(), surface.values.len())?;
    }
    for slice in &picture.slices {
        check_slice(slice)?;
    }
    let mut slices: Vec<_> = picture.slices.iter().collect();
    let depth = |centre| view.to_view(centre).z;
    slices.sort_by(|a, b| depth(b.centre_m()).total_cmp(&depth(a.centre_m())));
    let (tested, behind) = slices
        .into_iter()
        .partition(|slice| slice.depth == SliceDepth::Tested);
    Ok(Prepared {
        view,
        width,
        height,
        behind,
        tested,
    })
}

/// An image that shows nothing but the page.
pub(crate) fn empty_page(picture: &Picture) -> RgbImage {
    RgbImage::from_pixel(
        picture.width_px,
        picture.height_px,
        image::Rgb(picture.page),
    )
}

/// Draws a picture.
///
/// Primitives that are not finite, out of sight or without extent are left out.
///
/// # Errors
///
/// [`RenderError`] for an impossible size, viewport or camera, and for a surface or slice whose
/// number of values is wrong.
pub fn rasterise(picture: &Picture) -> Result<RgbImage, RenderError> {
    let prepared = prepare(picture)?;
    let mut canvas = Canvas::new(picture, &prepared);
    let Prepared { behind, tested, .. } = prepared;
    behind
        .iter()
        .for_each(|slice| draw_slice(&mut canvas, slice));
    picture
        .surfaces
        .iter()
        .for_each(|surface| draw_surface(&mut canvas, surface));
    if !tested.is_empty() {
        canvas.veils = vec![Veil::NONE; canvas.keys.len()];
    }
    tested
        .iter()
        .for_each(|slice| draw_slice(&mut canvas, slice));
    picture
        .surfaces
        .iter()
        .for_each(|surface| draw_edges(&mut canvas, surface));
    picture
        .polylines
        .iter()
        .for_each(|line| draw_polyline(&mut canvas, line));

    let mut image = empty_page(picture);
    canvas.copy_to(&mut image, picture);
    draw_annotations(&mut image, picture);
    Ok(image)
}

impl Canvas {
    fn new(picture: &Picture, prepared: &Prepared) -> Self {
        let &Prepared {
            view,
            width,
            height,
            ..
        } = prepared;
        let [top, bottom] = picture.background;
        let colours = (0..height)
            .flat_map(|row| {
                let share = (row as f32 + 0.5) / height as f32;
                std::iter::repeat_n(blend(top, bottom, share), width)
            })
            .collect();
        let keys = vec![f32::NEG_INFINITY; width * height];
        Self {
            view,
            width,
            height,
            colours,
            keys,
            veils: Vec::new(),
        }
    }

    /// Averages the samples of each pixel into the viewport.
    fn copy_to(&self, image: &mut RgbImage, picture: &Picture) {
        let port = picture.viewport;
        for y in 0..port.height {
            for x in 0..port.width {
                let corner = y as usize * SAMPLES * self.width + x as usize * SAMPLES;
                let mut sum = [0usize; 3];
                for row in 0..SAMPLES {
                    for sample in &self.colours[corner + row * self.width..][..SAMPLES] {
                        for (total, &channel) in sum.iter_mut().zip(sample) {
                            *total += usize::from(channel);
                        }
                    }
                }
                let count = SAMPLES * SAMPLES;
                let mean = sum.map(|total| ((total + count / 2) / count) as u8);
                image.put_pixel(port.x + x, port.y + y, image::Rgb(mean));
            }
        }
    }
}

/// A corner of a triangle in view coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corner {
    /// Place [m].
    pub position: DVec3,
    /// Normal of the surface, of unit length, turned to the eye.
    pub normal: DVec3,
}

fn draw_surface(canvas: &mut Canvas, surface: &Surface) {
    let view = canvas.view;
    visit_triangles(view, surface, |corners, colour| {
        let (polygon, count) = clip(corners, view.near);
        for k in 2..count {
            fill(canvas, [polygon[0], polygon[k - 1], polygon[k]], colour);
        }
    });
}

/// Shows `visit` every triangle that can be drawn with its colour before lighting.
pub(crate) fn visit_triangles(
    view: View,
    surface: &Surface,
    mut visit: impl FnMut([Corner; 3], Rgb),
) {
    let positions: Vec<DVec3> = surface
        .vertices_m
        .iter()
        .map(|p| view.to_view(*p))
        .collect();
    let corners_of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| positions.get(i as usize).copied());
        let corners = [a?, b?, c?];
        corners.iter().all(|p| p.is_finite()).then_some(corners)
    };

    // Area-weighted vertex normals.
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in &surface.triangles {
        if let Some([a, b, c]) = corners_of(triangle) {
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|&i| normals[i as usize] += normal);
        }
    }

    for (triangle, &value) in surface.triangles.iter().zip(&surface.values) {
        let Some(positions) = corners_of(triangle) else {
            continue;
        };
        let [a, b, c] = positions;
        let face = (b - a).cross(c - a);
        // Both sides are lit alike: normals are turned to the side that the eye sees.
        let toward_eye = if face.dot(view.ray_through(a)) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let corner = |k: usize| Corner {
            position: positions[k],
            normal: toward_eye * normals[triangle[k] as usize].normalize_or(face),
        };
        let colour = surface.scale.of(value, surface.range);
        visit([corner(0), corner(1), corner(2)], colour);
    }
}

/// The part of a triangle beyond the near plane: a convex polygon and its number of corners.
fn clip(triangle: [Corner; 3], near: f64) -> ([Corner; 4], usize) {
    let mut polygon = [triangle[0]; 4];
    let mut count = 0;
    let mut push = |corner| {
        if let Some(place) = polygon.get_mut(count) {
            *place = corner;
            count += 1;
        }
    };
    for k in 0..3 {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        let (da, db) = (a.position.z - near, b.position.z - near);
        if da >= 0.0 {
            push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            push(Corner {
                position: a.position.lerp(b.position, t),
                normal: a.normal.lerp(b.normal, t),
            });
        }
    }
    (polygon, count)
}

fn fill(canvas: &mut Canvas, corners: [Corner; 3], colour: Rgb) {
    let points: [ScreenPoint; 3] = corners.map(|corner| canvas.view.project(corner.position));
    let [a, b, c] = points;
    let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if !points.iter().all(ScreenPoint::is_finite) || !area.is_finite() || area.abs() < 1e-12 {
        return;
    }
    // Barycentric coordinate of corner k as an affine function of the sample's place.
    let planes: [[f64; 3]; 3] = std::array::from_fn(|k| {
        let (p, q) = (points[(k + 1) % 3], points[(k + 2) % 3]);
        let (dx, dy) = ((p.y - q.y) / area, (q.x - p.x) / area);
        [dx, dy, -(dx * p.x + dy * p.y)]
    });
    let columns = sample_span(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x), canvas.width);
    let rows = sample_span(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), canvas.height);
    for row in rows {
        let y = row as f64 + 0.5;
        for column in columns.clone() {
            let x = column as f64 + 0.5;
            let share = planes.map(|[dx, dy, constant]| dx * x + dy * y + constant);
            if share.iter().any(|s| *s < -ON_EDGE) {
                continue;
            }
            let key = (share[0] * a.key + share[1] * b.key + share[2] * c.key) as f32;
            let sample = row * canvas.width + column;
            if key <= canvas.keys[sample] {
                continue;
            }
            canvas.keys[sample] = key;
            let normal = (0..3)
                .map(|k| corners[k].normal * (share[k] * points[k].weight))
                .sum::<DVec3>()
                .normalize_or_zero();
            let light = light(normal);
            canvas.colours[sample] = colour.map(|channel| (f64::from(channel) * light + 0.5) as u8);
        }
    }
}

/// Share of a colour that a face with this unit normal (in view coordinates) shows.
fn light(normal: DVec3) -> f64 {
    let lamp = normal.dot(LAMP).max(0.0);
    let eye = (-normal.z).max(0.0);
    AMBIENT + (1.0 - AMBIENT) * (LAMP_SHARE * lamp + (1.0 - LAMP_SHARE) * eye)
}

#[cfg(test)]
#[path = "raster_tests.rs"]
mod tests;
