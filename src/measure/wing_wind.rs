//! What is measured on a wing in the wind: columns of the history behind those of fabric, and named results.
//!
//! Coefficients refer to ½ ρ U² and the flat area. Pressure coefficients are (p − p∞)/(½ ρ U²), p∞ the mean over a section behind the inlet, p in the
//! middle of a cell between its ribs and between its panels. Times are counted in chords: c/U, c the largest chord.

use std::ops::Range;

use glam::DVec3;

use super::air_around_wing::{Around, InWind, air_around};
use super::impulses::Forces;
use super::read_out::Reduction::{Last, Mean as MeanOf};
use super::read_out::{ReadOut, columns, results};
use super::record::Record;
use super::shared::{
    DRAG_COEFFICIENT, FILL_TIME, FORCE_IMBALANCE, IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX,
    LIFT_COEFFICIENT, STRESS_MAX, TIME,
};
use super::statistics::{Mean, average, batch_mean, largest, range};
use super::wing::{self, PITCH, RISER_FORCE_LEFT, RISER_FORCE_RIGHT, ROW_LOAD, ROW_SHARE, RowLoad};
use super::wing_walls;
use crate::case::scene::Scene;
use crate::case::wing::{Pull, Wing};
use crate::frame::StructureFrame;
use crate::geometry::wing::section::Side;
use crate::gpu::DeviceError;
use crate::output::{Quantity, Results};
use crate::simulation::Simulation;

columns! {
    /// What comes before the columns of rows and cells.
    COLUMNS of Moment, in Scene: "Wings in air";
    LIFT_COEFFICIENT => |now| now.forces.markers_n.z / now.scale_n, reduced MeanOf;
    DRAG_COEFFICIENT => |now| now.forces.markers_n.x / now.scale_n, reduced MeanOf;
    IMPULSE_Z_MARKERS: "impulse_z_markers_n_s", "N s", "impulse of the air along z by markers; since release"
        => |now| now.forces.impulse.markers.z;
    IMPULSE_Z_MOMENTUM_BOX: "impulse_z_momentum_box_n_s", "N s", "the same by the momentum of a box of air"
        => |now| now.forces.impulse.momentum_box.z;
    VOLUME_RATIO: "volume_ratio", "1", "volume over that of the design"
        => |now| now.volumes_m3.iter().sum::<f64>() / now.designed_m3(), reduced MeanOf;
    VOLUME_ASYMMETRY: "volume_asymmetry", "1", "volume of the right half less that of the left, over the design"
        => |now| {
            let half = now.volumes_m3.len() / 2;
            let of_left: f64 = now.volumes_m3[..half].iter().sum();
            let of_right: f64 = now.volumes_m3[now.volumes_m3.len() - half..].iter().sum();
            (of_right - of_left) / now.designed_m3()
        }, reduced MeanOf;
    REVERSE_FLOW_AREA: "reverse_flow_area_m2", "m2", "area of reverse flow in the middle section; outside the wing"
        => |now| now.air.reverse_flow_m2, reduced MeanOf;
    STRESS_MAX => |now| largest(now.structure.stress_pa.iter().copied()), reduced Last;
    PITCH => |now| (-now.chord_m.z).atan2(now.chord_m.x).to_degrees(), reduced MeanOf;
    DEFLECTION: "trailing_edge_deflection_deg", "deg", "deflection of the trailing edge in the middle; behind the last row before it, against the design"
        => |now| now.deflection_deg, reduced MeanOf;
    RISER_FORCE_RIGHT => |now| now.risers_n[0], reduced MeanOf;
    RISER_FORCE_LEFT => |now| now.risers_n[1], reduced MeanOf;
}

columns! {
    /// Of every row of lines.
    OF_ROW of RowLoad, in Scene: "Wings in air: every row of lines";
    ROW_LOAD => |row| row.load_n, reduced MeanOf;
}

columns! {
    /// Of every riser that is pulled.
    OF_PULL of f64, in Scene: "Wings in air: every row that is pulled";
    ROW_PULL: "row_{row}_pull_m", "m", "how far the row's risers are pulled" => |pull_m| *pull_m;
}

