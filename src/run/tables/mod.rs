//! Tables that a run leaves at its end, beside its history.

pub(super) mod load_test;
pub(super) mod panel_shaping;
pub(super) mod trim;

use std::path::Path;

use super::RunError;
use crate::case::Scene;
use crate::frame::StructureFrame;
use crate::measure::{self, Record};
use crate::output::{Chart, Series, Summary, write_comparison, write_table};

/// Files that hold them.
pub(super) const NAMES: [&str; 5] = [
    "lower_surface_line.csv",
    "gores.csv",
    "skirt_spectrum.csv",
    "comparison.csv",
    "comparison.md",
];

/// Writes those that the scene has.
pub(super) fn write(
    folder: &Path,
    scene: &Scene,
    (record, structure): (&Record, Option<&StructureFrame>),
    summary: &Summary,
) -> Result<(), RunError> {
    if let Some((columns, rows)) = record.details() {
        write_table(&folder.join("gores.csv"), &columns, rows)?;
    }
    if let Some(rows) = measure::skirt_spectrum(scene, record) {
        let columns = ["frequency_hz", "power_density_m2_s"];
        write_table(&folder.join("skirt_spectrum.csv"), &columns, &rows)?;
    }
    if scene.output.history_plots {
        charts(folder, scene, record)?;
    }
    if let Some(structure) = structure {
        wing_tables(folder, scene, record, structure)?;
    }
    if !summary.comparison.is_empty() {
        write_comparison(folder, &summary.comparison)?;
    }
    Ok(())
}

/// Charts of a wing in the wind.
pub(super) const WING_CHARTS: [&str; 3] = [
    "lower_surface_line",
    "history_internal_pressure_coefficient",
    "history_cell_volume_ratio",
];

/// The lower side along the span, and what every cell did.
fn wing_tables(
    folder: &Path,
    scene: &Scene,
    record: &Record,
    structure: &StructureFrame,
) -> Result<(), RunError> {
    let Some(rows) = measure::lower_surface_line(scene, structure) else {
        return Ok(());
    };
    let [line, pressure, volume] = WING_CHARTS;
    let path = folder.join(format!("{line}.csv"));
    write_table(&path, &measure::LOWER_SURFACE_COLUMNS, &rows)?;
    // The wing as a whole may have swung: heights count from their mean.
    let curve = |name: &str, y: usize, z: usize| {
        let mean = rows.iter().map(|row| row[z]).sum::<f64>() / rows.len() as f64;
        Series {
            name: name.to_owned(),
            points: rows.iter().map(|row| [row[y], row[z] - mean]).collect(),
            bars: Vec::new(),
            markers: false,
        }
    };
    Chart {
        title: scene.title.clone(),
        labels: [
            "across the wind [m]".to_owned(),
            "lower side at 30 % chord, height from its mean [m]".to_owned(),
        ],
        categories: Vec::new(),
        series: vec![curve("as designed", 1, 2), curve("at the end", 3, 4)],
    }
    .write(&folder.join(line))?;
    let times = record.column("time_s");
    for (chart, column, label) in [
        (
            pressure,
            "internal_pressure_coefficient",
            "pressure coefficient inside the cells",
        ),
        (
            volume,
            "volume_ratio",
            "volume of the cells over their design",
        ),
    ] {
        let names = measure::cell_columns(scene, column);
        let series = names.iter().enumerate().map(|(cell, name)| Series {
            name: format!("cell {}", cell + 1),
            points: (times.iter().zip(record.column(name)))
                .map(|(time, value)| [*time, value])
                .collect(),
            bars: Vec::new(),
            markers: false,
        });
        Chart {
            title: scene.title.clone(),
            labels: ["time since release [s]".to_owned(), label.to_owned()],
            categories: Vec::new(),
            series: series.collect(),
        }
        .write(&folder.join(chart))?;
    }
    Ok(())
}

/// Columns of the history with a chart each, where the history has them, and what their axis says.
pub(super) const CHARTS: [(&str, &str); 11] = [
    ("lift_coefficient", "lift coefficient"),
    ("volume_ratio", "volume over that of the design"),
    (
        "reverse_flow_area_m2",
        "area of reverse flow in the middle section [m2]",
    ),
    ("drag_coefficient", "drag coefficient"),
    ("force_x_n", "force along the wind [N]"),
    ("drag_n", "drag [N]"),
    (
        "projected_diameter_ratio",
        "projected over nominal diameter",
    ),
    ("line_tension_max_n", "largest line tension [N]"),
    ("descent_speed_m_s", "speed of descent [m/s]"),
    ("load_factor_g", "load factor [g]"),
    ("slot_width_m", "mean width of slots [m]"),
];

fn charts(folder: &Path, scene: &Scene, record: &Record) -> Result<(), RunError> {
    let times = record.column("time_s");
    for (column, label) in CHARTS {
        let points = times.iter().zip(record.column(column));
        let series = Series {
            name: String::new(),
            points: points.map(|(time, value)| [*time, value]).collect(),
            bars: Vec::new(),
            markers: false,
        };
        let chart = Chart {
            title: scene.title.clone(),
            labels: ["time since release [s]".to_owned(), label.to_owned()],
            categories: Vec::new(),
            series: vec![series],
        };
        chart.write(&folder.join(format!("history_{column}")))?;
    }
    Ok(())
}
