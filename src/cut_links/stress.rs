//! Where the shear stress that a model of the boundary layer ([`super::boundary_layer`]) puts on a wall is taken from the air.
//!
//! Not from the link: what comes back follows from further cells. They would fill up again what the first one lost, to a tenth of the stress and less where the wall lies askew. So half of
//! it is taken from the cells of the image, half from a cell two further off, from populations along open links, and the cell keeps its mass. Measured: a plate's friction is that of its law
//! within 15 % on 16 to 128 cells, however it is turned (`ripstop validate wall-friction`).
//!
//! A link stands for the area 9 w (d·n) |d − n (d·n)|². Its sum over the links is that of the wall, since Σ w c c c c is isotropic.

use glam::DVec3;
use rayon::prelude::*;

use super::boundary_layer::BoundaryLayers;
use super::cell_states::CELLS_OF_AN_IMAGE;
use super::images::{Asked, Images};
use super::modelled::Off;
use super::search::{CutLink, CutLinks, Domain};
use super::slide::Image;
use super::surroundings::{Around, Next, Surroundings};
use crate::lattice::{DIRECTIONS, WEIGHTS};

/// Share of a model's stress that is taken two cells off, the rest from the cells of the image. By 0 a plate at Re = 10⁶ gets 65 to 143 % of its friction, by 1 86 to 144 %, by
/// ½ 91 to 116 %. It has 16 to 64 cells and is turned by 0 to 45°. That was while all that a link lost went to the whole wall; now it is 94 to 114 % at 0 to 30°.
const TAKEN_OFF: f64 = 0.5;

/// Cells that one task works on.
const CELLS_AT_ONCE: usize = 512;

/// Cells that lose momentum at an image: its own, and the one off the wall.
const LOSERS: usize = CELLS_OF_AN_IMAGE + 1;

/// The directions along an axis in which links of a cell are open; one at least.
type Open = [Option<u8>; 2];

/// How a cell loses momentum: by what leaves it along the three axes.
type Loses = [Open; 3];

/// A population that the stress changes, as it leaves its cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Changed {
    /// Number of the cell among those of the images.
    pub number: u32,
    /// The cell.
    pub cell: [i32; 3],
    /// Direction in which it leaves; 0 at rest.
    pub direction: u8,
    /// What is added to it.
    pub change: f64,
}

/// Populations that the stress changes: those at rest, and those along the three axes, which no other pair of directions touches.
pub type ChangedByPair = [Vec<Changed>; 4];

/// What the walls take. What is of images is in the order of faces.
#[derive(Debug, Clone, Default)]
pub struct Stress {
    /// How each cell of the images loses momentum.
    loses: Vec<Option<Loses>>,
    /// By image, for which part of the wall each of its cells loses [cells²]; zeros where none of them can.
    areas: Vec<[f64; LOSERS]>,
    /// What each cell loses in a step.
    lost: Vec<DVec3>,
    /// By pair of directions, those at rest first.
    changed: ChangedByPair,
    /// What each of them is times what its cell loses.
    by: [Vec<DVec3>; 4],
    taken: Vec<[DVec3; 2]>,
}

/// Cells that lose at an image.
fn losers(image: &Image, off: &Off) -> [u32; LOSERS] {
    let [near, _] = off.cells;
    let [a, b, c] = image.cells;
    [a, b, c, near]
}

impl Stress {
    /// Lays out for `images` which of their cells can lose, and how.
    pub fn find(&mut self, links: &CutLinks, domain: &Domain, images: &Images) {
        let air = Surroundings { links, domain };
        (images.cells(Asked::Near).par_iter())
            .with_min_len(CELLS_AT_ONCE)
            .map(|cell| loses(&air, *cell))
            .collect_into_vec(&mut self.loses);
        let loses = &self.loses;
        let areas = |off: &Off| {
            let image = &images.all()[off.image as usize];
            let mut shares = [TAKEN_OFF; LOSERS];
            for (to, share) in shares.iter_mut().zip(image.shares) {
                *to = (1.0 - TAKEN_OFF) * share;
            }
            for (share, cell) in shares.iter_mut().zip(losers(image, off)) {
                if loses[cell as usize].is_none() {
                    *share = 0.0;
                }
            }
            let sum: f64 = shares.iter().sum();
            let link = &links.links()[off.link as usize];
            let area = area(link, usize::from(off.side), image.away);
            shares.map(|share| if sum > 0.0 { share / sum * area } else { 0.0 })
        };
        (images.modelled().par_iter())
            .with_min_len(CELLS_AT_ONCE)
            .map(areas)
            .collect_into_vec(&mut self.areas);
        self.lay(images);
    }

