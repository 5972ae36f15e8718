//! The device's own clock: two timestamps around every compute pass, brought back many passes at a time.
//!
//! What a pass takes on the device is what remains of a step if the host never waits; `ripstop run --profile` prints it beside the time
//! that the host sees. Fetching waits for the device, once in some five hundred passes, and is counted nowhere.

use std::collections::BTreeMap;

/// Passes between two looks; a set of queries holds 4096 at most.
pub(super) const PASSES: usize = 1024;

/// What all passes of one name took on the device.
#[derive(Debug, Clone, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: String,
    /// How many were timed.
    pub passes: u64,
    /// Time by the device's clock \[s\].
    pub seconds: f64,
}

/// Timestamps not yet fetched, and the sums of those that were.
#[derive(Debug)]
pub(super) struct PassClock {
    pub(super) queries: wgpu::QuerySet,
    pub(super) resolved: wgpu::Buffer,
    pub(super) fetched: wgpu::Buffer,
    pub(super) seconds_per_tick: f64,
    /// Names of the passes that have timestamps, in their order.
    pub(super) reserved: Vec<&'static str>,
    /// How many of them were submitted.
    pub(super) submitted: usize,
    pub(super) sums: BTreeMap<&'static str, (u64, f64)>,
}

impl PassClock {
    /// Timestamps for a pass: their set, and the number of the first of two. `None` where all are taken; such a pass is not timed.
    pub(super) fn reserve(&mut self, label: &'static str) -> Option<(wgpu::QuerySet, u32)> {
        if self.reserved.len() == PASSES {
            return None;
        }
        let first = 2 * self.reserved.len() as u32;
        self.reserved.push(label);
        Some((self.queries.clone(), first))
    }

    /// Takes note that so many timed passes were submitted; true where it is time to fetch them.
    pub(super) fn note_submitted(&mut self, passes: usize) -> bool {
        self.submitted += passes;
        self.submitted == self.reserved.len() && 2 * self.submitted > PASSES
    }
}
