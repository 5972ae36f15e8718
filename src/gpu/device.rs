//! An open device: buffers, transfers, submissions, and the faults that arrive late.
//!
//! wgpu reports most failures after the call that caused them. The first one is kept here, and every transfer back to the
//! host, where a run waits anyway, returns it as a [`DeviceError`].

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use bytemuck::Pod;

use super::adapters::{self, AdapterChoice, AdapterInfo, AdapterKind};
use super::error::DeviceError;
use super::latency::Latencies;
use super::meter::{DeviceWork, Meter};
use super::recorded::Recorded;
use super::tuning::Tuning;

/// Submissions in flight before the host waits for the oldest: enough to keep a device busy, few enough that what they hold is
/// released soon.
const IN_FLIGHT: usize = 3;

/// Bytes moved in one transfer.
pub(super) const TRANSFER_BYTES: u64 = 32 << 20;

/// How long the host waits for a submission before it declares the device lost.
pub(super) const TIMEOUT: Duration = Duration::from_secs(120);

/// How long a thread asks for the end of the work before it sleeps until then.
const ASKING: Duration = Duration::from_millis(1);

/// Features taken where an adapter offers them: populations in 16 bits, and the clock of `--profile`.
const WANTED_FEATURES: wgpu::Features =
    wgpu::Features::SHADER_F16.union(wgpu::Features::TIMESTAMP_QUERY);

type Fault = Arc<Mutex<Option<DeviceError>>>;

/// An adapter opened for computing.
#[derive(Debug)]
pub struct Device {
    pub(super) raw: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    info: AdapterInfo,
    passed_over: Vec<String>,
    limits: wgpu::Limits,
    fault: Fault,
    in_flight: Mutex<VecDeque<wgpu::SubmissionIndex>>,
    /// Recorded, and left to the next submission.
    pub(super) waiting: Mutex<Vec<Recorded>>,
    pub(super) meter: Arc<Meter>,
    pub(super) latencies: OnceLock<Latencies>,
    tuning: Tuning,
}

fn note(fault: &Fault, error: DeviceError) {
    let mut first = fault.lock().unwrap_or_else(PoisonError::into_inner);
    // A loss explains whatever else was reported with it.
    let explains = matches!(error, DeviceError::Lost(_))
        && !matches!(*first, Some(DeviceError::OutOfMemory { .. }));
    if first.is_none() || explains {
        *first = Some(error);
    }
}

impl Device {
    /// Opens the best adapter of a choice with all the limits it offers; where the driver refuses, the next one.
    pub fn open(choice: &AdapterChoice) -> Result<Arc<Self>, DeviceError> {
        Self::open_tuned(choice, Tuning::default())
    }

