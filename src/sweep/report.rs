//! What came out of a sweep: `sweep.json`, `sweep.csv`, `sweep.md`, and charts of chosen results.

use std::path::Path;

use super::contents::{Outcome, Status, Sweep, last};
use super::ladder::{ladder_markdown, ladders, write_ladders};
use crate::measure::shared::TIME;
use crate::output::{
    Chart, OutputError, Provenance, Quantity, ReadOut, Series, field, value_and_uncertainty,
    write_atomically,
};

/// What is shown of a sweep.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Chosen {
    /// Results of the table and of a chart each.
    pub results: Vec<String>,
    /// Results of which the second is drawn over the first.
    pub pairs: Vec<[String; 2]>,
    /// Columns of `history.csv` for a chart each.
    pub histories: Vec<ReadOut>,
}

/// The table of chosen results in Markdown: one row for each run.
#[must_use]
pub fn markdown(sweep: &Sweep, chosen: &Chosen) -> String {
    let unit = |name: &String| {
        let known = sweep.runs.iter().find_map(|run| run.results.get(name));
        match known.map(|q| q.unit.as_str()) {
            None | Some("1") => name.clone(),
            Some(unit) => format!("{name} [{unit}]"),
        }
    };
    let mut header: Vec<String> = sweep.leading_keys.clone();
    header.push("run".to_owned());
    header.extend(chosen.results.iter().map(unit));
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = line(&header);
    text += &format!("|{}\n", "---|".repeat(header.len()));
    let mut unsupported = false;
    for run in &sweep.runs {
        let mut cells: Vec<String> = sweep
            .leading_keys
            .iter()
            .map(|key| sweep.value(run, key).replace('|', "\\|"))
            .collect();
        let mark = if run.missed.is_empty() { "" } else { " †" };
        cells.push(format!("{}{mark}", run.status.name()));
        cells.extend(chosen.results.iter().map(|name| {
            let known = run.results.get(name).cloned();
            let quantity = known.unwrap_or_else(|| Quantity::missing(""));
            let [value, uncertainty] = value_and_uncertainty(&quantity);
            let mark = if quantity.unresolved.is_some() {
                unsupported = true;
                " \\*"
            } else {
                ""
            };
            if uncertainty == "-" {
                format!("{value}{mark}")
            } else {
                format!("{value} {uncertainty}{mark}")
            }
        }));
        text += &line(&cells);
    }
    if unsupported {
        text += "\n\\* unresolved: the set-up of that run does not support it; the validity in its summary.json says why\n";
    }
    let missed: Vec<&Outcome> = (sweep.runs.iter())
        .filter(|run| !run.missed.is_empty())
        .collect();
    if !missed.is_empty() {
        text += &format!(
            "\n† trust: NOT ALL WAS MET in {} of {} runs:\n\n",
            missed.len(),
            sweep.runs.len()
        );
    }
    for run in missed {
        text += &format!("* {}: {}\n", run.folder, run.missed.join("; "));
    }
    for run in &sweep.runs {
        if let Some(message) = &run.message {
            text += &format!("\n{}: {message}\n", run.folder);
        }
    }
    text += &ladder_markdown(&ladders(sweep), &chosen.results);
    text
}

/// Writes all files of a sweep into `folder`, with what its lattices tell; those that cannot be drawn for lack of points are left out.
///
/// # Errors
///
/// When a file cannot be drawn or written.
pub fn write(folder: &Path, sweep: &Sweep, chosen: &Chosen) -> Result<(), OutputError> {
    let told = Sweep {
        ladders: ladders(sweep),
        ..sweep.clone()
    };
    write_ladders(folder, &told.ladders)?;
    write_atomically(&folder.join("sweep.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, &told).map_err(std::io::Error::from)?;
        out.write_all(b"\n")
    })?;
    write_csv(folder, sweep)?;
    let text = markdown(sweep, chosen);
    write_atomically(&folder.join("sweep.md"), |out| {
        out.write_all(text.as_bytes())
    })?;
    let provenance = provenance(sweep);
    for (name, chart) in charts(folder, sweep, chosen) {
        chart.write(&folder.join(name), &provenance)?;
    }
    Ok(())
}

/// What charts of several runs have in common; each run's folder holds its own case.
fn provenance(sweep: &Sweep) -> Provenance {
    let file = Path::new(&sweep.case).file_name().unwrap_or_default();
    let mut source = file.to_string_lossy().into_owned();
    if let Some(variant) = &sweep.variant {
        source += &format!(", variant {variant}");
    }
    Provenance {
        program: format!("ripstop version {}", env!("CARGO_PKG_VERSION")),
        source,
        case: String::new(),
    }
}

/// Charts of what is shown of a sweep in `folder`, with the names of their files: results over each other and over the first leading key, histories over time.
#[must_use]
pub fn charts(folder: &Path, sweep: &Sweep, chosen: &Chosen) -> Vec<(String, Chart)> {
    let results = (chosen.results.iter()).map(|name| (format!("sweep_{name}"), chart(sweep, name)));
    let histories = chosen.histories.iter().map(|column| {
        let chart = histories(folder, sweep, column);
        (format!("sweep_history_{}", column.name), chart)
    });
    let pairs = chosen.pairs.iter().map(|pair| {
        let name = format!("sweep_{}_over_{}", pair[1], pair[0]);
        (name, over_each_other(sweep, pair))
    });
    pairs.chain(results).chain(histories).collect()
}

