//! Part of stage `solve_cloth`: which minimiser drives a solve, and what Newton's method asks of the objective.

use std::convert::Infallible;

use glam::{DVec3, Vec3};

use super::StepInput;
use super::objective::Objective;
use super::vectors::dot;
use crate::cloth::Structure;
use crate::solve::InitialHessian;
use crate::solve::Step;
use crate::solve::lbfgs::{self, Options, Outcome, Watch};
use crate::solve::newton::{self, Curvature, Trial};

/// True where Newton's method is faster than L-BFGS: tension-only membranes that seek their equilibrium with multigrid.
///
/// Measured (`cargo bench --bench cloth -- peers`): a cold sheet of 50² to 200² cells takes a half to a quarter of the time. Springs that
/// push take up to four times as long, since the projection leaves out what makes them buckle. Implicit
/// steps are left to L-BFGS: Newton's method was slower with springs, and is not measured there with tension-only fabric.
fn newton_pays(structure: &Structure, input: &StepInput, kind: InitialHessian) -> bool {
    kind == InitialHessian::Multigrid
        && input.time_step_s.is_none()
        && structure.springs.is_empty()
        && structure.is_tension_only()
}

/// Minimises the objective with the driver that suits it.
pub(super) fn minimise(
    objective: &mut Objective,
    point: &mut Vec<DVec3>,
    options: &Options,
    watch: Watch,
) -> Outcome {
    let newton = newton_pays(objective.structure(), objective.input(), objective.kind());
    let Ok(outcome) = if newton {
        newton::minimise_watched(objective, point, options, watch)
    } else {
        lbfgs::minimise_watched(objective, point, options, watch)
    };
    outcome
}

impl Curvature for Objective<'_> {
    fn multiply(&mut self, vector: &Vec<Vec3>, product: &mut Vec<Vec3>) -> Result<f64, Infallible> {
        match self.multigrid() {
            Some(multigrid) => multigrid.multiply(vector, product),
            // Not reached: without multigrid L-BFGS drives.
            None => product.fill(Vec3::ZERO),
        }
        self.add_between_sides(vector, product);
        Ok(dot(vector, product))
    }

    fn precondition(
        &mut self,
        vector: &Vec<Vec3>,
        result: &mut Vec<Vec3>,
    ) -> Result<f64, Infallible> {
        self.apply_inverse(vector, result);
        Ok(dot(vector, result))
    }

    fn advance(
        &mut self,
        from: &Step<'_, Vec<DVec3>, Vec<Vec3>>,
        point: &mut Vec<DVec3>,
        gradient: &mut Vec<Vec3>,
    ) -> Result<Trial, Infallible> {
        let length = self.move_along(from, point);
        let objective = self.evaluate(point, gradient);
        Ok(Trial {
            objective,
            round_off: Self::round_off(objective),
            length,
            slope_before: dot(from.gradient, from.direction),
            slope: dot(gradient, from.direction),
        })
    }
}
