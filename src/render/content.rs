//! Drawable pieces of a frame: lines, rigid bodies and slices of air.

use glam::DVec3;

use super::colour::{ColourScale, Rgb};
use super::picture::{LineStyle, Polyline, Surface};
use crate::frame::{BodiesFrame, CableKind, FluidFrame, StructureFrame};

/// Colours of air speed.
pub(super) const SPEED_SCALE: ColourScale = ColourScale::Mist;

/// Colour of lines and outlines.
pub(super) const INK: Rgb = [28, 32, 40];

/// Values above this share of all do not widen a range.
const RANGE_SHARE: f64 = 0.98;

/// A coordinate direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// Downstream.
    X = 0,
    /// Across.
    Y = 1,
    /// Upwards.
    Z = 2,
}

impl Axis {
    /// The axes that run to the right and upwards in a slice normal to this one.
    pub fn in_plane(self) -> [usize; 2] {
        match self {
            Self::X => [1, 2],
            Self::Y => [0, 2],
            Self::Z => [0, 1],
        }
    }

    /// Line of sight and upward direction under which a slice normal to this axis is seen squarely,
    /// its first index running to the right and its second upwards.
    pub fn square_view(self) -> (DVec3, DVec3) {
        match self {
            Self::X => (DVec3::NEG_X, DVec3::Z),
            Self::Y => (DVec3::Y, DVec3::Z),
            Self::Z => (DVec3::NEG_Z, DVec3::Y),
        }
    }
}

/// From 0 to the value that 98 % of the finite values do not exceed; from 0 to 1 if that is not
/// above 0.
#[must_use]
pub fn range_from_zero(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let index = (values.len() as f64 * RANGE_SHARE).ceil() as usize;
    let top = values.get(index.saturating_sub(1)).copied().unwrap_or(0.0);
    [0.0, if top > 0.0 { top } else { 1.0 }]
}

/// Rigid bodies, in one grey.
pub(super) fn bodies(bodies: &BodiesFrame, zoom: f64) -> Surface {
    let style = |width: f64, opacity| LineStyle {
        width_px: width * zoom,
        colour: INK,
        opacity,
    };
    Surface {
        vertices_m: bodies.positions_m.clone(),
        triangles: bodies.triangles.clone(),
        // What has no value is grey.
        values: vec![f64::NAN; bodies.triangles.len()],
        range: [0.0, 1.0],
        scale: SPEED_SCALE,
        mesh_edges: Some(style(0.4, 0.12)),
        boundary: Some(style(1.4, 0.9)),
    }
}

/// The cables, joined into lines where one segment starts at the end of the one before.
pub(super) fn cables(structure: &StructureFrame, zoom: f64) -> Vec<Polyline> {
    let mut lines: Vec<Polyline> = Vec::new();
    let mut last: Option<(u32, CableKind)> = None;
    for (&[start, end], &kind) in structure.cables.iter().zip(&structure.cable_kinds) {
        let point = |i: u32| structure.positions_m.get(i as usize).copied();
        let (Some(start_m), Some(end_m)) = (point(start), point(end)) else {
            last = None;
            continue;
        };
        match lines.last_mut() {
            Some(line) if last == Some((start, kind)) => line.points_m.push(end_m),
            _ => lines.push(Polyline {
                points_m: vec![start_m, end_m],
                style: style(kind, zoom),
            }),
        }
        last = Some((end, kind));
    }
    lines
}

fn style(kind: CableKind, zoom: f64) -> LineStyle {
    let (width_px, opacity) = match kind {
        CableKind::SuspensionLine => (2.0, 1.0),
        CableKind::Belt => (1.2, 0.85),
        CableKind::VentLine | CableKind::GapLine => (1.2, 1.0),
        CableKind::Riser | CableKind::Cable => (3.0, 1.0),
    };
    LineStyle {
        width_px: width_px * zoom,
        colour: INK,
        opacity,
    }
}

/// Lowest and highest corner of the air's grid [m].
pub(super) fn air_box(fluid: &FluidFrame) -> [DVec3; 2] {
    let low = fluid.origin_m - DVec3::splat(0.5 * fluid.cell_size_m);
    let cells = DVec3::from_array(fluid.cells.map(|count| count as f64));
    [low, low + fluid.cell_size_m * cells]
}

/// The axis along which the air has the fewest cells; across the flow if in doubt.
pub(super) fn thinnest_axis(fluid: &FluidFrame) -> Axis {
    let [x, y, z] = fluid.cells;
    if y <= x && y <= z {
        Axis::Y
    } else if z <= x {
        Axis::Z
    } else {
        Axis::X
    }
}
