//! A row of the table of validity, before the numbers of a case are put in.

use crate::output::{Bound, Supports, ValidityRow, When};

/// A row of the table, for every `Of` that it applies to.
pub(super) struct Rule<Of> {
    /// What is looked at.
    pub(super) name: &'static str,
    /// Unit of the value.
    pub(super) unit: &'static str,
    /// What the value is.
    pub(super) meaning: &'static str,
    /// On which side of the limit it must lie.
    pub(super) bound: Bound,
    /// The limit.
    pub(super) limit: f64,
    /// Which results need it.
    pub(super) supports: Supports,
    /// What to do where it does not.
    pub(super) remedy: &'static str,
    /// The value; `None` where the rule does not apply.
    pub(super) value: fn(&Of) -> Option<f64>,
}

impl<Of> Rule<Of> {
    /// The row of one of them; `None` where the rule does not apply. A value that is not a number is outside of every limit.
    pub(super) fn row(
        &self,
        of: &Of,
        (name, prefix): (&str, &str),
        when: When,
    ) -> Option<ValidityRow> {
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
