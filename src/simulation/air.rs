//! The air engine that the plan chose.

use std::sync::Arc;

use half::f16;

use crate::case::scene::{Air, Flow};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::fluid::Fluid;
use crate::gpu::{self, Device, DeviceError};
use crate::lattice::control_volume::{ControlVolume, MassMomentum};
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::lattice::grid::{
    CellState, Extremes, Faces, Grid, Initial, InletProfile, Setup, Sides, StreamwiseEnds, Wall,
};
use crate::lattice::nest::Level;
use crate::lattice::start::{Start, Stress};
use crate::plan::{AirPlacement, Plan, Precision, Stage};

/// The air on one of the engines; a `match` without wildcard forces every engine to offer every operation.
#[derive(Debug)]
pub enum AirEngine {
    /// CPU, single precision.
    CpuF32(Box<Fluid<f32>>),
    /// CPU, arithmetic in single precision, populations in 16 bits.
    CpuF16(Box<Fluid<f16>>),
    /// CPU, double precision.
    CpuF64(Box<Fluid<f64>>),
    /// Device, arithmetic in single precision.
    Gpu(Box<gpu::fluid::Fluid>),
}

macro_rules! each_engine {
    ($self:expr, $cpu:ident => $on_cpu:expr, $gpu:ident => $on_gpu:expr) => {
        match $self {
            AirEngine::CpuF32($cpu) => $on_cpu,
            AirEngine::CpuF16($cpu) => $on_cpu,
            AirEngine::CpuF64($cpu) => $on_cpu,
            AirEngine::Gpu($gpu) => $on_gpu,
        }
    };
}
pub(super) use each_engine;

impl AirEngine {
    /// One lattice of a scene's air: at rest, at the vortices of the case, or in a `state` of every cell in its own lattice units.
    pub(super) fn of_level(
        air: &Air,
        (level, setup): (&Level, Setup),
        plan: &Plan,
        device: Option<&Arc<Device>>,
        state: Option<&State<'_>>,
    ) -> Result<Self, DeviceError> {
        let placement = plan.placement.air;
        if let Some(state) = state {
            let start = Start::with_stresses(&setup, |cell| state(level, cell));
            let mut engine = Self::build(setup, None, placement, device)?;
            each_engine!(&mut engine, fluid => fluid.fill(&start), fluid => fluid.fill(&start));
            return Ok(engine);
        }
        match air.flow {
            // The wind rises from rest, and populations of air at rest are zero.
            Flow::WindTunnel { .. } => Self::build(setup, None, placement, device),
            Flow::TaylorGreen { speed_m_s, .. } => {
                let initial = vortices(air, *level, speed_m_s);
                Self::build(setup, Some(&initial), placement, device)
            }
        }
    }

    /// Air of a set-up on the engine of a placement; at rest where `initial` is `None`.
    pub fn build(
        setup: Setup,
        initial: Option<&Initial>,
        placement: AirPlacement,
        device: Option<&Arc<Device>>,
    ) -> Result<Self, DeviceError> {
        Ok(match placement {
            AirPlacement::Cpu(Precision::F32) => Self::CpuF32(Box::new(Fluid::new(setup, initial))),
            AirPlacement::Cpu(Precision::F16Storage) => {
                Self::CpuF16(Box::new(Fluid::new(setup, initial)))
            }
            AirPlacement::Cpu(Precision::F64) => Self::CpuF64(Box::new(Fluid::new(setup, initial))),
            AirPlacement::Gpu(storage) => {
                let device = needed(device)?;
                Self::Gpu(Box::new(gpu::fluid::Fluid::new(
                    device, setup, storage, initial,
                )?))
            }
        })
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> Grid {
        each_engine!(self, fluid => *fluid.grid(), fluid => *fluid.grid())
    }

    /// What the air was built from.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        each_engine!(self, fluid => fluid.setup(), fluid => fluid.setup())
    }

    /// True after an odd number of steps.
    #[must_use]
    pub fn is_odd(&self) -> bool {
        each_engine!(self, fluid => fluid.is_odd(), fluid => fluid.is_odd())
    }

    /// Sets the velocity at the inlet [cells per step].
    pub fn set_inlet_velocity(&mut self, velocity: [f64; 3]) {
        each_engine!(self, fluid => fluid.set_inlet_velocity(velocity), fluid => fluid.set_inlet_velocity(velocity));
    }

    /// Stage `eddy_viscosity`, where the step to come asks for it.
    pub fn eddy_viscosity(&mut self) -> Result<(), DeviceError> {
        each_engine!(self, fluid => {
            fluid.eddy_viscosity();
            Ok(())
        }, fluid => fluid.eddy_viscosity())
    }

