//! The load test of a wing, and the tables, charts and pictures that it leaves.

use std::cell::RefCell;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{INTERRUPTED, Observer, Run, RunError};
use crate::case::scene::Scene;
use crate::case::wing::Wing;
use crate::measure::{self, LineName, LoadReading};
use crate::output::{Chart, OutputError, Series, write_table, write_text_table};
use crate::simulation::{LoadStep, LoadTestState, Simulation};
use crate::solve::lbfgs::Progress;

/// Tables of a load test.
pub(super) const TABLES: [&str; 2] = ["load_test.csv", "load_test_lines.csv"];

/// Charts of a load test, without their endings.
pub(super) const CHARTS: [&str; 3] = ["load_test_lines", "load_test_rows", "load_test_stress"];

/// The wing under the largest load.
pub(super) const PICTURE: &str = "load_test.png";

/// The same for ParaView.
pub(super) const SHAPE: &str = "load_test.vtp";

impl Run<'_> {
    /// Raises the loads if the case asks for it; returns why the run ended if it was interrupted.
    pub(super) fn test_loads(
        &mut self,
        interrupt: &AtomicBool,
        observer: &mut dyn Observer,
    ) -> Result<Option<String>, RunError> {
        let scene = &self.case.scene;
        let (Some(wing), Some(body)) = (&scene.wing, &scene.body) else {
            return Ok(None);
        };
        let Some(test) = &wing.load_test else {
            return Ok(None);
        };
        let names = measure::line_names(wing, &body.structure);
        let steps = test.load_factors.len() as u64;
        let done = std::cell::Cell::new(0);
        let observer = RefCell::new(observer);
        let mut watch = |progress: &Progress| {
            let status = format!(
                "load test: step {} of {steps}, fabric's energy norm {:.1e} of the loads', {} evaluations",
                done.get(),
                progress.relative_norm,
                progress.evaluations
            );
            observer.borrow_mut().progress(done.get(), steps, &status);
            !interrupt.load(Ordering::Relaxed)
        };
        let last = test.load_factors.last().copied().unwrap_or(1.0);
        let files = &mut self.files;
        let mut unbalanced = Vec::new();
        let mut failed = None;
        let mut report = |simulation: &Simulation, step: &LoadStep| {
            done.set(done.get() + 1);
            observer.borrow_mut().note(&line(wing, &names, step));
            if !step.is_balanced() {
                unbalanced.push(step.load_factor);
            }
            if step.load_factor == last
                && let Err(error) = files.loaded_wing(simulation, last)
            {
                failed = Some(error);
            }
            Ok(())
        };
        let ended = self.simulation.test_loads(&mut watch, &mut report);
        if let Some(error) = failed {
            return Err(error);
        }
        match ended.transpose()? {
            None => {
                self.notes
                    .push("no load test was done: there are no loads of an equilibrium".to_owned());
            }
            Some(false) if interrupt.load(Ordering::Relaxed) => {
                self.save()?;
                return Ok(Some(INTERRUPTED.to_owned()));
            }
            Some(_) => {}
        }
        if !unbalanced.is_empty() {
            self.unbalanced = true;
            self.notes.push(format!(
                "the load test is not in balance at load factors {unbalanced:?}: lower equilibrium.tolerance, or raise equilibrium.evaluation_limit"
            ));
        }
        Ok(None)
    }
}

/// A step in a line.
fn line(wing: &Wing, names: &[LineName], step: &LoadStep) -> String {
    let reading = measure::read_load_step(wing, step);
    let nearest = reading.nearest.as_ref().map_or_else(
        || "breaking loads are not told".to_owned(),
        |n| {
            format!(
                "nearest to breaking {} at {:.2}",
                names[n.cable].text(),
                n.share
            )
        },
    );
    let rows: Vec<String> = wing
        .wing
        .row_names
        .iter()
        .zip(&reading.row_loads_n)
        .map(|(name, load)| format!("{name} {load:.0}"))
        .collect();
    let stress = reading.stresses.iter().map(|s| s.1).fold(0.0, f64::max);
    format!(
        "load factor {:>5.2}: risers {:.0} N (rows {} N), {nearest}; largest stress {:.1} MPa, projected area {:.3} m2, guide {:.1} N, risers lack {:.1e}, {} evaluations",
        step.load_factor,
        reading.riser_forces_n.iter().sum::<f64>(),
        rows.join(", "),
        1e-6 * stress,
        reading.projected_area_m2,
        step.guide_n,
        step.balance_error,
        step.evaluations
    )
}

/// Writes tables and charts of a load test; nothing where there is none.
pub(super) fn write(
    folder: &Path,
    scene: &Scene,
    simulation: &Simulation,
) -> Result<(), OutputError> {
    let (Some(wing), Some(body), Some(state)) =
        (&scene.wing, &scene.body, simulation.load_test_state())
    else {
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
    folder: &Path,
    wing: &Wing,
    state: &LoadTestState,
    readings: &[LoadReading],
) -> Result<(), OutputError> {
    let rows = &wing.wing.row_names;
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
    folder: &Path,
    wing: &Wing,
    state: &LoadTestState,
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
    folder: &Path,
    title: &str,
    wing: &Wing,
    readings: &[LoadReading],
) -> Result<(), OutputError> {
    let series = |name: String, of: &dyn Fn(&LoadReading) -> f64| Series {
        name,
        points: readings.iter().map(|r| [r.load_factor, of(r)]).collect(),
        bars: Vec::new(),
        markers: true,
    };
    let rows = || wing.wing.row_names.iter().enumerate();
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
        .write(&folder.join(file))?;
    }
    Ok(())
}
