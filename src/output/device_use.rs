//! What a run asked of its device, and what that took there.

use serde::{Deserialize, Serialize};

/// Commands, transfers and waits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceCounts {
    /// Dispatches of workgroups.
    pub dispatches: f64,
    /// Compute passes.
    pub passes: f64,
    /// Submissions of recorded commands.
    pub submits: f64,
    /// Writes of the host to a buffer.
    pub writes: f64,
    /// Bytes of these writes.
    pub written_bytes: f64,
    /// Maps of a buffer for the host, each after waiting for all that was submitted.
    pub maps: f64,
    /// Bytes of these maps.
    pub mapped_bytes: f64,
    /// Time in which the host waited for the device (s), maps included.
    pub waited_s: f64,
}

impl DeviceCounts {
    /// All of them, over `steps`.
    #[must_use]
    pub fn per(self, steps: f64) -> Self {
        Self {
            dispatches: self.dispatches / steps,
            passes: self.passes / steps,
            submits: self.submits / steps,
            writes: self.writes / steps,
            written_bytes: self.written_bytes / steps,
            maps: self.maps / steps,
            mapped_bytes: self.mapped_bytes / steps,
            waited_s: self.waited_s / steps,
        }
    }
}

/// What one stage asked for, in all steps counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviceStage {
    /// Name of the stage.
    pub stage: String,
    /// Its commands, transfers and waits.
    #[serde(flatten)]
    pub counts: DeviceCounts,
}

/// What all passes of one name took, by the device's own clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DevicePass {
    /// Name of the pass, which begins with that of its stage.
    pub pass: String,
    /// How many were timed.
    pub passes: u64,
    /// Their time (s).
    pub seconds: f64,
}

/// What asking the device costs, whatever it computes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviceLatency {
    /// Name.
    pub name: String,
    /// Median (s).
    pub seconds: f64,
    /// What was timed.
    pub meaning: String,
}

/// A run's use of its device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviceUse {
    /// Steps that were counted: those of this process since release.
    pub steps: u64,
    /// What the stages of one step asked for, on average.
    pub per_step: DeviceCounts,
    /// What every stage asked for, in all of them.
    pub stages: Vec<DeviceStage>,
    /// What was asked for besides: while the wind rises, for samples, pictures and searches for a breakdown, and waits of steps that are timed.
    pub besides_the_stages: DeviceCounts,
    /// Passes by the device's own clock, the longest first; only with `--profile`, on a device that has one.
    pub passes: Option<Vec<DevicePass>>,
    /// Latencies, measured before the run; only with `--profile`.
    pub latencies: Option<Vec<DeviceLatency>>,
}
