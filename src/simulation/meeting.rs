//! Where air and fabric meet at markers, and one device has both: it forms reactions and forces itself ([`crate::gpu::cloth::MarkersInAir`]).
//!
//! Stages `interpolate`, `solve_cloth` and `spread` leave one submission then, which `fetch_nodes` waits for. It brings the nodes, u* and a_k, and the forces that the air gets. From these
//! the host makes up its accounts. What a device leaves unsolved the host solves from the same u*, and sends the forces anew.

use super::{Coupled, Failure, Simulation};
use crate::gpu::DeviceError;
use crate::gpu::cloth::AtMarkers;
use crate::solve::lbfgs::Outcome;

impl Simulation {
    /// Stage `solve_cloth`: begun, and waited for by `fetch_nodes`.
    pub(super) fn begin_on_device(&mut self) -> Result<(), Failure> {
        let begun = self.with_fabric(|engine, cloth, input, settings| {
            engine.begin_solve(cloth, input, settings)
        });
        Ok(begun.transpose().map(drop)?)
    }

    /// Stage `spread` of forces that the device forms.
    pub(super) fn spread_on_device(&mut self) -> Result<(), DeviceError> {
        self.cloth_engine.react_back()?;
        if let Some(kernel) = self.coupled.as_mut().and_then(Coupled::kernel_mut) {
            kernel.spread_brought();
        }
        Ok(())
    }

    /// Stage `fetch_nodes`, with all that the device found and did.
    pub(super) fn fetch_from_device(&mut self) -> Result<(), Failure> {
        let (outcome, at_markers) = loop {
            match self.cloth_engine.bring_solution()? {
                Some(brought) => break brought,
                None => self.spread_on_device()?,
            }
        };
        self.end_on_device(outcome, &at_markers)
    }

    /// The fabric is where the device solved it, or is to be solved by the host from what the device found `at_markers`.
    pub(super) fn end_on_device(
        &mut self,
        outcome: Option<Outcome>,
        at_markers: &AtMarkers,
    ) -> Result<(), Failure> {
        if let Some(kernel) = self.coupled.as_mut().and_then(Coupled::kernel_mut) {
            kernel.take_brought(at_markers);
        }
        let left = self.take_nodes()?;
        self.judge(outcome.or(left))?;
        self.end_solve(None)?;
        if left.is_some() {
            self.send_marker_forces();
            self.spread_forces();
            return Ok(());
        }
        let time_s = self.time_at(self.step + 1);
        if let Some(kernel) = self.coupled.as_mut().and_then(Coupled::kernel_mut) {
            kernel.take_velocities(self.cloth.as_ref(), time_s, true);
        }
        self.note_motion();
        Ok(())
    }
}
