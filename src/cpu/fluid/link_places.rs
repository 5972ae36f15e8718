//! Where the populations of cut links lie, kept until the links are others.

use rayon::prelude::*;

use crate::cut_links::places::{Place, Places};
use crate::cut_links::{CutLink, CutLinks, SIDES, Side};
use crate::lattice::{DIRECTION_COUNT, opposite};

/// Links that one task lays out.
const LINKS_AT_ONCE: usize = 512;

/// Where the populations of links lie, in either parity.
#[derive(Debug, Clone, Default)]
pub(super) struct LinkPlaces {
    /// Number of the search that found the links.
    search: u64,
    /// By link, elements that its sides read.
    pub read: Vec<[Read; 2]>,
    pairs: Vec<u8>,
    /// By pair of directions, the links of it.
    pub of_pair: [Vec<u32>; DIRECTION_COUNT / 2],
}

/// Elements that a side of a link reads.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Read {
    /// Of what leaves its cell. What comes back to the other cell is put there, in the other array of the pair.
    pub out: usize,
    /// Of the further population; `out` without one.
    further: usize,
}

impl Read {
    /// What the side needs, and where it is before a step of a parity.
    #[inline(always)]
    pub fn places(self, link: &CutLink, side: usize, odd: bool) -> (Place, Option<Place>) {
        let leaving = link.leaving(side);
        let further = match link.side(side) {
            Side::HalfWay => None,
            Side::Near => Some((array(leaving, odd), self.further)),
            Side::Far => Some((array(opposite(leaving), odd), self.further)),
        };
        ((array(leaving, odd), self.out), further)
    }
}

impl LinkPlaces {
    /// Lays them out, anew where the links are others.
    pub fn lay(&mut self, links: &CutLinks, places: &Places) {
        if self.search == links.search() {
            return;
        }
        self.search = links.search();
        let read = |link: &CutLink| {
            SIDES.map(|side| {
                let (_, out) = places.out(link, side);
                let further = places.further(link, side);
                Read {
                    out,
                    further: further.map_or(out, |(_, element)| element),
                }
            })
        };
        (links.links().par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(|link| (read(link), link.pair))
            .unzip_into_vecs(&mut self.read, &mut self.pairs);
        let pairs = &self.pairs;
        (self.of_pair.par_iter_mut().enumerate()).for_each(|(pair, of_pair)| {
            let is_of_pair = |number: &u32| usize::from(pairs[*number as usize]) == pair;
            of_pair.clear();
            of_pair.extend((0..pairs.len() as u32).filter(is_of_pair));
        });
    }
}

/// Array that holds what leaves in a direction (not 0), before a step of a parity.
pub(super) const fn array(direction: usize, odd: bool) -> usize {
    if odd { direction } else { opposite(direction) }
}
