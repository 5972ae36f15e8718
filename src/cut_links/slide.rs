//! A wall along which the air slides: what comes back from a cut where the surface holds the air back across itself alone.
//!
//! A cut link leads from cell A to cell B behind the wall. The mirror image of B in the wall lies in the air. What B would send is taken from the cells about that image: g is the
//! population that leaves them along −d. It comes back with the velocity across the wall and the shear stress upon it turned round,
//!
//! r = g + 6 w β (d·n) (j − ρ V)·n − 18 w (d·n) d·s.
//!
//! Here n is the unit normal away from the air, and V the velocity of the wall. Of the cells about the image, ρ and j are density and
//! momentum. Of them, too, s is the part along the wall of the flux of momentum across it, (1 − n nᵀ)(T − j Vᵀ) n. With α = min(1, 1/2q) by the distance q of the cut, β is α η + ½ (1 − η). The velocity across
//! a wall grows with the height over it, and the cells lie higher than their image. Its height over theirs is η, 1 at most, and ½ (1 − η) takes from g what they have too much.
//! *Measured, not derived*: where the flow along turned walls speeds up, a fifth to a third of the air comes out of them that would with η = 1. On walls along the lattice, where α holds the height already,
//! more comes than before. There β = ½ (1 + η) is right, but no better than η = 1 on turned walls. The cells of an image lie askew along the wall, too. On a wall along the lattice, midway between cells, this is specular
//! reflection but for the few thousandths that come from the further cells of an image.
//!
//! Uniform flow along a plane wall comes back as it left, to round-off, however the plane is turned. So it would from a copy of A's own state, but that grows without bound where
//! the lattice makes stairs of the wall. *What it costs*: the mass of single cells. Along a plane a link loses 6 w d·(j − ρ V) of what slides, which other links of the same wall gain. The
//! sum of that, where a wall is not plane, goes to the whole wall. What is lost beyond it goes to the links nearby (`src/simulation/sliding.rs`). So the air keeps its mass. What is given back arrives
//! with the velocity of the air along the wall. At rest it would hold the air back, and what is taken away would drive it: a section has thrust.
//!
//! *Energy*: what comes from an image is a copy. Where the air has more energy there than at the wall, that would come from nowhere: round a nose, it drives a section on. Where it has less, the
//! wall would brake. A block of links gives the air what it would along a plane, by the share of what slides that comes back; the rest is bounce-back ([`super::energy`]).
//!
//! In gaps less than three cells wide, and in creases, which are cells with walls on both sides, the air sticks. There is no room for an image. Enclosed air from which nothing takes energy
//! breaks down, and so do cells of tight folds.
//!
//! The shear stress that a model of the boundary layer puts on the wall is not taken from the link: [`super::stress`].

use glam::DVec3;
use rayon::prelude::*;

use super::bounce::Return;
use super::boundary_layer::{Face, Seen};
use super::cell_numbers::CellNumbers;
use super::energy::Energy;
use super::modelled::{Modelled, Off};
use super::search::{CutLink, CutLinks, Domain};
use crate::lattice::nest::CHANGED_BY_LAYERS;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, WEIGHTS, opposite};

/// What leaves a cell, by direction; shifted populations.
pub type Leaving = [f64; DIRECTION_COUNT];

/// Cells that an image is taken from.
pub(super) const CELLS_OF_AN_IMAGE: usize = 3;

/// Length below which an image counts as lying on a cell's centre, to the fourth power [cells⁴].
const ON_A_CENTRE: f64 = 1e-3;

/// Cells from the one beside a wall to those whose velocities a model of the boundary layer takes. The first is two to three and a half cells off, so that the stress does not follow from
/// what it does to the first cell. The second tells the speed outside a layer that is thicker.
const CELLS_OFF: [usize; 2] = [CHANGED_BY_LAYERS - 1, 5];

/// Free cells beyond the first that a wall needs before it for the air to slide.
const ROOM: usize = 2;

/// Links, cells and images that one task works on.
const LINKS_AT_ONCE: usize = 512;

