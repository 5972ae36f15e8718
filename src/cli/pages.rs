//! `ripstop completions SHELL` and `ripstop man`: what packages install beside the program.

use clap::{Args, Command};
use clap_complete::Shell;

use super::exit;
use super::failure::Failure;
use super::log::emit;

#[derive(Debug, Args)]
pub(super) struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

pub(super) fn completions(
    arguments: &CompletionsArguments,
    mut command: Command,
) -> Result<u8, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "ripstop", &mut text);
    emit(&String::from_utf8_lossy(&text))?;
    Ok(0)
}

/// The page of the program, and behind it those of its commands.
pub(super) fn man(command: &Command) -> Result<u8, Failure> {
    let mut text = Vec::new();
    let mut write = |command: Command| clap_mangen::Man::new(command).render(&mut text);
    let mut written = write(command.clone());
    for inner in command.get_subcommands() {
        let name = format!("ripstop-{}", inner.get_name());
        written = written.and_then(|()| write(inner.clone().display_name(&name).bin_name(name)));
    }
    written.map_err(|error| Failure::Other(exit::OUTPUT_FAILED, error.to_string()))?;
    emit(&String::from_utf8_lossy(&text))?;
    Ok(0)
}
