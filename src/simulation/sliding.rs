//! Parts of a surface that cuts links along which the air slides, and the mass that it owes the air there ([`crate::cut_links::slide`]).

use glam::DVec3;

use crate::case::coupling::Friction;
use crate::cut_links::boundary_layer::Shape;
use crate::cut_links::slide::{self, Back, Changed, Slides};
use crate::cut_links::spaces::Spaces;
use crate::cut_links::{
    BoundaryLayers, CutLink, CutLinks, Domain, Images, Leaving, Return, SIDES, Wall,
};
use crate::lattice::WEIGHTS;

/// How the air slides along the surface.
#[derive(Debug)]
pub(super) struct Sliding {
    /// Of the triangles.
    friction: Vec<Friction>,
    images: Images,
    /// What left the cells of the images.
    leaving: Vec<Leaving>,
    back: Vec<Back>,
    spaces: Spaces,
    /// `None` where no boundary layer is modelled.
    layers: Option<BoundaryLayers>,
    /// Populations that lose the stress of the layers.
    changed: Vec<Changed>,
    /// What every side of every link takes of the air's momentum so; empty without layers.
    taken: Vec<[DVec3; 2]>,
    /// Of every space: what its sides lost in the step, and the sum of their weights.
    sums: Vec<[f64; 2]>,
    returned: f64,
}

/// What the air needs to know of walls with boundary layers that the cells do not hold, in lattice units.
#[derive(Debug, Clone, Copy)]
pub struct LayersIn {
    /// Kinematic viscosity [cells² per step].
    pub viscosity: f64,
    /// Reynolds number of the length of run at which a layer along a flat plate turns turbulent; 0 at its front.
    pub transition_reynolds: f64,
}

impl Sliding {
    /// With the `friction` of all triangles; `None` where the air sticks to all. Their nodes stand at `positions` at first, in any unit.
    pub(super) fn new(
        friction: Vec<Friction>,
        layers: LayersIn,
        triangles: &[[u32; 3]],
        positions: &[DVec3],
    ) -> Option<Self> {
        let modelled = friction.iter().map(|f| *f == Friction::Model).collect();
        (friction.iter().any(|f| *f != Friction::NoSlip)).then(|| Self {
            images: Images::default(),
            leaving: Vec::new(),
            back: Vec::new(),
            spaces: Spaces::new(triangles, positions),
            layers: BoundaryLayers::new(modelled, layers.viscosity, layers.transition_reynolds),
            changed: Vec::new(),
            taken: Vec::new(),
            friction,
            sums: Vec::new(),
            returned: 0.0,
        })
    }

    /// Lays the images out for what the surface cuts.
    pub(super) fn find(&mut self, links: &CutLinks, domain: &Domain, normals: &[DVec3]) {
        let friction = &self.friction;
        self.images.find(links, domain, |triangle| {
            let slides = Slides {
                normal: normals[triangle],
                modelled: friction[triangle] == Friction::Model,
            };
            (friction[triangle] != Friction::NoSlip).then_some(slides)
        });
    }

    /// Cells of which is asked what left them, and where that goes.
    pub(super) fn read(&mut self) -> (&[[i32; 3]], &mut Vec<Leaving>) {
        (self.images.cells(), &mut self.leaving)
    }

    /// Puts what comes back where the air slides into `returns`; `velocity` is that of the wall at a side.
    pub(super) fn answer(
        &mut self,
        links: &[CutLink],
        (triangles, positions, normals): (&[[u32; 3]], &[DVec3], &[DVec3]),
        velocity: impl Fn(&CutLink, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        let wall = |link: &CutLink, side: usize| Wall {
            normal: normals[link.cuts[side].triangle as usize],
            velocity: velocity(link, side),
        };
        let (images, leaving) = (&mut self.images, &self.leaving);
        if let Some(layers) = &mut self.layers {
            let shape = Shape {
                triangles,
                positions,
                normals,
                spaces: &self.spaces,
            };
            layers.step(shape, images.samples(links, leaving, wall));
            let results = (&mut self.changed, &mut self.taken);
            images.take_stress((links, normals), leaving, layers, results);
        }
        images.returned(links, leaving, wall, &mut self.back);
        for back in &self.back {
            let (link, side) = (&links[back.link], back.side);
            let weight = WEIGHTS[link.leaving(side)];
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let along = sign * link.direction().dot(velocity(link, side));
            let returned = &mut returns[back.link][side];
            // As far as the wall's velocity changes in this step, it is that of a wall to which the air sticks: convex in the fabric's step.
            *returned = Return {
                out: returned.out,
                share: 0.0,
                further: back.population + 6.0 * weight * back.strength * along,
                strength: back.strength,
            };
        }
    }

    /// Populations that lose the stress of modelled layers in this step.
    pub(super) fn changed(&self) -> &[Changed] {
        &self.changed
    }

    /// What every side of every link takes of the air's momentum by that stress; empty without layers.
    pub(super) fn taken(&self) -> &[[DVec3; 2]] {
        &self.taken
    }

    /// Layers that are modelled.
    pub(super) const fn layers(&self) -> Option<&BoundaryLayers> {
        self.layers.as_ref()
    }

    /// The same, to go on from.
    pub(super) const fn layers_mut(&mut self) -> Option<&mut BoundaryLayers> {
        self.layers.as_mut()
    }

    /// Mass given back to the air since this was made, loss and gain alike.
    pub(super) const fn returned(&self) -> f64 {
        self.returned
    }

    /// Gives back what the air lost in the step at all sides where it slides, `rest` of each: in equal parts, by weight, to those that look at the same space.
    ///
    /// Along a plane wall in a uniform stream some sides lose what others gain, so that what each lost must not come back to itself: it would be rough.
    pub(super) fn keep_mass(
        &mut self,
        links: &[CutLink],
        normals: &[DVec3],
        rest: &mut [[f64; 2]],
    ) {
        let (friction, spaces, sums) = (&self.friction, &self.spaces, &mut self.sums);
        let space = |link: &CutLink, side: usize| {
            let triangle = link.cuts[side].triangle as usize;
            let slides = friction[triangle] != Friction::NoSlip;
            slides.then(|| spaces.of(slide::face(link, side, normals[triangle])))
        };
        sums.clear();
        sums.resize(spaces.count(), [0.0; 2]);
        for (link, rest) in links.iter().zip(&*rest) {
            for side in SIDES {
                if let Some(space) = space(link, side) {
                    sums[space][0] += rest[side];
                    sums[space][1] += WEIGHTS[link.leaving(side)];
                }
            }
        }
        for (link, rest) in links.iter().zip(rest) {
            for side in SIDES {
                if let Some(space) = space(link, side) {
                    let [lost, weights] = sums[space];
                    rest[side] = lost / weights * WEIGHTS[link.leaving(side)];
                }
            }
        }
        self.returned += sums.iter().map(|[lost, _]| lost.abs()).sum::<f64>();
    }
}
