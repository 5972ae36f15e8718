//! Parts of a surface that cuts links along which the air slides, and the mass that it owes the air there ([`crate::cut_links::slide`]).

use glam::DVec3;

use crate::case::coupling::Friction;
use crate::cut_links::boundary_layer::Shape;
use crate::cut_links::slide::{self, Back, Slides};
use crate::cut_links::spaces::Spaces;
use crate::cut_links::{
    BoundaryLayers, ChangedByPair, CutLink, CutLinks, Domain, Images, Leaving, Return, Stress,
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
    /// Number of the space that each image looks at.
    space_of: Vec<u32>,
    /// `None` where no boundary layer is modelled.
    modelled: Option<Modelled>,
    /// Of every space: what its sides lost in the step, and the sum of their weights.
    sums: Vec<[f64; 2]>,
    returned: f64,
}

/// Boundary layers that are modelled, and what they take from the air.
#[derive(Debug)]
struct Modelled {
    layers: BoundaryLayers,
    /// They march in this step.
    march: bool,
    stress: Stress,
    /// The stress is that of the layers and images as they are now.
    taken: bool,
}

/// No population changes.
pub(super) const NOTHING: &ChangedByPair = &[const { Vec::new() }; 4];

/// What the air needs to know of walls with boundary layers that the cells do not hold, in lattice units.
#[derive(Debug, Clone, Copy)]
pub struct LayersIn {
    /// Kinematic viscosity [cells² per step].
    pub viscosity: f64,
    /// Reynolds number of the length of run at which a layer along a flat plate turns turbulent; 0 at its front.
    pub transition_reynolds: f64,
}

impl Sliding {
    /// With the `friction` of all triangles in the air of a domain; `None` where the air sticks to all. Their nodes stand at `positions` at first [cells].
    pub(super) fn new(
        friction: Vec<Friction>,
        layers: LayersIn,
        (triangles, positions): (&[[u32; 3]], &[DVec3]),
        domain: &Domain,
    ) -> Option<Self> {
        let modelled = friction.iter().map(|f| *f == Friction::Model).collect();
        (friction.iter().any(|f| *f != Friction::NoSlip)).then(|| Self {
            images: Images::default(),
            leaving: Vec::new(),
            back: Vec::new(),
            spaces: Spaces::new(triangles, positions, |middle| domain.goes_round(middle)),
            space_of: Vec::new(),
            modelled: BoundaryLayers::new(modelled, layers.viscosity, layers.transition_reynolds)
                .map(|layers| Modelled {
                    layers,
                    march: false,
                    stress: Stress::default(),
                    taken: false,
                }),
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
        if let Some(modelled) = &mut self.modelled {
            modelled.stress.find(links, domain, &self.images);
            modelled.taken = false;
        }
        let (links, spaces) = (links.links(), &self.spaces);
        let space = |(link, side): (usize, usize)| {
            let normal = normals[links[link].cuts[side].triangle as usize];
            spaces.of(slide::face(&links[link], side, normal)) as u32
        };
        self.space_of.clear();
        self.space_of.extend(self.images.sides().map(space));
    }

    /// Begins a step: cells of which is asked what left them, and where that goes.
    pub(super) fn read(&mut self) -> (&[[i32; 3]], &mut Vec<Leaving>) {
        let mut march = false;
        if let Some(modelled) = &mut self.modelled {
            modelled.march = modelled.layers.count_step();
            march = modelled.march;
        }
        (self.images.cells(march), &mut self.leaving)
    }

    /// Puts what comes back where the air slides into `returns`; `velocity` is that of the wall at a side.
    pub(super) fn answer(
        &mut self,
        links: &[CutLink],
        (triangles, positions, normals): (&[[u32; 3]], &[DVec3], &[DVec3]),
        velocity: impl Fn(&CutLink, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        let (images, leaving) = (&mut self.images, &self.leaving);
        if let Some(modelled) = &mut self.modelled {
            if modelled.march {
                let shape = Shape {
                    triangles,
                    positions,
                    normals,
                    spaces: &self.spaces,
                };
                let samples = images.samples(links, leaving, &velocity);
                modelled.layers.march(shape, samples);
                modelled.taken = false;
            }
            if !modelled.taken {
                modelled.stress.take(links, images, &modelled.layers);
                modelled.taken = true;
            }
        }
        images.returned(links, leaving, velocity, &mut self.back);
        for back in &self.back {
            let returned = &mut returns[back.link as usize][usize::from(back.side)];
            *returned = Return {
                out: returned.out,
                share: 0.0,
                further: back.further,
                strength: back.strength,
            };
        }
    }

    /// What left the cells of the images, and the populations that lose the stress of modelled layers in this step.
    pub(super) fn changed(&self) -> (&[Leaving], &ChangedByPair) {
        let changed = (self.modelled.as_ref()).map_or(NOTHING, |m| m.stress.changed());
        (&self.leaving, changed)
    }

    /// What every side of every link takes of the air's momentum by that stress; empty without layers.
    pub(super) fn taken(&self) -> &[[DVec3; 2]] {
        (self.modelled.as_ref()).map_or(&[][..], |modelled| modelled.stress.taken())
    }

    /// Layers that are modelled.
    pub(super) fn layers(&self) -> Option<&BoundaryLayers> {
        self.modelled.as_ref().map(|modelled| &modelled.layers)
    }

    /// The same, to go on from.
    pub(super) fn layers_mut(&mut self) -> Option<&mut BoundaryLayers> {
        self.modelled.as_mut().map(|modelled| &mut modelled.layers)
    }

    /// Mass given back to the air since this was made, loss and gain alike.
    pub(super) const fn returned(&self) -> f64 {
        self.returned
    }

    /// Gives back what the air lost in the step at the sides where it slides, `rest` of each: to the side itself what it lost beyond what leaves along a plane; the sum of that in equal parts, by weight,
    /// to all sides that look at the same space.
    ///
    /// Along a plane wall in a uniform stream some sides lose what others gain. That must not come back to the side itself: the wall would be rough.
    pub(super) fn keep_mass(&mut self, links: &[CutLink], rest: &mut [[f64; 2]]) {
        let sums = &mut self.sums;
        sums.clear();
        sums.resize(self.spaces.count(), [0.0; 2]);
        let weight =
            |back: &Back| WEIGHTS[links[back.link as usize].leaving(usize::from(back.side))];
        for (back, space) in self.back.iter().zip(&self.space_of) {
            let [lost, weights] = &mut sums[*space as usize];
            *lost += back.along;
            *weights += weight(back);
        }
        for (back, space) in self.back.iter().zip(&self.space_of) {
            let [lost, weights] = sums[*space as usize];
            rest[back.link as usize][usize::from(back.side)] +=
                lost / weights * weight(back) - back.along;
        }
        self.returned += sums.iter().map(|[lost, _]| lost.abs()).sum::<f64>();
    }
}
