//! Pipelines that read density and velocity back from the populations, with their buffers.

use super::names::by_parity;
use super::parameters::Region;
use crate::gpu::device::{Device, TRANSFER_BYTES};
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::Bound;
use crate::gpu::shaders;
use crate::lattice::Storage;
use crate::lattice::grid::Grid;

/// Cells fetched in one transfer.
pub(super) const CELLS_AT_ONCE: u64 = TRANSFER_BYTES / 16;

/// Words of 32 bits that a workgroup of `totals` or `extremes` writes.
pub(super) const SUMS: usize = 8;

/// Pipelines with their buffers, by parity.
#[derive(Debug)]
pub(super) struct ReadBack {
    pub(super) region: wgpu::Buffer,
    pub(super) states: wgpu::Buffer,
    pub(super) states_at_once: u64,
    pub(super) partial_sums: wgpu::Buffer,
    pub(super) macroscopic: [Bound; 2],
    pub(super) totals: [Bound; 2],
    pub(super) extremes: [Bound; 2],
}

impl ReadBack {
    pub(super) fn new(
        device: &Device,
        grid: &Grid,
        storage: Storage,
        populations: &[wgpu::Buffer],
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        let cells = grid.cell_count() as u64;
        let states_at_once = cells.min(CELLS_AT_ONCE);
        let region = device.uniform::<Region>("region")?;
        let states = device.storage("states", 16 * states_at_once)?;
        let [x, y] = device.workgroups(cells);
        let partial_sums = device.storage(
            "partial sums",
            4 * SUMS as u64 * u64::from(x) * u64::from(y),
        )?;
        let pipelines = device.pipelines(
            &shaders::MACROSCOPIC[storage as usize],
            ["macroscopic", "totals", "extremes"],
            constants,
        )?;
        let bound = |k: usize, odd: bool| -> Result<Bound, DeviceError> {
            let mut named = by_parity(populations, odd);
            named.extend([
                ("region", &region),
                ("states", &states),
                ("partial_sums", &partial_sums),
                // As many bytes, and never both at a time.
                ("group_extremes", &partial_sums),
            ]);
            device.bind(&pipelines[k], &named)
        };
        let both =
            |k| -> Result<[Bound; 2], DeviceError> { Ok([bound(k, false)?, bound(k, true)?]) };
        let (macroscopic, totals, extremes) = (both(0)?, both(1)?, both(2)?);
        Ok(Self {
            macroscopic,
            totals,
            extremes,
            region,
            states,
            states_at_once,
            partial_sums,
        })
    }
}
