//! Stage `interpolate`: u*_k = Σ_x φ_k(x) u*(x), with u* the bare velocity of the streamed populations (no F/2), and the local
//! strengths a_k.

use rayon::prelude::*;

use super::Immersed;
use crate::cpu::fluid::Fluid;
use crate::immersed::kernel::SUM_OF_SQUARES;
use crate::immersed::strength::LARGEST_OVER_RELAXATION_RATIO;
use crate::immersed::touched::OutOfDomain;
use crate::lattice::Real;

/// Cells or markers per parallel task.
const CHUNK: usize = 512;

impl Immersed {
    /// Moves the markers to `positions` [cells, cell centres at whole numbers] and reads the air there.
    pub fn interpolate<T: Real>(
        &mut self,
        fluid: &Fluid<T>,
        positions: &[[f64; 3]],
    ) -> Result<(), OutOfDomain> {
        self.touched.rebuild(positions, self.domain)?;
        let touched = &self.touched;
        self.cell_velocities.resize(touched.cells.len(), [0.0; 3]);
        let areas = &self.areas;
        let states: Vec<[f64; 4]> = self
            .cell_velocities
            .par_iter_mut()
            .zip(&touched.cells)
            .enumerate()
            .with_min_len(CHUNK)
            .map(|(index, (velocity, cell))| {
                *velocity = fluid.bare_state(cell.map(|c| c as usize)).1;
                let [area] = touched.spread(index, areas);
                [velocity[0], velocity[1], velocity[2], area]
            })
            .collect();
        let largest = LARGEST_OVER_RELAXATION_RATIO * self.over_relaxation;
        self.strengths
            .par_iter_mut()
            .zip(&mut self.air_velocities)
            .enumerate()
            .with_min_len(CHUNK)
            .for_each(|(marker, (strength, velocity))| {
                let [x, y, z, density] = touched.interpolate(marker, &states);
                *strength = (self.over_relaxation * SUM_OF_SQUARES / density).min(largest);
                *velocity = [x, y, z];
            });
        Ok(())
    }
}
