//! Long run in a small periodic box: mass is kept.
//!
//! Populations are stored as differences from their weights, so that round-off of f32 is that of values near 1e-2; it must not add up.

use super::flows::periodic;
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosity;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let steps: usize = session.size(10_000, 100_000);
    let n = 16;
    let cells = [n; 3];
    let mut setup = periodic(cells, 0.500_1, Operator::RecursiveRegularised);
    setup.eddy_viscosity = Some(EddyViscosity::smagorinsky(0.15));
    let initial = |[x, y, z]: [usize; 3]| {
        let phase = (3 * x + 5 * y + 7 * z) as f64;
        (
            0.01 * phase.sin(),
            [
                0.05 * phase.cos(),
                0.03 * (2.0 * phase).sin(),
                -0.04 * (0.5 * phase).cos(),
            ],
        )
    };
    let mut air = session.air(setup, &initial)?;
    let volume = (n * n * n) as f64;
    let (first, _) = air.mass_and_energy()?;
    session.advance(&mut air, steps, None)?;
    let (last, _) = air.mass_and_energy()?;
    session
        .row(
            cells,
            format!("drift of mass in {steps} steps"),
            (last - first) / volume,
        )
        .gate(Gate::AtMost(1e-6));
    Ok(())
}
