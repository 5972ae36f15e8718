//! What the stage `eddy_viscosity` keeps between two evaluations, and its pipeline.

use super::names::by_parity;
use super::parameters::EddyParameters;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::Bound;
use crate::gpu::shaders;
use crate::lattice::Storage;
use crate::lattice::eddy_viscosity::GradientModel;
use crate::lattice::grid::{Grid, Setup};

/// What the stage keeps between two evaluations, and its pipeline by parity.
#[derive(Debug)]
pub(super) struct HeldEddyViscosity {
    pub(super) every: u64,
    /// 3 ν_t, x fastest, `[cell_count]`.
    pub(super) relaxation_times: wgpu::Buffer,
    pub(super) parameters: wgpu::Buffer,
    pub(super) bound: [Bound; 2],
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
    pub(super) fn is_due(&self, step: u64) -> bool {
        step.is_multiple_of(self.every) && self.evaluated != Some(step)
    }
}
