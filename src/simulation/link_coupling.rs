//! Fabric and rigid bodies that cut links of the lattice: SI on their side, lattice units on the air's ([`super::cut_surface`]).
//!
//! The scheme, in a step of the air from tⁿ to tⁿ⁺¹:
//!
//! 1. collide and stream; no force acts on the air;
//! 2. `find_links`: the links that the surfaces cut where they are;
//! 3. `read_links`: what left along them, which a device has to be asked for, and `fetch_links` takes;
//! 4. the fabric minimises inertia, elastic energy and the reactions of its cuts, which are affine in its velocity ([`crate::cpu::cloth::TriangleReaction`]);
//! 5. `bounce`: what comes back, with the velocity that the fabric now has. The air has what the fabric felt, to the solver's tolerance, at once.

mod saved;

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::air::AirEngine;
use super::bodies::Load;
use super::cut_bodies::{self, Body};
use super::cut_surface::CutSurface;
use super::on_device::OnDevice;
use crate::case::Scene;
use crate::case::coupling::Friction;
use crate::case::scene::Air;
use crate::cloth::covers::Cover;
use crate::cloth::patches::Patches;
use crate::cpu::cloth::{Cloth, MiddleReaction, TriangleReaction};
use crate::cut_links::{OutOfAir, Passage};
use crate::fabric::permeability::Permeability;
use crate::gpu::DeviceError;
use crate::lattice::nest::{CHANGED_BY_LAYERS, EXCHANGED_CELLS};
use crate::plan::{Plan, Stage};
use crate::units::Units;

/// Surfaces that cut the lattice: first that of the fabric, then what shuts its narrow openings, then those of the rigid bodies.
#[derive(Debug)]
pub struct LinkCoupling {
    units: Units,
    surface: CutSurface,
    /// Triangles of the fabric, and with those in its openings.
    woven_triangles: usize,
    fabric_triangles: usize,
    covers: Vec<Cover>,
    pub(super) bodies: Vec<Body>,
    /// Which body every triangle behind the fabric's belongs to.
    body_of: Vec<u32>,
    /// Which walls a device answers along by itself.
    pub(super) on_device: OnDevice,
    /// Links that were cut in the last step that a device made by itself.
    pub(super) found_on_device: Option<usize>,
    /// Of the nodes [cells, cells per step].
    pub(super) positions: Vec<DVec3>,
    pub(super) velocities: Vec<DVec3>,
    pub(super) reactions: Vec<TriangleReaction>,
    force_on_air: [f64; 3],
    fabric_force_on_air: [f64; 3],
    /// Of fabric that is held, where a device made the step by itself.
    held_force_on_air: Option<[f64; 3]>,
    loads: Vec<Load>,
    fastest: f64,
}

/// Triangles that shut openings through which air passes by a law.
fn covers_of(scene: &Scene, units: &Units) -> Vec<Cover> {
    let (Some(body), Some(coupling)) = (&scene.body, &scene.coupling) else {
        return Vec::new();
    };
    let structure = &body.structure;
    let covers = coupling.covers(structure, units.cell_size_m);
    covers.into_iter().flatten().flatten().collect()
}

/// Triangles that one task works on.
const TRIANGLES_AT_ONCE: usize = 128;

