//! Stage `collide_ahead`: a device begins the next step of all cells that the structure does not touch, while the host works on the structure
//! ([`crate::gpu::fluid`]).
//!
//! What the structure does in a step acts on the cells of a box. These wait for it (they are *awaited*), and `collide_stream` does their step once it is known.
//! Until then no state of all cells can be read. So the stage is left out before a step after which somebody reads: the caller, who says when
//! ([`Simulation::set_next_reading`]), looks for a flow that breaks down, and the clock of the stages.

use super::{Coupled, Failure, Levels, Simulation};
use crate::gpu::DeviceError;

impl Simulation {
    /// The caller will read nothing of the air before so many steps are done (counted as [`Simulation::step_count`] does). If it never says so, a device never goes ahead.
    pub const fn set_next_reading(&mut self, step: u64) {
        self.next_reading = Some(step);
    }

    /// True while most cells are a step ahead of those that the structure touches, or a device has made steps that are not accounted for: the air cannot be read.
    #[must_use]
    pub fn is_ahead(&self) -> bool {
        self.own_steps_are_ahead() || self.air.as_ref().is_some_and(|air| air.finest().is_ahead())
    }

    /// Where cells are ahead, does the steps after which all air stands at one time.
    pub fn catch_up(&mut self) -> Result<(), Failure> {
        self.set_next_reading(0);
        while self.is_ahead() || !self.stands_together() {
            self.advance()?;
        }
        Ok(())
    }

    pub(super) fn collide_ahead(&mut self) -> Result<(), DeviceError> {
        if !self.may_go_ahead() {
            return Ok(());
        }
        let Some(coupled) = &self.coupled else {
            return Ok(());
        };
        let Some(awaited) = coupled.awaited_cells() else {
            return Ok(());
        };
        // What crosses the faces of the momentum box in this step is summed before.
        if let (Some(impulses), Some(air)) = (&mut self.impulses, &self.air)
            && !impulses.add_outflow(air.finest(), coupled)?
        {
            return Ok(());
        }
        self.set_inlet_velocity(self.step + 1);
        let markers = self.coupled.as_ref().and_then(Coupled::immersed);
        let air = self.air.as_mut();
        air.map_or(Ok(false), |air: &mut Levels| {
            air.collide_ahead(markers, awaited)
        })?;
        Ok(())
    }

    /// True if nobody reads the air after this step.
    fn may_go_ahead(&self) -> bool {
        let next = self.step + 1;
        let is_wanted = (self.device.as_ref()).is_some_and(|device| device.tuning().goes_ahead);
        is_wanted
            && self.step >= self.plan.start_steps
            && self.next_reading.is_some_and(|reading| next < reading)
            && !self.watch.is_due(next)
            && !self.times_step(self.step)
            && !self.times_step(next)
    }
}
