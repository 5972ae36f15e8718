//! What a run is known by: in checkpoints and in its ledger.

use std::path::Path;

use super::names;
use crate::case::Case;
use crate::ledger::{CaseEntry, Ledger, Reached, take_stock};
use crate::plan::Plan;
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

pub(super) fn case_entry(case: &Case) -> CaseEntry {
    CaseEntry {
        title: case.scene.title.clone(),
        file: case.name.clone(),
        variant: case.variant.clone(),
        overrides: case.overrides.clone(),
        hash: case.hash.clone(),
        physics: case.physics.clone(),
        text: case.text.clone(),
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
