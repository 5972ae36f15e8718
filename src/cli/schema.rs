//! `ripstop schema`

use clap::Args;

use super::failure::Failure;
use super::log::emit;
use crate::case::{key_reference, schema_text};

#[derive(Debug, Args)]
pub(super) struct SchemaArguments {
    /// Print the keys as tables of Markdown instead.
    #[arg(long)]
    markdown: bool,
}

pub(super) fn schema(arguments: &SchemaArguments) -> Result<u8, Failure> {
    if arguments.markdown {
        emit(&key_reference())?;
    } else {
        emit(&schema_text())?;
    }
    Ok(0)
}
