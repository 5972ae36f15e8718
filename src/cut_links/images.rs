//! Images of all cut links at which the air slides ([`super::slide`]), and the cells that they are taken from.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::{Blocks, Key};
use super::boundary_layer::{Face, Seen};
use super::cell_numbers::CellNumbers;
use super::modelled::{Modelled, Off};
use super::search::{CutLink, CutLinks, Domain};
use super::slide::{self, Air, CELLS_OF_AN_IMAGE, Image, Leaving, Slides, away};
use super::surroundings::{Around, CellsOff, Surroundings};

/// Links, cells and images that one task works on.
const AT_ONCE: usize = 512;

/// Images of all cut links at which the air slides.
#[derive(Debug, Clone, Default)]
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
    /// Of the cells, as it leaves them.
    air: Vec<Air>,
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

/// An image as it is found.
struct Found {
    image: Image,
    /// The side's own cell, and those that it is taken from.
    own: [i32; 3],
    cells: [[i32; 3]; CELLS_OF_AN_IMAGE],
    key: Key,
    /// The face for a model of the boundary layer, and the cells off the wall.
    off: Option<(Face, CellsOff)>,
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
        let air = Surroundings { links, domain };
        let look = |(task, some): (usize, &[CutLink])| -> Vec<Found> {
            let sides = (some.iter().enumerate())
                .flat_map(|(number, link)| super::SIDES.map(|side| (number, link, side)));
            let found = sides.filter_map(|(number, link, side)| {
                let slides = slides(link, side)?;
                let away = away(link, side, slides.normal);
                let own = Around::new(&air, link.cells[side]);
                let off = air.off((link, side), &own, (away, slides.modelled))?;
                let (cells, closer) = air.cells_of_image((link, side), &own, away);
                let number = (task * AT_ONCE + number) as u32;
                Some(Found {
                    image: Image::new(
                        (number, link, side),
                        away,
                        cells.map(|(share, _)| share),
                        closer,
                    ),
                    own: own.cell,
                    cells: cells.map(|(_, cell)| cell),
                    key: Key::new(slides.space, own.cell, own.cut.count()),
                    off: (slides.modelled).then(|| (slide::face(link, side, slides.normal), off)),
                })
            });
            found.collect()
        };
        let found: Vec<Vec<Found>> = (links.links().par_chunks(AT_ONCE).enumerate())
            .map(look)
            .collect();
        let found: Vec<&Found> = found.iter().flatten().collect();
        self.number_cells(&found);
        let keys = found.iter().map(|found| (found.key, found.image.weight()));
        self.blocks.lay(keys, &mut self.order);
        let number = |numbers: &CellNumbers, cell| numbers.get(cell).unwrap_or_default();
        let [numbers, further] = &self.numbers;
        (self.order.par_iter())
            .with_min_len(AT_ONCE)
            .map(|of| {
                let found = found[*of as usize];
                let mut image = found.image;
                image.own = number(numbers, found.own);
                image.cells = found.cells.map(|cell| number(numbers, cell));
                image
            })
            .collect_into_vec(&mut self.images);
        let modelled: Vec<Off> = (self.order.par_iter().enumerate())
            .with_min_len(AT_ONCE)
            .filter_map(|(image, of)| {
                let found = found[*of as usize];
                let (face, [(close, height), (far, far_height)]) = found.off?;
                Some(Off {
                    face: face as u32,
                    image: image as u32,
                    link: found.image.link,
                    side: found.image.side,
                    cells: [number(numbers, close), number(further, far)],
                    heights: [height, far_height],
                })
            })
            .collect();
        self.modelled.lay(&modelled);
        let place = |(link, side): (usize, usize)| (2 * link + side) as u32;
        self.sides.clear();
        (self.sides).extend(self.images.iter().map(|image| place(image.place())));
        self.of_links.clear();
        (self.of_links).resize(links.links().len(), [OfSide::NONE; 2]);
        self.stick.clear();
        self.stick.resize(links.links().len(), [true; 2]);
        for block in 0..self.blocks.count() {
            for number in self.blocks.sides(block) {
                let (link, side) = self.images[number].place();
                self.of_links[link][side] = OfSide {
                    image: number as u32,
                    block: block as u32,
                };
                self.stick[link][side] = false;
            }
        }
    }

    fn number_cells(&mut self, found: &[&Found]) {
        let of_images = || {
            let cells = found.iter().flat_map(|found| found.cells);
            cells.chain(found.iter().map(|found| found.own))
        };
        let off = |which: usize| {
            let off = found.iter().filter_map(|found| found.off);
            off.map(move |(_, cells)| cells[which].0)
        };
        self.cells.clear();
        let [numbers, further] = &mut self.numbers;
        numbers.lay(of_images().chain(off(0)));
        numbers.number(of_images(), &mut self.cells);
        self.ends[0] = self.cells.len();
        numbers.number(off(0), &mut self.cells);
        self.ends[1] = self.cells.len();
        further.lay(off(1));
        further.number(off(1), &mut self.cells);
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

    /// Takes what is `leaving` the cells.
    pub fn take(&mut self, leaving: &[Leaving]) {
        (leaving.par_iter())
            .with_min_len(AT_ONCE)
            .map(Air::new)
            .collect_into_vec(&mut self.air);
    }

    /// The air of the cells, as it was taken.
    pub(super) fn air(&self) -> &[Air] {
        &self.air
    }

    /// What a model of the boundary layer takes of the air beside a face, from what was taken of all cells. `wall` tells the wall's velocity at a side of a link.
    pub fn seen(&self, face: Face, wall: impl Fn(usize, usize) -> DVec3) -> Option<Seen> {
        self.modelled.seen(face, |off| {
            let wall = wall(off.link as usize, usize::from(off.side));
            off.cells.map(|cell| {
                let air = &self.air[cell as usize];
                air.momentum / air.density - wall
            })
        })
    }
}

#[cfg(test)]
#[path = "images_tests.rs"]
mod tests;
