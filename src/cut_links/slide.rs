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
//! the lattice makes stairs of the wall. *What it costs*: the mass of single cells. What is left over is given back to the whole wall
//! (`src/simulation/sliding.rs`), so that the air keeps its mass.
//!
//! # Shear stress of a model
//!
//! The stress τ that a model of the boundary layer puts on the wall ([`super::boundary_layer`]) is not taken from the link: what comes back follows from further cells, which would fill up
//! again what the first one lost, to a tenth of τ and less where the wall lies askew. So half of it is taken from the cells of the image, half from a cell two further off, from
//! populations along open links, and the cell keeps its mass. Measured: a plate's friction is that of its law within a seventh on 16 to 64 cells, however it is turned (`ripstop validate wall-friction`).
//! A link stands for the area 9 w (d·n) |d − n (d·n)|², whose sum over the links is that of the wall, since Σ w c c c c is isotropic.

use glam::DVec3;
use rayon::prelude::*;

use super::boundary_layer::{BoundaryLayers, Face, Sample};
use super::search::{CutLink, CutLinks, Domain};
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, WEIGHTS, opposite};

/// What leaves a cell, by direction; shifted populations.
pub type Leaving = [f64; DIRECTION_COUNT];

/// Cells that an image is taken from.
const CELLS_OF_AN_IMAGE: usize = 3;

/// Length below which an image counts as lying on a cell's centre, to the fourth power [cells⁴].
const ON_A_CENTRE: f64 = 1e-3;

/// Cells from the one beside a wall to the one whose velocity a model of the boundary layer takes: that is two to three and a half cells off, so that the stress does not follow from
/// what it does to the first cell.
const CELLS_OFF: usize = 2;

/// Cells beyond that of a link which a model of the boundary layer changes: what leaves that cell arrives one further.
pub const REACH: usize = CELLS_OFF + 1;

/// Share of a model's stress that is taken there, the rest from the cells of the image: by 0 a plate at Re = 10⁶ gets 65 to 143 % of its friction, by 1 86 to 144 %, by
/// ½ 91 to 116 % (16 to 64 cells, turned by 0 to 45°).
const TAKEN_OFF: f64 = 0.5;

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
struct Image {
    link: u32,
    side: u8,
    cells: [(f64, u32); CELLS_OF_AN_IMAGE],
    /// Where a model gives the stress.
    modelled: Option<Modelled>,
}

/// What an image knows for a model of the boundary layer.
#[derive(Debug, Clone, Copy)]
struct Modelled {
    /// The cell off the wall from which the velocity is taken, and its distance from the wall [cells].
    off: u32,
    height: f64,
    /// Shares of the stress that the cells of the image and that one lose; 1 in all, or 0 where none of them can.
    shares: [f64; CELLS_OF_AN_IMAGE + 1],
}

/// The directions along an axis in which links of a cell are open; one at least.
type Open = [Option<u8>; 2];

/// How a cell loses momentum: by what leaves it along the three axes.
type Loses = [Open; 3];

/// A population that a model of the boundary layer changes, as it leaves its cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Changed {
    /// The cell.
    pub cell: [i32; 3],
    /// Direction in which it leaves; 0 at rest.
    pub direction: usize,
    /// The shifted population.
    pub population: f64,
    /// What is added to it.
    pub change: f64,
}

/// The wall at a cut that slides.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wall {
    /// Unit normal of its triangle.
    pub normal: DVec3,
    /// Velocity [cells per step].
    pub velocity: DVec3,
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
    pub link: usize,
    /// Side of it.
    pub side: usize,
    /// What comes back to a wall as fast as it was.
    pub population: f64,
    /// α.
    pub strength: f64,
}

/// Images of all cut links at which the air slides.
#[derive(Debug, Clone, Default)]
pub struct Images {
    images: Vec<Image>,
    /// Cells that they are taken from, in order.
    cells: Vec<[i32; 3]>,
    /// How each of them loses momentum; empty where no layer is modelled.
    loses: Vec<Option<Loses>>,
    /// What each of them loses in this step.
    lost: Vec<DVec3>,
}

