//! The engine that the plan chose for the fabric. Its state, [`Cloth`], is the host's wherever it is solved.

use std::sync::Arc;

use super::air::needed;
use crate::cpu::cloth::driver::STEP_PATIENCE;
use crate::cpu::cloth::{Cloth, SolverSettings, StepInput};
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

impl OnDevice {
    /// `None` where the solve is left to the host.
    fn solve_cloth(
        &mut self,
        cloth: &Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Option<Outcome>, DeviceError> {
        let leaves = input.time_step_s.is_some() && !self.keeps_all;
        let limit = if leaves { STEP_PATIENCE } else { usize::MAX };
        let settings = SolverSettings {
            evaluation_limit: settings.evaluation_limit.min(limit),
            ..*settings
        };
        let outcome = self.cloth.solve_cloth(&cloth.structure, input, &settings)?;
        self.left = (leaves && !outcome.stop.reached()).then_some(outcome);
        Ok(self.left.is_none().then_some(outcome))
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
    /// The engine for the fabric, if there is any. The air acts at markers (triangle, barycentric weights), or on triangles that are `cut`.
    pub(super) fn new(
        placement: ClothPlacement,
        cloth: Option<&Cloth>,
        (markers, cut): (&[(u32, [f64; 3])], bool),
        device: Option<&Arc<Device>>,
    ) -> Result<Self, DeviceError> {
        match (placement, cloth) {
            (ClothPlacement::Host, _) | (ClothPlacement::Device, None) => Ok(Self::Host),
            (ClothPlacement::Device, Some(cloth)) => {
                let device = Arc::clone(needed(device)?);
                let structure = &cloth.structure;
                let engine = if cut {
                    gpu::cloth::Cloth::new_cut(device, structure)?
                } else {
                    gpu::cloth::Cloth::new(device, structure, markers)?
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
