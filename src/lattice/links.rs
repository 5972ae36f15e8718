//! Populations that enter through the faces of the domain, as copies from slots of outgoing to slots of incoming ones.
//!
//! For cell n and direction d with n − c_d outside: periodic, what left through the opposite face; free slip (half-way specular
//! reflection), what left mirrored at the wall midway between cell and ghost. Ghosts at inlet and outlet stream for themselves;
//! only their mirror images beyond the sides are copied.

use super::grid::{Grid, Sides, StreamwiseEnds};
use super::{DIRECTION_COUNT, DIRECTIONS, direction_of};

/// A run of consecutive slots copied from outgoing to incoming.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// Array written.
    pub to_array: u8,
    /// Array read.
    pub from_array: u8,
    /// First element written.
    pub to: u32,
    /// First element read.
    pub from: u32,
    /// Number of elements.
    pub length: u32,
}

/// Links through the faces, worked out once.
#[derive(Debug, Clone)]
pub struct Boundaries {
    /// Copies for even and odd steps.
    pub copies: [Vec<Run>; 2],
}

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
    /// The copies after a step, by the parity of the step to come.
    #[must_use]
    pub fn new(grid: &Grid, ends: StreamwiseEnds, sides: Sides) -> Self {
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
