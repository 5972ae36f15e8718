//! Decay of a three-dimensional Beltrami flow in a periodic box under diffusive scaling.
//!
//! Three-dimensional Taylor–Green vortices have no exact solution at a finite Reynolds number. The Arnold–Beltrami–Childress flow has
//! (Dombre et al. 1986, doi:10.1017/S0022112086002859): u = A (sin kz + cos ky), v = A (sin kx + cos kz), w = A (sin ky + cos kx) is
//! parallel to its vorticity, so that the pressure −ρ u²/2 balances the advection and every component decays with exp(−νk²t).

use std::f64::consts::TAU;

use super::flows::{periodic, velocity_error, viscosity};
use super::session::{Session, Stop};
use crate::lattice::Operator;

const RELAXATION_TIME: f64 = 0.65;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    for operator in Operator::in_use() {
        let name = operator.short_name();
        let sizes: &[usize] = session.size(&[16, 32, 64], &[16, 32, 64, 128]);
        let mut errors = Vec::new();
        for &n in sizes {
            let cells = [n; 3];
            let k = TAU / n as f64;
            let speed = 0.3 / n as f64;
            let flow = move |cell: [usize; 3], speed: f64| {
                let [x, y, z] = cell.map(|c| k * (c as f64 + 0.5));
                [
                    speed * (z.sin() + y.cos()),
                    speed * (x.sin() + z.cos()),
                    speed * (y.sin() + x.cos()),
                ]
            };
            let initial = |cell: [usize; 3]| {
                let u = flow(cell, speed);
                let square = u.iter().map(|u| u * u).sum::<f64>();
                // p = −ρ (u² − <u²>)/2; δρ = 3 p.
                (-1.5 * (square - 3.0 * speed * speed), u)
            };
            let mut air = session.air(periodic(cells, RELAXATION_TIME, operator), &initial)?;
            let steps = n * n / 8;
            session.advance(&mut air, steps, None)?;
            let decay = (-viscosity(RELAXATION_TIME) * k * k * steps as f64).exp();
            let error = velocity_error(&air, [0.0; 3], |cell| flow(cell, speed * decay))?;
            errors.push((cells, n, error));
        }
        session.orders(name, &errors);
    }
    Ok(())
}
