//! Stages `read_links`, `fetch_links` and `bounce` ([`crate::cut_links`]): lists of places made on the host, a thread for each population.

use rayon::prelude::*;

use super::Fluid;
use super::link_lists::{LinkLists, Listed};
use crate::cut_links::places::{Place, Places};
use crate::cut_links::{CellState, ChangedByPair, CutLink, CutLinks, Return, SIDES};
use crate::gpu::error::DeviceError;
use crate::lattice::DIRECTION_COUNT;

/// Links and cells that one task works on.
const AT_ONCE: usize = 512;

fn listed((array, element): Place) -> Listed {
    [array as u32, element as u32]
}

impl Fluid {
    fn lists(&mut self) -> Result<LinkLists, DeviceError> {
        match self.link_lists.take() {
            Some(lists) => Ok(lists),
            None => LinkLists::new(&self.device, self.storage),
        }
    }

    /// Stage `read_links`: asks what left along every side of every link. While the device reads, the places that stage `bounce` writes to are laid out, those that are `changed` among
    /// them. [`Fluid::fetch_links`] is to follow.
    pub fn read_links(
        &mut self,
        links: &CutLinks,
        changed: &ChangedByPair,
    ) -> Result<(), DeviceError> {
        let (search, links) = (links.search(), links.links());
        if links.is_empty() {
            return Ok(());
        }
        let mut lists = self.lists()?;
        self.lay_read_links(&mut lists, (search, links), self.odd)?;
        let list = &mut lists.read_links[usize::from(self.odd)];
        list.read(&self.device, 4 * links.len());
        self.lay_bounce(&mut lists, (search, links), changed, self.odd)?;
        self.link_lists = Some(lists);
        Ok(())
    }

    /// Stage `fetch_links`: what every side of every link gets back, for a sheet at rest.
    pub fn fetch_links(
        &mut self,
        links: &CutLinks,
        returns: &mut Vec<[Return; 2]>,
    ) -> Result<(), DeviceError> {
        let links = links.links();
        returns.resize(links.len(), [Return::default(); 2]);
        if links.is_empty() {
            return Ok(());
        }
        let mut lists = self.lists()?;
        let list = &mut lists.read_links[usize::from(self.odd)];
        list.numbers(&self.device, 4 * links.len(), |numbers| {
            (returns.par_iter_mut().zip(links))
                .zip(numbers.par_chunks(4))
                .with_min_len(AT_ONCE)
                .for_each(|((returns, link), read)| {
                    for side in SIDES {
                        let [out, further] = [0, 1].map(|k| f64::from(read[2 * side + k]));
                        returns[side] = link.returned(side, out, further);
                    }
                });
        })?;
        self.link_lists = Some(lists);
        Ok(())
    }

    /// Stage `read_links`, where the air slides: asks what left the first `count` of `cells` in all directions. All that may be asked of are laid out at once, those of the images for
    /// the links of a `search`. [`Fluid::fetch_images`] is to follow.
    pub fn read_images(
        &mut self,
        search: u64,
        (cells, count): (&[[i32; 3]], usize),
    ) -> Result<(), DeviceError> {
        if count == 0 {
            return Ok(());
        }
        let mut lists = self.lists()?;
        self.lay_read_images(&mut lists, (search, cells), self.odd)?;
        let list = &mut lists.read_images[usize::from(self.odd)];
        list.read(&self.device, DIRECTION_COUNT * count);
        self.link_lists = Some(lists);
        Ok(())
    }

    /// Stage `fetch_links`, where the air slides: what left the first `count` of the cells.
    pub fn fetch_images(
        &mut self,
        count: usize,
        states: &mut Vec<CellState<f32>>,
    ) -> Result<(), DeviceError> {
        states.resize(count, CellState::default());
        if count == 0 {
            return Ok(());
        }
        let mut lists = self.lists()?;
        let list = &mut lists.read_images[usize::from(self.odd)];
        list.numbers(&self.device, DIRECTION_COUNT * count, |numbers| {
            (states.par_iter_mut())
                .zip(numbers.par_chunks(DIRECTION_COUNT))
                .with_min_len(AT_ONCE)
                .for_each(|(state, read)| {
                    *state = CellState::new(std::array::from_fn(|direction| read[direction]));
                });
        })?;
        self.link_lists = Some(lists);
        Ok(())
    }

