//! The engine that the plan chose for the fabric. Its state, [`Cloth`], is the host's wherever it is solved.

use std::sync::Arc;

use super::air::{apart, needed};
use crate::cloth::patches::Patches;
use crate::cpu::cloth::driver::STEP_PATIENCE;
use crate::cpu::cloth::{Cloth, SolverSettings, StepInput};
use crate::gpu::cloth::{AirScales, AtCuts, AtMarkers, LinksInAir, MarkersInAir, NodesOnDevice};
use crate::gpu::{self, Device, DeviceError};
use crate::plan::ClothPlacement;
use crate::solve::lbfgs::{Outcome, Watch};

/// Who solves the fabric; a `match` without wildcard forces every engine to offer every operation.
#[derive(Debug)]
pub enum ClothEngine {
    /// The host, in double precision.
    Host,
    /// A device, in single precision with positions in fixed point.
    Device(Box<OnDevice>),
}

/// Fabric on a device. What the device leaves unsolved in a step, the host solves from the same start: in double precision, and with all its methods.
#[derive(Debug)]
pub struct OnDevice {
    cloth: gpu::cloth::Cloth,
    /// What the device did of the present step, where it left it.
    left: Option<Outcome>,
    /// True if it leaves nothing.
    keeps_all: bool,
}

/// Where the air meets the fabric.
#[derive(Debug, Default)]
pub(super) struct Met<'a> {
    /// At markers (triangle, barycentric weights);
    pub markers: &'a [(u32, [f64; 3])],
    /// in the air of the device that has the fabric, which forms their reactions itself;
    pub in_air: Option<MarkersInAir>,
    /// or on triangles that cut its lattice.
    pub cut: bool,
}

impl OnDevice {
    /// True if it leaves what it does not solve to the host.
    const fn leaves(&self, input: &StepInput) -> bool {
        input.time_step_s.is_some() && !self.keeps_all
    }

    /// How hard it tries.
    fn limited(&self, input: &StepInput, settings: &SolverSettings) -> SolverSettings {
        let limit = if self.leaves(input) {
            STEP_PATIENCE
        } else {
            usize::MAX
        };
        SolverSettings {
            evaluation_limit: settings.evaluation_limit.min(limit),
            ..*settings
        }
    }

    /// `None` where the solve is left to the host.
    fn take(&mut self, outcome: Outcome, leaves: bool) -> Option<Outcome> {
        self.left = (leaves && !outcome.stop.reached()).then_some(outcome);
        self.left.is_none().then_some(outcome)
    }

