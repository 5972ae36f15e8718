//! Walls that are not solved for, in the air of a device that answers along their cut links by itself: stages `read_links` and `bounce` where they stand still
//! ([`crate::gpu::fluid::standing_walls`]; [`super::moving_walls`] has those that move), and `fetch_wall_forces` of both. The host learns what the air does to them alone.

use glam::DVec3;

use super::air::AirEngine;
use super::bodies::Load;
use super::on_device::OnDevice;
use super::own_steps::MOST;
use super::{Coupled, Levels, LinkCoupling, Simulation};
use crate::cut_links::SIDES;
use crate::gpu::DeviceError;
use crate::gpu::fluid::standing_tables::Push;

impl LinkCoupling {
    /// Sides of the links of the fabric, then those of every body. Moments are those of bodies alone.
    fn pushes(&self) -> Vec<Vec<Push>> {
        let points = self.moment_points(0.0);
        let mut pushes = vec![Vec::new(); 1 + points.len()];
        for (number, link) in self.surface().links().iter().enumerate() {
            for side in SIDES {
                let cut = &link.cuts[side];
                let place = self.surface().at(cut, self.surface().positions());
                let (group, arm) = match self.body_of(cut.triangle) {
                    None => (0, DVec3::ZERO),
                    Some(body) => (1 + body, place - points[body]),
                };
                pushes[group].push(Push {
                    side: (2 * number + side) as u32,
                    arm: arm.to_array(),
                });
            }
        }
        pushes
    }

    /// Stage `read_links`; lays out before what does not change.
    pub(super) fn read_walls(&self, air: &mut AirEngine) -> Result<(), DeviceError> {
        if let AirEngine::Gpu(fluid) = air {
            let walls = self.surface().standing();
            fluid.lay_walls(&walls, || self.pushes(), MOST as usize)?;
            fluid.read_walls();
        }
        Ok(())
    }

    /// Stage `fetch_wall_forces`, of the next of the steps that were asked for.
    pub(super) fn fetch_wall_forces(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        let AirEngine::Gpu(fluid) = air else {
            return Ok(());
        };
        let found = fluid.fetch_wall_forces()?;
        if self.on_device == OnDevice::Moving {
            self.found_on_device = Some(fluid.moving_links());
        }
        self.take_loads(
            found
                .into_iter()
                .map(|[force, moment]| Load { force, moment }),
        );
        Ok(())
    }
}

impl Coupled {
    /// Has a device bring the forces on walls, of all steps since it was last asked.
    pub(super) fn ask_wall_forces(air: &mut AirEngine) {
        if let AirEngine::Gpu(fluid) = air {
            fluid.ask_wall_forces();
        }
    }

    /// Stage `fetch_wall_forces`.
    pub(super) fn fetch_wall_forces(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(_) => Ok(()),
            Self::Links(links) => links.fetch_wall_forces(air),
        }
    }
}

impl Simulation {
    /// Stage `fetch_wall_forces`, of a step that the device did not make by itself. While the wind rises nobody asks for them, before the last step.
    pub(super) fn fetch_wall_forces(&mut self) -> Result<(), DeviceError> {
        let is_asked = self.step + 1 >= self.plan.start_steps;
        match self.air.as_mut().map(Levels::finest_mut) {
            Some(air) if is_asked => Coupled::ask_wall_forces(air),
            Some(AirEngine::Gpu(fluid)) => {
                fluid.forget_wall_forces();
                return Ok(());
            }
            _ => return Ok(()),
        }
        self.take_wall_forces()
    }

    /// Takes what the air did to walls in the next of the steps that were asked for.
    pub(super) fn take_wall_forces(&mut self) -> Result<(), DeviceError> {
        let time_s = self.time_at(self.step + 1);
        let released = self.released();
        let (Some(air), Some(coupled)) = (&mut self.air, &mut self.coupled) else {
            return Ok(());
        };
        coupled.fetch_wall_forces(air.finest_mut())?;
        if let (Some(impulses), true) = (&mut self.impulses, released) {
            impulses.add_delivered(coupled, time_s);
        }
        Ok(())
    }
}