/// An image as it is found, and its cells: those that it is taken from, and the one off the wall.
type Found = (
    Image,
    [[i32; 3]; CELLS_OF_AN_IMAGE],
    Option<([i32; 3], f64)>,
);

impl Images {
    /// Lays them out for `links`; `slides` tells how the air slides along a triangle, if it does.
    pub fn find(
        &mut self,
        links: &CutLinks,
        domain: &Domain,
        slides: impl Fn(usize) -> Option<Slides> + Sync,
    ) {
        let look = |(task, some): (usize, &[CutLink])| -> Vec<Found> {
            let mut found = Vec::new();
            for (number, link) in some.iter().enumerate() {
                for side in super::SIDES {
                    let Some(slides) = slides(link.cuts[side].triangle as usize) else {
                        continue;
                    };
                    let cells = cells_of_image(links, domain, link, side, slides.normal);
                    let sum: f64 = cells.iter().map(|(share, _)| share).sum();
                    let image = Image {
                        link: (task * LINKS_AT_ONCE + number) as u32,
                        side: side as u8,
                        cells: cells.map(|(share, _)| (share / sum, 0)),
                        modelled: None,
                    };
                    let off = (slides.modelled)
                        .then(|| cell_off(links, domain, link, side, slides.normal));
                    found.push((image, cells.map(|(_, cell)| cell), off));
                }
            }
            found
        };
        let found: Vec<Vec<Found>> = (links.links().par_chunks(LINKS_AT_ONCE).enumerate())
            .map(look)
            .collect();
        self.cells.clear();
        for (_, cells, off) in found.iter().flatten() {
            self.cells.extend(cells);
            self.cells.extend(off.map(|(cell, _)| cell));
        }
        self.cells.par_sort_unstable();
        self.cells.dedup();
        let modelled = found.iter().flatten().any(|(_, _, off)| off.is_some());
        self.loses.clear();
        if modelled {
            (self.cells.par_iter())
                .with_min_len(LINKS_AT_ONCE)
                .map(|cell| loses(links, domain, *cell))
                .collect_into_vec(&mut self.loses);
        }
        let (cells, loses) = (&self.cells, &self.loses);
        let place = |cell: [i32; 3]| cells.partition_point(|other| *other < cell) as u32;
        let placed = |(mut image, asked, off): Found| {
            for ((_, to), cell) in image.cells.iter_mut().zip(asked) {
                *to = place(cell);
            }
            image.modelled = off.map(|(cell, height)| Modelled {
                off: place(cell),
                height,
                shares: shares_of_loss(&image, place(cell), loses),
            });
            image
        };
        let placed: Vec<Vec<Image>> = (found.into_par_iter())
            .map(|some| some.into_iter().map(placed).collect())
            .collect();
        self.images.clear();
        self.images.extend(placed.into_iter().flatten());
    }

    /// Cells of which is asked what left them.
    #[must_use]
    pub fn cells(&self) -> &[[i32; 3]] {
        &self.cells
    }

    /// What models of the boundary layer take, from what `leaving` the cells; `wall` tells of the wall at a side.
    pub fn samples(
        &self,
        links: &[CutLink],
        leaving: &[Leaving],
        wall: impl Fn(&CutLink, usize) -> Wall,
    ) -> impl Iterator<Item = Sample> {
        self.images.iter().filter_map(move |image| {
            let (link, side) = (&links[image.link as usize], usize::from(image.side));
            let modelled = image.modelled?;
            let air = Air::new(&leaving[modelled.off as usize]);
            let wall = wall(link, side);
            Some(Sample {
                face: face(link, side, wall.normal),
                velocity: air.momentum / air.density - wall.velocity,
                height: modelled.height,
            })
        })
    }

