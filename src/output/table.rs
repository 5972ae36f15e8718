//! Tables of numbers as CSV files.

use std::path::Path;

use super::atomic::{OutputError, write_atomically};

/// A number as a field of a table, with all its digits; nothing where there is none.
pub(crate) fn field(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:?}"))
}

/// Writes a table of words with a header, whole or not at all.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write_text_table(
    path: &Path,
    columns: &[&str],
    rows: &[Vec<String>],
) -> Result<(), OutputError> {
    write_atomically(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(columns)?;
        for row in rows {
            csv.write_record(row)?;
        }
        csv.flush()
    })
}

/// Writes a table with a header, whole or not at all; NaN is an empty field.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write_table(
    path: &Path,
    columns: &[&str],
    rows: impl IntoIterator<Item: AsRef<[f64]>>,
) -> Result<(), OutputError> {
    write_atomically(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(columns)?;
        for row in rows {
            csv.write_record(
                row.as_ref()
                    .iter()
                    .map(|&value| super::history::field(value)),
            )?;
        }
        csv.flush()
    })
}
