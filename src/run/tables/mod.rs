//! Tables that a run leaves at its end, beside its history.

pub(super) mod load_test;
pub(super) mod panel_shaping;
pub(super) mod trim;

use super::RunError;
use super::run_folder::RunFolder;
use crate::case::Scene;
use crate::frame::StructureFrame;
use crate::measure::flow_past_bodies::prefix;
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

/// A chart for each of [`CHARTS`] that the history has.
fn charts(folder: &RunFolder<'_>, scene: &Scene, record: &Record) -> Result<(), RunError> {
    for name in CHARTS.map(|column| &*column.name) {
        let columns = of_owners(scene, record.columns(), name);
        let Some((_, first)) = columns.first() else {
            continue;
        };
        let series = columns
            .iter()
            .map(|(owner, column)| series_of(record, column, (*owner).to_owned()));
        let chart = over_time(scene, first.label(), series.collect());
        chart.write(&folder.join(format!("history_{name}")), folder.provenance())?;
    }
    Ok(())
}

/// The column of that name and those of rigid bodies whose names go before it, each with its owner; one that stands alone needs none.
fn of_owners<'a>(
    scene: &'a Scene,
    columns: &'a [ReadOut],
    name: &str,
) -> Vec<(&'a str, &'a ReadOut)> {
    let named = |name: &str| columns.iter().find(|column| column.name == name);
    let bodies = (scene.rigid_bodies.iter())
        .map(|body| (&*body.name, prefix(scene, body)))
        .filter(|(_, prefix)| !prefix.is_empty())
        .filter_map(|(body, prefix)| Some((body, named(&format!("{prefix}{name}"))?)));
    let bodies: Vec<_> = bodies.collect();
    let owner = match bodies[..] {
        [] => "",
        _ => "structure",
    };
    let itself = named(name).map(|column| (owner, column));
    itself.into_iter().chain(bodies).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::case::{Choices, SHIPPED, parse};

    /// Who has a column of that name in a shipped case with changes.
    fn owners(case: &str, changes: &[&str], name: &str) -> Vec<(String, String)> {
        let (_, text) = SHIPPED.iter().find(|(known, _)| *known == case).unwrap();
        let choices = Choices {
            variant: None,
            overrides: changes.iter().map(|&change| change.to_owned()).collect(),
        };
        let case = parse(case, text, Path::new("cases"), &choices).unwrap();
        let columns = measure::history_columns(&case.scene);
        let found = of_owners(&case.scene, &columns, name).into_iter();
        found
            .map(|(owner, column)| (owner.to_owned(), column.name.to_string()))
            .collect()
    }

    #[test]
    fn bodies_share_a_chart() {
        let pair = |owner: &str, name: &str| (owner.to_owned(), name.to_owned());
        let alone = owners("sphere", &[], "force_x_n");
        assert_eq!(alone, [pair("", "force_x_n")]);
        let two = [
            "resolution.cells_per_diameter=absent",
            "resolution.cell_size_m=0.0125",
            "air.refinement={around=\"nothing\"}",
            "air.wind_tunnel.size_m=[0.5, 0.8, 0.4]",
            "air.wind_tunnel.sponge_length_m=0.1",
            "bodies.sphere.position_m=[0.18, 0.2, 0.2]",
            "bodies.other.position_m=[0.18, 0.6, 0.2]",
            "bodies.other.sphere.diameter_m=0.1",
        ];
        let mut found = owners("sphere", &two, "lift_coefficient");
        found.sort();
        assert_eq!(
            found,
            [
                pair("other", "other_lift_coefficient"),
                pair("sphere", "sphere_lift_coefficient")
            ]
        );
        assert!(owners("sphere", &two, "descent_speed_m_s").is_empty());
        let payload = [
            "bodies.payload.position_m=[0.55, 0.997, 0.997]",
            "bodies.payload.sphere.diameter_m=0.2",
            "coupling.scheme=kernel",
            "resolution.cells_per_diameter=12.0",
            "air.refinement={around=\"nothing\"}",
            "air.wind_tunnel.size_m=[2.9915, 1.994, 1.994]",
            "air.wind_tunnel.sponge_length_m=0.4",
            "structure.flat_circular.confluence_m=[0.4, 0.997, 0.997]",
            "structure.flat_circular.rings=8",
        ];
        assert_eq!(
            owners("flat-circular-tunnel", &payload, "drag_coefficient"),
            [
                pair("structure", "drag_coefficient"),
                pair("payload", "payload_drag_coefficient")
            ]
        );
        let diameter = "projected_diameter_ratio";
        let found = owners("flat-circular-tunnel", &payload, diameter);
        assert_eq!(found, [pair("", diameter)]);
    }
}
