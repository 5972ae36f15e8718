//! Thin double shear layer in a periodic box (Minion & Brown 1997, doi:10.1006/jcph.1997.5843): u = U tanh(80 (y − ¼)) for y ≤ ½ and
//! U tanh(80 (¾ − y)) above, v = 0.05 U sin(2π(x + ¼)). Layers of a cell or less must roll up without breaking down at any Reynolds
//! number, with the settings of high-Reynolds cases: regularised operator, Smagorinsky constant 0.15.

use super::flows::{periodic, relaxation_time};
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::Operator;
use crate::lattice::eddy_viscosity::EddyViscosity;
use crate::measure::extremes::larger;

const SPEED: f64 = 0.05;

/// Sound from the unbalanced start moves energy to and fro between motion and pressure.
const RISE_LIMIT: f64 = 1e-3;

/// Speed at which a cell counts as broken down [cells per step].
const SPEED_LIMIT: f64 = 0.3;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let sizes: &[usize] = session.size(&[64], &[64, 128, 256]);
    let reynolds: &[f64] = session.size(&[1e4, 1e7], &[1e4, 1e5, 1e6, 1e7]);
    for &n in sizes {
        for &re in reynolds {
            one(session, n, re)?;
        }
    }
    Ok(())
}

fn one(session: &mut Session, n: usize, reynolds: f64) -> Result<(), Stop> {
    let cells = [n, n, 4];
    let mut setup = periodic(
        cells,
        relaxation_time(SPEED * n as f64 / reynolds),
        Operator::RecursiveRegularised,
    );
    setup.eddy_viscosity = Some(EddyViscosity::smagorinsky(0.15));
    let initial = move |[x, y, _]: [usize; 3]| {
        let (x, y) = ((x as f64 + 0.5) / n as f64, (y as f64 + 0.5) / n as f64);
        let along = if y <= 0.5 {
            (80.0 * (y - 0.25)).tanh()
        } else {
            (80.0 * (0.75 - y)).tanh()
        };
        let across = 0.05 * (std::f64::consts::TAU * (x + 0.25)).sin();
        (0.0, [SPEED * along, SPEED * across, 0.0])
    };
    let mut air = session.air(setup, &initial)?;
    let (_, first) = air.mass_and_energy()?;
    let (mut before, mut rise) = (first, 0f64);
    // Three times the box at the speed of the layers, in twenty samples.
    for _ in 0..20 {
        session.advance(&mut air, 3 * n, None)?;
        let (_, energy) = air.mass_and_energy()?;
        if air.breakdown(SPEED_LIMIT)?.is_some() || !energy.is_finite() {
            rise = f64::INFINITY;
            break;
        }
        rise = larger(rise, (energy - before) / first);
        before = energy;
    }
    session
        .row(
            cells,
            format!("Re {reynolds:.0e}: largest rise of energy"),
            rise,
        )
        .gate(Gate::AtMost(RISE_LIMIT));
    session.row(
        cells,
        format!("Re {reynolds:.0e}: energy left"),
        before / first,
    );
    Ok(())
}