    /// Eddy viscosity of every cell as that stage left it [cells² per step]; `None` where no model needs it.
    pub fn eddy_viscosities(&self) -> Result<Option<Vec<f64>>, DeviceError> {
        each_engine!(self, fluid => Ok(fluid.eddy_viscosities()), fluid => fluid.eddy_viscosities())
    }

    /// What stands out among the cells from `first` to before `end`; `None` in an empty box.
    pub fn extremes(
        &self,
        first: [usize; 3],
        end: [usize; 3],
    ) -> Result<Option<Extremes>, DeviceError> {
        each_engine!(self, fluid => Ok(fluid.extremes(first, end)), fluid => fluid.extremes(first, end))
    }

    /// A cell that is not finite, too thin or too dense, or faster than `speed_limit` [cells per step]: the fastest finite one, if it is such.
    pub fn breakdown(&self, speed_limit: f64) -> Result<Option<CellState>, DeviceError> {
        let found = self.extremes([0; 3], self.grid().cells)?;
        Ok(found.and_then(|found| found.breakdown(speed_limit)))
    }

    /// Density excess and velocity of all cells.
    pub fn macroscopic(&self) -> Result<Vec<(f32, [f32; 3])>, DeviceError> {
        each_engine!(self, fluid => Ok(fluid.macroscopic()), fluid => fluid.macroscopic())
    }

    /// Density excess and velocity of single cells; a device reads all of them back.
    pub fn states_of(&self, cells: &[[usize; 3]]) -> Result<Vec<(f64, [f64; 3])>, DeviceError> {
        each_engine!(self, fluid => Ok(cells.iter().map(|cell| fluid.bare_state(*cell)).collect()), fluid => {
            let [nx, ny, _] = fluid.grid().cells;
            let all = fluid.macroscopic()?;
            let state = |[x, y, z]: &[usize; 3]| {
                let (excess, u) = all[x + nx * (y + ny * z)];
                (f64::from(excess), u.map(f64::from))
            };
            Ok(cells.iter().map(state).collect())
        })
    }

    /// Stress beyond equilibrium of all cells.
    pub fn stresses(&self) -> Result<Vec<Stress>, DeviceError> {
        each_engine!(self, fluid => Ok(fluid.stresses()), fluid => fluid.stresses())
    }

    /// Σ δρ and Σ ½ ρ u² over all cells.
    pub fn mass_and_energy(&self) -> Result<(f64, f64), DeviceError> {
        each_engine!(self, fluid => Ok(fluid.mass_and_energy()), fluid => fluid.mass_and_energy())
    }

    /// Mass and momentum in a box now.
    pub fn storage(&self, volume: &ControlVolume) -> Result<MassMomentum, DeviceError> {
        each_engine!(self, fluid => Ok(fluid.storage(volume)), fluid => fluid.storage(volume))
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        each_engine!(self, fluid => fluid.save(out), fluid => fluid.save(out))
    }

    pub(super) fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        each_engine!(self, fluid => fluid.restore(from), fluid => fluid.restore(from))
    }
}

/// State of a cell of a level: density excess, velocity and stress, in the level's lattice units.
pub(super) type State<'a> = dyn Fn(&Level, [usize; 3]) -> (f64, [f64; 3], Stress) + Sync + 'a;

/// The outermost lattice of a scene's air; how often a stage runs is the plan's.
pub(super) fn setup(air: &Air, plan: &Plan) -> Setup {
    let (ends, inlet_profile, sides, sponge_cells) = match &air.flow {
        Flow::WindTunnel {
            sponge_length_m,
            sides,
            inlet_profile,
            ..
        } => (
            StreamwiseEnds::InletOutlet,
            inlet_profile.clone(),
            *sides,
            sponge_length_m.map(|length| length / air.outer_cell_size_m()),
        ),
        Flow::TaylorGreen { .. } => (StreamwiseEnds::Periodic, None, Sides::Periodic, None),
    };
    Setup {
        cells: air.outer_cells(),
        ends,
        inlet_profile,
        sides,
        relaxation_time: air.relaxation_time(0),
        sponge_cells,
        idle: None,
        operator: air.operator,
        eddy_viscosity: air.eddy_viscosity.map(|eddy_viscosity| EddyViscosity {
            update_every: plan
                .every(Stage::EddyViscosity)
                .unwrap_or(eddy_viscosity.update_every),
            ..eddy_viscosity
        }),
    }
}

