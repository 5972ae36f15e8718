//! The command line: one file per command, exit codes in one place.

mod bench;
mod check;
mod devices;
mod engine;
mod log;
mod new;
mod profile;
mod progress;
mod run;
mod schema;
mod signals;
mod sweep;
mod validate;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Args, Parser, Subcommand};

use crate::case::{self, Case, CaseError, Choices, ExaminedMesh, Problem};
use crate::gpu::Device;
use crate::measure;
use crate::plan::{MemoryRefusal, Plan, Precision, Sizes, free_memory};
use crate::run::{Fault, caught, record_panics};
use log::say;

/// What `--help` says about them.
const EXIT_CODES: &str = "Exit codes: 0 done, 1 a gate of `validate` fails or `--strict` finds results without support, 2 bad case or usage, 3 no usable device, \
    20 diverged or not in balance, 70 internal fault, 73 the folder holds another run, 74 output failed or out of memory, 75 interrupted, 130 interrupted without a checkpoint";

/// Exit codes.
pub mod exit {
    /// A gate of `ripstop validate` fails, or `--strict` finds results that are not supported.
    pub const GATE_FAILED: u8 = 1;
    /// Bad case or usage.
    pub const BAD_CASE: u8 = 2;
    /// No usable device.
    pub const NO_DEVICE: u8 = 3;
    /// The run diverged, its static equilibrium was not reached, or steps of the fabric were not solved.
    pub const DIVERGED: u8 = 20;
    /// The program failed by a fault of its own; what was kept is told.
    pub const FAULT: u8 = 70;
    /// The folder holds another run, one that is not over, or one that goes on.
    pub const OCCUPIED: u8 = 73;
    /// A file could not be written, or memory ran out.
    pub const OUTPUT_FAILED: u8 = 74;
    /// Interrupted; what was computed is written and can be resumed.
    pub const INTERRUPTED: u8 = 75;
    /// Interrupted at once, with nothing to resume from.
    pub const ABORTED: u8 = 130;
}

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
    /// Validate a case; print the plan, its sizes, and what it skips.
    Check(check::CheckArguments),
    /// Print a shipped case to start from.
    New(new::NewArguments),
    /// Print the JSON schema of case files, which editors complete keys from.
    Schema(schema::SchemaArguments),
    /// Measure error against seconds over resolution, Mach number, operator, storage and engine.
    Bench(bench::BenchArguments),
    /// List the adapters of this machine, and which one `auto` takes.
    Devices,
    /// Compute problems with known answers; exit code 1 if a gate fails.
    Validate(validate::ValidateArguments),
}

/// How a case is read; shared by the commands that take one.
#[derive(Debug, Args)]
struct CaseArguments {
    /// Case file (TOML).
    case: PathBuf,
    /// Variant of the case, such as `quick`.
    #[arg(long)]
    variant: Option<String>,
    /// Change a key of the case; may be given several times.
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    engine: engine::EngineArguments,
    /// CPU threads; 0 takes all cores.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
}

/// A case ready to run.
struct Prepared {
    case: Case,
    plan: Plan,
    device: Option<Arc<Device>>,
    /// The plan without the device, where the program chose it by itself.
    fallback: Option<Plan>,
}

/// What ends a command early.
enum Failure {
    Case(Box<CaseError>),
    NoDevice(String),
    Other(u8, String),
}

impl From<Box<CaseError>> for Failure {
    fn from(error: Box<CaseError>) -> Self {
        Self::Case(error)
    }
}

impl CaseArguments {
    /// Reads and checks the case, plans it, and refuses what does not fit.
    fn prepare(&self) -> Result<Prepared, Failure> {
        self.plan(self.load(&[])?)
    }

    /// Reads and checks the case, with more `key.path=value` behind those of the command line.
    fn load(&self, more: &[String]) -> Result<Case, Failure> {
        let case = case::load(&self.case, &self.choices(more))?;
        refuse_unknown_comparisons(&case)?;
        Ok(case)
    }

