//! `ripstop check CASE.toml`

use clap::Args;

use super::{CaseArguments, Failure, emit};

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    case: CaseArguments,
}

pub(super) fn check(arguments: &CheckArguments) -> Result<u8, Failure> {
    let prepared = arguments.case.prepare()?;
    emit(
        &prepared
            .plan
            .report(&prepared.case.scene, rayon::current_num_threads()),
    )?;
    Ok(0)
}
