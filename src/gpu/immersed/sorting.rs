//! What a device sorts its markers with, where no host is asked ([`super::sort_markers`]).

use glam::DVec3;

use crate::gpu::cloth::NodesOnDevice;
use crate::gpu::pipeline::{Bound, Pipeline};

/// The lattice in space.
#[derive(Debug, Clone, Copy)]
pub struct LatticeInSpace {
    /// Centre of its first cell [m].
    pub first_centre_m: DVec3,
    /// Size of a cell [m].
    pub cell_size_m: f64,
}

/// What the device sorts its markers with.
#[derive(Debug)]
pub(super) struct Sorting {
    pub lattice: LatticeInSpace,
    pub pipelines: [Pipeline; 5],
    pub nodes: NodesOnDevice,
    pub parameters: wgpu::Buffer,
    pub areas: wgpu::Buffer,
    pub unsorted: wgpu::Buffer,
    pub scattered: wgpu::Buffer,
    pub boxed: Option<SortedBox>,
}

/// What belongs to the cells of the box.
#[derive(Debug)]
pub(super) struct SortedBox {
    pub generation: u64,
    /// Cell by cell, block by block, marker by marker.
    pub find_cells: Bound,
    pub scan_cells: Bound,
    pub scan_blocks: Bound,
    pub scatter_markers: Bound,
    pub rank_markers: Bound,
}
