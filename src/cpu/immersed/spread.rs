//! Stage `spread`: F(x) = Σ_k φ_k(x) g_k, g_k = 2 a_k A_k (v_k − u*_k), each cell adding up its markers.

use super::Immersed;
use crate::immersed::strength::{area_mean_square, length};

impl Immersed {
    /// Gives the air g_k for markers moving with `velocities` [cells per step]: exactly the opposite of the reaction that the fabric
    /// felt if it was solved for this step; between solves (k > 1) it follows the present u*, while the fabric felt the mean ū;
    /// returns the total force on the air [lattice units].
    pub fn spread(&mut self, velocities: &[[f64; 3]]) -> [f64; 3] {
        let mut total = [0.0; 3];
        for k in 0..self.areas.len() {
            let stiffness = self.stiffness(k);
            let force: [f64; 3] =
                std::array::from_fn(|a| stiffness * (velocities[k][a] - self.air_velocities[k][a]));
            for a in 0..3 {
                total[a] += force[a];
            }
            self.marker_forces[k] = force;
        }
        self.gather_cell_forces();
        self.active = true;
        total
    }

    /// F(x) from the marker forces.
    pub(super) fn gather_cell_forces(&mut self) {
        self.touched
            .spread(&self.marker_forces, &mut self.cell_forces);
        self.touched
            .spread_normals(&self.marker_forces, &mut self.cell_forces);
    }

    /// Slip left after the half force at every marker, u* + F/2 − v [cells per step], `[marker_count]`.
    #[must_use]
    pub fn slip_velocities(&self, velocities: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let forced: Vec<[f64; 3]> = self
            .cell_velocities
            .iter()
            .zip(&self.cell_forces)
            .map(|(u, f)| std::array::from_fn(|a| u[a] + 0.5 * f[a]))
            .collect();
        let mut slips: Vec<[f64; 3]> = velocities
            .iter()
            .enumerate()
            .map(|(k, velocity)| {
                let u = self.touched.interpolate(k, &forced);
                std::array::from_fn(|a| u[a] - velocity[a])
            })
            .collect();
        for (k, axis, part) in self.touched.interpolate_normals(&forced) {
            slips[k][axis] += part;
        }
        slips
    }

    /// Its magnitude [cells per step], `[marker_count]`.
    #[must_use]
    pub fn marker_slips(&self, velocities: &[[f64; 3]]) -> Vec<f64> {
        let slips = self.slip_velocities(velocities);
        slips.iter().map(length).collect()
    }

    /// Root mean square of [`Immersed::marker_slips`], weighted by area [cells per step].
    #[must_use]
    pub fn slip(&self, velocities: &[[f64; 3]]) -> f64 {
        let slips = self.marker_slips(velocities);
        area_mean_square(&slips, self.areas.as_flattened())
    }
}
