//! What a run has cost so far.

use std::time::Duration;

use crate::gpu::DeviceWork;
use crate::plan::Stage;

/// Wall time per stage and work done.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Eddy viscosity, collide and stream.
    pub fluid: Duration,
    /// Interpolate and spread.
    pub coupling: Duration,
    /// Solve the cloth.
    pub cloth: Duration,
    /// Contact of fabric with itself; part of `cloth`.
    pub contact: Duration,
    /// Measure.
    pub measure: Duration,
    /// Iterations of the minimiser.
    pub iterations: u64,
    /// Evaluations of the objective.
    pub evaluations: u64,
    /// Solves that ended without reaching their tolerance.
    pub unconverged: u64,
    /// Solves.
    pub solves: u64,
    /// Those that a device left to the host.
    pub left_to_host: u64,
    /// Steps that a device made by itself.
    pub own_steps: u64,
    /// The static equilibrium at the end, apart from the steps.
    pub equilibrium: Duration,
    /// Cell updates in the steps whose stages were timed, as many in each as on the mean.
    pub timed_cells: u64,
    /// Steps whose stages were timed: all, or some where a device works while the host goes on.
    pub timed_steps: u64,
    /// Steps done since release.
    pub steps: u64,
    /// What had been asked of the device before the first.
    pub device_before: DeviceWork,
    /// What every stage took in the timed steps, in the order of [`Stage::ALL`].
    pub stages: [StageCost; Stage::ALL.len()],
}

/// What a stage took in the timed steps.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageCost {
    /// Steps in which it was due.
    pub calls: u64,
    /// Wall time.
    pub time: Duration,
    /// What it asked of the device, in all steps since release.
    pub device: DeviceWork,
}

impl Cost {
    /// What a stage took.
    #[must_use]
    pub const fn of(&self, stage: Stage) -> StageCost {
        self.stages[stage as usize]
    }
}
