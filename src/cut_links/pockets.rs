//! Air shut in by folds: cells that one open link leaves at most.
//!
//! A fold that closes over the last cells inside presses their air together, for no link leads out; in truth it gets out along the fold. Such cells
//! reach densities that no flow has, 1.4 in a folded canopy of 96 cells per D_0. *Departure*: what is beyond an excess of 0.05 goes to the populations at
//! rest of the cells around, a share in every step. What is missing beyond it comes from there. Mass stays exact; the sheet feels what is left.

use rayon::prelude::*;

use super::bounce::{Return, SIDES};
use super::search::{CutLink, CutLinks};
use crate::lattice::{DIRECTION_COUNT, WEIGHTS};

/// Density excess over the cells around that the air shut in keeps: five times that of stagnation at 0.08 cells per step.
pub const KEPT: f64 = 0.05;

/// Share of the rest that gets out in a step.
pub const SHARE: f64 = 0.5;

/// Links that are cut at least.
const CUT: u32 = DIRECTION_COUNT as u32 - 2;

/// Links that one task works on.
const LINKS_AT_ONCE: usize = 4096;

/// A link, and the side that a cell is on.
type OnLink = (u32, usize);

/// The cells that are shut in.
#[derive(Debug, Clone, Default)]
pub struct Pockets {
    /// Their cut links, cell after cell.
    sides: Vec<OnLink>,
    /// Number of the search for the links.
    search: u64,
}

fn cell_of(links: &[CutLink], &(number, side): &OnLink) -> [i32; 3] {
    links[number as usize].cells[side]
}

impl Pockets {
    /// Finds them, anew where the links are others.
    pub fn find(&mut self, links: &CutLinks) {
        if self.search == links.search() {
            return;
        }
        self.search = links.search();
        let all = links.links();
        self.sides.clear();
        let sides = (0..all.len() as u32).into_par_iter();
        self.sides
            .par_extend(sides.with_min_len(LINKS_AT_ONCE).flat_map_iter(|number| {
                let on_link = SIDES.map(|side| (number, side));
                let is_shut_in =
                    |side: &OnLink| links.cut_around(cell_of(all, side)).count() >= CUT;
                on_link.into_iter().filter(is_shut_in)
            }));
        self.sides.sort_by_key(|side| cell_of(all, side));
    }

    /// Cut links of each of them.
    pub(super) fn each<'a>(&'a self, links: &'a [CutLink]) -> impl Iterator<Item = &'a [OnLink]> {
        self.sides
            .chunk_by(|a, b| cell_of(links, a) == cell_of(links, b))
    }

    /// Lets out what is too much in them, by what left them and the cells around along `links`: changes what is added to populations at `rest`.
    pub fn relieve(&self, links: &[CutLink], returns: &[[Return; 2]], rest: &mut [[f64; 2]]) {
        for sides in self.each(links) {
            let sides = sides.iter().map(|&(link, side)| (link as usize, side));
            let (mut more, mut weight) = (0.0, 0.0);
            for (link, side) in sides.clone() {
                more += returns[link][side].out - returns[link][1 - side].out;
                weight += WEIGHTS[links[link].leaving(side)];
            }
            let excess = more / weight;
            let let_out = SHARE * (excess.abs() - KEPT).max(0.0).copysign(excess);
            for (link, side) in sides {
                let part = WEIGHTS[links[link].leaving(side)] / weight * let_out;
                rest[link][side] -= part;
                rest[link][1 - side] += part;
            }
        }
    }
}
