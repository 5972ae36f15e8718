//! The air in and around a wing in the wind: pressure inside its cells, and reverse flow behind them.

use glam::DVec3;

use crate::case::scene::{Air, Scene};
use crate::case::wing::Wing;
use crate::gpu::DeviceError;
use crate::simulation::Simulation;

/// Cells of the section behind the inlet, along each axis, whose mean pressure is p∞; and how far behind the inlet it lies [cells].
const FAR_AHEAD: (usize, usize) = (8, 4);

/// Room around the section in which reverse flow is looked for, in chords: ahead, behind, below, above.
const AROUND: [f64; 4] = [0.1, 0.5, 0.2, 0.4];

/// A wing in the wind.
pub(super) struct InWind<'a> {
    pub wing: &'a Wing,
    pub air: &'a Air,
    pub designed_m: &'a [DVec3],
}

impl<'a> InWind<'a> {
    pub fn of(scene: &'a Scene) -> Option<Self> {
        let wing = scene.wing()?;
        Some(Self {
            wing,
            air: scene.air.as_ref()?,
            designed_m: &wing.tunnel.as_ref()?.designed_m,
        })
    }

    pub fn dynamic_pressure_pa(&self) -> f64 {
        let speed = self.air.wind_or_reference_m_s();
        0.5 * self.air.units.density_kg_m3 * speed * speed
    }

    /// c/U [s].
    pub fn unit_s(&self) -> f64 {
        self.wing.built.measures.largest_chord_m / self.air.wind_or_reference_m_s()
    }

    pub fn volumes_m3(&self, positions_m: &[DVec3]) -> Vec<f64> {
        let volume = |cell| self.wing.built.cell_volume_m3(cell, positions_m);
        (0..self.wing.built.cells).map(volume).collect()
    }
}

/// What is read of the air.
pub(super) struct Around {
    /// Pressure coefficient inside every cell.
    pub inside: Vec<f64>,
    /// Area in the section through the middle cell in which air outside the wing moves upstream [m²].
    pub reverse_flow_m2: f64,
}

pub(super) fn air_around(
    simulation: &Simulation,
    known: &InWind,
    positions_m: &[DVec3],
) -> Result<Around, DeviceError> {
    let wing = &known.wing.built;
    let cells = known.air.cells;
    let size_m = known.air.units.cell_size_m;
    let mut wanted: Vec<[usize; 3]> = Vec::new();
    let (count, behind) = FAR_AHEAD;
    for i in 0..count * count {
        let share = |a: usize, n: usize| (2 * a + 1) * n / (2 * count);
        let [y, z] = [share(i % count, cells[1]), share(i / count, cells[2])];
        wanted.push([behind.min(cells[0] - 1), y, z]);
    }
    // Corners around every point, with their weights.
    let points: Vec<Vec<DVec3>> = (0..wing.cells)
        .map(|cell| wing.inner_points_m(cell, positions_m))
        .collect();
    let mut weights = Vec::new();
    for point in points.iter().flatten() {
        let place = *point / size_m - 0.5;
        let below: [(usize, f64); 3] = std::array::from_fn(|a| {
            let last = (cells[a] - 2) as f64;
            let first = place[a].floor().clamp(0.0, last);
            (first as usize, (place[a] - first).clamp(0.0, 1.0))
        });
        for corner in 0..8_usize {
            let bit = |a: usize| corner >> a & 1;
            wanted.push(std::array::from_fn(|a| below[a].0 + bit(a)));
            let share = |a: usize| match bit(a) {
                0 => 1.0 - below[a].1,
                _ => below[a].1,
            };
            weights.push(share(0) * share(1) * share(2));
        }
    }
    let slice = outside_section(known, positions_m);
    wanted.extend(&slice);
    let states = simulation.air_in_cells(&wanted)?;
    let (ahead, rest) = states.split_at(count * count);
    let (inner, slice) = rest.split_at(weights.len());
    let far_pa = ahead.iter().map(|(p, _)| p).sum::<f64>() / ahead.len() as f64;
    let mut inner = inner.iter().zip(&weights);
    let inside = points
        .iter()
        .map(|points| {
            let own = inner.by_ref().take(8 * points.len());
            let sum: f64 = own.map(|((p, _), weight)| p * weight).sum();
            (sum / points.len() as f64 - far_pa) / known.dynamic_pressure_pa()
        })
        .collect();
    let reverse = slice.iter().filter(|(_, u)| u.x < 0.0).count();
    Ok(Around {
        inside,
        reverse_flow_m2: reverse as f64 * size_m * size_m,
    })
}

/// Cells of the air around the middle of the middle cell (right of the middle, if there are two), outside the wing.
fn outside_section(known: &InWind, positions_m: &[DVec3]) -> Vec<[usize; 3]> {
    let wing = &known.wing.built;
    let section = wing.middle_section_m(wing.cells / 2, positions_m);
    let size_m = known.air.units.cell_size_m;
    let chord = wing.measures.largest_chord_m;
    let (low, high) = section.iter().fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(low, high), place| (low.min(*place), high.max(*place)),
    );
    let [ahead, behind, below, above] = AROUND.map(|share| share * chord);
    let range = |from: f64, to: f64, axis: usize| {
        let end = known.air.cells[axis] - 1;
        let index = |x: f64| ((x / size_m - 0.5).round().max(0.0) as usize).min(end);
        index(from)..=index(to)
    };
    let y = *range(0.5 * (low.y + high.y), low.y, 1).start();
    let mut cells = Vec::new();
    for x in range(low.x - ahead, high.x + behind, 0) {
        for z in range(low.z - below, high.z + above, 2) {
            let middle = [x, z].map(|i| (i as f64 + 0.5) * size_m);
            if !is_inside(&section, middle) {
                cells.push([x, y, z]);
            }
        }
    }
    cells
}

/// True if a point (x, z) lies inside a closed polygon.
fn is_inside(polygon: &[DVec3], [x, z]: [f64; 2]) -> bool {
    let mut inside = false;
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if (a.z > z) != (b.z > z) && x < a.x + (b.x - a.x) * (z - a.z) / (b.z - a.z) {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_inside_or_outside() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        let square = square.map(|[x, z]| DVec3::new(x, 5.0, z));
        assert!(is_inside(&square, [1.9, 0.1]));
        for outside in [[2.1, 0.5], [-0.1, 0.5], [1.0, 1.1], [1.0, -0.1]] {
            assert!(!is_inside(&square, outside), "{outside:?}");
        }
    }
}
