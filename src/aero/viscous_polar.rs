//! Polars of sections by the viscous method ([`super::section`]).
//!
//! Angles run from the stream without lift outwards. A polar ends where the method has no solution for more than two angles in a row, or
//! four angles beyond the highest lift: farther on flow separates widely, and boundary layers do not describe it.
//!
//! Trailing edges are open by 0.002 chords, as a seam's is: with an edge that is quite sharp the method has a second solution with a third less lift,
//! and may come to it (of NACA 2417, 23015). From 0.001 to 0.003 lift changes by 1 to 2 %.

use glam::DVec2;

use super::AeroError;
use super::polar::{Polar, PolarPoint};
use super::section::{Conditions, Section, SectionError, SectionState};

/// Panels around a section.
const PANELS: usize = 160;

/// Height of the trailing edge, per chord, at least.
const OPENING: f64 = 0.002;

/// Angles that are tried [°].
const ANGLES_DEG: [i32; 2] = [-24, 24];

/// Angles in a row that may be missing.
const LONGEST_GAP: i32 = 2;

/// Angles that are kept beyond the highest lift.
const BEYOND_STALL: i32 = 4;

/// Fewest angles that make a polar.
const FEWEST: usize = 8;

/// A polar by the viscous method.
#[derive(Debug, Clone, PartialEq)]
pub struct ViscousPolar {
    /// The polar.
    pub polar: Polar,
    /// Whether it reaches beyond the highest lift.
    pub stalls: bool,
    /// States that it is made of, by growing angle.
    pub states: Vec<SectionState>,
}

/// Computes the polar of an outline, given from the trailing edge along the lower side around the nose back to it, over the chord.
///
/// # Errors
///
/// When the outline is no section, or too few angles have a solution.
pub fn viscous_polar(
    outline: &[DVec2],
    conditions: &Conditions,
    more_drag: f64,
) -> Result<ViscousPolar, AeroError> {
    let section =
        Section::new(&opened(outline), PANELS).map_err(|why| AeroError::Polar(why.to_string()))?;
    let [from, to] = ANGLES_DEG;
    let angles: Vec<f64> = (from..=to).map(|a| f64::from(a).to_radians()).collect();
    let found = section.polar_while(&angles, conditions, goes_on);
    let (states, stalls) = kept(&found, conditions)?;
    let points = states.iter().map(|state| PolarPoint {
        angle_rad: state.angle_rad,
        lift: state.lift,
        drag: state.drag + more_drag,
        moment: Some(state.moment_quarter_chord),
    });
    Ok(ViscousPolar {
        polar: Polar::new(points.collect())?,
        stalls,
        states,
    })
}

/// The states that make a polar, of those at [`ANGLES_DEG`], and whether it reaches beyond the highest lift.
fn kept(
    found: &[Result<SectionState, SectionError>],
    conditions: &Conditions,
) -> Result<(Vec<SectionState>, bool), AeroError> {
    let [from, to] = ANGLES_DEG;
    let all: Vec<(i32, &SectionState)> = (from..=to)
        .zip(found)
        .filter_map(|(degrees, state)| Some((degrees, state.as_ref().ok()?)))
        .collect();
    let by_lift = |a: &&(i32, &SectionState), b: &&(i32, &SectionState)| {
        a.1.lift.abs().total_cmp(&b.1.lift.abs())
    };
    let Some(middle) = all.iter().min_by(by_lift).map(|(degrees, _)| *degrees) else {
        // That of the angle which was tried first tells most.
        let mut errors: Vec<(i32, String)> = (from..=to)
            .zip(found)
            .filter_map(|(degrees, state)| Some((degrees, state.as_ref().err()?.to_string())))
            .collect();
        errors.sort_by_key(|(degrees, _)| degrees.abs());
        let why = errors.first().map(|(_, why)| why);
        return Err(AeroError::Polar(why.map_or_else(
            || "no angle has a solution".to_owned(),
            ToString::to_string,
        )));
    };
    let upwards: Vec<_> = all.iter().filter(|(d, _)| *d >= middle).copied().collect();
    let downwards: Vec<_> = all
        .iter()
        .rev()
        .filter(|(d, _)| *d < middle)
        .copied()
        .collect();
    let (upper, stalls) = branch(&upwards, middle);
    let (lower, _) = branch(&downwards, middle);
    let states: Vec<SectionState> = lower.into_iter().rev().chain(upper).cloned().collect();
    if states.len() < FEWEST {
        return Err(AeroError::Polar(format!(
            "only {} angles from {from} to {to} degrees have a solution at a Reynolds number of {:.2e}",
            states.len(),
            conditions.reynolds
        )));
    }
    Ok((states, stalls))
}

