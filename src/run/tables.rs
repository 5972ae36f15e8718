//! Tables that a run leaves at its end, beside its history.

use std::path::Path;

use super::RunError;
use crate::case::Scene;
use crate::measure::{self, Record};
use crate::output::{Summary, write_comparison, write_table};

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
    if !summary.comparison.is_empty() {
        write_comparison(folder, &summary.comparison)?;
    }
    Ok(())
}
