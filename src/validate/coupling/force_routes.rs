//! The force of the air on fabric by three routes that share no data (gate I4): what its markers give the air, the momentum of the air through a
//! box, and what the supports feel (`src/simulation/impulses.rs`). Means over the second half of a run, on the shipped canopy and plate.

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::case_runs;
use super::flexible_plate;
use crate::measure::canopy::IMPULSE_LINES;
use crate::measure::plate::IMPULSE_SUPPORTS;
use crate::measure::shared::{IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX};

const CANOPY: &str = include_str!("../../../cases/flat-circular-tunnel.toml");

/// Largest difference over the drag (gate I4).
const BAND: f64 = 0.01;

/// Tolerance of the fabric's steps: what is left of a solve is a force that supports feel and markers do not.
const TOLERANCE: &str = "solver.tolerance=1e-3";

/// The canopy at 12 cells per diameter, as in the case's quick variant.
const COARSE: [&str; 5] = [
    "resolution.cells_per_diameter=12.0",
    "air.wind_tunnel.size_m=[2.9915, 1.994, 1.994]",
    "air.wind_tunnel.sponge_length_m=0.4",
    "structure.flat_circular.confluence_m=[0.4, 0.997, 0.997]",
    "structure.flat_circular.rings=8",
];

pub(in crate::validate) fn compute(session: &mut Session) -> Result<(), Stop> {
    let coarse: &[&str] = session.size(&COARSE, &[]);
    let end_s = session.size(0.12, 0.3);
    let mut changes: Vec<String> = coarse.iter().map(|&change| change.to_owned()).collect();
    changes.extend([
        TOLERANCE.to_owned(),
        "coupling.scheme=kernel".to_owned(),
        format!("time.end_s={end_s:?}"),
    ]);
    let canopy = case_runs::case("flat-circular-tunnel", CANOPY, None, &changes)?;
    let lines = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX, &IMPULSE_LINES];
    let variant = session.size(Some("quick"), None);
    let equal_cells = "air.refinement.around=nothing";
    let changes = [TOLERANCE, "coupling.scheme=kernel", equal_cells].map(str::to_owned);
    let plate = case_runs::case("flexible-plate", flexible_plate::SOURCE, variant, &changes)?;
    let edge = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX, &IMPULSE_SUPPORTS];
    for (case, routes, what, support) in [
        (canopy, lines, "canopy", "lines"),
        (plate, edge, "plate", "held edge"),
    ] {
        let outcome = case_runs::run(session, case)?;
        let [markers, momentum_box, supports] = outcome.forces(routes);
        session.row(
            outcome.cells,
            format!("{what}: drag by markers, N"),
            markers,
        );
        for (force, route) in [(momentum_box, "momentum box"), (supports, support)] {
            session
                .row(
                    outcome.cells,
                    format!("{what}: {route} against markers"),
                    (force / markers - 1.0).abs(),
                )
                .gate(Gate::AtMost(BAND));
        }
    }
    Ok(())
}
