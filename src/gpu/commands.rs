//! Commands being recorded, counted as they come, and writes between them.
//!
//! A submission costs the host and the device some microseconds, so that stages leave what nobody waits for to the next one. The order stays that in which
//! they recorded and wrote.

use std::borrow::Cow;
use std::sync::{Arc, MutexGuard, PoisonError};

use bytemuck::Pod;

use super::device::{Device, TRANSFER_BYTES};
use super::meter::Meter;
use super::recorded::Recorded;

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
    fn recorded(self) -> Recorded {
        Recorded {
            raw: self.raw,
            timed_passes: self.timed_passes,
        }
    }

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

    /// The same with the workgroups that entry `index` of a buffer has once the dispatch is due: three words, along x, y and z.
    pub(super) fn dispatch_indirect(
        &mut self,
        pipeline: &wgpu::ComputePipeline,
        group: &wgpu::BindGroup,
        (workgroups, index): (&wgpu::Buffer, usize),
    ) {
        self.meter.dispatched();
        self.raw.set_pipeline(pipeline);
        self.raw.set_bind_group(0, group, &[]);
        let offset = (12 * index) as wgpu::BufferAddress;
        self.raw.dispatch_workgroups_indirect(workgroups, offset);
    }
}

/// Largest write that is recorded among commands that wait; a larger one has them submitted first.
const RECORDED_WRITE: usize = 1 << 20;

/// Recorded commands that may wait: a device should not stand idle, nor be given work for long.
const WAITING_LIMIT: usize = 16;

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

    /// Leaves commands to the next submission: they are done before whatever is submitted or written later.
    pub(super) fn leave(&self, commands: Commands) {
        let mut waiting = self.waiting();
        waiting.push(commands.recorded());
        let many = waiting.len() >= WAITING_LIMIT;
        drop(waiting);
        if many {
            self.submit_waiting();
        }
    }

    /// Submits what waits and then these, and waits for an older submission if too many are in flight.
    pub(super) fn submit(&self, commands: Commands) {
        self.waiting().push(commands.recorded());
        self.submit_waiting();
    }

    /// The same, to be waited for by itself.
    pub(super) fn submit_alone(&self, commands: Commands) -> wgpu::SubmissionIndex {
        let mut waiting = self.waiting();
        waiting.push(commands.recorded());
        self.submit_all(waiting)
    }

    /// Submits the commands that wait, if there are any.
    pub fn submit_waiting(&self) {
        let waiting = self.waiting();
        if !waiting.is_empty() {
            self.submit_all(waiting);
        }
    }

    /// Whoever finds nothing waiting may rely on its being submitted.
    fn submit_all(&self, mut waiting: MutexGuard<'_, Vec<Recorded>>) -> wgpu::SubmissionIndex {
        let timed = waiting.iter().map(|recorded| recorded.timed_passes).sum();
        let commands = waiting.drain(..).map(|recorded| recorded.raw.finish());
        let index = self.submit_raw(commands);
        drop(waiting);
        self.bound_in_flight(index.clone());
        if timed > 0 {
            self.passes_submitted(timed);
        }
        index
    }

    /// Writes `data` to a buffer, `offset` in elements, after what waits and before what is submitted later. Buffers are whole words of four bytes, and
    /// `offset` begins one; what `data` leaves of its last word becomes zero.
    pub(super) fn write<T: Pod>(&self, buffer: &wgpu::Buffer, offset: usize, data: &[T]) {
        let mut bytes: Cow<[u8]> = bytemuck::cast_slice(data).into();
        let whole_words = (bytes.len()).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT as usize);
        if whole_words > bytes.len() {
            bytes.to_mut().resize(whole_words, 0);
        }
        let bytes = bytes.as_ref();
        let start = (offset * size_of::<T>()) as u64;
        let mut waiting = self.waiting();
        if let (Some(recorded), true) = (waiting.last_mut(), bytes.len() <= RECORDED_WRITE) {
            if bytes.is_empty() {
                return;
            }
            // The queue's own writes would be done before what waits.
            let size = bytes.len() as u64;
            let staged = self.raw.create_buffer(&wgpu::BufferDescriptor {
                label: Some("write"),
                size,
                usage: wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            });
            // A device that cannot give it has failed, and says so where it is waited for.
            let Ok(mut view) = staged.get_mapped_range_mut(..) else {
                return;
            };
            view.copy_from_slice(bytes);
            drop(view);
            staged.unmap();
            recorded
                .raw
                .copy_buffer_to_buffer(&staged, 0, buffer, start, size);
            self.meter.wrote(size);
            return;
        }
        drop(waiting);
        self.submit_waiting();
        let mut done = 0;
        for chunk in bytes.chunks(TRANSFER_BYTES as usize) {
            self.queue.write_buffer(buffer, start + done, chunk);
            self.meter.wrote(chunk.len() as u64);
            done += chunk.len() as u64;
            if done < bytes.len() as u64 {
                // A staging buffer each; they are released once submitted.
                self.queue.submit([]);
                self.meter.submitted();
            }
        }
    }

    fn waiting(&self) -> MutexGuard<'_, Vec<Recorded>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
