//! Stage `repeat_forcing`: one more pass of multi-direct forcing (formula in [`crate::cpu::immersed`]), all on the device; and stage
//! `fetch_marker_forces`.

use super::Immersed;
use crate::gpu::error::DeviceError;

impl Immersed {
    /// Forces again what slip is left at markers moving with `velocities` [cells per step].
    pub fn repeat_forcing(&mut self, velocities: &[[f64; 3]]) -> Result<(), DeviceError> {
        let count = self.order.len();
        let Some(boxed) = self.boxed.as_ref().filter(|_| count > 0) else {
            return Ok(());
        };
        let sorted: Vec<[f32; 4]> = self
            .order
            .iter()
            .map(|&marker| {
                let [x, y, z] = velocities[marker as usize].map(|v| v as f32);
                [x, y, z, 0.0]
            })
            .collect();
        self.device.write(&self.target_velocities, 0, &sorted);
        let mut commands = self.device.record("repeat_forcing");
        {
            let mut pass = commands.pass("repeat_forcing");
            boxed
                .repeat_forcing
                .dispatch(&mut pass, self.device.workgroups(count as u64));
        }
        self.device.leave(commands);
        self.spread();
        Ok(())
    }

    /// Fetches the forces after the last pass; returns their sum on the air [lattice units].
    pub fn fetch_marker_forces(&mut self) -> Result<[f64; 3], DeviceError> {
        let count = self.order.len();
        if count > 0 {
            let bytes = 16 * count as u64;
            let mut commands = self.device.record("marker forces");
            self.staging
                .copy(&mut commands, &self.marker_forces, 0, 0, bytes);
            self.device.submit(commands);
            let forces = &mut self.forces;
            self.staging.read_first(&self.device, bytes, |view| {
                *forces = bytemuck::pod_collect_to_vec(view);
            })?;
        }
        Ok(self.forces.iter().fold([0.0; 3], |sum, force| {
            std::array::from_fn(|a| sum[a] + f64::from(force[a]))
        }))
    }
}
