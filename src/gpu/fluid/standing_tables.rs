//! What a device has to know of walls that stand still ([`super::standing_walls`]), as tables.

use bytemuck::Zeroable;

use super::link_lists::LinkLists;
use crate::cut_links::{SIDES, StandingWalls};
use crate::gpu::shaders::{WORKGROUP, parameters};
use crate::lattice::{DIRECTIONS, WEIGHTS};

parameters! {
    /// What a step of the device needs to know.
    StandingParameters {
        /// Where the sums of the forces of this step go.
        sums_from: u32,
        /// Portions of the sides whose forces are summed.
        portions: u32,
        /// Blocks of images.
        blocks: u32,
        /// Spaces that they look at.
        spaces: u32,
        /// Pockets.
        pockets: u32,
        /// Cells beside links.
        cells: u32,
        /// Sides of links.
        sides: u32,
        /// Unused.
        padding: u32,
    }
    /// What comes back to a side of a link.
    StandingSide {
        /// Share of what left, where the air sticks.
        share: f32,
        /// Share of the further population.
        further: f32,
        /// Number of the image; none where the air sticks.
        image: u32,
        /// Number of its block.
        block: u32,
    }
    /// Mirror image of the cell behind a cut.
    StandingImage {
        /// Numbers of the cells that it is taken from.
        cells: [u32; 3],
        /// Number of the side's own cell.
        own: u32,
        /// Shares of the cells.
        shares: [f32; 3],
        /// Number of the direction in which air leaves.
        direction: u32,
        /// Unit normal away from the air.
        away: [f32; 3],
        /// β.
        turned_round: f32,
        /// Direction in which air leaves.
        leaving: [f32; 3],
        /// Number of the side.
        side: u32,
    }
    /// Images that share what they lose.
    StandingBlock {
        /// First image.
        first: u32,
        /// End of its images.
        end: u32,
        /// Sum of the weights.
        weight: f32,
        /// Unused.
        padding: u32,
    }
    /// Blocks that look at the same air.
    StandingSpace {
        /// Where they begin among the blocks in the order of spaces.
        first: u32,
        /// Where they end.
        end: u32,
        /// Sum of the weights.
        weight: f32,
        /// Unused.
        padding: u32,
    }
    /// A side of a body's link.
    StandingPush {
        /// Direction in which air leaves.
        leaving: [f32; 3],
        /// Number of the side, or none.
        side: u32,
        /// Moment of that direction about the body's moment point [cells].
        turning: [f32; 3],
        /// Unused.
        padding: u32,
    }
    /// Air shut in by a fold.
    StandingPocket {
        /// First of its sides.
        first: u32,
        /// Their end.
        end: u32,
        /// Sum of the weights.
        weight: f32,
        /// Unused.
        padding: u32,
    }
    /// What a population at rest gets.
    RestPart {
        /// Number of a side, or of a pocket, with a bit that says so.
        number: u32,
        /// Share of what a pocket lets out.
        factor: f32,
    }
}

/// Where the air sticks, and no side; as in the shader.
const NONE: u32 = u32::MAX;

/// Marks the numbers of pockets among what a population at rest gets; as in the shader.
const OF_A_POCKET: u32 = 1 << 31;

/// Sides of a portion that one thread sums, and all.
pub(super) const SIDES_OF_A_THREAD: usize = 4;
pub(super) const PORTION: usize = SIDES_OF_A_THREAD * WORKGROUP as usize;

/// A side of a link of a rigid body.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// Its number: twice the link's, plus the side's.
    pub side: u32,
    /// From the body's moment point to the cut [cells].
    pub arm: [f64; 3],
}

/// Tables that go to the device as they are.
#[derive(Debug, Default)]
pub(super) struct Tables {
    pub sides: Vec<StandingSide>,
    pub images: Vec<StandingImage>,
    pub blocks: Vec<StandingBlock>,
    pub spaces: Vec<StandingSpace>,
    pub blocks_of_spaces: Vec<u32>,
    pub pushes: Vec<StandingPush>,
    /// End of the portions of each body.
    pub bodies: Vec<usize>,
    pub pockets: Vec<StandingPocket>,
    pub pocket_sides: Vec<u32>,
}

fn single(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|component| component as f32)
}

fn vector(direction: usize) -> [f64; 3] {
    DIRECTIONS[direction].map(f64::from)
}

