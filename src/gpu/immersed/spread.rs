//! Stage `spread`: F(x) = Σ_k φ_k(x) g_k, g_k = 2 a_k A_k (v_k − u*_k).
//!
//! Where the device does not form it itself (`gpu/cloth/marker_reactions.rs`), g_k is formed on the host from the very numbers that the fabric saw, and rounded once; what is returned as the total is the sum of
//! the rounded ones, so that markers and air agree.

use super::Immersed;
use crate::gpu::error::DeviceError;
use crate::immersed::strength::length;

impl Immersed {
    /// Stage `send_marker_forces`: the forces of markers moving with `velocities` [cells per step]; returns their sum on the air
    /// [lattice units].
    pub fn send_marker_forces(&mut self, velocities: &[[f64; 3]]) -> [f64; 3] {
        let mut total = [0.0; 3];
        for place in 0..self.order.len() {
            let k = self.order[place] as usize;
            let stiffness = self.stiffness(k);
            let mut force = [0.0; 4];
            for a in 0..3 {
                force[a] = (stiffness * (velocities[k][a] - self.air_velocities[k][a])) as f32;
                total[a] += f64::from(force[a]);
            }
            self.forces[place] = force;
        }
        self.device.write(&self.marker_forces, 0, &self.forces);
        total
    }

    /// Lets every touched cell gather the forces sent.
    pub fn spread(&mut self) {
        let Some(boxed) = self.boxed.as_ref().filter(|_| !self.order.is_empty()) else {
            return;
        };
        let cells: u64 = boxed.forces.size.iter().map(|&n| u64::from(n)).product();
        let mut commands = self.device.record("spread");
        {
            let mut pass = commands.pass("spread");
            boxed
                .spread
                .dispatch(&mut pass, self.device.workgroups(cells));
        }
        self.device.leave(commands);
        self.active = true;
    }

    /// Slip left after the half force at every marker, u* + F/2 − v [cells per step], `[marker_count]`.
    pub fn slip_velocities(&self, velocities: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, DeviceError> {
        let count = self.order.len();
        let mut slips = vec![[0.0; 3]; self.areas.len()];
        let Some(boxed) = self.boxed.as_ref().filter(|_| count > 0) else {
            return Ok(slips);
        };
        let mut commands = self.device.record("half_forced_velocity");
        {
            let mut pass = commands.pass("half_forced_velocity");
            boxed
                .half_forced_velocity
                .dispatch(&mut pass, self.device.workgroups(count as u64));
        }
        self.device.submit(commands);
        let found: Vec<[f32; 4]> = self.device.read(&self.marker_velocities, 0, count)?;
        for (u, &marker) in found.iter().zip(&self.order) {
            let k = marker as usize;
            slips[k] = std::array::from_fn(|a| f64::from(u[a]) - velocities[k][a]);
        }
        Ok(slips)
    }

    /// Its magnitude [cells per step], `[marker_count]`.
    pub fn marker_slips(&self, velocities: &[[f64; 3]]) -> Result<Vec<f64>, DeviceError> {
        let slips = self.slip_velocities(velocities)?;
        Ok(slips.iter().map(length).collect())
    }

    /// Root mean square of [`Immersed::marker_slips`], weighted by area [cells per step].
    pub fn slip(&self, velocities: &[[f64; 3]]) -> Result<f64, DeviceError> {
        Ok(crate::immersed::strength::area_mean_square(
            &self.marker_slips(velocities)?,
            &self.areas,
        ))
    }
}
