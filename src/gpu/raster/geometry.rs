//! What a picture shows, in numbers for the device.
//!
//! Everything is put into view coordinates, or onto the screen, in double precision here; the shader only projects.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

use super::cutting::{cut_polygon, cut_stroke};
use crate::gpu::shaders::parameters;
use crate::render::canvas::SAMPLES;
use crate::render::colour::{Rgb, fraction};
use crate::render::picture::{Picture, Slice, SliceDepth};
use crate::render::raster::{AMBIENT, Corner, LAMP, LAMP_SHARE, Prepared, visit_triangles};
use crate::render::sheets::Sheet;
use crate::render::strokes::{Stroke, edges};
use crate::render::view::View;

// The shader's GRID.
const _: () = assert!(SAMPLES == 2);

/// Value of a slice where it has a hole.
const HOLE: f32 = -1e30;

/// Values of a slice are cut here, far off any scale but well away from [`HOLE`].
const LARGEST_VALUE: f64 = 1e20;

parameters! {
    /// The camera, its light and its background. Places on the screen are in samples.
    RasterView {
        /// Colour at the top, opaque.
        background_top: [f32; 4],
        /// Colour at the bottom, opaque.
        background_bottom: [f32; 4],
        /// Direction towards the lamp in view coordinates, and its share of the directed light.
        lamp: [f32; 4],
        /// From view coordinates to clip coordinates [1/m]; for a perspective view before the division by depth.
        scale: [f32; 2],
        /// Columns and rows of samples.
        size: [f32; 2],
        /// Depth of the near plane [m].
        near: f32,
        /// Depth that becomes 0 in a parallel view [m].
        far: f32,
        /// How fast depth falls with distance in a parallel view [1/m].
        depth_slope: f32,
        /// Share of light that reaches every face.
        ambient: f32,
        /// 1 for a perspective view.
        perspective: u32,
        /// Number of translucent sheets that dim lines; they come first.
        veils: u32,
        /// Padding.
        unused: [u32; 2],
    }
    /// A slice. Its first four fields are affine functions of the place on the screen relative to the viewport's centre.
    RasterSheet {
        /// Place along the first edge, times the weight.
        first_place: [f32; 4],
        /// Place along the second edge, times the weight.
        second_place: [f32; 4],
        /// The weight; positive in front of the eye.
        weight: [f32; 4],
        /// Depth as in the depth buffer.
        depth: [f32; 4],
        /// Opacity, 0…1.
        opacity: f32,
        /// Where its values begin.
        first_value: u32,
        /// Number of values along the first edge.
        columns: u32,
        /// Number of values along the second edge.
        rows: u32,
    }
}

/// A corner of a triangle.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct SurfaceVertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub colour: [u8; 4],
}

/// A corner of a slice.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct SheetVertex {
    pub position: [f32; 3],
    pub sheet: u32,
}

/// A straight stretch of a line on the screen [samples].
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct LineInstance {
    /// x and y of the start, then of the end.
    pub ends: [f32; 4],
    /// Depths of the ends.
    pub depths: [f32; 2],
    /// Half the width, and the opacity.
    pub look: [f32; 2],
    pub colour: [u8; 4],
}

/// All that the device is given for one picture.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub view: RasterView,
    pub surfaces: Vec<SurfaceVertex>,
    /// Edges of surfaces.
    pub edges: Vec<LineInstance>,
    pub lines: Vec<LineInstance>,
    /// The stretches of each line.
    pub line_ranges: Vec<Range<u32>>,
    /// Translucent ones, opaque ones, backdrops.
    pub sheets: Vec<RasterSheet>,
    pub sheet_vertices: Vec<SheetVertex>,
    /// The corners of the sheets of each kind.
    pub sheet_ranges: [Range<u32>; 3],
    pub values: Vec<f32>,
    /// 256 for each sheet, red in the lowest byte.
    pub colours: Vec<u32>,
}

/// How depth is stored: 1 at the near plane, falling with distance. A perspective view stores near/depth, which reaches 0 at
/// infinity; a parallel view falls in proportion to depth and reaches 0 behind all that is shown.
#[derive(Debug, Clone, Copy)]
struct DepthRange {
    perspective: bool,
    near: f64,
    far: f64,
}

