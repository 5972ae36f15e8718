//! Stages `read_links` and `bounce` ([`crate::cut_links`]): lists of places made on the host, a thread for each population.

use super::Fluid;
use super::link_lists::{LinkLists, LinkParameters};
use crate::cut_links::places::{Place, Places};
use crate::cut_links::{ChangedByPair, CutLink, Leaving, Return, SIDES};
use crate::gpu::error::DeviceError;
use crate::lattice::DIRECTION_COUNT;

fn listed((array, element): Place) -> [u32; 2] {
    [array as u32, element as u32]
}

impl Fluid {
    /// Lists with room for so many populations.
    fn lists(&mut self, count: usize) -> Result<LinkLists, DeviceError> {
        let mut lists = match self.link_lists.take() {
            Some(lists) => lists,
            None => LinkLists::new(&self.device, self.storage, &self.populations, count)?,
        };
        lists.reserve(&self.device, &self.populations, count)?;
        Ok(lists)
    }

    /// Stage `read_links`: what every side of every link gets back, for a sheet at rest.
    pub fn read_links(
        &mut self,
        links: &[CutLink],
        returns: &mut Vec<[Return; 2]>,
    ) -> Result<(), DeviceError> {
        returns.resize(links.len(), [Return::default(); 2]);
        if links.is_empty() {
            return Ok(());
        }
        let places = Places::new(self.grid, &self.setup, self.odd);
        // What left, and the further population; what left twice where there is none.
        let mut lists = self.lists(4 * links.len())?;
        lists.places.clear();
        for link in links {
            for side in SIDES {
                let out = places.out(link, side);
                let further = places.further(link, side).unwrap_or(out);
                lists.places.extend([listed(out), listed(further)]);
            }
        }
        self.read_listed(&lists, "read_links", |numbers| {
            for ((link, returns), read) in links
                .iter()
                .zip(returns.iter_mut())
                .zip(numbers.chunks_exact(4))
            {
                for side in SIDES {
                    let [out, further] = [0, 1].map(|k| f64::from(read[2 * side + k]));
                    returns[side] = link.returned(side, out, further);
                }
            }
        })?;
        self.link_lists = Some(lists);
        Ok(())
    }

    /// Reads the populations in a list.
    fn read_listed(
        &self,
        lists: &LinkLists,
        stage: &'static str,
        take: impl FnOnce(&[f32]),
    ) -> Result<(), DeviceError> {
        let (device, room) = (&self.device, &lists.room);
        let parameters = LinkParameters {
            count: lists.places.len() as u32,
            ..LinkParameters::default()
        };
        device.write(&lists.parameters, 0, &[parameters]);
        device.write(&room.places, 0, &lists.places);
        let mut commands = device.record(stage);
        {
            let mut pass = commands.pass(stage);
            room.bound[0].dispatch(&mut pass, device.workgroups(lists.places.len() as u64));
        }
        let bytes = 4 * lists.places.len() as u64;
        room.staging.copy(&mut commands, &room.numbers, 0, 0, bytes);
        device.submit(commands);
        room.staging
            .read(device, |bytes| take(bytemuck::cast_slice(bytes)))
    }

    /// Stage `read_images`: what left cells in all directions.
    pub fn read_images(
        &mut self,
        cells: &[[i32; 3]],
        leaving: &mut Vec<Leaving>,
    ) -> Result<(), DeviceError> {
        leaving.resize(cells.len(), [0.0; DIRECTION_COUNT]);
        if cells.is_empty() {
            return Ok(());
        }
        let places = Places::new(self.grid, &self.setup, self.odd);
        let mut lists = self.lists(DIRECTION_COUNT * cells.len())?;
        lists.places.clear();
        for cell in cells {
            let of_cell = (0..DIRECTION_COUNT).map(places.leaving(*cell));
            lists.places.extend(of_cell.map(listed));
        }
        self.read_listed(&lists, "read_images", |numbers| {
            for (leaving, read) in leaving
                .iter_mut()
                .zip(numbers.chunks_exact(DIRECTION_COUNT))
            {
                *leaving = std::array::from_fn(|direction| f64::from(read[direction]));
            }
        })?;
        self.link_lists = Some(lists);
        Ok(())
    }

    /// Stage `bounce`: writes what comes `back` to both sides of every link, adds to the population at `rest` there, and what is `changed` along open links to what was `leaving`.
    pub fn bounce(
        &mut self,
        links: &[CutLink],
        back: &[[f64; 2]],
        rest: &[[f64; 2]],
        (leaving, changed): (&[Leaving], &ChangedByPair),
    ) -> Result<(), DeviceError> {
        if links.is_empty() {
            return Ok(());
        }
        let places = Places::new(self.grid, &self.setup, self.odd);
        let changes = changed.iter().map(Vec::len).sum::<usize>();
        let mut lists = self.lists(4 * links.len() + changes)?;
        lists.places.clear();
        lists.numbers.clear();
        lists.rest.clear();
        for ((link, back), rest) in links.iter().zip(back).zip(rest) {
            for side in SIDES {
                lists.places.push(listed(places.back(link, side)));
                lists.numbers.push(back[side] as f32);
                if rest[side] != 0.0 {
                    lists
                        .rest
                        .push((places.rest(link, side) as u32, rest[side]));
                }
            }
        }
        for change in changed.iter().flatten() {
            let direction = usize::from(change.direction);
            let place = places.leaving(change.cell)(direction);
            if direction == 0 {
                lists.rest.push((place.1 as u32, change.change));
            } else {
                lists.places.push(listed(place));
                let population = leaving[change.number as usize][direction];
                lists.numbers.push((population + change.change) as f32);
            }
        }
        // All that goes to one cell at once, in the order of links: a stable sort.
        lists.rest.sort_by_key(|(element, _)| *element);
        for group in lists.rest.chunk_by(|a, b| a.0 == b.0) {
            let sum: f64 = group.iter().map(|(_, share)| share).sum();
            lists.places.push([0, group[0].0]);
            lists.numbers.push(sum as f32);
        }
        let (device, room) = (&self.device, &lists.room);
        let parameters = LinkParameters {
            count: lists.places.len() as u32,
            ..LinkParameters::default()
        };
        device.write(&lists.parameters, 0, &[parameters]);
        device.write(&room.places, 0, &lists.places);
        device.write(&room.numbers, 0, &lists.numbers);
        let mut commands = device.record("bounce");
        {
            let mut pass = commands.pass("bounce");
            room.bound[1].dispatch(&mut pass, device.workgroups(lists.places.len() as u64));
        }
        device.leave(commands);
        self.link_lists = Some(lists);
        self.device.check()
    }
}
