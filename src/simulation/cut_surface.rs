//! A surface of triangles that cuts links of the air's lattice, in lattice units ([`crate::cut_links`]): stages `find_links`, `read_links`, `fetch_links` and `bounce`.

mod reach;

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::air::AirEngine;
use super::bodies::normal_of;
use super::sliding::{LayersIn, NOTHING, Sliding};
use super::surface_box::NOWHERE;
use super::wall_velocities::WallVelocities;
use crate::case::coupling::Friction;
use crate::cloth::patches::Patches;
use crate::cut_links::boundary_layer::Saved;
use crate::cut_links::faces::{self, Seen};
use crate::cut_links::{
    BoundaryLayers, CellState, ChangedByPair, Cut, CutLink, CutLinks, CutsByTriangle, Domain,
    FacePressures, OutOfAir, Passage, Pockets, Return, SIDES, StandingWalls, Through,
};
use crate::gpu::DeviceError;
use crate::lattice::WEIGHTS;

/// Links, and triangles, that one task works on.
const LINKS_AT_ONCE: usize = 512;
const TRIANGLES_AT_ONCE: usize = 512;

/// Links whose forces are summed together; part of the result, since sums are rounded part by part.
const LINKS_OF_A_PART: usize = 4096;

/// Forces on the air at the cuts of a link, both sides' at one where it has one layer; how many these are.
#[inline(always)]
fn of_link(link: &CutLink, along: [f64; 2], taken: [DVec3; 2]) -> ([(&Cut, DVec3); 2], usize) {
    let c = link.direction();
    let [first, other] = SIDES.map(|side| c * along[side] - taken[side]);
    let [cut, last] = &link.cuts;
    if link.layers > 1 {
        ([(cut, first), (last, other)], 2)
    } else {
        ([(cut, first + other), (last, DVec3::ZERO)], 1)
    }
}

/// A surface in the air; what it is made of, its owner knows.
#[derive(Debug)]
pub struct CutSurface {
    domain: Domain,
    /// Kinematic viscosity of the air [cells² per step].
    viscosity: f64,
    triangles: Vec<[u32; 3]>,
    /// Of the nodes [cells].
    positions: Vec<DVec3>,
    /// Of the triangles [1, cells²].
    normals: Vec<DVec3>,
    areas: Vec<f64>,
    links: CutLinks,
    /// Cells that they shut in.
    pockets: Pockets,
    /// Sorted when first asked for.
    cuts: CutsByTriangle,
    /// Links are those of the positions.
    found: bool,
    /// What of the air they touch.
    reach: [[i32; 3]; 2],
    returns: Vec<[Return; 2]>,
    /// Density excess between the layers of every link; zero with one.
    inside: Vec<f64>,
    faces: FacePressures,
    /// Its first triangles share what the air does to them; `None` where each has it alone.
    patches: Option<Patches>,
    /// Reactions are asked for, and with them what stands between two layers.
    reacts: bool,
    through: Option<Through>,
    /// `None` where the air sticks to all of it.
    sliding: Option<Sliding>,
    /// What comes back, and what goes to the population at rest.
    back: Vec<[f64; 2]>,
    rest: Vec<[f64; 2]>,
    /// Force on the air by every side of every link over its direction, beside the stress of modelled boundary layers.
    forces: Vec<[f64; 2]>,
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
    /// A surface in the air of `engine` whose triangles have these nodes, of `count`. It keeps off `kept` cells at all faces; triangles
    /// from `open_from` on may go on beyond them.
    #[must_use]
    pub fn new(
        engine: &AirEngine,
        triangles: Vec<[u32; 3]>,
        count: usize,
        (kept, open_from): (usize, Option<usize>),
    ) -> Self {
        let setup = engine.setup();
        Self {
            domain: Domain {
                cells: setup.cells,
                repeats: setup.repeats(),
                kept,
                open_from,
            },
            viscosity: (setup.relaxation_time - 0.5) / 3.0,
            positions: vec![DVec3::ZERO; count],
            normals: vec![DVec3::ZERO; triangles.len()],
            areas: vec![0.0; triangles.len()],
            links: CutLinks::default(),
            pockets: Pockets::default(),
            cuts: CutsByTriangle::default(),
            found: false,
            reach: NOWHERE,
            returns: Vec::new(),
            inside: Vec::new(),
            faces: FacePressures::new(&triangles, count),
            patches: None,
            reacts: true,
            through: None,
            sliding: None,
            back: Vec::new(),
            rest: Vec::new(),
            forces: Vec::new(),
            triangles,
        }
    }

