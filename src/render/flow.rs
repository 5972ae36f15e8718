//! Slices of air: speed, vorticity or pressure on a plane, and arrows of its velocity there.

use glam::DVec3;

use super::colour::ColourScale;
use super::content::{Axis, INK, SPEED_SCALE, air_box, range_from_zero};
use super::picture::{LineStyle, Polyline, Slice, SliceDepth};
use crate::frame::{FlowQuantity, FluidFrame};

/// Arrows along the longer side of a slice, at most.
const ARROWS: usize = 48;

/// Length of an arrow at the reference speed, over the distance of arrows.
const ARROW_LENGTH: f64 = 0.9;

/// Heads of arrows over their length.
const ARROW_HEAD: f64 = 0.3;

/// Heading of the colour bar.
pub(super) const fn title(quantity: FlowQuantity) -> &'static str {
    match quantity {
        FlowQuantity::Speed => "Air speed [m/s]",
        FlowQuantity::Vorticity => "Vorticity [1/s]",
        FlowQuantity::Pressure => "Pressure [Pa]",
    }
}

/// Colours of a quantity.
pub(super) const fn scale(quantity: FlowQuantity) -> ColourScale {
    match quantity {
        FlowQuantity::Speed => SPEED_SCALE,
        FlowQuantity::Vorticity | FlowQuantity::Pressure => ColourScale::BlueRed,
    }
}

/// From 0, or evenly about 0, to what 98 % of the values do not exceed.
pub(super) fn range(quantity: FlowQuantity, slices: &[Slice]) -> [f64; 2] {
    let values = slices.iter().flat_map(|slice| &slice.values);
    let values = values.map(|v| f64::from(*v));
    match quantity {
        FlowQuantity::Speed => range_from_zero(values),
        FlowQuantity::Vorticity | FlowQuantity::Pressure => {
            let [_, top] = range_from_zero(values.map(f64::abs));
            [-top, top]
        }
    }
}

/// A plane through the air, with its parts in boxes of finer cells.
pub(super) struct Section<'a> {
    /// In the outermost grid, then in boxes, each before those in it.
    planes: Vec<Plane<'a>>,
}

impl<'a> Section<'a> {
    /// The plane normal to `normal` at the coordinate `place_m` [m], which is moved into the air. `None` without cells.
    pub fn new(fluid: &'a FluidFrame, normal: Axis, place_m: f64) -> Option<Self> {
        let outermost = Plane::new(fluid, normal, place_m)?;
        let place_m = outermost.origin_m[normal as usize];
        let boxes = fluid.finer.iter().filter(|finer| {
            let [low, high] = air_box(finer);
            (low[normal as usize]..high[normal as usize]).contains(&place_m)
        });
        let boxes = boxes.filter_map(|finer| Plane::new(finer, normal, place_m));
        Some(Self {
            planes: std::iter::once(outermost).chain(boxes).collect(),
        })
    }

    /// A quantity on the plane, the outermost grid first; the range is left at [0, 1]. Coarser cells under finer ones are left out.
    pub fn slices(&self, quantity: FlowQuantity, depth: SliceDepth) -> Vec<Slice> {
        let slice = |(number, plane): (usize, &Plane)| {
            let mut slice = plane.slice(quantity, depth);
            for finer in &self.planes[number + 1..] {
                plane.leave_out(finer, &mut slice.values);
            }
            slice
        };
        self.planes.iter().enumerate().map(slice).collect()
    }

    /// Where boxes of finer cells end, thinly.
    pub fn outlines(&self, zoom: f64) -> Vec<Polyline> {
        let outline = |plane: &Plane| {
            let [across, up] = plane.edges_m();
            let corner = plane.origin_m;
            Polyline {
                points_m: vec![
                    corner,
                    corner + across,
                    corner + across + up,
                    corner + up,
                    corner,
                ],
                style: LineStyle {
                    width_px: 0.8 * zoom,
                    colour: INK,
                    opacity: 0.3,
                },
            }
        };
        self.planes[1..].iter().map(outline).collect()
    }

    /// Arrows of the velocity in the plane, as long as their distance at `reference_m_s`; none where air is slower than a twentieth of it.
    pub fn arrows(&self, reference_m_s: f64, zoom: f64) -> Vec<Polyline> {
        let outermost = &self.planes[0];
        outermost.arrows(reference_m_s, zoom, |place_m| {
            let holder = self.planes.iter().rev();
            holder
                .filter_map(|plane| plane.velocity_at(place_m))
                .next()
                .unwrap_or([f32::NAN; 3])
        })
    }
}

