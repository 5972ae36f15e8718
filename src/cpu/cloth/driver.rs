//! Part of stage `solve_cloth`: which minimiser drives a solve, and what Newton's method asks of the objective.

use std::convert::Infallible;

use glam::{DVec3, Vec3};

use super::StepInput;
use super::objective::Objective;
use super::vectors::dot;
use crate::cloth::Structure;
use crate::solve::InitialHessian;
use crate::solve::Step;
use crate::solve::lbfgs::{self, Options, Outcome, Stop, Watch};
use crate::solve::newton::{self, Curvature, Trial};
use crate::solve::stiffening::{self, Levels};

/// True where Newton's method is faster than L-BFGS: tension-only membranes that seek their equilibrium with multigrid.
///
/// Measured (`cargo bench --bench cloth -- peers`): a cold sheet of 50² to 200² cells takes a half to a quarter of the time. Springs that
/// push take up to four times as long, since the projection leaves out what makes them buckle. Implicit
/// steps are left to L-BFGS: Newton's method was slower with springs, and is not measured there with tension-only fabric.
#[must_use]
pub fn newton_pays(structure: &Structure, input: &StepInput, kind: InitialHessian) -> bool {
    kind == InitialHessian::Multigrid
        && input.time_step_s.is_none()
        && structure.springs.is_empty()
        && structure.is_tension_only()
}

/// Evaluations after which an equilibrium counts as one of slack fabric: of taut membranes it takes 20 to 30 with multigrid, of taut springs up to 200.
const MEMBRANE_PATIENCE: usize = 60;
const SPRING_PATIENCE: usize = 400;

/// The same of a time step: as long as factorisations take. A device leaves a step to the host after as many.
pub const STEP_PATIENCE: usize = 300;

/// Evaluations of a step of slack fabric with L-BFGS, over the square of the elements that a stretching wave crosses in the time that its velocities count from
/// (docs/results/2026-11-26-motion-of-fabric.md).
const SLACK_EVALUATIONS: f64 = 0.6;

/// Most nodes that are factorised: half a gigabyte.
const NODE_LIMIT: usize = 200_000;

/// Newton's steps on the true objective of a time step, before it is softened.
const DIRECT_STEPS: usize = 10;

/// Square of the elements that a stretching wave crosses in a step, over which inertia no longer keeps Newton's steps short.
const CROSSED_SQUARE: f64 = 10.0;

/// True where slack fabric can be stiffened step by step: the Hessian of contact does not fit a factorisation's pattern, and pressure that follows is not in it.
fn can_be_stiffened(objective: &Objective) -> bool {
    let structure = objective.structure();
    let elastic = !structure.triangles.is_empty() || !structure.springs.is_empty();
    // The matrix is too stiff along triangles that feel the air across themselves alone.
    let slides = objective.input().markers.iter().any(|m| m.across.is_some());
    elastic
        && !slides
        && structure.contact.is_none()
        && !objective.input().pressure_follows()
        && structure.node_count() <= NODE_LIMIT
}

/// Minimises the objective with the driver that suits it: L-BFGS, or Newton's method where it is faster; what neither solves soon is stiffened step by step.
pub(super) fn minimise(
    objective: &mut Objective,
    point: &mut Vec<DVec3>,
    options: &Options,
    watch: Watch,
) -> Outcome {
    let patience = patience(objective);
    if options.evaluation_limit <= patience || !can_be_stiffened(objective) {
        return unsoftened(objective, point, options, watch);
    }
    // Where L-BFGS gets to in an equilibrium is no better a start, but a lower minimum may be near the first.
    let start = (!options.time_step).then(|| point.clone());
    let mut before = None;
    if patience > 0 {
        let first = Options {
            evaluation_limit: patience,
            ..*options
        };
        let outcome = unsoftened(objective, point, &first, watch);
        if ends(outcome.stop) {
            return outcome;
        }
        before = Some(outcome);
    }
    if !objective.prepare_cholesky() {
        return finished(objective, point, options, (before, watch));
    }
    if let Some(start) = start {
        *point = start;
    }
    let levels = levels(objective);
    let spent = before.map_or(0, |outcome| outcome.evaluations);
    // A solve may end a few trials behind its limit.
    let left = Options {
        evaluation_limit: options.evaluation_limit.saturating_sub(spent),
        ..*options
    };
    let mut numbers = bytemuck::cast_slice(point).to_vec();
    let next = stiffening::minimise_watched(objective, &mut numbers, &levels, &left, watch);
    point.copy_from_slice(bytemuck::cast_slice(&numbers));
    let outcome = together(before, next);
    finished(objective, point, options, (Some(outcome), watch))
}

/// Evaluations after which a solve counts as one of slack fabric; none where a step is known to take more.
fn patience(objective: &Objective) -> usize {
    let structure = objective.structure();
    match (objective.input().time_step_s, objective.kind()) {
        (None, _) if structure.is_tension_only() => MEMBRANE_PATIENCE,
        (None, _) => SPRING_PATIENCE,
        (Some(dt), InitialHessian::Multigrid)
            if SLACK_EVALUATIONS * structure.elements_crossed(dt).powi(2)
                > STEP_PATIENCE as f64 =>
        {
            0
        }
        (Some(_), _) => STEP_PATIENCE,
    }
}

/// Levels of stiffness for what is solved.
fn levels(objective: &Objective) -> Levels {
    match objective.input().time_step_s {
        None => Levels::default(),
        Some(dt) => {
            let crossed = objective.structure().elements_crossed(dt);
            let first = CROSSED_SQUARE / (crossed * crossed);
            Levels {
                first: first.clamp(Levels::default().first, 1.0),
                direct_steps: DIRECT_STEPS,
                ..Levels::default()
            }
        }
    }
}

/// True where another driver would find no more.
const fn ends(stop: Stop) -> bool {
    match stop {
        Stop::LimitReached | Stop::Stalled | Stop::Indefinite => false,
        Stop::Converged | Stop::RoundOff | Stop::NotFinite | Stop::Interrupted => true,
    }
}

/// A solve that has ended early goes on without softening, as long as it may.
fn finished(
    objective: &mut Objective,
    point: &mut Vec<DVec3>,
    options: &Options,
    (before, watch): (Option<Outcome>, Watch),
) -> Outcome {
    let spent = before.map_or(0, |outcome| outcome.evaluations);
    let left = options.evaluation_limit.saturating_sub(spent);
    if let Some(outcome) = before.filter(|outcome| ends(outcome.stop) || left == 0) {
        return outcome;
    }
    let options = Options {
        evaluation_limit: left,
        ..*options
    };
    together(before, unsoftened(objective, point, &options, watch))
}

/// What two solves, one behind the other, came to.
fn together(first: Option<Outcome>, next: Outcome) -> Outcome {
    first.map_or(next, |first| Outcome {
        iterations: first.iterations + next.iterations,
        evaluations: first.evaluations + next.evaluations,
        ..next
    })
}

/// With L-BFGS, or with Newton's method where it is faster.
fn unsoftened(
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