impl LinkCoupling {
    pub(super) fn new(scene: &Scene, air: &Air, engine: &AirEngine, plan: &Plan) -> Self {
        let units = air.units;
        let passage = |permeability: Option<Permeability>| {
            permeability.map_or(Passage::Shut, |permeability| {
                Passage::Fabric([
                    permeability.viscous_pa_s_m / (units.density_kg_m3 * units.speed_m_s()),
                    permeability.inertial_kg_m3 / units.density_kg_m3,
                ])
            })
        };
        let (mut triangles, mut passages) = (Vec::new(), Vec::new());
        let (mut positions_m, mut areas_m2) = (Vec::new(), Vec::new());
        if let Some(body) = &scene.body {
            let structure = &body.structure;
            triangles.extend(structure.triangles.iter().map(|t| t.nodes));
            areas_m2.extend(structure.triangles.iter().map(|t| t.rest_area_m2));
            passages.resize(triangles.len(), passage(structure.permeability));
            positions_m.clone_from(&structure.positions_m);
        }
        let woven_triangles = triangles.len();
        let patches = (scene.body.as_ref())
            .and_then(|body| Patches::new(&body.structure.triangles, units.cell_size_m));
        let covers = covers_of(scene, &units);
        triangles.extend(covers.iter().map(|cover| cover.nodes));
        passages.resize(triangles.len(), Passage::Opening);
        // They have no area that they were cut with.
        areas_m2.resize(triangles.len(), 0.0);
        let fabric_triangles = triangles.len();
        let (mut bodies, mut body_of) = (Vec::new(), Vec::new());
        for (number, body) in scene.rigid_bodies.iter().enumerate() {
            let surface = &body.surface;
            let first = positions_m.len() as u32;
            triangles.extend(surface.triangles.iter().map(|t| t.map(|n| n + first)));
            areas_m2.extend(surface.area_vectors_m2().map(DVec3::length));
            passages.resize(triangles.len(), passage(body.permeability));
            body_of.resize(triangles.len() - fabric_triangles, number as u32);
            positions_m.extend_from_slice(&surface.positions_m);
            bodies.push(Body {
                motion: body.motion.clone(),
                positions_m: surface.positions_m.clone(),
                moment_point_m: body.moment_point_m,
                nodes: first as usize..positions_m.len(),
            });
        }
        let modelled = (scene.friction.as_ref()).is_some_and(|f| f.has(Friction::Model));
        let kept = match air.depth() {
            0 => 0,
            _ => EXCHANGED_CELLS + if modelled { CHANGED_BY_LAYERS } else { 0 },
        };
        // Fabric stays inside; bodies may pass.
        let open_from = scene.passes_through_a_face().then_some(fabric_triangles);
        let cell_m2 = units.cell_size_m.powi(2);
        let areas: Vec<f64> = areas_m2.iter().map(|area_m2| area_m2 / cell_m2).collect();
        let nodes = positions_m.len();
        let lattice = |place_m| DVec3::from_array(units.position_to_lattice(place_m));
        let mut positions: Vec<DVec3> = positions_m.into_iter().map(lattice).collect();
        cut_bodies::place(&bodies, 0.0, lattice, &mut positions);
        let surface = CutSurface::new(engine, triangles, nodes, (kept, open_from));
        let surface = match plan.every(Stage::SolveCloth) {
            Some(_) => surface,
            None => surface.rigid(),
        };
        let surface = match &scene.friction {
            Some(friction) => {
                let of_each = scene.rigid_bodies.iter().zip(&friction.bodies);
                let of_bodies =
                    of_each.flat_map(|(body, own)| vec![*own; body.surface.triangles.len()]);
                let of_covers = vec![Friction::NoSlip; covers.len()];
                let of_fabric = friction.fabric.iter().copied().chain(of_covers);
                let all = of_fabric.chain(of_bodies);
                let stand = cut_bodies::standing(&bodies, &body_of, fabric_triangles, &positions);
                surface
                    .with_friction(all.collect(), friction.transition_reynolds, &positions)
                    .sticking_inside(&stand, &positions)
            }
            None => surface,
        };
        Self {
            units,
            surface: surface.permeable(&passages, &areas).sharing(patches),
            woven_triangles,
            fabric_triangles,
            covers,
            bodies,
            body_of,
            on_device: OnDevice::of(scene, plan),
            found_on_device: None,
            positions,
            velocities: vec![DVec3::ZERO; nodes],
            reactions: Vec::new(),
            force_on_air: [0.0; 3],
            fabric_force_on_air: [0.0; 3],
            held_force_on_air: None,
            loads: vec![Load::default(); scene.rigid_bodies.len()],
            fastest: 0.0,
        }
    }

