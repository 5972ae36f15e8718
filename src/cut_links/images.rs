//! Images of all cut links at which the air slides ([`super::slide`]), and the cells that they are taken from.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::{Blocks, Key};
use super::boundary_layer::{Face, Seen};
use super::cell_numbers::CellNumbers;
use super::cell_states::CellState;
use super::modelled::{Modelled, Off};
use super::search::{CutLink, CutLinks, Domain};
use super::slide::{self, Image, Slides, away};
use super::surroundings::{Around, CELLS_OFF, Surroundings, straightest};
use crate::lattice::Real;

/// Links, cells and images that one task works on.
const AT_ONCE: usize = 512;

/// Images of all cut links at which the air slides.
#[derive(Debug, Default)]
pub struct Images {
    /// Block by block, within one in the order of links.
    images: Vec<Image>,
    blocks: Blocks,
    modelled: Modelled,
    /// Their sides: twice the link's number, plus the side's.
    sides: Vec<u32>,
    /// By link, those of its sides.
    of_links: Vec<[OfSide; 2]>,
    /// At which sides of every link the air sticks.
    stick: Vec<[bool; 2]>,
    /// Cells that they are taken from, and those of the sides themselves. Behind them come the others near the wall that models of the boundary layer ask for, and last those further off.
    /// Each part is in the order of memory.
    cells: Vec<[i32; 3]>,
    /// Where the first and the second part end.
    ends: [usize; 2],
    /// Numbers of the first two parts, and of the third.
    numbers: [CellNumbers; 2],
    /// By block, which of the images as they are found is the next.
    order: Vec<u32>,
}

/// Image of a side, and its block.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfSide {
    image: u32,
    block: u32,
}

impl OfSide {
    /// The air sticks.
    const NONE: Self = Self {
        image: u32::MAX,
        block: u32::MAX,
    };

    /// Numbers of the image and of its block, where the air slides.
    pub fn get(self) -> Option<(usize, usize)> {
        (self.image != u32::MAX).then_some((self.image as usize, self.block as usize))
    }
}

/// An image as it is found. Its cells are named by their places among those that may have numbers.
struct Found {
    image: Image,
    key: Key,
}

/// Cells of the images of which is asked what left them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Those that the images are taken from, and those of their sides.
    Images,
    /// Those near the wall, too, which lose the stress of modelled layers.
    Near,
    /// Those further off, too.
    Further,
}

impl Images {
    /// Lays them out for `links`; `slides` tells how the air slides along the triangle that a side of a link meets, if it does.
    pub fn find(
        &mut self,
        links: &CutLinks,
        domain: &Domain,
        slides: impl Fn(&CutLink, usize) -> Option<Slides> + Sync,
    ) {
        // Cells of images are next to the links'.
        const { assert!(CELLS_OFF[0] >= 1) };
        let air = Surroundings { links, domain };
        for (numbers, off) in self.numbers.iter_mut().zip(CELLS_OFF) {
            numbers.lay(links.cells().grown(off, domain.cells, domain.repeats));
        }
        let [numbers, further] = &self.numbers;
        // What is modelled names its cells by their places, too.
        let look = |(task, some): (usize, &[CutLink])| -> (Vec<Found>, Vec<Off>) {
            let (mut found, mut modelled) = (Vec::with_capacity(2 * some.len()), Vec::new());
            // Links that follow each other mostly meet the same triangle, on either of its faces.
            let mut last = [(DVec3::ZERO, 0); 2];
            for (number, link) in some.iter().enumerate() {
                for side in super::SIDES {
                    let Some(slides) = slides(link, side) else {
                        continue;
                    };
                    let away = away(link, side, slides.normal);
                    let face = slide::face(link, side, slides.normal);
                    let (known, ahead) = &mut last[face % 2];
                    if *known != away {
                        (*known, *ahead) = (away, straightest(-away));
                    }
                    let own = Around::new(&air, link.cells[side]);
                    let off = air.off((link, side), &own, (away, *ahead, slides.modelled));
                    let Some([(near, height), (far, far_height)]) = off else {
                        continue;
                    };
                    let (cells, closer) = air.cells_of_image((link, side), &own, away);
                    let number = (task * AT_ONCE + number) as u32;
                    let shares = cells.map(|(share, _)| share);
                    let mut image = Image::new((number, link, side), away, shares, closer);
                    image.own = numbers.place(own.cell);
                    image.cells = cells.map(|(_, cell)| numbers.place(cell));
                    let key = Key::new(slides.space, own.cell, own.cut.count());
                    found.push(Found { image, key });
                    if slides.modelled {
                        modelled.push(Off {
                            face: face as u32,
                            image: 0,
                            link: number,
                            side: side as u8,
                            cells: [numbers.place(near), further.place(far)],
                            heights: [height, far_height],
                        });
                    }
                }
            }
            (found, modelled)
        };
        let (found, modelled): (Vec<_>, Vec<_>) = (links.links().par_chunks(AT_ONCE).enumerate())
            .map(look)
            .unzip();
        let parts = found;
        let found: Vec<&Found> = parts.iter().flatten().collect();
        let mut modelled: Vec<Off> = modelled.into_iter().flatten().collect();
        self.number_cells(&found, &modelled);
        let keys = found.iter().map(|found| (found.key, found.image.weight()));
        let placed = self.blocks.lay(keys, &mut self.order);
        let [numbers, further] = &self.numbers;
        (self.order.par_iter())
            .with_min_len(AT_ONCE)
            .map(|of| {
                let mut image = found[*of as usize].image;
                image.own = numbers.at(image.own);
                image.cells = image.cells.map(|place| numbers.at(place));
                image
            })
            .collect_into_vec(&mut self.images);
        (self.images.par_iter())
            .with_min_len(AT_ONCE)
            .map(|image| 2 * image.link + u32::from(image.side))
            .collect_into_vec(&mut self.sides);
        self.of_links.clear();
        (self.of_links).resize(links.links().len(), [OfSide::NONE; 2]);
        let mut rest = &placed[..];
        let placed_parts: Vec<&[[u32; 2]]> = (parts.iter())
            .filter_map(|part| rest.split_off(..part.len()))
            .collect();
        let by_task = self.of_links.par_chunks_mut(AT_ONCE);
        (by_task.zip(&parts).zip(placed_parts).enumerate()).for_each(
            |(task, ((of_links, found), placed))| {
                for (Found { image, .. }, [place, block]) in found.iter().zip(placed) {
                    let (link, side) = image.place();
                    of_links[link - task * AT_ONCE][side] = OfSide {
                        image: *place,
                        block: *block,
                    };
                }
            },
        );
        (self.of_links.par_iter())
            .with_min_len(AT_ONCE)
            .map(|sides| sides.map(|side| side.get().is_none()))
            .collect_into_vec(&mut self.stick);
        let of_links = &self.of_links;
        (modelled.par_iter_mut())
            .with_min_len(AT_ONCE)
            .for_each(|off| {
                off.image = of_links[off.link as usize][usize::from(off.side)].image;
                let [near, far] = off.cells;
                off.cells = [numbers.at(near), further.at(far)];
            });
        self.modelled.lay(&modelled);
    }

