//! What is measured on a wing in the wind: columns of the history behind those of fabric, and named results.
//!
//! Coefficients refer to ½ ρ U² and the flat area. Pressure coefficients are (p − p∞)/(½ ρ U²), p∞ the mean over a section behind the inlet, p in the
//! middle of a cell between its ribs and between its panels. Times are counted in chords: c/U, c the largest chord.

use glam::DVec3;

use super::record::largest;
use super::statistics::{Mean, batch_mean};
use super::{Record, wing};
use crate::case::scene::{Air, Scene};
use crate::case::wing::{Pull, Wing};
use crate::frame::StructureFrame;
use crate::geometry::wing::section::Side;
use crate::gpu::DeviceError;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

/// What comes before the columns of rows and cells.
const COLUMNS: [&str; 12] = [
    "lift_coefficient",
    "drag_coefficient",
    "impulse_z_markers_n_s",
    "impulse_z_momentum_box_n_s",
    "volume_ratio",
    "volume_asymmetry",
    "reverse_flow_area_m2",
    "stress_max_pa",
    "pitch_deg",
    "trailing_edge_deflection_deg",
    "riser_force_right_n",
    "riser_force_left_n",
];

/// Means begin so many c/U after the release, or after the last riser was hauled in.
const SETTLING: f64 = 5.0;

/// Length of a batch of the means' uncertainty [c/U].
const BATCH: f64 = 1.5;

/// Volume over that of the design at which a wing counts as filled.
const FILLED: f64 = 0.95;

/// Cells of the section behind the inlet, along each axis, whose mean pressure is p∞; and how far behind the inlet it lies [cells].
const FAR_AHEAD: (usize, usize) = (8, 4);

/// Room around the section in which reverse flow is looked for, in chords: ahead, behind, below, above.
const AROUND: [f64; 4] = [0.1, 0.5, 0.2, 0.4];

/// A wing in the wind.
struct InWind<'a> {
    wing: &'a Wing,
    air: &'a Air,
    designed_m: &'a [DVec3],
}

impl<'a> InWind<'a> {
    fn of(scene: &'a Scene) -> Option<Self> {
        let wing = scene.wing()?;
        Some(Self {
            wing,
            air: scene.air.as_ref()?,
            designed_m: &wing.tunnel.as_ref()?.designed_m,
        })
    }

    fn dynamic_pressure_pa(&self) -> f64 {
        let speed = self.air.wind_or_reference_m_s();
        0.5 * self.air.units.density_kg_m3 * speed * speed
    }

    /// c/U [s].
    fn unit_s(&self) -> f64 {
        self.wing.built.measures.largest_chord_m / self.air.wind_or_reference_m_s()
    }

    fn volumes_m3(&self, positions_m: &[DVec3]) -> Vec<f64> {
        let volume = |cell| self.wing.built.cell_volume_m3(cell, positions_m);
        (0..self.wing.built.cells).map(volume).collect()
    }
}

fn of_cell(name: &str, cell: usize) -> String {
    format!("{name}_cell_{}", cell + 1)
}

/// Names of the columns; cells count from the left tip, from 1.
pub(super) fn columns(scene: &Scene) -> Vec<String> {
    let Some(known) = InWind::of(scene) else {
        return Vec::new();
    };
    let mut columns: Vec<String> = COLUMNS.map(str::to_owned).to_vec();
    for row in &known.wing.built.row_names {
        columns.push(format!("row_{row}_load_n"));
    }
    for pull in &known.wing.pulls {
        let row = &known.wing.built.row_names[pull.row];
        columns.push(format!("row_{row}_pull_m"));
    }
    for name in ["internal_pressure_coefficient", "volume_ratio"] {
        columns.extend((0..known.wing.built.cells).map(|cell| of_cell(name, cell)));
    }
    columns
}

