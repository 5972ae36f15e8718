//! What a sweep over lattices, or over starts on one, tells of every result: order, error of the lattice, interval, and whether it is resolved.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use super::contents::{Ladder, Outcome, Rung, Status, Sweep};
use super::order::{OnLattice, SAME, convergence};
use super::vary::{LATTICE_KEYS, SHIFT_KEY};
use crate::measure::statistics::student;
use crate::output::{
    ComparisonRow, LatticeError, OutputError, Quantity, comparison_markdown, field, significant,
    value_and_uncertainty, write_atomically,
};

/// Largest error, over the value, of a result that counts as resolved. Half of the 10 % to which shipped cases know their mean drag: what differs
/// by less from design to design is lost in the scatter of drop tests and tunnels anyway.
pub const RESOLVED_SHARE: f64 = 0.05;

/// Extremes whose own interval is only that of the mean they are divided by.
const EXTREMES_OVER_MEANS: [&str; 1] = ["opening_force_factor"];

/// Digits of errors and orders.
const DIGITS: i32 = 2;

/// Runs of one series on one lattice.
struct Lattice<'a> {
    name: String,
    cell_m: f64,
    runs: Vec<&'a Outcome>,
}

/// The ladders of a sweep: one for each combination of keys that change neither lattice nor start. Runs on one lattice that differ in anything but their start are in different ones. Empty
/// where nothing of that varies.
#[must_use]
pub fn ladders(sweep: &Sweep) -> Vec<Ladder> {
    let starts_vary = sweep.leading_keys.iter().any(|key| key == SHIFT_KEY);
    if sweep.lattice_key.is_none() && !starts_vary {
        return Vec::new();
    }
    let keys = keys_of_series(sweep);
    let mut series: Vec<(String, Vec<Lattice>)> = Vec::new();
    for run in sweep.runs.iter().filter(|run| run.status == Status::Done) {
        let Some(cell_m) = run.cell_size_m else {
            continue;
        };
        let name = series_of(sweep, &keys, run);
        let known = series.iter().position(|(known, _)| *known == name);
        let number = known.unwrap_or_else(|| {
            series.push((name, Vec::new()));
            series.len() - 1
        });
        let lattices = &mut series[number].1;
        match lattices.iter_mut().find(|known| known.cell_m == cell_m) {
            Some(known) => known.runs.push(run),
            None => lattices.push(Lattice {
                name: match &sweep.lattice_key {
                    Some(key) => sweep.value(run, key).to_owned(),
                    None => format!("cells of {} m", significant(cell_m, 4)),
                },
                cell_m,
                runs: vec![run],
            }),
        }
    }
    let ladder = |(series, mut lattices): (String, Vec<Lattice>)| {
        lattices.sort_by(|a, b| b.cell_m.total_cmp(&a.cell_m));
        Ladder::new(series, &lattices, sweep.lattice_key.as_deref())
    };
    series.into_iter().map(ladder).collect()
}

/// Marks every result that its ladder does not resolve, in all its runs.
pub fn mark_unresolved(sweep: &mut Sweep) {
    let ladders = ladders(sweep);
    let keys = keys_of_series(sweep);
    for number in 0..sweep.runs.len() {
        let name = series_of(sweep, &keys, &sweep.runs[number]);
        let Some(ladder) = ladders.iter().find(|ladder| ladder.series == name) else {
            continue;
        };
        for (name, quantity) in sweep.runs[number].results.iter_mut() {
            let rung = ladder.rungs.iter().find(|rung| rung.result == name);
            if let Some(rung) = rung.filter(|rung| rung.resolved == Some(false)) {
                let why = rung.verdict.strip_prefix("unresolved: ");
                quantity.mark_unresolved(why.unwrap_or(&rung.verdict));
            }
        }
    }
}

