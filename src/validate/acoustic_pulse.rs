//! A plane sound pulse in a tunnel with and without wind: how much of it comes back from the outlet, and from the inlet.
//!
//! The air is a sum of two waves, w± = ½ (δρ ± u′/c_s) with u′ = u − U. A Gaussian pulse of w+ runs into the outlet, or one of w− into the
//! inlet; when all of it has arrived, the largest wave of the other kind is what came back. It is compared with the pulse in air without ends
//! at the same time.

use super::flows::states;
use super::report::Gate;
use super::session::{Session, Stop};
use crate::lattice::grid::{Setup, Sides, StreamwiseEnds};
use crate::lattice::{Operator, SOUND_SPEED_SQUARED};

/// Cells between inlet and outlet.
const LENGTH: usize = 400;

/// Standard deviation of the pulse [cells].
const WIDTH: f64 = 10.0;

/// Its largest density excess.
const AMPLITUDE: f64 = 1e-3;

pub(super) fn compute(session: &mut Session) -> Result<(), Stop> {
    for operator in Operator::in_use() {
        let name = operator.short_name();
        for wind in [0.0, 0.08] {
            let speed = format!("{name}, wind {wind}");
            let back = reflected(session, operator, wind, true)?;
            let row = session.row(CELLS, format!("outlet, {speed}: reflected/incident"), back);
            // Tunnels of high Reynolds numbers take the regularised operator.
            if operator == Operator::RecursiveRegularised {
                row.gate(Gate::AtMost(0.05));
            }
            let back = reflected(session, operator, wind, false)?;
            session.row(CELLS, format!("inlet, {speed}: reflected/incident"), back);
        }
    }
    Ok(())
}

const CELLS: [usize; 3] = [LENGTH, 4, 4];

fn reflected(
    session: &mut Session,
    operator: Operator,
    wind: f64,
    outlet: bool,
) -> Result<f64, Stop> {
    let sound = SOUND_SPEED_SQUARED.sqrt();
    let sign = if outlet { 1.0 } else { -1.0 };
    let tunnel = Setup {
        cells: CELLS,
        ends: StreamwiseEnds::InletOutlet,
        sides: Sides::Periodic,
        relaxation_time: 0.501,
        sponge_cells: None,
        operator,
        eddy_viscosity: None,
    };
    // The same pulse where it meets nothing: the method itself damps it on its way.
    let endless = Setup {
        cells: [2 * LENGTH, CELLS[1], CELLS[2]],
        ends: StreamwiseEnds::Periodic,
        ..tunnel.clone()
    };
    let centre = 0.5 * LENGTH as f64;
    // Until what came back is at the middle again.
    let time = centre / (sound + wind) + centre / (sound - wind);
    let mut largest = [0.0; 2];
    for ((setup, kind), largest) in [(tunnel, -sign), (endless, sign)]
        .into_iter()
        .zip(&mut largest)
    {
        let initial = |[x, _, _]: [usize; 3]| {
            let distance = (x as f64 + 0.5 - centre) / WIDTH;
            let excess = AMPLITUDE * (-0.5 * distance * distance).exp();
            (excess, [wind + sign * sound * excess, 0.0, 0.0])
        };
        let mut air = session.air(setup, &initial)?;
        air.set_inlet_velocity([wind, 0.0, 0.0]);
        session.advance(&mut air, time.round() as usize, None)?;
        *largest = states(&air)?
            .iter()
            .map(|(excess, u)| (0.5 * (excess + kind * (u[0] - wind) / sound)).abs())
            .fold(0.0, f64::max);
    }
    Ok(largest[0] / largest[1])
}