    fn number_cells(&mut self, found: &[&Found], modelled: &[Off]) {
        let of_images =
            (found.par_iter())
                .with_min_len(AT_ONCE)
                .flat_map_iter(|Found { image, .. }| {
                    let [a, b, c] = image.cells;
                    [image.own, a, b, c]
                });
        let off = |which: usize| {
            let modelled = modelled.par_iter().with_min_len(AT_ONCE);
            modelled.map(move |off| off.cells[which])
        };
        self.cells.clear();
        let [numbers, further] = &mut self.numbers;
        numbers.number(of_images, &mut self.cells);
        self.ends = [self.cells.len(); 2];
        if !modelled.is_empty() {
            numbers.number(off(0), &mut self.cells);
            self.ends[1] = self.cells.len();
            further.number(off(1), &mut self.cells);
        }
    }

    /// Cells of which is asked what left them.
    #[must_use]
    pub fn cells(&self, asked: Asked) -> &[[i32; 3]] {
        match asked {
            Asked::Images => &self.cells[..self.ends[0]],
            Asked::Near => &self.cells[..self.ends[1]],
            Asked::Further => &self.cells,
        }
    }

    /// All of them, block by block.
    pub(super) fn all(&self) -> &[Image] {
        &self.images
    }

    /// Which of them belong together.
    pub(super) const fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// By link, those of its sides.
    pub(super) fn of_links(&self) -> &[[OfSide; 2]] {
        &self.of_links
    }

    /// Images where a model of the boundary layer gives the stress, in the order of faces.
    pub(super) fn modelled(&self) -> &[Off] {
        self.modelled.all()
    }

    /// Links and sides that slide.
    pub fn sides(&self) -> impl Iterator<Item = (usize, usize)> {
        self.sides_of(0..self.images.len())
    }

    /// Those of some images.
    pub(super) fn sides_of(&self, images: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let place = |place: &u32| (*place as usize / 2, *place as usize % 2);
        self.sides[images].iter().map(place)
    }

    /// At which sides of every link the air sticks.
    #[must_use]
    pub fn stick(&self) -> &[[bool; 2]] {
        &self.stick
    }

    /// What a model of the boundary layer takes of the air beside a face, by the states of all `cells`. `wall` tells the wall's velocity at a side of a link.
    pub fn seen<R: Real>(
        &self,
        face: Face,
        cells: &[CellState<R>],
        wall: impl Fn(usize, usize) -> DVec3,
    ) -> Option<Seen> {
        self.modelled.seen(face, |off| {
            let wall = wall(off.link as usize, usize::from(off.side));
            (off.cells).map(|cell| cells[cell as usize].velocity() - wall)
        })
    }
}

#[cfg(test)]
#[path = "images_tests.rs"]
mod tests;