columns! {
    /// Of every cell, from the left tip, from 1.
    PRESSURE_OF_CELL of f64, in Scene: "Wings in air: pressure in every cell";
    CELL_PRESSURE: "internal_pressure_coefficient_cell_{cell}", "1", "pressure coefficient inside the cells; cells count from the left tip"
        => |pressure| *pressure, reduced MeanOf;
}

columns! {
    /// The same.
    VOLUME_OF_CELL of f64, in Scene: "Wings in air: volume of every cell";
    CELL_VOLUME: "volume_ratio_cell_{cell}", "1", "volume of the cells over their design; cells count from the left tip" => |ratio| *ratio;
}

results! {
    /// What follows from them.
    RESULTS: "Wings in air";
    LIFT_TO_DRAG: "lift_to_drag_ratio", "1", "lift over drag; fabric alone, without the drag of lines";
    PRESSURE_MEAN: "internal_pressure_coefficient_mean", "1", "mean pressure coefficient inside the cells; of all cells, each counted once";
    PRESSURE_SPREAD: "internal_pressure_coefficient_spread", "1", "spread of the pressure coefficient inside the cells; largest less smallest mean of a cell";
    VOLUME_RATIO_MIN: "volume_ratio_min", "1", "smallest volume over that of the design; once filled, or of the whole run";
    REFILL_TIME: "refill_time_s", "s", "time until the wing is full again once risers are let go";
    VOLUME_ASYMMETRY_MAX: "volume_asymmetry_max", "1", "largest asymmetry of the volume; right less left half over the design, of all samples";
}

/// Means begin so many c/U after the release, or after the last riser was hauled in.
const SETTLING: f64 = 5.0;

/// Length of a batch of the means' uncertainty [c/U].
const BATCH: f64 = 1.5;

/// Volume over that of the design at which a wing counts as filled.
const FILLED: f64 = 0.95;

/// A wing at a sample.
pub(super) struct Moment {
    forces: Forces,
    /// Dynamic pressure times flat area [N].
    scale_n: f64,
    structure: StructureFrame,
    /// Of every cell [m³].
    volumes_m3: Vec<f64>,
    designed_volumes_m3: Vec<f64>,
    chord_m: DVec3,
    deflection_deg: f64,
    /// Forces of the risers of the right and the left half [N].
    risers_n: [f64; 2],
    air: Around,
}

impl Moment {
    fn designed_m3(&self) -> f64 {
        self.designed_volumes_m3.iter().sum()
    }
}

/// The columns of a scene.
pub(super) fn columns(scene: &Scene) -> Vec<ReadOut> {
    let Some(known) = InWind::of(scene) else {
        return Vec::new();
    };
    let rows = &known.wing.built.row_names;
    let mut columns: Vec<ReadOut> = COLUMNS.read_outs(scene);
    columns.extend(rows.iter().flat_map(|row| OF_ROW.read_outs_of(scene, row)));
    let pulls = known.wing.pulls.iter();
    columns.extend(pulls.flat_map(|pull| OF_PULL.read_outs_of(scene, &rows[pull.row])));
    for table in [&PRESSURE_OF_CELL, &VOLUME_OF_CELL] {
        let cells = 1..=known.wing.built.cells;
        columns.extend(cells.flat_map(|cell| table.read_outs_of(scene, &cell.to_string())));
    }
    columns
}

/// The same columns now.
pub(super) fn values(simulation: &Simulation, forces: Forces) -> Result<Vec<f64>, DeviceError> {
    let scene = simulation.scene();
    let Some(known) = InWind::of(scene) else {
        return Ok(Vec::new());
    };
    let Some(structure) = simulation.structure_frame().structure else {
        return Ok(Vec::new());
    };
    let wing = &known.wing.built;
    let positions_m = &structure.positions_m;
    let [nose, tail] = wing.middle_chord_m(positions_m);
    let rows = wing::row_loads(known.wing, &structure);
    let now = Moment {
        forces,
        scale_n: known.dynamic_pressure_pa() * wing.measures.flat_area_m2,
        volumes_m3: known.volumes_m3(positions_m),
        designed_volumes_m3: known.volumes_m3(known.designed_m),
        chord_m: tail - nose,
        deflection_deg: deflection_deg(&known, positions_m)
            - deflection_deg(&known, known.designed_m),
        risers_n: wing
            .hang_points
            .map(|n| structure.reactions_n[n as usize].length()),
        air: air_around(simulation, &known, positions_m)?,
        structure,
    };
    let mut row: Vec<f64> = COLUMNS.values(scene, Some(&now));
    row.extend(rows.iter().flat_map(|own| OF_ROW.values(scene, Some(own))));
    let time_s = simulation.time_s();
    for pull in &known.wing.pulls {
        row.extend(OF_PULL.values(scene, Some(&pull.at(time_s))));
    }
    for pressure in &now.air.inside {
        row.extend(PRESSURE_OF_CELL.values(scene, Some(pressure)));
    }
    for (volume, designed) in now.volumes_m3.iter().zip(&now.designed_volumes_m3) {
        row.extend(VOLUME_OF_CELL.values(scene, Some(&(volume / designed))));
    }
    Ok(row)
}

