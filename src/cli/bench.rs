//! `ripstop bench [FILTER]`

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use super::engine::Engine;
use super::exit;
use super::failure::Failure;
use super::log::emit;
use super::progress::Progress;
use super::signals::requests;
use super::threads;
use crate::bench::{
    self, Stop, Watch, aerodynamics, bluff_bodies, coupling, device, fabric, levels, stability,
    work_precision,
};
use crate::gpu::{AdapterChoice, Device};
use crate::lattice::Operator;
use crate::output::prepare_directory;
use crate::plan::{AirPlacement, Precision, Storage};

#[derive(Debug, Args)]
pub(super) struct BenchArguments {
    /// Only problems with this text in their name. Some run only when named. `stability` maps where operators break down (`stability-at-bodies` is its second part alone). `bluff-bodies` follows
    /// bodies over cells, Reynolds numbers and speeds on the lattice. `aerodynamics` measures panels, `levels` boxes of finer cells, `device` a device. `fabric` solves Hencky's disc and an
    /// airbag. `coupling-schemes` and `coupling-passes` compare schemes of coupling, and `light-canopies` takes ever lighter sheets.
    filter: Option<String>,
    /// More and larger sizes.
    #[arg(long)]
    full: bool,
    /// Engines to compare: CPU threads, a device, or both where there is a real GPU.
    #[arg(long, value_enum, default_value = "auto")]
    engine: Engine,
    /// Take the adapter whose name contains this text (see `ripstop devices`).
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    adapter: Option<String>,
    /// Of `device`: no row begins that would not end within this time [default: 60, with --full 480].
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    seconds: Option<u64>,
    /// Of `device`: one table alone, beside latencies and copying [default: all].
    #[arg(long, value_enum, value_name = "NAME")]
    table: Option<device::Table>,
    /// Of `stability` and `stability-at-bodies`: one operator, by its name in case files [default: all].
    #[arg(long, value_name = "NAME", value_parser = operator)]
    operator: Option<Operator>,
    /// Folder for tables and plots.
    #[arg(long, default_value = "bench")]
    out: PathBuf,
}

/// An operator by its name.
fn operator(name: &str) -> Result<Operator, String> {
    let names = || Operator::ALL.map(Operator::name).join(", ");
    let found = Operator::ALL.into_iter().find(|one| one.name() == name);
    found.ok_or_else(|| format!("there are {}", names()))
}

const STABILITY: &str = "stability";
const STABILITY_AT_BODIES: &str = "stability-at-bodies";
const BLUFF_BODIES: &str = "bluff-bodies";
const AERODYNAMICS: &str = "aerodynamics";
const FABRIC: &str = "fabric";
const DEVICE: &str = "device";
const LEVELS: &str = "levels";

type Comparison =
    fn(bool, &bench::Engine, &Path, &mut Watch) -> Result<(Vec<coupling::Point>, String), Stop>;

/// Comparisons of coupling, which run only when named.
const COUPLING: [(&str, Comparison); 3] = [
    ("coupling-schemes", coupling::schemes_compared),
    ("coupling-passes", coupling::passes_compared),
    ("light-canopies", coupling::light_canopies),
];

impl From<Stop> for Failure {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Interrupted => Self::Other(exit::INTERRUPTED, "interrupted".to_owned()),
            Stop::Device(error) => error.into(),
            Stop::Refused(_) => Self::Other(exit::BAD_CASE, stop.to_string()),
            Stop::Output(_) | Stop::Plot(_) => Self::Other(exit::OUTPUT_FAILED, stop.to_string()),
        }
    }
}

