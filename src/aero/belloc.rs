//! The rigid paraglider wing that Belloc measured in a wind tunnel, with what is known of its section.
//!
//! Belloc, Wind tunnel investigation of a rigid paraglider reference wing, Journal of Aircraft 52 (2015) 703: a wing at 1/8 scale with an arched
//! span, NACA 23015 throughout, in air of 40 m/s. Its table gives the points at 60 % of the chord; everything varies linearly between them.
//! The section's polar is one of XFOIL's method at the root's Reynolds number; the tips, at a third of it, take the same.

use std::sync::Arc;

use glam::DVec3;

use super::AeroError;
use super::polar::{Polar, PolarPoint, SectionFlow};
use super::surface::{Station, Wing};
use crate::geometry::profile::Profile;

/// Area that the coefficients refer to: the wing laid flat [m²].
pub const REFERENCE_AREA_M2: f64 = 0.44625;

/// Air speed [m/s].
pub const SPEED_M_S: f64 = 40.0;

/// y, z (down) and chord [m], and twist [degrees], from the root to a tip.
const STATIONS: [[f64; 4]; 7] = [
    [0.0, -0.375, 0.350, 0.0],
    [0.178, -0.362, 0.339, 0.0],
    [0.344, -0.325, 0.308, 0.0],
    [0.486, -0.265, 0.259, 0.0],
    [0.595, -0.188, 0.198, 0.0],
    [0.664, -0.097, 0.137, 3.0],
    [0.688, 0.0, 0.107, 3.0],
];

const MEASURED: &str = include_str!("data/belloc_2015.csv");
const SECTION: &str = include_str!("data/naca_23015.csv");

/// Half of the wing, which is symmetric.
pub fn wing() -> Result<Wing, AeroError> {
    let profile = Arc::new(Profile::naca("23015")?);
    let stations = STATIONS
        .map(|[y, down, chord_m, twist_degrees]| Station {
            position_m: DVec3::new(0.0, y, -down),
            chord_m,
            twist_rad: twist_degrees.to_radians(),
            roll_rad: 0.0,
            profile: Arc::clone(&profile),
        })
        .to_vec();
    let mut wing = Wing {
        stations,
        chord_fraction: 0.6,
        is_symmetric: true,
    };
    wing.roll_along_span();
    Ok(wing)
}

/// The section's polar, and its lift in potential flow.
pub fn section() -> Result<(Polar, SectionFlow), AeroError> {
    let polar = Polar::new(rows(SECTION))?;
    let flow = SectionFlow::of(&Arc::new(Profile::naca("23015")?))?;
    Ok((polar, flow))
}

/// Measured angle of attack, lift and drag coefficient of the wing, without sideslip.
#[must_use]
pub fn measured() -> Vec<PolarPoint> {
    rows(MEASURED)
}

/// Stream at an angle of attack.
#[must_use]
pub fn stream_m_s(angle_rad: f64) -> DVec3 {
    SPEED_M_S * DVec3::new(angle_rad.cos(), 0.0, angle_rad.sin())
}

/// Angle in degrees, lift and drag coefficient per line, behind comments and a header.
fn rows(text: &str) -> Vec<PolarPoint> {
    text.lines()
        .filter_map(|line| {
            let numbers: Vec<f64> = line
                .split(',')
                .map(|word| word.trim().parse().ok())
                .collect::<Option<_>>()?;
            let &[degrees, lift, drag] = numbers.as_slice() else {
                return None;
            };
            Some(PolarPoint {
                angle_rad: degrees.to_radians(),
                lift,
                drag,
                moment: None,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's span and areas (full scale over 8 and 64), and how many rows the tables have.
    #[test]
    fn the_wing_has_the_published_size() {
        let wing = wing().unwrap();
        assert!((wing.projected_span_m() / (11.0 / 8.0) - 1.0).abs() < 0.002);
        assert!((wing.flat_area_m2() / REFERENCE_AREA_M2 - 1.0).abs() < 0.01);
        assert_eq!((measured().len(), rows(SECTION).len()), (51, 25));
        section().unwrap();
    }
}
