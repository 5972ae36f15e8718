//! `[comparison.NAME]`: values of others that results are set beside at the end of a run.

use super::file::{ComparisonEntry, File};
use super::problem::Problem;

/// A value that a result is compared with, in the unit of the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Name of the result, as in `summary.json`.
    pub quantity: String,
    /// Lowest and highest value of the reference; equal where it is one value.
    pub range: [f64; 2],
    /// Where the reference comes from.
    pub source: String,
    /// Remark for the reader.
    pub note: Option<String>,
}

/// Checks everything but the names, which follow from what is measured.
pub(super) fn check(file: &File) -> Result<Vec<Comparison>, Problem> {
    let entries = file
        .comparison
        .iter()
        .flat_map(|(name, table)| table.0.iter().map(move |entry| (name, entry)));
    if let Some((name, _)) = file.comparison.iter().find(|(_, table)| table.0.is_empty()) {
        return Err(Problem::new(
            format!("comparison.{name}"),
            format!("comparison.{name} is an empty list"),
            "give at least one { value = …, source = \"…\" }, or remove it",
        ));
    }
    entries
        .map(|(name, entry)| {
            Ok(Comparison {
                quantity: name.clone(),
                range: range(name, entry)?,
                source: entry.source.clone(),
                note: entry.note.clone(),
            })
        })
        .collect()
}

fn range(name: &str, entry: &ComparisonEntry) -> Result<[f64; 2], Problem> {
    let refuse = |key: &str, what: String| {
        Err(Problem::new(
            format!("comparison.{name}{key}"),
            format!("comparison.{name}{key} {what}"),
            "give `value = …`, or `range = [low, high]`, in the unit of the result",
        ))
    };
    match (entry.value, entry.range) {
        (Some(value), None) if value.is_finite() => Ok([value, value]),
        (Some(value), None) => refuse(".value", format!("= {value} is not a number")),
        (None, Some([low, high])) if low.is_finite() && high.is_finite() && low <= high => {
            Ok([low, high])
        }
        (None, Some([low, high])) => refuse(
            ".range",
            format!("= [{low}, {high}] does not run from a lower to a higher number"),
        ),
        (Some(_), Some(_)) => refuse("", "has both value and range".to_owned()),
        (None, None) => refuse("", "has neither value nor range".to_owned()),
    }
}
