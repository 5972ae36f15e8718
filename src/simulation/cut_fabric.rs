//! Steps that a device makes by itself of fabric that cuts links of its air ([`super::device_alone`]): it places the nodes among the cells, finds the links, forms what the air does to every
//! triangle, solves, and answers along the links ([`crate::gpu::fluid::moving_walls`], `gpu/cloth/cut_fabric.rs`). Every step leaves its nodes and reactions on the device, from which the host
//! makes up its accounts.

use glam::{DMat3, DVec3};

use super::air::AirEngine;
use super::cloth::step_input;
use super::cloth_engine::ClothEngine;
use super::own_steps::ROOM;
use super::surface_box::within;
use super::{Coupled, Failure, LinkCoupling, Simulation};
use crate::cloth::Triangle;
use crate::cpu::cloth::{Cloth, TriangleReaction};
use crate::cut_links::search::GENERAL_POSITION;
use crate::gpu::cloth::{AirScales, AtCuts};
use crate::gpu::fluid::Fluid;
use crate::gpu::fluid::moving_answers::{MovingWalls, trouble};
use crate::gpu::{DeviceError, DeviceWork};
use crate::plan::Stage;

/// Factor by which fabric may grow within a series beyond its area where that begins, or as it was cut, before its links find no room.
const GROWTH: f64 = 1.5;

/// A block (xx, yy, zz, xy, xz, yz).
fn symmetric([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(xx, xy, xz),
        DVec3::new(xy, yy, yz),
        DVec3::new(xz, yz, zz),
    )
}

impl AtCuts {
    /// What the air does to a triangle, of so many; `None` where it cuts nothing. The constant part of its energy is left out.
    fn reaction(&self, triangle: usize, count: usize) -> Option<TriangleReaction> {
        let of = |words: &[f32], word: usize| f64::from(words[word * count + triangle]);
        let block = |pair: usize| {
            symmetric(std::array::from_fn(|word| {
                of(&self.stiffness_kg_s, 6 * pair + word)
            }))
        };
        let pull = |corner: usize| {
            DVec3::from_array(std::array::from_fn(|axis| {
                of(&self.pull_n, 3 * corner + axis)
            }))
        };
        let reaction = TriangleReaction {
            triangle: triangle as u32,
            stiffness_kg_s: std::array::from_fn(block),
            pull_n: std::array::from_fn(pull),
            rest_w: 0.0,
        };
        (reaction.stiffness_kg_s != [DMat3::ZERO; 6]).then_some(reaction)
    }
}

impl LinkCoupling {
    /// Has a device make steps of the fabric by itself; false where a step needs more of the host.
    pub(super) fn follow(
        &self,
        cloth: &Cloth,
        engine: &mut ClothEngine,
    ) -> Result<bool, DeviceError> {
        let units = self.units();
        let moved_m = GENERAL_POSITION * units.cell_size_m;
        let air = AirScales {
            first_centre_m: units.position_m([0.0; 3]) - moved_m,
            cell_size_m: units.cell_size_m,
            speed_m_s: units.speed_m_s(),
            stiffness_kg_s: units.stiffness_kg_s(),
            force_n: units.force_n(),
        };
        engine.follow_cuts(cloth, (&air, self.surface().patches()))
    }

    /// Takes where the fabric stands, in the air or not.
    fn stand(&mut self, cloth: &Cloth) -> bool {
        self.place(Some(cloth), 0.0);
        let positions = std::mem::take(&mut self.positions);
        let inside = self.surface_mut().move_to(&positions).is_ok();
        self.positions = positions;
        inside
    }

    /// Cells that the fabric has room to move in during a series of steps; 0 where it has none.
    fn room(&self) -> u32 {
        let [low, high] = self.surface().reach();
        let [first, end] = self.surface().cells_for_surfaces();
        let of_axis = |a: usize| (low[a] - first[a]).min(end[a] - 1 - high[a]) - 1;
        let room = (0..3).map(of_axis).min().unwrap_or_default();
        (room.max(0) as u32).min(ROOM)
    }

    /// Lays out what a device needs of the fabric for a series of steps.
    fn lay_series(&self, cloth: &Cloth, fluid: &mut Fluid) -> Result<(), DeviceError> {
        let triangles = self.surface().triangles();
        let cell_m2 = self.units().cell_size_m.powi(2);
        let area = |(nodes, triangle): (&[u32; 3], &Triangle)| {
            let [a, b, c] = nodes.map(|node| self.positions[node as usize]);
            let now = 0.5 * (b - a).cross(c - a).length();
            now.max(triangle.rest_area_m2 / cell_m2)
        };
        let areas = triangles.iter().zip(&cloth.structure.triangles).map(area);
        let walls = MovingWalls {
            triangles,
            bodies: &vec![0; triangles.len()],
            count: 0,
            nodes: self.positions.len(),
            area: areas.sum(),
            growth: GROWTH,
        };
        fluid.lay_moving_walls(&walls, 1)?;
        let room = self.room() as i32 + 1;
        let (first, size) = within(self.surface().reach(), room, fluid.setup().cells);
        fluid.enclose_walls(first, size)
    }