fn write_csv(folder: &Path, sweep: &Sweep) -> Result<(), OutputError> {
    let names = sweep.names();
    let mut keys: Vec<&String> = sweep
        .runs
        .iter()
        .flat_map(|run| run.values.keys())
        .collect();
    keys.sort();
    keys.dedup();
    write_atomically(&folder.join("sweep.csv"), |out| {
        let mut csv = csv::Writer::from_writer(out);
        let mut header: Vec<String> = keys.iter().map(|key| (*key).clone()).collect();
        header.extend(["folder", "status"].map(str::to_owned));
        for name in &names {
            header.extend([name.clone(), format!("{name}_uncertainty")]);
        }
        csv.write_record(&header)?;
        for run in &sweep.runs {
            let mut cells: Vec<String> = keys
                .iter()
                .map(|key| sweep.value(run, key).to_owned())
                .collect();
            cells.extend([run.folder.clone(), run.status.name().to_owned()]);
            for name in &names {
                let quantity = run.results.get(name);
                cells.push(field(quantity.and_then(|q| q.value)));
                cells.push(field(
                    quantity.and_then(|q| q.confidence.or(q.sampling_error)),
                ));
            }
            csv.write_record(&cells)?;
        }
        csv.flush()
    })
}

/// One result against another, one series for each combination of the keys but the first leading one.
fn over_each_other(sweep: &Sweep, pair: &[String; 2]) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    let mut labels = pair.clone();
    for run in sweep.runs.iter().filter(|run| run.status == Status::Done) {
        let found = pair.each_ref().map(|name| run.results.get(name));
        let [Some(x), Some(y)] = found else { continue };
        let (Some(at), Some(value)) = (x.value, y.value) else {
            continue;
        };
        labels = [with_unit(&pair[0], &x.unit), with_unit(&pair[1], &y.unit)];
        own_series(&mut series, sweep.series(run))
            .points
            .push([at, value]);
    }
    Chart {
        title: sweep.title.clone(),
        labels,
        categories: Vec::new(),
        series,
    }
}

/// The series of a name, a new one where there is none.
fn own_series(series: &mut Vec<Series>, name: String) -> &mut Series {
    let known = series.iter().position(|s| s.name == name);
    let index = known.unwrap_or(series.len());
    if known.is_none() {
        series.push(Series {
            name,
            points: Vec::new(),
            bars: Vec::new(),
            markers: true,
            colour: None,
        });
    }
    &mut series[index]
}

fn with_unit(name: &str, unit: &str) -> String {
    if unit == "1" || unit.is_empty() {
        name.to_owned()
    } else {
        format!("{name} [{unit}]")
    }
}

/// One result against the first leading key, one series for each combination of the others.
fn chart(sweep: &Sweep, name: &str) -> Chart {
    let key = sweep.leading_keys.first().map_or("", String::as_str);
    let done = || sweep.runs.iter().filter(|run| run.status == Status::Done);
    let mut categories: Vec<String> = Vec::new();
    if done().any(|run| sweep.value(run, key).parse::<f64>().is_err()) {
        for run in &sweep.runs {
            let value = sweep.value(run, key).to_owned();
            if !categories.contains(&value) {
                categories.push(value);
            }
        }
    }
    let place = |run: &Outcome| {
        let value = sweep.value(run, key);
        let category = categories.iter().position(|known| known == value);
        category.map_or_else(|| value.parse().unwrap_or(f64::NAN), |k| (k + 1) as f64)
    };
    let mut series: Vec<Series> = Vec::new();
    let mut unit = String::new();
    for run in done() {
        let Some(quantity) = run.results.get(name) else {
            continue;
        };
        let Some(value) = quantity.value else {
            continue;
        };
        unit.clone_from(&quantity.unit);
        let own = own_series(&mut series, sweep.series(run));
        own.points.push([place(run), value]);
        let half = quantity.confidence.or(quantity.sampling_error);
        own.bars.push(half.unwrap_or(0.0));
    }
    Chart {
        title: sweep.title.clone(),
        labels: [key.to_owned(), with_unit(name, &unit)],
        categories,
        series,
    }
}

/// A column of all histories against time since release.
fn histories(folder: &Path, sweep: &Sweep, column: &ReadOut) -> Chart {
    let name = |run: &Outcome| {
        let words = sweep.leading_keys.iter();
        let words = words.map(|key| format!("{} = {}", last(key), sweep.value(run, key)));
        words.collect::<Vec<_>>().join(", ")
    };
    let series = sweep.runs.iter().filter_map(|run| {
        Some(Series {
            name: name(run),
            points: read_column(&folder.join(&run.folder).join("history.csv"), &column.name)?,
            bars: Vec::new(),
            markers: false,
            colour: None,
        })
    });
    Chart {
        title: sweep.title.clone(),
        labels: [TIME.label(), column.label()],
        categories: Vec::new(),
        series: series.collect(),
    }
}

/// Time and one column of a history from release on; `None` without the file or the column.
fn read_column(path: &Path, column: &str) -> Option<Vec<[f64; 2]>> {
    let mut csv = csv::Reader::from_path(path).ok()?;
    let header = csv.headers().ok()?.clone();
    let place = |name: &str| header.iter().position(|known| known == name);
    let (time, value) = (place(&TIME.name)?, place(column)?);
    let rows = csv.records().map_while(Result::ok);
    let pairs =
        rows.filter_map(|row| Some([row.get(time)?.parse().ok()?, row.get(value)?.parse().ok()?]));
    Some(pairs.filter(|[time, _]: &[f64; 2]| *time >= 0.0).collect())
}

#[cfg(test)]
#[path = "report_tests.rs"]
mod tests;
