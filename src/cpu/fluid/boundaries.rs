//! Populations that enter through the faces of the domain: through the sides they are copied after each sweep, at inlet and
//! outlet ghost cells stream them within the sweep.
//!
//! For cell n and direction d with n − c_d outside:
//! * periodic: what left through the opposite face;
//! * free slip (half-way specular reflection): what left mirrored at the wall midway between cell and ghost;
//! * velocity inlet: equilibrium with the inlet's velocity and the density of the second cell (zero pressure gradient), both as after the
//!   collision of the step, like every cell that streams;
//! * pressure outlet: equilibrium with ρ = 1 and the velocity of the last cell but one after its collision; a viscous sponge before it
//!   (see [`super::Setup::sponge_cells`]) damps vortices that leave.
//!
//! Beyond the sides the ghosts of inlet and outlet are mirrored (or repeated). *Limit*: an inlet of given velocity and an outlet of given
//! pressure reflect sound; only vortices are damped by the sponge.

use super::{Fluid, Grid};
use crate::lattice::operators::bare_moments;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real, WEIGHTS, direction_of, opposite};

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
}

/// Directions that enter through −x; the entering ones at +x are their opposites.
const DOWNSTREAM: [usize; 5] = [1, 7, 9, 13, 15];

/// Where the population that enters `cell` along `direction` from outside left, and in which direction; `None` if nothing has
/// to be copied because a ghost at inlet or outlet sends it.
fn source(
    grid: &Grid,
    ends: StreamwiseEnds,
    sides: Sides,
    cell: [i64; 3],
    direction: usize,
) -> Option<([i64; 3], usize)> {
    let mut from: [i64; 3] = std::array::from_fn(|a| cell[a] - i64::from(DIRECTIONS[direction][a]));
    let mut velocity = DIRECTIONS[direction];
    let mut crosses_copied_face = false;
    for a in 0..3 {
        let n = grid.cells[a] as i64;
        if (0..n).contains(&from[a]) {
            continue;
        }
        let reflects = if a == 0 {
            if ends == StreamwiseEnds::InletOutlet {
                // Inlet and outlet ghosts stream for themselves; only their mirror images beyond the sides are copied.
                continue;
            }
            false
        } else {
            sides == Sides::FreeSlip
        };
        crosses_copied_face = true;
        if reflects {
            from[a] = if from[a] < 0 { 0 } else { n - 1 };
            velocity[a] = -velocity[a];
        } else {
            from[a] = from[a].rem_euclid(n);
        }
    }
    crosses_copied_face.then(|| (from, direction_of(velocity).unwrap_or(direction)))
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
                            let Some((cell, leaving)) = source(grid, ends, sides, link, direction)
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
        Self { copies }
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
    }
}

/// The ghost cells at both ends of a row: they are at equilibrium and stream like any cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowEnds<T> {
    inlet_density_excess: T,
    inlet_velocity: [T; 3],
    outlet_velocity: [T; 3],
}

impl<T: Real> RowEnds<T> {
    /// Reads what they take from their neighbours off a row just collided, while it is in the cache; the momentum after the collision
    /// is what a streaming cell carries.
    #[inline(always)]
    pub(super) fn read(rows: &[&mut [T]; DIRECTION_COUNT], inlet_velocity: [T; 3]) -> Self {
        let nx = rows[0].len();
        let (inlet, outlet) = (1.min(nx - 1), nx.saturating_sub(2));
        let mut states = [[T::default(); DIRECTION_COUNT]; 2];
        for direction in 0..DIRECTION_COUNT {
            states[0][direction] = rows[opposite(direction)][inlet];
            states[1][direction] = rows[opposite(direction)][outlet];
        }
        let (inlet_density_excess, _) = bare_moments(&states[0]);
        let (excess, momentum) = bare_moments(&states[1]);
        let inverse_density = T::of(1.0) / (T::of(1.0) + excess);
        Self {
            inlet_density_excess,
            inlet_velocity,
            outlet_velocity: momentum.map(|j| j * inverse_density),
        }
    }

    /// Streams their populations into the domain: `arrays` are the slab's, by direction read in this step, and the row's cells
    /// are the elements `start..start + nx`.
    #[inline(always)]
    pub(super) fn write(&self, arrays: &mut [&mut [T]; DIRECTION_COUNT], start: usize, nx: usize) {
        for direction in DOWNSTREAM {
            // As for any cell, f_i goes to the slot shifted by c_i, here seen from cell −1, and f_{i+1} to the local one.
            arrays[direction + 1][start - 1] =
                shifted_equilibrium(direction, self.inlet_density_excess, &self.inlet_velocity);
            arrays[direction][start + nx] =
                shifted_equilibrium(direction + 1, T::default(), &self.outlet_velocity);
        }
    }
}

#[inline(always)]
fn shifted_equilibrium<T: Real>(direction: usize, density_excess: T, u: &[T; 3]) -> T {
    let c = DIRECTIONS[direction].map(|c| T::of(f64::from(c)));
    let weight = T::of(WEIGHTS[direction]);
    let density = T::of(1.0) + density_excess;
    let along = c[0] * u[0] + c[1] * u[1] + c[2] * u[2];
    let square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    weight
        * (density_excess
            + density * (T::of(3.0) * along + T::of(4.5) * along * along - T::of(1.5) * square))
}
