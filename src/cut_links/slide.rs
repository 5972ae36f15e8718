//! A wall along which the air slides: what comes back from a cut where the surface holds the air back across itself alone.
//!
//! A cut link leads from cell A to cell B behind the wall. The mirror image of B in the wall lies in the air. What B would send is taken from the cells about that image: g is the
//! population that leaves them along −d. It comes back with the velocity across the wall and the shear stress upon it turned round,
//!
//! r = g + 6 w α (d·n) (j − ρ V)·n − 18 w (d·n) d·s,
//!
//! n the unit normal away from the air, V the velocity of the wall, α = min(1, 1/2q) by the distance q of the cut, ρ, j and s density, momentum and the part along the
//! wall of the flux of momentum across it, (1 − n nᵀ)(T − j Vᵀ) n, where the image lies. On a wall along the lattice, midway between cells, this is specular
//! reflection but for the few thousandths that come from the further cells of an image.
//!
//! Uniform flow along a plane wall comes back as it left, to round-off, however the plane is turned. So it would from a copy of A's own state, but that grows without bound where
//! the lattice makes stairs of the wall. *What it costs*: the mass of single cells. Along a plane a link loses 6 w d·(j − ρ V) of what slides, which other links of the same wall gain; what is lost
//! beyond that goes back to the cell's population at rest, and the sum of the first, where a wall is not plane, to the whole wall (`src/simulation/sliding.rs`): the air keeps its mass.
//!
//! In gaps less than three cells wide the air sticks: there is no room for an image, and enclosed air from which nothing takes energy breaks down.
//!
//! The shear stress that a model of the boundary layer puts on the wall is not taken from the link: [`super::stress`].

use glam::DVec3;
use rayon::prelude::*;

use super::boundary_layer::{Face, Sample};
use super::search::{CutLink, CutLinks, Domain};
use crate::lattice::nest::CHANGED_BY_LAYERS;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, WEIGHTS, opposite};

/// What leaves a cell, by direction; shifted populations.
pub type Leaving = [f64; DIRECTION_COUNT];

/// Cells that an image is taken from.
pub(super) const CELLS_OF_AN_IMAGE: usize = 3;

/// Length below which an image counts as lying on a cell's centre, to the fourth power [cells⁴].
const ON_A_CENTRE: f64 = 1e-3;

/// Cells from the one beside a wall to those whose velocities a model of the boundary layer takes: the first is two to three and a half cells off, so that the stress does not follow from
/// what it does to the first cell; the second tells the speed outside a layer that is thicker.
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
    /// Unit normal away from the air.
    pub(super) away: DVec3,
    pub(super) cells: [(f64, u32); CELLS_OF_AN_IMAGE],
    /// Where a model gives the stress.
    pub(super) off: Option<Off>,
}

/// What an image knows for a model of the boundary layer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Off {
    pub(super) face: u32,
    /// The cells off the wall from which velocities are taken, and their distances from the wall [cells].
    pub(super) cells: [u32; 2],
    heights: [f64; 2],
}

/// How the air slides along a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Slides {
    /// Its unit normal.
    pub normal: DVec3,
    /// True where a model of the boundary layer gives the stress.
    pub modelled: bool,
}

/// What comes back to a side of a link that slides.
#[derive(Debug, Clone, Copy)]
pub struct Back {
    /// Number of the link.
    pub link: u32,
    /// Side of it.
    pub side: u8,
    /// What comes back, less what the wall's velocity adds.
    pub further: f64,
    /// α.
    pub strength: f64,
    /// Mass that leaves along the link, and does not come back, where the air slides along a plane: 6 w d·(j − ρ V − n n·(j − ρ V)).
    pub along: f64,
}

/// Images of all cut links at which the air slides.
#[derive(Debug, Clone, Default)]
pub struct Images {
    images: Vec<Image>,
    /// Cells that they are taken from and the nearer ones off the wall, in the order of memory; behind them the further ones.
    cells: Vec<[i32; 3]>,
    /// How many stand before the further ones.
    nearer: usize,
    /// Of the nearer cells, as it leaves them.
    air: Vec<Air>,
    /// By image, what the cells off the wall move with beyond it.
    velocities: Vec<[DVec3; 2]>,
}

/// An image as it is found, and its cells: those that it is taken from, and those off the wall with their distances.
type Found = (
    Image,
    [[i32; 3]; CELLS_OF_AN_IMAGE],
    Option<[([i32; 3], f64); 2]>,
);

/// Cells in the order of memory, each once.
fn in_order(cells: &mut Vec<[i32; 3]>) {
    cells.par_sort_unstable_by_key(in_memory);
    cells.dedup();
}

fn in_memory(&[x, y, z]: &[i32; 3]) -> [i32; 3] {
    [z, y, x]
}

fn place_among(cells: &[[i32; 3]], cell: [i32; 3]) -> u32 {
    cells.partition_point(|other| in_memory(other) < in_memory(&cell)) as u32
}