    /// The same, with choices that a benchmark compares.
    pub fn open_tuned(choice: &AdapterChoice, tuning: Tuning) -> Result<Arc<Self>, DeviceError> {
        let open = |(adapter, info): &(wgpu::Adapter, AdapterInfo)| {
            let descriptor = wgpu::DeviceDescriptor {
                label: Some("ripstop"),
                required_features: adapter.features() & WANTED_FEATURES,
                required_limits: adapter.limits(),
                memory_hints: wgpu::MemoryHints::Performance,
                ..wgpu::DeviceDescriptor::default()
            };
            pollster::block_on(adapter.request_device(&descriptor))
                .map_err(|error| format!("{} ({error})", info.name))
        };
        let ((adapter, info), (raw, queue), passed_over) =
            adapters::first_that_opens(adapters::fitting(choice)?, open)?;
        let limits = adapter.limits();
        let fault = Fault::default();
        let late = Arc::clone(&fault);
        raw.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            note(&late, DeviceError::from_wgpu(&error, "computing"));
        }));
        let lost = Arc::clone(&fault);
        raw.set_device_lost_callback(move |reason, message| {
            note(&lost, DeviceError::Lost(format!("{reason:?}: {message}")));
        });
        Ok(Arc::new(Self {
            raw,
            queue,
            info,
            passed_over,
            limits,
            fault,
            in_flight: Mutex::default(),
            waiting: Mutex::default(),
            meter: Arc::default(),
            latencies: OnceLock::new(),
            tuning,
        }))
    }

    /// Opens the adapter of a device anew, once that one is lost; its passes are timed as before.
    pub fn open_again(lost: &Self) -> Result<Arc<Self>, DeviceError> {
        let choice = AdapterChoice::Exactly(Box::new(lost.info.clone()));
        let device = Self::open_tuned(&choice, lost.tuning)?;
        if lost.meter.clock().is_some() {
            device.time_passes();
        }
        Ok(device)
    }

    /// The adapter.
    #[must_use]
    pub const fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// Better adapters that did not open, each with the driver's reason.
    #[must_use]
    pub fn passed_over(&self) -> &[String] {
        &self.passed_over
    }

    /// What a benchmark chose otherwise.
    #[must_use]
    pub const fn tuning(&self) -> Tuning {
        self.tuning
    }

    /// All that was asked of the device so far.
    #[must_use]
    pub fn work(&self) -> DeviceWork {
        self.meter.work()
    }

    /// Threads allowed in one workgroup along x.
    #[must_use]
    pub fn thread_limit(&self) -> u32 {
        let limits = &self.limits;
        (limits.max_compute_invocations_per_workgroup).min(limits.max_compute_workgroup_size_x)
    }

    /// Workgroups allowed along one dimension of a dispatch.
    #[must_use]
    pub const fn workgroup_limit(&self) -> u32 {
        self.limits.max_compute_workgroups_per_dimension
    }

    /// Fails where populations cannot be stored in 16 bits.
    pub fn require_f16(&self) -> Result<(), DeviceError> {
        if self.raw.features().contains(wgpu::Features::SHADER_F16) {
            return Ok(());
        }
        Err(DeviceError::Feature {
            what: "store numbers of 16 bits",
            device: self.info.name.clone(),
            remedy: "use --precision f32",
        })
    }

    /// Gives the device up; what follows fails with [`DeviceError::Lost`]. For tests of that failure.
    pub fn destroy(&self) {
        self.raw.destroy();
    }

    /// The first failure that was reported, if any.
    pub fn check(&self) -> Result<(), DeviceError> {
        match &*self.fault.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error.clone()),
            None => Ok(()),
        }
    }

    /// Runs `work` and returns what the device has to say about it at once.
    pub(super) fn guarded<T>(
        &self,
        doing: &str,
        work: impl FnOnce() -> T,
    ) -> Result<T, DeviceError> {
        let memory = self.raw.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = self.raw.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = self.raw.push_error_scope(wgpu::ErrorFilter::Validation);
        let result = work();
        let errors = [
            pollster::block_on(validation.pop()),
            pollster::block_on(internal.pop()),
            pollster::block_on(memory.pop()),
        ];
        self.check()?;
        match errors.into_iter().flatten().next() {
            Some(error) => Err(DeviceError::from_wgpu(&error, doing)),
            None => Ok(result),
        }
    }

    /// A buffer of `bytes` (rounded up to 16), filled with zeros.
    pub(super) fn buffer(
        &self,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, DeviceError> {
        let size = bytes.div_ceil(16).max(1) * 16;
        let too_large = |limit: u64, limit_name: &'static str| DeviceError::Limit {
            what: format!("the buffer \"{label}\""),
            needed: size,
            limit,
            limit_name,
            device: self.info.name.clone(),
            remedy: "make the case coarser or smaller, or compute it on the CPU (--engine cpu, --cloth host)",
        };
        if size > self.limits.max_buffer_size {
            return Err(too_large(self.limits.max_buffer_size, "max_buffer_size"));
        }
        let bound = usage.contains(wgpu::BufferUsages::STORAGE);
        if bound && size > self.limits.max_storage_buffer_binding_size {
            return Err(too_large(
                self.limits.max_storage_buffer_binding_size,
                "max_storage_buffer_binding_size",
            ));
        }
        self.guarded(&format!("allocating {size} bytes for \"{label}\""), || {
            self.raw.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        })
    }

    /// A storage buffer that can be written from and read to the host.
    pub(super) fn storage(&self, label: &str, bytes: u64) -> Result<wgpu::Buffer, DeviceError> {
        self.buffer(
            label,
            bytes,
            wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
        )
    }

    /// A storage buffer that holds `data`.
    pub(super) fn storage_of<T: Pod>(
        &self,
        label: &str,
        data: &[T],
    ) -> Result<wgpu::Buffer, DeviceError> {
        let buffer = self.storage(label, size_of_val(data) as u64)?;
        self.write(&buffer, 0, data);
        Ok(buffer)
    }

    /// A buffer of parameters.
    pub(super) fn uniform<T: Pod>(&self, label: &str) -> Result<wgpu::Buffer, DeviceError> {
        self.buffer(
            label,
            size_of::<T>() as u64,
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        )
    }

    /// Submits commands.
    pub(super) fn submit_raw(
        &self,
        commands: impl Iterator<Item = wgpu::CommandBuffer>,
    ) -> wgpu::SubmissionIndex {
        self.meter.submitted();
        self.queue.submit(commands)
    }

    /// Waits for older submissions if too many are in flight with this one.
    pub(super) fn bound_in_flight(&self, index: wgpu::SubmissionIndex) {
        let oldest = {
            let mut in_flight = self
                .in_flight
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            in_flight.push_back(index);
            if in_flight.len() > IN_FLIGHT {
                in_flight.pop_front()
            } else {
                None
            }
        };
        if oldest.is_some() {
            self.poll_counted(oldest, None);
        }
    }

    /// [`Device::poll`], its time counted as time that the host waited.
    fn poll_counted(
        &self,
        submission_index: Option<wgpu::SubmissionIndex>,
        done: Option<&AtomicBool>,
    ) {
        let start = Instant::now();
        self.poll(submission_index, done);
        self.meter.waited(start.elapsed());
    }

    /// Waits for a submission (the last one if `None`), which may set a flag once it is `done`; a failure is kept for [`Device::check`].
    pub(super) fn poll(
        &self,
        submission_index: Option<wgpu::SubmissionIndex>,
        done: Option<&AtomicBool>,
    ) {
        if self.check().is_err() {
            // A device that has failed is not asked again: every answer would take the whole timeout.
            return;
        }
        // wgpu 30 panics where the driver reports the loss of a device to a waiting host.
        let waited = catch_unwind(AssertUnwindSafe(|| {
            if (submission_index.is_none() || done.is_some()) && self.is_done_soon(done) {
                return Ok(wgpu::PollStatus::QueueEmpty);
            }
            self.raw.poll(wgpu::PollType::Wait {
                submission_index,
                timeout: Some(TIMEOUT),
            })
        }));
        let why = match waited {
            Err(_) => "reported while waiting for it".to_owned(),
            Ok(Err(wgpu::PollError::Timeout)) => {
                format!("no answer within {} s", TIMEOUT.as_secs())
            }
            // The other failure is an index that a refused submission never got; that refusal is on record.
            Ok(_) => return,
        };
        if self.check().is_ok() {
            note(&self.fault, DeviceError::Lost(why));
        }
    }

    /// Asks for a while whether everything submitted is done, or what sets a flag: a thread that sleeps is told some 30 µs later on a graphics card (docs/results/2026-11-26-graphics-card.md). A software adapter
    /// needs the processor itself.
    fn is_done_soon(&self, done: Option<&AtomicBool>) -> bool {
        let start = Instant::now();
        while self.info.kind != AdapterKind::Software && start.elapsed() < ASKING {
            let status = self.raw.poll(wgpu::PollType::Poll);
            let is_set = done.is_some_and(|done| done.load(Ordering::Acquire));
            if is_set || matches!(status, Ok(status) if status.is_queue_empty()) {
                return true;
            }
            std::hint::spin_loop();
        }
        false
    }

    /// Sleeps until everything recorded is done, without asking before.
    pub(super) fn sleep(&self) -> Result<(), DeviceError> {
        self.submit_waiting();
        let asleep = self.raw.poll(wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(TIMEOUT),
        });
        if asleep.is_err() {
            return Err(DeviceError::Lost("no answer to a poll".to_owned()));
        }
        self.check()
    }

    /// Waits until a submission is done, whatever came after it; `done` is set as soon as what it brings is there.
    pub(super) fn wait_for(
        &self,
        submitted: wgpu::SubmissionIndex,
        done: &AtomicBool,
    ) -> Result<(), DeviceError> {
        self.poll_counted(Some(submitted), Some(done));
        self.check()
    }

    /// Waits until everything recorded is done.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.submit_waiting();
        self.poll_counted(None, None);
        self.in_flight
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clear();
        self.check()
    }
}
