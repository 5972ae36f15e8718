//! What the host asks of a device, counted; and, on request, what the device's passes take by the device's own clock.
//!
//! Counters are always on: they are a few additions per command. The clock writes two timestamps per pass. It brings them back some
//! five hundred passes at a time, so it is on only where a run is to be profiled ([`super::Device::time_passes`]).

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::pass_clock::PassClock;

/// What was asked of a device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DeviceWork {
    /// Compute passes.
    pub passes: u64,
    /// Dispatches of workgroups.
    pub dispatches: u64,
    /// Submissions of recorded commands.
    pub submits: u64,
    /// Writes of the host to a buffer.
    pub writes: u64,
    /// Bytes of these writes.
    pub written_bytes: u64,
    /// Maps of a buffer for the host, each after waiting for all that was submitted.
    pub maps: u64,
    /// Bytes of these maps.
    pub mapped_bytes: u64,
    /// Time in which the host waited for the device \[ns\], maps included.
    pub waited_ns: u64,
}

impl DeviceWork {
    /// What was asked since an earlier look.
    #[must_use]
    pub const fn since(&self, earlier: &Self) -> Self {
        Self {
            passes: self.passes.saturating_sub(earlier.passes),
            dispatches: self.dispatches.saturating_sub(earlier.dispatches),
            submits: self.submits.saturating_sub(earlier.submits),
            writes: self.writes.saturating_sub(earlier.writes),
            written_bytes: self.written_bytes.saturating_sub(earlier.written_bytes),
            maps: self.maps.saturating_sub(earlier.maps),
            mapped_bytes: self.mapped_bytes.saturating_sub(earlier.mapped_bytes),
            waited_ns: self.waited_ns.saturating_sub(earlier.waited_ns),
        }
    }
}

impl std::ops::AddAssign for DeviceWork {
    fn add_assign(&mut self, other: Self) {
        self.passes += other.passes;
        self.dispatches += other.dispatches;
        self.submits += other.submits;
        self.writes += other.writes;
        self.written_bytes += other.written_bytes;
        self.maps += other.maps;
        self.mapped_bytes += other.mapped_bytes;
        self.waited_ns += other.waited_ns;
    }
}

/// Counters of a device; any thread may add.
#[derive(Debug, Default)]
pub(super) struct Meter {
    passes: AtomicU64,
    dispatches: AtomicU64,
    submits: AtomicU64,
    writes: AtomicU64,
    written_bytes: AtomicU64,
    maps: AtomicU64,
    mapped_bytes: AtomicU64,
    waited_ns: AtomicU64,
    clock: Mutex<Option<PassClock>>,
}

fn add(counter: &AtomicU64, amount: u64) {
    counter.fetch_add(amount, Ordering::Relaxed);
}

impl Meter {
    pub(super) fn work(&self) -> DeviceWork {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        DeviceWork {
            passes: of(&self.passes),
            dispatches: of(&self.dispatches),
            submits: of(&self.submits),
            writes: of(&self.writes),
            written_bytes: of(&self.written_bytes),
            maps: of(&self.maps),
            mapped_bytes: of(&self.mapped_bytes),
            waited_ns: of(&self.waited_ns),
        }
    }

    pub(super) fn submitted(&self) {
        add(&self.submits, 1);
    }

    pub(super) fn wrote(&self, bytes: u64) {
        add(&self.writes, 1);
        add(&self.written_bytes, bytes);
    }

    pub(super) fn mapped(&self, bytes: u64) {
        add(&self.maps, 1);
        add(&self.mapped_bytes, bytes);
    }

    pub(super) fn waited(&self, time: Duration) {
        add(&self.waited_ns, time.as_nanos() as u64);
    }

    /// The clock; `None` where passes are not timed.
    pub(super) fn clock(&self) -> MutexGuard<'_, Option<PassClock>> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a pass, and reserves its timestamps where the clock is on: their set and the number of the first.
    pub(super) fn begin_pass(&self, label: &'static str) -> Option<(wgpu::QuerySet, u32)> {
        add(&self.passes, 1);
        self.clock().as_mut().and_then(|clock| clock.reserve(label))
    }

    pub(super) fn dispatched(&self) {
        add(&self.dispatches, 1);
    }
}
