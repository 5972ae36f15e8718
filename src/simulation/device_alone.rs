//! Steps that a device makes by itself. Where one device has air and fabric, and nothing but the structure's state changes from step to step, it makes a series of
//! them without the host: it places and sorts the markers, predicts the nodes, solves, and spreads. Every step leaves its nodes, u* and forces
//! on the device, and one map brings those of the whole series. From them the host makes up its accounts, step by step, as if it had been there.
//!
//! Where nothing is in the air but walls that are not solved for, it makes them without any structure, and leaves the forces on the walls. Fabric that cuts links has
//! [a file of its own](super::cut_fabric).
//!
//! A series ends before somebody reads the air ([`Simulation::set_next_reading`], the clock of the stages); looks for a flow that breaks down wait for its end. Meanwhile the air is
//! ahead of the host ([`Simulation::is_ahead`]). A run has the same bits whichever steps make up a series.
//!
//! *Departure from steps with the host*: a solve that the device does not end stands as it is, and is counted as one that did not converge. Then, and where solves come
//! near to that, steps are made with the host for a while, to which the device leaves what it does not solve.

use super::own_steps::{ENOUGH, FASTER, Kind, MOST, ROOM};
use super::{Coupled, Failure, Simulation};
use crate::case::scene::Air;
use crate::cloth::TimeIntegration;
use crate::cpu::cloth::Cloth;
use crate::gpu::{DeviceError, DeviceWork};
use crate::plan::Stage;

impl Simulation {
    /// Steps that the device may make by itself now; 0 where the host is needed first.
    fn own_steps_now(&mut self, kind: Kind) -> u64 {
        let Some(own_steps) = &self.own_steps else {
            return 0;
        };
        let wanted = (self.device.as_ref()).is_some_and(|device| device.tuning().goes_ahead);
        if !wanted || !self.released() || own_steps.need_host(self.step) {
            return 0;
        }
        let room = match kind {
            Kind::Cuts => self.room_of_fabric(),
            Kind::Walls | Kind::Markers => ROOM,
        };
        let Some(coupled) = &self.coupled else {
            return 0;
        };
        let most = match &self.cloth {
            // Where links reach the faces of the momentum box, what crosses them is summed after each bounce.
            _ if kind == Kind::Walls => (self.impulses.as_ref()).map_or(0, |impulses| {
                let holds = |step: &u64| impulses.holds_at(coupled, self.time_at(self.step + step));
                (1..=MOST).take_while(holds).count() as u64
            }),
            Some(cloth) if self.steps_alike(cloth) => {
                let fastest = FASTER * coupled.fastest_of_fabric(cloth);
                let by_room = (f64::from(room) / fastest.max(f64::MIN_POSITIVE)) as u64;
                let at_rest = u64::from(room) * MOST / u64::from(ENOUGH);
                by_room.min(at_rest).min(self.cloth_engine.most_own_steps())
            }
            _ => 0,
        };
        let Some(next_reading) = self.next_reading.filter(|_| most > 0) else {
            return 0;
        };
        let next = self.step + 1;
        let ends = [
            self.border_behind(next),
            self.step.saturating_add(most),
            // What is to be read now is read after the next step.
            next_reading.max(next),
            self.next_timed_step(),
        ];
        let end = ends.into_iter().min().unwrap_or_default();
        // Whole steps of all lattices, but for a rest.
        let whole = (self.step..=end).rev().find(|step| self.are_whole(*step));
        let whole = whole.filter(|whole| *whole > self.step);
        whole.unwrap_or(end).saturating_sub(self.step)
    }

    /// The first border from a step on, counted from where steps are.
    pub(super) const fn border_behind(&self, step: u64) -> u64 {
        let origin = self.origin.step;
        origin + step.saturating_sub(origin).next_multiple_of(MOST)
    }

    /// True if lattices of all levels stand at one time after so many steps.
    pub(super) fn are_whole(&self, steps: u64) -> bool {
        let outer = self.scene.air.as_ref().map_or(1, Air::steps_per_outer);
        steps.saturating_sub(self.origin.step).is_multiple_of(outer)
    }

    /// True if this step counts from the last one as all further ones do from theirs.
    fn steps_alike(&self, cloth: &Cloth) -> bool {
        self.scene.time.is_some_and(|time| {
            time.integration == TimeIntegration::BackwardEuler
                || (cloth.step_before.as_ref())
                    .is_some_and(|before| before.time_step_s == time.step_s)
        })
    }

    /// Has the device begin with a series, if it may.
    pub(super) fn begin_own_steps(&mut self) -> Result<(), Failure> {
        let Some(kind) = self.own_steps.as_ref().map(|own_steps| own_steps.kind) else {
            return Ok(());
        };
        match kind {
            Kind::Walls => self.place_surfaces(self.step)?,
            Kind::Cuts | Kind::Markers => {}
        }
        let steps = self.own_steps_now(kind);
        if steps == 0 {
            return Ok(());
        }
        let mut asked = self.device_work();
        match kind {
            Kind::Walls => self.enclose_walls(steps)?,
            Kind::Cuts => self.begin_cut_steps(steps)?,
            Kind::Markers => {
                self.begin_solve();
                let begun = self.with_fabric(|engine, cloth, input, settings| {
                    engine.begin_own_steps((cloth, input), settings, steps as usize)
                });
                begun.transpose()?;
            }
        }
        let prepares = match kind {
            Kind::Walls => Stage::FindLinks,
            Kind::Cuts | Kind::Markers => Stage::SendNodes,
        };
        self.count_device_work(prepares, &mut asked);
        for further in 0..steps {
            self.make_own_step(kind, further, &mut asked)?;
        }
        match &mut self.air {
            Some(air) if kind == Kind::Walls => Coupled::ask_wall_forces(air.finest_mut()),
            _ => self.cloth_engine.submit_own_steps()?,
        }
        if let Some(own_steps) = &mut self.own_steps {
            own_steps.began = self.step;
            own_steps.made = Some(self.step + steps);
        }
        Ok(())
    }

