//! Polars of the strips of a wing.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use crate::aero::AeroError;
use crate::aero::polar::{Polar, SectionFlow};
use crate::aero::surface::Wing;
use crate::case::bare_wing::BareWing;

/// Thinnest profile that panels of two sides make sense of, over the chord.
const LEAST_THICKNESS: f64 = 0.005;

/// Polars and potential flow of every strip, and the wing cut into them.
#[derive(Debug)]
pub struct SectionsOfWing {
    /// The wing, one strip between neighbouring stations.
    pub wing: Wing,
    /// Of every strip.
    pub strips: Vec<(Polar, SectionFlow)>,
    /// Reynolds number of every strip, on its chord.
    pub reynolds: Vec<f64>,
}

/// Where a strip lies between the stations of the case.
struct Place {
    /// Number of the station before, and how far the strip's middle is to the next.
    station: usize,
    share: f64,
    reynolds: f64,
}

/// Cuts the wing into strips and finds their polars.
///
/// # Errors
///
/// When the wing makes no surface.
pub fn sections(case: &BareWing) -> Result<SectionsOfWing, AeroError> {
    for profile in &case.profiles {
        let thickness = profile.outline.thickness();
        if thickness < LEAST_THICKNESS {
            return Err(AeroError::Surface(format!(
                "profile {} is {:.2} % thick: panels of both sides cannot be told apart below {:.1} %; a single skin is computed with the thickness of its leading edge, 1 % or more",
                profile.name,
                100.0 * thickness,
                100.0 * LEAST_THICKNESS
            )));
        }
    }
    let wing = case.wing.divided(case.strips, case.tip_clustering)?;
    let places = places(case, &wing);
    let flows: Vec<SectionFlow> = (case.profiles.par_iter())
        .map(|profile| SectionFlow::of(&profile.outline))
        .collect::<Result<_, _>>()?;
    let polars = case.profiles.iter().map(|profile| match &profile.polar {
        Some(polar) => Ok(Arc::new(polar.clone())),
        None => Err(AeroError::Polar(format!(
            "profile {} has none",
            profile.name
        ))),
    });
    let polars: Vec<Arc<Polar>> = polars.collect::<Result<_, _>>()?;
    let strips = places.iter().map(|place| {
        let [a, b] = [0, 1].map(|k| case.station_profiles[place.station + k]);
        if a == b {
            return (polars[a].as_ref().clone(), flows[a]);
        }
        let mix = |x: f64, y: f64| x + place.share * (y - x);
        let flow = SectionFlow {
            slope_per_rad: mix(flows[a].slope_per_rad, flows[b].slope_per_rad),
            zero_lift_rad: mix(flows[a].zero_lift_rad, flows[b].zero_lift_rad),
        };
        (polars[a].between(&polars[b], place.share), flow)
    });
    Ok(SectionsOfWing {
        strips: strips.collect(),
        reynolds: places.iter().map(|place| place.reynolds).collect(),
        wing,
    })
}

fn places(case: &BareWing, divided: &Wing) -> Vec<Place> {
    let ends = lengths(&case.wing);
    let at = lengths(divided);
    at.windows(2)
        .zip(divided.stations.windows(2))
        .map(|(pair, stations)| {
            let middle = 0.5 * (pair[0] + pair[1]);
            let last = ends.len() - 2;
            let station = ends.partition_point(|&l| l <= middle).clamp(1, last + 1) - 1;
            let share = (middle - ends[station]) / (ends[station + 1] - ends[station]);
            let chord = 0.5 * (stations[0].chord_m + stations[1].chord_m);
            Place {
                station,
                share: share.clamp(0.0, 1.0),
                reynolds: case.speed_m_s * chord / case.viscosity_m2_s,
            }
        })
        .collect()
}

/// Lengths along the span's polygon up to every station [m].
fn lengths(wing: &Wing) -> Vec<f64> {
    let mut passed = 0.0;
    let steps = wing.stations.windows(2).map(|pair| {
        let step = pair[1].position_m - pair[0].position_m;
        passed += DVec2::new(step.y, step.z).length();
        passed
    });
    std::iter::once(0.0).chain(steps).collect()
}
