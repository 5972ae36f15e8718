//! Decay of Taylor–Green vortices in a thin periodic box at Re = U L/ν = 100 until the time L/U, over resolution and lattice speed:
//! u = U sin kx cos ky exp(−2νk²t), v = −U cos kx sin ky exp(−2νk²t), k = 2π/L (Taylor & Green 1937).
//!
//! At a fixed Mach number the error ends at that of weak compressibility, of order Ma²; at a fixed resolution at that of the grid.

use std::f64::consts::TAU;

use super::measurement::{Flow, Setting};
use crate::lattice::grid::Setup;

const REYNOLDS: f64 = 100.0;

pub(super) fn flow(setting: &Setting) -> Flow {
    let n = setting.resolution;
    let speed = setting.lattice_speed;
    let k = TAU / n as f64;
    let viscosity = speed * n as f64 / REYNOLDS;
    let steps = (n as f64 / speed).round() as usize;
    let decay = (-2.0 * viscosity * k * k * steps as f64).exp();
    let velocity = move |[x, y, _]: [usize; 3], speed: f64| {
        let (x, y) = (k * (x as f64 + 0.5), k * (y as f64 + 0.5));
        [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin(), 0.0]
    };
    Flow {
        setup: Setup::periodic([n, n, 4], 0.5 + 3.0 * viscosity, setting.operator),
        initial: Box::new(move |cell| {
            let (x, y) = (k * (cell[0] as f64 + 0.5), k * (cell[1] as f64 + 0.5));
            // p = (ρ U²/4)(cos 2kx + cos 2ky); δρ = 3 p.
            let excess = 0.75 * speed * speed * ((2.0 * x).cos() + (2.0 * y).cos());
            (excess, velocity(cell, speed))
        }),
        steps,
        exact: Box::new(move |cell| velocity(cell, speed * decay)),
    }
}