/// An outline whose trailing edge is open by at least [`OPENING`], by shear.
fn opened(outline: &[DVec2]) -> Vec<DVec2> {
    let (Some(first), Some(last)) = (outline.first(), outline.last()) else {
        return Vec::new();
    };
    let lacking = (OPENING - (last.y - first.y)).max(0.0);
    let by_length = |a: &(usize, &DVec2), b: &(usize, &DVec2)| {
        a.1.length_squared().total_cmp(&b.1.length_squared())
    };
    let nose = outline
        .iter()
        .enumerate()
        .min_by(by_length)
        .map_or(0, |(k, _)| k);
    let moved = |(k, p): (usize, &DVec2)| {
        let side = if k < nose { -0.5 } else { 0.5 };
        *p + DVec2::Y * (side * lacking * p.x)
    };
    outline.iter().enumerate().map(moved).collect()
}

/// Whether angles farther out than these may be kept, one degree apart from the zero of the lift without viscosity outwards; with viscosity it may lie some degrees farther out.
fn goes_on(outwards: &[Option<&SectionState>]) -> bool {
    let found = || {
        let places = outwards.iter().enumerate();
        places.filter_map(|(place, state)| Some((place, (*state)?.lift.abs())))
    };
    let least = found().min_by(|a, b| a.1.total_cmp(&b.1));
    let middle = least.map_or(0, |(place, _)| place);
    let (mut last, mut highest) = (middle, (middle, 0.0));
    for (place, lift) in found().skip_while(|(place, _)| *place < middle) {
        last = place;
        if lift >= highest.1 {
            highest = (place, lift);
        }
    }
    let next = outwards.len();
    next <= last + LONGEST_GAP as usize + 1 && next <= highest.0 + BEYOND_STALL as usize
}