pub(super) fn bench(arguments: &BenchArguments) -> Result<u8, Failure> {
    threads::start(0)?;
    let engines = engines(arguments)?;
    let filter = arguments.filter.as_deref();
    let named = |name: &str| filter.is_some_and(|filter| name.contains(filter));
    let maps_stability = named(STABILITY);
    let maps_bodies = named(STABILITY_AT_BODIES);
    let follows_bodies = named(BLUFF_BODIES);
    let comparisons: Vec<_> = COUPLING.iter().filter(|(name, _)| named(name)).collect();
    let measures = work_precision::names().any(|name| filter.is_none_or(|f| name.contains(f)));
    let flies_wings = named(AERODYNAMICS);
    let loads_fabric = named(FABRIC);
    let measures_device = named(DEVICE);
    let measures_levels = named(LEVELS);
    if !maps_stability
        && !maps_bodies
        && !follows_bodies
        && !flies_wings
        && !loads_fabric
        && !measures_device
        && !measures_levels
        && !measures
        && comparisons.is_empty()
    {
        let names: Vec<&str> = work_precision::names()
            .chain([
                STABILITY,
                STABILITY_AT_BODIES,
                BLUFF_BODIES,
                AERODYNAMICS,
                FABRIC,
                DEVICE,
                LEVELS,
            ])
            .chain(COUPLING.map(|(name, _)| name))
            .collect();
        return Err(Failure::Other(
            exit::BAD_CASE,
            format!(
                "no benchmark has `{}` in its name; there are {}",
                filter.unwrap_or_default(),
                names.join(", ")
            ),
        ));
    }
    prepare_directory(&arguments.out).map_err(Stop::Output)?;
    let interrupt = requests("the benchmark").stop;
    let mut progress = Progress::new();
    let mut watch = Watch {
        interrupt: &interrupt,
        observer: &mut progress,
    };
    // Bodies and schemes of coupling are computed in single precision, on CPU threads if they take part.
    let single = engines.iter().find(|engine| {
        !engine.placement.is_in_sixteen_bits()
            && engine.placement != AirPlacement::Cpu(Precision::F64)
    });
    let mut text = String::new();
    if measures {
        let (points, summary) =
            work_precision::measure(filter, arguments.full, &engines, &arguments.out, &mut watch)?;
        text.push_str(&summary);
        text.push_str(&format!("{} settings measured\n", points.len()));
    }
    if maps_stability {
        let points = stability::map(&engines, arguments.operator, &arguments.out, &mut watch)?;
        text.push_str(&stability::table(&points));
    }
    if maps_bodies && let Some(engine) = single {
        let points =
            stability::map_at_bodies(engine, arguments.operator, &arguments.out, &mut watch)?;
        text.push_str(&stability::table_at_bodies(&points));
    }
    if follows_bodies && let Some(engine) = single {
        let rows = bluff_bodies::matrix(arguments.full, engine, &arguments.out, &mut watch)?;
        text.push_str(&format!(
            "{}\n{}",
            engine.name(),
            bluff_bodies::table(&rows)
        ));
    }
    if flies_wings {
        let points = aerodynamics::measure(arguments.full, &arguments.out, &mut watch)?;
        text.push_str(&aerodynamics::table(&points));
    }
    if loads_fabric {
        let points = fabric::measure(arguments.full, &engines, &arguments.out, &mut watch)?;
        text.push_str(&fabric::table(&points));
    }
    if measures_levels {
        let (_, table) = levels::measure(arguments.full, &engines, &arguments.out, &mut watch)?;
        text.push_str(&table);
    }
    if measures_device {
        text.push_str(&measure_device(arguments, &engines, &mut watch)?);
    }
    for (_, compare) in comparisons {
        if let Some(engine) = single {
            let (_, table) = compare(arguments.full, engine, &arguments.out, &mut watch)?;
            text.push_str(&format!("{}\n{table}", engine.name()));
        }
    }
    progress.finish();
    text.push_str(&format!("tables and plots: {}\n", arguments.out.display()));
    emit(&text)?;
    Ok(0)
}

fn measure_device(
    arguments: &BenchArguments,
    engines: &[bench::Engine],
    watch: &mut Watch,
) -> Result<String, Failure> {
    let Some(opened) = engines.iter().find_map(|engine| engine.device.as_ref()) else {
        return Err(Failure::Other(
            exit::NO_DEVICE,
            "the benchmark `device` needs one, and there is no GPU; --engine gpu or --adapter NAME takes a software adapter, too"
                .to_owned(),
        ));
    };
    let usual = if arguments.full { 480 } else { 60 };
    let extent = device::Extent {
        full: arguments.full,
        limit: Duration::from_secs(arguments.seconds.unwrap_or(usual)),
        table: arguments.table,
    };
    Ok(device::measure(opened, extent, &arguments.out, watch)?)
}

/// Every precision of every engine asked for.
fn engines(arguments: &BenchArguments) -> Result<Vec<bench::Engine>, Failure> {
    let choice = match (arguments.engine, &arguments.adapter) {
        (Engine::Cpu, Some(_)) => {
            return Err(Failure::Other(
                exit::BAD_CASE,
                "--adapter has no use with --engine cpu".to_owned(),
            ));
        }
        (Engine::Cpu, None) => None,
        (_, Some(name)) => Some(AdapterChoice::Named(name.clone())),
        (Engine::Gpu, None) => Some(AdapterChoice::Any),
        (Engine::Auto, None) => Some(AdapterChoice::Hardware),
    };
    let mut engines = Vec::new();
    if arguments.engine != Engine::Gpu {
        let precisions = [Precision::F64, Precision::F32, Precision::F16Storage];
        engines.extend(precisions.map(bench::Engine::cpu));
    }
    let device = match choice.map(|choice| Device::open(&choice)) {
        None => return Ok(engines),
        // Only what was asked for has to be there.
        Some(Err(_)) if arguments.engine == Engine::Auto && arguments.adapter.is_none() => {
            return Ok(engines);
        }
        Some(opened) => opened?,
    };
    let mut storages = vec![Storage::F32];
    if device.require_f16().is_ok() {
        storages.push(Storage::F16);
    }
    engines.extend(storages.into_iter().map(|storage| bench::Engine {
        placement: AirPlacement::Gpu(storage),
        device: Some(device.clone()),
    }));
    Ok(engines)
}
