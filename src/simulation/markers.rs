//! The markers, on the engine that has the air.

use super::air::{AirEngine, apart, each_engine};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::fluid::BodyForce;
use crate::cpu::immersed::{self, Immersed};
use crate::gpu::cloth::{AtMarkers, MarkersInAir, NodesOnDevice};
use crate::gpu::fluid::ForceBox;
use crate::gpu::immersed::LatticeInSpace;
use crate::gpu::{self, DeviceError};
use crate::immersed::folds::Folds;
use crate::immersed::touched::{Domain, OutOfDomain};
use crate::lattice::grid::Setup;
use crate::units::Units;

/// Markers in the air.
#[derive(Debug)]
pub enum MarkerEngine {
    /// Host memory.
    Cpu(Box<Immersed>),
    /// Device memory.
    Gpu(Box<gpu::immersed::Immersed>),
}

/// The cells of the air for markers; kernels go on through sides that repeat, but not through the ends, and are folded at faces that a body
/// passes through.
pub fn domain(setup: &Setup, folds: Option<Folds>, kept: usize) -> Domain {
    let [_, y, z] = setup.repeats();
    Domain {
        cells: setup.cells,
        repeats: [false, y, z],
        folds,
        kept,
    }
}

macro_rules! both {
    ($self:expr, $markers:ident => $body:expr) => {
        match $self {
            MarkerEngine::Cpu($markers) => $body,
            MarkerEngine::Gpu($markers) => $body,
        }
    };
}

impl MarkerEngine {
    /// Markers of the given areas [cells²] in the air of `engine`, of which none stands at a face.
    pub fn new(
        engine: &AirEngine,
        areas: Vec<f64>,
        over_relaxation: f64,
    ) -> Result<Self, DeviceError> {
        Self::at_faces(engine, (None, 0), areas, over_relaxation)
    }

    /// The same with kernels folded at the given faces, or which keep off so many cells at all faces.
    pub fn at_faces(
        engine: &AirEngine,
        (folds, kept): (Option<Folds>, usize),
        areas: Vec<f64>,
        over_relaxation: f64,
    ) -> Result<Self, DeviceError> {
        Ok(match engine {
            AirEngine::CpuF32(fluid) => Self::Cpu(Box::new(Immersed::new(
                areas,
                over_relaxation,
                domain(fluid.setup(), folds, kept),
            ))),
            AirEngine::CpuF16(fluid) => Self::Cpu(Box::new(Immersed::new(
                areas,
                over_relaxation,
                domain(fluid.setup(), folds, kept),
            ))),
            AirEngine::CpuF64(fluid) => Self::Cpu(Box::new(Immersed::new(
                areas,
                over_relaxation,
                domain(fluid.setup(), folds, kept),
            ))),
            AirEngine::Gpu(fluid) => Self::Gpu(Box::new(gpu::immersed::Immersed::new(
                fluid,
                domain(fluid.setup(), folds, kept),
                areas,
                over_relaxation,
            )?)),
        })
    }

    /// Number of markers.
    #[must_use]
    pub fn marker_count(&self) -> usize {
        both!(self, markers => markers.marker_count())
    }

    /// u* at the markers [cells per step].
    #[must_use]
    pub fn air_velocities(&self) -> &[[f64; 3]] {
        both!(self, markers => markers.air_velocities())
    }

    /// Immersed-boundary stiffness 2 a_k A_k of marker `k` [lattice units].
    #[must_use]
    pub fn stiffness(&self, k: usize) -> f64 {
        both!(self, markers => markers.stiffness(k))
    }

    /// True if all touched cells lie in the box of cells `first..end`.
    #[must_use]
    pub fn touches_only(&self, first: [usize; 3], end: [usize; 3]) -> bool {
        both!(self, markers => markers.touches_only(first, end))
    }