    /// Takes the stress of `layers` from the air: tells which populations are `changed`, from what `leaving` the cells, and what every side of every link has `taken`, zero where nothing is modelled.
    pub fn take_stress(
        &mut self,
        (links, normals): (&[CutLink], &[DVec3]),
        leaving: &[Leaving],
        layers: &BoundaryLayers,
        (changed, taken): (&mut Vec<Changed>, &mut Vec<[DVec3; 2]>),
    ) {
        self.lost.clear();
        self.lost.resize(self.cells.len(), DVec3::ZERO);
        taken.clear();
        taken.resize(links.len(), [DVec3::ZERO; 2]);
        for image in &self.images {
            let Some(modelled) = image.modelled else {
                continue;
            };
            let (number, side) = (image.link as usize, usize::from(image.side));
            let link = &links[number];
            let normal = normals[link.cuts[side].triangle as usize];
            let (d, n) = (vector(link.leaving(side)), away(link, side, normal));
            let across = d.dot(n);
            let area =
                9.0 * WEIGHTS[link.leaving(side)] * across * (d - n * across).length_squared();
            let stress = layers.stress(face(link, side, normal)) * area;
            let cells = image.cells.map(|(_, cell)| cell);
            let from = cells.into_iter().chain([modelled.off]);
            for (cell, share) in from.zip(modelled.shares) {
                self.lost[cell as usize] += stress * share;
                taken[number][side] += stress * share;
            }
        }
        changed.clear();
        let lost = self.lost.iter().zip(&self.loses).zip(leaving);
        for (cell, ((lost, loses), leaving)) in self.cells.iter().zip(lost) {
            let Some(loses) = loses else { continue };
            if *lost == DVec3::ZERO {
                continue;
            }
            let mut to_rest = 0.0;
            let mut change = |direction: usize, change: f64| {
                changed.push(Changed {
                    cell: *cell,
                    direction,
                    population: leaving[direction],
                    change,
                });
            };
            for (open, lost) in loses.iter().zip(lost.to_array()) {
                let each = lost / open.iter().flatten().count() as f64;
                for (direction, sign) in open.iter().zip([-1.0, 1.0]) {
                    if let Some(direction) = direction {
                        change(usize::from(*direction), sign * each);
                        to_rest -= sign * each;
                    }
                }
            }
            // Beside a wall one link of an axis may be cut; the cell keeps its mass.
            if to_rest != 0.0 {
                change(0, to_rest);
            }
        }
    }