    /// The scales.
    #[must_use]
    pub const fn units(&self) -> &Units {
        &self.units
    }

    /// The surfaces in the lattice.
    #[must_use]
    pub const fn surface(&self) -> &CutSurface {
        &self.surface
    }

    /// Links that are cut now.
    pub(super) fn link_count(&self) -> usize {
        (self.found_on_device).unwrap_or_else(|| self.surface.links().len())
    }

    pub(super) const fn surface_mut(&mut self) -> &mut CutSurface {
        &mut self.surface
    }

    /// Total force on the air of the last `bounce` [lattice units].
    #[must_use]
    pub const fn force_on_air(&self) -> [f64; 3] {
        self.force_on_air
    }

    /// That of the fabric alone.
    #[must_use]
    pub const fn fabric_force_on_air(&self) -> [f64; 3] {
        self.fabric_force_on_air
    }

    /// What the last `bounce` did to every rigid body [lattice units].
    #[must_use]
    pub fn body_loads(&self) -> &[Load] {
        &self.loads
    }

    /// Places of the nodes of triangles [cells].
    pub(super) fn positions(&self) -> Vec<[f64; 3]> {
        let nodes = self.surface.triangles().iter().flatten();
        nodes
            .map(|node| self.positions[*node as usize].to_array())
            .collect()
    }

    /// Force on the air by fabric that is held, by the shares of held nodes [lattice units].
    pub(super) fn held_force_on_air(&self, cloth: &Cloth) -> [f64; 3] {
        if let Some(known) = self.held_force_on_air {
            return known;
        }
        let held = &cloth.structure.held;
        let mut sum = DVec3::ZERO;
        for (cut, force) in self.surface.forces() {
            if cut.triangle as usize >= self.fabric_triangles {
                continue;
            }
            sum += force * self.surface.share_of(held, cut);
        }
        sum.to_array()
    }

    /// Nodes as they are at `time_s`.
    pub(super) fn place(&mut self, cloth: Option<&Cloth>, time_s: f64) {
        let lattice = |place_m| DVec3::from_array(self.units.position_to_lattice(place_m));
        if let Some(cloth) = cloth {
            for (position, place_m) in self.positions.iter_mut().zip(&cloth.positions_m) {
                *position = lattice(*place_m);
            }
        }
        cut_bodies::place(&self.bodies, time_s, lattice, &mut self.positions);
    }