impl DepthRange {
    fn new(view: View, depths: impl Iterator<Item = f64>) -> Self {
        let (low, high) = depths
            .filter(|depth| depth.is_finite())
            .fold((f64::INFINITY, view.near), |(low, high), depth| {
                (low.min(depth), high.max(depth))
            });
        let low = low.clamp(view.near, high);
        let margin = 0.01 * (high - low) + 1e-3 * view.near;
        Self {
            perspective: view.perspective,
            near: if view.perspective {
                view.near
            } else {
                (low - margin).max(view.near)
            },
            far: high + margin,
        }
    }

    fn slope(self) -> f64 {
        1.0 / (self.far - self.near)
    }

    /// What is stored for a nearness of the software rasteriser.
    fn stored(self, key: f64) -> f64 {
        if self.perspective {
            self.near * key
        } else {
            (self.far + key) * self.slope()
        }
    }
}

impl Geometry {
    pub fn new(picture: &Picture, prepared: &Prepared) -> Self {
        let view = prepared.view;
        let screen = DVec2::new(prepared.width as f64, prepared.height as f64);
        let scale = 2.0 * view.scale / screen;

        let mut surfaces = Vec::new();
        for surface in &picture.surfaces {
            visit_triangles(view, surface, |corners, colour| {
                for corner in cut_polygon(view, scale, &corners).into_iter().flatten() {
                    surfaces.push(SurfaceVertex {
                        position: corner.position.as_vec3().to_array(),
                        normal: corner.normal.normalize_or_zero().as_vec3().to_array(),
                        colour: packed(colour),
                    });
                }
            });
        }
        let strokes_of = |ends_m: [DVec3; 2], style| {
            Stroke::new(view, ends_m, style).and_then(|stroke| cut_stroke(stroke, screen))
        };
        let edge_strokes: Vec<Stroke> = (picture.surfaces.iter())
            .flat_map(edges)
            .filter_map(|(ends_m, style)| strokes_of(ends_m, style))
            .collect();
        let line_strokes: Vec<Vec<Stroke>> = (picture.polylines.iter())
            .map(|line| {
                (line.points_m.windows(2))
                    .filter_map(|pair| strokes_of([pair[0], pair[1]], line.style))
                    .collect()
            })
            .collect();
        let sheets: Vec<CutSlice> = (prepared.tested.iter())
            .chain(&prepared.behind)
            .filter_map(|slice| CutSlice::new(view, scale, slice))
            .collect();

        let stroke_depths = (edge_strokes.iter())
            .chain(line_strokes.iter().flatten())
            .flat_map(|stroke| stroke.keys.map(|key| -key));
        let sheet_depths = (sheets.iter())
            .flat_map(|sheet| sheet.triangles.iter().flatten())
            .map(|corner| corner.position.z);
        let surface_depths = surfaces.iter().map(|v| f64::from(v.position[2]));
        let range = DepthRange::new(
            view,
            surface_depths.chain(stroke_depths).chain(sheet_depths),
        );

        let instance = |stroke: &Stroke| line_instance(stroke, range);
        let mut geometry = Self {
            surfaces,
            edges: edge_strokes.iter().map(instance).collect(),
            ..Self::default()
        };
        for strokes in &line_strokes {
            let start = geometry.lines.len() as u32;
            geometry.lines.extend(strokes.iter().map(instance));
            let end = geometry.lines.len() as u32;
            geometry.line_ranges.push(start..end);
        }
        for kind in 0..3 {
            let start = geometry.sheet_vertices.len() as u32;
            for sheet in sheets.iter().filter(|sheet| sheet.kind == kind) {
                geometry.add_sheet(view, range, sheet);
            }
            geometry.sheet_ranges[kind] = start..geometry.sheet_vertices.len() as u32;
        }
        let veils = sheets.iter().filter(|sheet| sheet.kind == 0).count();
        let [top, bottom] = picture.background.map(opaque);
        geometry.view = RasterView {
            background_top: top,
            background_bottom: bottom,
            lamp: LAMP.extend(LAMP_SHARE).as_vec4().to_array(),
            scale: scale.as_vec2().to_array(),
            size: screen.as_vec2().to_array(),
            near: range.near as f32,
            far: range.far as f32,
            depth_slope: range.slope() as f32,
            ambient: AMBIENT as f32,
            perspective: u32::from(view.perspective),
            veils: veils as u32,
            unused: [0; 2],
        };
        geometry
    }

