//! One trial of the line search, for comparing engines.

use glam::{DVec3, Vec3};

use super::integration::StepBase;
use super::loads::StepInput;
use super::objective::Objective;
use super::settings::SolverSettings;
use super::{Cloth, vectors};
use crate::solve::{Attempt, Landing, Start, Step, VectorSpace};

/// What one trial found; for comparing engines.
#[derive(Debug, Clone)]
pub struct Probe {
    /// At the start of the step.
    pub start: Start,
    /// Of the trial; the only stored vector is H₀ g of the start.
    pub attempt: Attempt,
    /// Gradient at the trial [N].
    pub gradient: Vec<DVec3>,
    /// H₀ times the gradient [m].
    pub preconditioned: Vec<DVec3>,
    /// Positions of the trial [m].
    pub positions_m: Vec<DVec3>,
}

impl Cloth {
    /// One trial from the start of a step along `direction` [m], `[node_count]`: its `length`, and the longest way of a node [m]; of the
    /// settings only the initial Hessian counts.
    #[must_use]
    pub fn probe(
        &self,
        (input, settings): (&StepInput, &SolverSettings),
        direction: &[DVec3],
        [length, step_limit_m]: [f64; 2],
    ) -> Probe {
        let structure = &self.structure;
        let state = [&self.positions_m[..], &self.velocities_m_s];
        let base = StepBase::new(state, self.step_before.as_ref(), input);
        let point = base.prediction(structure, input);
        let mut prepared = self.prepared.clone();
        let mut objective = Objective::new(
            structure,
            &mut prepared,
            base,
            input,
            settings.initial_hessian,
        );
        let mut landed = vec![DVec3::ZERO; structure.node_count()];
        let [mut g, mut h, mut new_g, mut new_h] =
            [(); 4].map(|()| vec![Vec3::ZERO; structure.node_count()]);
        let Ok(start) = objective.start(&point, &mut g, &mut h);
        let from = Step {
            point: &point,
            gradient: &g,
            preconditioned: &h,
            direction: &vectors::single(direction),
            length,
            step_limit_m,
        };
        let mut to = Landing {
            point: &mut landed,
            gradient: &mut new_g,
            preconditioned: &mut new_h,
        };
        let Ok(attempt) = objective.attempt(&from, &mut to, &[&h]);
        Probe {
            start,
            attempt,
            gradient: vectors::double(&new_g),
            preconditioned: vectors::double(&new_h),
            positions_m: landed,
        }
    }
}