/// Keys whose values tell series of runs from each other: the leading ones but those of lattice and start, and others in which runs on one lattice differ.
///
/// What varies together with the cells, such as rings of triangles, belongs to the lattice where each lattice has one value of it.
fn keys_of_series(sweep: &Sweep) -> Vec<String> {
    let is_other = |key: &&String| *key != SHIFT_KEY && Some(*key) != sweep.lattice_key.as_ref();
    let mut keys: Vec<String> = (sweep.leading_keys.iter().filter(is_other).cloned()).collect();
    let all: BTreeSet<&String> = sweep
        .runs
        .iter()
        .flat_map(|run| run.values.keys())
        .collect();
    for key in all {
        // Those of the cells act by the size that all runs on one lattice have.
        if key == SHIFT_KEY || LATTICE_KEYS.contains(&key.as_str()) || keys.contains(key) {
            continue;
        }
        let mut of_lattices: HashMap<(Option<u64>, String), &str> = HashMap::new();
        let differs = sweep.runs.iter().any(|run| {
            let cell = run.cell_size_m.map(f64::to_bits);
            let value = sweep.value(run, key);
            let lattice = (cell, series_of(sweep, &keys, run));
            *of_lattices.entry(lattice).or_insert(value) != value
        });
        if differs {
            keys.push(key.clone());
        }
    }
    keys
}

/// Values of the keys that tell a run's series.
fn series_of(sweep: &Sweep, keys: &[String], run: &Outcome) -> String {
    let words = keys.iter();
    let words = words.map(|key| format!("{key} = {}", sweep.value(run, key)));
    words.collect::<Vec<_>>().join(", ")
}

/// Value and interval of a result over the runs on one lattice, and what the interval is of.
fn over_starts(name: &str, runs: &[&Outcome]) -> Option<(f64, Option<f64>, String)> {
    let found = runs.iter().filter_map(|run| {
        let quantity = run.results.get(name)?;
        Some((quantity, quantity.value?))
    });
    let found: Vec<(&Quantity, f64)> = found.collect();
    match found.as_slice() {
        [] => None,
        [(quantity, value)] => {
            let interval = quantity.confidence.or(quantity.sampling_error);
            let of = match (quantity.confidence, quantity.sampling_error) {
                (Some(_), _) => "the run's own",
                (None, Some(_)) => "between samples",
                (None, None) => "",
            };
            Some((*value, interval, of.to_owned()))
        }
        several => {
            let count = several.len();
            let mean = several.iter().map(|(_, value)| value).sum::<f64>() / count as f64;
            let squares = several.iter().map(|(_, value)| (value - mean).powi(2));
            let deviation = (squares.sum::<f64>() / (count - 1) as f64).sqrt();
            let half = student(count - 1) * deviation;
            // A mean over time is better known from several runs; an extreme is that of one run, whichever one looks at.
            let is_mean = several.iter().all(|(q, _)| q.confidence.is_some())
                && !EXTREMES_OVER_MEANS.contains(&name);
            Some(if is_mean {
                let half = half / (count as f64).sqrt();
                (mean, Some(half), format!("mean of {count} starts"))
            } else {
                (mean, Some(half), format!("one of {count} starts"))
            })
        }
    }
}

impl Ladder {
    fn new(series: String, lattices: &[Lattice], key: Option<&str>) -> Self {
        let mut names: Vec<(&str, &str)> = Vec::new();
        for run in lattices.iter().flat_map(|lattice| &lattice.runs) {
            for (name, quantity) in run.results.iter() {
                if !names.iter().any(|(known, _)| *known == name) {
                    names.push((name, quantity.unit.as_str()));
                }
            }
        }
        let rungs: Vec<Rung> = (names.iter())
            .map(|(name, unit)| Rung::new(name, unit, lattices))
            .collect();
        let finest = lattices.last().and_then(|lattice| lattice.runs.first());
        let comparison = finest.map_or_else(Vec::new, |run| {
            let rows = run.comparison.iter();
            rows.filter_map(|row| {
                let rung = rungs.iter().find(|rung| rung.result == row.quantity)?;
                Some(rung.compared(row, key))
            })
            .collect()
        });
        Self {
            series,
            lattices: lattices.iter().map(|own| own.name.clone()).collect(),
            cell_sizes_m: lattices.iter().map(|own| own.cell_m).collect(),
            starts: lattices.iter().map(|own| own.runs.len()).collect(),
            rungs,
            comparison,
        }
    }
}

