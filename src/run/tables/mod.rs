//! Tables that a run leaves at its end, beside its history.

pub(super) mod load_test;
pub(super) mod panel_shaping;
pub(super) mod trim;

use super::RunError;
use super::run_folder::RunFolder;
use crate::case::Scene;
use crate::frame::StructureFrame;
use crate::measure::shared::TIME;
use crate::measure::{self, CHARTS, Record};
use crate::output::{Chart, ReadOut, Series, Summary, write_comparison, write_table};

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
    folder: &RunFolder<'_>,
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
        write_comparison(folder.path(), &summary.comparison)?;
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
    folder: &RunFolder<'_>,
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
            colour: None,
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
    .write(&folder.join(line), folder.provenance())?;
    for (chart, columns) in [pressure, volume]
        .into_iter()
        .zip(measure::cell_columns(scene))
    {
        let series = columns.iter().enumerate();
        let series =
            series.map(|(cell, column)| series_of(record, column, format!("cell {}", cell + 1)));
        let label = columns.first().map_or_else(String::new, ReadOut::label);
        over_time(scene, label, series.collect())
            .write(&folder.join(chart), folder.provenance())?;
    }
    Ok(())
}

/// A column over time.
fn series_of(record: &Record, column: &ReadOut, name: String) -> Series {
    let times = record.column(&TIME).into_iter();
    let points = times.zip(record.column(column));
    Series {
        name,
        points: points.map(|(time, value)| [time, value]).collect(),
        bars: Vec::new(),
        markers: false,
        colour: None,
    }
}

/// A chart of columns over time.
fn over_time(scene: &Scene, label: String, series: Vec<Series>) -> Chart {
    Chart {
        title: scene.title.clone(),
        labels: [TIME.label(), label],
        categories: Vec::new(),
        series,
    }
}

fn charts(folder: &RunFolder<'_>, scene: &Scene, record: &Record) -> Result<(), RunError> {
    for name in CHARTS.map(|column| &*column.name) {
        if let Some(column) = record.named(name) {
            let series = vec![series_of(record, column, String::new())];
            let chart = over_time(scene, column.label(), series);
            chart.write(&folder.join(format!("history_{name}")), folder.provenance())?;
        }
    }
    Ok(())
}
