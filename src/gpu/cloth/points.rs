//! Positions of the minimiser's points, brought to the host.

use glam::DVec3;

use super::elements::joined;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::transfer::Staging;

/// A point on the device.
#[derive(Debug)]
pub(super) struct PointSlot(pub u32);

/// Where points are stored: whole and remainder of every coordinate.
#[derive(Debug)]
pub(super) struct Points<'a> {
    pub device: &'a Device,
    pub staging: &'a Staging,
    pub whole: &'a wgpu::Buffer,
    pub remainder: &'a wgpu::Buffer,
    pub nodes: usize,
}

impl Points<'_> {
    /// Positions of a point [m].
    pub fn positions_m(&self, point: &PointSlot) -> Result<Vec<DVec3>, DeviceError> {
        let bytes = 12 * self.nodes as u64;
        let first = u64::from(point.0) * bytes;
        let mut commands = self.device.record("cloth positions");
        self.staging
            .copy(&mut commands, self.whole, first, 0, bytes);
        self.staging
            .copy(&mut commands, self.remainder, first, bytes, bytes);
        self.device.submit(commands);
        let mut positions = Vec::new();
        self.staging.read(self.device, |view| {
            let (whole, remainder) = view.split_at(bytes as usize);
            let whole: Vec<[i32; 3]> = bytemuck::pod_collect_to_vec(whole);
            let remainder: Vec<[f32; 3]> =
                bytemuck::pod_collect_to_vec(&remainder[..bytes as usize]);
            positions = whole
                .iter()
                .zip(&remainder)
                .map(|(whole, remainder)| {
                    DVec3::from_array(std::array::from_fn(|axis| {
                        joined(whole[axis], remainder[axis])
                    }))
                })
                .collect();
        })?;
        Ok(positions)
    }
}