    fn solve_cloth(
        &mut self,
        cloth: &Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Option<Outcome>, DeviceError> {
        let settings = self.limited(input, settings);
        let outcome = self.cloth.solve_cloth(&cloth.structure, input, &settings)?;
        Ok(self.take(outcome, self.leaves(input)))
    }

    /// Takes the solution, or solves what was left; then what both did.
    fn fetch_nodes(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Option<Outcome>, DeviceError> {
        let Some(left) = self.left.take() else {
            self.cloth.fetch_nodes(cloth, input)?;
            return Ok(None);
        };
        let by_host = cloth.solve_cloth(input, settings);
        Ok(Some(Outcome {
            iterations: left.iterations + by_host.iterations,
            evaluations: left.evaluations + by_host.evaluations,
            ..by_host
        }))
    }
}

/// A solve with its transfers.
#[derive(Debug, Clone, Copy)]
pub struct Solved {
    pub outcome: Outcome,
    /// True if a device left it to the host.
    pub left_to_host: bool,
}

impl ClothEngine {
    /// The engine for the fabric, if there is any.
    pub(super) fn new(
        placement: ClothPlacement,
        cloth: Option<&Cloth>,
        met: Met,
        device: Option<&Arc<Device>>,
    ) -> Result<Self, DeviceError> {
        match (placement, cloth) {
            (ClothPlacement::Host, _) | (ClothPlacement::Device, None) => Ok(Self::Host),
            (ClothPlacement::Device, Some(cloth)) => {
                let device = Arc::clone(needed(device)?);
                let structure = &cloth.structure;
                let engine = match met.in_air {
                    Some(air) => {
                        gpu::cloth::Cloth::new_in_air(device, structure, met.markers, air)?
                    }
                    None if met.cut => gpu::cloth::Cloth::new_cut(device, structure)?,
                    None => gpu::cloth::Cloth::new(device, structure, met.markers)?,
                };
                Ok(Self::Device(Box::new(OnDevice {
                    cloth: engine,
                    left: None,
                    keeps_all: false,
                })))
            }
        }
    }

    /// A device that leaves nothing to the host, for a benchmark.
    pub(super) fn keep_all(&mut self) {
        if let Self::Device(engine) = self {
            engine.keeps_all = true;
        }
    }

    /// True if stages `send_nodes` and `fetch_nodes` stand around `solve_cloth`.
    pub(super) const fn is_device(&self) -> bool {
        matches!(self, Self::Device(_))
    }

    /// Stage `send_nodes`.
    pub(super) fn send_nodes(
        &mut self,
        cloth: &Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<(), DeviceError> {
        match self {
            Self::Host => Ok(()),
            Self::Device(engine) => engine.cloth.send_nodes(cloth, input, settings),
        }
    }

    /// Stage `solve_cloth`; on a device on what was sent, and the solution stays there. `None` where it is left to the host, until [`Self::fetch_nodes`].
    pub(super) fn solve_cloth(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Option<Outcome>, DeviceError> {
        match self {
            Self::Host => Ok(Some(cloth.solve_cloth(input, settings))),
            Self::Device(engine) => engine.solve_cloth(cloth, input, settings),
        }
    }

    /// Stage `solve_cloth` of fabric whose markers are in the air of the device. It is begun, and waited for with [`Self::bring_solution`].
    pub(super) fn begin_solve(
        &mut self,
        cloth: &Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => {
                let settings = engine.limited(input, settings);
                (engine.cloth).begin_solve(&cloth.structure, input, &settings)
            }
        }
    }

    /// Forms the forces of these markers on the air, by where the minimiser stands.
    pub(super) fn react_back(&self) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => engine.cloth.react_back(),
        }
    }

    /// What the device found and did at these markers, and the outcome of the solve (`None` where it is left to the host, until [`Self::fetch_nodes`]). Nothing while
    /// the solve goes on, with forces to be formed anew.
    pub(super) fn bring_solution(
        &mut self,
    ) -> Result<Option<(Option<Outcome>, AtMarkers)>, DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => {
                let brought = engine.cloth.bring_solution()?;
                let leaves = !engine.keeps_all;
                Ok(brought.map(|(outcome, at)| (engine.take(outcome, leaves), at)))
            }
        }
    }

    /// Where the nodes are while the device makes steps by itself; `None` where it cannot.
    pub(super) fn nodes_on_device(&self) -> Option<NodesOnDevice> {
        match self {
            Self::Host => None,
            Self::Device(engine) => engine.cloth.nodes_on_device(),
        }
    }

    /// Steps that may wait on the device together.
    pub(super) fn most_own_steps(&self) -> u64 {
        match self {
            Self::Host => 0,
            Self::Device(engine) => engine.cloth.most_own_steps(),
        }
    }

    /// Has the device make at most so many steps by itself, from the present state on.
    pub(super) fn begin_own_steps(
        &mut self,
        (cloth, input): (&Cloth, &StepInput),
        settings: &SolverSettings,
        most: usize,
    ) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => {
                let settings = engine.limited(input, settings);
                engine
                    .cloth
                    .begin_own_steps((cloth, input), &settings, most)
            }
        }
    }

    /// From now on a device may make steps by itself of fabric that cuts links; false where it may not.
    pub(super) fn follow_cuts(
        &mut self,
        cloth: &Cloth,
        air: (&AirScales, Option<&Patches>),
    ) -> Result<bool, DeviceError> {
        match self {
            Self::Host => Ok(false),
            Self::Device(engine) => engine.cloth.follow_cuts(&cloth.structure, air),
        }
    }

    /// Has it begin with at most so many of them, from the present state on; `met` are the density excess on both faces of every node, and buffers of the air.
    pub(super) fn begin_cut_steps(
        &mut self,
        (cloth, input): (&Cloth, &StepInput),
        settings: &SolverSettings,
        most: usize,
        met: (&[[f64; 2]], &LinksInAir<'_>),
    ) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => {
                let settings = engine.limited(input, settings);
                (engine.cloth).begin_cut_steps((cloth, input), &settings, most, met)
            }
        }
    }

    /// Records where their nodes stand among the cells.
    pub(super) fn place_among_cells(&self) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => engine.cloth.place_among_cells(),
        }
    }

    /// What the next of them did; [`Self::fetch_nodes`] is to follow.
    pub(super) fn take_cut_step(&mut self) -> Result<(Outcome, AtCuts), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => engine.cloth.take_cut_step(),
        }
    }

    /// Records the next of them, at markers whose air is known or at links of which is known what left.
    pub(super) fn make_own_step(&mut self) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => engine.cloth.make_own_step(),
        }
    }

    /// Has the device begin with them.
    pub(super) fn submit_own_steps(&mut self) -> Result<(), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => engine.cloth.submit_own_steps(),
        }
    }

    /// What the next of them did; [`Self::fetch_nodes`] is to follow.
    pub(super) fn take_own_step(&mut self) -> Result<(Outcome, AtMarkers), DeviceError> {
        match self {
            Self::Host => Err(apart()),
            Self::Device(engine) => engine.cloth.take_own_step(),
        }
    }

    /// Stage `fetch_nodes`; the outcome of a solve that was left to the host.
    pub(super) fn fetch_nodes(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Option<Outcome>, DeviceError> {
        match self {
            Self::Host => Ok(None),
            Self::Device(engine) => engine.fetch_nodes(cloth, input, settings),
        }
    }

    /// All three.
    pub(super) fn solve(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Solved, DeviceError> {
        self.send_nodes(cloth, input, settings)?;
        let solved = self.solve_cloth(cloth, input, settings)?;
        let left = self.fetch_nodes(cloth, input, settings)?;
        let outcome = solved.or(left).ok_or_else(|| {
            DeviceError::Command("a solve of the fabric has no outcome".to_owned())
        })?;
        Ok(Solved {
            outcome,
            left_to_host: left.is_some(),
        })
    }

    /// All three, driven by the host. `watch` is told of every iteration and may end it.
    pub(super) fn solve_watched(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
        watch: Watch,
    ) -> Result<Outcome, DeviceError> {
        match self {
            Self::Host => Ok(cloth.solve_cloth_watched(input, settings, watch)),
            Self::Device(engine) => engine.cloth.solve_watched(cloth, input, settings, watch),
        }
    }
}
