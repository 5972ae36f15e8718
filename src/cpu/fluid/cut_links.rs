//! Stages `read_links` and `bounce`: what leaves along cut links, and what comes back ([`crate::cut_links`]).
//!
//! The two populations of a link lie at one place in memory, and no other link touches them. A cut is a swap with a term of the wall, and the order of
//! links does not matter. Those of one pair of directions are a task. The share of the population at rest is added in their order.

use rayon::prelude::*;

use super::{Fluid, Stored};
use crate::cut_links::places::{Place, Places};
use crate::cut_links::{ChangedByPair, CutLink, Leaving, Return, SIDES};
use crate::lattice::{DIRECTION_COUNT, Real};

/// Links that one task reads.
const LINKS_AT_ONCE: usize = 512;

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Stage `read_links`: what every side of every link gets back, for a sheet at rest.
    pub fn read_links(&self, links: &[CutLink], returns: &mut Vec<[Return; 2]>) {
        let places = Places::new(self.grid, &self.setup, self.odd);
        let arrays = self.arrays();
        let read = |(array, element): Place| arrays[array][element].unpacked().to_f64();
        returns.resize(links.len(), [Return::default(); 2]);
        returns
            .par_iter_mut()
            .zip(links)
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|(returns, link)| {
                for side in SIDES {
                    let out = read(places.out(link, side));
                    let further = places.further(link, side).map_or(0.0, read);
                    returns[side] = link.returned(side, out, further);
                }
            });
    }

    fn arrays(&self) -> [&[P]; DIRECTION_COUNT] {
        std::array::from_fn(|array| &self.populations[array])
    }

    /// Stage `read_images`: what left cells in all directions.
    pub fn read_images(&self, cells: &[[i32; 3]], leaving: &mut Vec<Leaving>) {
        let places = Places::new(self.grid, &self.setup, self.odd);
        let arrays = self.arrays();
        let ends = self.exchanged_ends.as_ref();
        leaving.resize(cells.len(), [0.0; DIRECTION_COUNT]);
        (leaving.par_iter_mut().zip(cells))
            .with_min_len(LINKS_AT_ONCE / DIRECTION_COUNT)
            .for_each(|(leaving, cell)| {
                let place = places.leaving(*cell);
                // Next to an end of a row what left may have arrived where populations wait.
                let ends = ends.filter(|ends| ends.is_near(*cell));
                *leaving = std::array::from_fn(|direction| {
                    let arrived = ends.and_then(|ends| ends.waiting_beside(*cell, direction));
                    arrived.map_or_else(
                        || {
                            let (array, element) = place(direction);
                            arrays[array][element].unpacked().to_f64()
                        },
                        T::to_f64,
                    )
                });
            });
    }

    /// Stage `bounce`: writes what comes `back` to both sides of every link, adds to the population at `rest` there, and what is `changed` along open links.
    pub fn bounce(
        &mut self,
        links: &[CutLink],
        back: &[[f64; 2]],
        rest: &[[f64; 2]],
        changed: &ChangedByPair,
    ) {
        let places = Places::new(self.grid, &self.setup, self.odd);
        let mut of_pair: [Vec<u32>; DIRECTION_COUNT / 2] = Default::default();
        for (number, link) in links.iter().enumerate() {
            of_pair[usize::from(link.pair)].push(number as u32);
        }
        let [at_rest, moving @ ..] = self.populations.arrays_mut();
        // The links of a pair of directions write to its two arrays alone.
        let along = |(pair, (arrays, of_pair)): (usize, (&mut [&mut [P]], &Vec<u32>))| {
            for change in changed.get(1 + pair).into_iter().flatten() {
                let (array, element) = places.leaving(change.cell)(usize::from(change.direction));
                let population = &mut arrays[array - 1 - 2 * pair][element];
                *population = P::packed(T::of(population.unpacked().to_f64() + change.change));
            }
            for number in of_pair {
                let number = *number as usize;
                for side in SIDES {
                    let (array, element) = places.back(&links[number], side);
                    arrays[array - 1 - 2 * pair][element] = P::packed(T::of(back[number][side]));
                }
            }
        };
        let (mut moving, of_pair) = (moving, of_pair);
        rayon::join(
            || {
                for change in &changed[0] {
                    let at_rest = &mut at_rest[self.grid.index(change.cell.map(i64::from))];
                    *at_rest = P::packed(T::of(at_rest.unpacked().to_f64() + change.change));
                }
                for (link, rest) in links.iter().zip(rest) {
                    for side in SIDES {
                        let at_rest = &mut at_rest[places.rest(link, side)];
                        *at_rest = P::packed(T::of(at_rest.unpacked().to_f64() + rest[side]));
                    }
                }
            },
            || {
                (moving.par_chunks_mut(2).zip(&of_pair))
                    .enumerate()
                    .for_each(along);
            },
        );
    }
}