/// State of the air where an image lies, as it leaves.
#[derive(Debug, Clone, Copy, Default)]
struct Air {
    density: f64,
    momentum: DVec3,
    /// Flux of momentum beyond the pressure: xx, yy, zz and yz, xz, xy.
    flux: [DVec3; 2],
}

fn vector(direction: usize) -> DVec3 {
    DVec3::from_array(DIRECTIONS[direction].map(f64::from))
}

impl Air {
    fn new(leaving: &Leaving) -> Self {
        let (mut excess, mut momentum, mut flux) = (leaving[0], [0.0; 3], [[0.0; 3]; 2]);
        for pair in 0..DIRECTION_COUNT / 2 {
            let (there, back) = (leaving[2 * pair + 1], leaving[2 * pair + 2]);
            let (both, beyond) = (there + back, there - back);
            let c = DIRECTIONS[2 * pair + 1];
            excess += both;
            for a in 0..3 {
                match c[a] {
                    0 => {}
                    sign => {
                        momentum[a] += f64::from(sign) * beyond;
                        flux[0][a] += both;
                    }
                }
                match c[(a + 1) % 3] * c[(a + 2) % 3] {
                    0 => {}
                    sign => flux[1][a] += f64::from(sign) * both,
                }
            }
        }
        Self {
            density: 1.0 + excess,
            momentum: DVec3::from_array(momentum),
            flux: [
                DVec3::from_array(flux[0]) - DVec3::splat(excess / 3.0),
                DVec3::from_array(flux[1]),
            ],
        }
    }

    fn add(&mut self, share: f64, other: &Self) {
        self.density += share * other.density;
        self.momentum += other.momentum * share;
        self.flux[0] += other.flux[0] * share;
        self.flux[1] += other.flux[1] * share;
    }

    /// Flux of momentum across a plane.
    fn flux(&self, normal: DVec3) -> DVec3 {
        let [diagonal, off] = self.flux;
        diagonal * normal
            + DVec3::new(
                off.z * normal.y + off.y * normal.z,
                off.z * normal.x + off.x * normal.z,
                off.y * normal.x + off.x * normal.y,
            )
    }
}

/// Mirror image of the cell behind a cut: shares of cells in the air.
#[derive(Debug, Clone, Copy)]
pub(super) struct Image {
    pub(super) link: u32,
    pub(super) side: u8,
    /// Direction d in which air leaves the side.
    direction: u8,
    /// Unit normal n away from the air.
    pub(super) away: DVec3,
    /// d − n (d·n).
    along: DVec3,
    /// α.
    strength: f64,
    /// β.
    turned_round: f64,
    pub(super) cells: [(f64, u32); CELLS_OF_AN_IMAGE],
}

/// How the air slides along a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Slides {
    /// Its unit normal.
    pub normal: DVec3,
    /// True where a model of the boundary layer gives the stress.
    pub modelled: bool,
}

/// What a side where the air slides loses.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loss {
    /// Mass that leaves, and does not come back, along a plane: 6 w d·(j − ρ V − n n·(j − ρ V)).
    pub along: f64,
    /// All that does not come back, for a wall that goes on as it moves.
    pub all: f64,
    /// Velocity along d of the air at the wall.
    pub velocity: f64,
    /// What the wall gives the air, if all slides.
    pub energy: Energy,
}

impl Loss {
    /// Where a share of what slides comes back, and of the rest what left.
    pub fn blend(&mut self, share: f64) {
        self.along *= share;
        self.all *= share;
    }
}

/// Images of all cut links at which the air slides.
#[derive(Debug, Clone, Default)]
pub struct Images {
    images: Vec<Image>,
    modelled: Modelled,
    /// By link, the images of its sides; [`NO_IMAGE`] where the air sticks.
    of_link: Vec<[u32; 2]>,
    /// Cells that they are taken from; behind them the others near the wall that models of the boundary layer ask for, and last those further off. Each part is in the order of memory.
    cells: Vec<[i32; 3]>,
    /// Where the first and the second part end.
    ends: [usize; 2],
    /// Numbers of the first two parts, and of the third.
    numbers: [CellNumbers; 2],
    /// Of the cells, as it leaves them.
    air: Vec<Air>,
}

/// No image, in [`Images::of_link`].
const NO_IMAGE: u32 = u32::MAX;

