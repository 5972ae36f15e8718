//! What a run is known by: in checkpoints and in its ledger.

use std::path::Path;
use std::time::Duration;

use super::names::{self, CASE_FILE};
use crate::case::{Case, expanded};
use crate::ledger::{CaseEntry, Ledger, Reached, take_stock};
use crate::output::{OutputError, write_atomically};
use crate::plan::{Plan, structure_every};
use crate::simulation::Simulation;

/// What a checkpoint must agree with to be resumed from: the physics of the case, and precision.
pub(super) fn identity(case: &Case, plan: &Plan) -> String {
    format!(
        "case {} in {}",
        case.physics,
        plan.placement.precision_name()
    )
}

/// Who computes what: where it differs, a resumed run does not deliver the bits of one that was never interrupted.
pub(super) fn computed_by(plan: &Plan) -> String {
    let placement = &plan.placement;
    let engine = |on_device: bool| match &placement.device {
        Some(name) if on_device => name.as_str(),
        _ => "the host",
    };
    format!(
        "air on {}, fabric on {}",
        engine(placement.air_on_device()),
        engine(placement.cloth_on_device())
    )
}

/// Key of the time between checkpoints, which the command line gives.
const CHECKPOINTS: &str = "checkpoint_every_s";

/// The case of a run, with all that it leaves to the program.
pub(super) fn case_entry(case: &Case, checkpoint_interval: Duration) -> CaseEntry {
    let mut resolved = case.resolved.clone();
    let every = "coupling.structure_every";
    if case
        .scene
        .coupling
        .is_some_and(|c| c.structure_every.is_none())
        && case.scene.body.is_some()
    {
        resolved.insert(every.to_owned(), structure_every(&case.scene).into());
    }
    resolved.insert(
        CHECKPOINTS.to_owned(),
        checkpoint_interval.as_secs_f64().into(),
    );
    CaseEntry {
        title: case.scene.title.clone(),
        file: case.name.clone(),
        variant: case.variant.clone(),
        overrides: case.overrides.clone(),
        hash: case.hash.clone(),
        physics: case.physics.clone(),
        text: case.text.clone(),
        resolved,
    }
}

pub(super) fn reached(simulation: &Simulation) -> Reached {
    Reached {
        step: simulation.step_count(),
        time_s: simulation.time_s(),
    }
}

/// Brings the list of files in a ledger up to date, and how far the run has come.
pub(super) fn account(ledger: &mut Ledger, folder: &Path, simulation: &Simulation) {
    ledger.files = take_stock(folder, &ledger.files, names::is_result);
    ledger.reached = reached(simulation);
}

/// Section that tells who computed a checkpoint.
pub(super) const COMPUTED_BY: &str = "computed_by";

/// Writes the case as it is run, with variant, overrides and what follows from its design, into the folder.
pub(super) fn write_case(case: &Case, folder: &Path) -> Result<(), OutputError> {
    let mut head = format!(
        "# As run by ripstop {} from {}",
        env!("CARGO_PKG_VERSION"),
        case.name
    );
    if let Some(variant) = &case.variant {
        head += &format!(", variant {variant}");
    }
    for change in &case.overrides {
        head += &format!(", --set {change}");
    }
    // A change may hold a line feed.
    let head = head.replace(['\n', '\r'], " ");
    let text = expanded(&case.text, &case.derived);
    write_atomically(&folder.join(CASE_FILE), |out| {
        writeln!(out, "{head}\n{text}")
    })
}
