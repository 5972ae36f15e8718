//! What flows of several problems share.

use crate::gpu::DeviceError;
use crate::lattice::Operator;
use crate::lattice::grid::Setup;
use crate::simulation::AirEngine;

/// Slope of the straight line through points by least squares.
pub(super) fn slope(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let rise: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let run: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
    rise / run
}

/// Air in a periodic box.
pub(super) fn periodic(cells: [usize; 3], relaxation_time: f64, operator: Operator) -> Setup {
    Setup::periodic(cells, relaxation_time, operator)
}

/// ν = (τ − ½)/3.
pub(super) fn viscosity(relaxation_time: f64) -> f64 {
    (relaxation_time - 0.5) / 3.0
}

/// τ = ½ + 3 ν.
pub(super) fn relaxation_time(viscosity: f64) -> f64 {
    0.5 + 3.0 * viscosity
}

/// Density excess and bare velocity of all cells, x fastest, in the engine's precision.
pub(super) fn states(air: &AirEngine) -> Result<Vec<(f64, [f64; 3])>, DeviceError> {
    let [nx, ny, nz] = air.grid().cells;
    let cells = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]);
    Ok(match air {
        AirEngine::CpuF64(fluid) => cells.map(|cell| fluid.bare_state(cell)).collect(),
        AirEngine::CpuF32(_) | AirEngine::CpuF16(_) | AirEngine::Gpu(_) => air
            .macroscopic()?
            .into_iter()
            .map(|(excess, u)| (f64::from(excess), u.map(f64::from)))
            .collect(),
    })
}

/// Relative L2 error of the velocity against `exact(cell)`; `shift` is added to the computed velocity first.
pub(super) fn velocity_error(
    air: &AirEngine,
    shift: [f64; 3],
    exact: impl Fn([usize; 3]) -> [f64; 3],
) -> Result<f64, DeviceError> {
    let [nx, ny, _] = air.grid().cells;
    let (mut off, mut whole) = (0.0, 0.0);
    for (i, (_, u)) in states(air)?.into_iter().enumerate() {
        let e = exact([i % nx, i / nx % ny, i / nx / ny]);
        for a in 0..3 {
            off += (u[a] + shift[a] - e[a]).powi(2);
            whole += e[a] * e[a];
        }
    }
    Ok((off / whole).sqrt())
}
