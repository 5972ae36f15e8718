//! Stage `eddy_viscosity`: the eddy part of every cell's relaxation time from the velocity gradient of its neighbours
//! ([`crate::lattice::eddy_viscosity`]), stored as populations are.
//!
//! A thread reads the populations of its cell and of six neighbours; the caches serve six of the seven, so that no velocity is stored.

use super::{Bound, Fluid, by_parity};
use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::shaders::{self, parameters};
use crate::lattice::Storage;
use crate::lattice::eddy_viscosity::GradientModel;
use crate::lattice::grid::{Beyond, beyond};
use crate::lattice::grid::{Grid, Setup};

parameters! {
    /// Where to evaluate, and what lies beyond the faces.
    EddyParameters {
        /// Factors of the velocity before a face, lower and upper along x, y, z; the fourth is 1 where the face is periodic.
        factors: [[f32; 4]; 6],
        /// What is added [cells per step].
        offsets: [[f32; 4]; 6],
        /// First cell of a dispatch.
        first: u32,
        /// Cells at most.
        count: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
    }
}

/// What the stage keeps between two evaluations, and its pipeline by parity.
#[derive(Debug)]
pub(super) struct HeldEddyViscosity {
    every: u64,
    /// 3 ν_t, x fastest, `[cell_count]`.
    pub(super) relaxation_times: wgpu::Buffer,
    parameters: wgpu::Buffer,
    bound: [Bound; 2],
    /// The step before which it was evaluated last.
    pub(super) evaluated: Option<u64>,
}

impl HeldEddyViscosity {
    /// Of a set-up, if its model needs the velocity gradient.
    pub(super) fn new(
        device: &Device,
        setup: &Setup,
        grid: &Grid,
        storage: Storage,
        populations: &[wgpu::Buffer],
        constants: &[(&str, f64)],
    ) -> Result<Option<Self>, DeviceError> {
        let Some((eddy_viscosity, model)) = setup
            .eddy_viscosity
            .and_then(|eddy_viscosity| Some((eddy_viscosity, eddy_viscosity.gradient_model()?)))
        else {
            return Ok(None);
        };
        // Bindings come in whole words.
        let bytes = (storage.bytes() * grid.cell_count() as u64).next_multiple_of(4);
        let relaxation_times = device.storage("eddy relaxation times", bytes)?;
        let parameters = device.uniform::<EddyParameters>("eddy")?;
        let mut constants = constants.to_vec();
        constants.extend([
            (
                "GRADIENT_MODEL",
                match model {
                    GradientModel::Wale => 0.0,
                    GradientModel::Vreman => 1.0,
                },
            ),
            ("RELAXATION_FACTOR", eddy_viscosity.relaxation_factor()),
        ]);
        let [pipeline] = device.pipelines(
            &shaders::EDDY_VISCOSITY[storage as usize],
            ["eddy_viscosity"],
            &constants,
        )?;
        let bound = |odd| {
            let mut named = by_parity(populations, odd);
            named.extend([
                ("eddy", &parameters),
                ("eddy_relaxation_times", &relaxation_times),
            ]);
            device.bind(&pipeline, &named)
        };
        let bound = [bound(false)?, bound(true)?];
        Ok(Some(Self {
            every: u64::from(eddy_viscosity.update_every.max(1)),
            relaxation_times,
            parameters,
            bound,
            evaluated: None,
        }))
    }

    /// The values, as `collide_stream` names them.
    pub(super) const fn named(&self) -> (&'static str, &wgpu::Buffer) {
        ("eddy_relaxation_times", &self.relaxation_times)
    }

    /// Whether the step to come asks for an evaluation that has not been done.
    fn is_due(&self, step: u64) -> bool {
        step.is_multiple_of(self.every) && self.evaluated != Some(step)
    }
}

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
