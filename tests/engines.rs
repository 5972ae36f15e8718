//! One test body, one trial per engine.

use std::sync::{Arc, OnceLock};

use libtest_mimic::Trial;
use ripstop::gpu::{AdapterChoice, Device, DeviceError};
use ripstop::lattice::grid::{Initial, Setup};
use ripstop::plan::{AirPlacement, ClothPlacement, Placement, Precision, Storage};
use ripstop::simulation::AirEngine;

use crate::timing::timed;

/// Air on a device, which can share memory with fabric there.
pub fn air_on_a_device(cloth: ClothPlacement) -> Placement {
    Placement {
        air: AirPlacement::Gpu(Storage::F32),
        cloth,
        device: Some("device".to_owned()),
        shared_memory: true,
    }
}

/// Where the air is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    CpuF64,
    CpuF32,
    Gpu,
    /// The CPU with populations in 16 bits; not for every test.
    CpuF16,
    /// A device with the same.
    GpuF16,
}

impl Engine {
    pub const ALL: [Self; 3] = [Self::CpuF64, Self::CpuF32, Self::Gpu];

    pub const fn name(self) -> &'static str {
        match self {
            Self::CpuF64 => "cpu_f64",
            Self::CpuF32 => "cpu_f32",
            Self::Gpu => "gpu",
            Self::CpuF16 => "cpu_f16",
            Self::GpuF16 => "gpu_f16",
        }
    }

    pub fn placement(self) -> AirPlacement {
        match self {
            Self::CpuF64 => AirPlacement::Cpu(Precision::F64),
            Self::CpuF32 => AirPlacement::Cpu(Precision::F32),
            Self::Gpu => AirPlacement::Gpu(Storage::F32),
            Self::CpuF16 => AirPlacement::Cpu(Precision::F16Storage),
            Self::GpuF16 => AirPlacement::Gpu(Storage::F16),
        }
    }

    /// Air here, fabric on the host.
    pub fn plan_placement(self) -> Placement {
        Placement {
            air: self.placement(),
            cloth: ClothPlacement::Host,
            device: self.device().map(|device| device.info().name.clone()),
            shared_memory: self.on_device(),
        }
    }

    /// The device that this engine needs.
    pub fn device(self) -> Option<Arc<Device>> {
        self.on_device()
            .then(|| Arc::clone(device().as_ref().unwrap()))
    }

    const fn on_device(self) -> bool {
        matches!(self, Self::Gpu | Self::GpuF16)
    }

    /// Air of a set-up.
    pub fn air(self, setup: Setup, initial: &Initial) -> AirEngine {
        AirEngine::build(
            setup,
            Some(initial),
            self.placement(),
            self.device().as_ref(),
        )
        .unwrap()
    }
}

/// (δρ, u) of every cell, in the precision of the engine.
pub fn states(air: &AirEngine) -> Vec<(f64, [f64; 3])> {
    let [nx, ny, nz] = air.grid().cells;
    let cells = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]);
    match air {
        AirEngine::CpuF64(fluid) => cells.map(|cell| fluid.bare_state(cell)).collect(),
        AirEngine::CpuF32(fluid) => cells.map(|cell| fluid.bare_state(cell)).collect(),
        AirEngine::CpuF16(fluid) => cells.map(|cell| fluid.bare_state(cell)).collect(),
        AirEngine::Gpu(fluid) => fluid
            .macroscopic()
            .unwrap()
            .into_iter()
            .map(|(excess, u)| (f64::from(excess), u.map(f64::from)))
            .collect(),
    }
}

/// Σ δρ and Σ ρ u over all cells.
pub fn mass_and_momentum(air: &AirEngine) -> [f64; 4] {
    states(air).iter().fold([0.0; 4], |sum, (excess, u)| {
        let density = 1.0 + excess;
        [
            sum[0] + excess,
            sum[1] + density * u[0],
            sum[2] + density * u[1],
            sum[3] + density * u[2],
        ]
    })
}

/// The device of all tests: a software adapter will do.
pub fn device() -> &'static Result<Arc<Device>, DeviceError> {
    static DEVICE: OnceLock<Result<Arc<Device>, DeviceError>> = OnceLock::new();
    DEVICE.get_or_init(|| Device::open(&AdapterChoice::Any))
}

fn gpu_required() -> bool {
    std::env::var_os("RIPSTOP_REQUIRE_GPU").is_some_and(|v| v == "1")
}

/// A trial that needs a device: where there is none it shows as 'ignored', its kind says why, and `RIPSTOP_REQUIRE_GPU=1` turns
/// that into a failure. By its name `benches/accelerator.sh` finds it.
pub fn needs_device(name: String, body: impl FnOnce() + Send + 'static) -> Trial {
    assert!(
        name.contains("device") || name.contains("::gpu"),
        "{name}: trials that need a device have `device` or `::gpu` in their names"
    );
    let absent = device().is_err();
    let trial = Trial::test(name.clone(), move || {
        if let Err(error) = device() {
            return Err(format!("RIPSTOP_REQUIRE_GPU=1, but {error}").into());
        }
        timed(&name, body);
        Ok(())
    });
    if absent && !gpu_required() {
        trial.with_ignored_flag(true).with_kind("no adapter")
    } else {
        trial
    }
}

/// A test body that runs on every engine.
pub trait Body: Send + Copy + 'static {
    fn run(self, engine: Engine);
}

/// Trials of `body` on every engine.
pub fn on_every_engine(name: &str, body: impl Body) -> Vec<Trial> {
    on_engines(&Engine::ALL, name, body)
}

/// Trials of `body` on every engine, 16-bit storage included.
pub fn on_every_storage(name: &str, body: impl Body) -> Vec<Trial> {
    on_engines(
        &[&Engine::ALL[..], &[Engine::CpuF16, Engine::GpuF16]].concat(),
        name,
        body,
    )
}

fn on_engines(engines: &[Engine], name: &str, body: impl Body) -> Vec<Trial> {
    engines
        .iter()
        .copied()
        .map(|engine| {
            let name = format!("{name}::{}", engine.name());
            if engine.on_device() {
                return needs_device(name, move || body.run(engine));
            }
            Trial::test(name.clone(), move || {
                timed(&name, || body.run(engine));
                Ok(())
            })
        })
        .collect()
}

/// A test that does not depend on the engine.
pub fn plain(name: &str, body: impl FnOnce() + Send + 'static) -> Vec<Trial> {
    let timed_as = name.to_owned();
    vec![Trial::test(name, move || {
        timed(&timed_as, body);
        Ok(())
    })]
}
