//! Stage `interpolate`: u*_k = Σ_x φ_k(x) u*(x), with u* the bare velocity of the streamed populations (no F/2), and the local
//! strengths a_k.

use rayon::prelude::*;

use super::Immersed;
use crate::cpu::fluid::{Fluid, Stored};
use crate::immersed::kernel::SUM_OF_SQUARES;
use crate::immersed::strength::LARGEST_OVER_RELAXATION_RATIO;
use crate::immersed::touched::OutOfDomain;

/// Cells or markers per parallel task.
const CHUNK: usize = 512;

impl Immersed {
    /// Moves the markers to `positions` [cells, cell centres at whole numbers] and reads the air there.
    pub fn interpolate<P: Stored>(
        &mut self,
        fluid: &Fluid<P>,
        positions: &[[f64; 3]],
    ) -> Result<(), OutOfDomain> {
        self.touched.rebuild(positions, self.domain)?;
        let touched = &self.touched;
        self.cell_velocities.resize(touched.cells.len(), [0.0; 3]);
        touched.spread(&self.areas, &mut self.cell_areas);
        self.cell_states.resize(touched.cells.len(), [0.0; 4]);
        self.cell_states
            .par_iter_mut()
            .zip(&mut self.cell_velocities)
            .zip(&touched.cells)
            .zip(&self.cell_areas)
            .with_min_len(CHUNK)
            .for_each(|(((state, velocity), cell), &[area])| {
                *velocity = fluid.bare_state(cell.map(|c| c as usize)).1;
                *state = [velocity[0], velocity[1], velocity[2], area];
            });
        let states = &self.cell_states;
        let largest = LARGEST_OVER_RELAXATION_RATIO * self.over_relaxation;
        self.strengths
            .par_iter_mut()
            .zip(&mut self.air_velocities)
            .enumerate()
            .with_min_len(CHUNK)
            .for_each(|(marker, (strength, velocity))| {
                let [x, y, z, density] = touched.interpolate(marker, states);
                *strength = (self.over_relaxation * SUM_OF_SQUARES / density).min(largest);
                *velocity = [x, y, z];
            });
        for (marker, axis, part) in touched.interpolate_normals(states) {
            self.air_velocities[marker][axis] += part;
        }
        Ok(())
    }
}
