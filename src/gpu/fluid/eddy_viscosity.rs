//! Stage `eddy_viscosity`: the eddy part of every cell's relaxation time from the velocity gradient of its neighbours
//! ([`crate::lattice::eddy_viscosity`]), stored as populations are.
//!
//! A thread reads the populations of its cell and of six neighbours; the caches serve six of the seven, so that no velocity is stored.

use super::Fluid;
use super::parameters::EddyParameters;
use crate::gpu::commands::Pass;
use crate::gpu::error::DeviceError;
use crate::lattice::grid::{Beyond, beyond};

impl Fluid {
    /// Stage `eddy_viscosity` before the step to come; does nothing where no model needs it, where it is not due, or done.
    pub fn eddy_viscosity(&mut self) -> Result<(), DeviceError> {
        if !self
            .held_eddy_viscosity
            .as_ref()
            .is_some_and(|held| held.is_due(self.steps))
        {
            return Ok(());
        }
        let (count, at_once) = (self.grid.cell_count() as u64, self.cells_at_once());
        for first in (0..count).step_by(at_once as usize) {
            self.write_eddy_parameters(first, at_once);
            let mut commands = self.device.record("eddy_viscosity");
            {
                let mut pass = commands.pass("eddy_viscosity");
                self.record_eddy_viscosity(&mut pass, at_once.min(count - first));
            }
            self.device.submit(commands);
        }
        self.device.check()
    }

    /// Parameters of the evaluations recorded next.
    pub(super) fn write_eddy_parameters(&self, first: u64, count: u64) {
        let Some(held) = &self.held_eddy_viscosity else {
            return;
        };
        let mut parameters = EddyParameters {
            first: first as u32,
            count: count.min(u64::from(u32::MAX)) as u32,
            ..EddyParameters::default()
        };
        let faces = beyond(&self.setup, self.inlet_velocity);
        for (k, face) in faces.into_iter().flatten().enumerate() {
            match face {
                Beyond::Periodic => parameters.factors[k][3] = 1.0,
                Beyond::Extrapolated => parameters.factors[k][3] = 2.0,
                Beyond::Ghost { factor, offset } => {
                    for a in 0..3 {
                        parameters.factors[k][a] = factor[a] as f32;
                        parameters.offsets[k][a] = offset[a] as f32;
                    }
                }
            }
        }
        self.device.write(&held.parameters, 0, &[parameters]);
    }

    /// Records the stage for `cells` cells from the first of the parameters, if the step to come asks for it.
    pub(super) fn record_eddy_viscosity(&mut self, pass: &mut Pass<'_>, cells: u64) {
        let (step, parity) = (self.steps, usize::from(self.odd));
        let groups = self.device.workgroups(cells);
        if let Some(held) = &mut self.held_eddy_viscosity
            && step.is_multiple_of(held.every)
        {
            held.bound[parity].dispatch(pass, groups);
            held.evaluated = Some(step);
        }
    }

    /// Eddy viscosity ν_t of every cell as the stage of that name left it, x fastest, `[cell_count]`; `None` where no model needs the stage.
    pub fn eddy_viscosities(&self) -> Result<Option<Vec<f64>>, DeviceError> {
        let Some(held) = &self.held_eddy_viscosity else {
            return Ok(None);
        };
        let times = self.read_stored(&held.relaxation_times, self.grid.cell_count())?;
        Ok(Some(
            times.iter().map(|&time| f64::from(time) / 3.0).collect(),
        ))
    }
}
