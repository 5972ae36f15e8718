//! Commands being recorded, counted as they come.

use std::sync::Arc;

use super::device::Device;
use super::meter::Meter;

/// Commands for one submission.
#[derive(Debug)]
pub(super) struct Commands {
    /// Copies and passes that draw are recorded here.
    pub(super) raw: wgpu::CommandEncoder,
    meter: Arc<Meter>,
    timed_passes: usize,
}

/// A compute pass.
#[derive(Debug)]
pub(super) struct Pass<'a> {
    raw: wgpu::ComputePass<'a>,
    meter: &'a Meter,
}

impl Commands {
    /// Begins a compute pass; its name is that of the stage.
    pub(super) fn pass(&mut self, label: &'static str) -> Pass<'_> {
        let reserved = self.meter.begin_pass(label);
        let timestamp_writes = reserved.as_ref().map(|(query_set, first)| {
            self.timed_passes += 1;
            wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(*first),
                end_of_pass_write_index: Some(first + 1),
            }
        });
        let raw = self.raw.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes,
        });
        Pass {
            raw,
            meter: &self.meter,
        }
    }
}

impl Pass<'_> {
    /// Records a dispatch of workgroups along x and y.
    pub(super) fn dispatch(
        &mut self,
        pipeline: &wgpu::ComputePipeline,
        group: &wgpu::BindGroup,
        [x, y]: [u32; 2],
    ) {
        self.meter.dispatched();
        self.raw.set_pipeline(pipeline);
        self.raw.set_bind_group(0, group, &[]);
        self.raw.dispatch_workgroups(x, y, 1);
    }
}

impl Device {
    /// Starts recording commands.
    pub(super) fn record(&self, label: &str) -> Commands {
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some(label) };
        Commands {
            raw: self.raw.create_command_encoder(&descriptor),
            meter: Arc::clone(&self.meter),
            timed_passes: 0,
        }
    }

    /// Submits commands, waiting for older ones if too many are in flight.
    pub(super) fn submit(&self, commands: Commands) {
        let timed = commands.timed_passes;
        self.submit_raw(commands.raw.finish());
        if timed > 0 {
            self.passes_submitted(timed);
        }
    }
}