    /// The stages of a step that many steps ahead.
    fn make_own_step(
        &mut self,
        kind: Kind,
        further: u64,
        asked: &mut DeviceWork,
    ) -> Result<(), Failure> {
        self.set_inlet_velocity(self.step + further);
        if kind == Kind::Walls {
            self.place_surfaces(self.step + further)?;
        }
        self.eddy_viscosity()?;
        self.count_device_work(Stage::EddyViscosity, asked);
        let (Some(air), Some(coupled), Some(impulses)) =
            (&mut self.air, &mut self.coupled, &mut self.impulses)
        else {
            return Ok(());
        };
        air.collide_stream(None, coupled.immersed())?;
        air.coarser_levels(None)?;
        if kind != Kind::Cuts && !impulses.add_outflow(air.finest(), coupled)? {
            let what = "a surface reaches the faces of the momentum box in a series of steps";
            return Err(DeviceError::Command(what.to_owned()).into());
        }
        let Some(kernel) = coupled.kernel_mut() else {
            self.count_device_work(Stage::CollideStream, asked);
            if kind == Kind::Cuts {
                return self.make_cut_step(asked);
            }
            self.find_links_on_device(self.step + further, true)?;
            self.count_device_work(Stage::FindLinks, asked);
            self.read_links()?;
            self.count_device_work(Stage::ReadLinks, asked);
            self.bounce()?;
            self.count_device_work(Stage::Bounce, asked);
            return Ok(());
        };
        let enclosed = if further == 0 {
            kernel.enclose(air.finest(), ROOM)?
        } else {
            Ok(())
        };
        kernel.sort_markers();
        let placed = kernel.interpolate(air.finest(), None, 0.0)?;
        self.count_device_work(Stage::CollideStream, asked);
        self.still_inside(enclosed.and(placed).map_err(Into::into))?;
        self.count_device_work(Stage::Interpolate, asked);
        self.cloth_engine.make_own_step()?;
        if let Some(kernel) = self.coupled.as_mut().and_then(Coupled::kernel_mut) {
            kernel.spread_brought();
        }
        self.count_device_work(Stage::SolveCloth, asked);
        Ok(())
    }

    /// Accounts for the next of the steps that the device has made.
    pub(super) fn account_own_step(&mut self) -> Result<(), Failure> {
        match self.own_steps.as_ref().map(|own_steps| own_steps.kind) {
            Some(Kind::Walls) => return self.account_step_at_walls(),
            Some(Kind::Cuts) => return self.account_cut_step(),
            Some(Kind::Markers) | None => {}
        }
        let mut asked = self.device_work();
        self.add_delivered();
        let (outcome, at_markers) = self.cloth_engine.take_own_step()?;
        let next = self.step + 1;
        let began = self.pass_own_step(next);
        let time_s = self.time_at(next);
        if let Some(kernel) = self.coupled.as_mut().and_then(Coupled::kernel_mut) {
            let placed = kernel.take_sorted(self.cloth.as_ref(), time_s, &at_markers.order);
            self.still_inside(placed.map_err(Into::into))?;
        }
        if at_markers.strayed.is_some() {
            let what = format!(
                "the surface moved farther than {ROOM} cells within {} steps",
                self.step - began
            );
            return Err(self.diverged(what).into());
        }
        self.begin_solve();
        self.end_on_device(Some(outcome), &at_markers)?;
        self.count_device_work(Stage::FetchNodes, &mut asked);
        self.accumulate()?;
        self.count_device_work(Stage::Measure, &mut asked);
        self.cost.own_steps += 1;
        self.end_step(true)
    }

    /// The same of a step in which nothing but walls that are not solved for was in the air.
    fn account_step_at_walls(&mut self) -> Result<(), Failure> {
        let mut asked = self.device_work();
        self.gather_drags();
        self.take_wall_forces()?;
        self.count_device_work(Stage::FetchWallForces, &mut asked);
        self.pass_own_step(self.step + 1);
        self.accumulate()?;
        self.count_device_work(Stage::Measure, &mut asked);
        self.cost.own_steps += 1;
        self.end_step(true)
    }

    /// The step `next` of the series is accounted for; where that began.
    pub(super) fn pass_own_step(&mut self, next: u64) -> u64 {
        let Some(own_steps) = &mut self.own_steps else {
            return next;
        };
        own_steps.made = own_steps.made.filter(|made| *made > next);
        own_steps.began
    }

    /// Notes for a stage what was asked of the device since an earlier look.
    pub(super) fn count_device_work(&mut self, stage: Stage, asked: &mut DeviceWork) {
        let now = self.device_work();
        self.cost.stages[stage as usize].device += now.since(asked);
        *asked = now;
    }
}
