//! A surface of triangles that cuts links of the air's lattice, in lattice units ([`crate::cut_links`]): stages `find_links`, `read_links` and `bounce`.

use glam::DVec3;
use rayon::prelude::*;

use super::air::AirEngine;
use super::bodies::normal_of;
use super::sliding::Sliding;
use crate::cut_links::faces::Seen;
use crate::cut_links::{
    Cut, CutLink, CutLinks, Domain, FacePressures, OutOfAir, Return, SIDES, Through,
};
use crate::gpu::DeviceError;
use crate::lattice::WEIGHTS;

/// Links that one task works on.
const LINKS_AT_ONCE: usize = 512;

/// A surface in the air; what it is made of, its owner knows.
#[derive(Debug)]
pub struct CutSurface {
    domain: Domain,
    triangles: Vec<[u32; 3]>,
    /// Of the nodes [cells].
    positions: Vec<DVec3>,
    /// Of the triangles [1, cells²].
    normals: Vec<DVec3>,
    areas: Vec<f64>,
    links: CutLinks,
    /// Links are those of the positions.
    found: bool,
    returns: Vec<[Return; 2]>,
    /// Density excess between the layers of every link; zero with one.
    inside: Vec<f64>,
    faces: FacePressures,
    through: Option<Through>,
    /// `None` where the air sticks to all of it.
    sliding: Option<Sliding>,
    /// What comes back, and what goes to the population at rest.
    back: Vec<[f64; 2]>,
    rest: Vec<[f64; 2]>,
    /// Force on the air by every side of every link.
    forces: Vec<[DVec3; 2]>,
}

/// What the air does to the surface at one cut, in a step: along `leaving` the force `push` − `stiffness` leaving·v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutReaction {
    /// Unit vector in which air leaves towards the cut.
    pub leaving: DVec3,
    /// Force over velocity.
    pub stiffness: f64,
    /// Force on a surface at rest.
    pub push: f64,
}

impl CutSurface {
    /// A surface in the air of `engine` whose triangles have these nodes, of `count`. It keeps off `kept` cells at all faces; where it is `open`
    /// it goes on beyond them.
    #[must_use]
    pub fn new(
        engine: &AirEngine,
        triangles: Vec<[u32; 3]>,
        count: usize,
        (kept, open): (usize, bool),
    ) -> Self {
        let setup = engine.setup();
        Self {
            domain: Domain {
                cells: setup.cells,
                repeats: setup.repeats(),
                kept,
                open,
            },
            positions: vec![DVec3::ZERO; count],
            normals: vec![DVec3::ZERO; triangles.len()],
            areas: vec![0.0; triangles.len()],
            links: CutLinks::default(),
            found: false,
            returns: Vec::new(),
            inside: Vec::new(),
            faces: FacePressures::new(&triangles, count),
            through: None,
            sliding: None,
            back: Vec::new(),
            rest: Vec::new(),
            forces: Vec::new(),
            triangles,
        }
    }

    /// The same where air passes triangles by these laws [lattice units], its edges so many cells long in the mean.
    #[must_use]
    pub fn permeable(mut self, laws: &[Option<[f64; 2]>], edge_cells: f64) -> Self {
        let count = self.positions.len();
        self.through = Through::new(&self.triangles, laws, count, edge_cells);
        self
    }

    /// The same where the air slides without friction along the triangles for which `slides`, one for each, is true, its nodes at `positions` at first, in any unit. Where
    /// nothing slides, nothing is added.
    #[must_use]
    pub fn sliding(mut self, slides: Vec<bool>, positions: &[DVec3]) -> Self {
        self.sliding = Sliding::new(slides, &self.triangles, positions);
        self
    }

    /// Mass that was given back to the air where it slides, since this surface was made, loss and gain alike [cells of density 1].
    #[must_use]
    pub fn mass_returned(&self) -> f64 {
        self.sliding.as_ref().map_or(0.0, Sliding::returned)
    }

    /// Nodes of its triangles.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Where its nodes are [cells].
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The links that it cuts.
    #[must_use]
    pub fn links(&self) -> &[CutLink] {
        self.links.links()
    }

    /// Force on the air by both sides of every link in the last `bounce`.
    pub fn forces(&self) -> impl Iterator<Item = (&Cut, DVec3)> {
        (self.links().iter().zip(&self.forces))
            .flat_map(|(link, forces)| SIDES.map(|side| (&link.cuts[side], forces[side])))
    }

