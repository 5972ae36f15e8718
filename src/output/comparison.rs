//! Results beside the values of others: rows of `summary.json`, of the terminal, and of `comparison.csv` and `comparison.md`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::atomic::{OutputError, write_atomically};
use super::summary::Quantity;
use super::summary_table::{NOTHING, significant, value_and_uncertainty};

/// Cells of the nominal diameter within which nothing that air does to a sheet is resolved: half the width of the kernel through
/// which the two meet.
pub const UNRESOLVED_CELLS: f64 = 2.0;

/// Digits of references and differences.
const DIGITS: i32 = 4;

/// One result beside one reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComparisonRow {
    /// Name of the result.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Where the reference comes from.
    pub source: String,
    /// Lowest and highest value of the reference, in `unit`; equal where it is one value.
    pub reference: [f64; 2],
    /// Our value, in `unit`; `None` where the run did not determine it.
    pub value: Option<f64>,
    /// Half width of its 95 % confidence interval, in `unit`.
    pub confidence: Option<f64>,
    /// Interval between the samples that it was read from, in `unit`.
    pub sampling_error: Option<f64>,
    /// Our value minus the reference, or minus the nearest end of its range; 0 within the range.
    pub difference: Option<f64>,
    /// Difference over the magnitude of that reference; `None` for a reference of zero.
    pub relative_difference: Option<f64>,
    /// Whether the difference is larger than what the run leaves open; `None` where that is not known.
    pub resolved: Option<bool>,
    /// Why, in a few words.
    pub why: String,
    /// Remark of the case on the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl ComparisonRow {
    /// Sets a result beside a reference.
    ///
    /// A difference counts as resolved where it exceeds (1) the half width of our 95 % confidence interval, or the interval between
    /// samples where the value was read from single samples, and (2) with air on `cells_per_diameter` cells, the share
    /// [`UNRESOLVED_CELLS`] of these in our value. A value without any uncertainty of its own decides nothing.
    #[must_use]
    pub fn new(
        name: &str,
        quantity: &Quantity,
        reference: [f64; 2],
        source: &str,
        cells_per_diameter: Option<f64>,
    ) -> Self {
        let nearest = |value: f64| value.clamp(reference[0], reference[1]);
        let difference = quantity.value.map(|value| value - nearest(value));
        let relative_difference = quantity
            .value
            .zip(difference)
            .filter(|(value, _)| nearest(*value) != 0.0)
            .map(|(value, difference)| difference / nearest(value).abs());
        let mut row = Self {
            quantity: name.to_owned(),
            unit: quantity.unit.clone(),
            source: source.to_owned(),
            reference,
            value: quantity.value,
            confidence: quantity.confidence,
            sampling_error: quantity.sampling_error,
            difference,
            relative_difference,
            resolved: None,
            why: String::new(),
            note: None,
        };
        (row.resolved, row.why) = row.judge(quantity, cells_per_diameter);
        row
    }

    fn judge(
        &self,
        quantity: &Quantity,
        cells_per_diameter: Option<f64>,
    ) -> (Option<bool>, String) {
        let (Some(value), Some(difference)) = (self.value, self.difference) else {
            let why = quantity.note.clone();
            return (
                None,
                why.unwrap_or_else(|| "the run did not determine it".to_owned()),
            );
        };
        let share = cells_per_diameter.map(|cells| UNRESOLVED_CELLS / cells);
        if let Some(share) = share.filter(|share| difference.abs() <= share * value.abs()) {
            let why = format!(
                "within {UNRESOLVED_CELLS:.0} cells of D_0, {:.1} %",
                100.0 * share
            );
            return (Some(false), why);
        }
        match (self.confidence, self.sampling_error) {
            (Some(half), _) if difference.abs() <= half => {
                (Some(false), "within our 95 % interval".to_owned())
            }
            (None, Some(interval)) if difference.abs() <= interval => {
                (Some(false), "within a sample interval".to_owned())
            }
            (None, None) => (
                None,
                "our value has no interval: a single extreme, or too short a run".to_owned(),
            ),
            (Some(_), _) => (Some(true), "beyond our 95 % interval".to_owned()),
            (None, Some(_)) => (Some(true), "beyond a sample interval".to_owned()),
        }
    }

    /// Cells of a table for a reader.
    fn cells(&self) -> [String; 7] {
        let number = |value: f64| significant(value, DIGITS);
        let [low, high] = self.reference;
        let reference = if low == high {
            number(low)
        } else {
            format!("{} to {}", number(low), number(high))
        };
        let quantity = Quantity {
            value: self.value,
            confidence: self.confidence,
            sampling_error: self.sampling_error,
            ..Quantity::default()
        };
        let [value, uncertainty] = value_and_uncertainty(&quantity);
        let ours = if uncertainty == NOTHING {
            value
        } else {
            format!("{value} {uncertainty}")
        };
        let difference = match (self.difference, self.relative_difference) {
            (Some(0.0), _) => "0".to_owned(),
            (_, Some(relative)) => format!("{:+.1} %", 100.0 * relative),
            (Some(difference), None) => number(difference),
            (None, None) => NOTHING.to_owned(),
        };
        let answer = match self.resolved {
            Some(true) => "yes",
            Some(false) => "no",
            None => "unknown",
        };
        [
            self.quantity.clone(),
            self.unit.clone(),
            self.source.clone(),
            reference,
            ours,
            difference,
            format!("{answer}: {}", self.why),
        ]
    }
}

