//! `ripstop check CASE.toml`

use clap::Args;

use super::run::{strict, validity_text};
use super::{CaseArguments, Failure, emit};
use crate::measure;
use crate::plan;
use crate::validity;

#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    #[command(flatten)]
    case: CaseArguments,
    /// End with exit code 1 where the set-up does not support its results.
    #[arg(long)]
    strict: bool,
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
    let validity = validity::beforehand(&case.scene, &prepared.plan);
    let expected = validity::expected_errors(&case.scene);
    let text = validity_text(&validity, &expected);
    if !text.is_empty() {
        emit(&format!("\n{text}\n"))?;
    }
    if arguments.strict {
        return strict(&validity, std::iter::empty());
    }
    Ok(0)
}
