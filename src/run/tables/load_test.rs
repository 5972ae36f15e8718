//! Tables, charts and pictures of a load test.

use crate::case::scene::Scene;
use crate::case::wing::Wing;
use crate::measure::{self, LineName, LoadReading};
use crate::output::{Chart, OutputError, Series, write_table, write_text_table};
use crate::run::run_folder::RunFolder;
use crate::statics::LoadTest;

/// Tables of a load test.
pub(in crate::run) const TABLES: [&str; 2] = ["load_test.csv", "load_test_lines.csv"];

/// Charts of a load test, without their endings.
pub(in crate::run) const CHARTS: [&str; 3] =
    ["load_test_lines", "load_test_rows", "load_test_stress"];

/// The wing under the largest load.
pub(in crate::run) const PICTURE: &str = "load_test.png";

/// The same for ParaView.
pub(in crate::run) const SHAPE: &str = "load_test.vtp";

/// Writes tables and charts of a load test; nothing where there is none.
pub(in crate::run) fn write(
    folder: &RunFolder<'_>,
    scene: &Scene,
    load_test: Option<&LoadTest>,
) -> Result<(), OutputError> {
    let (Some(wing), Some(body), Some(state)) = (scene.wing(), &scene.body, load_test) else {
        return Ok(());
    };
    if state.steps.is_empty() {
        return Ok(());
    }
    let readings: Vec<LoadReading> = state
        .steps
        .iter()
        .map(|step| measure::read_load_step(wing, step))
        .collect();
    steps_table(folder, wing, state, &readings)?;
    let names = measure::line_names(wing, &body.structure);
    lines_table(folder, wing, state, &names)?;
    charts(folder, &scene.title, wing, &readings)
}

fn steps_table(
    folder: &RunFolder<'_>,
    wing: &Wing,
    state: &LoadTest,
    readings: &[LoadReading],
) -> Result<(), OutputError> {
    let rows = &wing.built.row_names;
    let parts = measure::wing_parts(wing);
    let mut columns: Vec<String> = [
        "load_factor",
        "riser_force_right_n",
        "riser_force_left_n",
        "guide_n",
        "riser_balance_error",
        "energy_norm",
        "evaluations",
        "projected_area_m2",
        "line_load_over_breaking_load_max",
    ]
    .map(str::to_owned)
    .into();
    columns.extend(rows.iter().map(|name| format!("row_{name}_load_n")));
    columns.extend(
        rows.iter()
            .map(|name| format!("row_{name}_load_over_breaking_load_max")),
    );
    columns.extend(
        parts
            .iter()
            .map(|part| format!("{}_stress_max_pa", measure::part_key(*part))),
    );
    let share = |nearest: &Option<measure::Nearest>| nearest.as_ref().map_or(f64::NAN, |n| n.share);
    let table: Vec<Vec<f64>> = state
        .steps
        .iter()
        .zip(readings)
        .map(|(step, reading)| {
            let mut row = vec![
                step.load_factor,
                reading.riser_forces_n[0],
                reading.riser_forces_n[1],
                step.guide_n,
                step.balance_error,
                step.relative_norm,
                step.evaluations as f64,
                reading.projected_area_m2,
                share(&reading.nearest),
            ];
            row.extend(&reading.row_loads_n);
            row.extend(reading.rows.iter().map(share));
            row.extend(reading.stresses.iter().map(|s| s.1));
            row
        })
        .collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    write_table(&folder.join(TABLES[0]), &columns, &table)
}

/// All lines with their loads at every step.
fn lines_table(
    folder: &RunFolder<'_>,
    wing: &Wing,
    state: &LoadTest,
    names: &[LineName],
) -> Result<(), OutputError> {
    let mut columns: Vec<String> = ["line", "half", "breaking_load_n"]
        .map(str::to_owned)
        .into();
    columns.extend(
        state
            .steps
            .iter()
            .map(|step| format!("load_n_at_{}", step.load_factor)),
    );
    columns.push("load_over_breaking_load_at_last".to_owned());
    let rows: Vec<Vec<String>> = names
        .iter()
        .zip(&wing.breaking_loads_n)
        .enumerate()
        .map(|(cable, (name, breaking))| {
            let loads: Vec<f64> = state
                .steps
                .iter()
                .map(|s| s.cable_tensions_n[cable])
                .collect();
            let mut row = vec![
                name.text(),
                name.half.to_owned(),
                breaking.map_or_else(String::new, |b| format!("{b}")),
            ];
            row.extend(loads.iter().map(|load| format!("{load:.3}")));
            let used = breaking.zip(loads.last()).map(|(b, load)| load / b);
            row.push(used.map_or_else(String::new, |used| format!("{used:.5}")));
            row
        })
        .collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    write_text_table(&folder.join(TABLES[1]), &columns, &rows)
}

fn charts(
    folder: &RunFolder<'_>,
    title: &str,
    wing: &Wing,
    readings: &[LoadReading],
) -> Result<(), OutputError> {
    let series = |name: String, of: &dyn Fn(&LoadReading) -> f64| Series {
        name,
        points: readings.iter().map(|r| [r.load_factor, of(r)]).collect(),
        bars: Vec::new(),
        markers: true,
        colour: None,
    };
    let rows = || wing.built.row_names.iter().enumerate();
    let shares: Vec<Series> = rows()
        .map(|(row, name)| {
            series(name.clone(), &|r| {
                r.rows[row].as_ref().map_or(f64::NAN, |n| n.share)
            })
        })
        .collect();
    let loads = rows()
        .map(|(row, name)| series(name.clone(), &|r| r.row_loads_n[row]))
        .collect();
    let stresses = measure::wing_parts(wing)
        .into_iter()
        .enumerate()
        .map(|(number, part)| series(part.name().to_owned(), &|r| 1e-6 * r.stresses[number].1))
        .collect();
    for (file, label, series) in [
        (
            CHARTS[0],
            "largest line load of the row over its breaking load",
            shares,
        ),
        (CHARTS[1], "tension of the row's risers [N]", loads),
        (CHARTS[2], "largest stress [MPa]", stresses),
    ] {
        Chart {
            title: title.to_owned(),
            labels: ["load factor".to_owned(), label.to_owned()],
            categories: Vec::new(),
            series,
        }
        .write(&folder.join(file), folder.provenance())?;
    }
    Ok(())
}
