//! Populations that enter through the faces of the domain, filled in after each step.
//!
//! For cell n and direction d with n − c_d outside:
//! * periodic: what left through the opposite face;
//! * free slip (half-way specular reflection): what left mirrored at the wall midway between cell and ghost;
//! * velocity inlet: equilibrium with the inlet's velocity and the density of the second cell (zero pressure gradient);
//! * pressure outlet: equilibrium with ρ = 1 and the velocity of the last cell but one; a viscous sponge before it
//!   (see [`super::Setup::sponge_cells`]) damps vortices that leave.
//!
//! Inlet and outlet own the edges they share with the sides.

use rayon::prelude::*;

use super::{Fluid, Grid};
use crate::lattice::operators::bare_moments;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real, direction_of};

/// What lies upstream (−x) and downstream (+x).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamwiseEnds {
    /// The domain repeats along x.
    Periodic,
    /// Velocity inlet at −x, pressure outlet at +x.
    InletOutlet,
}

/// What lies beside (±y), below and above (±z).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// The domain repeats along y and z.
    Periodic,
    /// Frictionless impermeable walls.
    FreeSlip,
}

/// A run of consecutive slots copied from outgoing to incoming.
#[derive(Debug, Clone, Copy)]
struct Run {
    to_array: u8,
    from_array: u8,
    to: u32,
    from: u32,
    length: u32,
}

/// Links through the faces, worked out once.
#[derive(Debug, Clone)]
pub(super) struct Boundaries {
    /// Copies for even and odd steps.
    copies: [Vec<Run>; 2],
    has_ends: bool,
}

/// Directions that enter through −x; the entering ones at +x are their opposites.
const DOWNSTREAM: [usize; 5] = [1, 7, 9, 13, 15];

enum Source {
    Cell { cell: [i64; 3], direction: usize },
    End,
}

fn source(
    grid: &Grid,
    ends: StreamwiseEnds,
    sides: Sides,
    cell: [i64; 3],
    direction: usize,
) -> Source {
    let mut from: [i64; 3] = std::array::from_fn(|a| cell[a] - i64::from(DIRECTIONS[direction][a]));
    let mut velocity = DIRECTIONS[direction];
    for a in 0..3 {
        let n = grid.cells[a] as i64;
        if (0..n).contains(&from[a]) {
            continue;
        }
        let reflects = if a == 0 {
            if ends == StreamwiseEnds::InletOutlet {
                return Source::End;
            }
            false
        } else {
            sides == Sides::FreeSlip
        };
        if reflects {
            from[a] = if from[a] < 0 { 0 } else { n - 1 };
            velocity[a] = -velocity[a];
        } else {
            from[a] = from[a].rem_euclid(n);
        }
    }
    let direction = direction_of(velocity).unwrap_or(direction);
    Source::Cell {
        cell: from,
        direction,
    }
}

impl Boundaries {
    pub(super) fn new(grid: &Grid, ends: StreamwiseEnds, sides: Sides) -> Self {
        let [nx, ny, nz] = grid.cells.map(|n| n as i64);
        let mut copies = [Vec::new(), Vec::new()];
        for (parity, runs) in copies.iter_mut().enumerate() {
            let odd = parity == 1;
            for direction in 1..DIRECTION_COUNT {
                for z in 0..nz {
                    for y in 0..ny {
                        let inner_row = y > 0 && z > 0 && y < ny - 1 && z < nz - 1;
                        let mut x = 0;
                        while x < nx {
                            let link = [x, y, z];
                            // Only cells on a face can receive from outside.
                            x += if inner_row && x == 0 && nx > 1 {
                                nx - 1
                            } else {
                                1
                            };
                            let outside = (0..3).any(|a| {
                                let from = link[a] - i64::from(DIRECTIONS[direction][a]);
                                from < 0 || from >= grid.cells[a] as i64
                            });
                            if !outside {
                                continue;
                            }
                            let Source::Cell {
                                cell,
                                direction: leaving,
                            } = source(grid, ends, sides, link, direction)
                            else {
                                continue;
                            };
                            let (to_array, to) = grid.slot(grid.index(link), direction, odd);
                            let target: [i64; 3] = std::array::from_fn(|a| {
                                cell[a] + i64::from(DIRECTIONS[leaving][a])
                            });
                            let (from_array, from) = grid.slot(grid.index(target), leaving, odd);
                            push(runs, to_array, to, from_array, from);
                        }
                    }
                }
            }
        }
        Self {
            copies,
            has_ends: ends == StreamwiseEnds::InletOutlet,
        }
    }
}