    /// Lays out the places of stage `read_links` for an `odd` step or an even one. They are those of what left, and of the further population or what left again.
    pub(super) fn lay_read_links(
        &self,
        lists: &mut LinkLists,
        (search, links): (u64, &[CutLink]),
        odd: bool,
    ) -> Result<(), DeviceError> {
        let places = Places::new(self.grid, &self.setup, odd);
        let list = &mut lists.read_links[usize::from(odd)];
        if list.is_of(search, 4 * links.len()) {
            return Ok(());
        }
        lists.places.resize(4 * links.len(), Listed::default());
        (lists.places.par_chunks_mut(4).zip(links))
            .with_min_len(AT_ONCE)
            .for_each(|(listed_places, link)| {
                for side in SIDES {
                    let out = places.out(link, side);
                    let further = places.further(link, side).unwrap_or(out);
                    listed_places[2 * side] = listed(out);
                    listed_places[2 * side + 1] = listed(further);
                }
            });
        list.lay(&self.device, &self.populations, search, &lists.places)
    }

    /// The same of what left the `cells` of images in all directions.
    pub(super) fn lay_read_images(
        &self,
        lists: &mut LinkLists,
        (search, cells): (u64, &[[i32; 3]]),
        odd: bool,
    ) -> Result<(), DeviceError> {
        let places = Places::new(self.grid, &self.setup, odd);
        let list = &mut lists.read_images[usize::from(odd)];
        let laid = DIRECTION_COUNT * cells.len();
        if list.is_of(search, laid) {
            return Ok(());
        }
        lists.places.resize(laid, Listed::default());
        (lists.places.par_chunks_mut(DIRECTION_COUNT).zip(cells))
            .with_min_len(AT_ONCE)
            .for_each(|(listed_places, cell)| {
                let place = places.leaving(*cell);
                for (direction, listed_place) in listed_places.iter_mut().enumerate() {
                    *listed_place = listed(place(direction));
                }
            });
        list.lay(&self.device, &self.populations, search, &lists.places)
    }

    /// Lays out the places of stage `bounce`: both sides of every link, populations at rest, and those that are changed along open links.
    pub(super) fn lay_bounce(
        &self,
        lists: &mut LinkLists,
        (search, links): (u64, &[CutLink]),
        [at_rest, moving @ ..]: &ChangedByPair,
        odd: bool,
    ) -> Result<(), DeviceError> {
        let places = Places::new(self.grid, &self.setup, odd);
        lists.at_rest.lay(&places, (search, links), at_rest);
        let list = &mut lists.bounce[usize::from(odd)];
        let sides = 2 * links.len();
        let changes = moving.iter().map(Vec::len).sum::<usize>();
        let count = sides + lists.at_rest.count() + changes;
        if list.is_of(search, count) {
            return Ok(());
        }
        lists.places.resize(sides, Listed::default());
        (lists.places.par_chunks_mut(2).zip(links))
            .with_min_len(AT_ONCE)
            .for_each(|(listed_places, link)| {
                for side in SIDES {
                    listed_places[side] = listed(places.back(link, side));
                }
            });
        let cells = lists.at_rest.elements().map(|element| [0, element]);
        lists.places.extend(cells);
        let changes = (moving.iter().flatten())
            .map(|change| places.leaving(change.cell)(usize::from(change.direction)));
        lists.places.extend(changes.map(listed));
        list.lay(&self.device, &self.populations, search, &lists.places)
    }

    /// Stage `bounce`, where the last `read_links` laid the places out: writes what comes `back` to both sides of every link. Adds to the population at `rest` there, and what is `changed`
    /// along open links to what left cells of those `states`.
    pub fn bounce(
        &mut self,
        links: &CutLinks,
        back: &[[f64; 2]],
        rest: &[[f64; 2]],
        (states, changed): (&[CellState<f32>], &ChangedByPair),
    ) -> Result<(), DeviceError> {
        if links.links().is_empty() {
            return Ok(());
        }
        let mut lists = self.lists()?;
        let [at_rest, moving @ ..] = changed;
        let (sides, cells) = (2 * back.len(), lists.at_rest.count());
        let changes = moving.iter().map(Vec::len).sum::<usize>();
        lists.numbers.resize(sides + cells + changes, 0.0);
        let (of_sides, others) = lists.numbers.split_at_mut(sides);
        let (of_cells, of_changes) = others.split_at_mut(cells);
        (of_sides.par_chunks_mut(2).zip(back))
            .with_min_len(AT_ONCE)
            .for_each(|(numbers, back)| {
                for side in SIDES {
                    numbers[side] = back[side] as f32;
                }
            });
        lists.at_rest.add_up(rest, at_rest, of_cells);
        for (number, change) in of_changes.iter_mut().zip(moving.iter().flatten()) {
            let population = states[change.number as usize].leaving(usize::from(change.direction));
            *number = (population + change.change) as f32;
        }
        lists.bounce[usize::from(self.odd)].write(&self.device, &lists.numbers);
        self.link_lists = Some(lists);
        self.device.check()
    }
}
