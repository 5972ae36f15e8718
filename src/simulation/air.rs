//! The air engine that the plan chose.

use crate::case::scene::{Air, Flow};
use crate::cpu::fluid::control_volume::{ControlVolume, MassMomentum};
use crate::cpu::fluid::{BodyForce, Breakdown, Fluid, Grid, Setup, Sides, StreamwiseEnds};
use crate::plan::Precision;

/// The air on one of the engines; a `match` without wildcard forces every engine to offer every operation.
#[derive(Debug)]
pub enum AirEngine {
    /// CPU, single precision.
    CpuF32(Fluid<f32>),
    /// CPU, double precision.
    CpuF64(Fluid<f64>),
}

macro_rules! each_engine {
    ($self:expr, $fluid:ident => $body:expr) => {
        match $self {
            AirEngine::CpuF32($fluid) => $body,
            AirEngine::CpuF64($fluid) => $body,
        }
    };
}
pub(super) use each_engine;

impl AirEngine {
    /// Air of a scene at its initial state.
    #[must_use]
    pub fn new(air: &Air, precision: Precision) -> Self {
        let (ends, sides, sponge_cells) = match air.flow {
            Flow::WindTunnel {
                sponge_length_m, ..
            } => (
                StreamwiseEnds::InletOutlet,
                Sides::FreeSlip,
                sponge_length_m.map(|length| length / air.units.cell_size_m),
            ),
            Flow::TaylorGreen { .. } => (StreamwiseEnds::Periodic, Sides::Periodic, None),
        };
        let setup = Setup {
            cells: air.cells,
            ends,
            sides,
            relaxation_time: air.units.relaxation_time(air.kinematic_viscosity_m2_s),
            sponge_cells,
            operator: air.operator,
            smagorinsky_constant: air.smagorinsky_constant,
        };
        let initial = initial_state(air);
        match precision {
            Precision::F32 => Self::CpuF32(Fluid::new(setup, initial)),
            Precision::F64 => Self::CpuF64(Fluid::new(setup, initial)),
        }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> Grid {
        each_engine!(self, fluid => *fluid.grid())
    }

    /// Sets the velocity at the inlet [cells per step].
    pub fn set_inlet_velocity(&mut self, velocity: [f64; 3]) {
        each_engine!(self, fluid => fluid.set_inlet_velocity(velocity));
    }

    /// Stage `collide_stream`.
    pub fn collide_stream(&mut self, body_force: &BodyForce) {
        each_engine!(self, fluid => fluid.collide_stream(body_force));
    }

    /// First cell that is not finite or too fast.
    #[must_use]
    pub fn breakdown(&self, speed_limit: f64) -> Option<Breakdown> {
        each_engine!(self, fluid => fluid.breakdown(speed_limit))
    }

    /// Density excess and velocity of all cells.
    #[must_use]
    pub fn macroscopic(&self) -> Vec<(f32, [f32; 3])> {
        each_engine!(self, fluid => fluid.macroscopic())
    }

    /// Σ δρ and Σ ½ ρ u² over all cells.
    #[must_use]
    pub fn mass_and_energy(&self) -> (f64, f64) {
        each_engine!(self, fluid => fluid.mass_and_energy())
    }

    /// Net outflow of a box in the step just done.
    #[must_use]
    pub fn outflow(&self, volume: &ControlVolume) -> MassMomentum {
        each_engine!(self, fluid => fluid.outflow(volume))
    }

    /// Mass and momentum in a box now.
    #[must_use]
    pub fn storage(&self, volume: &ControlVolume) -> MassMomentum {
        each_engine!(self, fluid => fluid.storage(volume))
    }
}

/// Density excess and velocity of every cell at the start [lattice units].
fn initial_state(air: &Air) -> impl Fn([usize; 3]) -> (f64, [f64; 3]) {
    let flow = air.flow;
    let units = air.units;
    let side_cells = air.cells[0] as f64;
    move |cell| match flow {
        // The wind rises from rest.
        Flow::WindTunnel { .. } => (0.0, [0.0; 3]),
        Flow::TaylorGreen { speed_m_s, .. } => {
            let speed = speed_m_s / units.speed_m_s();
            let k = std::f64::consts::TAU / side_cells;
            let [x, y] = [k * (cell[0] as f64 + 0.5), k * (cell[1] as f64 + 0.5)];
            // p = (ρ u²/4)(cos 2kx + cos 2ky); δρ = 3 p.
            let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
            (
                excess,
                [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0],
            )
        }
    }
}