/// The same columns now; `force_n` is the mean force of the air since the last sample, `impulses_z` those of markers and momentum box [N s].
pub(super) fn values(
    simulation: &Simulation,
    force_n: DVec3,
    impulses_z: [f64; 2],
) -> Result<Vec<f64>, DeviceError> {
    let Some(known) = InWind::of(simulation.scene()) else {
        return Ok(Vec::new());
    };
    let Some(structure) = simulation.structure_frame().structure else {
        return Ok(Vec::new());
    };
    let wing = &known.wing.built;
    let positions_m = &structure.positions_m;
    let scale = known.dynamic_pressure_pa() * wing.measures.flat_area_m2;
    let (volumes, designed) = (
        known.volumes_m3(positions_m),
        known.volumes_m3(known.designed_m),
    );
    let whole: f64 = designed.iter().sum();
    let half = wing.cells / 2;
    let of_left: f64 = volumes[..half].iter().sum();
    let of_right: f64 = volumes[wing.cells - half..].iter().sum();
    let [nose, tail] = wing.middle_chord.map(|n| positions_m[n as usize]);
    let chord = tail - nose;
    let air = air_around(simulation, &known, positions_m)?;
    let risers = wing
        .hang_points
        .map(|n| structure.reactions_n[n as usize].length());
    let mut row = vec![
        force_n.z / scale,
        force_n.x / scale,
        impulses_z[0],
        impulses_z[1],
        volumes.iter().sum::<f64>() / whole,
        (of_right - of_left) / whole,
        air.reverse_flow_m2,
        largest(structure.stress_pa.iter().copied()),
        (-chord.z).atan2(chord.x).to_degrees(),
        deflection_deg(&known, positions_m) - deflection_deg(&known, known.designed_m),
        risers[0],
        risers[1],
    ];
    row.extend(
        wing::row_loads(known.wing, &structure)
            .iter()
            .map(|row| row.load_n),
    );
    let time_s = simulation.time_s();
    row.extend(known.wing.pulls.iter().map(|pull| pull.at(time_s)));
    row.extend(air.inside);
    row.extend(volumes.iter().zip(&designed).map(|(now, then)| now / then));
    Ok(row)
}

/// How far the part of the middle rib behind the last row before the trailing edge points down against the part before it [°].
fn deflection_deg(known: &InWind, positions_m: &[DVec3]) -> f64 {
    let wing = &known.wing.built;
    let [nose, tail] = wing.middle_chord.map(|n| positions_m[n as usize]);
    let outline = &wing.outlines[wing.cells.div_ceil(2)];
    let at = |side, x| {
        let j = wing.places.nearest(side, x);
        let count = outline.len();
        let k = match side {
            Side::Upper => j,
            Side::Lower => (count - j) % count,
        };
        positions_m[outline[k] as usize]
    };
    let x = wing.turning_place;
    let turn = at(Side::Upper, x).midpoint(at(Side::Lower, x));
    let angle = |from: DVec3, to: DVec3| (from.z - to.z).atan2(to.x - from.x).to_degrees();
    angle(turn, tail) - angle(nose, turn)
}

/// What is read of the air.
struct Around {
    /// Pressure coefficient inside every cell.
    inside: Vec<f64>,
    /// Area in the section through the middle cell in which air outside the wing moves upstream [m²].
    reverse_flow_m2: f64,
}

