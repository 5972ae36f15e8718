//! Choices about how a device works that change its speed, not its formulas; `ripstop bench device` compares those of the air.

use std::time::Duration;

/// How the arrays of populations are padded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Padding {
    /// Not at all.
    None,
    /// Planes to multiples of 32 elements, so that the threads of a plane begin on a cache line.
    #[default]
    Planes,
    /// Rows to multiples of 32 elements, so that neighbours along y and z begin on one too.
    Rows,
}

/// The choices; the default is what runs take, and what was fastest on an NVIDIA H100 (docs/results/2026-11-26-graphics-card.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tuning {
    /// Threads of a workgroup of `collide_stream`.
    pub workgroup: u32,
    /// Padding of the arrays.
    pub padding: Padding,
    /// Whether `collide_stream` checks that it stays inside its buffers, as all other shaders do.
    pub bounds_checks: bool,
    /// Nodes of the largest fabric whose time steps are solved by one workgroup; `None`: by the kind of adapter, as
    /// measured on an NVIDIA H100 and Mesa's software adapter.
    pub small_cloth_nodes: Option<usize>,
    /// Commands that take no longer wait for the next submission: as many as may wait stay well below two seconds together, after which
    /// watchdogs bite.
    pub longest_left: Duration,
    /// Whether cells that the structure does not touch begin their next step while the host works on the structure, and whole steps are made without it.
    pub goes_ahead: bool,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            workgroup: 256,
            padding: Padding::Planes,
            bounds_checks: true,
            small_cloth_nodes: None,
            longest_left: Duration::from_millis(15),
            goes_ahead: true,
        }
    }
}
