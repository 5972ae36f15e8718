//! What the stage `eddy_viscosity` keeps from one evaluation to the next.

use crate::lattice::Real;
use crate::lattice::eddy_viscosity::GradientModel;
use crate::lattice::grid::Setup;

/// What the stage keeps between two evaluations.
#[derive(Debug, Clone)]
pub(super) struct HeldEddyViscosity<T> {
    pub(super) model: GradientModel,
    /// 3 ν_t per value of the model.
    pub(super) factor: f64,
    pub(super) every: u64,
    /// 3 ν_t, x fastest, `[cell_count]`.
    pub(super) relaxation_times: Vec<T>,
    /// The step before which it was evaluated last.
    pub(super) evaluated: Option<u64>,
}

impl<T: Real> HeldEddyViscosity<T> {
    /// Of a set-up, if its model needs the velocity gradient.
    pub(super) fn new(setup: &Setup) -> Option<Self> {
        let eddy_viscosity = setup.eddy_viscosity?;
        Some(Self {
            model: eddy_viscosity.gradient_model()?,
            factor: eddy_viscosity.relaxation_factor(),
            every: u64::from(eddy_viscosity.update_every.max(1)),
            relaxation_times: vec![T::default(); setup.cells.iter().product()],
            evaluated: None,
        })
    }

    /// Takes the values from a checkpoint; they are evaluated anew if the step to come asks for it.
    pub(super) fn restore(&mut self, relaxation_times: Vec<T>) {
        self.relaxation_times = relaxation_times;
        self.evaluated = None;
    }
}