/// Angles from the middle outwards that are kept, and whether they go beyond the highest lift, or the lowest.
fn branch<'a>(outwards: &[(i32, &'a SectionState)], middle: i32) -> (Vec<&'a SectionState>, bool) {
    let mut kept: Vec<&SectionState> = Vec::new();
    let (mut last, mut highest) = (middle, (middle, 0.0));
    for &(degrees, state) in outwards {
        if (degrees - last).abs() > LONGEST_GAP + 1 || (degrees - highest.0).abs() > BEYOND_STALL {
            break;
        }
        if state.lift.abs() >= highest.1 {
            highest = (degrees, state.lift.abs());
        }
        kept.push(state);
        last = degrees;
    }
    (kept, last != highest.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::profile::Profile;

    /// What is left out of a sweep would not have been kept: with edges that are turned up and down, whose lift vanishes some degrees from where it does without viscosity, too.
    #[test]
    fn nothing_is_left_out_that_is_kept() {
        let angles = (ANGLES_DEG[0]..=ANGLES_DEG[1]).map(|a| f64::from(a).to_radians());
        let angles: Vec<f64> = angles.collect();
        for (profile, turn_deg, reynolds) in
            [("2417", -8.0, 1e6), ("2417", 24.0, 1e6), ("9412", 0.0, 2e5)]
        {
            let down = |x: f64| f64::to_radians(turn_deg).tan() * (x - 0.75).max(0.0);
            let outline: Vec<DVec2> = Profile::naca(profile)
                .unwrap()
                .resampled(100)
                .iter()
                .map(|p| *p - DVec2::Y * down(p.x))
                .collect();
            let conditions = Conditions {
                reynolds,
                critical_amplification: 9.0,
                forced_transition: [Some(0.05), None],
            };
            let section = Section::new(&opened(&outline), PANELS).unwrap();
            let of = |found: &[Result<SectionState, SectionError>]| {
                let (states, stalls) = kept(found, &conditions).unwrap();
                let lifts: Vec<f64> = states.iter().map(|state| state.lift).collect();
                (lifts, stalls)
            };
            let whole = of(&section.polar(&angles, &conditions));
            let left_out = of(&section.polar_while(&angles, &conditions, goes_on));
            assert_eq!(whole, left_out, "{profile}, {turn_deg} degrees");
            assert!(
                whole.0.len() > 12,
                "{profile}, {turn_deg} degrees: {whole:?}"
            );
        }
    }

    /// A section that NACA measured: slope, least drag and highest lift of 23012 (TR 824, smooth, 6e6: 0.105 per degree, 0.0061, 1.76), and a polar that ends beyond its stall.
    #[test]
    fn a_computed_polar_reaches_its_stall() {
        let outline = Profile::naca("23012").unwrap().resampled(100);
        let conditions = Conditions {
            reynolds: 6e6,
            critical_amplification: 9.0,
            forced_transition: [None; 2],
        };
        let computed = viscous_polar(&outline, &conditions, 0.0).unwrap();
        let polar = &computed.polar;
        assert!(computed.stalls);
        let slope = (polar.lift(0.1).0 - polar.lift(0.0).0) / 0.1f64.to_degrees();
        assert!((slope / 0.105 - 1.0).abs() < 0.08, "{slope}");
        let drags = computed.states.iter().map(|state| state.drag);
        let least = drags.fold(f64::INFINITY, f64::min);
        assert!((least / 0.0061 - 1.0).abs() < 0.15, "{least}");
        let lifts = computed.states.iter().map(|state| state.lift);
        let highest = lifts.fold(0.0, f64::max);
        assert!((highest / 1.76 - 1.0).abs() < 0.12, "{highest}");
        // What is added is drag alone.
        let more = viscous_polar(&outline, &conditions, 0.01).unwrap().polar;
        assert!((more.drag(0.05) - polar.drag(0.05) - 0.01).abs() < 1e-12);
        assert_eq!(more.lift(0.05), polar.lift(0.05));
    }

    /// Whether layers are tripped or not, a sharp trailing edge does not take a third of the lift.
    #[test]
    fn sharp_trailing_edges_have_their_lift() {
        for (name, lift) in [("2417", 0.22), ("23015", 0.13)] {
            let outline = Profile::naca(name).unwrap().resampled(100);
            for place in [0.03, 0.05, 0.1] {
                let conditions = Conditions {
                    reynolds: 0.92e6,
                    critical_amplification: 9.0,
                    forced_transition: [Some(place); 2],
                };
                let polar = viscous_polar(&outline, &conditions, 0.0).unwrap().polar;
                let slope = (polar.lift(0.1).0 - polar.lift(0.0).0) / 0.1;
                assert!((polar.lift(0.0).0 - lift).abs() < 0.04, "{name} {place}");
                assert!((5.5..6.5).contains(&slope), "{name} {place}: {slope}");
            }
        }
    }

    #[test]
    fn what_is_no_section_is_refused() {
        let line = vec![DVec2::X; 40];
        let conditions = Conditions::default();
        assert!(matches!(
            viscous_polar(&line, &conditions, 0.0),
            Err(AeroError::Polar(_))
        ));
    }
}
