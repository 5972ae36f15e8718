//! Validation of low-order aerodynamics.

pub(super) mod belloc_wing;
pub(super) mod elliptic_wing;
pub(super) mod plane_section;
pub(super) mod potential_bodies;
pub(super) mod rectangular_wings;
pub(super) mod trim;
pub(super) mod viscous_sections;
pub(super) mod wing_stall;

use std::sync::Arc;

use glam::DVec3;

use super::report::Row;
use super::session::{Session, Stop};
use crate::aero::AeroError;
use crate::aero::potential_flow::{Flow, MEMORY_LIMIT, PotentialFlow};
use crate::aero::surface::{PanelSurface, Station, Wing};
use crate::aero::vortex_lattice::VortexLattice;
use crate::geometry::profile::Profile;

/// Who computes, whatever engine the air is on.
const ENGINE: &str = "cpu f64";

/// Angle of attack over which slopes are measured [rad].
const SMALL_ANGLE: f64 = 0.035;

impl From<AeroError> for Stop {
    fn from(error: AeroError) -> Self {
        Self::Refused(error.to_string())
    }
}

impl Session<'_> {
    /// Adds a row about so many panels.
    fn aero_row(&mut self, panels: usize, quantity: impl Into<String>, value: f64) -> &mut Row {
        let row = self.row([0; 3], quantity, value);
        row.panels = Some(panels);
        row.engine = Some(ENGINE);
        row.is_judged = true;
        row
    }
}

/// A stream of 1 m/s at an angle of attack.
fn stream(angle_rad: f64) -> DVec3 {
    DVec3::new(angle_rad.cos(), 0.0, angle_rad.sin())
}

/// The flow around a surface whose wake leaves along the stream, as it must for pressures and far wake to tell the same.
fn aligned_flow(surface: &PanelSurface, stream: DVec3) -> Result<Flow, Stop> {
    let flow = PotentialFlow::new(surface, stream, MEMORY_LIMIT)?;
    Ok(flow.solve(&[stream])?.remove(0))
}

/// Flows around a surface whose wake leaves along x.
fn flows(surface: &PanelSurface, angles_rad: &[f64]) -> Result<Vec<Flow>, Stop> {
    let streams: Vec<DVec3> = angles_rad.iter().map(|&a| stream(a)).collect();
    let flow = PotentialFlow::new(surface, DVec3::X, MEMORY_LIMIT)?;
    Ok(flow.solve(&streams)?)
}

/// A symmetric flat wing by its chords at some y, straight at a chord fraction.
fn flat_wing(sections: &[[f64; 2]], chord_fraction: f64, profile: &Arc<Profile>) -> Wing {
    Wing {
        stations: sections
            .iter()
            .map(|&[y, chord_m]| Station {
                position_m: DVec3::Y * y,
                chord_m,
                twist_rad: 0.0,
                roll_rad: 0.0,
                profile: Arc::clone(profile),
            })
            .collect(),
        chord_fraction,
        is_symmetric: true,
    }
}

/// Lift slope per radian of a wing by the panel method, on its flat area.
fn slope(wing: &Wing, per_side: usize) -> Result<f64, Stop> {
    let surface = wing.panels(per_side)?;
    let flow = flows(&surface, &[SMALL_ANGLE])?.remove(0);
    let lift = flow.trefftz_forces(&surface, 1.0).lift_n;
    Ok(lift / (0.5 * wing.flat_area_m2() * SMALL_ANGLE))
}

/// The same of a symmetric profile's mean surface by the vortex lattice.
fn lattice_slope(wing: &Wing, chordwise: usize) -> Result<f64, Stop> {
    let lattice = VortexLattice::new(wing, chordwise, DVec3::X)?;
    let circulation = lattice.circulations_m2_s(&[stream(SMALL_ANGLE)]).remove(0);
    let forces = lattice.trefftz_forces(&circulation, stream(SMALL_ANGLE), 1.0);
    Ok(forces.lift_n / (0.5 * wing.flat_area_m2() * SMALL_ANGLE))
}

/// A symmetric NACA profile of that thickness in percent.
fn symmetric_profile(percent: usize) -> Result<Arc<Profile>, Stop> {
    Ok(Arc::new(
        Profile::naca(&format!("00{percent:02}")).map_err(AeroError::from)?,
    ))
}
