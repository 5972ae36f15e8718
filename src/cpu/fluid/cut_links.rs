//! Stages `read_links` and `bounce`: what leaves along cut links, and what comes back ([`crate::cut_links`]).
//!
//! The two populations of a link lie at one place in memory, and no other link touches them. A cut is a swap with a term of the wall, and the order of
//! links does not matter. Those of one pair of directions are a task. The share of the population at rest is added in their order, pair after pair.

use rayon::prelude::*;

use super::link_places::{LinkPlaces, array};
use super::prefetch::prefetch_behind;
use super::{Fluid, Stored};
use crate::cut_links::places::{Place, Places};
use crate::cut_links::{CellState, Changed, ChangedByPair, CutLinks, Return, SIDES};
use crate::lattice::{DIRECTION_COUNT, Real};

/// Links that one task reads.
const LINKS_AT_ONCE: usize = 512;

/// Links, and cells, between one that is read and the one whose populations are asked for. They lie far apart, and the CPU would wait for each.
///
/// Together with leaving out sides that slide, asking took `read_links` of a closed wing (48 cells, one thread) from 44 to 33 ms. These distances were chosen, not tuned.
const LINKS_AHEAD: usize = 16;
const CELLS_AHEAD: usize = 3;

/// Asks for one of the populations, if it is one.
#[inline(always)]
fn ask_for<P>(populations: &[P], element: usize) {
    if let Some(population) = populations.get(element) {
        prefetch_behind(population, 0);
    }
}