const HEADER: [&str; 7] = [
    "quantity",
    "unit",
    "reference from",
    "reference",
    "ours",
    "difference",
    "resolved?",
];

/// The comparison as an aligned plain-text table; empty without rows.
#[must_use]
pub fn comparison_text(rows: &[ComparisonRow]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut table = vec![HEADER.map(str::to_owned)];
    table.extend(rows.iter().map(ComparisonRow::cells));
    let widths: [usize; 7] = std::array::from_fn(|column| {
        let lengths = table.iter().map(|row| row[column].chars().count());
        lengths.max().unwrap_or(0)
    });
    let mut text = String::new();
    for row in &table {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(widths) {
            line += &format!("{cell:<width$}  ");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// The comparison as a table in Markdown, followed by the remarks of the case.
#[must_use]
pub fn comparison_markdown(rows: &[ComparisonRow]) -> String {
    let line = |cells: [String; 7]| {
        let cells = cells.map(|cell| cell.replace('|', "\\|").replace('\n', " "));
        format!("| {} |\n", cells.join(" | "))
    };
    let mut text = line(HEADER.map(str::to_owned));
    text += "|---|---|---|---|---|---|---|\n";
    for row in rows {
        text += &line(row.cells());
    }
    for row in rows {
        if let Some(note) = &row.note {
            text += &format!("\n{} ({}): {note}\n", row.quantity, row.source);
        }
    }
    text
}

/// Writes `comparison.csv` and `comparison.md` into `folder`, each whole or not at all.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_comparison(folder: &Path, rows: &[ComparisonRow]) -> Result<(), OutputError> {
    let path = folder.join("comparison.csv");
    write_atomically(&path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record([
            "quantity",
            "unit",
            "source",
            "reference_low",
            "reference_high",
            "value",
            "confidence",
            "sampling_error",
            "difference",
            "relative_difference",
            "resolved",
            "why",
            "note",
        ])?;
        let number = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:?}"));
        for row in rows {
            csv.write_record([
                row.quantity.clone(),
                row.unit.clone(),
                row.source.clone(),
                number(Some(row.reference[0])),
                number(Some(row.reference[1])),
                number(row.value),
                number(row.confidence),
                number(row.sampling_error),
                number(row.difference),
                number(row.relative_difference),
                row.resolved.map_or_else(String::new, |r| r.to_string()),
                row.why.clone(),
                row.note.clone().unwrap_or_default(),
            ])?;
        }
        csv.flush()
    })?;
    let text = comparison_markdown(rows);
    write_atomically(&folder.join("comparison.md"), |out| {
        out.write_all(text.as_bytes())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(quantity: &Quantity, reference: [f64; 2], cells: Option<f64>) -> Option<bool> {
        ComparisonRow::new("x", quantity, reference, "there", cells).resolved
    }

    #[test]
    fn a_difference_counts_only_beyond_interval_and_cells() {
        let mean = Quantity::new(1.0, "1").with_confidence(0.1);
        assert_eq!(judged(&mean, [1.09, 1.09], None), Some(false));
        assert_eq!(judged(&mean, [1.11, 1.11], None), Some(true));
        // Two cells of ten are 20 %.
        assert_eq!(judged(&mean, [1.11, 1.11], Some(10.0)), Some(false));
        assert_eq!(judged(&mean, [1.21, 1.21], Some(10.0)), Some(true));
        let time = Quantity::new(0.050, "s").with_sampling_error(0.001);
        assert_eq!(judged(&time, [0.0505, 0.0505], None), Some(false));
        assert_eq!(judged(&time, [0.055, 0.055], None), Some(true));
        assert_eq!(judged(&Quantity::new(1.0, "1"), [2.0, 2.0], None), None);
        let missing = Quantity::missing("1", "too short");
        let row = ComparisonRow::new("x", &missing, [1.0, 1.0], "there", None);
        assert_eq!((row.resolved, row.why.as_str()), (None, "too short"));
    }

    #[test]
    fn ranges_count_from_their_nearest_end() {
        let mean = Quantity::new(1.0, "1").with_confidence(0.01);
        let row = |range| ComparisonRow::new("x", &mean, range, "there", None);
        assert_eq!(row([0.9, 1.2]).difference, Some(0.0));
        assert_eq!(row([0.9, 1.2]).resolved, Some(false));
        assert!((row([1.25, 1.5]).difference.unwrap() + 0.25).abs() < 1e-12);
        assert!((row([1.25, 1.5]).relative_difference.unwrap() + 0.2).abs() < 1e-12);
        assert_eq!(row([0.0, 0.0]).relative_difference, None);
    }

    #[test]
    fn files_are_written_with_what_readers_expect() {
        let folder = tempfile::tempdir().unwrap();
        let mean = Quantity::new(0.82, "1").with_confidence(0.07);
        let mut row = ComparisonRow::new("drag", &mean, [0.7, 0.8], "a | b", Some(24.0));
        row.note = Some("free, \"air\"".to_owned());
        write_comparison(folder.path(), &[row]).unwrap();
        let mut csv = csv::Reader::from_path(folder.path().join("comparison.csv")).unwrap();
        let record = csv.records().next().unwrap().unwrap();
        assert_eq!(&record[5], "0.82");
        assert_eq!(&record[12], "free, \"air\"");
        let text = std::fs::read_to_string(folder.path().join("comparison.md")).unwrap();
        assert!(text.contains("a \\| b"), "{text}");
        assert!(
            text.contains("| 0.7000 to 0.8000 | 0.820 ±0.070 | +2.5 % | no: within 2 cells"),
            "{text}"
        );
    }
}