/// A box of finer cells in it. What lies beyond its faces reaches no cell that counts ([`crate::lattice::nest`]).
pub(super) fn inner_setup(outermost: &Setup, air: &Air, level: &Level) -> Setup {
    let [x, sides @ ..] = level.spans;
    Setup {
        cells: level.cells,
        ends: if x {
            StreamwiseEnds::Periodic
        } else {
            StreamwiseEnds::Walls([Wall::OfBox; 2])
        },
        // While the wind rises cells gain what that of the outermost lattice gains that they lie in.
        inlet_profile: outermost.inlet_profile.as_ref().map(|outer| {
            let across = (1_u32 << (air.depth() - level.depth)) as f64;
            let share = |axis: usize, cell: usize| {
                let place = level.corner[axis] as f64 + across * (cell as f64 + 0.5);
                place / air.cells[axis] as f64
            };
            InletProfile::new(level.cells, |y, z| {
                outer.ratio_at([share(1, y), share(2, z)])
            })
        }),
        sides: Sides::Each(sides.map(|spans| match spans {
            true => Faces::Periodic,
            false => Faces::Walls([Wall::OfBox; 2]),
        })),
        relaxation_time: air.relaxation_time(level.depth),
        sponge_cells: None,
        idle: None,
        ..outermost.clone()
    }
}

/// The device of a placement that asks for one.
pub(super) fn needed(device: Option<&Arc<Device>>) -> Result<&Arc<Device>, DeviceError> {
    device.ok_or_else(|| {
        DeviceError::NoAdapter("the plan asks for a device, none was opened".to_owned())
    })
}

/// Air and markers must live on the same engine.
pub(super) fn apart() -> DeviceError {
    DeviceError::Command("air and markers live on different engines".to_owned())
}

/// Net outflow of a box of cells, added up step by step.
#[derive(Debug)]
pub struct Balance {
    volume: ControlVolume,
    outflow: MassMomentum,
    watch: Option<gpu::fluid::VolumeWatch>,
}

impl Balance {
    /// Balance of a box in the air of `engine`.
    pub fn new(engine: &AirEngine, volume: ControlVolume) -> Result<Self, DeviceError> {
        let watch = match engine {
            AirEngine::CpuF32(_) | AirEngine::CpuF16(_) | AirEngine::CpuF64(_) => None,
            AirEngine::Gpu(fluid) => Some(fluid.watch_volume(&volume)?),
        };
        Ok(Self {
            volume,
            outflow: MassMomentum::default(),
            watch,
        })
    }

    /// The box.
    #[must_use]
    pub const fn volume(&self) -> &ControlVolume {
        &self.volume
    }

    /// Adds the step just done.
    pub fn add_step(&mut self, engine: &AirEngine) -> Result<(), DeviceError> {
        let volume = &self.volume;
        let out = match (engine, &mut self.watch) {
            (AirEngine::CpuF32(fluid), _) => fluid.outflow(volume),
            (AirEngine::CpuF16(fluid), _) => fluid.outflow(volume),
            (AirEngine::CpuF64(fluid), _) => fluid.outflow(volume),
            (AirEngine::Gpu(fluid), Some(watch)) => return fluid.add_outflow(watch),
            (AirEngine::Gpu(_), None) => return Err(apart()),
        };
        self.outflow.add(&out);
        Ok(())
    }

    /// Net outflow since the beginning.
    pub fn outflow(&mut self, engine: &AirEngine) -> Result<MassMomentum, DeviceError> {
        if let (AirEngine::Gpu(fluid), Some(watch)) = (engine, &mut self.watch) {
            self.outflow.add(&fluid.take_outflow(watch)?);
        }
        Ok(self.outflow)
    }

    /// Begins anew, or from what a checkpoint holds.
    pub fn restart(
        &mut self,
        engine: &AirEngine,
        outflow: MassMomentum,
    ) -> Result<(), DeviceError> {
        self.outflow(engine)?;
        self.outflow = outflow;
        Ok(())
    }
}

/// Density excess and velocity of every cell of a level in Taylor–Green vortices [lattice units].
fn vortices(air: &Air, level: Level, speed_m_s: f64) -> impl Fn([usize; 3]) -> (f64, [f64; 3]) {
    let speed = speed_m_s / air.units.speed_m_s();
    let k = std::f64::consts::TAU / air.cells[0] as f64;
    let size = air.finest_cells_across(&level);
    move |cell| {
        let place = |a: usize| level.corner[a] as f64 + size * (cell[a] as f64 + 0.5);
        let [x, y] = [k * place(0), k * place(1)];
        // p = (ρ u²/4)(cos 2kx + cos 2ky); δρ = 3 p.
        let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
        (
            excess,
            [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0],
        )
    }
}
