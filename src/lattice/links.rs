//! Populations that enter through the faces of the domain, as copies from slots of outgoing to slots of incoming ones.
//!
//! For cell n and direction d with n − c_d outside: periodic, what left through the opposite face; free slip (half-way specular
//! reflection), what left mirrored at the wall midway between cell and ghost; no slip (half-way bounce-back), what left in the opposite
//! direction, plus 6 w c·u_w for a wall that moves in its own plane (Ladd 1994, doi:10.1017/S0022112094001771, with ρ = 1, so that the
//! wall adds no mass). A link through a no-slip wall and any other face at once bounces back; the velocities of two no-slip walls add.
//! Ghosts at inlet and outlet stream for themselves; only their mirror images beyond the sides are copied.

use super::grid::{Faces, Grid, Sides, StreamwiseEnds, Wall};
use super::{DIRECTION_COUNT, DIRECTIONS, WEIGHTS, direction_of, opposite};

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
    /// Added to each, by a wall that moves.
    pub added: f64,
}

/// Links through the faces, worked out once.
#[derive(Debug, Clone)]
pub struct Boundaries {
    /// Copies for even and odd steps.
    pub copies: [Vec<Run>; 2],
}

/// Where a population that enters from outside comes from.
struct Source {
    cell: [i64; 3],
    /// The direction in which it left there.
    direction: usize,
    /// What a moving wall adds.
    added: f64,
}

/// What a link meets at one face.
enum Met {
    Ghost,
    Repeats,
    Wall(Wall),
}

fn met(ends: StreamwiseEnds, sides: Sides, axis: usize, upper: bool) -> Met {
    let faces = match (axis, ends, sides) {
        (0, StreamwiseEnds::Periodic, _) | (1 | 2, _, Sides::Periodic) => Faces::Periodic,
        // Inlet and outlet ghosts stream for themselves; only their mirror images beyond the sides are copied.
        (0, StreamwiseEnds::InletOutlet, _) => return Met::Ghost,
        (0, StreamwiseEnds::Walls(walls), _) => Faces::Walls(walls),
        (_, _, Sides::FreeSlip) => Faces::Walls([Wall::FreeSlip; 2]),
        (_, _, Sides::Each(faces)) => faces[axis - 1],
        (_, _, Sides::Periodic) => Faces::Periodic,
    };
    match faces {
        Faces::Periodic => Met::Repeats,
        Faces::Walls(walls) => Met::Wall(walls[usize::from(upper)]),
    }
}

/// Where the population that enters `cell` along `direction` from outside left; `None` if nothing has to be copied, because a ghost at
/// inlet or outlet sends it, or because what enters a box of finer cells reaches no cell that counts: cells at its faces find what they sent themselves.
fn source(
    grid: &Grid,
    ends: StreamwiseEnds,
    sides: Sides,
    cell: [i64; 3],
    direction: usize,
) -> Option<Source> {
    let c = DIRECTIONS[direction];
    let mut from: [i64; 3] = std::array::from_fn(|a| cell[a] - i64::from(c[a]));
    let mut velocity = c;
    let mut crosses_copied_face = false;
    let mut wall_velocity = None;
    for a in 0..3 {
        let n = grid.cells[a] as i64;
        if (0..n).contains(&from[a]) {
            continue;
        }
        match met(ends, sides, a, from[a] >= n) {
            Met::Ghost => continue,
            Met::Repeats => from[a] = from[a].rem_euclid(n),
            Met::Wall(Wall::OfBox) => return None,
            Met::Wall(Wall::FreeSlip | Wall::Absorbing) => {
                from[a] = from[a].clamp(0, n - 1);
                velocity[a] = -velocity[a];
            }
            Met::Wall(Wall::NoSlip { velocity }) => {
                let sum: &mut [f64; 3] = wall_velocity.get_or_insert([0.0; 3]);
                for b in 0..3 {
                    sum[b] += velocity[b];
                }
            }
        }
        crosses_copied_face = true;
    }
    if let Some(wall) = wall_velocity {
        let along: f64 = (0..3).map(|a| f64::from(c[a]) * wall[a]).sum();
        return Some(Source {
            cell,
            direction: opposite(direction),
            added: 6.0 * WEIGHTS[direction] * along,
        });
    }
    crosses_copied_face.then(|| Source {
        cell: from,
        direction: direction_of(velocity).unwrap_or(direction),
        added: 0.0,
    })
}

impl Boundaries {
    /// True if a wall moves: then copies carry an addend.
    #[must_use]
    pub fn moving(&self) -> bool {
        self.copies.iter().flatten().any(|run| run.added != 0.0)
    }

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
                            let Some(source) = source(grid, ends, sides, link, direction) else {
                                continue;
                            };
                            let leaving = source.direction;
                            let to = grid.slot(grid.index(link), direction, odd);
                            let target: [i64; 3] = std::array::from_fn(|a| {
                                source.cell[a] + i64::from(DIRECTIONS[leaving][a])
                            });
                            let from = grid.slot(grid.index(target), leaving, odd);
                            push(runs, to, from, source.added);
                        }
                    }
                }
            }
        }
        Self { copies }
    }
}

fn push(
    runs: &mut Vec<Run>,
    (to_array, to): (usize, usize),
    (from_array, from): (usize, usize),
    added: f64,
) {
    if let Some(last) = runs.last_mut()
        && usize::from(last.to_array) == to_array
        && usize::from(last.from_array) == from_array
        && (last.to + last.length) as usize == to
        && (last.from + last.length) as usize == from
        && last.added.to_bits() == added.to_bits()
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
        added,
    });
}
