//! Results beside the values of others: rows of `summary.json`, of the terminal, and of `comparison.csv` and `comparison.md`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::aligned::aligned;
use super::atomic::{OutputError, write_atomically};
use super::digits::{NOTHING, UNRESOLVED, significant, with_interval};
use super::quantity::Quantity;
use super::table::field;

/// Cells of the nominal diameter within which nothing that air does to a sheet is resolved: half the width of the kernel through
/// which the two meet.
pub const UNRESOLVED_CELLS: f64 = 2.0;

/// Digits of references and differences.
const DIGITS: i32 = 4;

/// What is known of the error that the lattice of the air makes in a result.
#[derive(Debug, Clone, PartialEq)]
pub enum LatticeError {
    /// There is no air, hence no lattice.
    None,
    /// One lattice tells nothing of it.
    OneLattice {
        /// Its cells per nominal diameter, of a canopy.
        cells_per_diameter: Option<f64>,
        /// Key of the case that sets the size of its cells.
        key: String,
    },
    /// Two lattices tell how far their values lie apart, in the unit of the result.
    Spread(f64),
    /// Three or more: half width, in the unit of the result.
    HalfWidth(f64),
}

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
    /// The run does not support our value ([`Quantity::unresolved`]).
    #[serde(default)]
    pub unresolved: bool,
    /// Remark of the case on the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl ComparisonRow {
    /// Sets a result beside a reference.
    ///
    /// A difference counts as resolved where it exceeds the error of the lattice and, combined with it in quadrature, the half width of our
    /// 95 % confidence interval (or the interval between samples where the value was read from single samples). With one lattice, or two, that
    /// error is unknown, and so is the answer, unless the difference lies within what is known: the interval, the spread of two lattices, or
    /// the share [`UNRESOLVED_CELLS`] of the cells per diameter in our value. A value without any uncertainty of its own decides nothing.
    #[must_use]
    pub fn new(
        name: &str,
        quantity: &Quantity,
        reference: [f64; 2],
        source: &str,
        lattice: &LatticeError,
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
            unresolved: quantity.unresolved.is_some(),
            note: None,
        };
        (row.resolved, row.why) = row.judge(quantity, lattice);
        row
    }

    fn judge(&self, quantity: &Quantity, lattice: &LatticeError) -> (Option<bool>, String) {
        let (Some(value), Some(difference)) = (self.value, self.difference) else {
            let why = quantity.note.clone();
            return (
                None,
                why.unwrap_or_else(|| "the run did not determine it".to_owned()),
            );
        };
        let difference = difference.abs();
        let (own, own_name) = match (self.confidence, self.sampling_error) {
            (Some(half), _) => (Some(half), "our 95 % interval"),
            (None, interval) => (interval, "a sample interval"),
        };
        if let LatticeError::OneLattice {
            cells_per_diameter: Some(cells),
            ..
        } = lattice
            && difference <= UNRESOLVED_CELLS / cells * value.abs()
        {
            let share = 100.0 * UNRESOLVED_CELLS / cells;
            let why = format!("within {UNRESOLVED_CELLS:.0} cells of D_0, {share:.1} %");
            return (Some(false), why);
        }
        if own.is_some_and(|own| difference <= own) {
            return (Some(false), format!("within {own_name}"));
        }
        let beyond_own = match own {
            Some(_) => format!("beyond {own_name}"),
            None => "our value has no interval".to_owned(),
        };
        match lattice {
            LatticeError::None if own.is_none() => (
                None,
                format!("{beyond_own}: a single extreme, or too short a run"),
            ),
            LatticeError::None => (Some(true), beyond_own),
            LatticeError::OneLattice { key, .. } => (
                None,
                format!("one lattice, {beyond_own}: `ripstop sweep CASE --vary {key}=A,B,C` tells"),
            ),
            LatticeError::Spread(spread) | LatticeError::HalfWidth(spread) => {
                let error = spread.hypot(own.unwrap_or(0.0));
                let told = format!("±{} of lattice and interval", significant(error, 2));
                match lattice {
                    _ if difference <= error => (Some(false), format!("within {told}")),
                    LatticeError::Spread(_) => {
                        (None, format!("two lattices, beyond {told}: a third tells"))
                    }
                    _ if own.is_none() => (
                        None,
                        format!(
                            "{beyond_own} (`ripstop sweep --ensemble N` gives one); beyond {told}"
                        ),
                    ),
                    _ => (Some(true), format!("beyond {told}")),
                }
            }
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
        let ours = with_interval(&quantity);
        let ours = if self.unresolved {
            format!("{ours} ({UNRESOLVED})")
        } else {
            ours
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
    let mut table = vec![HEADER.map(str::to_owned).to_vec()];
    table.extend(rows.iter().map(|row| row.cells().to_vec()));
    aligned(&table)
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
        for row in rows {
            csv.write_record([
                row.quantity.clone(),
                row.unit.clone(),
                row.source.clone(),
                field(Some(row.reference[0])),
                field(Some(row.reference[1])),
                field(row.value),
                field(row.confidence),
                field(row.sampling_error),
                field(row.difference),
                field(row.relative_difference),
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

    fn judged(quantity: &Quantity, reference: [f64; 2], lattice: &LatticeError) -> Option<bool> {
        ComparisonRow::new("x", quantity, reference, "there", lattice).resolved
    }

    fn one(cells: Option<f64>) -> LatticeError {
        LatticeError::OneLattice {
            cells_per_diameter: cells,
            key: "resolution.cells_per_diameter".to_owned(),
        }
    }

    #[test]
    fn without_air_a_difference_counts_beyond_the_interval() {
        let alone = LatticeError::None;
        let mean = Quantity::new(1.0).with_confidence(0.1);
        assert_eq!(judged(&mean, [1.09, 1.09], &alone), Some(false));
        assert_eq!(judged(&mean, [1.11, 1.11], &alone), Some(true));
        let time = Quantity::new(0.050).with_sampling_error(0.001);
        assert_eq!(judged(&time, [0.0505, 0.0505], &alone), Some(false));
        assert_eq!(judged(&time, [0.055, 0.055], &alone), Some(true));
        assert_eq!(judged(&Quantity::new(1.0), [2.0, 2.0], &alone), None);
        let missing = Quantity::missing("too short");
        let row = ComparisonRow::new("x", &missing, [1.0, 1.0], "there", &alone);
        assert_eq!((row.resolved, row.why.as_str()), (None, "too short"));
    }

    #[test]
    fn one_lattice_resolves_no_difference() {
        let mean = Quantity::new(1.0).with_confidence(0.1);
        assert_eq!(judged(&mean, [1.09, 1.09], &one(None)), Some(false));
        // Two cells of ten are 20 %.
        assert_eq!(judged(&mean, [1.19, 1.19], &one(Some(10.0))), Some(false));
        assert_eq!(judged(&mean, [1.21, 1.21], &one(Some(10.0))), None);
        let row = ComparisonRow::new("x", &mean, [5.0, 5.0], "there", &one(Some(10.0)));
        assert_eq!(row.resolved, None);
        assert_eq!(
            row.why,
            "one lattice, beyond our 95 % interval: `ripstop sweep CASE --vary resolution.cells_per_diameter=A,B,C` tells"
        );
    }

    #[test]
    fn several_lattices_combine_their_error_with_the_interval() {
        let mean = Quantity::new(1.0).with_confidence(0.3);
        let three = LatticeError::HalfWidth(0.4);
        assert_eq!(judged(&mean, [1.49, 1.49], &three), Some(false));
        assert_eq!(judged(&mean, [1.51, 1.51], &three), Some(true));
        let two = LatticeError::Spread(0.4);
        assert_eq!(judged(&mean, [1.49, 1.49], &two), Some(false));
        assert_eq!(judged(&mean, [9.0, 9.0], &two), None);
        // An extreme without an interval may lie within, never beyond.
        let extreme = Quantity::new(1.0);
        assert_eq!(judged(&extreme, [1.39, 1.39], &three), Some(false));
        assert_eq!(judged(&extreme, [9.0, 9.0], &three), None);
    }

    #[test]
    fn ranges_count_from_their_nearest_end() {
        let mean = Quantity::new(1.0).with_confidence(0.01);
        let row = |range| ComparisonRow::new("x", &mean, range, "there", &LatticeError::None);
        assert_eq!(row([0.9, 1.2]).difference, Some(0.0));
        assert_eq!(row([0.9, 1.2]).resolved, Some(false));
        assert!((row([1.25, 1.5]).difference.unwrap() + 0.25).abs() < 1e-12);
        assert!((row([1.25, 1.5]).relative_difference.unwrap() + 0.2).abs() < 1e-12);
        assert_eq!(row([0.0, 0.0]).relative_difference, None);
    }

    #[test]
    fn files_are_written_with_what_readers_expect() {
        let folder = tempfile::tempdir().unwrap();
        let mean = Quantity::new(0.82).with_confidence(0.07);
        let mut row = ComparisonRow::new("drag", &mean, [0.7, 0.8], "a | b", &one(Some(24.0)));
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