    /// The same where air passes triangles of these areas so [cells²].
    #[must_use]
    pub fn permeable(mut self, passages: &[Passage], areas: &[f64]) -> Self {
        let count = self.positions.len();
        self.through = Through::new(&self.triangles, passages, count, areas);
        self
    }

    /// The same with the `friction` of every triangle, its nodes at `positions` at first [cells]; modelled boundary layers turn turbulent at the Reynolds number `transition_reynolds`
    /// of the length of run, 0 at their front. Where the air sticks everywhere, nothing is added.
    #[must_use]
    pub fn with_friction(
        mut self,
        friction: Vec<Friction>,
        transition_reynolds: f64,
        positions: &[DVec3],
    ) -> Self {
        let layers = LayersIn {
            viscosity: self.viscosity,
            transition_reynolds,
        };
        self.sliding = Sliding::new(friction, layers, (&self.triangles, positions), &self.domain);
        self
    }

    /// The same where the air sticks inside of `bodies`, whose triangles these are: closed ones at rest, with nothing else inside, their nodes at `positions` [cells].
    #[must_use]
    pub fn sticking_inside(mut self, bodies: &[Range<usize>], positions: &[DVec3]) -> Self {
        if let Some(sliding) = &mut self.sliding {
            sliding.stick_inside(bodies, (&self.triangles, positions));
        }
        self
    }

    /// The same where its first triangles share what the air does to them.
    #[must_use]
    pub fn sharing(mut self, patches: Option<Patches>) -> Self {
        self.patches = patches;
        self
    }

    /// The same of rigid bodies alone, whose motion is prescribed: nobody asks for their reactions. Where air passes them, it still asks what stands between two layers.
    #[must_use]
    pub const fn rigid(mut self) -> Self {
        self.reacts = false;
        self
    }

    /// Boundary layers that are modelled, in lattice units; `None` where none are.
    #[must_use]
    pub fn boundary_layers(&self) -> Option<&BoundaryLayers> {
        self.sliding.as_ref().and_then(Sliding::layers)
    }

    /// Mass that was given back to the air where it slides, since this surface was made, loss and gain alike [cells of density 1]. Nothing where a device answers by itself.
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