/// How far the part of the middle rib, or in the mean of both beside the middle, behind the last row before the trailing edge points down against the part before it [°].
fn deflection_deg(known: &InWind, positions_m: &[DVec3]) -> f64 {
    let wing = &known.wing.built;
    let [nose, tail] = wing.middle_chord_m(positions_m);
    let at = |side, x| {
        let j = wing.places.nearest(side, x);
        let [left, right] = wing.middle_outlines().map(|outline| {
            let count = outline.len();
            let k = match side {
                Side::Upper => j,
                Side::Lower => (count - j) % count,
            };
            positions_m[outline[k] as usize]
        });
        left.midpoint(right)
    };
    let x = wing.turning_place;
    let turn = at(Side::Upper, x).midpoint(at(Side::Lower, x));
    let angle = |from: DVec3, to: DVec3| (from.z - to.z).atan2(to.x - from.x).to_degrees();
    angle(turn, tail) - angle(nose, turn)
}

/// The part of the record over which means are taken.
struct Window {
    first: usize,
    batch: usize,
    note: String,
}

fn window(record: &Record, known: &InWind) -> Option<Window> {
    let times = record.column(&TIME);
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

/// Samples over which the means of a wing in wind are taken; `None` of other scenes.
pub(super) fn averaged(scene: &Scene, record: &Record) -> Option<Range<usize>> {
    let window = window(record, &InWind::of(scene)?)?;
    Some(window.first..record.column(&TIME).len())
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
        let missing = Quantity::missing("the run ended before two samples after the release");
        results.insert(&LIFT_COEFFICIENT, missing);
        return;
    };
    let mean = |column: &ReadOut| {
        let column = record.column(column);
        batch_mean(&column[window.first.min(column.len())..], window.batch)
    };
    let quantity = |mean: Mean| {
        let told = Quantity::new(mean.value).with_note(&window.note);
        match mean.confidence {
            Some(confidence) => told.with_confidence(confidence),
            None => told,
        }
    };
    for column in COLUMNS.reduced(scene, MeanOf) {
        results.insert(column, quantity(mean(column)));
    }
    let (lift, drag) = (mean(&LIFT_COEFFICIENT), mean(&DRAG_COEFFICIENT));
    results.insert(
        &LIFT_TO_DRAG,
        if drag.value == 0.0 {
            Quantity::missing("there is no drag")
        } else {
            Quantity::told(&LIFT_TO_DRAG, lift.value / drag.value)
        },
    );
    wing_walls::results(results, (scene, &known), [lift, drag], &quantity);
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
    mean: &dyn Fn(&ReadOut) -> Mean,
    quantity: &dyn Fn(Mean) -> Quantity,
) {
    let rows = &known.wing.built.row_names;
    let loads: Vec<Mean> = rows.iter().map(|row| mean(&ROW_LOAD.of(row))).collect();
    let sum: f64 = loads.iter().map(|load| load.value).sum();
    for (load, row) in loads.into_iter().zip(rows) {
        let share = if sum > 0.0 { load.value / sum } else { 0.0 };
        results.insert(&ROW_LOAD.of(row), quantity(load));
        results.insert(&ROW_SHARE.of(row), Quantity::new(share));
    }
}