fn air_around(
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

/// The part of the record over which means are taken.
struct Window {
    first: usize,
    batch: usize,
    note: String,
}

fn window(record: &Record, known: &InWind) -> Option<Window> {
    let times = record.column("time_s");
    let unit_s = known.unit_s();
    let pulls = known.wing.pulls.iter();
    let steady_s = pulls.map(Pull::end_s).fold(0.0, f64::max);
    let released = times.iter().position(|&t| t > 0.0)?;
    let last = times.len() - 1;
    let from_s = steady_s + SETTLING * unit_s;
    let settled = times.partition_point(|&t| t < from_s);
    let (first, settled) = match settled + 1 < last {
        true => (settled, true),
        false => (released.midpoint(last), false),
    };
    let interval_s = (times[last] - times[first]) / (last - first).max(1) as f64;
    let length = (times[last] - times[first]) / unit_s;
    Some(Window {
        first,
        batch: (BATCH * unit_s / interval_s).round().max(1.0) as usize,
        note: if settled {
            format!("mean of the last {length:.1} c/U")
        } else {
            format!("mean of the last {length:.1} c/U, not settled: indicative only")
        },
    })
}

/// Means over the settled window, filling, and the state at the end.
pub(super) fn results(
    results: &mut Results,
    record: &Record,
    scene: &Scene,
    structure: Option<&StructureFrame>,
) {
    let Some(known) = InWind::of(scene) else {
        return;
    };
    let Some(window) = window(record, &known) else {
        results.insert(
            "lift_coefficient",
            Quantity::missing("1", "the run ended before release"),
        );
        return;
    };
    let mean = |name: &str| {
        let column = record.column(name);
        batch_mean(&column[window.first.min(column.len())..], window.batch)
    };
    let quantity = |mean: Mean, unit: &str| {
        let quantity = Quantity::new(mean.value, unit).with_note(&window.note);
        match mean.confidence {
            Some(confidence) => quantity.with_confidence(confidence),
            None => quantity,
        }
    };
    let (lift, drag) = (mean("lift_coefficient"), mean("drag_coefficient"));
    results.insert("lift_coefficient", quantity(lift, "1"));
    results.insert("drag_coefficient", quantity(drag, "1"));
    results.insert(
        "lift_to_drag_ratio",
        if drag.value == 0.0 {
            Quantity::missing("1", "there is no drag")
        } else {
            Quantity::new(lift.value / drag.value, "1")
                .with_note("fabric alone: lines have no drag in the wind")
        },
    );
    for (name, unit) in [
        ("volume_ratio", "1"),
        ("volume_asymmetry", "1"),
        ("reverse_flow_area_m2", "m2"),
        ("pitch_deg", "deg"),
        ("trailing_edge_deflection_deg", "deg"),
        ("riser_force_right_n", "N"),
        ("riser_force_left_n", "N"),
    ] {
        results.insert(name, quantity(mean(name), unit));
    }
    rows(results, &known, &mean, &quantity);
    inside(results, &known, &mean, &quantity);
    filling(results, record, &known);
    imbalance(results, record, window.first);
    if let Some(structure) = structure {
        wing::stresses(results, known.wing, structure);
        wing::margins(results, known.wing, structure);
        place_of_largest(results, known.wing, structure);
    }
}

fn rows(
    results: &mut Results,
    known: &InWind,
    mean: &dyn Fn(&str) -> Mean,
    quantity: &dyn Fn(Mean, &str) -> Quantity,
) {
    let names: Vec<String> = (known.wing.built.row_names.iter())
        .map(|row| format!("row_{row}_load_n"))
        .collect();
    let loads: Vec<Mean> = names.iter().map(|name| mean(name)).collect();
    let sum: f64 = loads.iter().map(|load| load.value).sum();
    for ((name, load), row) in names.iter().zip(loads).zip(&known.wing.built.row_names) {
        let share = if sum > 0.0 { load.value / sum } else { 0.0 };
        results.insert(name, quantity(load, "N"));
        results.insert(&format!("row_{row}_load_share"), Quantity::new(share, "1"));
    }
}

fn inside(
    results: &mut Results,
    known: &InWind,
    mean: &dyn Fn(&str) -> Mean,
    quantity: &dyn Fn(Mean, &str) -> Quantity,
) {
    let name = "internal_pressure_coefficient";
    let cells: Vec<Mean> = (0..known.wing.built.cells)
        .map(|cell| mean(&of_cell(name, cell)))
        .collect();
    let values = || cells.iter().map(|cell| cell.value);
    let most = values().fold(f64::NEG_INFINITY, f64::max);
    let least = values().fold(f64::INFINITY, f64::min);
    results.insert(
        "internal_pressure_coefficient_mean",
        Quantity::new(values().sum::<f64>() / cells.len() as f64, "1")
            .with_note("of all cells, each counted once"),
    );
    results.insert(
        "internal_pressure_coefficient_spread",
        Quantity::new(most - least, "1").with_note("largest less smallest mean of a cell"),
    );
    for (cell, mean) in cells.into_iter().enumerate() {
        results.insert(&of_cell(name, cell), quantity(mean, "1"));
    }
}

/// Time of filling, least volume after it, and time of filling again once risers are let go.
fn filling(results: &mut Results, record: &Record, known: &InWind) {
    let times = record.column("time_s");
    let ratios = record.column("volume_ratio");
    let unit_s = known.unit_s();
    let reached = |from_s: f64| {
        let from = times.partition_point(|&t| t < from_s);
        (from..times.len()).find(|&i| ratios[i] >= FILLED)
    };
    let time = |from_s: f64| match reached(from_s) {
        Some(i) => Quantity::new(times[i] - from_s, "s").with_note(&format!(
            "volume at {FILLED} of the design; {:.2} c/U",
            (times[i] - from_s) / unit_s
        )),
        None => Quantity::missing(
            "s",
            &format!("the volume did not reach {FILLED} of the design"),
        ),
    };
    results.insert("fill_time_s", time(0.0));
    let filled = reached(0.0).unwrap_or(0);
    let least = ratios[filled..]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    results.insert(
        "volume_ratio_min",
        Quantity::new(least, "1").with_note("once filled, or of the whole run"),
    );
    let let_go = known.wing.pulls.iter().filter(|pull| pull.lets_go());
    if let Some(end_s) = let_go.map(Pull::end_s).reduce(f64::max) {
        results.insert("refill_time_s", time(end_s));
        let asymmetry = record.column("volume_asymmetry");
        let most = largest(asymmetry.iter().map(|a| a.abs()));
        results.insert(
            "volume_asymmetry_max",
            Quantity::new(most, "1")
                .with_note("right less left half over the design, of all samples"),
        );
    }
}

/// Difference of the forces by markers and momentum box, over the window.
fn imbalance(results: &mut Results, record: &Record, first: usize) {
    let routes = |name: &str| {
        let impulse = record.column(name);
        impulse.last().copied().unwrap_or(f64::NAN) - impulse[first.saturating_sub(1)]
    };
    let markers = DVec3::new(
        routes("impulse_markers_n_s"),
        0.0,
        routes("impulse_z_markers_n_s"),
    );
    let momentum_box = DVec3::new(
        routes("impulse_momentum_box_n_s"),
        0.0,
        routes("impulse_z_momentum_box_n_s"),
    );
    let ratio = (markers - momentum_box).length() / markers.length();
    results.insert(
        "force_imbalance",
        if ratio.is_finite() {
            Quantity::new(ratio, "1").with_note(
                "markers against momentum box, along and across the wind, over the force",
            )
        } else {
            Quantity::missing(
                "1",
                "the fabric left the momentum box, or there is no force",
            )
        },
    );
}

fn place_of_largest(results: &mut Results, known: &Wing, structure: &StructureFrame) {
    let stresses = structure.stress_pa.iter().zip(&known.built.tags);
    let most = stresses.max_by(|a, b| a.0.total_cmp(b.0));
    let Some((stress, tag)) = most else { return };
    results.insert(
        "stress_max_pa",
        Quantity::new(*stress, "Pa").with_note(&format!("at the end: {}", wing::place(known, tag))),
    );
}

/// Lower panels along the span at this place of the chord.
const LOWER_LINE: f64 = 0.3;

/// Columns and rows of the lower side's line along the span, as designed and at the end; `None` but for wings in the wind.
#[must_use]
pub fn lower_surface_line(scene: &Scene, structure: &StructureFrame) -> Option<Vec<Vec<f64>>> {
    let known = InWind::of(scene)?;
    let line = known.wing.built.span_line(Side::Lower, LOWER_LINE);
    let row = |(span, node): (f64, u32)| {
        let [from, to] = [
            known.designed_m[node as usize],
            structure.positions_m[node as usize],
        ];
        vec![span, from.y, from.z, to.y, to.z]
    };
    Some(line.into_iter().map(row).collect())
}

/// Names of those columns.
pub const LOWER_SURFACE_COLUMNS: [&str; 5] = [
    "span_m",
    "designed_y_m",
    "designed_z_m",
    "flown_y_m",
    "flown_z_m",
];

/// Columns of the history per cell, by what a chart of them shows.
#[must_use]
pub fn cell_columns(scene: &Scene, name: &str) -> Vec<String> {
    let cells = InWind::of(scene).map_or(0, |known| known.wing.built.cells);
    (0..cells).map(|cell| of_cell(name, cell)).collect()
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
