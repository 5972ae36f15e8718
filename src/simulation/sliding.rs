//! Parts of a surface that cuts links along which the air slides, and the mass that it owes the air there ([`crate::cut_links::slide`]).

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::case::coupling::Friction;
use crate::cut_links::boundary_layer::Shape;
use crate::cut_links::cell_numbers::CellNumbers;
use crate::cut_links::energy::Energy;
use crate::cut_links::slide::{self, Asked, Loss, Slides};
use crate::cut_links::spaces::Spaces;
use crate::cut_links::{
    BoundaryLayers, ChangedByPair, CutLinks, Domain, Images, Leaving, Return, Stress,
};
use crate::lattice::WEIGHTS;

/// Edge of the blocks of cells whose links share among them what they lose beyond what passes along a plane, and which give the air as much energy as along one [cells].
///
/// A link that gets its own loss back is rough, the whole wall is too far off. Of a section of 24 cells lift was 7, 4, 2 % too low with blocks of 1, 2, 4 cells
/// before energy was held; it had a thrust of 0.000, 0.004 and 0.010 (docs/results/2026-11-27-thrust-of-sliding-walls.md).
const BLOCK: i32 = 4;

/// Cut links of a cell from which on it shares with no other, half of all: in tight folds it would fill up (docs/results/2026-11-26-sliding-in-creases.md).
const CROWDED: u32 = 9;

/// How the air slides along the surface.
#[derive(Debug)]
pub(super) struct Sliding {
    /// Of the triangles.
    friction: Vec<Friction>,
    /// By face, whether it looks at air that a body at rest shuts in; empty where none does.
    shut_in: Vec<bool>,
    images: Images,
    /// What left the cells of the images.
    leaving: Vec<Leaving>,
    /// By link and side.
    losses: Vec<[Loss; 2]>,
    /// By space, what passes along planes there, and by which weight in all.
    of_spaces: Vec<[f64; 2]>,
    spaces: Spaces,
    /// Sides that slide, in the order of links.
    sides: Vec<Side>,
    /// How many links are cut at every cell, less one.
    cut: CellNumbers,
    /// `None` where no boundary layer is modelled.
    modelled: Option<Modelled>,
    /// Numbers of sides in the order of their blocks, and where those of a block begin; one more at the end.
    of_blocks: Vec<u32>,
    blocks: Vec<u32>,
    /// By block, by which share what slides comes back.
    shares: Vec<f64>,
    /// What every side gives back.
    given: Vec<f64>,
    returned: f64,
}

/// Sides that one task works on; part of the result, since sums are rounded part by part.
const SIDES_AT_ONCE: usize = 2048;

/// Blocks that one task works on.
const BLOCKS_AT_ONCE: usize = 64;

/// A side of a link along which the air slides.
#[derive(Debug, Clone, Copy)]
struct Side {
    link: u32,
    side: u8,
    /// Numbers of the space that it looks at, and of its block.
    groups: [u32; 2],
    /// Of the direction.
    weight: f64,
}

