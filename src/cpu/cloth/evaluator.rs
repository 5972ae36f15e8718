//! The objective of a step, one evaluation at a time: for minimisers other than ours, and for measuring how far they are.

use glam::{DVec3, Vec3};

use super::integration::StepBase;
use super::objective::Objective;
use super::vectors::{double, single};
use super::{Cloth, InitialHessian, StepInput};

/// Objective of one implicit step, or of the static equilibrium, of a structure.
pub struct Evaluator<'a> {
    objective: Objective<'a>,
    prediction_m: Vec<DVec3>,
}

impl Cloth {
    /// The objective that [`Cloth::solve_cloth`] minimises for this input; norms are measured with the given initial Hessian.
    #[must_use]
    pub fn evaluator<'a>(
        &'a mut self,
        input: &'a StepInput<'a>,
        initial_hessian: InitialHessian,
    ) -> Evaluator<'a> {
        let structure = &self.structure;
        let state = [&self.positions_m[..], &self.velocities_m_s];
        let base = StepBase::new(state, self.step_before.as_ref(), input);
        let prediction_m = base.prediction(structure, input);
        let objective = Objective::new(structure, &mut self.prepared, base, input, initial_hessian);
        Evaluator {
            objective,
            prediction_m,
        }
    }
}

impl Evaluator<'_> {
    /// Where [`Cloth::solve_cloth`] starts \[m\].
    #[must_use]
    pub fn prediction_m(&self) -> &[DVec3] {
        &self.prediction_m
    }

    /// The objective \[J\]; writes its gradient \[N\], `[node_count]`.
    pub fn evaluate(&mut self, point_m: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        self.objective.evaluate_double(point_m, gradient)
    }

    /// Builds H₀ around a point.
    pub fn rebuild(&mut self, point_m: &[DVec3]) {
        self.objective.rebuild(point_m);
    }

    /// H₀ times a vector, with the H₀ built last.
    pub fn precondition(&mut self, vector: &[DVec3]) -> Vec<DVec3> {
        let vector = single(vector);
        let mut result = vec![Vec3::ZERO; vector.len()];
        self.objective.apply_inverse(&vector, &mut result);
        double(&result)
    }

    /// The projected Hessian that H₀ was built from, times a vector; `None` unless that is multigrid.
    pub fn stiffness_times(&self, vector: &[DVec3]) -> Option<Vec<DVec3>> {
        let mut product = vec![Vec3::ZERO; vector.len()];
        self.objective
            .multigrid()?
            .multiply(&single(vector), &mut product);
        Some(double(&product))
    }

    /// √(bᵀH₀b) of the loads b at a point.
    pub fn load_norm(&mut self, point_m: &[DVec3]) -> f64 {
        self.objective.load_norm(point_m)
    }

    /// √(gᵀH₀g) relative to that of the loads, with H₀ built at the point: what [`super::SolverSettings::tolerance`] is the goal of.
    pub fn relative_energy_norm(&mut self, point_m: &[DVec3], gradient: &[DVec3]) -> f64 {
        self.rebuild(point_m);
        let displacements = self.precondition(gradient);
        let square: f64 = gradient
            .iter()
            .zip(&displacements)
            .map(|(g, d)| g.dot(*d))
            .sum();
        square.max(0.0).sqrt() / self.load_norm(point_m)
    }
}
