//! `[canopy]`: a canopy by its design, from which all other tables of a case follow (docs/design.md).
//!
//! What a case writes itself stands; the rest is derived from the nominal diameter D_0, the speed U and the masses.

mod canopy;
mod derived;
mod handbook;
mod scales;
mod shape;

use serde::Deserialize;
use toml::{Table, Value};

pub use derived::Derived;

use super::file::CanopyDesign;
use super::problem::Problem;
use super::text::ABSENT;

/// The table of a design.
pub(super) const TABLE: &str = "canopy";

/// A case's `[canopy]` alone, so that what cannot be read is told by its whole path.
#[derive(Deserialize)]
pub(super) struct Designed {
    pub(super) canopy: CanopyDesign,
}

/// A case's text with the reason behind every key that follows from its design; it runs as the design does. Without a design it stays as it is.
#[must_use]
pub fn expanded(text: &str, derived: &[Derived]) -> String {
    if derived.is_empty() {
        return text.to_owned();
    }
    toml::from_str(text).map_or_else(
        |_| text.to_owned(),
        |case: Table| derived::commented(&case, derived),
    )
}

/// The `[canopy]` of a case taken out of it, to be read; `None` where it has none.
pub(super) fn take(case: &mut Table) -> Option<Table> {
    let design = case.remove(TABLE)?;
    let mut alone = Table::from_iter([(TABLE.to_owned(), design)]);
    derived::remove_absent(&mut alone, ABSENT);
    Some(alone)
}

/// Puts all that follows from a design into a case, where that does not say otherwise; returns what it put.
pub(super) fn expand(design: &CanopyDesign, case: &mut Table) -> Result<Vec<Derived>, Problem> {
    let name = shape::table(design.kind);
    let written = case.get("structure").and_then(Value::as_table);
    if let Some(other) = written.and_then(|structures| structures.keys().find(|key| *key != name)) {
        return Err(Problem::new(
            format!("structure.{other}"),
            format!(
                "[structure.{other}] is another canopy than that of [canopy], which is [structure.{name}]"
            ),
            "remove one of the two",
        ));
    }
    let derived = canopy::derive(design)?.put_into(case);
    derived::remove_absent(case, ABSENT);
    Ok(derived)
}
