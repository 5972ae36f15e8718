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

use glam::{DMat3, DVec3};

use super::search::{CutLink, CutLinks, Domain};
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, WEIGHTS, opposite};

/// What leaves a cell, by direction; shifted populations.
pub type Leaving = [f64; DIRECTION_COUNT];

/// Cells that an image is taken from.
const CELLS_OF_AN_IMAGE: usize = 3;

/// Length below which an image counts as lying on a cell's centre, to the fourth power [cells⁴].
const ON_A_CENTRE: f64 = 1e-3;

/// State of the air where an image lies, as it leaves.
#[derive(Debug, Clone, Copy, Default)]
struct Air {
    density: f64,
    momentum: DVec3,
    /// Flux of momentum beyond the pressure.
    flux: DMat3,
}

fn vector(direction: usize) -> DVec3 {
    DVec3::from_array(DIRECTIONS[direction].map(f64::from))
}

impl Air {
    fn new(leaving: &Leaving) -> Self {
        let mut air = Self::default();
        let mut excess = 0.0;
        for (direction, population) in leaving.iter().enumerate() {
            let c = vector(direction);
            excess += population;
            air.momentum += c * *population;
            air.flux += DMat3::from_cols(c * c.x, c * c.y, c * c.z) * *population;
        }
        air.density = 1.0 + excess;
        air.flux -= DMat3::IDENTITY * (excess / 3.0);
        air
    }
}

/// Mirror image of the cell behind a cut: shares of cells in the air.
#[derive(Debug, Clone, Copy)]
struct Image {
    link: u32,
    side: u8,
    cells: [(f64, u32); CELLS_OF_AN_IMAGE],
}

/// A cut that slides: unit normal of its triangle, and velocity of the wall there.
pub type Wall = (DVec3, DVec3);

/// Images of all cut links at which the air slides.
#[derive(Debug, Clone, Default)]
pub struct Images {
    images: Vec<Image>,
    /// Cells that they are taken from, in order.
    cells: Vec<[i32; 3]>,
}

impl Images {
    /// Lays them out for `links`; `slides` gives the unit normal of a triangle along which the air slides.
    pub fn find(
        &mut self,
        links: &CutLinks,
        domain: &Domain,
        slides: impl Fn(usize) -> Option<DVec3>,
    ) {
        self.images.clear();
        let mut asked = Vec::new();
        for (number, link) in links.links().iter().enumerate() {
            for side in super::SIDES {
                let Some(normal) = slides(link.cuts[side].triangle as usize) else {
                    continue;
                };
                let found = cells_of_image(links, domain, link, side, normal);
                let sum: f64 = found.iter().map(|(share, _)| share).sum();
                self.images.push(Image {
                    link: number as u32,
                    side: side as u8,
                    cells: found.map(|(share, _)| (share / sum, 0)),
                });
                asked.extend(found.map(|(_, cell)| cell));
            }
        }
        self.cells.clone_from(&asked);
        self.cells.sort_unstable();
        self.cells.dedup();
        for (image, asked) in (self.images.iter_mut()).zip(asked.chunks_exact(CELLS_OF_AN_IMAGE)) {
            for ((_, place), cell) in image.cells.iter_mut().zip(asked) {
                *place = self.cells.partition_point(|other| other < cell) as u32;
            }
        }
    }

    /// Cells of which is asked what left them.
    #[must_use]
    pub fn cells(&self) -> &[[i32; 3]] {
        &self.cells
    }

    /// What comes back to every side that slides, with α, from what `leaving` the cells; `wall` tells of the wall at a side.
    pub fn returned(
        &self,
        links: &[CutLink],
        leaving: &[Leaving],
        wall: impl Fn(&CutLink, usize) -> Wall,
        mut take: impl FnMut(usize, usize, [f64; 2]),
    ) {
        let air: Vec<Air> = leaving.iter().map(Air::new).collect();
        for image in &self.images {
            let (number, side) = (image.link as usize, usize::from(image.side));
            let link = &links[number];
            let (mut at, mut back) = (Air::default(), 0.0);
            for (share, cell) in image.cells {
                let cell = cell as usize;
                at.density += share * air[cell].density;
                at.momentum += air[cell].momentum * share;
                at.flux += air[cell].flux * share;
                back += share * leaving[cell][opposite(link.leaving(side))];
            }
            take(
                number,
                side,
                reflected(link, side, back, &at, wall(link, side)),
            );
        }
    }
}

/// Unit normal away from the air of a side.
fn away(link: &CutLink, side: usize, normal: DVec3) -> DVec3 {
    if vector(link.leaving(side)).dot(normal) < 0.0 {
        -normal
    } else {
        normal
    }
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
        if direction > 0 && links.cuts(own, direction) {
            continue;
        }
        let c = DIRECTIONS[direction];
        let Some(cell) = domain.cell(std::array::from_fn(|a| i64::from(own[a] + c[a]))) else {
            continue;
        };
        let distance = (vector(direction) - image).length_squared();
        let mut new = (1.0 / (distance * distance + ON_A_CENTRE), cell);
        for held in &mut nearest {
            if new.0 > held.0 {
                std::mem::swap(held, &mut new);
            }
        }
    }
    nearest
}

/// What comes back, and α.
fn reflected(
    link: &CutLink,
    side: usize,
    back: f64,
    air: &Air,
    (normal, velocity): Wall,
) -> [f64; 2] {
    let direction = link.leaving(side);
    let (weight, d) = (WEIGHTS[direction], vector(direction));
    let n = away(link, side, normal);
    let across = d.dot(n);
    let alpha = (0.5 / link.distance(side)).min(1.0);
    let passing = n.dot(air.momentum - velocity * air.density);
    let flux = air.flux * n - air.momentum * n.dot(velocity);
    let shear = flux - n * n.dot(flux);
    [
        back + 6.0 * weight * alpha * across * passing - 18.0 * weight * across * d.dot(shear),
        alpha,
    ]
}
