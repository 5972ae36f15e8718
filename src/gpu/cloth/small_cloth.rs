//! Stage `minimise` of small fabric (`shaders/small_cloth.wgsl`): one workgroup goes through a whole solve.
//!
//! A trial of a batch takes eight or more dispatches, each of which waits for the one before; within a workgroup barriers do, and the host records one
//! dispatch. But one workgroup has one of a device's many processors, so that large fabric is solved in batches ([`super::batches`]).

use crate::gpu::adapters::AdapterKind;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders::{self, WORKGROUP};

use super::elements::Kind;
use super::host_constants::constants_of_the_host;
use super::slots::DRIVE;

/// Nodes of the largest fabric that is solved so on a graphics device (docs/results/2026-11-27-fabric-on-the-device.md).
const NODES: usize = 2500;
/// Threads of the workgroup, where the device allows them.
const THREADS: u32 = 512;
/// Trials of one dispatch at most, so that no device is kept busy for long.
const TRIALS: u32 = 128;
/// The same on software adapters: Mesa's ends every loop of a thread that has gone round 65 535 times, all its loops counted together.
const TRIALS_OF_SOFTWARE: u32 = 8;
/// Buffers of a structure without elements.
const BUFFERS: usize = 16;
/// Buffers of a kind of elements at most.
const BUFFERS_OF_KIND: usize = 3;

/// The minimiser with its buffers.
#[derive(Debug)]
pub(super) struct SmallCloth {
    pub bound: Bound,
    /// Trials of one dispatch.
    trials: usize,
}

impl SmallCloth {
    /// With its buffers.
    pub fn new(
        device: &Device,
        pipeline: &Pipeline,
        buffers: &[(&str, &wgpu::Buffer)],
    ) -> Result<Self, DeviceError> {
        Ok(Self {
            bound: device.bind(pipeline, buffers)?,
            trials: trials(device.info().kind) as usize,
        })
    }

    /// Dispatches after which a solve has had so many evaluations: the first of all is that of the start.
    pub const fn dispatches(&self, evaluations: usize) -> usize {
        evaluations.div_ceil(self.trials)
    }
}

/// Trials of one dispatch.
const fn trials(kind: AdapterKind) -> u32 {
    match kind {
        AdapterKind::Software => TRIALS_OF_SOFTWARE,
        _ => TRIALS,
    }
}

/// The pipeline for a structure of these kinds of elements; `None` where batches are faster, or the device cannot hold all buffers at once.
pub(super) fn pipeline(
    device: &Device,
    nodes: usize,
    kinds: &[Kind],
    constants: &[(&str, f64)],
) -> Result<Option<Pipeline>, DeviceError> {
    let info = device.info();
    let usual = match info.kind {
        // One workgroup is one thread of the host there, and barriers are dear.
        AdapterKind::Software => 0,
        _ => NODES,
    };
    let limit = device.tuning().small_cloth_nodes.unwrap_or(usual);
    let buffers = BUFFERS + BUFFERS_OF_KIND * kinds.len();
    if nodes > limit || buffers > info.storage_buffer_limit as usize {
        return Ok(None);
    }
    let threads = (THREADS.min(device.thread_limit()) + 1).next_power_of_two() / 2;
    let mut constants = constants.to_vec();
    constants.extend(constants_of_the_host());
    constants.extend([
        ("SMALL_WORKGROUP", f64::from(threads.max(WORKGROUP))),
        ("TRIALS", f64::from(trials(info.kind))),
        ("DRIVE", f64::from(DRIVE)),
    ]);
    let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
    let shader = (shaders::SMALL_CLOTH.name, source(&names));
    match device.pipelines_of(shader, ["solve_small_cloth"], &constants) {
        Ok([pipeline]) => Ok(Some(pipeline)),
        // A driver that cannot compile it still has batches.
        Err(DeviceError::Pipeline { .. }) => Ok(None),
        Err(other) => Err(other),
    }
}

/// The shader with these kinds of elements alone.
fn source(kinds: &[&str]) -> String {
    let call = |kind: &&str| format!(" {kind}_force(e); }}");
    let calls: Vec<String> = kinds.iter().map(call).collect();
    let kept = |line: &&str| {
        let is_call = line.ends_with("_force(e); }");
        !is_call || calls.iter().any(|call| line.ends_with(call))
    };
    let whole = shaders::SMALL_CLOTH.source();
    let mut lines: Vec<&str> = whole.lines().filter(kept).collect();
    lines.push("");
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_structure_gets_the_elements_that_it_has() {
        let calls = |kinds: &[&str]| source(kinds).matches("_force(e); }").count();
        assert_eq!(calls(&[]), 0);
        assert_eq!(calls(&["triangle", "cable", "marker"]), 3);
        assert_eq!(calls(&["permeable_marker"]), 1);
        assert_eq!(calls(&["cut_triangle", "triangle"]), 2);
        let every = shaders::SMALL_CLOTH.source();
        assert_eq!(every.matches("_force(e); }").count(), 11);
    }
}