    /// What comes back to every side that slides, from what `leaving` the cells; `wall` tells of the wall at a side.
    pub fn returned(
        &self,
        links: &[CutLink],
        leaving: &[Leaving],
        wall: impl Fn(&CutLink, usize) -> Wall + Sync,
        back: &mut Vec<Back>,
    ) {
        let air: Vec<Air> = (leaving.par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(Air::new)
            .collect();
        (self.images.par_iter())
            .with_min_len(LINKS_AT_ONCE)
            .map(|image| {
                let (number, side) = (image.link as usize, usize::from(image.side));
                let link = &links[number];
                let from = opposite(link.leaving(side));
                let (mut at, mut came) = (Air::default(), 0.0);
                for (share, cell) in image.cells {
                    let cell = cell as usize;
                    at.add(share, &air[cell]);
                    came += share * leaving[cell][from];
                }
                let [population, strength] = reflected(link, side, came, &at, wall(link, side));
                Back {
                    link: number,
                    side,
                    population,
                    strength,
                }
            })
            .collect_into_vec(back);
    }
}

/// How a cell loses momentum; `None` where both links along an axis are cut.
fn loses(links: &CutLinks, domain: &Domain, cell: [i32; 3]) -> Option<Loses> {
    let along = |a: usize| {
        let open = [1, -1].map(|sign| {
            let direction = (1..DIRECTION_COUNT).find(|&direction| {
                let c = DIRECTIONS[direction];
                (0..3).all(|other| c[other] == if other == a { sign } else { 0 })
            })?;
            neighbour(links, domain, cell, direction)?;
            Some(direction as u8)
        });
        (open != [None; 2]).then_some(open)
    };
    Some([along(0)?, along(1)?, along(2)?])
}

/// Shares of a model's stress that the cells of an image and the one off the wall lose, of those that can.
fn shares_of_loss(
    image: &Image,
    off: u32,
    loses: &[Option<Loses>],
) -> [f64; CELLS_OF_AN_IMAGE + 1] {
    let mut shares = [TAKEN_OFF; CELLS_OF_AN_IMAGE + 1];
    for (to, (share, _)) in shares.iter_mut().zip(image.cells) {
        *to = (1.0 - TAKEN_OFF) * share;
    }
    let cells = image.cells.map(|(_, cell)| cell);
    for (share, cell) in shares.iter_mut().zip(cells.into_iter().chain([off])) {
        if loses[cell as usize].is_none() {
            *share = 0.0;
        }
    }
    let sum: f64 = shares.iter().sum();
    shares.map(|share| if sum > 0.0 { share / sum } else { 0.0 })
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

/// The neighbour of a cell in the air, or the cell that it repeats; `None` where a wall or the end of the air is between.
fn neighbour(
    links: &CutLinks,
    domain: &Domain,
    cell: [i32; 3],
    direction: usize,
) -> Option<[i32; 3]> {
    let c = DIRECTIONS[direction];
    let next = domain.cell(std::array::from_fn(|a| i64::from(cell[a] + c[a])))?;
    (direction == 0 || !links.cuts(cell, next, direction)).then_some(next)
}

/// A cell off the wall, and its distance from it: straight ahead as far as a direction of the lattice leads, and fewer cells where another wall is near.
fn cell_off(
    links: &CutLinks,
    domain: &Domain,
    link: &CutLink,
    side: usize,
    normal: DVec3,
) -> ([i32; 3], f64) {
    let n = away(link, side, normal);
    let off = |direction: usize| -vector(direction).dot(n);
    let straight = |direction: usize| off(direction) / vector(direction).length();
    let ahead = (1..DIRECTION_COUNT)
        .max_by(|a, b| straight(*a).total_cmp(&straight(*b)))
        .unwrap_or(0);
    let mut cell = link.cells[side];
    let mut height = link.distance(side) * -off(link.leaving(side));
    for _ in 0..CELLS_OFF {
        let Some(next) = neighbour(links, domain, cell, ahead) else {
            break;
        };
        cell = next;
        height += off(ahead);
    }
    (cell, height)
}

/// The cells nearest to the mirror image of the cell behind a cut, among the side's own and its neighbours in the air.
fn cells_of_image(
    links: &CutLinks,
    domain: &Domain,
    link: &CutLink,
    side: usize,
    normal: DVec3,
) -> [(f64, [i32; 3]); CELLS_OF_AN_IMAGE] {
    let own = link.cells[side];
    let (d, n) = (vector(link.leaving(side)), away(link, side, normal));
    let image = d - n * (2.0 * (1.0 - link.distance(side)) * d.dot(n));
    let mut nearest = [(0.0, own); CELLS_OF_AN_IMAGE];
    for direction in 0..DIRECTION_COUNT {
        let distance = (vector(direction) - image).length_squared();
        let mut new = (1.0 / (distance * distance + ON_A_CENTRE), own);
        if new.0 <= nearest[CELLS_OF_AN_IMAGE - 1].0 {
            continue;
        }
        // Walls beyond a side that repeats are not looked for: with them a thin section between such sides breaks down on 24 cells (docs/cut-links.md#limits).
        let c = DIRECTIONS[direction];
        let next: [i32; 3] = std::array::from_fn(|a| own[a] + c[a]);
        if direction > 0 && links.cuts(own, next, direction) {
            continue;
        }
        let Some(cell) = domain.cell(next.map(i64::from)) else {
            continue;
        };
        new.1 = cell;
        for held in &mut nearest {
            if new.0 > held.0 {
                std::mem::swap(held, &mut new);
            }
        }
    }
    nearest
}

/// What comes back, and α.
fn reflected(link: &CutLink, side: usize, back: f64, air: &Air, wall: Wall) -> [f64; 2] {
    let direction = link.leaving(side);
    let (weight, d) = (WEIGHTS[direction], vector(direction));
    let n = away(link, side, wall.normal);
    let across = d.dot(n);
    let alpha = (0.5 / link.distance(side)).min(1.0);
    let passing = n.dot(air.momentum - wall.velocity * air.density);
    let flux = air.flux(n) - air.momentum * n.dot(wall.velocity);
    let shear = flux - n * n.dot(flux);
    [
        back + 6.0 * weight * alpha * across * passing - 18.0 * weight * across * d.dot(shear),
        alpha,
    ]
}
