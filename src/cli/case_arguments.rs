//! A case as the command line names it: read, checked, planned, and refused where it does not fit.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::engine::EngineArguments;
use super::exit;
use super::failure::Failure;
use super::threads;
use crate::case::{self, Case, CaseError, Choices, ExaminedMesh, Problem, did_you_mean};
use crate::gpu::Device;
use crate::lattice::nest::Level;
use crate::measure;
use crate::plan::{MemoryRefusal, Plan, Precision, Sizes, free_memory};

/// How a case is read; shared by the commands that take one.
#[derive(Debug, Clone, Args)]
pub(super) struct CaseArguments {
    /// Case file (TOML).
    case: PathBuf,
    /// Variant of the case, such as `quick`.
    #[arg(long)]
    variant: Option<String>,
    /// Change a key of the case; may be given several times.
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    overrides: Vec<String>,
    /// How fine a case by its design is computed: short for `--set design.quality=…`.
    #[arg(long, value_enum)]
    quality: Option<QualityArgument>,
    #[command(flatten)]
    engine: EngineArguments,
    /// CPU threads; 0 takes all cores.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
}

/// How fine a design is computed.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum QualityArgument {
    /// 16 cells per D_0 and mean drag to 10 %; wings 14 edges along the chord.
    Draft,
    /// 24 cells and 5 %; 24 edges.
    Normal,
    /// 32 cells and 3 %; 40 edges.
    Fine,
}

impl QualityArgument {
    const fn as_override(self) -> &'static str {
        match self {
            Self::Draft => "design.quality=draft",
            Self::Normal => "design.quality=normal",
            Self::Fine => "design.quality=fine",
        }
    }
}

/// A case ready to run.
pub(super) struct Prepared {
    pub(super) case: Case,
    pub(super) plan: Plan,
    pub(super) device: Option<Arc<Device>>,
    /// The plan without the device, where the program chose it by itself.
    pub(super) fallback: Option<Plan>,
}

impl CaseArguments {
    /// Reads and checks the case, plans it, and refuses what does not fit.
    pub(super) fn prepare(&self) -> Result<Prepared, Failure> {
        self.plan(self.load(&[])?)
    }

    /// Reads and checks the case, with more `key.path=value` behind those of the command line.
    pub(super) fn load(&self, more: &[String]) -> Result<Case, Failure> {
        let case = case::load(&self.case, &self.choices(more))?;
        refuse_unknown_comparisons(&case)?;
        Ok(case)
    }

    /// Reads and examines the meshes of the case, whether they would be refused or not.
    pub(super) fn examine_meshes(&self) -> Result<Vec<ExaminedMesh>, Box<CaseError>> {
        case::examine_meshes(&self.case, &self.choices(&[]))
    }

    fn choices(&self, more: &[String]) -> Choices {
        Choices {
            variant: self.variant.clone(),
            overrides: (self.quality.iter())
                .map(|quality| quality.as_override().to_owned())
                .chain(self.overrides.iter().chain(more).cloned())
                .collect(),
        }
    }

    /// Refuses what asks for a device where the case holds a wing by itself, of which no device computes anything.
    pub(super) fn refuse_device_of_bare_wing(&self, case: &Case) -> Result<(), Failure> {
        match (&case.scene.bare_wing, self.engine.of_no_use_by_itself()) {
            (Some(_), Some(option)) => Err(Failure::Other(
                exit::BAD_CASE,
                format!(
                    "{option} has no use with {}: a wing by itself is computed on the host, in double precision",
                    case.name
                ),
            )),
            _ => Ok(()),
        }
    }

    /// CPU threads; 0 takes all cores.
    pub(super) fn thread_count(&self) -> usize {
        self.threads.into()
    }

    /// Plans a case, and refuses what does not fit.
    pub(super) fn plan(&self, case: Case) -> Result<Prepared, Failure> {
        refuse_bare_wing(&case)?;
        threads::start(self.threads.into())?;
        // Before any device is asked for what none can hold.
        Sizes::new(&case.scene, &self.engine.precision.into())
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
        let air = case.scene.air.as_ref();
        let needs = format!(
            "it needs {:.1} GB{}",
            refusal.needed as f64 / 1e9,
            air.map_or_else(String::new, |air| {
                let cells = |level: &Level| level.cells.iter().map(|n| *n as u64).product::<u64>();
                match &air.levels()[..] {
                    [only] => format!(
                        " for {} x {} x {} cells",
                        only.cells[0], only.cells[1], only.cells[2]
                    ),
                    levels => format!(
                        " for {} cells in {} lattices",
                        levels.iter().map(cells).sum::<u64>(),
                        levels.len()
                    ),
                }
            })
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
                match (air, self.engine.precision) {
                    (None, _) => "use a coarser mesh of the structure",
                    (Some(_), Precision::F32 | Precision::F16Storage) => "choose larger cells (resolution.cells_per_diameter or cell_size_m), or a smaller tunnel",
                    (Some(_), Precision::F64) => "choose larger cells (resolution.cells_per_diameter or cell_size_m), a smaller tunnel, or --precision f32",
                },
            )))
    }
}

/// Refuses a case in which there is nothing to run.
pub(super) fn refuse_bare_wing(case: &Case) -> Result<(), Failure> {
    if case.scene.bare_wing.is_none() {
        return Ok(());
    }
    Err(Failure::Case(case.error(Problem::new(
        "aero",
        format!(
            "in {}: there is nothing to run: the case holds a wing by itself",
            case.name
        ),
        "`ripstop polar CASE.toml` computes its forces over the angle of attack",
    ))))
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
            format!(
                "{}`ripstop results` lists them: {}",
                did_you_mean(&comparison.quantity, names.iter().map(String::as_str)),
                names.join(", ")
            ),
        )))),
    }
}