    /// Takes what the air did to the triangles in a step of the device's own.
    fn take_reactions(&mut self, at_cuts: &AtCuts) {
        let count = self.surface().triangles().len();
        let reactions = (0..count).filter_map(|triangle| at_cuts.reaction(triangle, count));
        self.reactions = reactions.collect();
        let faces = at_cuts.faces.iter();
        let faces = faces.map(|[front, back, ..]| [*front, *back].map(f64::from));
        self.surface_mut().take_face_pressures(faces.collect());
        self.found_on_device = Some(at_cuts.links as usize);
    }

    /// Takes where the fabric is after it, and what it did to the air.
    fn end_series_step(&mut self, cloth: &Cloth, time_s: f64) {
        self.place(Some(cloth), time_s);
        self.take_velocities(Some(cloth), time_s, true);
        let held = &cloth.structure.held;
        let (mut all, mut of_held) = (DVec3::ZERO, DVec3::ZERO);
        for reaction in &self.reactions {
            let nodes = cloth.structure.triangles[reaction.triangle as usize].nodes;
            let velocities = nodes.map(|node| cloth.velocities_m_s[node as usize]);
            let (_, forces_n) = reaction.at(velocities);
            for (node, force_n) in nodes.into_iter().zip(forces_n) {
                all += force_n;
                if held[node as usize] {
                    of_held += force_n;
                }
            }
        }
        let [all, of_held] = [all, of_held].map(|n| (n / self.units().force_n()).to_array());
        self.take_forces(all, of_held);
    }
}

impl Simulation {
    /// Cells that fabric which cuts links has room to move in during a series of steps.
    pub(super) fn room_of_fabric(&mut self) -> u32 {
        match (&self.cloth, &mut self.coupled) {
            (Some(cloth), Some(Coupled::Links(links))) => match links.stand(cloth) {
                true => links.room(),
                false => 0,
            },
            _ => 0,
        }
    }

    /// Has the device begin with so many steps of fabric that cuts links.
    pub(super) fn begin_cut_steps(&mut self, steps: u64) -> Result<(), Failure> {
        self.begin_energy();
        if let Some(Coupled::Links(links)) = &mut self.coupled {
            links.forget_reactions();
        }
        let settings = self.step_settings();
        let acting = (self.felt_gravity_m_s2(), &[][..], &*self.moved_supports);
        let input = step_input(&self.scene, None, acting, 1);
        let (Some(air), Some(cloth), Some(Coupled::Links(links))) =
            (&mut self.air, &self.cloth, &self.coupled)
        else {
            return Ok(());
        };
        let AirEngine::Gpu(fluid) = air.finest_mut() else {
            return Ok(());
        };
        links.lay_series(cloth, fluid)?;
        let met = (links.surface().face_pressures(), &fluid.links_in_air()?);
        let begun = (cloth, &input);
        Ok(self
            .cloth_engine
            .begin_cut_steps(begun, &settings, steps as usize, met)?)
    }

    /// Stages `find_links` to `bounce` of a step of the device's own.
    pub(super) fn make_cut_step(&mut self, asked: &mut DeviceWork) -> Result<(), Failure> {
        let engine = &mut self.cloth_engine;
        let Some(AirEngine::Gpu(fluid)) = self.air.as_mut().map(super::Levels::finest_mut) else {
            return Ok(());
        };
        engine.place_among_cells()?;
        fluid.find_links_of_nodes()?;
        let mut count = |stage: Stage, now: DeviceWork| {
            self.cost.stages[stage as usize].device += now.since(asked);
            *asked = now;
        };
        let work = || {
            self.device
                .as_ref()
                .map_or_else(DeviceWork::default, |d| d.work())
        };
        count(Stage::FindLinks, work());
        fluid.read_moving_walls()?;
        count(Stage::ReadLinks, work());
        engine.make_own_step()?;
        count(Stage::SolveCloth, work());
        fluid.answer_walls()?;
        count(Stage::Bounce, work());
        if let (Some(impulses), Some(air)) = (&mut self.impulses, &self.air) {
            impulses.add_outflow_after_bounce(air.finest())?;
        }
        Ok(())
    }

    /// Accounts for the next of these steps.
    pub(super) fn account_cut_step(&mut self) -> Result<(), Failure> {
        let mut asked = self.device_work();
        let (outcome, at_cuts) = self.cloth_engine.take_cut_step()?;
        let next = self.step + 1;
        let began = self.pass_own_step(next);
        let time_s = self.time_at(next);
        if let Some(what) = trouble(at_cuts.trouble) {
            let steps = self.step + 1 - began;
            let what = format!("within {steps} steps of the device's own {what}");
            return Err(self.diverged(what).into());
        }
        self.begin_energy();
        if let (Some(Coupled::Links(links)), Some(cloth)) = (&mut self.coupled, &self.cloth) {
            // Links were found where the step began.
            links.stand(cloth);
            links.take_reactions(&at_cuts);
        }
        let left = self.take_nodes()?;
        self.judge(Some(outcome).or(left))?;
        self.end_solve(None)?;
        if let (Some(Coupled::Links(links)), Some(cloth)) = (&mut self.coupled, &self.cloth) {
            links.end_series_step(cloth, time_s);
        }
        self.note_motion();
        if let (Some(impulses), Some(coupled)) = (&mut self.impulses, &self.coupled) {
            impulses.add_delivered(coupled, time_s);
        }
        self.count_device_work(Stage::FetchNodes, &mut asked);
        self.accumulate()?;
        self.count_device_work(Stage::Measure, &mut asked);
        self.cost.own_steps += 1;
        self.end_step(true)
    }
}
