//! `[canopy]`, `[wing]`, `[mesh]`: a case by a design, from which all its other tables follow (docs/design.md).
//!
//! What a case writes itself stands; the rest is derived from sizes, speeds and masses.

mod canopy;
mod derived;
mod handbook;
mod materials;
mod mesh;
mod scales;
mod shape;
mod units;
pub(super) mod wing;

use std::path::Path;

use serde::Deserialize;
use toml::{Table, Value};

pub use derived::Derived;
pub(super) use derived::{Keys, commented, traced};

use super::file::{CanopyDesign, MeshDesign, MeshType, WingDesign};
use super::problem::Problem;
use super::text::ABSENT;

/// The tables of designs, of which a case has one at most.
pub const TABLES: [&str; 3] = ["canopy", "wing", "mesh"];

/// On the command line this stands for the table of the design that the case has.
pub(super) const ANY: &str = "design";

/// A case's design alone, so that what cannot be read is told by its whole path. One of them is there.
#[derive(Deserialize)]
pub(super) struct Designed {
    canopy: Option<CanopyDesign>,
    wing: Option<WingDesign>,
    mesh: Option<MeshDesign>,
}

/// Name of the design that a case has.
pub(super) fn table_of(case: &Table) -> Option<&'static str> {
    TABLES.into_iter().find(|table| case.contains_key(*table))
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

/// The design of a case taken out of it, to be read; `None` where it has none.
pub(super) fn take(case: &mut Table) -> Result<Option<Table>, Problem> {
    let mut taken = TABLES
        .into_iter()
        .filter_map(|name| Some((name, case.remove(name)?)));
    let Some((name, design)) = taken.next() else {
        return Ok(None);
    };
    if let Some((other, _)) = taken.next() {
        return Err(Problem::new(
            other,
            format!("[{name}] and [{other}] are both whole cases"),
            "remove one of the two",
        ));
    }
    let mut alone = Table::from_iter([(name.to_owned(), design)]);
    derived::remove_absent(&mut alone, ABSENT);
    Ok(Some(alone))
}

/// Puts all that follows from a design into a case, where that does not say otherwise; returns what it put. Files are looked up relative to
/// `folder`.
pub(super) fn expand(
    design: &Designed,
    written: &Table,
    case: &mut Table,
    folder: &Path,
) -> Result<Vec<Derived>, Problem> {
    let own = |name: &str| written.get(name).and_then(Value::as_table);
    let (keys, structure, of) = if let Some(canopy) = &design.canopy {
        let structure = shape::table(canopy.kind);
        (canopy::derive(canopy, case)?, Some(structure), "canopy")
    } else if let Some(wing) = &design.wing {
        (wing::derive(wing, case)?, Some("wing"), "wing")
    } else if let (Some(mesh), Some(table)) = (&design.mesh, own("mesh")) {
        let structure = (mesh.kind != MeshType::Rigid).then_some("mesh");
        (mesh::derive(mesh, table, folder)?, structure, "mesh")
    } else {
        return Ok(Vec::new());
    };
    let structures = case.get("structure").and_then(Value::as_table);
    if let Some(name) = structure
        && let Some(other) =
            structures.and_then(|structures| structures.keys().find(|key| *key != name))
    {
        return Err(Problem::new(
            format!("structure.{other}"),
            format!(
                "[structure.{other}] is another structure than that of [{of}], which is [structure.{name}]"
            ),
            "remove one of the two",
        ));
    }
    let derived = keys.put_into(case);
    derived::remove_absent(case, ABSENT);
    Ok(derived)
}
