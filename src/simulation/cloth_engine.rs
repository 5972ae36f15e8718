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
    Device(Box<gpu::cloth::Cloth>),
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
                Ok(Self::Device(Box::new(engine)))
            }
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
            Self::Device(engine) => engine.send_nodes(cloth, input, settings),
        }
    }

    /// Stage `solve_cloth`; on a device on what was sent, and the solution stays there.
    pub(super) fn solve_cloth(
        &mut self,
        cloth: &mut Cloth,
        input: &StepInput,
        settings: &SolverSettings,
    ) -> Result<Outcome, DeviceError> {
        match self {
            Self::Host => Ok(cloth.solve_cloth(input, settings)),
            Self::Device(engine) => engine.solve_cloth(&cloth.structure, input, settings),
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
            Self::Device(engine) => engine.solve(cloth, input, settings),
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
            Self::Device(engine) => engine.solve_watched(cloth, input, settings, watch),
        }
    }
}
