//! Which engine computes what: turns `--engine`, `--cloth`, `--adapter` and `--precision` into a placement and an open device.

use std::sync::{Arc, OnceLock};

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, ValueEnum};

use super::exit;
use super::failure::Failure;
use super::log::say;
use crate::bench::pace;
use crate::case::Scene;
use crate::case::coupling::{Friction, Scheme};
use crate::gpu::adapters::{adapters, chosen, has_gpu};
use crate::gpu::cloth::largest_buffer_bytes;
use crate::gpu::{AdapterChoice, AdapterKind, Device, DeviceError};
use crate::plan::{
    AirPlacement, ClothPlacement, Placement, Precision, Sizes, capabilities, place_markers,
    steps_are_left_to_host, steps_take_multigrid,
};

/// Opens a device, and says which better ones did not open.
fn open(choice: &AdapterChoice) -> Result<Arc<Device>, DeviceError> {
    let device = Device::open(choice)?;
    for refused in device.passed_over() {
        say(&format!(
            "note: {refused} does not open; the device is {}",
            device.info().name
        ));
    }
    Ok(device)
}

/// Nodes from which `--cloth auto` puts the fabric on a real GPU where the device decides between evaluations, in steps in air with block-Jacobi. Two canopies
/// of 674 nodes took 0.9 and 1.2 times as long on an NVIDIA H100 as with fabric on the host, one of 2 706 nodes half as long
/// (docs/results/2026-11-27-fabric-on-the-device.md). In between it is an estimate.
const CLOTH_NODES_IN_AIR: u64 = 1_000;

/// The same elsewhere, where the host drives the device. An evaluation of 10 201 nodes takes the host 1.1 ms and an NVIDIA H100 0.5 ms
/// (docs/results/2026-11-26-graphics-card.md); below it is an estimate. On a software adapter the host is faster at every size, 25 times at 289 nodes and
/// 2.4 times at 66 049 (`benches/results/device-lavapipe.json`).
const CLOTH_NODES: u64 = 4_000;

/// Where the air is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Engine {
    /// A real GPU if there is one, else CPU threads.
    Auto,
    /// CPU threads.
    Cpu,
    /// A device through wgpu; a software adapter if there is no GPU.
    Gpu,
}

/// Where the fabric is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ClothChoice {
    /// On a real GPU from 1 000 nodes on, or 4 000 without air or with multigrid in steps; else on the host, as is slack fabric in light wind.
    Auto,
    /// Host memory, f64.
    Host,
    /// A device, a software adapter if there is no GPU.
    Device,
}

const F64_ON_DEVICE: &str = "--precision f64 needs --engine cpu: devices compute in f32";

const F16_AND_FRICTION: &str = "--precision f16-storage rounds away what friction = \"model\" takes from the air in a step: take f32, or another friction";

/// Choice of engines.
#[derive(Debug, Clone, Args)]
pub(super) struct EngineArguments {
    /// Engine for the air.
    #[arg(long, value_enum, default_value = "auto")]
    engine: Engine,
    /// Where the fabric is solved.
    #[arg(long, value_enum, default_value = "auto")]
    cloth: ClothChoice,
    /// Take the adapter whose name contains this text (see `ripstop devices`); implies --engine gpu.
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    adapter: Option<String>,
    /// Floating-point type of the air.
    #[arg(long, value_enum, default_value = "f32")]
    pub precision: Precision,
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        Self::NoDevice(error.to_string())
    }
}

/// Who computes what, with the device if one takes part.
pub(super) struct Placed {
    pub placement: Placement,
    pub device: Option<Arc<Device>>,
    /// Taken if the device turns out too small: only where the program chose it by itself.
    pub fallback: Option<Placement>,
}