    /// First cell and end of the box of cells that the next collision feels forces in, on a device; `None` until there are forces.
    pub(super) fn forced_cells(&self) -> Option<[[i32; 3]; 2]> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(markers) => markers.force_box().map(ForceBox::cells),
        }
    }

    /// Stage `send_markers`; nothing on the CPU.
    pub fn send_markers(
        &mut self,
        air: &AirEngine,
        positions: &[[f64; 3]],
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        match (self, air) {
            (Self::Gpu(markers), AirEngine::Gpu(fluid)) => markers.send_markers(fluid, positions),
            (Self::Cpu(_), _) => Ok(Ok(())),
            (Self::Gpu(_), _) => Err(apart()),
        }
    }

    /// Stage `interpolate` for markers at `positions` [cells].
    pub fn interpolate(
        &mut self,
        air: &AirEngine,
        positions: &[[f64; 3]],
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        match (self, air) {
            (Self::Cpu(markers), AirEngine::CpuF32(fluid)) => {
                Ok(markers.interpolate(fluid, positions))
            }
            (Self::Cpu(markers), AirEngine::CpuF16(fluid)) => {
                Ok(markers.interpolate(fluid, positions))
            }
            (Self::Cpu(markers), AirEngine::CpuF64(fluid)) => {
                Ok(markers.interpolate(fluid, positions))
            }
            (Self::Gpu(markers), AirEngine::Gpu(fluid)) => {
                markers.interpolate(fluid);
                Ok(Ok(()))
            }
            (Self::Cpu(_) | Self::Gpu(_), _) => Err(apart()),
        }
    }

    /// Has a device begin with what `fetch_air_velocities` will take; nothing on the CPU.
    pub fn ask_air_velocities(&mut self) {
        if let Self::Gpu(markers) = self {
            markers.ask_air_velocities();
        }
    }

    /// Takes what a device found and did at the markers by itself; returns the sum of the forces on the air [lattice units], `None` on the CPU.
    pub(super) fn take_brought(&mut self, at_markers: &AtMarkers) -> Option<[f64; 3]> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(markers) => {
                Some(markers.take_brought(&at_markers.states, &at_markers.forces))
            }
        }
    }

    /// The markers for fabric on the device that has the air; `None` on the CPU.
    pub(super) fn in_air(&self, units: &Units) -> Option<MarkersInAir> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(markers) => {
                Some(markers.in_air(units.stiffness_kg_s(), [units.speed_m_s(), units.force_n()]))
            }
        }
    }

    /// From now on a device may find the markers itself, at these nodes. False on the CPU, and where kernels go on through sides or are folded at faces.
    pub(super) fn follow(
        &mut self,
        nodes: NodesOnDevice,
        lattice: LatticeInSpace,
    ) -> Result<bool, DeviceError> {
        match self {
            Self::Cpu(_) => Ok(false),
            Self::Gpu(markers) => markers.follow(nodes, lattice),
        }
    }

    /// Lays a box around markers at `positions` [cells], with so many cells of room to move in.
    pub(super) fn enclose(
        &mut self,
        air: &AirEngine,
        positions: &[[f64; 3]],
        room: u32,
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        match (self, air) {
            (Self::Gpu(markers), AirEngine::Gpu(fluid)) => markers.enclose(fluid, positions, room),
            _ => Err(apart()),
        }
    }

    /// Has a device find and sort the markers in that box.
    pub(super) fn sort_markers(&self) {
        if let Self::Gpu(markers) = self {
            markers.sort_markers();
        }
    }

    /// Takes where a device had sorted them to, at `positions` [cells].
    pub(super) fn take_sorted(
        &mut self,
        order: &[u32],
        positions: &[[f64; 3]],
    ) -> Result<(), OutOfDomain> {
        match self {
            Self::Cpu(_) => Ok(()),
            Self::Gpu(markers) => markers.take_sorted(order, positions),
        }
    }

    /// Stage `fetch_air_velocities`; nothing on the CPU.
    pub fn fetch_air_velocities(&mut self) -> Result<(), DeviceError> {
        match self {
            Self::Cpu(_) => Ok(()),
            Self::Gpu(markers) => markers.fetch_air_velocities(),
        }
    }

    /// Stage `send_marker_forces`: the forces of markers moving with `velocities` [cells per step]; returns their sum on the air
    /// [lattice units]. On the CPU `spread` does both.
    pub fn send_marker_forces(&mut self, velocities: &[[f64; 3]]) -> Option<[f64; 3]> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(markers) => Some(markers.send_marker_forces(velocities)),
        }
    }

    /// Stage `spread`; returns the sum of the forces on the air where this stage forms them.
    pub fn spread(&mut self, velocities: &[[f64; 3]]) -> Option<[f64; 3]> {
        match self {
            Self::Cpu(markers) => Some(markers.spread(velocities)),
            Self::Gpu(markers) => {
                markers.spread();
                None
            }
        }
    }

    /// Stage `repeat_forcing`: one more pass of multi-direct forcing; returns the sum of the forces on the air where this stage knows it.
    pub fn repeat_forcing(
        &mut self,
        velocities: &[[f64; 3]],
    ) -> Result<Option<[f64; 3]>, DeviceError> {
        match self {
            Self::Cpu(markers) => Ok(Some(markers.repeat_forcing(velocities))),
            Self::Gpu(markers) => markers.repeat_forcing(velocities).map(|()| None),
        }
    }

    /// Stage `fetch_marker_forces`: the sum of the forces on the air after the last pass; nothing on the CPU.
    pub fn fetch_marker_forces(&mut self) -> Result<Option<[f64; 3]>, DeviceError> {
        match self {
            Self::Cpu(_) => Ok(None),
            Self::Gpu(markers) => markers.fetch_marker_forces().map(Some),
        }
    }

    /// Force of marker `k` on the air by the last `spread` [lattice units].
    #[must_use]
    pub fn force(&self, k: usize) -> [f64; 3] {
        both!(self, markers => markers.force(k))
    }

    /// Area of marker `k` [cells²].
    #[must_use]
    pub fn area(&self, k: usize) -> f64 {
        both!(self, markers => markers.area(k))
    }

    /// Velocity of the air after the half force relative to every marker [cells per step].
    pub fn slip_velocities(&self, velocities: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, DeviceError> {
        match self {
            Self::Cpu(markers) => Ok(markers.slip_velocities(velocities)),
            Self::Gpu(markers) => markers.slip_velocities(velocities),
        }
    }

    /// Its magnitude [cells per step].
    pub fn marker_slips(&self, velocities: &[[f64; 3]]) -> Result<Vec<f64>, DeviceError> {
        match self {
            Self::Cpu(markers) => Ok(markers.marker_slips(velocities)),
            Self::Gpu(markers) => markers.marker_slips(velocities),
        }
    }

    /// Its root mean square, weighted by area [cells per step].
    pub fn slip(&self, velocities: &[[f64; 3]]) -> Result<f64, DeviceError> {
        match self {
            Self::Cpu(markers) => Ok(markers.slip(velocities)),
            Self::Gpu(markers) => markers.slip(velocities),
        }
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        both!(self, markers => markers.save(out))
    }

    pub(super) fn restore(
        &mut self,
        from: &Reader,
        positions: &[[f64; 3]],
        air: &AirEngine,
    ) -> Result<(), CheckpointError> {
        match (&mut *self, air) {
            (Self::Cpu(markers), _) if from.has(immersed::FORCES) => {
                return markers.restore(from, positions);
            }
            (Self::Gpu(markers), AirEngine::Gpu(fluid)) if from.has(gpu::immersed::FORCES) => {
                return markers.restore(from, positions, fluid);
            }
            _ => {}
        }
        // The other engine wrote it: the air tells what it knew but for the forces.
        let count = self.marker_count();
        let forces: Vec<[f64; 3]> = if from.has(immersed::FORCES) {
            from.take_exactly(immersed::FORCES, count)?
        } else {
            from.take_exactly::<[f32; 4]>(gpu::immersed::FORCES, count)?
                .iter()
                .map(|[x, y, z, _]| [*x, *y, *z].map(f64::from))
                .collect()
        };
        if from.take_exactly::<u64>("markers_active", 1)?[0] != 1 {
            return Ok(());
        }
        self.go_on(air, positions, &forces)
            .map_err(|error| from.damaged(error.to_string()))?
            .map_err(|left| from.damaged(format!("marker {} lies outside the air", left.marker)))
    }

    /// Goes on with forces that another engine or lattice has formed, at `positions` [cells, lattice units]; what else there is to know, the air tells.
    pub(super) fn go_on(
        &mut self,
        air: &AirEngine,
        positions: &[[f64; 3]],
        forces: &[[f64; 3]],
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        if let Err(left) = self.send_markers(air, positions)? {
            return Ok(Err(left));
        }
        if let Err(left) = self.interpolate(air, positions)? {
            return Ok(Err(left));
        }
        self.fetch_air_velocities()?;
        both!(self, markers => markers.take_forces(forces));
        Ok(Ok(()))
    }
}