impl Tables {
    pub fn new(walls: &StandingWalls, bodies: &[Vec<Push>]) -> Self {
        let mut tables = Self::default();
        let links = walls.links.links();
        let sides = links.iter().flat_map(|link| SIDES.map(|side| (link, side)));
        for ((link, side), image) in sides.zip(walls.of_sides()) {
            let [share, further] = StandingWalls::sticking(link, side);
            let (image, block) = image.map_or((NONE, NONE), |(i, b)| (i as u32, b as u32));
            tables.sides.push(StandingSide {
                share: share as f32,
                further: further as f32,
                image,
                block,
            });
        }
        tables.images.extend(walls.images().map(|image| {
            let direction = usize::from(image.direction);
            StandingImage {
                cells: image.cells,
                own: image.own,
                shares: single(image.shares),
                direction: direction as u32,
                away: single(image.away),
                turned_round: image.turned_round as f32,
                leaving: single(vector(direction)),
                side: image.side,
            }
        }));
        let blocks: Vec<_> = walls.blocks().collect();
        tables
            .blocks
            .extend(blocks.iter().map(|block| StandingBlock {
                first: block.images.start as u32,
                end: block.images.end as u32,
                weight: block.weight as f32,
                padding: 0,
            }));
        tables.blocks_of_spaces.extend(0..blocks.len() as u32);
        (tables.blocks_of_spaces).sort_by_key(|block| blocks[*block as usize].space);
        let mut first = 0;
        for (space, weight) in (0..).zip(walls.weights_of_spaces()) {
            let of = |block: &u32| blocks[*block as usize].space <= space;
            let end = tables.blocks_of_spaces.partition_point(of) as u32;
            tables.spaces.push(StandingSpace {
                first,
                end,
                weight: weight.max(f64::from(f32::MIN_POSITIVE)) as f32,
                padding: 0,
            });
            first = end;
        }
        for body in bodies {
            tables.pushes.extend(body.iter().map(|push| {
                let [link, side] = [push.side as usize / 2, push.side as usize % 2];
                let d = vector(links[link].leaving(side));
                let [x, y, z] = push.arm;
                let turning = [
                    y * d[2] - z * d[1],
                    z * d[0] - x * d[2],
                    x * d[1] - y * d[0],
                ];
                StandingPush {
                    leaving: single(d),
                    side: push.side,
                    turning: single(turning),
                    padding: 0,
                }
            }));
            let whole = tables.pushes.len().next_multiple_of(PORTION);
            let none = StandingPush {
                side: NONE,
                ..StandingPush::zeroed()
            };
            tables.pushes.resize(whole, none);
            tables.bodies.push(whole / PORTION);
        }
        for pocket in walls.pockets() {
            let first = tables.pocket_sides.len() as u32;
            let weight: f64 = (pocket.sides.iter())
                .map(|&(link, side)| WEIGHTS[links[link as usize].leaving(side)])
                .sum();
            let sides = pocket.sides.iter();
            tables
                .pocket_sides
                .extend(sides.map(|&(link, side)| 2 * link + side as u32));
            tables.pockets.push(StandingPocket {
                first,
                end: tables.pocket_sides.len() as u32,
                weight: weight as f32,
                padding: 0,
            });
        }
        tables
    }

    /// By cell beside a link, what its population at rest gets, and where that begins.
    pub fn of_rest(&self, walls: &StandingWalls, lists: &LinkLists) -> (Vec<u32>, Vec<RestPart>) {
        // By side, what a pocket lets out there.
        let mut let_out = vec![Vec::new(); self.sides.len()];
        for (number, pocket) in walls.pockets().enumerate() {
            let weight = f64::from(self.pockets[number].weight);
            for (link, side) in pocket.sides {
                let share = WEIGHTS[walls.links.links()[link as usize].leaving(side)] / weight;
                for (of, sign) in [(side, -1.0), (1 - side, 1.0)] {
                    let_out[2 * link as usize + of].push(RestPart {
                        number: OF_A_POCKET | number as u32,
                        factor: (sign * share) as f32,
                    });
                }
            }
        }
        let (mut starts, mut parts) = (vec![0], Vec::new());
        for of_cell in lists.at_rest.parts() {
            for &(_, number) in of_cell {
                parts.push(RestPart {
                    number,
                    factor: 1.0,
                });
                parts.extend_from_slice(&let_out[number as usize]);
            }
            starts.push(parts.len() as u32);
        }
        (starts, parts)
    }
}
