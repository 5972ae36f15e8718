//! The engine that the plan chose for the fabric. Its state, [`Cloth`], is the host's wherever it is solved.

use std::sync::Arc;

use super::air::needed;
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
    /// True if the host solved the present step.
    solved_by_host: bool,
    /// Solves that the host took over.
    left_to_host: u64,
}

impl OnDevice {
    fn solve_cloth(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, DeviceError> {
        let outcome = self.cloth.solve_cloth(&cloth.structure, input, settings)?;
        self.solved_by_host = input.time_step_s.is_some() && !outcome.stop.reached();
        if !self.solved_by_host {
            return Ok(outcome);
        }
        self.left_to_host += 1;
        let by_host = cloth.solve_cloth(input, settings);
        Ok(Outcome {
            iterations: outcome.iterations + by_host.iterations,
            evaluations: outcome.evaluations + by_host.evaluations,
            ..by_host
        })
    }

    fn fetch_nodes(&mut self, cloth: &mut Cloth, input: &StepInput) -> Result<(), DeviceError> {
        if self.solved_by_host {
            return Ok(());
        }
        self.cloth.fetch_nodes(cloth, input)
    }
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
                    solved_by_host: false,
                    left_to_host: 0,
                })))
            }
        }
    }

    /// Solves that a device left unsolved, and the host took over.
    pub(super) const fn left_to_host(&self) -> u64 {
        match self {
            Self::Host => 0,
            Self::Device(engine) => engine.left_to_host,
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

    /// Stage `solve_cloth`; on a device on what was sent, and the solution stays there unless the host took over.
    pub(super) fn solve_cloth(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, DeviceError> {
        match self {
            Self::Host => Ok(cloth.solve_cloth(input, settings)),
            Self::Device(engine) => engine.solve_cloth(cloth, input, settings),
        }
    }

    /// Stage `fetch_nodes`.
    pub(super) fn fetch_nodes(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
    ) -> Result<(), DeviceError> {
        match self {
            Self::Host => Ok(()),
            Self::Device(engine) => engine.fetch_nodes(cloth, input),
        }
    }

    /// All three.
    pub(super) fn solve(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, DeviceError> {
        match self {
            Self::Host => Ok(cloth.solve_cloth(input, settings)),
            Self::Device(engine) => {
                engine.cloth.send_nodes(cloth, input, settings)?;
                let outcome = engine.solve_cloth(cloth, input, settings)?;
                engine.fetch_nodes(cloth, input)?;
                Ok(outcome)
            }
        }
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
