//! Rows of the drag of a sphere or a disk.

use std::sync::atomic::Ordering;

use super::report::Gate;
use super::session::{Session, Stop};
use crate::bluff_body::{self, BluffBody, Until};
use crate::case::coupling::Scheme;

/// Largest difference of the two routes of the drag, over the drag: round-off of f32 in a box of some thousand cells.
const ROUTES: f64 = 1e-3;

impl From<bluff_body::Stop> for Stop {
    fn from(stop: bluff_body::Stop) -> Self {
        match stop {
            bluff_body::Stop::Interrupted => Self::Interrupted,
            bluff_body::Stop::Device(error) => Self::Device(error),
            bluff_body::Stop::Refused(why) => Self::Refused(why),
        }
    }
}

/// Computes the drag of a body and adds rows: the drag against the published one, which must lie within `band` if there is one, and the
/// difference of the two routes. The tunnel's walls are part of the error; the row states its blockage.
pub(super) fn rows(session: &mut Session, body: &BluffBody, band: Option<f64>) -> Result<(), Stop> {
    let order = session.order;
    let cells = body.cells();
    let updates = 1e-6 * body.updates()?;
    let start = session.done;
    let mut go_on = |steps: u64| {
        session.progress_to(start + updates * steps as f64);
        !session.interrupt.load(Ordering::Relaxed)
    };
    let drag = body.drag(order.placement, order.device.as_ref(), &mut |simulation| {
        go_on(simulation.step_count())
    })?;
    let flow = format!(
        "Re {}, {} cells/D{}{}, blockage {:.1} %",
        body.reynolds,
        body.resolution,
        match body.scheme {
            Scheme::Kernel => "",
            Scheme::Links => ", cut links",
        },
        match body.levels {
            0 => String::new(),
            levels => format!(" in {levels} boxes"),
        },
        100.0 * body.blockage()
    );
    let when = match body.until {
        Until::Settled(_) if drag.settled => format!("at {:.0} D/U", drag.time),
        Until::Settled(_) => format!("at {:.0} D/U, not settled", drag.time),
        Until::Averaged(end) => format!("mean {:.0} to {end:.0} D/U", 0.5 * end),
    };
    let row = session.row(cells, format!("{flow}: C_D {when}"), drag.coefficient);
    if let Some((reference, source)) = body.published_drag() {
        row.reference(reference, source);
    }
    // Without a published drag there is no error, and the gate fails.
    if let Some(band) = band {
        row.gate(Gate::Within(band));
    }
    let difference = (drag.momentum_box - drag.coefficient) / drag.coefficient;
    session
        .row(
            cells,
            format!("{flow}: momentum box against markers"),
            difference,
        )
        .gate(Gate::AtMost(ROUTES));
    Ok(())
}