    fn add_sheet(&mut self, view: View, range: DepthRange, sheet: &CutSlice) {
        let slice = sheet.slice;
        let index = self.sheets.len() as u32;
        let first_value = self.values.len() as u32;
        self.values.extend(slice.values.iter().map(|&value| {
            let value = fraction(f64::from(value), slice.range);
            if value.is_finite() {
                value.clamp(-LARGEST_VALUE, LARGEST_VALUE) as f32
            } else {
                HOLE
            }
        }));
        let colours = slice.scale.table();
        self.colours
            .extend(colours.map(|colour| u32::from_le_bytes(packed(colour))));
        let corners = sheet.triangles.iter().flatten();
        self.sheet_vertices
            .extend(corners.map(|corner| SheetVertex {
                position: corner.position.as_vec3().to_array(),
                sheet: index,
            }));
        let [first_place, second_place, weight, depth] = screen_planes(view, range, sheet.plane)
            .map(|plane| plane.extend(0.0).as_vec4().to_array());
        self.sheets.push(RasterSheet {
            first_place,
            second_place,
            weight,
            depth,
            opacity: slice.opacity.clamp(0.0, 1.0),
            first_value,
            columns: slice.counts[0] as u32,
            rows: slice.counts[1] as u32,
        });
    }
}

/// The part of a slice that may be seen.
struct CutSlice<'a> {
    slice: &'a Slice,
    plane: Sheet,
    /// Place among [`Geometry::sheet_ranges`].
    kind: usize,
    triangles: Vec<[Corner; 3]>,
}

impl<'a> CutSlice<'a> {
    /// `None` for a slice that has no values or no extent, is out of sight or seen on edge.
    fn new(view: View, scale: DVec2, slice: &'a Slice) -> Option<Self> {
        let plane = Sheet::new(view, slice).filter(|_| !slice.values.is_empty())?;
        let range = DepthRange::new(view, std::iter::empty());
        let corners = slice.corners_m().map(|corner| Corner {
            position: view.to_view(corner),
            normal: DVec3::ZERO,
        });
        let triangles = cut_polygon(view, scale, &corners);
        let drawable = !triangles.is_empty()
            && (screen_planes(view, range, plane).iter()).all(|plane| plane.is_finite());
        drawable.then_some(Self {
            slice,
            plane,
            kind: match slice.depth {
                SliceDepth::Tested if slice.opacity < 1.0 => 0,
                SliceDepth::Tested => 1,
                SliceDepth::Behind => 2,
            },
            triangles,
        })
    }
}

/// The four affine functions of a [`RasterSheet`], each as its slopes along x and y and its value at the viewport's centre.
fn screen_planes(view: View, range: DepthRange, sheet: Sheet) -> [DVec3; 4] {
    let Sheet {
        origin,
        normal,
        dual,
    } = sheet;
    // View x and y per sample.
    let across = |d: DVec3| DVec2::new(d.x, -d.y) / view.scale;
    if view.perspective {
        // The ray's direction is (x, y, 1): its product with a vector is affine, and 1/depth follows from the normal's.
        let along = |d: DVec3| across(d).extend(d.z);
        let key = along(normal) / normal.dot(origin);
        let place = dual.map(|d| along(d) - d.dot(origin) * key);
        [place[0], place[1], key, range.near * key]
    } else {
        // The ray starts at (x, y, 0) and runs along z.
        let depth = (-across(normal)).extend(normal.dot(origin)) / normal.z;
        let place = dual.map(|d| across(d).extend(-d.dot(origin)) + d.z * depth);
        let stored = DVec3::Z * range.far - depth;
        [place[0], place[1], DVec3::Z, range.slope() * stored]
    }
}

fn line_instance(stroke: &Stroke, range: DepthRange) -> LineInstance {
    let [a, b] = stroke.points;
    LineInstance {
        ends: [a.x, a.y, b.x, b.y].map(|place| place as f32),
        // A line at the near plane is lifted no farther.
        depths: stroke
            .keys
            .map(|key| range.stored(key).clamp(0.0, 1.0) as f32),
        look: [stroke.radius as f32, stroke.opacity as f32],
        colour: packed(stroke.colour),
    }
}

fn packed([red, green, blue]: Rgb) -> [u8; 4] {
    [red, green, blue, 255]
}

fn opaque(colour: Rgb) -> [f32; 4] {
    packed(colour).map(|channel| f32::from(channel) / 255.0)
}