impl AirEngine {
    /// Stage `collide_stream`, under a uniform acceleration [cells per step²] and the forces of the markers, if there are any.
    pub fn collide_stream(
        &mut self,
        acceleration: Option<[f64; 3]>,
        markers: Option<&MarkerEngine>,
    ) -> Result<(), DeviceError> {
        each_engine!(self, fluid => {
            let cells = match markers {
                Some(MarkerEngine::Cpu(immersed)) => immersed.forced_cells(),
                Some(MarkerEngine::Gpu(_)) => return Err(apart()),
                None => Default::default(),
            };
            fluid.collide_stream(&BodyForce { acceleration, cells });
            Ok(())
        }, fluid => {
            let forces = match markers {
                Some(MarkerEngine::Cpu(_)) => return Err(apart()),
                Some(MarkerEngine::Gpu(immersed)) => immersed.force_box(),
                None => None,
            };
            fluid.collide_stream(acceleration, forces)
        })
    }

    /// Stage `collide_ahead`, on a device: all cells but those from `awaited[0]` to before `awaited[1]` go ahead by a step. False where the device cannot yet.
    pub fn collide_ahead(
        &mut self,
        markers: Option<&MarkerEngine>,
        awaited: [[i32; 3]; 2],
    ) -> Result<bool, DeviceError> {
        let forces = match markers {
            Some(MarkerEngine::Cpu(_)) => return Err(apart()),
            Some(MarkerEngine::Gpu(immersed)) => immersed.force_box(),
            None => None,
        };
        match self {
            Self::Gpu(fluid) => fluid.collide_ahead(forces, awaited),
            Self::CpuF32(_) | Self::CpuF16(_) | Self::CpuF64(_) => Err(apart()),
        }
    }

    /// True if most cells are a step ahead of the others.
    #[must_use]
    pub fn is_ahead(&self) -> bool {
        match self {
            Self::Gpu(fluid) => fluid.is_ahead(),
            Self::CpuF32(_) | Self::CpuF16(_) | Self::CpuF64(_) => false,
        }
    }

    /// Has a device begin with what was left to a later submission.
    pub(super) fn submit(&self) {
        if let Self::Gpu(fluid) = self {
            fluid.device().submit_waiting();
        }
    }
}
