//! Couette flow between a wall at rest, y = 0, and one that moves along x with U, y = H.
//!
//! Steady: u = U y/H, which half-way bounce-back keeps to round-off. Started from rest: u/U = y/H + Σ_n (2/(nπ)) (−1)ⁿ sin(nπy/H)
//! exp(−n²π²νt/H²) (Batchelor 1967, section 4.3), compared at νt/H² = 0.1.

use std::f64::consts::PI;

use super::flows::{periodic, velocity_error, viscosity};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::Operator;
use crate::lattice::grid::{Faces, Setup, Sides, Wall};

const RELAXATION_TIME: f64 = 0.8;

/// νt/H² of the comparison.
const VISCOUS_TIME: f64 = 0.1;

/// Round-off over some hundred steps.
const ROUND_OFF: [f64; 2] = [1e-11, 2e-5];

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let limit = if session.is_double() {
        ROUND_OFF[0]
    } else {
        ROUND_OFF[1]
    };
    for operator in Operator::in_use() {
        let name = operator.short_name();
        let (cells, error) = error(session, operator, 32, true)?;
        session
            .row(
                cells,
                format!("{name}: steady, L2 error, exact but for round-off"),
                error,
            )
            .gate(Gate::AtMost(limit));
        let sizes: &[usize] = session.size(&[16, 32, 64], &[16, 32, 64, 128]);
        let mut errors = Vec::new();
        for &n in sizes {
            let (cells, error) = error_after_start(session, operator, n)?;
            errors.push((cells, n, error));
        }
        session.orders(&format!("{name}, from rest"), &errors);
    }
    Ok(())
}

fn error_after_start(
    session: &mut Session,
    operator: Operator,
    n: usize,
) -> Result<([usize; 3], f64), Stop> {
    error(session, operator, n, false)
}

fn error(
    session: &mut Session,
    operator: Operator,
    n: usize,
    steady: bool,
) -> Result<([usize; 3], f64), Stop> {
    let cells = [8, n, 4];
    let height = n as f64;
    // Diffusive scaling: the Mach number falls with the cell size. As fast as is good for the rest, since round-off is seen against it.
    let speed = 1.6 / height;
    let moving = Wall::NoSlip {
        velocity: [speed, 0.0, 0.0],
    };
    let setup = Setup {
        sides: Sides::Each([Faces::Walls([Wall::AT_REST, moving]), Faces::Periodic]),
        ..periodic(cells, RELAXATION_TIME, operator)
    };
    let exact = move |[_, y, _]: [usize; 3]| {
        let y = (y as f64 + 0.5) / height;
        let sum: f64 = (1..40)
            .map(|k| {
                let k = f64::from(k);
                let sign = if k % 2.0 == 0.0 { 1.0 } else { -1.0 };
                sign * 2.0 / (k * PI)
                    * (k * PI * y).sin()
                    * (-(k * PI).powi(2) * VISCOUS_TIME).exp()
            })
            .sum();
        [speed * if steady { y } else { y + sum }, 0.0, 0.0]
    };
    let initial = |cell: [usize; 3]| (0.0, if steady { exact(cell) } else { [0.0; 3] });
    let mut air = session.air(setup, &initial)?;
    let times = if steady { 2.5 } else { VISCOUS_TIME };
    let steps = (times * height * height / viscosity(RELAXATION_TIME)).round() as usize;
    session.advance(&mut air, steps, None)?;
    Ok((cells, velocity_error(&air, [0.0; 3], exact)?))
}
