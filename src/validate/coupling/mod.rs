//! Validation of the immersed boundary and of air coupled with fabric.

pub(super) mod canopy_opening;
mod case_runs;
pub(super) mod flag;
pub(super) mod flexible_plate;
pub(super) mod force_routes;
pub(super) mod immersed_boundary;
pub(super) mod levels_around_bodies;
pub(super) mod light_canopies;
pub(super) mod marker_spacing;
pub(super) mod spherical_couette;

use super::session::Stop;
use crate::simulation::{AirEngine, MarkerEngine};

/// Interpolates and spreads once, with the transfers that the engine needs; returns the total force on the air [lattice units].
fn exchange(
    air: &AirEngine,
    markers: &mut MarkerEngine,
    positions: &[[f64; 3]],
    velocities: &[[f64; 3]],
) -> Result<[f64; 3], Stop> {
    let outside = || Stop::Refused("a marker lies outside the air".to_owned());
    markers
        .send_markers(air, positions)?
        .map_err(|_| outside())?;
    markers
        .interpolate(air, positions)?
        .map_err(|_| outside())?;
    markers.fetch_air_velocities()?;
    let sent = markers.send_marker_forces(velocities);
    let formed = markers.spread(velocities);
    Ok(sent.or(formed).unwrap_or([f64::NAN; 3]))
}