impl<T: Real, P: Stored<Real = T>> Fluid<P> {
    /// Stage `read_links`: what every side of every link gets back, for a sheet at rest. If `stick` tells at which sides the air sticks, the others are left as they are.
    pub fn read_links(
        &mut self,
        links: &CutLinks,
        stick: &[[bool; 2]],
        returns: &mut Vec<[Return; 2]>,
    ) {
        let places = Places::new(self.grid, &self.setup, self.odd);
        self.link_places.lay(links, &places);
        let (arrays, odd) = (self.arrays(), self.odd);
        let read = |(array, element): Place| arrays[array][element].unpacked().to_f64();
        let (links, elements) = (links.links(), &*self.link_places.read);
        let sticks = |number: usize, side: usize| stick.get(number).is_none_or(|at| at[side]);
        let ask = |number: usize| {
            let Some(link) = links.get(number) else {
                return;
            };
            for side in SIDES.into_iter().filter(|side| sticks(number, *side)) {
                let (out, further) = elements[number][side].places(link, side, odd);
                ask_for(arrays[out.0], out.1);
                if let Some((array, element)) = further {
                    ask_for(arrays[array], element);
                }
            }
        };
        returns.resize(links.len(), [Return::default(); 2]);
        (returns.par_iter_mut().enumerate())
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|(number, returns)| {
                ask(number + LINKS_AHEAD);
                for side in SIDES.into_iter().filter(|side| sticks(number, *side)) {
                    let link = &links[number];
                    let (out, further) = elements[number][side].places(link, side, odd);
                    returns[side] = link.returned(side, read(out), further.map_or(0.0, read));
                }
            });
    }

    fn arrays(&self) -> [&[P]; DIRECTION_COUNT] {
        std::array::from_fn(|array| &self.populations[array])
    }

    /// Stage `read_images`: what left cells in all directions.
    pub fn read_images(&self, cells: &[[i32; 3]], states: &mut Vec<CellState<T>>) {
        let places = Places::new(self.grid, &self.setup, self.odd);
        let arrays = self.arrays();
        let ends = self.exchanged_ends.as_ref();
        let by_direction = places.offsets().map(|(array, by)| (arrays[array], by));
        let ask = |cell: [i32; 3]| {
            if let Some(index) = places.index_inside(cell) {
                for (populations, by) in by_direction {
                    ask_for(populations, index.wrapping_add_signed(by));
                }
            }
        };
        states.resize(cells.len(), CellState::default());
        (states.par_iter_mut().enumerate())
            .with_min_len(LINKS_AT_ONCE / DIRECTION_COUNT)
            .for_each(|(number, state)| {
                cells.get(number + CELLS_AHEAD).copied().map(ask);
                let cell = cells[number];
                // Next to an end of a row what left may have arrived where populations wait.
                let ends = ends.filter(|ends| ends.is_near(cell));
                if let (Some(index), None) = (places.index_inside(cell), ends) {
                    let leaving = by_direction.map(|(populations, by)| {
                        populations[index.wrapping_add_signed(by)].unpacked()
                    });
                    *state = CellState::new(leaving);
                    return;
                }
                let place = places.leaving(cell);
                *state = CellState::new(std::array::from_fn(|direction| {
                    let arrived = ends.and_then(|ends| ends.waiting_beside(cell, direction));
                    let (array, element) = place(direction);
                    arrived.unwrap_or_else(|| arrays[array][element].unpacked())
                }));
            });
    }

    /// Stage `bounce`: writes what comes `back` to both sides of every link. Adds to the population at `rest` there, and what is `changed` along open links.
    pub fn bounce(
        &mut self,
        links: &CutLinks,
        back: &[[f64; 2]],
        rest: &[[f64; 2]],
        changed: &ChangedByPair,
    ) {
        let places = Places::new(self.grid, &self.setup, self.odd);
        self.link_places.lay(links, &places);
        let shifts = self.grid.pair_shifts();
        let LinkPlaces { read, of_pair, .. } = &self.link_places;
        let [at_rest, moving @ ..] = self.populations.arrays_mut();
        // The links of a pair of directions write to its two arrays alone.
        let along = |(pair, (arrays, of_pair)): (usize, (&mut [&mut [P]], &Vec<u32>))| {
            let first = 2 * pair + 1;
            let changed = changed.get(1 + pair).map_or(&[][..], |changed| &**changed);
            let place = |change: &Changed| {
                let (array, element) = places.leaving(change.cell)(usize::from(change.direction));
                (array - first, element)
            };
            for (number, change) in changed.iter().enumerate() {
                if let Some(change) = changed.get(number + LINKS_AHEAD) {
                    let (array, element) = place(change);
                    ask_for(arrays[array], element);
                }
                let (array, element) = place(change);
                let population = &mut arrays[array][element];
                *population = P::packed(T::of(population.unpacked().to_f64() + change.change));
            }
            let [to_a, to_b] = [first + 1, first].map(|from| array(from, self.odd) - first);
            for (place, number) in of_pair.iter().enumerate() {
                if let Some(number) = of_pair.get(place + LINKS_AHEAD) {
                    let [of_a, of_b] = read[*number as usize].map(|read| read.out);
                    ask_for(arrays[to_a], of_b);
                    ask_for(arrays[to_b], of_a);
                }
                let number = *number as usize;
                // What comes back to a cell is put where the other cell's was read.
                let ([of_a, of_b], back) = (read[number].map(|read| read.out), back[number]);
                arrays[to_a][of_b] = P::packed(T::of(back[0]));
                arrays[to_b][of_a] = P::packed(T::of(back[1]));
            }
        };
        let mut moving = moving;
        rayon::join(
            || {
                for change in &changed[0] {
                    let at_rest = &mut at_rest[self.grid.index(change.cell.map(i64::from))];
                    *at_rest = P::packed(T::of(at_rest.unpacked().to_f64() + change.change));
                }
                for (of_pair, shift) in of_pair.iter().zip(shifts) {
                    // What leaves a cell has arrived at the other one.
                    let cells = |number: u32| {
                        let [cell_b, next_to_a] = read[number as usize].map(|read| read.out);
                        [next_to_a.wrapping_add_signed(-shift), cell_b]
                    };
                    for (place, number) in of_pair.iter().enumerate() {
                        if let Some(number) = of_pair.get(place + LINKS_AHEAD) {
                            for cell in cells(*number) {
                                ask_for(at_rest, cell);
                            }
                        }
                        for (cell, rest) in cells(*number).into_iter().zip(rest[*number as usize]) {
                            let at_rest = &mut at_rest[cell];
                            *at_rest = P::packed(T::of(at_rest.unpacked().to_f64() + rest));
                        }
                    }
                }
            },
            || {
                (moving.par_chunks_mut(2).zip(of_pair))
                    .enumerate()
                    .for_each(along);
            },
        );
    }
}