/// A plane through one grid, between two layers of cells.
pub(super) struct Plane<'a> {
    fluid: &'a FluidFrame,
    normal: Axis,
    counts: [usize; 2],
    layers: [usize; 2],
    share: f32,
    /// Corner of the plane [m].
    origin_m: DVec3,
}

impl<'a> Plane<'a> {
    /// The plane normal to `normal` at the coordinate `place_m` [m], which is moved into the grid. `None` without cells.
    pub fn new(fluid: &'a FluidFrame, normal: Axis, place_m: f64) -> Option<Self> {
        let axis = normal as usize;
        let [i_axis, j_axis] = normal.in_plane();
        let layers = fluid.cells[axis];
        let counts = [fluid.cells[i_axis], fluid.cells[j_axis]];
        let size = fluid.cell_size_m;
        if layers == 0 || counts.contains(&0) || !(size > 0.0 && place_m.is_finite()) {
            return None;
        }
        let place = (place_m - fluid.origin_m[axis]) / size;
        let place = place.clamp(0.0, (layers - 1) as f64);
        let layer = place as usize;
        let [low, _] = air_box(fluid);
        let mut origin_m = low;
        origin_m[axis] = place_m.clamp(low[axis], low[axis] + size * layers as f64);
        Some(Self {
            fluid,
            normal,
            counts,
            layers: [layer, (layer + 1).min(layers - 1)],
            share: (place - layer as f64) as f32,
            origin_m,
        })
    }

    /// Edges of the grid in the plane [m].
    fn edges_m(&self) -> [DVec3; 2] {
        let [i_axis, j_axis] = self.normal.in_plane();
        let edge =
            |axis: usize, count: usize| DVec3::AXES[axis] * (self.fluid.cell_size_m * count as f64);
        [edge(i_axis, self.counts[0]), edge(j_axis, self.counts[1])]
    }

    fn cell(&self, i: usize, j: usize, layer: usize) -> usize {
        let [i_axis, j_axis] = self.normal.in_plane();
        let mut cell = [0; 3];
        cell[self.normal as usize] = layer;
        cell[i_axis] = i;
        cell[j_axis] = j;
        (cell[2] * self.fluid.cells[1] + cell[1]) * self.fluid.cells[0] + cell[0]
    }

    fn between(&self, [low, high]: [f32; 2]) -> f32 {
        low * (1.0 - self.share) + high * self.share
    }

    /// Velocity [m/s]; NaN where the frame has none.
    fn velocity(&self, i: usize, j: usize) -> [f32; 3] {
        let [low, high] = self.layers.map(|layer| {
            let known = self.fluid.velocity_m_s.get(self.cell(i, j, layer));
            known.copied().unwrap_or([f32::NAN; 3])
        });
        std::array::from_fn(|a| self.between([low[a], high[a]]))
    }

    fn pressure(&self, i: usize, j: usize) -> f32 {
        self.between(self.layers.map(|layer| {
            let known = self.fluid.pressure_pa.get(self.cell(i, j, layer));
            known.copied().unwrap_or(f32::NAN)
        }))
    }

    /// Vorticity across the plane by differences over two cells, over one at the sides [1/s].
    fn vorticity(&self, i: usize, j: usize) -> f32 {
        let [i_axis, j_axis] = self.normal.in_plane();
        let size = self.fluid.cell_size_m as f32;
        let ends = |at: usize, count: usize| [at.saturating_sub(1), (at + 1).min(count - 1)];
        let slope = |low: f32, high: f32, [from, to]: [usize; 2]| {
            if from == to {
                0.0
            } else {
                (high - low) / ((to - from) as f32 * size)
            }
        };
        let across = ends(i, self.counts[0]);
        let up = ends(j, self.counts[1]);
        let [left, right] = across.map(|i| self.velocity(i, j)[j_axis]);
        let [below, above] = up.map(|j| self.velocity(i, j)[i_axis]);
        slope(left, right, across) - slope(below, above, up)
    }