    /// Lays out what changes in the cells that lose.
    fn lay(&mut self, images: &Images) {
        let mut lose = vec![false; self.loses.len()];
        for (off, areas) in images.modelled().iter().zip(&self.areas) {
            for (cell, area) in losers(&images.all()[off.image as usize], off)
                .into_iter()
                .zip(areas)
            {
                lose[cell as usize] |= *area > 0.0;
            }
        }
        self.changed.iter_mut().for_each(Vec::clear);
        self.by.iter_mut().for_each(Vec::clear);
        let cells = images.cells(Asked::Near).iter().zip(&self.loses).zip(lose);
        for (number, ((cell, loses), _)) in cells.enumerate().filter(|(_, (_, lose))| *lose) {
            let Some(loses) = loses else { continue };
            let mut change = |direction: u8, by: DVec3| {
                let pair = usize::from(direction.div_ceil(2));
                self.by[pair].push(by);
                self.changed[pair].push(Changed {
                    number: number as u32,
                    cell: *cell,
                    direction,
                    change: 0.0,
                });
            };
            let mut to_rest = DVec3::ZERO;
            for (open, axis) in loses.iter().zip(DVec3::AXES) {
                let each = axis / open.iter().flatten().count() as f64;
                for (direction, by) in open.iter().zip([-each, each]) {
                    if let Some(direction) = direction {
                        change(*direction, by);
                        to_rest -= by;
                    }
                }
            }
            // Beside a wall one link of an axis may be cut; the cell keeps its mass.
            if to_rest != DVec3::ZERO {
                change(0, to_rest);
            }
        }
    }

    /// Takes the stress of `layers` from the cells, every step the same until this is called again; so many `links` are cut.
    pub fn take(&mut self, links: usize, images: &Images, layers: &BoundaryLayers) {
        self.lost.clear();
        self.lost.resize(self.loses.len(), DVec3::ZERO);
        self.taken.clear();
        self.taken.resize(links, [DVec3::ZERO; 2]);
        for (off, areas) in images.modelled().iter().zip(&self.areas) {
            let stress = layers.stress(off.face as usize);
            let cells = losers(&images.all()[off.image as usize], off);
            for (cell, area) in cells.into_iter().zip(areas) {
                self.lost[cell as usize] += stress * *area;
            }
            self.taken[off.link as usize][usize::from(off.side)] =
                stress * areas.iter().sum::<f64>();
        }
        let lost = &self.lost;
        for (changed, by) in self.changed.iter_mut().zip(&self.by) {
            (changed.par_iter_mut().zip(by))
                .with_min_len(CELLS_AT_ONCE)
                .for_each(|(changed, by)| changed.change = by.dot(lost[changed.number as usize]));
        }
    }

    /// Populations that change in a step.
    #[must_use]
    pub const fn changed(&self) -> &ChangedByPair {
        &self.changed
    }

    /// What every side of every link takes of the air's momentum so.
    #[must_use]
    pub fn taken(&self) -> &[[DVec3; 2]] {
        &self.taken
    }
}

/// Area of the wall that a link stands for [cells²].
fn area(link: &CutLink, side: usize, away: DVec3) -> f64 {
    let direction = link.leaving(side);
    let d = DVec3::from_array(DIRECTIONS[direction].map(f64::from));
    let across = d.dot(away);
    9.0 * WEIGHTS[direction] * across * (d - away * across).length_squared()
}

/// How a cell loses momentum; `None` where both links along an axis are cut.
fn loses(air: &Surroundings<'_>, cell: [i32; 3]) -> Option<Loses> {
    let around = Around::new(air, cell);
    let along = |a: usize| {
        let open =
            [1 + 2 * a, 2 + 2 * a].map(|direction| match around.next(air.domain, direction) {
                Next::Cell(_) => Some(direction as u8),
                Next::Wall | Next::End => None,
            });
        (open != [None; 2]).then_some(open)
    };
    Some([along(0)?, along(1)?, along(2)?])
}
