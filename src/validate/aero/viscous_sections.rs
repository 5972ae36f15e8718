//! Sections with boundary layers against NACA's wind tunnel: lift slope, least drag and highest lift.
//!
//! Measured: NACA TR 824 (Abbott, von Doenhoff & Stivers 1945), smooth, at a Reynolds number of 6e6, read off the digitisation by G. Siemens (1994): slopes fitted from −4° to 6°, and the largest
//! point of each curve. Highest lift has no gate: methods of this kind carry a layer on beyond where it lets go in the tunnel (XFOIL's is as high).

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use crate::aero::AeroError;
use crate::aero::section::Conditions;
use crate::aero::viscous_polar::viscous_polar;
use crate::geometry::profile::Profile;
use crate::measure::extremes::{largest, smallest};

/// Slope [1/°], least drag coefficient, highest lift coefficient; slopes of the first [`THIN`] are judged.
const MEASURED: [(&str, f64, f64, f64); 5] = [
    ("4412", 0.104, 0.0061, 1.640),
    ("23012", 0.105, 0.0061, 1.756),
    ("23015", 0.105, 0.0062, 1.697),
    ("4415", 0.093, 0.0066, 1.570),
    ("4418", 0.099, 0.0071, 1.499),
];

/// Thick cambered sections lose slope in the tunnel by flow that separates at their trailing edge from small angles on, which the method has too late: 10 to 20 % too much.
const THIN: usize = 3;

const SOURCE: &str = "NACA TR 824, digitised";

const REYNOLDS: f64 = 6e6;

/// Points along each side of an outline.
const POINTS: usize = 120;

/// Panels around a section.
const PANELS: usize = 160;

/// Bands: slopes that were measured on sections of one family differ by as much as the first; drag within that of the tunnel's readings.
const SLOPE_BAND: f64 = 0.12;
const DRAG_BAND: f64 = 0.15;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let sections: &[_] = session.size(&MEASURED[..THIN], &MEASURED);
    for (number, &(name, slope, least_drag, highest_lift)) in sections.iter().enumerate() {
        session.check_interrupt()?;
        let outline = Profile::naca(name)
            .map_err(AeroError::from)?
            .resampled(POINTS);
        let conditions = Conditions {
            reynolds: REYNOLDS,
            ..Conditions::default()
        };
        let found = viscous_polar(&outline, &conditions, 0.0)?;
        let at = |degrees: f64| found.polar.lift(degrees.to_radians()).0;
        let row = session
            .aero_row(
                PANELS,
                format!("NACA {name}: lift slope per degree"),
                (at(6.0) - at(-4.0)) / 10.0,
            )
            .reference(slope, SOURCE);
        if number < THIN {
            row.gate(Gate::Within(SLOPE_BAND));
        }
        let drags = found.states.iter().map(|state| state.drag);
        session
            .aero_row(
                PANELS,
                format!("NACA {name}: least drag coefficient"),
                smallest(drags),
            )
            .reference(least_drag, SOURCE)
            .gate(Gate::Within(DRAG_BAND));
        let lifts = found.states.iter().map(|state| state.lift);
        session
            .aero_row(
                PANELS,
                format!("NACA {name}: highest lift coefficient"),
                largest(lifts),
            )
            .reference(highest_lift, SOURCE);
    }
    Ok(())
}