impl Side {
    /// Its link, and which side of it this is.
    fn place(&self) -> (usize, usize) {
        (self.link as usize, usize::from(self.side))
    }
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
            losses: Vec::new(),
            of_spaces: Vec::new(),
            spaces: Spaces::new(triangles, positions, |middle| domain.goes_round(middle)),
            sides: Vec::new(),
            cut: CellNumbers::default(),
            modelled: BoundaryLayers::new(modelled, layers.viscosity, layers.transition_reynolds)
                .map(|layers| Modelled {
                    layers,
                    march: false,
                    stress: Stress::default(),
                    taken: false,
                }),
            friction,
            shut_in: Vec::new(),
            of_blocks: Vec::new(),
            blocks: Vec::new(),
            shares: Vec::new(),
            given: Vec::new(),
            returned: 0.0,
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
        let (friction, shut_in) = (&self.friction, &self.shut_in);
        self.images.find(links, domain, |link, side| {
            let triangle = link.cuts[side].triangle as usize;
            let normal = normals[triangle];
            let is_inside = || !shut_in.is_empty() && shut_in[slide::face(link, side, normal)];
            (friction[triangle] != Friction::NoSlip && !is_inside()).then(|| Slides {
                normal,
                modelled: friction[triangle] == Friction::Model,
            })
        });
        if let Some(modelled) = &mut self.modelled {
            modelled.stress.find(links, domain, &self.images);
            modelled.taken = false;
        }
        let (links, spaces) = (links.links(), &self.spaces);
        let cut = &mut self.cut;
        cut.lay(links.iter().flat_map(|link| link.cells));
        for cell in links.iter().flat_map(|link| link.cells) {
            if let Some(count) = cut.entry(cell) {
                *count = count.wrapping_add(1);
            }
        }
        let mut blocks: FxHashMap<(u32, [i32; 3]), u32> = FxHashMap::default();
        let side = |(number, side): (usize, usize)| {
            let link = &links[number];
            let normal = normals[link.cuts[side].triangle as usize];
            let space = spaces.of(slide::face(link, side, normal)) as u32;
            let cell = link.cells[side];
            let block = if cut.get(cell).is_some_and(|cut| cut + 1 >= CROWDED) {
                (u32::MAX, cell)
            } else {
                (space, cell.map(|place| place.div_euclid(BLOCK)))
            };
            let next = blocks.len() as u32;
            Side {
                link: number as u32,
                side: side as u8,
                groups: [space, *blocks.entry(block).or_insert(next)],
                weight: WEIGHTS[link.leaving(side)],
            }
        };
        self.sides.clear();
        self.sides.extend(self.images.sides().map(side));
        // Sides by blocks, within one in their order.
        self.blocks.clear();
        self.blocks.resize(blocks.len() + 1, 0);
        for side in &self.sides {
            self.blocks[side.groups[1] as usize + 1] += 1;
        }
        for number in 0..blocks.len() {
            self.blocks[number + 1] += self.blocks[number];
        }
        self.of_blocks.clear();
        self.of_blocks.resize(self.sides.len(), 0);
        let mut next = self.blocks.clone();
        for (number, side) in (0..).zip(&self.sides) {
            let next = &mut next[side.groups[1] as usize];
            self.of_blocks[*next as usize] = number;
            *next += 1;
        }
    }

    /// Begins a step. Returns the cells that are asked what left them, how many of them (from the first on) are asked in this step, and room for the answers. With `on_device` a
    /// device answers, which keeps its own list of cells.
    pub(super) fn read(&mut self, on_device: bool) -> (&[[i32; 3]], usize, &mut Vec<Leaving>) {
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
        let count = self.images.cells(asked).len();
        (self.images.cells(Asked::Further), count, &mut self.leaving)
    }

    /// Puts what comes back where the air slides into `returns`; `velocity` is that of the wall at a side of a link.
    pub(super) fn answer(
        &mut self,
        (triangles, positions, normals): (&[[u32; 3]], &[DVec3], &[DVec3]),
        velocity: impl Fn(usize, usize) -> DVec3 + Sync,
        returns: &mut [[Return; 2]],
    ) {
        let (images, leaving) = (&mut self.images, &self.leaving);
        images.take(leaving);
        if let Some(modelled) = &mut self.modelled {
            if modelled.march {
                let shape = Shape {
                    triangles,
                    positions,
                    normals,
                    spaces: &self.spaces,
                };
                let seen = |face| images.seen(face, &velocity);
                modelled.layers.march(shape, seen);
                modelled.taken = false;
            }
            if !modelled.taken {
                (modelled.stress).take(returns.len(), images, &modelled.layers);
                modelled.taken = true;
            }
        }
        images.returned(leaving, velocity, returns, &mut self.losses);
        self.hold_energy(returns);
        self.sum_spaces();
        self.carry(returns);
    }

    /// Lets less slide in blocks where the wall would give the air more energy than along a plane, and more where it would give less.
    ///
    /// Populations of images are copies: where the air at the image has more energy than at the wall, energy comes from nowhere. Round a nose that was a thrust
    /// (docs/results/2026-11-28-energy-of-sliding-walls.md). Where it has less, walls brake
    /// (docs/results/2026-11-28-walls-that-take-no-energy.md).
    fn hold_energy(&mut self, returns: &mut [[Return; 2]]) {
        let (sides, losses) = (&self.sides, &self.losses);
        (self.blocks.par_windows(2))
            .with_min_len(BLOCKS_AT_ONCE)
            .map(|bounds| {
                let mut energy = Energy::default();
                for side in &self.of_blocks[bounds[0] as usize..bounds[1] as usize] {
                    let (link, of_link) = sides[*side as usize].place();
                    energy += losses[link][of_link].energy;
                }
                energy.share()
            })
            .collect_into_vec(&mut self.shares);
        let shares = &self.shares;
        self.images
            .change((returns, &mut self.losses), |side, back, loss| {
                let share = shares[sides[side].groups[1] as usize];
                if share != 1.0 {
                    back.blend(share);
                    loss.blend(share);
                }
            });
    }

    /// What is given back arrives with the velocity u of the air along the wall: of a mass m, −3 m d·u comes along −d, the rest of it at rest. It follows from what links lose where the wall
    /// goes on as it moves, so that the fabric knows of it in its step.
    fn carry(&mut self, returns: &mut [[Return; 2]]) {
        self.share(|_, loss| loss.all);
        for (side, given) in self.sides.iter().zip(&self.given) {
            let (link, of_link) = side.place();
            returns[link][of_link].further -= 3.0 * given * self.losses[link][of_link].velocity;
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

    /// Gives back what the air lost in the step at the sides where it slides, `rest` of each: what leaves along a plane in equal parts, by weight, to all sides that look at the same space, what is lost
    /// beyond it to those of the same block.
    ///
    /// Along a plane wall in a uniform stream some sides lose what others gain. That must not come back to the side itself: the wall would be rough.
    pub(super) fn keep_mass(&mut self, rest: &mut [[f64; 2]]) {
        self.share(|(link, side), _| rest[link][side]);
        self.returned += (self.of_spaces.iter())
            .map(|[lost, _]| lost.abs())
            .sum::<f64>();
        for (side, given) in self.sides.iter().zip(&self.given) {
            let (link, of_link) = side.place();
            rest[link][of_link] = *given;
        }
    }

    /// Sums up what passes along planes.
    fn sum_spaces(&mut self) {
        let (sides, losses) = (&self.sides, &self.losses);
        let parts: Vec<Vec<[f64; 2]>> = (sides.par_chunks(SIDES_AT_ONCE))
            .map(|sides| {
                let mut sums = vec![[0.0; 2]; self.spaces.count()];
                for side in sides {
                    let (link, of_link) = side.place();
                    let sum = &mut sums[side.groups[0] as usize];
                    sum[0] += losses[link][of_link].along;
                    sum[1] += side.weight;
                }
                sums
            })
            .collect();
        self.of_spaces.clear();
        self.of_spaces.resize(self.spaces.count(), [0.0; 2]);
        for part in &parts {
            for (sum, part) in self.of_spaces.iter_mut().zip(part) {
                sum[0] += part[0];
                sum[1] += part[1];
            }
        }
    }

    /// Lays out what every side gets of what all have `lost`.
    fn share(&mut self, lost: impl Fn((usize, usize), &Loss) -> f64 + Sync) {
        let (sides, losses, of_spaces) = (&self.sides, &self.losses, &self.of_spaces);
        let share = |[lost, weight]: [f64; 2]| lost / weight.max(f64::MIN_POSITIVE);
        let of_blocks: Vec<f64> = (self.blocks.par_windows(2))
            .with_min_len(BLOCKS_AT_ONCE)
            .map(|bounds| {
                let mut sum = [0.0; 2];
                for side in &self.of_blocks[bounds[0] as usize..bounds[1] as usize] {
                    let side = &sides[*side as usize];
                    let (link, of_link) = side.place();
                    let loss = &losses[link][of_link];
                    sum[0] += lost((link, of_link), loss) - loss.along;
                    sum[1] += side.weight;
                }
                share(sum)
            })
            .collect();
        (sides.par_iter())
            .with_min_len(SIDES_AT_ONCE)
            .map(|side| {
                let [space, block] = side.groups.map(|number| number as usize);
                (share(of_spaces[space]) + of_blocks[block]) * side.weight
            })
            .collect_into_vec(&mut self.given);
    }
}
