//! What others read of a simulation: its scene and plan, time, speed of the wind, and the engines' states.

use std::sync::Arc;

use super::{
    Cadence, Cost, Coupled, Impulses, Interval, Levels, Opening, Origin, Simulation, SolverAccount,
};
use crate::case::Scene;
use crate::case::scene::Flow;
use crate::cpu::cloth::Cloth;
use crate::gpu::{Device, DeviceError, DeviceWork};
use crate::plan::Plan;

impl Simulation {
    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The plan.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Steps done, those before release included.
    #[must_use]
    pub const fn step_count(&self) -> u64 {
        self.step
    }

    /// Time since release; negative while the wind rises [s].
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_at(self.step)
    }

    /// Where steps and time are counted from.
    #[must_use]
    pub const fn origin(&self) -> Origin {
        self.origin
    }

    pub(super) fn time_at(&self, step: u64) -> f64 {
        let step_s = self.scene.time.map_or(0.0, |t| t.step_s);
        self.origin.time_s + (step as f64 - self.origin.step as f64) * step_s
    }

    /// True once the sheet moves freely.
    #[must_use]
    pub const fn released(&self) -> bool {
        self.step >= self.plan.start_steps
    }

    /// True before the end that is planned.
    #[must_use]
    pub const fn steps_are_left(&self) -> bool {
        self.step < self.plan.start_steps.saturating_add(self.plan.steps)
    }

    /// Fabric and cables.
    #[must_use]
    pub const fn cloth(&self) -> Option<&Cloth> {
        self.cloth.as_ref()
    }

    /// What the device has to complain about, if one takes part.
    pub fn check_device(&self) -> Result<(), DeviceError> {
        self.device.as_ref().map_or(Ok(()), |device| device.check())
    }

    /// Gives the device up, if one takes part: for tests of what follows.
    pub fn give_device_up(&self) {
        if let Some(device) = &self.device {
            device.destroy();
        }
    }

    /// The air.
    #[must_use]
    pub const fn air(&self) -> Option<&Levels> {
        self.air.as_ref()
    }

    /// True if all lattices of the air stand at one time: what is read of all of it, and checkpoints, are whole.
    #[must_use]
    pub fn stands_together(&self) -> bool {
        if self.own_steps_are_ahead() {
            return self.are_whole(self.step);
        }
        self.air.as_ref().is_none_or(Levels::stand_together)
    }

    /// The markers.
    #[must_use]
    pub const fn coupled(&self) -> Option<&Coupled> {
        self.coupled.as_ref()
    }

    /// Impulses of the three force routes since release.
    #[must_use]
    pub const fn impulses(&self) -> Option<&Impulses> {
        self.impulses.as_ref()
    }

    /// How the folded canopy was opened.
    #[must_use]
    pub const fn opening(&self) -> Option<&Opening> {
        self.opening.as_ref()
    }

    /// Last step at which the air was known to be sound.
    #[must_use]
    pub const fn sound_step(&self) -> u64 {
        self.sound_step
    }

    /// Farthest that a marker moved between two solves of the fabric [cells]; the coupling is meant for less than 0.25.
    #[must_use]
    pub const fn largest_marker_motion(&self) -> f64 {
        self.largest_marker_motion
    }

    /// Steps of the air between solves of the fabric; `None` where it is solved in each.
    #[must_use]
    pub const fn cadence(&self) -> Option<&Cadence> {
        self.cadence.as_ref()
    }

    /// Wall time and work so far.
    #[must_use]
    pub const fn cost(&self) -> &Cost {
        &self.cost
    }

    /// The device that computes, if one does.
    #[must_use]
    pub const fn device(&self) -> Option<&Arc<Device>> {
        self.device.as_ref()
    }

    /// All that was asked of the device so far.
    pub(super) fn device_work(&self) -> DeviceWork {
        self.device.as_ref().map(|d| d.work()).unwrap_or_default()
    }

    /// How the solves of the fabric ended, from the start of the run.
    #[must_use]
    pub const fn solver_account(&self) -> &SolverAccount {
        &self.account
    }

    /// How those since the last call ended.
    pub fn take_solver_interval(&mut self) -> Interval {
        self.account.take_interval()
    }

    /// Speed of the wind at the inlet now [m/s].
    #[must_use]
    pub fn wind_speed_m_s(&self) -> f64 {
        self.wind_speed_at(self.step)
    }

    pub(super) fn wind_speed_at(&self, step: u64) -> f64 {
        if let Some(descent) = self
            .descent
            .as_ref()
            .filter(|_| step >= self.plan.start_steps)
        {
            return if step > self.step {
                descent.next_speed_m_s()
            } else {
                descent.speed_m_s()
            };
        }
        match self.scene.air.as_ref().map(|air| &air.flow) {
            Some(Flow::WindTunnel { speed_m_s, .. }) if self.plan.start_steps > 0 => {
                speed_m_s * (step as f64 / self.plan.start_steps as f64).min(1.0)
            }
            Some(Flow::WindTunnel { speed_m_s, .. }) => *speed_m_s,
            _ => 0.0,
        }
    }

    /// Mean velocity of the air through what is permeable, and what residual slip adds to it [m/s]; `None` where nothing is.
    #[must_use]
    pub fn through_velocities_m_s(&self) -> Option<[f64; 2]> {
        self.coupled.as_ref()?.through_velocities_m_s()
    }
}
