//! Sections of the strips: polars and potential flow of the designed profiles, between which strips are mixed as the ribs are.

use std::sync::Arc;

use glam::DVec2;

use super::skin::Skin;
use super::{Settings, TrimError};
use crate::aero::AeroError;
use crate::aero::polar::{Polar, SectionFlow};
use crate::geometry::profile;
use crate::geometry::wing::Wing;
use crate::geometry::wing::section::{Profile, Side};

/// Points per side that stand for a profile.
const PROFILE_POINTS: usize = 100;

/// Polar and potential flow of every strip, from the middle to the tip.
pub(super) fn of_strips(
    wing: &Wing,
    skin: &Skin,
    settings: &Settings,
) -> Result<Vec<(Polar, SectionFlow)>, TrimError> {
    let flows = wing
        .profiles
        .iter()
        .map(section_flow)
        .collect::<Result<Vec<_>, _>>()?;
    let polars = wing
        .profiles
        .iter()
        .enumerate()
        .map(|(number, profile)| match settings.polars.get(number) {
            Some(Some(polar)) => Ok(polar.clone()),
            _ => Polar::paraglider(&flows[number], thickness(profile), settings.reynolds),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let strip = |u: &f64| {
        let rib = (u + 0.5 * wing.cells as f64).round() as usize;
        let ([a, b], share) = wing.frames[rib.min(wing.cells)].profiles;
        if a == b {
            return (polars[a].clone(), flows[a]);
        }
        let mix = |x: f64, y: f64| x + share * (y - x);
        let flow = SectionFlow {
            slope_per_rad: mix(flows[a].slope_per_rad, flows[b].slope_per_rad),
            zero_lift_rad: mix(flows[a].zero_lift_rad, flows[b].zero_lift_rad),
        };
        (polars[a].between(&polars[b], share), flow)
    };
    Ok(skin.strip_middles().iter().map(strip).collect())
}

fn thickness(profile: &Profile) -> f64 {
    (0..=PROFILE_POINTS)
        .map(|i| {
            let x = i as f64 / PROFILE_POINTS as f64;
            profile.height(Side::Upper, x) - profile.height(Side::Lower, x)
        })
        .fold(0.0, f64::max)
}

/// Lift of a rib's profile in potential flow.
fn section_flow(profile: &Profile) -> Result<SectionFlow, TrimError> {
    let place = |i: usize| {
        let angle = std::f64::consts::PI * i as f64 / PROFILE_POINTS as f64;
        0.5 * (1.0 - angle.cos())
    };
    let point = |side: Side, i: usize| {
        let x = place(i);
        DVec2::new(x, profile.height(side, x))
    };
    let lower = (1..=PROFILE_POINTS).rev().map(|i| point(Side::Lower, i));
    let upper = (0..=PROFILE_POINTS).map(|i| point(Side::Upper, i));
    let profile = profile::Profile::new(lower.chain(upper).collect()).map_err(AeroError::from)?;
    Ok(SectionFlow::of(&Arc::new(profile))?)
}