impl Rung {
    fn new(name: &str, unit: &str, lattices: &[Lattice]) -> Self {
        let found: Vec<Option<(f64, Option<f64>, String)>> = lattices
            .iter()
            .map(|lattice| over_starts(name, &lattice.runs))
            .collect();
        let on: Vec<OnLattice> = (lattices.iter().zip(&found))
            .filter_map(|(lattice, found)| {
                let (value, interval, _) = found.as_ref()?;
                Some(OnLattice {
                    cell: lattice.cell_m,
                    value: *value,
                    interval: *interval,
                })
            })
            .collect();
        let told = convergence(&on);
        let finest = found.last().cloned().flatten();
        let mut rung = Self {
            result: name.to_owned(),
            unit: unit.to_owned(),
            values: found.iter().map(|f| f.as_ref().map(|f| f.0)).collect(),
            intervals: (found.iter())
                .map(|f| f.as_ref().and_then(|f| f.1))
                .collect(),
            interval_of: finest.as_ref().map_or_else(String::new, |f| f.2.clone()),
            order: told.order,
            tends_to: told.tends_to,
            lattice_error: told.error,
            error: None,
            resolved: None,
            verdict: String::new(),
        };
        let Some((value, interval, _)) = finest else {
            "unknown: the finest lattice did not determine it".clone_into(&mut rung.verdict);
            return rung;
        };
        rung.error = told.error.map(|error| error.hypot(interval.unwrap_or(0.0)));
        (rung.resolved, rung.verdict) = match (on.len(), rung.error) {
            (2, Some(_)) => {
                let spread = significant(told.error.unwrap_or(f64::NAN), DIGITS);
                (None, format!("unknown: two lattices, spread {spread}"))
            }
            (3.., Some(error)) => judge((value, error), interval, &told),
            _ => (None, "unknown: one lattice".to_owned()),
        };
        rung
    }

    /// The value on the finest lattice.
    fn finest(&self) -> Quantity {
        Quantity {
            value: self.values.last().copied().flatten(),
            unit: self.unit.clone(),
            confidence: self.intervals.last().copied().flatten(),
            ..Quantity::default()
        }
    }

    /// A row of the finest run's comparison, with what the lattices tell.
    fn compared(&self, row: &ComparisonRow, key: Option<&str>) -> ComparisonRow {
        let count = self.values.iter().flatten().count();
        let lattice = match (count, self.lattice_error) {
            (2, Some(spread)) => LatticeError::Spread(spread),
            (3.., Some(error)) => LatticeError::HalfWidth(error),
            _ => LatticeError::OneLattice {
                cells_per_diameter: None,
                key: key.unwrap_or("resolution.cells_per_diameter").to_owned(),
            },
        };
        let quantity = self.finest();
        let mut own = ComparisonRow::new(
            &row.quantity,
            &quantity,
            row.reference,
            &row.source,
            &lattice,
        );
        own.note.clone_from(&row.note);
        own.unresolved = row.unresolved;
        own
    }

    fn cells(&self) -> Vec<String> {
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |v| significant(v, DIGITS));
        let mut cells = vec![self.result.clone(), self.unit.clone()];
        for (value, interval) in self.values.iter().zip(&self.intervals) {
            let quantity = Quantity {
                value: *value,
                confidence: *interval,
                ..Quantity::default()
            };
            let [value, interval] = value_and_uncertainty(&quantity);
            cells.push(if interval == "-" {
                value
            } else {
                format!("{value} {interval}")
            });
        }
        let limit = Quantity {
            value: self.tends_to,
            confidence: self.lattice_error,
            ..Quantity::default()
        };
        let [limit, _] = value_and_uncertainty(&limit);
        let interval = self.intervals.last().copied().flatten();
        cells.extend([
            number(self.order),
            limit,
            number(self.lattice_error),
            match interval {
                Some(half) => format!("{} ({})", significant(half, DIGITS), self.interval_of),
                None => "-".to_owned(),
            },
            self.verdict.clone(),
        ]);
        cells
    }
}

/// Whether a value from three lattices or more is resolved.
fn judge(
    (value, error): (f64, f64),
    interval: Option<f64>,
    told: &super::order::Convergence,
) -> (Option<bool>, String) {
    let basis = &told.basis;
    // A result that is nothing on every lattice is known to all digits.
    let share = if error == 0.0 {
        0.0
    } else {
        100.0 * error / value.abs()
    };
    let limit = 100.0 * RESOLVED_SHARE;
    if error > RESOLVED_SHARE * value.abs() {
        let why = if share.is_finite() {
            format!("±{} % on the finest lattice", significant(share, DIGITS))
        } else {
            format!("±{} about zero", significant(error, DIGITS))
        };
        return (
            Some(false),
            format!("unresolved: {why}, more than {limit:.0} % ({basis})"),
        );
    }
    let same = told.error.is_some_and(|error| error <= SAME * value.abs());
    if interval.is_none() && !same {
        return (
            None,
            format!(
                "unknown: the lattice leaves ±{} % ({basis}), but there is no interval: --ensemble N gives one",
                significant(share, DIGITS)
            ),
        );
    }
    let verdict = if same && interval.is_none() {
        format!("resolved: {basis}")
    } else {
        format!("resolved: ±{} % ({basis})", significant(share, DIGITS))
    };
    (Some(true), verdict)
}