    /// Reads and examines the meshes of the case, whether they would be refused or not.
    fn examine_meshes(&self) -> Result<Vec<ExaminedMesh>, Box<CaseError>> {
        case::examine_meshes(&self.case, &self.choices(&[]))
    }

    fn choices(&self, more: &[String]) -> Choices {
        Choices {
            variant: self.variant.clone(),
            overrides: [&self.overrides[..], more].concat(),
        }
    }

    /// Plans a case, and refuses what does not fit.
    fn plan(&self, case: Case) -> Result<Prepared, Failure> {
        if self.threads > 0 {
            // Fails only if a pool exists already, as from the second run of a sweep on.
            let _ = rayon::ThreadPoolBuilder::new()
                .num_threads(usize::from(self.threads))
                .build_global();
        }
        // Before any device is asked for what none can hold.
        Sizes::new(&case.scene, &self.engine.precision.on_cpu().into())
            .fit_into(None)
            .map_err(|refusal| self.too_large(&case, refusal))?;
        let placed = self.engine.place(&case.scene)?;
        let plan = Plan::new(&case.scene, placed.placement);
        let fallback = placed
            .fallback
            .map(|placement| Plan::new(&case.scene, placement));
        plan.sizes
            .fit_into(free_memory())
            .map_err(|refusal| self.too_large(&case, refusal))?;
        Ok(Prepared {
            case,
            plan,
            device: placed.device,
            fallback,
        })
    }

    fn too_large(&self, case: &Case, refusal: MemoryRefusal) -> Failure {
        let air = case.scene.air.map(|air| air.cells);
        let needs = format!(
            "it needs {:.1} GB{}",
            refusal.needed as f64 / 1e9,
            air.map_or_else(String::new, |[x, y, z]| format!(
                " for {x} x {y} x {z} cells"
            ))
        );
        let limit = refusal.free.map_or_else(
            || "more than 4 294 967 294 cells cannot be addressed".to_owned(),
            |free| {
                format!(
                    "of {:.1} GB free memory at most 80 % may be taken",
                    free as f64 / 1e9
                )
            },
        );
        Failure::Case(case.error(Problem::new(
                if air.is_some() { "resolution" } else { "structure" },
                format!("in {}: the case is too large for this machine: {needs}, and {limit}", case.name),
                match (air, self.engine.precision.on_cpu()) {
                    (None, _) => "use a coarser mesh of the structure",
                    (Some(_), Precision::F32) => "choose larger cells (resolution.cells_per_diameter or cell_size_m), or a smaller tunnel",
                    (Some(_), Precision::F64) => "choose larger cells (resolution.cells_per_diameter or cell_size_m), a smaller tunnel, or --precision f32",
                },
            )))
    }
}

/// Refuses comparisons with results that a run of the case does not have.
fn refuse_unknown_comparisons(case: &Case) -> Result<(), Failure> {
    if case.scene.comparisons.is_empty() {
        return Ok(());
    }
    let names = measure::result_names(&case.scene);
    let unknown = |c: &&case::scene::Comparison| !names.contains(&c.quantity);
    match case.scene.comparisons.iter().find(unknown) {
        None => Ok(()),
        Some(comparison) => Err(Failure::Case(case.error(Problem::new(
            format!("comparison.{}", comparison.quantity),
            format!(
                "in {}: this case has no result `{}` to compare",
                case.name, comparison.quantity
            ),
            format!("its results are: {}", names.join(", ")),
        )))),
    }
}

/// Writes to standard output. A reader that has gone away is no failure; a full disk behind a redirection is.
fn emit(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::Other(
            exit::OUTPUT_FAILED,
            format!("cannot write to standard output: {error}"),
        )),
        _ => Ok(()),
    }
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
        Command::Check(arguments) => check::check(arguments),
        Command::New(arguments) => new::new(arguments),
        Command::Schema(arguments) => schema::schema(arguments),
        Command::Bench(arguments) => bench::bench(arguments),
        Command::Devices => devices::devices(),
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
