//! Which engine computes what: turns `--engine`, `--cloth`, `--adapter` and `--precision` into a placement and an open device.

use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::{Failure, exit};
use crate::case::Scene;
use crate::gpu::adapters::{adapters, chosen};
use crate::gpu::{AdapterChoice, AdapterKind, Device, DeviceError};
use crate::plan::{AirPlacement, ClothPlacement, Placement, Precision, Sizes};

/// Nodes from which `--cloth auto` puts the fabric on a real GPU. Not yet measured on one (see `benches/results/README.md`): on
/// software adapters the host is faster at every size, and a solve on a device pays about ten waits of 50 µs.
pub const DEVICE_CLOTH_NODES: u64 = 20_000;

/// Where the air is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Engine {
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
    /// By the number of nodes.
    Auto,
    /// Host memory, f64.
    Host,
    /// Device memory.
    Device,
}

/// Choice of engines.
#[derive(Debug, Args)]
pub(super) struct EngineArguments {
    /// Engine for the air.
    #[arg(long, value_enum, default_value = "auto")]
    engine: Engine,
    /// Where the fabric is solved.
    #[arg(long, value_enum, default_value = "auto")]
    cloth: ClothChoice,
    /// Take the adapter whose name contains this text (see `ripstop devices`); implies --engine gpu.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Floating-point type of the air on the CPU; devices compute in f32.
    #[arg(long, value_enum, default_value = "f32")]
    precision: Precision,
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        Self::NoDevice(error.to_string())
    }
}

impl EngineArguments {
    /// Opens a device if one is to take part, and places air and fabric.
    pub(super) fn place(&self, scene: &Scene) -> Result<(Placement, Option<Arc<Device>>), Failure> {
        let on_cpu = Placement::from(self.precision);
        let named = self
            .adapter
            .as_ref()
            .map(|name| AdapterChoice::Named(name.clone()));
        let engine = match (self.engine, &named) {
            (Engine::Auto, Some(_)) => Engine::Gpu,
            (engine, _) => engine,
        };
        if engine == Engine::Gpu && self.precision == Precision::F64 {
            return Err(Failure::Other(
                exit::BAD_CASE,
                "--precision f64 needs --engine cpu: devices compute in f32".to_owned(),
            ));
        }
        let device = match engine {
            Engine::Cpu if self.cloth == ClothChoice::Device => {
                Some(Device::open(&named.unwrap_or(AdapterChoice::Any))?)
            }
            Engine::Cpu => None,
            Engine::Gpu => Some(Device::open(&named.unwrap_or(AdapterChoice::Any))?),
            Engine::Auto => automatic(scene, self.precision),
        };
        let Some(device) = device else {
            if self.cloth == ClothChoice::Device {
                return Err(Failure::NoDevice(
                    "--cloth device needs a device, and this machine has no GPU; `ripstop devices` lists what it has, \
                     --adapter NAME takes one"
                        .to_owned(),
                ));
            }
            return Ok((on_cpu, None));
        };
        let air = match engine {
            Engine::Cpu => AirPlacement::Cpu(self.precision),
            Engine::Auto | Engine::Gpu => AirPlacement::Gpu,
        };
        let nodes = scene
            .body
            .as_ref()
            .map_or(0, |body| body.structure.node_count() as u64);
        let cloth = match self.cloth {
            ClothChoice::Host => ClothPlacement::Host,
            ClothChoice::Device => ClothPlacement::Device,
            ClothChoice::Auto => {
                let real = device.info().kind != AdapterKind::Software;
                if real && nodes >= DEVICE_CLOTH_NODES {
                    ClothPlacement::Device
                } else {
                    ClothPlacement::Host
                }
            }
        };
        let placement = Placement {
            air,
            cloth,
            device: Some(device.info().name.clone()),
        };
        if air == AirPlacement::Gpu {
            fits(scene, &placement, &device)?;
        }
        Ok((placement, Some(device)))
    }
}

/// The best real GPU that can hold the air; `None`, with a word why, where the CPU is taken although there is a GPU.
fn automatic(scene: &Scene, precision: Precision) -> Option<Arc<Device>> {
    if precision == Precision::F64 || scene.air.is_none() {
        return None;
    }
    chosen(&adapters(), &AdapterChoice::Hardware)?;
    let placement = Placement {
        air: AirPlacement::Gpu,
        cloth: ClothPlacement::Host,
        device: None,
    };
    let opened = Device::open(&AdapterChoice::Hardware)
        .and_then(|device| fits(scene, &placement, &device).map(|()| device));
    opened
        .inspect_err(|error| eprintln!("note: the CPU computes the air, since {error}"))
        .ok()
}

/// Whether the largest buffer of the air is within the device's limits.
fn fits(scene: &Scene, placement: &Placement, device: &Device) -> Result<(), DeviceError> {
    let needed = Sizes::new(scene, placement).population_bytes;
    let info = device.info();
    let limits = [
        (info.buffer_limit_bytes, "max_buffer_size [bytes]"),
        (
            info.binding_limit_bytes,
            "max_storage_buffer_binding_size [bytes]",
        ),
    ];
    for (limit, limit_name) in limits {
        if needed > limit {
            return Err(DeviceError::Limit {
                what: "one array of populations".to_owned(),
                needed,
                limit,
                limit_name,
                device: info.name.clone(),
                remedy: "choose larger cells, a smaller tunnel, or --engine cpu",
            });
        }
    }
    Ok(())
}