/// Cells off a wall, a near and a further one, and their distances from it [cells].
type CellsOff = [([i32; 3], f64); 2];

/// An image as it is found.
struct Found {
    image: Image,
    /// Cells that it is taken from.
    cells: [[i32; 3]; CELLS_OF_AN_IMAGE],
    /// The face for a model of the boundary layer, and the cells off the wall.
    off: Option<(Face, CellsOff)>,
}

/// Cells of the images of which is asked what left them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// Those that the images are taken from.
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
                let off = air.off(link, side, (away, slides.modelled))?;
                let (cells, closer) = air.cells_of_image(link, side, away);
                let direction = link.leaving(side);
                let d = vector(direction);
                let strength = (0.5 / link.distance(side)).min(1.0);
                let image = Image {
                    link: (task * LINKS_AT_ONCE + number) as u32,
                    side: side as u8,
                    direction: direction as u8,
                    away,
                    along: d - away * d.dot(away),
                    strength,
                    turned_round: strength * closer + 0.5 * (1.0 - closer),
                    cells: cells.map(|(share, _)| (share, 0)),
                };
                Some(Found {
                    image,
                    cells: cells.map(|(_, cell)| cell),
                    off: (slides.modelled).then(|| (face(link, side, slides.normal), off)),
                })
            });
            found.collect()
        };
        let found: Vec<Vec<Found>> = (links.links().par_chunks(LINKS_AT_ONCE).enumerate())
            .map(look)
            .collect();
        let of_images = || found.iter().flatten().flat_map(|found| found.cells);
        let off = |which: usize| {
            let off = found.iter().flatten().filter_map(|found| found.off);
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
        let number = |numbers: &CellNumbers, cell| numbers.get(cell).unwrap_or_default();
        let [numbers, further] = &self.numbers;
        let placed = |found: &Found| {
            let mut image = found.image;
            for ((_, to), cell) in image.cells.iter_mut().zip(found.cells) {
                *to = number(numbers, cell);
            }
            let off = found
                .off
                .map(|(face, [(close, height), (far, far_height)])| Off {
                    face: face as u32,
                    image: 0,
                    link: image.link,
                    side: image.side,
                    cells: [number(numbers, close), number(further, far)],
                    heights: [height, far_height],
                });
            (image, off)
        };
        let placed: Vec<Vec<(Image, Option<Off>)>> = (found.par_iter())
            .map(|some| some.iter().map(placed).collect())
            .collect();
        self.images.clear();
        let mut modelled = Vec::new();
        self.of_link.clear();
        self.of_link.resize(links.links().len(), [NO_IMAGE; 2]);
        for (image, off) in placed.into_iter().flatten() {
            let number = self.images.len() as u32;
            self.of_link[image.link as usize][usize::from(image.side)] = number;
            self.images.push(image);
            modelled.extend(off.map(|off| Off {
                image: number,
                ..off
            }));
        }
        self.modelled.lay(&modelled);
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

    /// The image of a number.
    pub(super) fn image(&self, number: u32) -> &Image {
        &self.images[number as usize]
    }

    /// Images where a model of the boundary layer gives the stress, in the order of faces.
    pub(super) fn modelled(&self) -> &[Off] {
        self.modelled.all()
    }

    /// Links and sides that slide, in the order of links.
    pub fn sides(&self) -> impl Iterator<Item = (usize, usize)> {
        (self.images.iter()).map(|image| (image.link as usize, usize::from(image.side)))
    }

    /// Takes what is `leaving` the cells.
    pub fn take(&mut self, leaving: &[Leaving]) {
        (leaving.par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(Air::new)
            .collect_into_vec(&mut self.air);
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

    /// Puts what comes back to every side that slides into `returns`, from what was taken and is `leaving` the cells. `wall` tells the wall's velocity at a side of a link. Into `losses` goes
    /// what it loses.
    pub fn returned(
        &self,
        leaving: &[Leaving],
        wall: impl Fn(usize, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
        losses: &mut Vec<[Loss; 2]>,
    ) {
        losses.resize(returns.len(), [Loss::default(); 2]);
        (returns
            .par_iter_mut()
            .zip(losses)
            .zip(&self.of_link)
            .enumerate())
        .with_min_len(LINKS_AT_ONCE)
        .for_each(|(link, ((returns, losses), images))| {
            for side in super::SIDES {
                if images[side] == NO_IMAGE {
                    continue;
                }
                let image = &self.images[images[side] as usize];
                let from = opposite(usize::from(image.direction));
                let (mut at, mut went, mut came) = (Air::default(), 0.0, 0.0);
                for (share, cell) in image.cells {
                    let cell = cell as usize;
                    at.add(share, &self.air[cell]);
                    went += share * leaving[cell][usize::from(image.direction)];
                    came += share * leaving[cell][from];
                }
                (returns[side], losses[side]) =
                    image.reflected(returns[side].out, (went, came), &at, wall(link, side));
            }
        });
    }

    /// Changes what comes back to every side that slides, and what it loses, by its number in the order of [`Self::sides`]. Each is changed by itself: the number of threads does not matter.
    pub fn change(
        &self,
        (returns, losses): (&mut [[Return; 2]], &mut [[Loss; 2]]),
        change: impl Fn(usize, &mut Return, &mut Loss) + Sync,
    ) {
        (returns.par_iter_mut().zip(losses).zip(&self.of_link))
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|((returns, losses), images)| {
                let slides = |side: &usize| images[*side] != NO_IMAGE;
                for side in super::SIDES.into_iter().filter(slides) {
                    change(images[side] as usize, &mut returns[side], &mut losses[side]);
                }
            });
    }
}

impl Image {
    /// What comes back, and what is lost, by what went `out` and what of the image `went` with it and `came` back.
    fn reflected(
        &self,
        out: f64,
        (went, came): (f64, f64),
        air: &Air,
        wall: DVec3,
    ) -> (Return, Loss) {
        let away = self.away;
        let direction = usize::from(self.direction);
        let six_weights = 6.0 * WEIGHTS[direction];
        let d = vector(direction);
        let across = d.dot(away);
        let relative = air.momentum - wall * air.density;
        let passing = away.dot(relative);
        let along = self.along.dot(relative);
        let moves = d.dot(wall);
        // d·s, s being the part along the wall of the flux across it.
        let shear = self.along.dot(air.flux(away)) - self.along.dot(air.momentum) * away.dot(wall);
        // As far as the wall's velocity changes in this step, it is that of a wall to which the air sticks: convex in the fabric's step.
        let added = self.turned_round * across * passing + self.strength * moves;
        let further = came + six_weights * (added - 3.0 * across * shear);
        let returned = Return {
            out,
            share: 0.0,
            further,
            strength: self.strength,
        };
        // For a wall that goes on as it moves, and as the wall sees it.
        let back = further - six_weights * self.strength * moves;
        let frame = 0.5 * six_weights * moves;
        let loss = Loss {
            along: six_weights * along,
            all: out - back - six_weights * moves,
            velocity: along / air.density + moves,
            energy: Energy::new(
                six_weights,
                (out - frame, back + frame),
                (went - frame, came + frame),
            ),
        };
        (returned, loss)
    }
}

/// Face of a cut's triangle that a side looks at, by the triangle's normal.
#[must_use]
pub fn face(link: &CutLink, side: usize, normal: DVec3) -> Face {
    let towards = normal.dot(link.direction()) > 0.0;
    2 * link.cuts[side].triangle as usize + usize::from(towards == (side == 0))
}

/// Direction (not 0) of the lattice nearest to a unit vector; of equally near ones the last.
fn straightest(towards: DVec3) -> usize {
    let (mut best, mut nearest) = (f64::NEG_INFINITY, 1);
    for pair in 0..DIRECTION_COUNT / 2 {
        let direction = 2 * pair + 1;
        let length = match DIRECTIONS[direction].map(i32::abs) {
            [1, 0, 0] | [0, 1, 0] | [0, 0, 1] => 1.0,
            _ => std::f64::consts::SQRT_2,
        };
        let along = vector(direction).dot(towards) / length;
        for (cosine, direction) in [(along, direction), (-along, direction + 1)] {
            if cosine >= best {
                (best, nearest) = (cosine, direction);
            }
        }
    }
    nearest
}

/// Unit normal away from the air of a side.
fn away(link: &CutLink, side: usize, normal: DVec3) -> DVec3 {
    if vector(link.leaving(side)).dot(normal) < 0.0 {
        -normal
    } else {
        normal
    }
}

/// What a cell may meet next.
#[derive(Debug, Clone, Copy)]
pub(super) enum Next {
    /// A cell of the air, or the one that it repeats.
    Cell([i32; 3]),
    /// A wall.
    Wall,
    /// The end of the air.
    End,
}

/// Links that are cut, and the air around them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) links: &'a CutLinks,
    pub(super) domain: &'a Domain,
}

impl Surroundings<'_> {
    /// What lies in a direction (not 0) of a cell.
    pub(super) fn next(&self, cell: [i32; 3], direction: usize) -> Next {
        let c = DIRECTIONS[direction];
        let place = std::array::from_fn(|a| i64::from(cell[a] + c[a]));
        match self.domain.cell(place) {
            None => Next::End,
            Some(next) if self.links.cuts(cell, next, direction) => Next::Wall,
            Some(next) => Next::Cell(next),
        }
    }

    /// Cells off a wall and their distances from it, straight ahead as far as a direction of the lattice leads, fewer cells off where the way ends. It is `None` where other walls leave no room to slide. What is not `modelled` asks for that alone.
    fn off(
        &self,
        link: &CutLink,
        side: usize,
        (away, modelled): (DVec3, bool),
    ) -> Option<CellsOff> {
        // In a crease, or a gap of one cell.
        if self.links.cut_on_both_sides(link.cells[side]) {
            return None;
        }
        let off = |direction: usize| -vector(direction).dot(away);
        let ahead = straightest(-away);
        let mut cell = link.cells[side];
        let mut height = link.distance(side) * -off(link.leaving(side));
        let mut found = [(cell, height); 2];
        let last = if modelled { CELLS_OFF[1] } else { ROOM };
        for done in 1..=last {
            match self.next(cell, ahead) {
                Next::Wall if done <= ROOM => return None,
                Next::Cell(next) => cell = next,
                Next::Wall | Next::End => break,
            }
            height += off(ahead);
            for (found, cells) in found.iter_mut().zip(CELLS_OFF) {
                if done <= cells {
                    *found = (cell, height);
                }
            }
        }
        Some(found)
    }

    /// The cells nearest to the mirror image of the cell behind a cut, among the side's own and its neighbours in the air, with their shares, and η.
    fn cells_of_image(
        &self,
        link: &CutLink,
        side: usize,
        away: DVec3,
    ) -> ([(f64, [i32; 3]); CELLS_OF_AN_IMAGE], f64) {
        let own = link.cells[side];
        let d = vector(link.leaving(side));
        let across = d.dot(away);
        let height = (1.0 - link.distance(side)) * across;
        let image = d - away * (2.0 * height);
        let mut nearest = [(0.0, own, 0); CELLS_OF_AN_IMAGE];
        for direction in 0..DIRECTION_COUNT {
            let distance = (vector(direction) - image).length_squared();
            let mut new = (1.0 / (distance * distance + ON_A_CENTRE), own, direction);
            if new.0 <= nearest[CELLS_OF_AN_IMAGE - 1].0 {
                continue;
            }
            if direction > 0 {
                let Next::Cell(cell) = self.next(own, direction) else {
                    continue;
                };
                new.1 = cell;
            }
            for held in &mut nearest {
                if new.0 > held.0 {
                    std::mem::swap(held, &mut new);
                }
            }
        }
        let sum: f64 = nearest.iter().map(|(share, ..)| share).sum();
        let lower = (nearest.iter())
            .map(|(share, _, direction)| share * vector(*direction).dot(away))
            .sum::<f64>()
            / sum;
        let of_cells = link.distance(side) * across - lower;
        let closer = if of_cells > height {
            height / of_cells
        } else {
            1.0
        };
        (nearest.map(|(share, cell, _)| (share / sum, cell)), closer)
    }
}

#[cfg(test)]
#[path = "slide_tests.rs"]
mod tests;
