//! Plane Poiseuille flow under a uniform body force between no-slip walls at y = 0 and y = H: u = g y (H − y)/(2ν).
//!
//! With two relaxation times and Λ = 3/16 half-way bounce-back puts the walls exactly midway between cells and ghosts (Ginzburg,
//! Verhaeghe & d'Humières 2008, Commun. Comput. Phys. 3:427), and the discrete solution is the parabola itself: the error is round-off.
//! The regularised operator places them to second order.

use super::flows::{periodic, velocity_error, viscosity};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::Operator;
use crate::lattice::grid::{Faces, Setup, Sides, Wall};

/// Round-off over some thousand steps; in single precision of forces that are a millionth of the populations.
const ROUND_OFF: [f64; 2] = [1e-10, 1e-3];

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let limit = if session.is_double() {
        ROUND_OFF[0]
    } else {
        ROUND_OFF[1]
    };
    // From the exact profile, at equilibrium: what the start lacks has decayed by exp(-25) after 2.5 H²/ν.
    let (cells, error) = profile_error(session, Operator::TwoRelaxationTimes, 16, 0.9, 2.5)?;
    session
        .row(cells, "TRT: L2 error, exact but for round-off", error)
        .gate(Gate::AtMost(limit));
    let sizes: &[usize] = session.size(&[16, 32, 64], &[16, 32, 64, 128]);
    let mut errors = Vec::new();
    for &n in sizes {
        let (cells, error) = profile_error(session, Operator::RecursiveRegularised, n, 1.2, 0.5)?;
        errors.push((cells, n, error));
    }
    session.orders("regularised", &errors);
    Ok(())
}

fn profile_error(
    session: &mut Session,
    operator: Operator,
    n: usize,
    relaxation_time: f64,
    viscous_times: f64,
) -> Result<([usize; 3], f64), Stop> {
    let cells = [8, n, 4];
    let setup = Setup {
        sides: Sides::Each([Faces::Walls([Wall::AT_REST; 2]), Faces::Periodic]),
        ..periodic(cells, relaxation_time, operator)
    };
    let nu = viscosity(relaxation_time);
    let height = n as f64;
    // Diffusive scaling: the Mach number falls with the cell size.
    let peak = 0.8 / height;
    let force = 8.0 * nu * peak / (height * height);
    let exact = move |[_, y, _]: [usize; 3]| {
        let y = y as f64 + 0.5;
        [0.5 * force / nu * y * (height - y), 0.0, 0.0]
    };
    // The bare velocity lacks half the force of a step.
    let initial = |cell: [usize; 3]| (0.0, [exact(cell)[0] - 0.5 * force, 0.0, 0.0]);
    let mut air = session.air(setup, &initial)?;
    let steps = (viscous_times * height * height / nu).ceil() as usize;
    session.advance(&mut air, steps, Some([force, 0.0, 0.0]))?;
    let error = velocity_error(&air, [0.5 * force, 0.0, 0.0], exact)?;
    Ok((cells, error))
}
