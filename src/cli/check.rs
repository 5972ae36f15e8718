//! `ripstop check CASE.toml`

use clap::Args;

use super::{CaseArguments, Failure, emit};
use crate::measure;
use crate::plan;

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    case: CaseArguments,
}

pub(super) fn check(arguments: &CheckArguments) -> Result<u8, Failure> {
    let prepared = arguments.case.prepare()?;
    let case = &prepared.case;
    let threads = rayon::current_num_threads();
    emit(&prepared.plan.report(&case.scene, threads))?;
    emit(&plan::grid_sequence(&case.coarser))?;
    if let Some(averaging) = measure::averaging(&case.scene) {
        emit(&format!("\n{averaging}\n"))?;
    }
    Ok(0)
}