impl Images {
    /// Lays them out for `links`; `slides` tells how the air slides along a triangle, if it does.
    pub fn find(
        &mut self,
        links: &CutLinks,
        domain: &Domain,
        slides: impl Fn(usize) -> Option<Slides> + Sync,
    ) {
        let air = Surroundings { links, domain };
        let look = |(task, some): (usize, &[CutLink])| -> Vec<Found> {
            let sides = (some.iter().enumerate())
                .flat_map(|(number, link)| super::SIDES.map(|side| (number, link, side)));
            let found = sides.filter_map(|(number, link, side)| {
                let slides = slides(link.cuts[side].triangle as usize)?;
                let away = away(link, side, slides.normal);
                let off = air.off(link, side, (away, slides.modelled))?;
                let cells = air.cells_of_image(link, side, away);
                let sum: f64 = cells.iter().map(|(share, _)| share).sum();
                let image = Image {
                    link: (task * LINKS_AT_ONCE + number) as u32,
                    side: side as u8,
                    away,
                    cells: cells.map(|(share, _)| (share / sum, 0)),
                    off: slides.modelled.then(|| Off {
                        face: face(link, side, slides.normal) as u32,
                        cells: [0; 2],
                        heights: off.map(|(_, height)| height),
                    }),
                };
                Some((
                    image,
                    cells.map(|(_, cell)| cell),
                    slides.modelled.then_some(off),
                ))
            });
            found.collect()
        };
        let found: Vec<Vec<Found>> = (links.links().par_chunks(LINKS_AT_ONCE).enumerate())
            .map(look)
            .collect();
        self.cells.clear();
        let mut further = Vec::new();
        for (_, cells, off) in found.iter().flatten() {
            self.cells.extend(cells);
            if let Some([(near, _), (far, _)]) = off {
                self.cells.push(*near);
                further.push(*far);
            }
        }
        in_order(&mut self.cells);
        in_order(&mut further);
        self.nearer = self.cells.len();
        let nearer = &self.cells;
        let placed = |(mut image, asked, off): Found| {
            for ((_, to), cell) in image.cells.iter_mut().zip(asked) {
                *to = place_among(nearer, cell);
            }
            if let (Some(own), Some([(near, _), (far, _)])) = (&mut image.off, off) {
                let far = nearer.len() as u32 + place_among(&further, far);
                own.cells = [place_among(nearer, near), far];
            }
            image
        };
        let placed: Vec<Vec<Image>> = (found.into_par_iter())
            .map(|some| some.into_iter().map(placed).collect())
            .collect();
        self.images.clear();
        self.images.extend(placed.into_iter().flatten());
        self.cells.extend(further);
    }

    /// Cells of which is asked what left them; the `further` ones where the layers march.
    #[must_use]
    pub fn cells(&self, further: bool) -> &[[i32; 3]] {
        if further {
            &self.cells
        } else {
            &self.cells[..self.nearer]
        }
    }

    /// In the order of links.
    pub(super) fn all(&self) -> &[Image] {
        &self.images
    }

    /// Links and sides that slide, in the order of links.
    pub fn sides(&self) -> impl Iterator<Item = (usize, usize)> {
        (self.images.iter()).map(|image| (image.link as usize, usize::from(image.side)))
    }

