//! `ripstop validate [FILTER]`

use std::path::PathBuf;

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use super::engine::{self, Engine};
use super::exit;
use super::failure::Failure;
use super::log::emit;
use super::progress::Progress;
use super::signals::requests;
use super::threads;
use crate::plan::Precision;
use crate::validate::{self, Order, PROBLEMS, Report, Stop};

#[derive(Debug, Args)]
pub(super) struct ValidateArguments {
    /// Compute only the problem of this name, or those whose name contains this text.
    filter: Option<String>,
    /// Real sizes and the gates meant for them, instead of the quick set of about a minute and a half.
    #[arg(long)]
    full: bool,
    /// Engine for the air.
    #[arg(long, value_enum, default_value = "auto")]
    engine: Engine,
    /// Take the adapter whose name contains this text (see `ripstop devices`); implies --engine gpu.
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    adapter: Option<String>,
    /// Floating-point type of the air.
    #[arg(long, value_enum, default_value = "f32")]
    precision: Precision,
    /// Also write the rows as JSON.
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
}

pub(super) fn validate(arguments: &ValidateArguments) -> Result<u8, Failure> {
    threads::start(0)?;
    let problems = validate::chosen(arguments.filter.as_deref());
    if problems.is_empty() {
        let names: Vec<&str> = PROBLEMS.iter().map(|problem| problem.name).collect();
        return Err(Failure::Other(
            exit::BAD_CASE,
            format!(
                "no problem has `{}` in its name; there are {}",
                arguments.filter.as_deref().unwrap_or_default(),
                names.join(", ")
            ),
        ));
    }
    let (placement, device) = engine::air_alone(
        arguments.engine,
        arguments.adapter.as_deref(),
        arguments.precision,
    )?;
    let order = Order {
        problems,
        full: arguments.full,
        placement,
        device,
    };
    let interrupt = requests("the validation").stop;
    let write = |report: &Report| match &arguments.out {
        Some(path) => report
            .write(path)
            .map_err(|error| Failure::Other(exit::OUTPUT_FAILED, error.to_string())),
        None => Ok(()),
    };
    // A file that cannot be written is noticed before anything is computed.
    write(&Report::new(
        order.full,
        order.placement,
        order.device.as_deref(),
    ))?;
    let mut progress = Progress::new();
    let (report, end) = validate::validate(&order, &interrupt, &mut progress);
    progress.finish();
    emit(&report.table())?;
    write(&report)?;
    match end {
        Err(Stop::Device(error)) => Err(error.into()),
        Err(Stop::Interrupted) => Ok(exit::INTERRUPTED),
        Err(Stop::Refused(why)) => Err(Failure::Other(exit::BAD_CASE, why)),
        Ok(()) if report.holds() => Ok(0),
        Ok(()) => Ok(exit::GATE_FAILED),
    }
}
