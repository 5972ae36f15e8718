//! Stage `repeat_forcing`: one more pass of *multi-direct forcing* (Wang, Fan & Luo 2008; Inamuro 2012, paper P0): what slip the
//! forces so far leave is forced again, g_k ← g_k + 2 a_k A_k (v_k − Σ_x φ_k(x) (u*(x) + F(x)/2)).
//!
//! Inside a flat surface N passes leave (1 − (3/8) a)^N of the slip: (5/8)^N for plain a = 1. *Departure*: Inamuro's scheme knows no
//! half force and no a_k; with a_k D_k ≤ 1 the passes converge wherever surfaces meet.

use rayon::prelude::*;

use super::Immersed;

/// Markers per parallel task.
const CHUNK: usize = 512;

impl Immersed {
    /// One more pass for markers moving with `velocities` [cells per step]; returns the total force on the air [lattice units].
    pub fn repeat_forcing(&mut self, velocities: &[[f64; 3]]) -> [f64; 3] {
        let forced: Vec<[f64; 3]> = self
            .cell_velocities
            .iter()
            .zip(&self.cell_forces)
            .map(|(u, f)| std::array::from_fn(|a| u[a] + 0.5 * f[a]))
            .collect();
        let mut forces = std::mem::take(&mut self.marker_forces);
        forces
            .par_iter_mut()
            .enumerate()
            .with_min_len(CHUNK)
            .for_each(|(k, force)| {
                let u = self.touched.interpolate(k, &forced);
                let stiffness = self.stiffness(k);
                for a in 0..3 {
                    force[a] += stiffness * (velocities[k][a] - u[a]);
                }
            });
        for (k, axis, part) in self.touched.interpolate_normals(&forced) {
            forces[k][axis] -= self.stiffness(k) * part;
        }
        self.marker_forces = forces;
        self.gather_cell_forces();
        self.marker_forces.iter().fold([0.0; 3], |sum, force| {
            std::array::from_fn(|a| sum[a] + force[a])
        })
    }
}