    /// What models of the boundary layer take, from what `leaving` the cells, further ones among them; `wall` tells the wall's velocity at a side.
    pub fn samples(
        &mut self,
        links: &[CutLink],
        leaving: &[Leaving],
        wall: impl Fn(&CutLink, usize) -> DVec3 + Sync,
    ) -> impl Iterator<Item = Sample> {
        let seen = |image: &Image| {
            image.off.map_or([DVec3::ZERO; 2], |off| {
                let wall = wall(&links[image.link as usize], usize::from(image.side));
                off.cells
                    .map(|cell| velocity(&leaving[cell as usize]) - wall)
            })
        };
        (self.images.par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(seen)
            .collect_into_vec(&mut self.velocities);
        let seen = self.images.iter().zip(&self.velocities);
        seen.filter_map(|(image, velocities)| {
            let off = image.off?;
            Some(Sample {
                face: off.face as Face,
                velocities: *velocities,
                heights: off.heights,
            })
        })
    }

    /// What comes back to every side that slides, from what `leaving` the cells; `wall` tells the wall's velocity at a side.
    pub fn returned(
        &mut self,
        links: &[CutLink],
        leaving: &[Leaving],
        wall: impl Fn(&CutLink, usize) -> DVec3 + Sync,
        back: &mut Vec<Back>,
    ) {
        (leaving[..self.nearer].par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(Air::new)
            .collect_into_vec(&mut self.air);
        let air = &self.air;
        (self.images.par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(|image| {
                let side = usize::from(image.side);
                let link = &links[image.link as usize];
                let from = opposite(link.leaving(side));
                let (mut at, mut came) = (Air::default(), 0.0);
                for (share, cell) in image.cells {
                    let cell = cell as usize;
                    at.add(share, &air[cell]);
                    came += share * leaving[cell][from];
                }
                let wall = (image.away, wall(link, side));
                let [further, strength, along] = reflected(link, side, came, &at, wall);
                Back {
                    link: image.link,
                    side: image.side,
                    further,
                    strength,
                    along,
                }
            })
            .collect_into_vec(back);
    }
}

/// Velocity of a cell.
fn velocity(leaving: &Leaving) -> DVec3 {
    let (mut density, mut momentum) = (1.0, DVec3::ZERO);
    for (direction, population) in leaving.iter().enumerate() {
        density += population;
        momentum += vector(direction) * *population;
    }
    momentum / density
}

/// Face of a cut's triangle that a side looks at, by the triangle's normal.
#[must_use]
pub fn face(link: &CutLink, side: usize, normal: DVec3) -> Face {
    let towards = normal.dot(link.direction()) > 0.0;
    2 * link.cuts[side].triangle as usize + usize::from(towards == (side == 0))
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

    /// Cells off a wall and their distances from it, straight ahead as far as a direction of the lattice leads, fewer cells off where the way ends; `None` where another wall leaves no room to slide. What is not `modelled` asks for that alone.
    fn off(
        &self,
        link: &CutLink,
        side: usize,
        (away, modelled): (DVec3, bool),
    ) -> Option<[([i32; 3], f64); 2]> {
        let off = |direction: usize| -vector(direction).dot(away);
        let straight = |direction: usize| off(direction) / vector(direction).length();
        let ahead = (1..DIRECTION_COUNT)
            .max_by(|a, b| straight(*a).total_cmp(&straight(*b)))
            .unwrap_or(1);
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

    /// The cells nearest to the mirror image of the cell behind a cut, among the side's own and its neighbours in the air.
    fn cells_of_image(
        &self,
        link: &CutLink,
        side: usize,
        away: DVec3,
    ) -> [(f64, [i32; 3]); CELLS_OF_AN_IMAGE] {
        let own = link.cells[side];
        let d = vector(link.leaving(side));
        let image = d - away * (2.0 * (1.0 - link.distance(side)) * d.dot(away));
        let mut nearest = [(0.0, own); CELLS_OF_AN_IMAGE];
        for direction in 0..DIRECTION_COUNT {
            let distance = (vector(direction) - image).length_squared();
            let mut new = (1.0 / (distance * distance + ON_A_CENTRE), own);
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
        nearest
    }
}

/// What comes back, less what the wall's velocity adds; α; and what leaves along a plane.
fn reflected(
    link: &CutLink,
    side: usize,
    back: f64,
    air: &Air,
    (away, velocity): (DVec3, DVec3),
) -> [f64; 3] {
    let direction = link.leaving(side);
    let (weight, d) = (WEIGHTS[direction], vector(direction));
    let across = d.dot(away);
    let strength = (0.5 / link.distance(side)).min(1.0);
    let relative = air.momentum - velocity * air.density;
    let passing = away.dot(relative);
    let flux = air.flux(away) - air.momentum * away.dot(velocity);
    let shear = flux - away * away.dot(flux);
    // As far as the wall's velocity changes in this step, it is that of a wall to which the air sticks: convex in the fabric's step.
    let added = 6.0 * weight * strength * d.dot(velocity);
    [
        back + 6.0 * weight * strength * across * passing - 18.0 * weight * across * d.dot(shear)
            + added,
        strength,
        6.0 * weight * d.dot(relative - away * passing),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between two plates less than three cells apart the air sticks, farther apart it slides; outside it slides anyhow.
    #[test]
    fn air_sticks_in_narrow_gaps() {
        let domain = Domain {
            cells: [20; 3],
            repeats: [false; 3],
            kept: 0,
            open: false,
        };
        for (cells_between, slides) in [(1, false), (2, false), (3, true), (4, true)] {
            let plate = |height: f64| {
                [[5.2, 5.3], [14.6, 5.3], [14.6, 14.7], [5.2, 14.7]]
                    .map(|[x, y]| DVec3::new(x, y, height))
            };
            let upper = 8.4 + f64::from(cells_between);
            let positions = [plate(8.4), plate(upper)].concat();
            let triangles = [[0, 1, 2], [2, 3, 0], [4, 5, 6], [6, 7, 4]];
            let mut links = CutLinks::default();
            links.find(&positions, &triangles, &domain).unwrap();
            for modelled in [false, true] {
                let mut images = Images::default();
                images.find(&links, &domain, |_| {
                    Some(Slides {
                        normal: DVec3::Z,
                        modelled,
                    })
                });
                // Off the rims, beside which the way across is free.
                let between = |(link, side): &(usize, usize)| {
                    let [x, y, z] = links.links()[*link].cells[*side];
                    (8.4..upper).contains(&f64::from(z))
                        && [x, y].iter().all(|n| (7..13).contains(n))
                };
                let inside = images.sides().filter(between).count();
                assert_eq!(inside > 0, slides, "{cells_between} cells");
                let outside = images.sides().count() - inside;
                assert!(outside > 500, "{cells_between} cells: {outside}");
            }
        }
    }
}
