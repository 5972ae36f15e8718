//! Parts of a surface that cuts links along which the air slides ([`crate::cut_links::slide`]), and boundary layers that are modelled there.

use std::ops::Range;

use glam::DVec3;

use crate::case::coupling::Friction;
use crate::cut_links::boundary_layer::Shape;
use crate::cut_links::images::Asked;
use crate::cut_links::slide::{self, Slides};
use crate::cut_links::spaces::Spaces;
use crate::cut_links::{
    BoundaryLayers, CellState, CellStates, ChangedByPair, CutLinks, Domain, Images, Reflections,
    Return, Stress,
};
use crate::lattice::Real;

/// How the air slides along the surface.
#[derive(Debug)]
pub(super) struct Sliding {
    /// Of the triangles.
    friction: Vec<Friction>,
    /// By face, whether it looks at air that a body at rest shuts in; empty where none does.
    shut_in: Vec<bool>,
    images: Images,
    /// Of the cells of the images, and how many of these are asked in this step.
    states: CellStates,
    asked: usize,
    reflections: Reflections,
    spaces: Spaces,
    /// `None` where no boundary layer is modelled.
    modelled: Option<Modelled>,
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
            states: CellStates::default(),
            asked: 0,
            reflections: Reflections::default(),
            spaces: Spaces::new(triangles, positions, |middle| domain.goes_round(middle)),
            modelled: BoundaryLayers::new(modelled, layers.viscosity, layers.transition_reynolds)
                .map(|layers| Modelled {
                    layers,
                    march: false,
                    stress: Stress::default(),
                    taken: false,
                }),
            friction,
            shut_in: Vec::new(),
        })
    }

    /// The air that bodies at rest shut in stands, whether it slides or not: it sticks, which asks for no images. These are `triangles` of closed bodies, with nothing else inside.
    pub(super) fn stick_inside(
        &mut self,
        bodies: &[Range<usize>],
        (triangles, positions): (&[[u32; 3]], &[DVec3]),
    ) {
        if bodies.is_empty() {
            return;
        }
        let shut_in = self.spaces.shut_in(triangles, positions);
        self.shut_in = vec![false; 2 * triangles.len()];
        for face in bodies.iter().flat_map(|body| 2 * body.start..2 * body.end) {
            self.shut_in[face] = shut_in[self.spaces.of(face)];
        }
    }

    /// Lays the images out for what the surface cuts.
    pub(super) fn find(&mut self, links: &CutLinks, domain: &Domain, normals: &[DVec3]) {
        let (friction, shut_in, spaces) = (&self.friction, &self.shut_in, &self.spaces);
        self.images.find(links, domain, |link, side| {
            let triangle = link.cuts[side].triangle as usize;
            if friction[triangle] == Friction::NoSlip {
                return None;
            }
            let normal = normals[triangle];
            let face = slide::face(link, side, normal);
            let is_inside = !shut_in.is_empty() && shut_in[face];
            (!is_inside).then(|| Slides {
                normal,
                space: spaces.of(face) as u32,
                modelled: friction[triangle] == Friction::Model,
            })
        });
        if let Some(modelled) = &mut self.modelled {
            modelled.stress.find(links, domain, &self.images);
            modelled.taken = false;
        }
    }

    /// Images of the links.
    pub(super) const fn images(&self) -> &Images {
        &self.images
    }

    /// At which sides of every link the air sticks.
    pub(super) fn stick(&self) -> &[[bool; 2]] {
        self.images.stick()
    }

    /// Begins a step. Returns the cells that are asked what left them, how many of them (from the first on) are asked in this step, and room for the answers. With `on_device` a
    /// device answers, which keeps its own list of cells.
    pub(super) fn read(&mut self, on_device: bool) -> (&[[i32; 3]], usize, &mut CellStates) {
        let mut asked = if on_device {
            Asked::Near
        } else {
            Asked::Images
        };
        if let Some(modelled) = &mut self.modelled {
            modelled.march = modelled.layers.count_step();
            if modelled.march {
                asked = Asked::Further;
            }
        }
        self.asked = self.images.cells(asked).len();
        let cells = self.images.cells(Asked::Further);
        (cells, self.asked, &mut self.states)
    }

    /// How many cells were asked in this step, and room for the answers.
    pub(super) const fn asked(&mut self) -> (usize, &mut CellStates) {
        (self.asked, &mut self.states)
    }

    /// Puts what comes back where the air slides into `returns`; `velocity` is that of the wall at a side of a link.
    pub(super) fn answer(
        &mut self,
        shape: (&[[u32; 3]], &[DVec3], &[DVec3]),
        velocity: impl Fn(usize, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        let states = std::mem::take(&mut self.states);
        match states.as_double() {
            [] => self.answer_by(states.as_single(), shape, velocity, returns),
            cells => self.answer_by(cells, shape, velocity, returns),
        }
        self.states = states;
    }

    fn answer_by<R: Real>(
        &mut self,
        cells: &[CellState<R>],
        (triangles, positions, normals): (&[[u32; 3]], &[DVec3], &[DVec3]),
        velocity: impl Fn(usize, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        let images = &self.images;
        if let Some(modelled) = &mut self.modelled {
            if modelled.march {
                let shape = Shape {
                    triangles,
                    positions,
                    normals,
                    spaces: &self.spaces,
                };
                let seen = |face| images.seen(face, cells, &velocity);
                modelled.layers.march(shape, seen);
                modelled.taken = false;
            }
            if !modelled.taken {
                (modelled.stress).take(returns.len(), images, &modelled.layers);
                modelled.taken = true;
            }
        }
        (self.reflections).put(images, cells, velocity, returns);
    }

    /// States of the cells of the images as a device has them, and the populations that lose the stress of modelled layers in this step.
    pub(super) fn changed(&self) -> (&[CellState<f32>], &ChangedByPair) {
        let changed = (self.modelled.as_ref()).map_or(NOTHING, |m| m.stress.changed());
        (self.states.as_single(), changed)
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
        self.reflections.returned()
    }

    /// Gives back what the air lost in the step at the sides where it slides, `rest` of each.
    pub(super) fn keep_mass(&mut self, rest: &mut [[f64; 2]]) {
        self.reflections.keep_mass(&self.images, rest);
    }
}
