//! The command line: one file per command, exit codes in one place.

mod answer;
mod bare_polar;
mod bench;
mod case_arguments;
mod check;
mod devices;
mod engine;
pub mod exit;
mod explain;
mod failure;
mod import;
mod log;
mod new;
mod pages;
mod polar;
mod polar_arguments;
mod profile;
mod progress;
mod report;
mod run;
mod schema;
mod signals;
mod sweep;
mod threads;
mod trim_polar;
mod validate;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::run::{Fault, caught, record_panics};
use failure::Failure;
use log::say;

/// What `--help` says about them.
const EXIT_CODES: &str = "Exit codes: 0 done, 1 a gate of `validate` fails or `--strict` finds results without support, 2 bad case or usage, 3 no usable device, \
    20 diverged or not in balance, 70 internal fault, 73 the folder holds another run, 74 output failed or out of memory, 75 interrupted, 130 interrupted without a checkpoint";

/// Fluid–structure solver for parachutes and paragliders.
#[derive(Debug, Parser)]
#[command(version, about, arg_required_else_help = true, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a case to its end or to steady state.
    Run(run::RunArguments),
    /// Begin a run from the state that another one has come to, with other outputs or another length.
    Restart(run::RestartArguments),
    /// Run a case once for each value of some of its keys, and set the results side by side.
    Sweep(sweep::SweepArguments),
    /// Forces of a wing over its angle of attack, or speed, sink and line loads of a glider over brake, bar and mass.
    Polar(polar_arguments::PolarArguments),
    /// Validate a case; print the plan, its sizes, and what it skips.
    Check(check::CheckArguments),
    /// Write the page of a finished run, report.html, anew.
    Report(report::ReportArguments),
    /// Set the results of finished runs side by side, as a table and as a page.
    Compare(report::CompareArguments),
    /// List the results that a run of a case has, those that it prints first on top.
    Results(explain::ResultsArguments),
    /// Tell what a key of case files, a column or a result means.
    Explain(explain::ExplainArguments),
    /// Print a shipped case to start from; without a name, list them.
    New(new::NewArguments),
    /// Bring in a wing of another program: LEparagliding's `leparagliding.txt`, or XFLR5's `.xwimp`.
    Import(import::ImportArguments),
    /// Print completions for a shell.
    Completions(pages::CompletionsArguments),
    /// Print the manual page.
    Man,
    /// Print the JSON schema of case files, which editors complete keys from.
    Schema(schema::SchemaArguments),
    /// Measure error against seconds over resolution, Mach number, operator, storage and engine.
    Bench(bench::BenchArguments),
    /// List the adapters of this machine, and which one `auto` takes.
    Devices(devices::DevicesArguments),
    /// Compute problems with known answers; exit code 1 if a gate fails.
    Validate(validate::ValidateArguments),
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let code = if error.use_stderr() {
                exit::BAD_CASE
            } else {
                0
            };
            // Printing help to a closed pipe is not worth a failure.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    record_panics();
    let result = caught(|| dispatch(&cli.command));
    ExitCode::from(told(result))
}

fn dispatch(command: &Command) -> Result<u8, Failure> {
    match command {
        Command::Run(arguments) => run::run(arguments),
        Command::Restart(arguments) => run::restart(arguments),
        Command::Sweep(arguments) => sweep::sweep(arguments),
        Command::Polar(arguments) => polar::polar(arguments),
        Command::Check(arguments) => check::check(arguments),
        Command::Report(arguments) => report::report(arguments),
        Command::Compare(arguments) => report::compare(arguments),
        Command::Results(arguments) => explain::results(arguments),
        Command::Explain(arguments) => explain::explain(arguments),
        Command::New(arguments) => new::new(arguments),
        Command::Import(arguments) => import::import(arguments),
        Command::Completions(arguments) => pages::completions(arguments, Cli::command()),
        Command::Man => pages::man(&Cli::command()),
        Command::Schema(arguments) => schema::schema(arguments),
        Command::Bench(arguments) => bench::bench(arguments),
        Command::Devices(arguments) => devices::devices(arguments),
        Command::Validate(arguments) => validate::validate(arguments),
    }
}

/// Tells why a command failed, if it did.
fn told(result: Result<Result<u8, Failure>, Fault>) -> u8 {
    let result = match result {
        Ok(result) => result,
        Err(fault) => {
            say(&format!("error: {fault}"));
            if let Some(backtrace) = fault.backtrace {
                say(&backtrace);
            }
            return exit::FAULT;
        }
    };
    match result {
        Ok(code) => code,
        Err(Failure::Case(error)) => {
            say(&format!("{:?}", miette::Report::new(*error)));
            exit::BAD_CASE
        }
        Err(Failure::NoDevice(message)) => {
            say(&format!("error: {message}"));
            exit::NO_DEVICE
        }
        Err(Failure::Other(code, message)) => {
            say(&format!("error: {message}"));
            code
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_of_the_program_has_its_own_code() {
        assert_eq!(told(caught(|| panic!("this is a test"))), exit::FAULT);
        assert_eq!(told(caught(|| Ok(3))), 3);
        assert_eq!(
            run::exit_code(&crate::run::RunError::Fault(Box::default())),
            exit::FAULT
        );
    }
}