    /// What a device needs to answer along them while the surface stands still, and no air passes it.
    pub(super) fn standing(&self) -> StandingWalls<'_> {
        StandingWalls {
            links: &self.links,
            images: self.sliding.as_ref().map(Sliding::images),
            pockets: &self.pockets,
        }
    }

    /// Sorts their cuts by triangle.
    pub(super) fn sort_cuts(&mut self) {
        self.cuts.sort(&self.links, self.triangles.len());
    }

    /// Their cuts by triangle, as they were sorted last.
    pub(super) const fn sorted_cuts(&self) -> &CutsByTriangle {
        &self.cuts
    }

    /// Force on the air by the surface in the last `bounce`, cut by cut. Nothing where a device answers by itself.
    pub fn forces(&self) -> impl Iterator<Item = (&Cut, DVec3)> {
        (0..self.links().len()).flat_map(|number| {
            let (forces, count) = self.forces_at(number);
            forces.into_iter().take(count)
        })
    }

    #[inline(always)]
    fn forces_at(&self, number: usize) -> ([(&Cut, DVec3); 2], usize) {
        let taken = self.taken().get(number).copied().unwrap_or_default();
        let along = self.forces.get(number).copied().unwrap_or_default();
        of_link(&self.links()[number], along, taken)
    }

    /// Those of some links.
    #[inline(always)]
    pub(super) fn each_force(&self, links: Range<usize>, mut of: impl FnMut(&Cut, DVec3)) {
        for number in links {
            let (forces, count) = self.forces_at(number);
            for (cut, force) in forces.into_iter().take(count) {
                of(cut, force);
            }
        }
    }

    /// Parts of the links, whose forces are summed together.
    pub(super) fn parts(&self) -> impl IndexedParallelIterator<Item = Range<usize>> {
        let count = self.links().len();
        (0..count.div_ceil(LINKS_OF_A_PART))
            .into_par_iter()
            .map(move |part| {
                let first = part * LINKS_OF_A_PART;
                first..(first + LINKS_OF_A_PART).min(count)
            })
    }

    /// What every side of every link takes of the air's momentum by modelled boundary layers; empty without any.
    fn taken(&self) -> &[[DVec3; 2]] {
        self.sliding.as_ref().map_or(&[][..], Sliding::taken)
    }

    /// Stage `find_links`, for nodes at `positions` [cells].
    pub fn find_links(&mut self, positions: &[DVec3]) -> Result<(), OutOfAir> {
        if self.found && self.positions == positions {
            return Ok(());
        }
        self.found = false;
        self.positions.copy_from_slice(positions);
        (self.normals.par_iter_mut().zip(&mut self.areas))
            .zip(&self.triangles)
            .with_min_len(TRIANGLES_AT_ONCE)
            .for_each(|((normal, area), nodes)| {
                let corners = nodes.map(|n| positions[n as usize]);
                let [a, b, c] = corners;
                *normal = normal_of(corners);
                *area = 0.5 * (b - a).cross(c - a).length();
            });
        if let Some(patches) = &mut self.patches {
            patches.share(&self.normals);
        }
        self.links.find(positions, &self.triangles, &self.domain)?;
        self.pockets.find(&self.links);
        if let Some(sliding) = &mut self.sliding {
            sliding.find(&self.links, &self.domain, &self.normals);
        }
        self.reach = self.find_reach();
        self.found = true;
        Ok(())
    }

    /// Stage `read_links`: what left along the links, and about the images of cells where the air slides. A device is asked for it, and does other work until
    /// [`CutSurface::fetch_links`].
    pub fn read_links(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        let mut returns = std::mem::take(&mut self.returns);
        let stick = self.sliding.as_ref().map_or(&[][..], Sliding::stick);
        match air {
            AirEngine::CpuF32(fluid) => fluid.read_links(&self.links, stick, &mut returns),
            AirEngine::CpuF16(fluid) => fluid.read_links(&self.links, stick, &mut returns),
            AirEngine::CpuF64(fluid) => fluid.read_links(&self.links, stick, &mut returns),
            AirEngine::Gpu(fluid) => fluid.read_links(&self.links, self.changed().1)?,
        }
        self.returns = returns;
        let Some(sliding) = &mut self.sliding else {
            return Ok(());
        };
        let (cells, count, states) = sliding.read(matches!(air, AirEngine::Gpu(_)));
        match air {
            AirEngine::CpuF32(fluid) => fluid.read_images(&cells[..count], states.single()),
            AirEngine::CpuF16(fluid) => fluid.read_images(&cells[..count], states.single()),
            AirEngine::CpuF64(fluid) => fluid.read_images(&cells[..count], states.double()),
            AirEngine::Gpu(fluid) => fluid.read_images(self.links.search(), (cells, count))?,
        }
        Ok(())
    }

    /// Stage `fetch_links`: takes what a device has read, and works out from it what comes back. The nodes moved with `velocities` in the last step, by which what passes the surface is
    /// found.
    pub fn fetch_links(
        &mut self,
        air: &mut AirEngine,
        velocities: &[DVec3],
    ) -> Result<(), DeviceError> {
        if let AirEngine::Gpu(fluid) = air {
            fluid.fetch_links(&self.links, &mut self.returns)?;
            if let Some(sliding) = &mut self.sliding {
                let (count, states) = sliding.asked();
                fluid.fetch_images(count, states.single())?;
            }
        }
        self.slide(velocities);
        let wall = WallVelocities::new(&self.triangles, self.patches.as_ref(), velocities);
        let seen = Seen {
            triangles: &self.triangles,
            normals: &self.normals,
            links: self.links.links(),
            returns: &self.returns,
        };
        self.inside.clear();
        self.inside.resize(seen.links.len(), 0.0);
        // Pressures of faces are asked for between two layers alone.
        let doubled = self.links.doubled();
        if !doubled.is_empty() && (self.reacts || self.through.is_some()) {
            self.cuts.sort(&self.links, self.triangles.len());
            self.faces.take(&seen, &self.cuts);
            let between: Vec<f64> = (doubled.par_iter())
                .with_min_len(LINKS_AT_ONCE)
                .map(|link| self.faces.between(&seen, &seen.links[*link as usize]))
                .collect();
            for (link, between) in doubled.iter().zip(between) {
                self.inside[*link as usize] = between;
            }
        }
        if let Some(through) = &mut self.through {
            through.take(&seen, &self.inside, (|cut: &Cut| wall.at(cut), &self.areas));
        }
        Ok(())
    }

    /// What comes back where the air slides, in place of what was read.
    fn slide(&mut self, velocities: &[DVec3]) {
        let Some(mut sliding) = self.sliding.take() else {
            return;
        };
        let mut returns = std::mem::take(&mut self.returns);
        let wall = WallVelocities::new(&self.triangles, self.patches.as_ref(), velocities);
        let velocity = |link: usize, side: usize| wall.at(&self.links()[link].cuts[side]);
        let shape = (&*self.triangles, &*self.positions, &*self.normals);
        sliding.answer(shape, velocity, &mut returns);
        self.returns = returns;
        self.sliding = Some(sliding);
    }

    /// Velocity of the air through the surface at one side of a link.
    fn through(&self, link: &CutLink, side: usize) -> DVec3 {
        let through = self.through.as_ref().filter(|t| !t.shuts(link));
        through.map_or(DVec3::ZERO, |through| {
            let cut = &link.cuts[side];
            let nodes = self.triangles[cut.triangle as usize];
            self.normals[cut.triangle as usize] * through.at(nodes, cut.weights)
        })
    }

    /// What the air behind gets beside it, at one side of a link: momentum of jets that its cells do not carry.
    fn jet(&self, link: &CutLink, side: usize) -> DVec3 {
        let jets = (self.through.as_ref()).filter(|t| t.has_openings() && !t.shuts(link));
        jets.map_or(DVec3::ZERO, |through| {
            let cut = &link.cuts[side];
            let nodes = self.triangles[cut.triangle as usize];
            let normal = self.normals[cut.triangle as usize];
            let face = faces::face(normal, link, side);
            normal * through.jet(face, nodes, cut.weights)
        })
    }

    /// Mean velocity of the air through permeable fabric; `None` where nothing is.
    #[must_use]
    pub fn mean_through(&self) -> Option<f64> {
        self.through.as_ref().and_then(Through::mean)
    }

    /// Goes on with it as it was.
    pub(super) fn go_on_with_mean_through(&mut self, mean: f64) {
        if let Some(through) = &mut self.through {
            through.go_on(mean);
        }
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
            - stiffness * leaving.dot(self.through(link, side) + self.jet(link, side));
        let reaction = CutReaction {
            leaving,
            stiffness,
            push,
        };
        (cut, reaction)
    }

    /// Force by the stress of a modelled boundary layer at one side of a link; `None` where no layer is.
    #[must_use]
    pub fn friction(&self, number: usize, side: usize) -> Option<DVec3> {
        let taken = self.taken().get(number)?[side];
        (taken != DVec3::ZERO).then_some(taken)
    }

    /// Value of a field on nodes at a cut.
    #[must_use]
    pub fn at(&self, cut: &Cut, field: &[DVec3]) -> DVec3 {
        let [a, b, c] = self.triangles[cut.triangle as usize].map(|node| field[node as usize]);
        let [of_a, of_b, of_c] = cut.weights;
        a * of_a + b * of_b + c * of_c
    }

    /// Triangles that share what the air does to them; `None` where each has it alone.
    #[must_use]
    pub const fn patches(&self) -> Option<&Patches> {
        self.patches.as_ref()
    }

    /// Share of nodes that have a flag in what the air does at a cut.
    #[must_use]
    pub fn share_of(&self, flags: &[bool], cut: &Cut) -> f64 {
        let flagged = |triangle: u32, weights: [f64; 3]| -> f64 {
            let nodes = self.triangles[triangle as usize].into_iter().zip(weights);
            nodes
                .map(|(node, weight)| if flags[node as usize] { weight } else { 0.0 })
                .sum()
        };
        match (self.patches.as_ref()).filter(|patches| patches.shares(cut.triangle)) {
            None => flagged(cut.triangle, cut.weights),
            Some(patches) => (patches.given(cut.triangle))
                .map(|(other, share)| flagged(other, [share / 3.0; 3]))
                .sum(),
        }
    }

    /// States of the cells of the images as a device has them, and the populations that lose the stress of boundary layers.
    fn changed(&self) -> (&[CellState<f32>], &ChangedByPair) {
        (self.sliding.as_ref()).map_or((&[], NOTHING), Sliding::changed)
    }

    /// Stage `bounce`, for nodes that move with `velocities` [cells per step].
    pub fn bounce(&mut self, air: &mut AirEngine, velocities: &[DVec3]) -> Result<(), DeviceError> {
        self.form_returns(velocities);
        let changed = self.changed();
        let (back, rest) = (&self.back, &self.rest);
        match air {
            AirEngine::CpuF32(fluid) => fluid.bounce(&self.links, back, rest, changed.1),
            AirEngine::CpuF16(fluid) => fluid.bounce(&self.links, back, rest, changed.1),
            AirEngine::CpuF64(fluid) => fluid.bounce(&self.links, back, rest, changed.1),
            AirEngine::Gpu(fluid) => fluid.bounce(&self.links, back, rest, changed)?,
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
        forces.resize(count, [0.0; 2]);
        let formed = (back.par_iter_mut().zip(&mut rest)).zip(&mut forces);
        let wall = WallVelocities::new(&self.triangles, self.patches.as_ref(), velocities);
        (formed.zip(self.links()).zip(&self.returns))
            .with_min_len(LINKS_AT_ONCE)
            .for_each(|((((r, left), force), link), returns)| {
                let c = link.direction();
                let weight = WEIGHTS[link.leaving(0)];
                let of = |side: usize| c.dot(wall.at(&link.cuts[side]) + self.through(link, side));
                let mut along = [of(0); 2];
                if link.layers > 1 {
                    along[1] = of(1);
                }
                // Both sides at one velocity: what one loses the other gains.
                let mean = 0.5 * (along[0] + along[1]);
                for side in SIDES {
                    let sign = if side == 0 { 1.0 } else { -1.0 };
                    let returned = &returns[side];
                    let along = along[side] + c.dot(self.jet(link, side));
                    r[side] = returned.back(weight, sign * along);
                    left[side] = returned.out - 6.0 * weight * sign * mean - r[side];
                    force[side] = -sign * (returned.out + r[side]);
                }
            });
        if let Some(sliding) = &mut self.sliding {
            sliding.keep_mass(&mut rest);
        }
        (self.pockets).relieve(self.links(), &self.returns, &mut rest);
        (self.back, self.rest, self.forces) = (back, rest, forces);
    }

    /// Density excess on both faces of every node, which the next step goes on from.
    #[must_use]
    pub fn face_pressures(&self) -> &[[f64; 2]] {
        self.faces.excess()
    }

    /// Goes on from them and from the boundary layers, nodes at `positions` [cells].
    pub(super) fn go_on(
        &mut self,
        excess: Vec<[f64; 2]>,
        (layers, steps_left): (&[Saved], u64),
        positions: Vec<DVec3>,
    ) {
        self.faces.go_on(excess);
        if let Some(own) = self.sliding.as_mut().and_then(Sliding::layers_mut) {
            own.go_on(layers, steps_left);
        }
        self.positions = positions;
        self.found = false;
    }
}