impl EngineArguments {
    /// The option that asks for what has no use where a wing is computed by itself: on the host, in double precision.
    pub(super) fn of_no_use_by_itself(&self) -> Option<&'static str> {
        [
            (self.engine == Engine::Gpu, "--engine gpu"),
            (self.adapter.is_some(), "--adapter"),
            (self.cloth == ClothChoice::Device, "--cloth device"),
            (
                self.precision == Precision::F16Storage,
                "--precision f16-storage",
            ),
        ]
        .into_iter()
        .find_map(|(asked, option)| asked.then_some(option))
    }

    /// Opens a device if one is to take part, and places air and fabric.
    pub(super) fn place(&self, scene: &Scene) -> Result<Placed, Failure> {
        let named = self
            .adapter
            .as_ref()
            .map(|name| AdapterChoice::Named(name.clone()));
        let engine = match (self.engine, &named) {
            (Engine::Auto, Some(_)) => Engine::Gpu,
            (engine, _) => engine,
        };
        let misuse = |what: &str| Err(Failure::Other(exit::BAD_CASE, what.to_owned()));
        if engine == Engine::Gpu && self.precision == Precision::F64 {
            return misuse(F64_ON_DEVICE);
        }
        let modelled = (scene.friction.as_ref()).is_some_and(|f| f.has(Friction::Model));
        if modelled && self.precision == Precision::F16Storage {
            return misuse(F16_AND_FRICTION);
        }
        if engine == Engine::Cpu && named.is_some() && self.cloth != ClothChoice::Device {
            return misuse(
                "--adapter has no use with --engine cpu, unless --cloth device puts the fabric there",
            );
        }
        if self.cloth == ClothChoice::Device && scene.body.is_none() {
            return misuse("--cloth device: the case has no [structure]; leave it out");
        }
        let lacking = capabilities::lacking_on_device(scene);
        if let (ClothChoice::Device, Some(lacking)) = (self.cloth, &lacking) {
            return misuse(&lacking.to_string());
        }
        let on_request = named.unwrap_or(AdapterChoice::Any);
        if engine == Engine::Gpu && scene.air.is_none() && self.cloth != ClothChoice::Device {
            // Whoever names an adapter must hear that there is none of that name.
            if chosen(&adapters(), &on_request).is_none() {
                open(&on_request)?;
            }
            say(
                "note: the case has no [air], so --engine and --adapter change nothing; --cloth device puts the fabric on a device",
            );
        }
        let mut device = match engine {
            _ if scene.air.is_none() => None,
            Engine::Cpu => None,
            Engine::Gpu => Some(open(&on_request)?),
            Engine::Auto => match self.precision {
                Precision::F64 => None,
                precision => automatic(scene, precision),
            },
        };
        let air = match device {
            Some(_) => AirPlacement::Gpu(self.precision.storage()),
            None => AirPlacement::Cpu(self.precision),
        };
        let nodes = scene
            .body
            .as_ref()
            .map_or(0, |body| body.structure.node_count() as u64);
        let cloth_on_device = match self.cloth {
            ClothChoice::Host => false,
            ClothChoice::Auto if lacking.is_some() || steps_are_left_to_host(scene) => false,
            ClothChoice::Device => {
                if device.is_none() {
                    device = Some(open(&on_request)?);
                }
                true
            }
            ClothChoice::Auto => {
                let enough = if scene.air.is_some() && !steps_take_multigrid(scene) {
                    CLOTH_NODES_IN_AIR
                } else {
                    CLOTH_NODES
                };
                let many = nodes >= enough;
                if many && device.is_none() && engine == Engine::Auto {
                    // An integrated one that the air was not given to is no better for fabric.
                    let opened = open(&AdapterChoice::Hardware).ok();
                    device = opened.filter(|d| {
                        scene.air.is_none() || d.info().kind != AdapterKind::Integrated
                    });
                }
                many && device.as_ref().is_some_and(|d| {
                    d.info().kind != AdapterKind::Software && fabric_fits(scene, d).is_ok()
                })
            }
        };
        let kind = device.as_ref().map(|d| d.info().kind);
        let placement = Placement {
            air,
            cloth: if cloth_on_device {
                ClothPlacement::Device
            } else {
                ClothPlacement::Host
            },
            device: device.as_ref().map(|d| d.info().name.clone()),
            shared_memory: matches!(kind, Some(AdapterKind::Software | AdapterKind::Integrated)),
        };
        if let (AirPlacement::Gpu(_), Some(device)) = (air, &device) {
            stores(self.precision, device)?;
            air_fits(scene, &placement, device)?;
        }
        if let (true, Some(device)) = (cloth_on_device, &device) {
            fabric_fits(scene, device)?;
        }
        let chosen_by_itself = engine == Engine::Auto && self.cloth != ClothChoice::Device;
        Ok(Placed {
            fallback: (chosen_by_itself && device.is_some()).then(|| self.precision.into()),
            placement,
            device,
        })
    }
}

/// The best real GPU that can hold the air; `None`, with a word why, where the CPU is taken although there is a GPU.
fn automatic(scene: &Scene, precision: Precision) -> Option<Arc<Device>> {
    if !has_gpu() {
        return None;
    }
    let placement = Placement {
        air: AirPlacement::Gpu(precision.storage()),
        ..Placement::from(precision)
    };
    let opened = open(&AdapterChoice::Hardware)
        .and_then(|device| stores(precision, &device).map(|()| device))
        .and_then(|device| air_fits(scene, &placement, &device).map(|()| device))
        .map_err(|error| error.to_string())
        .and_then(|device| match device.info().kind {
            // It shares the CPU's memory, which bounds both.
            AdapterKind::Integrated => {
                let slower = SLOWER.get_or_init(|| {
                    let paces = (pace::of_device(&device), pace::of_cpu());
                    slower_than_cpu(&device.info().name, paces)
                });
                slower.clone().map_or(Ok(device), Err)
            }
            _ => Ok(device),
        });
    opened
        .inspect_err(|why| say(&format!("note: the CPU computes the air, since {why}")))
        .ok()
}

