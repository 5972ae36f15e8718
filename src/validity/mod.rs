//! Whether a set-up supports its results: one table of what the numbers of a case must keep to, known beforehand or at the end of a run, and
//! the error to be expected of its lattice and its box. `docs/validity.md` says where every limit is from.

mod at_the_end;
mod beforehand;
mod expected_error;
mod subject;

pub use beforehand::beforehand;
pub use expected_error::expected_errors;

use crate::case::Scene;
use crate::frame::StructureFrame;
use crate::measure::Record;
use crate::output::{Bound, Supports, ValidityRow, When};
use crate::plan::Plan;

/// A row of the table, for every `Of` that it applies to.
struct Rule<Of> {
    /// What is looked at.
    name: &'static str,
    /// Unit of the value.
    unit: &'static str,
    /// What the value is.
    meaning: &'static str,
    /// On which side of the limit it must lie.
    bound: Bound,
    /// The limit.
    limit: f64,
    /// Which results need it.
    supports: Supports,
    /// What to do where it does not.
    remedy: &'static str,
    /// The value; `None` where the rule does not apply.
    value: fn(&Of) -> Option<f64>,
}

impl<Of> Rule<Of> {
    /// The row of one of them; `None` where the rule does not apply. A value that is not a number is outside of every limit.
    fn row(&self, of: &Of, (name, prefix): (&str, &str), when: When) -> Option<ValidityRow> {
        let value = (self.value)(of)?;
        let valid = match self.bound {
            Bound::AtMost => value <= self.limit,
            Bound::AtLeast => value >= self.limit,
        };
        Some(ValidityRow {
            name: if name.is_empty() {
                self.name.to_owned()
            } else {
                format!("{name}: {}", self.name)
            },
            unit: self.unit.to_owned(),
            meaning: self.meaning.to_owned(),
            when,
            value: value.is_finite().then_some(value),
            bound: self.bound,
            limit: self.limit,
            valid: Some(valid),
            supports: self.supports,
            prefix: prefix.to_owned(),
            remedy: self.remedy.to_owned(),
        })
    }
}

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
