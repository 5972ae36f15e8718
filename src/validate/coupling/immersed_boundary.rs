//! Exact properties of the immersed boundary.
//!
//! The kernel's weights sum to one, have no first moment and squares that sum to 3/8, whatever the offset (Peskin 2002). What markers give, the
//! air receives. A pass of direct forcing of strength a over a flat sheet with one marker per cell leaves 1 − 3a/8 of its slip: (5/8)^N after N
//! plain passes, nothing after one of strength 8/3.

use super::super::flows::{periodic, states};
use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::exchange;
use crate::immersed::kernel;
use crate::lattice::Operator;
use crate::measure::extremes::larger;
use crate::simulation::{AirEngine, MarkerEngine};

const CELLS: [usize; 3] = [16, 40, 40];

/// Relative errors in double and in single precision.
const ROUND_OFF: [f64; 2] = [1e-12, 1e-6];

/// The same of slips, which are differences of velocities.
const SLIP_ROUND_OFF: [f64; 2] = [1e-12, 2e-6];

const WIND: [f64; 3] = [0.05, 0.01, -0.02];

pub(in crate::validate) fn compute(session: &mut Session) -> Result<(), Stop> {
    moments(session);
    momentum(session)?;
    slips(session)
}

fn moments(session: &mut Session) {
    let mut worst = [0.0_f64; 3];
    for i in 0..1000 {
        let place = 5.0 + f64::from(i) / 1000.0;
        let (first, weights) = kernel::weights(place);
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            let cells = weights.iter().enumerate();
            cells
                .map(|(k, w)| of((first + k as i64) as f64 - place, *w))
                .sum()
        };
        let found = [
            sum(&|_, w| w) - 1.0,
            sum(&|r, w| r * w),
            sum(&|_, w| w * w) - kernel::SUM_OF_SQUARES,
        ];
        for (worst, found) in worst.iter_mut().zip(found) {
            *worst = larger(*worst, found.abs());
        }
    }
    for (what, error) in ["sum", "first moment", "sum of squares"].iter().zip(worst) {
        session
            .row([0; 3], format!("kernel: {what}, largest error"), error)
            .gate(Gate::AtMost(1e-14));
    }
}

/// A square of markers one cell apart, normal to x, so large that its rim does not reach the middle in five passes.
fn sheet(x: f64) -> Vec<[f64; 3]> {
    let row = |i: usize| 4.6 + i as f64;
    (0..31)
        .flat_map(|j| (0..31).map(move |k| [x, row(j), row(k) - 0.3]))
        .collect()
}

fn air(session: &Session) -> Result<AirEngine, Stop> {
    session.air(
        periodic(CELLS, 0.6, Operator::RecursiveRegularised),
        &|_| (0.0, WIND),
    )
}

fn total_momentum(air: &AirEngine) -> Result<[f64; 3], Stop> {
    let mut total = [0.0; 3];
    for (excess, u) in states(air)? {
        for (sum, u) in total.iter_mut().zip(u) {
            *sum += (1.0 + excess) * u;
        }
    }
    Ok(total)
}

/// Markers that move against the wind: the momentum that the air gains in a step is the sum of their forces.
fn momentum(session: &mut Session) -> Result<(), Stop> {
    let mut air = air(session)?;
    let positions = sheet(7.37);
    let mut markers = MarkerEngine::new(&air, vec![1.0; positions.len()], 1.6)?;
    let velocities: Vec<[f64; 3]> = (0..positions.len())
        .map(|k| [-0.05, 0.03 * (k as f64 * 0.7).sin(), 0.02])
        .collect();
    let before = total_momentum(&air)?;
    let given = exchange(&air, &mut markers, &positions, &velocities)?;
    air.collide_stream(None, Some(&markers))?;
    let after = total_momentum(&air)?;
    let size = given.iter().map(|f| f * f).sum::<f64>().sqrt();
    let error = (0..3)
        .map(|a| (after[a] - before[a] - given[a]).powi(2))
        .sum::<f64>()
        .sqrt();
    // What single precision loses of the momentum of all cells counts here.
    let cells = CELLS.iter().product::<usize>() as f64;
    let held = cells * WIND.iter().map(|u| u * u).sum::<f64>().sqrt();
    let limit = if session.is_double() {
        ROUND_OFF[0]
    } else {
        ROUND_OFF[1]
    };
    session
        .row(
            CELLS,
            "momentum of the air less forces of the markers, over the momentum of the air",
            error / held,
        )
        .gate(Gate::AtMost(limit));
    session.row(CELLS, "the same, over the force", error / size);
    Ok(())
}

fn slips(session: &mut Session) -> Result<(), Stop> {
    let speed = WIND.iter().map(|u| u * u).sum::<f64>().sqrt();
    let limit = if session.is_double() {
        SLIP_ROUND_OFF[0]
    } else {
        SLIP_ROUND_OFF[1]
    };
    for (strength, passes) in [
        (1.0, 1),
        (1.0, 2),
        (1.0, 3),
        (1.0, 5),
        (1.6, 1),
        (8.0 / 3.0, 1),
    ] {
        let mut worst: f64 = 0.0;
        for offset in [0.0, 0.13, 0.5, 0.81] {
            let air = air(session)?;
            let positions = sheet(7.0 + offset);
            let mut markers = MarkerEngine::new(&air, vec![1.0; positions.len()], strength)?;
            let still = vec![[0.0; 3]; positions.len()];
            exchange(&air, &mut markers, &positions, &still)?;
            for _ in 1..passes {
                markers.repeat_forcing(&still)?;
            }
            // The middle marker, beyond the reach of the rim's stronger exchange.
            let slip = markers.marker_slips(&still)?[positions.len() / 2] / speed;
            let expected = (1.0 - 0.375 * strength).powi(passes);
            worst = larger(worst, (slip - expected).abs());
        }
        session
            .row(
                CELLS,
                format!("slip of a flat sheet, a = {strength:.2}, {passes} passes: largest error"),
                worst,
            )
            .gate(Gate::AtMost(limit));
    }
    Ok(())
}
