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
//! sum of that, where a wall is not plane, goes to the whole wall. What is lost beyond it goes to the links nearby ([`super::reflections`]). So the air keeps its mass. What is given back arrives
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

use super::Return;
use super::boundary_layer::Face;
use super::cell_states::{Air, CELLS_OF_AN_IMAGE, CellState};
use super::energy::Energy;
use super::faces;
use super::search::CutLink;
use crate::lattice::{DIRECTION_COUNT, DIRECTIONS, Real, WEIGHTS, opposite};

/// The directions as vectors.
const VECTORS: [DVec3; DIRECTION_COUNT] = {
    let mut vectors = [DVec3::ZERO; DIRECTION_COUNT];
    let mut direction = 0;
    while direction < DIRECTION_COUNT {
        let [x, y, z] = DIRECTIONS[direction];
        vectors[direction] = DVec3::new(x as f64, y as f64, z as f64);
        direction += 1;
    }
    vectors
};

#[inline]
pub(super) const fn vector(direction: usize) -> DVec3 {
    VECTORS[direction]
}

/// Mirror image of the cell behind a cut: shares of cells in the air.
#[derive(Debug, Clone, Copy)]
pub(super) struct Image {
    pub(super) link: u32,
    pub(super) side: u8,
    /// Direction d in which air leaves the side.
    pub(super) direction: u8,
    /// Unit normal n away from the air.
    pub(super) away: DVec3,
    /// α.
    strength: f64,
    /// β.
    pub(super) turned_round: f64,
    /// Number of the side's own cell, and those of the image's.
    pub(super) own: u32,
    pub(super) cells: [u32; CELLS_OF_AN_IMAGE],
    pub(super) shares: [f64; CELLS_OF_AN_IMAGE],
}

/// How the air slides along a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Slides {
    /// Its unit normal.
    pub normal: DVec3,
    /// Number of the space that the side looks at.
    pub space: u32,
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

impl Image {
    /// Of the cell behind the cut at a side of a link, taken from cells by these shares; η is `closer`. Who made it numbers the cells; until then these are their places in a box.
    pub(super) fn new(
        (number, link, side): (u32, &CutLink, usize),
        away: DVec3,
        shares: [f64; CELLS_OF_AN_IMAGE],
        closer: f64,
    ) -> Self {
        let strength = (0.5 / link.distance(side)).min(1.0);
        Self {
            link: number,
            side: side as u8,
            direction: link.leaving(side) as u8,
            away,
            strength,
            turned_round: strength * closer + 0.5 * (1.0 - closer),
            own: 0,
            cells: [0; CELLS_OF_AN_IMAGE],
            shares,
        }
    }

    /// Its link, and which side of it this is.
    pub(super) fn place(&self) -> (usize, usize) {
        (self.link as usize, usize::from(self.side))
    }

    /// Weight of the direction in which air leaves.
    pub(super) fn weight(&self) -> f64 {
        WEIGHTS[usize::from(self.direction)]
    }

    /// What comes back, and what is lost, by the states of all `cells`.
    pub(super) fn returned<R: Real>(&self, cells: &[CellState<R>], wall: DVec3) -> (Return, Loss) {
        let direction = usize::from(self.direction);
        let out = cells[self.own as usize].leaving(direction);
        let of_image = self.cells.map(|cell| &cells[cell as usize]);
        let leaving = |direction: usize| {
            let parts = self.shares.into_iter().zip(of_image);
            parts.fold(0.0, |sum, (share, cell)| {
                sum + share * cell.leaving(direction)
            })
        };
        let exchanged = (leaving(direction), leaving(opposite(direction)));
        self.reflected(out, exchanged, &Air::between(self.shares, of_image), wall)
    }

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
        // The part of d along the wall.
        let tangent = d - away * across;
        let along = tangent.dot(relative);
        let moves = d.dot(wall);
        // d·s, s being the part along the wall of the flux across it.
        let shear = tangent.dot(air.flux(away)) - tangent.dot(air.momentum) * away.dot(wall);
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
    2 * link.cuts[side].triangle as usize + faces::face(normal, link, side)
}

/// Unit normal away from the air of a side.
pub(super) fn away(link: &CutLink, side: usize, normal: DVec3) -> DVec3 {
    if vector(link.leaving(side)).dot(normal) < 0.0 {
        -normal
    } else {
        normal
    }
}