    /// True if the cells of all links, and those behind them, lie in the box of cells `first..end`.
    #[must_use]
    pub fn touches_only(&self, first: [usize; 3], end: [usize; 3]) -> bool {
        let inside = |cell: [i32; 3]| {
            (0..3).all(|a| cell[a] > first[a] as i32 && cell[a] + 1 < end[a] as i32)
        };
        self.links().iter().flat_map(|link| link.cells).all(inside)
    }

    /// Stage `find_links`, for nodes at `positions` [cells].
    pub fn find_links(&mut self, positions: &[DVec3]) -> Result<(), OutOfAir> {
        if self.found && self.positions == positions {
            return Ok(());
        }
        self.found = false;
        self.positions.copy_from_slice(positions);
        for (k, nodes) in self.triangles.iter().enumerate() {
            let corners = nodes.map(|n| positions[n as usize]);
            let [a, b, c] = corners;
            self.normals[k] = normal_of(corners);
            self.areas[k] = 0.5 * (b - a).cross(c - a).length();
        }
        self.links.find(positions, &self.triangles, &self.domain)?;
        if let Some(mut sliding) = self.sliding.take() {
            let mut images = std::mem::take(&mut sliding.images);
            images.find(&self.links, &self.domain, |triangle| {
                let normal = self.normals[triangle];
                sliding.along(triangle as u32).then_some(normal)
            });
            sliding.images = images;
            self.sliding = Some(sliding);
        }
        self.found = true;
        Ok(())
    }

    /// Stage `read_links`; the nodes moved with `velocities` in the last step, by which what passes the surface is found.
    pub fn read_links(
        &mut self,
        air: &mut AirEngine,
        velocities: &[DVec3],
    ) -> Result<(), DeviceError> {
        match air {
            AirEngine::CpuF32(fluid) => fluid.read_links(self.links.links(), &mut self.returns),
            AirEngine::CpuF64(fluid) => fluid.read_links(self.links.links(), &mut self.returns),
            AirEngine::Gpu(fluid) => fluid.read_links(self.links.links(), &mut self.returns)?,
        }
        self.slide(air, velocities)?;
        let seen = Seen {
            triangles: &self.triangles,
            normals: &self.normals,
            links: self.links.links(),
            returns: &self.returns,
        };
        // Pressures of faces are asked for between two layers alone.
        if self.links.doubled() > 0 {
            self.faces.take(&seen);
        }
        self.inside.clear();
        self.inside
            .extend(seen.links.iter().map(|link| match link.layers {
                1 => 0.0,
                _ => self.faces.between(&seen, link),
            }));
        if let Some(through) = &mut self.through {
            through.take(&seen, &self.inside, (velocities, &self.areas));
        }
        Ok(())
    }

    /// What comes back where the air slides, in place of what was read.
    fn slide(&mut self, air: &mut AirEngine, velocities: &[DVec3]) -> Result<(), DeviceError> {
        let Some(mut sliding) = self.sliding.take() else {
            return Ok(());
        };
        let (cells, leaving) = (sliding.images.cells(), &mut sliding.leaving);
        let read = match air {
            AirEngine::CpuF32(fluid) => {
                fluid.read_images(cells, leaving);
                Ok(())
            }
            AirEngine::CpuF64(fluid) => {
                fluid.read_images(cells, leaving);
                Ok(())
            }
            AirEngine::Gpu(fluid) => fluid.read_images(cells, leaving),
        };
        let (images, leaving) = (&sliding.images, &sliding.leaving);
        let mut returns = std::mem::take(&mut self.returns);
        let links = self.links.links();
        let wall = |link: &CutLink, side: usize| {
            let cut = &link.cuts[side];
            (
                self.normals[cut.triangle as usize],
                self.at(cut, velocities),
            )
        };
        images.returned(links, leaving, wall, |number, side, [back, strength]| {
            let link = &links[number];
            let weight = WEIGHTS[link.leaving(side)];
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let along = sign * link.direction().dot(wall(link, side).1);
            // As far as the wall's velocity changes in this step, it is that of a wall to which the air sticks: convex in the fabric's step.
            returns[number][side] = Return {
                out: returns[number][side].out,
                share: 0.0,
                further: back + 6.0 * weight * strength * along,
                strength,
            };
        });
        self.returns = returns;
        self.sliding = Some(sliding);
        read
    }

    /// Velocity of the air through the surface at a cut.
    fn through(&self, cut: &Cut) -> DVec3 {
        self.through.as_ref().map_or(DVec3::ZERO, |through| {
            let nodes = self.triangles[cut.triangle as usize];
            self.normals[cut.triangle as usize] * through.at(nodes, cut.weights)
        })
    }