fn inside(
    results: &mut Results,
    known: &InWind,
    mean: &dyn Fn(&ReadOut) -> Mean,
    quantity: &dyn Fn(Mean) -> Quantity,
) {
    let columns = (1..=known.wing.built.cells).map(|cell| CELL_PRESSURE.of(cell));
    let cells: Vec<(ReadOut, Mean)> = columns
        .map(|column| {
            let mean = mean(&column);
            (column, mean)
        })
        .collect();
    let values: Vec<f64> = cells.iter().map(|(_, mean)| mean.value).collect();
    for (read_out, value) in [
        (&PRESSURE_MEAN, average(&values)),
        (&PRESSURE_SPREAD, range(&values)),
    ] {
        let quantity = Quantity::told(read_out, value);
        results.insert(read_out, quantity);
    }
    for (column, mean) in cells {
        results.insert(&column, quantity(mean));
    }
}

/// Time of filling, least volume after it, and time of filling again once risers are let go.
fn filling(results: &mut Results, record: &Record, known: &InWind) {
    let times = record.column(&TIME);
    let ratios = record.column(&VOLUME_RATIO);
    let unit_s = known.unit_s();
    let reached = |from_s: f64| {
        let from = times.partition_point(|&t| t < from_s);
        (from..times.len()).find(|&i| ratios[i] >= FILLED)
    };
    let time = |from_s: f64| match reached(from_s) {
        Some(i) => Quantity::new(times[i] - from_s).with_note(&format!(
            "volume at {FILLED} of the design; {:.2} c/U",
            (times[i] - from_s) / unit_s
        )),
        None => Quantity::missing(&format!("the volume did not reach {FILLED} of the design")),
    };
    results.insert(&FILL_TIME, time(0.0));
    let filled = reached(0.0).unwrap_or(0);
    let least = ratios[filled..]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    results.insert(
        &VOLUME_RATIO_MIN,
        Quantity::new(least).with_note("once filled, or of the whole run"),
    );
    let let_go = known.wing.pulls.iter().filter(|pull| pull.lets_go());
    if let Some(end_s) = let_go.map(Pull::end_s).reduce(f64::max) {
        results.insert(&REFILL_TIME, time(end_s));
        let asymmetry = record.column(&VOLUME_ASYMMETRY);
        let most = largest(asymmetry.iter().map(|a| a.abs()));
        results.tell(&VOLUME_ASYMMETRY_MAX, most);
    }
}

/// Difference of the forces by markers and momentum box, over the window.
fn imbalance(results: &mut Results, record: &Record, first: usize) {
    let routes = |column: &ReadOut| {
        let impulse = record.column(column);
        impulse.last().copied().unwrap_or(f64::NAN) - impulse[first.saturating_sub(1)]
    };
    let markers = DVec3::new(routes(&IMPULSE_MARKERS), 0.0, routes(&IMPULSE_Z_MARKERS));
    let momentum_box = DVec3::new(
        routes(&IMPULSE_MOMENTUM_BOX),
        0.0,
        routes(&IMPULSE_Z_MOMENTUM_BOX),
    );
    let ratio = (markers - momentum_box).length() / markers.length();
    results.insert(
        &FORCE_IMBALANCE,
        if ratio.is_finite() {
            Quantity::new(ratio).with_note(
                "markers against momentum box, along and across the wind, over the force",
            )
        } else {
            Quantity::missing("the fabric left the momentum box, or there is no force")
        },
    );
}

fn place_of_largest(results: &mut Results, known: &Wing, structure: &StructureFrame) {
    let stresses = structure.stress_pa.iter().zip(&known.built.tags);
    let most = stresses.max_by(|a, b| a.0.total_cmp(b.0));
    let Some((stress, tag)) = most else { return };
    results.insert(
        &STRESS_MAX,
        Quantity::new(*stress).with_note(&format!("at the end: {}", wing::place(known, tag))),
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

/// Columns of the history of every cell that have a chart together.
#[must_use]
pub fn cell_columns(scene: &Scene) -> [Vec<ReadOut>; 2] {
    let cells = InWind::of(scene).map_or(0, |known| known.wing.built.cells);
    [&CELL_PRESSURE, &CELL_VOLUME].map(|column| (1..=cells).map(|cell| column.of(cell)).collect())
}