/// Why not the integrated GPU: measured once, so that all runs of a sweep are computed alike.
static SLOWER: OnceLock<Option<String>> = OnceLock::new();

/// By how much a device must be the faster.
const MARGIN: f64 = 1.1;

/// Why CPU threads are taken in place of a device, by what both update per second; `None` where the device is the faster.
fn slower_than_cpu(name: &str, (device, cpu): (Result<f64, DeviceError>, f64)) -> Option<String> {
    match device {
        Ok(device) if device > MARGIN * cpu => None,
        Ok(device) => Some(format!(
            "{name} makes {:.0} million updates of bare air per second and the CPU's threads {:.0} (--engine gpu takes the device)",
            1e-6 * device,
            1e-6 * cpu
        )),
        Err(error) => Some(error.to_string()),
    }
}

/// Whether the device can keep populations as asked for.
fn stores(precision: Precision, device: &Device) -> Result<(), DeviceError> {
    if precision == Precision::F16Storage {
        device.require_f16()?;
    }
    Ok(())
}

/// Whether the largest buffer of the air is within the device's limits.
fn air_fits(scene: &Scene, placement: &Placement, device: &Device) -> Result<(), DeviceError> {
    let sizes = Sizes::new(scene, placement);
    let what = format!("one array of populations, for {} cells,", sizes.cells);
    let remedy = "choose larger cells, a smaller tunnel, or --engine cpu";
    fits(what, sizes.population_bytes, remedy, device)
}

/// Whether the largest buffer of the fabric is within the device's limits.
fn fabric_fits(scene: &Scene, device: &Device) -> Result<(), DeviceError> {
    let Some(body) = &scene.body else {
        return Ok(());
    };
    let nodes = body.structure.node_count();
    let what = format!("the minimiser's memory for {nodes} nodes");
    let remedy = "use a coarser mesh, or --cloth host";
    // Equilibria, and long steps, take multigrid as their initial Hessian.
    let multigrid = steps_take_multigrid(scene) || scene.equilibrium.is_some();
    let cut = (scene.coupling).is_some_and(|coupling| coupling.scheme == Scheme::Links);
    let marker_count = if cut { 0 } else { place_markers(scene).len() };
    let bytes = largest_buffer_bytes(&body.structure, marker_count, multigrid, cut);
    fits(what, bytes, remedy, device)
}

fn fits(
    what: String,
    needed: u64,
    remedy: &'static str,
    device: &Device,
) -> Result<(), DeviceError> {
    let info = device.info();
    let limits = [
        (info.buffer_limit_bytes, "max_buffer_size"),
        (info.binding_limit_bytes, "max_storage_buffer_binding_size"),
    ];
    for (limit, limit_name) in limits {
        if needed > limit {
            return Err(DeviceError::Limit {
                what,
                needed,
                limit,
                limit_name,
                device: info.name.clone(),
                remedy,
            });
        }
    }
    Ok(())
}

/// Engine for flows that are no case: the air alone, without a question of size. `auto` takes a real GPU if there is one.
pub(super) fn air_alone(
    engine: Engine,
    adapter: Option<&str>,
    precision: Precision,
) -> Result<(AirPlacement, Option<Arc<Device>>), Failure> {
    let on_cpu = (AirPlacement::Cpu(precision), None);
    let choice = match (engine, adapter) {
        (Engine::Cpu, None) => return Ok(on_cpu),
        (Engine::Cpu, Some(_)) => {
            return Err(Failure::Other(
                exit::BAD_CASE,
                "--adapter has no use with --engine cpu".to_owned(),
            ));
        }
        (Engine::Auto, None) if precision == Precision::F64 => return Ok(on_cpu),
        (Engine::Auto, None) => {
            let opened = open(&AdapterChoice::Hardware);
            return Ok(
                match opened.and_then(|device| stores(precision, &device).map(|()| device)) {
                    Ok(device) => (AirPlacement::Gpu(precision.storage()), Some(device)),
                    Err(_) => on_cpu,
                },
            );
        }
        (Engine::Gpu | Engine::Auto, Some(name)) => AdapterChoice::Named(name.to_owned()),
        (Engine::Gpu, None) => AdapterChoice::Any,
    };
    if precision == Precision::F64 {
        return Err(Failure::Other(exit::BAD_CASE, F64_ON_DEVICE.to_owned()));
    }
    let device = open(&choice)?;
    stores(precision, &device)?;
    Ok((AirPlacement::Gpu(precision.storage()), Some(device)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_faster_of_an_integrated_gpu_and_the_cpu_is_taken() {
        assert_eq!(slower_than_cpu("A", (Ok(9e7), 8e7)), None);
        let why = slower_than_cpu("A", (Ok(7e7), 8e7)).unwrap();
        assert!(why.starts_with("A makes 70 million updates"), "{why}");
        let lost = DeviceError::Lost("gone".to_owned());
        assert!(
            slower_than_cpu("A", (Err(lost), 8e7))
                .unwrap()
                .contains("gone")
        );
    }
}
