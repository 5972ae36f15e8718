//! Passes timed by the device's own clock: from when on, and what they took.

use std::collections::BTreeMap;
use std::sync::mpsc;

use super::device::{Device, TIMEOUT};
use super::error::DeviceError;
use super::pass_clock::{PASSES, PassClock, PassTime};

impl PassClock {
    /// `None` where the device has no timestamps.
    fn new(device: &Device) -> Option<Self> {
        if !device
            .raw
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
        {
            return None;
        }
        let size = 2 * PASSES as u64 * u64::from(wgpu::QUERY_SIZE);
        let buffer = |label, usage| {
            device.raw.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: device.raw.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES as u32,
            }),
            resolved: buffer(
                "timestamps",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            fetched: buffer(
                "fetched timestamps",
                wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            ),
            seconds_per_tick: 1e-9 * f64::from(device.queue.get_timestamp_period()),
            reserved: Vec::new(),
            submitted: 0,
            sums: BTreeMap::new(),
        })
    }

    /// Brings back what was submitted, and adds it up.
    fn fetch(&mut self, device: &Device) -> Result<(), DeviceError> {
        let passes = self.submitted;
        if passes == 0 || passes < self.reserved.len() {
            // Commands that are still being recorded will come.
            return Ok(());
        }
        let bytes = 2 * passes as u64 * u64::from(wgpu::QUERY_SIZE);
        let mut commands = device
            .raw
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("timestamps"),
            });
        commands.resolve_query_set(&self.queries, 0..2 * passes as u32, &self.resolved, 0);
        commands.copy_buffer_to_buffer(&self.resolved, 0, &self.fetched, 0, bytes);
        device.queue.submit([commands.finish()]);
        let (sender, receiver) = mpsc::channel();
        self.fetched
            .map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
                // The receiver waits below, or has given up.
                let _ = sender.send(result.is_ok());
            });
        device.poll(None, None);
        device.check()?;
        let lost = || DeviceError::Lost("timestamps could not be read back".to_owned());
        if receiver.recv_timeout(TIMEOUT) != Ok(true) {
            return Err(lost());
        }
        {
            let view = self
                .fetched
                .get_mapped_range(0..bytes)
                .map_err(|_| lost())?;
            let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&view);
            for (label, ends) in self.reserved.drain(..).zip(ticks.chunks_exact(2)) {
                let sum = self.sums.entry(label).or_default();
                sum.0 += 1;
                sum.1 += self.seconds_per_tick * ends[1].saturating_sub(ends[0]) as f64;
            }
        }
        self.fetched.unmap();
        self.submitted = 0;
        Ok(())
    }
}

impl Device {
    /// Times every pass from now on by the device's own clock, from zero; false where the device has none.
    pub fn time_passes(&self) -> bool {
        // Passes that wait are of the clock before.
        self.submit_waiting();
        let clock = PassClock::new(self);
        let possible = clock.is_some();
        *self.meter.clock() = clock;
        possible
    }

    /// Ends that, and forgets what was timed.
    pub fn stop_timing_passes(&self) {
        self.submit_waiting();
        *self.meter.clock() = None;
    }

    /// What passes took since they are timed, the longest first; `None` where they are not.
    pub fn pass_times(&self) -> Result<Option<Vec<PassTime>>, DeviceError> {
        self.submit_waiting();
        let mut clock = self.meter.clock();
        let Some(clock) = clock.as_mut() else {
            return Ok(None);
        };
        clock.fetch(self)?;
        let mut times: Vec<PassTime> = clock
            .sums
            .iter()
            .map(|(pass, &(passes, seconds))| PassTime {
                pass: (*pass).to_owned(),
                passes,
                seconds,
            })
            .collect();
        times.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        Ok(Some(times))
    }

    /// Takes note of timed passes that were submitted; a failure shows at the next check.
    pub(super) fn passes_submitted(&self, passes: usize) {
        let mut clock = self.meter.clock();
        if let Some(clock) = clock.as_mut()
            && clock.note_submitted(passes)
        {
            // A failure is on record with the device.
            let _ = clock.fetch(self);
        }
    }
}
