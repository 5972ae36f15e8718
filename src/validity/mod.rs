//! Whether a set-up supports its results: one table of what the numbers of a case must keep to, known beforehand or at the end of a run, and
//! the error to be expected of its lattice and its box. `docs/validity.md` says where every limit is from.

mod at_the_end;
mod beforehand;
mod expected_error;
mod rule;
mod subject;

pub use beforehand::beforehand;
pub use expected_error::expected_errors;

use crate::case::Scene;
use crate::frame::StructureFrame;
use crate::measure::Record;
use crate::output::ValidityRow;
use crate::plan::Plan;

/// The table of a run that is over: what was known beforehand, and what it measured.
#[must_use]
pub fn of_run(
    scene: &Scene,
    plan: &Plan,
    structure: Option<&StructureFrame>,
    record: &Record,
) -> Vec<ValidityRow> {
    let measured = at_the_end::at_the_end(scene, structure, record);
    let mut rows = beforehand(scene, plan);
    if !measured.is_empty() {
        rows.retain(|row| row.name != beforehand::STRAIN_TO_BE_EXPECTED);
    }
    rows.extend(measured);
    rows
}
