//! Momentum and mass balance of a box of cells, from populations alone.
//!
//! Per step, Σ_box Σ_i c_i f_i changes by the force on the air inside, minus what streams out, plus what streams in;
//! the balance closes to round-off. It reads no body force, so it is independent of the immersed boundary.

use rayon::prelude::*;

use super::{Fluid, Stored};
use crate::lattice::control_volume::{ControlVolume, MassMomentum};
use crate::lattice::{DIRECTIONS, Real};

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Mass and momentum that left the box minus what entered it in the step just done.
    #[must_use]
    pub fn outflow(&self, volume: &ControlVolume) -> MassMomentum {
        let parts: Vec<(usize, f64)> = volume.crossings[usize::from(self.odd)]
            .par_iter()
            .map(|crossing| {
                let sum = |array: usize, elements: &[u32]| {
                    let data = &self.populations[array];
                    let read = |element: &u32| data[*element as usize].unpacked().to_f64();
                    // Side by side, so that no sum waits for the one before.
                    let mut sums = [0.0; 8];
                    let parts = elements.chunks_exact(sums.len());
                    let rest: f64 = parts.remainder().iter().map(read).sum();
                    for part in parts {
                        for (sum, element) in sums.iter_mut().zip(part) {
                            *sum += read(element);
                        }
                    }
                    sums.iter().sum::<f64>() + rest
                };
                let net = sum(crossing.leaving_array, &crossing.leaving)
                    - sum(crossing.entering_array, &crossing.entering);
                (crossing.direction, net)
            })
            .collect();
        let mut total = MassMomentum::default();
        for (direction, net) in parts {
            total.mass_excess += net;
            for a in 0..3 {
                total.momentum[a] += net * f64::from(DIRECTIONS[direction][a]);
            }
        }
        total
    }

    /// Mass and momentum inside the box now.
    #[must_use]
    pub fn storage(&self, volume: &ControlVolume) -> MassMomentum {
        let planes: Vec<MassMomentum> = (volume.first[2]..volume.end[2])
            .into_par_iter()
            .map(|z| {
                let mut sum = MassMomentum::default();
                for y in volume.first[1]..volume.end[1] {
                    for x in volume.first[0]..volume.end[0] {
                        let (density_excess, u) = self.bare_state([x, y, z]);
                        sum.mass_excess += density_excess;
                        for a in 0..3 {
                            sum.momentum[a] += (1.0 + density_excess) * u[a];
                        }
                    }
                }
                sum
            })
            .collect();
        planes
            .iter()
            .fold(MassMomentum::default(), |mut total, plane| {
                total.mass_excess += plane.mass_excess;
                for a in 0..3 {
                    total.momentum[a] += plane.momentum[a];
                }
                total
            })
    }
}
