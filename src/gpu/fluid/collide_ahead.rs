//! Stage `collide_ahead`: cells that the structure does not touch begin their next step, while the host works on the structure.
//!
//! Streamed in place, no two cells touch one element of an array in a step ([`crate::lattice::grid`]). So a step may be done in two parts, in any order and with anything between
//! them that touches neither the cells of the first part nor what they read. What the structure does to the air lies in a box of cells: forces, or what comes back along cut links.
//! All others have their next step before it is known. The bits are those of one dispatch.

use super::awaited::{Awaited, IN_BOX, OUTSIDE_BOX};
use super::{Fluid, ForceBox};
use crate::gpu::error::DeviceError;

impl Fluid {
    /// Advances all cells but those from `awaited[0]` to before `awaited[1]` by a step, without uniform acceleration and under the same forces as these, which feel them alone. [`Fluid::collide_stream`]
    /// is to follow, and until then nothing may be read but in that box. False, and nothing is done, where the box comes too near to a face or holds too many cells, or the device does not know yet
    /// how long a step takes.
    pub fn collide_ahead(
        &mut self,
        forces: Option<&ForceBox>,
        awaited: [[i32; 3]; 2],
    ) -> Result<bool, DeviceError> {
        self.check_readable()?;
        let Some(awaited) = Awaited::new(awaited, self.setup.cells).filter(|_| self.is_timed())
        else {
            return Ok(false);
        };
        self.last_acceleration = [0.0; 3];
        let bound = self.bound(None, forces)?;
        let mut parameters = self.step_parameters_of();
        awaited.put(OUTSIDE_BOX, &mut parameters);
        self.sweep(&bound, parameters)?;
        // The device is to begin now.
        self.device.submit_waiting();
        self.awaited = Some(awaited);
        Ok(true)
    }

    /// The same step of the cells that waited.
    pub(super) fn collide_awaited(
        &mut self,
        forces: Option<&ForceBox>,
        awaited: Awaited,
    ) -> Result<(), DeviceError> {
        let bound = self.bound(None, forces)?;
        let [_, rows, planes] = awaited.size;
        let stride_y = self.grid.stride_y as u32;
        let mut parameters = self.step_parameters_of();
        awaited.put(IN_BOX, &mut parameters);
        // A ghost stands before the first row.
        parameters.first_element = (awaited.first[1] + 1) * stride_y;
        let groups = (rows * stride_y).div_ceil(self.device.tuning().workgroup);
        let rows_of_all = self.setup.cells[1] as f64;
        let mut done = 0;
        while done < planes {
            let at_once = (self.planes_at_once() as f64 * rows_of_all / f64::from(rows)) as u32;
            let count = at_once.clamp(1, planes - done);
            parameters.first_plane = awaited.first[2] + done;
            self.device.write(&self.step_parameters, 0, &[parameters]);
            let mut commands = self.device.record("collide_awaited");
            {
                let mut pass = commands.pass("collide_awaited");
                bound.dispatch(&mut pass, [groups, count]);
            }
            self.leave_if_short(commands, f64::from(count * rows) / rows_of_all);
            done += count;
        }
        self.device.check()
    }

    /// True while most cells are a step ahead of the others.
    #[must_use]
    pub const fn is_ahead(&self) -> bool {
        self.awaited.is_some()
    }

    /// An error while it is ahead: no state of all cells can be read.
    pub(super) fn check_readable(&self) -> Result<(), DeviceError> {
        match self.awaited {
            None => Ok(()),
            Some(_) => Err(DeviceError::Command(
                "cells cannot be read while most are a step ahead of the others".to_owned(),
            )),
        }
    }
}
