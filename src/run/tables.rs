//! Tables that a run leaves at its end, beside its history.

use std::path::Path;

use super::RunError;
use crate::case::Scene;
use crate::measure::{self, Record};
use crate::output::{Chart, Series, Summary, write_comparison, write_table};

/// Files that hold them.
pub(super) const NAMES: [&str; 4] = [
    "gores.csv",
    "skirt_spectrum.csv",
    "comparison.csv",
    "comparison.md",
];

/// Writes those that the scene has.
pub(super) fn write(
    folder: &Path,
    scene: &Scene,
    record: &Record,
    summary: &Summary,
) -> Result<(), RunError> {
    if let Some((columns, rows)) = record.details() {
        write_table(&folder.join("gores.csv"), &columns, &rows)?;
    }
    if let Some(rows) = measure::skirt_spectrum(scene, record) {
        let columns = ["frequency_hz", "power_density_m2_s"];
        write_table(&folder.join("skirt_spectrum.csv"), &columns, &rows)?;
    }
    if scene.output.history_plots {
        charts(folder, scene, record)?;
    }
    if !summary.comparison.is_empty() {
        write_comparison(folder, &summary.comparison)?;
    }
    Ok(())
}

/// Columns of the history with a chart each, where the history has them, and what their axis says.
pub(super) const CHARTS: [(&str, &str); 8] = [
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
