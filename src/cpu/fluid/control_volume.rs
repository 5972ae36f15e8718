//! Momentum and mass balance of a box of cells, from populations alone.
//!
//! Per step, Σ_box Σ_i c_i f_i changes by the force on the air inside, minus what streams out, plus what streams in;
//! the balance closes to round-off. It reads no body force, so it is independent of the immersed boundary.

use rayon::prelude::*;

use super::{Fluid, Grid};
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real};

/// Mass and momentum [lattice units].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MassMomentum {
    /// Σ δρ.
    pub mass_excess: f64,
    /// Σ f c.
    pub momentum: [f64; 3],
}

/// Addresses of all populations that cross the faces of a box of cells in a step.
#[derive(Debug, Clone)]
pub struct ControlVolume {
    /// First cell.
    pub first: [usize; 3],
    /// One past the last cell.
    pub end: [usize; 3],
    /// Per parity and direction: (array, elements leaving, elements entering).
    crossings: [Vec<Crossing>; 2],
}

#[derive(Debug, Clone)]
struct Crossing {
    direction: usize,
    leaving_array: usize,
    leaving: Vec<u32>,
    entering_array: usize,
    entering: Vec<u32>,
}

impl ControlVolume {
    /// Box of cells `first..end`, inside the domain of `grid`.
    #[must_use]
    pub fn new(grid: &Grid, first: [usize; 3], end: [usize; 3]) -> Self {
        let crossings = [false, true].map(|odd| {
            (1..DIRECTION_COUNT)
                .map(|direction| crossing(grid, first, end, direction, odd))
                .collect()
        });
        Self {
            first,
            end,
            crossings,
        }
    }

    /// Cells inside.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        (0..3).map(|a| self.end[a] - self.first[a]).product()
    }
}

fn crossing(
    grid: &Grid,
    first: [usize; 3],
    end: [usize; 3],
    direction: usize,
    odd: bool,
) -> Crossing {
    let c = DIRECTIONS[direction];
    let mut result = Crossing {
        direction,
        leaving_array: 0,
        leaving: Vec::new(),
        entering_array: 0,
        entering: Vec::new(),
    };
    let inside =
        |cell: [i64; 3]| (0..3).all(|a| cell[a] >= first[a] as i64 && cell[a] < end[a] as i64);
    for z in first[2]..end[2] {
        for y in first[1]..end[1] {
            for x in first[0]..end[0] {
                let cell = [x as i64, y as i64, z as i64];
                let next: [i64; 3] = std::array::from_fn(|a| cell[a] + i64::from(c[a]));
                if !inside(next) {
                    let (array, element) = grid.slot(grid.index(next), direction, odd);
                    result.leaving_array = array;
                    result.leaving.push(element as u32);
                }
                let previous: [i64; 3] = std::array::from_fn(|a| cell[a] - i64::from(c[a]));
                if !inside(previous) {
                    let (array, element) = grid.slot(grid.index(cell), direction, odd);
                    result.entering_array = array;
                    result.entering.push(element as u32);
                }
            }
        }
    }
    result
}

impl<T: Real> Fluid<T> {
    /// Mass and momentum that left the box minus what entered it in the step just done.
    #[must_use]
    pub fn outflow(&self, volume: &ControlVolume) -> MassMomentum {
        let parts: Vec<(usize, f64)> = volume.crossings[usize::from(self.odd)]
            .par_iter()
            .map(|crossing| {
                let sum = |array: usize, elements: &[u32]| -> f64 {
                    let data = &self.populations[array];
                    elements
                        .iter()
                        .map(|&element| data[element as usize].to_f64())
                        .sum()
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