    /// Mean velocity of the air through what is permeable; `None` where nothing is.
    #[must_use]
    pub fn mean_through(&self) -> Option<f64> {
        self.through.as_ref().map(Through::mean)
    }

    /// What the air does to the surface by what was read, cut by cut.
    pub fn reactions(&self) -> impl Iterator<Item = (&Cut, CutReaction)> {
        (0..self.links().len()).flat_map(|link| SIDES.map(|side| self.reaction(link, side)))
    }

    /// The same at one side of a link.
    #[must_use]
    pub fn reaction(&self, number: usize, side: usize) -> (&Cut, CutReaction) {
        let link = &self.links()[number];
        let c = link.direction();
        let length = c.length();
        let weight = WEIGHTS[link.leaving(0)];
        let cut = &link.cuts[side];
        let leaving = if side == 0 { c } else { -c } / length;
        let returned = &self.returns[number][side];
        let stiffness = 6.0 * weight * returned.strength * length * length;
        let push = (returned.push() - 2.0 * weight * self.inside[number]) * length
            - stiffness * leaving.dot(self.through(cut));
        let reaction = CutReaction {
            leaving,
            stiffness,
            push,
        };
        (cut, reaction)
    }

    /// Value of a field on nodes at a cut.
    #[must_use]
    pub fn at(&self, cut: &Cut, field: &[DVec3]) -> DVec3 {
        let [a, b, c] = self.triangles[cut.triangle as usize].map(|node| field[node as usize]);
        let [of_a, of_b, of_c] = cut.weights;
        a * of_a + b * of_b + c * of_c
    }

    /// Stage `bounce`, for nodes that move with `velocities` [cells per step].
    pub fn bounce(&mut self, air: &mut AirEngine, velocities: &[DVec3]) -> Result<(), DeviceError> {
        self.form_returns(velocities);
        let links = self.links.links();
        match air {
            AirEngine::CpuF32(fluid) => fluid.bounce(links, &self.back, &self.rest),
            AirEngine::CpuF64(fluid) => fluid.bounce(links, &self.back, &self.rest),
            AirEngine::Gpu(fluid) => fluid.bounce(links, &self.back, &self.rest)?,
        }
        Ok(())
    }

    /// What comes back, what goes to rest, and the forces on the air.
    fn form_returns(&mut self, velocities: &[DVec3]) {
        let mut back = std::mem::take(&mut self.back);
        let mut rest = std::mem::take(&mut self.rest);
        let mut forces = std::mem::take(&mut self.forces);
        let count = self.links().len();
        back.resize(count, [0.0; 2]);
        rest.resize(count, [0.0; 2]);
        forces.resize(count, [DVec3::ZERO; 2]);
        let formed = (back.par_iter_mut().zip(&mut rest)).zip(&mut forces);
        (formed.zip(self.links()).zip(&self.returns))
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|((((r, left), force), link), returns)| {
                let c = link.direction();
                let weight = WEIGHTS[link.leaving(0)];
                let of = |cut: &Cut| c.dot(self.at(cut, velocities) + self.through(cut));
                let mut along = [of(&link.cuts[0]); 2];
                if link.layers > 1 {
                    along[1] = of(&link.cuts[1]);
                }
                // Both sides at one velocity: what one loses the other gains.
                let mean = 0.5 * (along[0] + along[1]);
                for side in SIDES {
                    let sign = if side == 0 { 1.0 } else { -1.0 };
                    let returned = &returns[side];
                    r[side] = returned.back(weight, sign * along[side]);
                    left[side] = returned.out - 6.0 * weight * sign * mean - r[side];
                    force[side] = c * (-sign * (returned.out + r[side]));
                }
            });
        if let Some(sliding) = &mut self.sliding {
            sliding.keep_mass(self.links.links(), &self.normals, &mut rest);
        }
        (self.back, self.rest, self.forces) = (back, rest, forces);
    }

    /// Density excess on both faces of every node, which the next step goes on from.
    #[must_use]
    pub fn face_pressures(&self) -> &[[f64; 2]] {
        self.faces.excess()
    }

    /// Goes on from them, nodes at `positions` [cells].
    pub(super) fn go_on(&mut self, excess: Vec<[f64; 2]>, positions: Vec<DVec3>) {
        self.faces.go_on(excess);
        self.positions = positions;
        self.found = false;
    }
}