fn push(runs: &mut Vec<Run>, to_array: usize, to: usize, from_array: usize, from: usize) {
    if let Some(last) = runs.last_mut()
        && usize::from(last.to_array) == to_array
        && usize::from(last.from_array) == from_array
        && (last.to + last.length) as usize == to
        && (last.from + last.length) as usize == from
    {
        last.length += 1;
        return;
    }
    runs.push(Run {
        to_array: to_array as u8,
        from_array: from_array as u8,
        to: to as u32,
        from: from as u32,
        length: 1,
    });
}

impl<T: Real> Fluid<T> {
    pub(super) fn apply_boundaries(&mut self) {
        for run in &self.boundaries.copies[usize::from(self.odd)] {
            let (to, from, length) = (run.to as usize, run.from as usize, run.length as usize);
            let (to_array, from_array) = (usize::from(run.to_array), usize::from(run.from_array));
            match self.populations.get_disjoint_mut([to_array, from_array]) {
                Ok([target, origin]) => {
                    target[to..to + length].copy_from_slice(&origin[from..from + length])
                }
                Err(_) => self.populations[to_array].copy_within(from..from + length, to),
            }
        }
        if self.boundaries.has_ends {
            self.apply_ends();
        }
    }

    /// Velocity inlet at −x and pressure outlet at +x.
    fn apply_ends(&mut self) {
        let [nx, ny, nz] = self.setup.cells.map(|n| n as i64);
        let probe = |x: i64| -> Vec<(T, [T; 3])> {
            (0..(nz * ny) as usize)
                .into_par_iter()
                .with_min_len(256)
                .map(|row| row as i64)
                .map(|row| bare_moments(&self.gather(self.grid.index([x, row % ny, row / ny]))))
                .collect()
        };
        let inlet_state = probe(1.min(nx - 1));
        let outlet_state = probe((nx - 2).max(0));
        let inlet_velocity = self.inlet_velocity.map(T::of);
        for row in 0..nz * ny {
            let (y, z) = (row % ny, row / ny);
            let (density_excess, _) = inlet_state[row as usize];
            let index = self.grid.index([0, y, z]);
            for direction in DOWNSTREAM {
                self.set_equilibrium(index, direction, density_excess, &inlet_velocity);
            }
            let (excess, momentum) = outlet_state[row as usize];
            let inverse_density = T::of(1.0) / (T::of(1.0) + excess);
            let velocity = momentum.map(|j| j * inverse_density);
            let index = self.grid.index([nx - 1, y, z]);
            for direction in DOWNSTREAM {
                self.set_equilibrium(index, direction + 1, T::default(), &velocity);
            }
        }
    }

    #[inline(always)]
    fn set_equilibrium(&mut self, index: usize, direction: usize, density_excess: T, u: &[T; 3]) {
        let c = DIRECTIONS[direction];
        let weight = T::of(crate::lattice::WEIGHTS[direction]);
        let density = T::of(1.0) + density_excess;
        let along = T::of(f64::from(c[0])) * u[0]
            + T::of(f64::from(c[1])) * u[1]
            + T::of(f64::from(c[2])) * u[2];
        let square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        let value = weight
            * (density_excess
                + density
                    * (T::of(3.0) * along + T::of(4.5) * along * along - T::of(1.5) * square));
        let (array, element) = self.grid.slot(index, direction, self.odd);
        self.populations[array][element] = value;
    }
}