    /// Stage `find_links`, for fabric where it stands, and bodies where they are at `time_s`.
    pub(super) fn find_links(
        &mut self,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<(), OutOfAir> {
        self.place(cloth, time_s);
        if self.on_device == OnDevice::Moving {
            return self.surface.move_to(&self.positions);
        }
        self.surface.find_links(&self.positions)
    }

    /// Goes on on another lattice, with what was known of the air and of the loads on the one `before`, in SI units.
    pub(super) fn go_on(
        &mut self,
        before: &Self,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<(), OutOfAir> {
        let scale = |of: fn(&Units) -> f64| of(&before.units) / of(&self.units);
        let [pressure, force] = [scale(Units::pressure_pa), scale(Units::force_n)];
        let [speed, length] = [scale(Units::speed_m_s), scale(|units| units.cell_size_m)];
        let excess = before.surface.face_pressures().iter();
        let excess = excess.map(|faces| faces.map(|face| face * pressure));
        let layers = before.surface.boundary_layers();
        let (layers, steps_left) = layers.map_or_else(Default::default, |layers| {
            let saved = layers.saved_for([speed, length]);
            (self.of_own_faces(before, saved), layers.steps_left())
        });
        self.place(cloth, time_s);
        let places = self.positions.clone();
        self.surface
            .go_on(excess.collect(), (&layers, steps_left), places);
        let scaled = |vector: [f64; 3], by: f64| vector.map(|component| component * by);
        self.force_on_air = scaled(before.force_on_air, force);
        self.fabric_force_on_air = scaled(before.fabric_force_on_air, force);
        for (load, old) in self.loads.iter_mut().zip(&before.loads) {
            load.force = scaled(old.force, force);
            load.moment = scaled(old.moment, force * length);
        }
        self.take_velocities(cloth, time_s, true);
        self.find_links(cloth, time_s)
    }

    /// What both faces of every triangle had on another lattice, with other openings shut.
    fn of_own_faces<T: Default + Clone>(&self, before: &Self, mut of: Vec<T>) -> Vec<T> {
        let covers = vec![T::default(); 2 * self.covers.len()];
        of.splice(
            2 * before.woven_triangles..2 * before.fabric_triangles,
            covers,
        );
        of
    }

    /// Stage `read_links`; on the host, where nothing has to be fetched, `fetch_links` with it.
    pub(super) fn read_links(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        match (self.on_device, &*air) {
            (OnDevice::Standing, _) => return self.read_walls(air),
            (OnDevice::Moving, AirEngine::Gpu(fluid)) => return fluid.read_moving_walls(),
            _ => {}
        }
        self.surface.read_links(air)?;
        match air {
            AirEngine::Gpu(_) => Ok(()),
            _ => self.fetch_links(air),
        }
    }

    /// Stage `fetch_links`.
    pub(super) fn fetch_links(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        self.surface.fetch_links(air, &self.velocities)
    }

    /// The triangles of the fabric as it feels them in this solve.
    pub(super) fn reactions(&self) -> &[TriangleReaction] {
        &self.reactions
    }

    /// Leaves them to a device.
    pub(super) fn forget_reactions(&mut self) {
        self.reactions.clear();
    }

    /// Makes them from what was read.
    pub(super) fn gather_reactions(&mut self) {
        self.surface.sort_cuts();
        let (stiffness_kg_s, force_n) = (self.units.stiffness_kg_s(), self.units.force_n());
        let (surface, cuts) = (&self.surface, self.surface.sorted_cuts());
        let of_fabric = |triangle: &u32| (*triangle as usize) < self.woven_triangles;
        let count = cuts.triangles().partition_point(of_fabric);
        let own = |triangle: u32| {
            let mut sum = TriangleReaction::none(triangle);
            for &(link, side) in cuts.of(triangle) {
                let (cut, reaction) = surface.reaction(link as usize, usize::from(side));
                sum.add(
                    cut.weights,
                    reaction.leaving,
                    [reaction.stiffness * stiffness_kg_s, reaction.push * force_n],
                );
                if let Some(friction) = surface.friction(link as usize, usize::from(side)) {
                    sum.add_force(cut.weights, friction * force_n);
                }
            }
            sum
        };
        let cut = &cuts.triangles()[..count];
        match surface.patches() {
            None => (cut.par_iter())
                .with_min_len(TRIANGLES_AT_ONCE)
                .map(|&triangle| own(triangle))
                .collect_into_vec(&mut self.reactions),
            Some(patches) => {
                let middles = self.middle_reactions(cut, [stiffness_kg_s, force_n]);
                self.reactions = (0..self.woven_triangles as u32)
                    .into_par_iter()
                    .with_min_len(TRIANGLES_AT_ONCE)
                    .filter_map(|triangle| {
                        if !patches.shares(triangle) {
                            let is_cut = !cuts.of(triangle).is_empty();
                            return is_cut.then(|| own(triangle));
                        }
                        let mut sum = TriangleReaction::none(triangle);
                        let mut touched = false;
                        for (from, share) in patches.received(triangle) {
                            if let (Some(middle), true) = (&middles[from as usize], share > 0.0) {
                                sum.add_middle(middle, share);
                                touched = true;
                            }
                        }
                        touched.then_some(sum)
                    })
                    .collect();
            }
        }
        self.hand_on([stiffness_kg_s, force_n]);
    }

    /// What the air does to every triangle at its middle; nothing where it has no cuts.
    fn middle_reactions(
        &self,
        cut: &[u32],
        [stiffness_kg_s, force_n]: [f64; 2],
    ) -> Vec<Option<MiddleReaction>> {
        let (surface, cuts) = (&self.surface, self.surface.sorted_cuts());
        let mut middles = vec![None; self.woven_triangles];
        let found: Vec<MiddleReaction> = (cut.par_iter())
            .with_min_len(TRIANGLES_AT_ONCE)
            .map(|&triangle| {
                let mut sum = MiddleReaction::NONE;
                for &(link, side) in cuts.of(triangle) {
                    let (_, reaction) = surface.reaction(link as usize, usize::from(side));
                    let scales = [reaction.stiffness * stiffness_kg_s, reaction.push * force_n];
                    sum.add(reaction.leaving, scales);
                    if let Some(friction) = surface.friction(link as usize, usize::from(side)) {
                        sum.pull_n += friction * force_n;
                    }
                }
                sum
            })
            .collect();
        for (triangle, middle) in cut.iter().zip(found) {
            middles[*triangle as usize] = Some(middle);
        }
        middles
    }

    /// Hands what the air does in openings on to the fabric at their rims.
    fn hand_on(&mut self, [stiffness_kg_s, force_n]: [f64; 2]) {
        let (surface, cuts) = (&self.surface, self.surface.sorted_cuts());
        let mut handed: BTreeMap<u32, TriangleReaction> = BTreeMap::new();
        for (number, cover) in (self.woven_triangles as u32..).zip(&self.covers) {
            for &(link, side) in cuts.of(number) {
                let (cut, reaction) = surface.reaction(link as usize, usize::from(side));
                // Its corners take their shares of it one by one.
                for ((triangle, corner), share) in cover.at.into_iter().zip(cut.weights) {
                    if share == 0.0 {
                        continue;
                    }
                    let mut weights = [0.0; 3];
                    weights[usize::from(corner)] = 1.0;
                    let scales = [reaction.stiffness * stiffness_kg_s, reaction.push * force_n];
                    (handed.entry(triangle))
                        .or_insert_with(|| TriangleReaction::none(triangle))
                        .add(weights, reaction.leaving, scales.map(|of| of * share));
                }
            }
        }
        for (triangle, reaction) in handed {
            let known = (self.reactions).binary_search_by_key(&triangle, |known| known.triangle);
            match known {
                Ok(place) => self.reactions[place].add_reaction(&reaction),
                Err(place) => self.reactions.insert(place, reaction),
            }
        }
    }

    /// Velocities of a step that ends at `time_s`; before release all is held.
    pub(super) fn take_velocities(&mut self, cloth: Option<&Cloth>, time_s: f64, released: bool) {
        if !released {
            self.velocities.fill(DVec3::ZERO);
            self.fastest = 0.0;
            return;
        }
        let lattice = |v_m_s| DVec3::from_array(self.units.velocity_to_lattice(v_m_s));
        if let Some(cloth) = cloth {
            for (v, v_m_s) in self.velocities.iter_mut().zip(&cloth.velocities_m_s) {
                *v = lattice(*v_m_s);
            }
        }
        for body in &self.bodies {
            let placement = body.motion.at(time_s);
            let nodes = &mut self.velocities[body.nodes.clone()];
            for (v, &place_m) in nodes.iter_mut().zip(&body.positions_m) {
                *v = lattice(placement.velocity_m_s(place_m));
            }
        }
        // Lines and payload do not touch the air here.
        let nodes = self.surface.triangles().iter().flatten();
        let squares = nodes.map(|node| self.velocities[*node as usize].length_squared());
        self.fastest = squares.fold(0.0, f64::max).sqrt();
    }

    /// Stage `bounce`.
    pub(super) fn bounce(
        &mut self,
        air: &mut AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
        released: bool,
    ) -> Result<(), DeviceError> {
        if let (AirEngine::Gpu(fluid), true) = (&mut *air, self.on_device.answers()) {
            return fluid.answer_walls();
        }
        (self.held_force_on_air, self.found_on_device) = (None, None);
        self.take_velocities(cloth, time_s, released);
        self.surface.bounce(air, &self.velocities)?;
        self.sum_forces(time_s);
        Ok(())
    }

    /// Moment points of the bodies at `time_s` [cells].
    pub(super) fn moment_points(&self, time_s: f64) -> Vec<DVec3> {
        (self.bodies.iter())
            .map(|body| {
                let place_m = body.motion.at(time_s).position_m(body.moment_point_m);
                DVec3::from_array(self.units.position_to_lattice(place_m))
            })
            .collect()
    }

    /// Number of the body that a triangle belongs to; `None` for fabric.
    pub(super) fn body_of(&self, triangle: u32) -> Option<usize> {
        let of_body = (triangle as usize).checked_sub(self.fabric_triangles)?;
        Some(self.body_of[of_body] as usize)
    }

    /// Takes what a device found that the air did to the fabric, and to every body; nothing where no link is cut.
    pub(super) fn take_loads(&mut self, mut loads: impl Iterator<Item = Load>) {
        let of_fabric = loads.next().unwrap_or_default();
        self.loads.fill(Load::default());
        for (own, load) in self.loads.iter_mut().zip(loads) {
            *own = load;
        }
        self.fabric_force_on_air = of_fabric.force.map(|force| -force);
        let of_bodies = self.loads.iter().map(|load| DVec3::from_array(load.force));
        let all = DVec3::from_array(of_fabric.force) + of_bodies.sum::<DVec3>();
        self.force_on_air = (-all).to_array();
    }

    /// Takes what a step of a device's own did to the air: all of the fabric, and that of it which is held [lattice units].
    pub(super) const fn take_forces(&mut self, all: [f64; 3], of_held: [f64; 3]) {
        (self.force_on_air, self.fabric_force_on_air) = (all, all);
        self.held_force_on_air = Some(of_held);
    }

    /// Adds the forces up.
    fn sum_forces(&mut self, time_s: f64) {
        let points = self.moment_points(time_s);
        let of_part = |links: Range<usize>| {
            let (mut total, mut of_fabric) = (DVec3::ZERO, DVec3::ZERO);
            let mut loads = vec![Load::default(); points.len()];
            self.surface.each_force(links, |cut, force| {
                total += force;
                let Some(body) = self.body_of(cut.triangle) else {
                    of_fabric += force;
                    return;
                };
                let arm = self.surface.at(cut, &self.positions) - points[body];
                loads[body].add(&Load {
                    force: (-force).to_array(),
                    moment: (-arm.cross(force)).to_array(),
                });
            });
            (total, of_fabric, loads)
        };
        let parts: Vec<_> = self.surface.parts().map(of_part).collect();
        self.loads.fill(Load::default());
        let (mut total, mut of_fabric) = (DVec3::ZERO, DVec3::ZERO);
        for (part, part_of_fabric, loads) in parts {
            total += part;
            of_fabric += part_of_fabric;
            for (sum, load) in self.loads.iter_mut().zip(&loads) {
                sum.add(load);
            }
        }
        self.force_on_air = total.to_array();
        self.fabric_force_on_air = of_fabric.to_array();
    }

    /// Fastest node of a surface [cells per step].
    #[must_use]
    pub const fn fastest_marker(&self) -> f64 {
        self.fastest
    }

    /// Fastest node of the fabric as it moves now [cells per step].
    pub(super) fn fastest_of_fabric(&self, cloth: &Cloth) -> f64 {
        let nodes = self.surface.triangles()[..self.fabric_triangles]
            .iter()
            .flatten();
        let speeds = nodes.map(|node| cloth.velocities_m_s[*node as usize].length());
        speeds.fold(0.0, f64::max) / self.units.speed_m_s()
    }

    /// Mean velocity of the air through what is permeable [m/s]; `None` where nothing is.
    #[must_use]
    pub fn through_velocity_m_s(&self) -> Option<f64> {
        let through = self.surface.mean_through()?;
        Some(through * self.units.speed_m_s())
    }
}
