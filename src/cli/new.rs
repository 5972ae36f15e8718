//! `ripstop new NAME`

use clap::Args;

use super::{Failure, emit, exit};
use crate::case::SHIPPED;

#[derive(Debug, Args)]
pub(super) struct NewArguments {
    /// Name of a shipped case.
    name: String,
}

pub(super) fn new(arguments: &NewArguments) -> Result<u8, Failure> {
    match SHIPPED.iter().find(|(name, _)| *name == arguments.name) {
        Some((_, text)) => {
            emit(text)?;
            Ok(0)
        }
        None => {
            let names: Vec<&str> = SHIPPED.iter().map(|(name, _)| *name).collect();
            Err(Failure::Other(
                exit::BAD_CASE,
                format!(
                    "there is no shipped case `{}`; there are: {}",
                    arguments.name,
                    names.join(", ")
                ),
            ))
        }
    }
}
