//! Walls that stand still: what a device has to know of their cut links to answer by itself, step after step (`src/gpu/fluid/standing_walls.rs`).
//!
//! There no link and no coefficient changes. Two things are not linear in the air: the share that holds the energy of a block ([`super::energy`]), and the velocity with which mass is
//! given back ([`super::reflections`]).

use std::ops::Range;

use super::blocks::Blocks;
use super::images::Images;
use super::slide::Image;
use super::{CutLink, CutLinks, Pockets, Return, SIDES};

/// What walls that stand still are made of. Sides are numbered by their links: twice the link's number, plus the side's.
#[derive(Debug, Clone, Copy)]
pub struct StandingWalls<'a> {
    /// The links.
    pub links: &'a CutLinks,
    /// Images, where the air slides; `None` where it sticks to all walls.
    pub images: Option<&'a Images>,
    /// Cells that the walls shut in.
    pub pockets: &'a Pockets,
}

/// An image, as far as it matters where the wall stands.
#[derive(Debug, Clone, Copy)]
pub struct StandingImage {
    /// Number of its side.
    pub side: u32,
    /// Number of the direction d in which air leaves the side.
    pub direction: u8,
    /// Unit normal n away from the air.
    pub away: [f64; 3],
    /// β ([`super::slide`]).
    pub turned_round: f64,
    /// Number of the side's own cell.
    pub own: u32,
    /// Cells that it is taken from.
    pub cells: [u32; 3],
    /// Their shares.
    pub shares: [f64; 3],
}

/// A block of sides that share what they lose.
#[derive(Debug, Clone)]
pub struct StandingBlock {
    /// Its images.
    pub images: Range<usize>,
    /// The space that they look at.
    pub space: u32,
    /// Sum of their weights.
    pub weight: f64,
}

/// Air shut in by a fold.
#[derive(Debug, Clone)]
pub struct StandingPocket {
    /// Its sides: link and side.
    pub sides: Vec<(u32, usize)>,
}

impl StandingWalls<'_> {
    /// What comes back where the air sticks: shares of what left, and of the further population.
    #[must_use]
    pub fn sticking(link: &CutLink, side: usize) -> [f64; 2] {
        let Return { share, further, .. } = link.returned(side, 0.0, 1.0);
        [share, further]
    }

    /// All images, block by block.
    pub fn images(&self) -> impl Iterator<Item = StandingImage> {
        let of = |image: &Image| StandingImage {
            side: 2 * image.link + u32::from(image.side),
            direction: image.direction,
            away: image.away.to_array(),
            turned_round: image.turned_round,
            own: image.own,
            cells: image.cells,
            shares: image.shares,
        };
        self.images.into_iter().flat_map(Images::all).map(of)
    }

    /// Numbers of the image and of the block of every side; `None` where the air sticks.
    pub fn of_sides(&self) -> impl Iterator<Item = Option<(usize, usize)>> {
        let of_links = self.images.map(Images::of_links);
        (0..self.links.links().len()).flat_map(move |link| {
            SIDES.map(|side| of_links.and_then(|of_links| of_links[link][side].get()))
        })
    }

    /// The blocks.
    pub fn blocks(&self) -> impl Iterator<Item = StandingBlock> {
        let blocks = self.images.map(Images::blocks);
        blocks.into_iter().flat_map(|blocks| {
            (0..blocks.count()).map(|block| StandingBlock {
                images: blocks.sides(block),
                space: blocks.space(block),
                weight: blocks.weight(block),
            })
        })
    }

    /// Sum of the weights of all sides that look at each space.
    #[must_use]
    pub fn weights_of_spaces(&self) -> &[f64] {
        (self.images.map(Images::blocks)).map_or(&[][..], Blocks::weights_of_spaces)
    }

    /// The cells that are shut in.
    pub fn pockets(&self) -> impl Iterator<Item = StandingPocket> {
        let of = |sides: &[(u32, usize)]| StandingPocket {
            sides: sides.to_vec(),
        };
        self.pockets.each(self.links.links()).map(of)
    }
}