/// The ladders in Markdown, with the results of those names; empty without ladders.
#[must_use]
pub fn ladder_markdown(ladders: &[Ladder], results: &[String]) -> String {
    let mut text = String::new();
    for ladder in ladders {
        let name = if ladder.series.is_empty() {
            "Lattices"
        } else {
            ladder.series.as_str()
        };
        let starts = match ladder.starts.iter().max() {
            Some(most) if *most > 1 => {
                let counts: Vec<String> = ladder.starts.iter().map(usize::to_string).collect();
                format!(" ({} starts)", counts.join(", "))
            }
            _ => String::new(),
        };
        text += &format!("\n{name}{starts}:\n\n");
        let mut header = vec!["result".to_owned(), "unit".to_owned()];
        header.extend(ladder.lattices.iter().cloned());
        header.extend(
            [
                "order",
                "tends to",
                "error of the lattice",
                "interval",
                "verdict",
            ]
            .map(str::to_owned),
        );
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        text += &line(&header);
        text += &format!("|{}\n", "---|".repeat(header.len()));
        for name in results {
            if let Some(rung) = ladder.rungs.iter().find(|rung| rung.result == *name) {
                text += &line(&rung.cells());
            }
        }
        let count = |answer: Option<bool>| {
            let rungs = ladder.rungs.iter();
            rungs.filter(|rung| rung.resolved == answer).count()
        };
        text += &format!(
            "\nOf all {} results {} are resolved, {} unresolved, {} unknown (ladder.csv).\n",
            ladder.rungs.len(),
            count(Some(true)),
            count(Some(false)),
            count(None)
        );
        if !ladder.comparison.is_empty() {
            text.push('\n');
            text += &comparison_markdown(&ladder.comparison);
        }
    }
    text
}

/// Writes `ladder.csv` into `folder`: one row for each result of each series. Nothing without ladders.
pub(super) fn write_ladders(folder: &Path, ladders: &[Ladder]) -> Result<(), OutputError> {
    let Some(most) = ladders.iter().map(|ladder| ladder.lattices.len()).max() else {
        return Ok(());
    };
    write_atomically(&folder.join("ladder.csv"), |out| {
        let mut csv = csv::Writer::from_writer(out);
        let mut header: Vec<String> = ["series", "result", "unit"].map(str::to_owned).to_vec();
        for k in 1..=most {
            for name in ["lattice", "cell_size_m", "starts", "value", "interval"] {
                header.push(format!("{name}_{k}"));
            }
        }
        header.extend(
            [
                "interval_of",
                "order",
                "tends_to",
                "lattice_error",
                "error",
                "resolved",
                "verdict",
            ]
            .map(str::to_owned),
        );
        csv.write_record(&header)?;
        for ladder in ladders {
            for rung in &ladder.rungs {
                let mut cells = vec![
                    ladder.series.clone(),
                    rung.result.clone(),
                    rung.unit.clone(),
                ];
                for k in 0..most {
                    cells.extend([
                        ladder.lattices.get(k).cloned().unwrap_or_default(),
                        field(ladder.cell_sizes_m.get(k).copied()),
                        (ladder.starts.get(k)).map_or_else(String::new, usize::to_string),
                        field(rung.values.get(k).copied().flatten()),
                        field(rung.intervals.get(k).copied().flatten()),
                    ]);
                }
                cells.extend([
                    rung.interval_of.clone(),
                    field(rung.order),
                    field(rung.tends_to),
                    field(rung.lattice_error),
                    field(rung.error),
                    rung.resolved.map_or_else(String::new, |r| r.to_string()),
                    rung.verdict.clone(),
                ]);
                csv.write_record(&cells)?;
            }
        }
        csv.flush()
    })
}

#[cfg(test)]
#[path = "ladder_tests.rs"]
mod tests;
