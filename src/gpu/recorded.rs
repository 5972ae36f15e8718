//! Commands that were recorded and wait for their submission.

/// Commands for the next submission.
#[derive(Debug)]
pub(super) struct Recorded {
    pub(super) raw: wgpu::CommandEncoder,
    /// Passes that the device's clock times.
    pub(super) timed_passes: usize,
}
