//! A tapered wing up to its stall against the wind tunnel: the shipped case `tapered-wing`.
//!
//! Measured: NACA TN 1270 (Neely, Bollech, Westrick & Graham 1947), wing 2.5-8-44,16, read off a digitisation of its curves.

use std::path::Path;

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use crate::aero::section::Conditions;
use crate::case::bare_wing::{BareWing, SectionPolar};
use crate::case::{Choices, SHIPPED, parse};
use crate::polar::{numbers, solve};

const SOURCE: &str = "NACA TN 1270, digitised";

/// Slope [1/°], highest lift coefficient and its angle [°], least drag coefficient.
const SLOPE: f64 = 0.0819;
const HIGHEST_LIFT: f64 = 1.538;
const ITS_ANGLE_DEG: f64 = 19.3;
const LEAST_DRAG: f64 = 0.0088;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let case = SHIPPED.iter().find(|(name, _)| *name == "tapered-wing");
    let text = case.map_or("", |(_, text)| *text);
    let case = parse(
        "tapered-wing.toml",
        text,
        Path::new("."),
        &Choices::default(),
    )
    .map_err(|why| Stop::Refused(why.to_string()))?;
    let Some(mut wing) = case.scene.bare_wing else {
        return Err(Stop::Refused(
            "the shipped case holds no wing by itself".to_owned(),
        ));
    };
    wing.angles_deg = (-8..=24).map(f64::from).collect();
    let strips: &[usize] = session.size(&[12], &[12, 24, 48]);
    for &count in strips {
        session.check_interrupt()?;
        wing.strips = count;
        let polar = solve(&wing)?;
        let found = numbers(&polar);
        let panels = polar.panels;
        let missed = polar
            .points
            .iter()
            .filter(|point| point.coefficients.is_none());
        let missed = missed.count() as f64;
        let name = |what: &str| format!("{what}, {count} strips");
        let nothing = (f64::NAN, f64::NAN);
        let (lift, angle) = found.highest_lift.unwrap_or(nothing);
        session
            .aero_row(
                panels,
                name("lift slope per degree"),
                found.lift_slope_per_deg.unwrap_or(f64::NAN),
            )
            .reference(SLOPE, SOURCE)
            .gate(Gate::Within(0.08));
        session
            .aero_row(panels, name("highest lift coefficient"), lift)
            .reference(HIGHEST_LIFT, SOURCE)
            .gate(Gate::Within(0.1));
        session
            .aero_row(panels, name("angle of the highest lift [deg]"), angle)
            .reference(ITS_ANGLE_DEG, SOURCE)
            .gate(Gate::Within(0.1));
        session
            .aero_row(
                panels,
                name("least drag coefficient"),
                found.least_drag.unwrap_or(nothing).0,
            )
            .reference(LEAST_DRAG, SOURCE)
            .gate(Gate::Within(0.2));
        session
            .aero_row(
                panels,
                name("angles at which sections and wing do not agree"),
                missed,
            )
            .gate(Gate::AtMost(0.0));
    }
    if session.size(false, true) {
        computed_sections(session, wing, strips[0])?;
    }
    Ok(())
}

/// The same wing by what is computed of its sections, as designers' wings are.
///
/// Layers of thick cambered sections let go too late ([`viscous_sections`](super::viscous_sections)), and the wing's with them.
fn computed_sections(session: &mut Session, mut wing: BareWing, strips: usize) -> Result<(), Stop> {
    session.check_interrupt()?;
    for profile in &mut wing.profiles {
        profile.polar = SectionPolar::Computed {
            critical_amplification: Conditions::default().critical_amplification,
            transition: [None; 2],
        };
    }
    wing.strips = strips;
    wing.angles_deg = (-8..=30).map(f64::from).collect();
    let polar = solve(&wing)?;
    let found = numbers(&polar);
    let nothing = (f64::NAN, f64::NAN);
    let (lift, angle) = found.highest_lift.unwrap_or(nothing);
    session
        .aero_row(
            polar.panels,
            "lift slope per degree, computed sections",
            found.lift_slope_per_deg.unwrap_or(f64::NAN),
        )
        .reference(SLOPE, SOURCE)
        .gate(Gate::Within(0.08));
    // No gates: they would be those of the sections' highest lift.
    for (what, value, measured) in [
        ("highest lift coefficient", lift, HIGHEST_LIFT),
        ("angle of the highest lift [deg]", angle, ITS_ANGLE_DEG),
    ] {
        session
            .aero_row(polar.panels, format!("{what}, computed sections"), value)
            .reference(measured, SOURCE);
    }
    Ok(())
}
