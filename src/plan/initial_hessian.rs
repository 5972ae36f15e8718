//! Which initial Hessian the implicit steps of the fabric start from.

use super::skips::Skip;
use super::structure_every;
use crate::case::Scene;
use crate::solve::InitialHessian;

/// From so many elements that a stretching wave crosses in a step on, multigrid is faster than block-Jacobi.
///
/// Inertia holds the nodes in short steps, and block-Jacobi needs few evaluations, each a third as dear; in long steps its evaluations
/// grow with the elements that one step couples, those of multigrid hardly. Measured (`cargo bench --bench cloth -- step`): the two
/// meet between 5 and 20 elements, over meshes of 25² to 100² cells, a hundredfold in stiffness, and springs or tension-only membrane.
/// Devices take the same: a cycle adds some 45 dispatches to the 9 of an evaluation, and a round trip that block-Jacobi does without. Where the two meet there
/// has not been measured since.
const ELEMENTS_CROSSED: f64 = 10.0;

/// Elements that a stretching wave crosses in one implicit step; `None` without fabric or time steps.
pub(super) fn elements_crossed(scene: &Scene) -> Option<f64> {
    let every = structure_every(scene);
    let time_step_s = scene.time?.step_s * f64::from(every);
    Some(scene.body.as_ref()?.structure.elements_crossed(time_step_s))
}

/// True where implicit steps start from multigrid.
#[must_use]
pub fn steps_take_multigrid(scene: &Scene) -> bool {
    elements_crossed(scene) >= Some(ELEMENTS_CROSSED)
}

/// What implicit steps start from.
pub fn of_steps(scene: &Scene) -> InitialHessian {
    if steps_take_multigrid(scene) {
        InitialHessian::Multigrid
    } else {
        InitialHessian::BlockJacobi
    }
}

/// Length of an implicit step from which multigrid is faster [s]; infinite where it is never taken.
pub fn multigrid_from_s(scene: &Scene) -> f64 {
    scene.body.as_ref().map_or(f64::INFINITY, |body| {
        ELEMENTS_CROSSED / body.structure.elements_crossed(1.0)
    })
}

/// What the choice leaves out.
pub fn skipped(scene: &Scene) -> Option<Skip> {
    let crossed = elements_crossed(scene)?;
    if steps_take_multigrid(scene) {
        return None;
    }
    Some(Skip {
        what: "multigrid in the steps of the fabric",
        why: format!(
            "a stretching wave crosses {crossed:.2} elements in a step: block-Jacobi is faster up to {ELEMENTS_CROSSED}"
        ),
    })
}
