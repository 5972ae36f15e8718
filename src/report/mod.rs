//! `report.html`: one self-contained page of a finished run, of a sweep, of a polar, or of several runs side by side, from the files in their folders.

mod charts;
mod folder;
mod page;
mod parts;
mod polar;
mod side_by_side;
mod sweep;

use std::path::Path;

pub use folder::{Finished, FolderError, names};
pub use polar::{PageTable, PolarPage};
pub use side_by_side::{Difference, differences};

use crate::output::{OutputError, write_atomically};
use crate::sweep::{Chosen, Sweep};

/// Name of a run's report in its folder.
pub const FILE_NAME: &str = "report.html";

/// Writes the report of a run into its folder.
///
/// # Errors
///
/// When the page cannot be written.
pub fn write(run: &Finished) -> Result<(), OutputError> {
    let page = page::of_run(run);
    write_atomically(&run.folder.join(FILE_NAME), |out| {
        out.write_all(page.as_bytes())
    })
}

/// Writes the report of a sweep into its folder, from the folders of its runs.
///
/// # Errors
///
/// When the page cannot be written.
pub fn write_sweep(folder: &Path, sweep: &Sweep, chosen: &Chosen) -> Result<(), OutputError> {
    let page = sweep::page_of(folder, sweep, chosen);
    write_atomically(&folder.join(FILE_NAME), |out| {
        out.write_all(page.as_bytes())
    })
}

/// Writes the page of a polar into a folder.
///
/// # Errors
///
/// When the page cannot be written.
pub fn write_polar(folder: &Path, polar: &PolarPage) -> Result<(), OutputError> {
    let page = polar::page_of(polar);
    write_atomically(&folder.join(FILE_NAME), |out| {
        out.write_all(page.as_bytes())
    })
}

/// Writes one page with several runs side by side.
///
/// # Errors
///
/// When the page cannot be written.
pub fn write_comparison(runs: &[Finished], path: &Path) -> Result<(), OutputError> {
    let page = page::of_several(runs);
    write_atomically(path, |out| out.write_all(page.as_bytes()))
}
