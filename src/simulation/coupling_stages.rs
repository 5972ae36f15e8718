//! Stages of a step in which air and structure meet, at cut links or through markers.

use super::{Coupled, Failure, LeftTheAir, Simulation};
use crate::gpu::DeviceError;

impl Simulation {
    pub(super) fn find_links(&mut self) -> Result<(), Failure> {
        self.place_surfaces(self.step)?;
        Ok(self.find_links_on_device(self.step, false)?)
    }

    pub(super) fn read_links(&mut self) -> Result<(), DeviceError> {
        match (&mut self.air, &mut self.coupled) {
            (Some(air), Some(coupled)) => coupled.read_links(air.finest_mut()),
            _ => Ok(()),
        }
    }

    pub(super) fn fetch_links(&mut self) -> Result<(), DeviceError> {
        match (&mut self.air, &mut self.coupled) {
            (Some(air), Some(coupled)) => coupled.fetch_links(air.finest_mut()),
            _ => Ok(()),
        }
    }

    pub(super) fn bounce(&mut self) -> Result<(), DeviceError> {
        let time_s = self.time_at(self.step + 1);
        let released = self.released();
        let answered = self.plan.answers_on_device();
        let (Some(air), Some(coupled)) = (&mut self.air, &mut self.coupled) else {
            return Ok(());
        };
        coupled.bounce(air.finest_mut(), self.cloth.as_ref(), time_s, released)?;
        self.largest_marker_motion = self.largest_marker_motion.max(coupled.fastest_marker());
        // Forces that a device sums are fetched first.
        if let (Some(impulses), true) = (&mut self.impulses, released && !answered) {
            impulses.add_delivered(coupled, time_s);
        }
        Ok(())
    }

    pub(super) fn send_markers(&mut self) -> Result<(), Failure> {
        let time_s = self.time_at(self.step + 1);
        let (Some(air), Some(coupled)) = (&self.air, &mut self.coupled) else {
            return Ok(());
        };
        let sent = coupled.send_markers(air.finest(), self.cloth.as_ref(), time_s)?;
        self.still_inside(sent)
    }

    pub(super) fn interpolate(&mut self) -> Result<(), Failure> {
        let time_s = self.time_at(self.step + 1);
        let (Some(air), Some(coupled)) = (&self.air, &mut self.coupled) else {
            return Ok(());
        };
        let done = coupled.interpolate(air.finest(), self.cloth.as_ref(), time_s)?;
        if !self.plan.reacts_on_device() {
            coupled.ask_air_velocities();
        }
        self.still_inside(done)
    }

    pub(super) fn fetch_air_velocities(&mut self) -> Result<(), DeviceError> {
        if let Some(coupled) = &mut self.coupled {
            coupled.fetch_air_velocities()?;
        }
        Ok(())
    }

    /// A marker or a node of a surface that left the air ends the run.
    pub(super) fn still_inside(&mut self, surfaces: Result<(), LeftTheAir>) -> Result<(), Failure> {
        let Err(left) = surfaces else {
            return Ok(());
        };
        // Perhaps the air drove it out. Air that is ahead tells of another time.
        if !self.is_ahead() {
            self.look()?;
        }
        let Some(coupled) = &self.coupled else {
            return Ok(());
        };
        let place = coupled.units().position_m(left.position);
        let refined = self.scene.air.as_ref().is_some_and(|air| air.depth() > 0);
        let (left, remedy) = if refined {
            (
                "the innermost box of cells",
                "raise air.refinement.margin, or enlarge that box",
            )
        } else {
            ("the air", "enlarge the tunnel")
        };
        let what = format!(
            "the surface left {left} at ({:.3}, {:.3}, {:.3}) m; {remedy}, guide the apex, or check the loads",
            place.x, place.y, place.z
        );
        Err(self.diverged(what).into())
    }

    pub(super) fn send_marker_forces(&mut self) {
        let time_s = self.time_at(self.step + 1);
        if let Some(coupled) = &mut self.coupled {
            let released = self.step >= self.plan.start_steps;
            coupled.send_marker_forces(self.cloth.as_ref(), time_s, released);
        }
    }

    pub(super) fn spread(&mut self) -> Result<(), DeviceError> {
        if self.plan.reacts_on_device() {
            if self.solves_now() {
                return self.spread_on_device();
            }
            // While the fabric is held, nothing is solved.
            self.fetch_air_velocities()?;
            self.send_marker_forces();
        }
        self.spread_forces();
        Ok(())
    }

    /// Stage `spread` of forces that the host has formed or sent.
    pub(super) fn spread_forces(&mut self) {
        let time_s = self.time_at(self.step + 1);
        if let Some(coupled) = &mut self.coupled {
            let released = self.step >= self.plan.start_steps;
            coupled.spread(self.cloth.as_ref(), time_s, released);
            self.note_motion();
        }
    }

    /// Notes how far the fastest marker moves.
    pub(super) fn note_motion(&mut self) {
        if let Some(coupled) = &self.coupled {
            let every = self.cadence.map_or(1, |cadence| cadence.every());
            let motion = coupled.fastest_marker() * f64::from(every);
            self.largest_marker_motion = self.largest_marker_motion.max(motion);
        }
    }

    pub(super) fn repeat_forcing(&mut self) -> Result<(), DeviceError> {
        self.coupled
            .as_mut()
            .map_or(Ok(()), Coupled::repeat_forcing)
    }

    pub(super) fn fetch_marker_forces(&mut self) -> Result<(), DeviceError> {
        self.coupled
            .as_mut()
            .map_or(Ok(()), Coupled::fetch_marker_forces)
    }
}
