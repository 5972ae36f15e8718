//! Decay of two-dimensional Taylor–Green vortices in a thin periodic box under diffusive scaling: u = U sin kx cos ky exp(−2νk²t),
//! v = −U cos kx sin ky exp(−2νk²t), an exact solution of the Navier–Stokes equations (Taylor & Green 1937).

use std::f64::consts::TAU;

use super::flows::{periodic, velocity_error, viscosity};
use super::session::{Session, Stop};
use crate::lattice::Operator;

const RELAXATION_TIME: f64 = 0.6;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    // Those for comparison only, too: here are no walls, whose place depends on τ with one relaxation time.
    for operator in Operator::ALL {
        let sizes: &[usize] = session.size(&[16, 32, 64], &[16, 32, 64, 128]);
        let mut errors = Vec::new();
        for &n in sizes {
            let cells = [n, n, 4];
            let k = TAU / n as f64;
            let speed = 0.64 / n as f64;
            let vortices = move |[x, y, _]: [usize; 3], speed: f64| {
                let (x, y) = (k * (x as f64 + 0.5), k * (y as f64 + 0.5));
                [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0]
            };
            let initial = |cell: [usize; 3]| {
                let (x, y) = (k * (cell[0] as f64 + 0.5), k * (cell[1] as f64 + 0.5));
                // p = (ρ U²/4)(cos 2kx + cos 2ky); δρ = 3 p.
                let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
                (excess, vortices(cell, speed))
            };
            let mut air = session.air(periodic(cells, RELAXATION_TIME, operator), &initial)?;
            let steps = n * n / 8;
            session.advance(&mut air, steps, None)?;
            let decay = (-2.0 * viscosity(RELAXATION_TIME) * k * k * steps as f64).exp();
            let error = velocity_error(&air, [0.0; 3], |cell| vortices(cell, speed * decay))?;
            errors.push((cells, n, error));
        }
        session.orders(operator.short_name(), &errors);
    }
    Ok(())
}