    /// A quantity on the plane; the range is left at [0, 1].
    fn slice(&self, quantity: FlowQuantity, depth: SliceDepth) -> Slice {
        let places = (0..self.counts[1]).flat_map(|j| (0..self.counts[0]).map(move |i| (i, j)));
        let value = |(i, j): (usize, usize)| match quantity {
            FlowQuantity::Speed => {
                let squares = self.velocity(i, j).map(|v| v * v);
                squares.iter().sum::<f32>().sqrt()
            }
            FlowQuantity::Vorticity => self.vorticity(i, j),
            FlowQuantity::Pressure => self.pressure(i, j),
        };
        Slice {
            origin_m: self.origin_m,
            edges_m: self.edges_m(),
            counts: self.counts,
            values: places.map(value).collect(),
            range: [0.0, 1.0],
            scale: scale(quantity),
            opacity: 1.0,
            depth,
        }
    }

    /// Velocity of the cell at a place in the plane [m/s]; `None` beyond the grid.
    fn velocity_at(&self, place_m: DVec3) -> Option<[f32; 3]> {
        let [low, _] = air_box(self.fluid);
        let cell = (place_m - low) / self.fluid.cell_size_m;
        let [i, j] = self.normal.in_plane().map(|axis| cell[axis].floor());
        let [across, up] = self.counts.map(|n| n as f64);
        let inside = (0.0..across).contains(&i) && (0.0..up).contains(&j);
        inside.then(|| self.velocity(i as usize, j as usize))
    }

    /// Makes holes of values under a finer grid, but for a rim of one cell, so that nothing shows between them. Where both end at one face there is no rim.
    fn leave_out(&self, finer: &Plane, values: &mut [f32]) {
        let size = self.fluid.cell_size_m;
        let [own, end] = air_box(self.fluid);
        let [low, high] = air_box(finer.fluid);
        let axes = self.normal.in_plane();
        let inside = |axis: usize, cell: usize| {
            let place = own[axis] + (cell as f64 + 0.5) * size;
            let rim = |between: f64| if between > 0.5 * size { size } else { 0.0 };
            let rims = [rim(low[axis] - own[axis]), rim(end[axis] - high[axis])];
            place > low[axis] + rims[0] && place < high[axis] - rims[1]
        };
        for j in (0..self.counts[1]).filter(|j| inside(axes[1], *j)) {
            for i in (0..self.counts[0]).filter(|i| inside(axes[0], *i)) {
                values[j * self.counts[0] + i] = f32::NAN;
            }
        }
    }

    /// Arrows of the velocity `of` places [m], one for every few cells.
    fn arrows(
        &self,
        reference_m_s: f64,
        zoom: f64,
        of: impl Fn(DVec3) -> [f32; 3],
    ) -> Vec<Polyline> {
        let stride = self.counts[0].max(self.counts[1]).div_ceil(ARROWS).max(1);
        let [i_axis, j_axis] = self.normal.in_plane();
        let size = self.fluid.cell_size_m;
        let mut lines = Vec::new();
        for j in (stride / 2..self.counts[1]).step_by(stride) {
            for i in (stride / 2..self.counts[0]).step_by(stride) {
                let middle = self.origin_m
                    + DVec3::AXES[i_axis] * ((i as f64 + 0.5) * size)
                    + DVec3::AXES[j_axis] * ((j as f64 + 0.5) * size);
                let velocity = of(middle);
                let [along, up] = [i_axis, j_axis].map(|a| f64::from(velocity[a]));
                let speed = along.hypot(up);
                if !(reference_m_s > 0.0 && speed > 0.05 * reference_m_s && speed.is_finite()) {
                    continue;
                }
                let length = ARROW_LENGTH * size * stride as f64 / reference_m_s;
                let arrow =
                    DVec3::AXES[i_axis] * (along * length) + DVec3::AXES[j_axis] * (up * length);
                let side =
                    DVec3::AXES[i_axis] * (-up * length) + DVec3::AXES[j_axis] * (along * length);
                let [tail, tip] = [middle - arrow * 0.5, middle + arrow * 0.5];
                let back = tip - arrow * ARROW_HEAD;
                let wing = side * (0.5 * ARROW_HEAD);
                lines.push(Polyline {
                    points_m: vec![tail, tip, back + wing, tip, back - wing],
                    style: LineStyle {
                        width_px: 0.9 * zoom,
                        colour: INK,
                        opacity: 0.55,
                    },
                });
            }
        }
        lines
    }
}

#[cfg(test)]
#[path = "flow_tests.rs"]
mod tests;
