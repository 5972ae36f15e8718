//! Polars of the strips of a wing.

use rayon::prelude::*;

use crate::aero::AeroError;
use crate::aero::polar::{Polar, SectionFlow};
use crate::aero::section::Conditions;
use crate::aero::surface::Wing;
use crate::aero::viscous_polar::viscous_polar;
use crate::case::bare_wing::{BareProfile, BareWing, SectionPolar};

/// Thinnest profile that panels of two sides make sense of, over the chord.
const LEAST_THICKNESS: f64 = 0.005;

/// Points along each side of an outline whose polar is computed.
const OUTLINE_PER_SIDE: usize = 120;

/// Largest over least Reynolds number up to which one polar stands for all strips.
const NEARLY_ONE: f64 = 1.3;

/// Least Reynolds number of a computed polar; strips below it, as at tips that end in a point, have that of this one.
pub const LEAST_REYNOLDS: f64 = 5e4;

/// Polars and potential flow of every strip, and the wing cut into them.
#[derive(Debug)]
pub struct SectionsOfWing {
    /// The wing, one strip between neighbouring stations.
    pub wing: Wing,
    /// Of every strip.
    pub strips: Vec<(Polar, SectionFlow)>,
    /// Width of every strip along the span's polygon of the case [m]. Where an arch is cut into few strips, their panels are narrower.
    pub widths_m: Vec<f64>,
    /// Reynolds number of every strip, on its chord.
    pub reynolds: Vec<f64>,
    /// Whether strips with computed polars lie below the least Reynolds number for which these are computed.
    pub below_range: bool,
    /// Whether all computed polars reach beyond the highest lift.
    pub stalls: bool,
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
    let cuts_m = case.wing.strip_ends_m(case.strips, case.tip_clustering);
    let places = places(case, &wing, &cuts_m);
    let flows: Vec<SectionFlow> = (case.profiles.par_iter())
        .map(|profile| SectionFlow::of(&profile.outline))
        .collect::<Result<_, _>>()?;
    let reynolds: Vec<f64> = places.iter().map(|place| place.reynolds).collect();
    let families = (case.profiles.par_iter().enumerate())
        .map(|(number, profile)| {
            // At those of its own strips.
            let own = places.iter().filter(|place| {
                let numbers = &case.station_profiles[place.station..=place.station + 1];
                numbers.contains(&number)
            });
            let own: Vec<f64> = own.map(|place| place.reynolds).collect();
            Family::of(profile, if own.is_empty() { &reynolds } else { &own })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let strips = places.iter().map(|place| {
        let [a, b] = [0, 1].map(|k| case.station_profiles[place.station + k]);
        let of = |profile: usize| families[profile].at(place.reynolds);
        if a == b {
            return (of(a), flows[a]);
        }
        let flow = flows[a].between(&flows[b], place.share);
        (of(a).between(&of(b), place.share), flow)
    });
    Ok(SectionsOfWing {
        strips: strips.collect(),
        widths_m: cuts_m.windows(2).map(|pair| pair[1] - pair[0]).collect(),
        below_range: places.iter().any(|place| {
            let numbers = [0, 1].map(|k| case.station_profiles[place.station + k]);
            let is_computed = numbers.iter().any(|&number| families[number].is_computed);
            is_computed && place.reynolds < LEAST_REYNOLDS
        }),
        stalls: families.iter().all(|family| family.stalls),
        reynolds,
        wing,
    })
}

/// Polars of a profile by growing Reynolds number; one that is given stands for all.
struct Family {
    polars: Vec<(f64, Polar)>,
    is_computed: bool,
    /// Whether all of them reach beyond the highest lift.
    stalls: bool,
}

impl Family {
    fn of(profile: &BareProfile, reynolds: &[f64]) -> Result<Self, AeroError> {
        let (critical_amplification, transition) = match &profile.polar {
            SectionPolar::Given(polar) => {
                return Ok(Self {
                    polars: vec![(1.0, polar.clone())],
                    is_computed: false,
                    stalls: true,
                });
            }
            SectionPolar::Computed {
                critical_amplification,
                transition,
            } => (*critical_amplification, *transition),
        };
        let outline = profile.outline.resampled(OUTLINE_PER_SIDE);
        let polars = members(reynolds)
            .into_par_iter()
            .map(|reynolds| {
                let conditions = Conditions {
                    reynolds,
                    critical_amplification,
                    forced_transition: transition,
                };
                viscous_polar(&outline, &conditions, 0.0).map(|found| (reynolds, found))
            })
            .collect::<Result<Vec<_>, _>>()
            .map_err(|why| {
                AeroError::Polar(format!(
                    "of profile {}: {why} (it is computed with an outline of {} points); mend its file, give the profile a polar (polar, polar_file), or of a mesh the unit (mesh.scale)",
                    profile.name,
                    2 * OUTLINE_PER_SIDE + 1
                ))
            })?;
        Ok(Self {
            stalls: polars.iter().all(|(_, found)| found.stalls),
            polars: (polars.into_iter())
                .map(|(reynolds, found)| (reynolds, found.polar))
                .collect(),
            is_computed: true,
        })
    }

    /// Between two members, over the logarithm of the Reynolds number.
    fn at(&self, reynolds: f64) -> Polar {
        let last = self.polars.len() - 1;
        let after = self.polars.partition_point(|(known, _)| *known < reynolds);
        if after == 0 || last == 0 {
            return self.polars[0].1.clone();
        }
        let [(low, a), (high, b)] = [
            &self.polars[after.min(last) - 1],
            &self.polars[after.min(last)],
        ];
        let share = (reynolds / low).ln() / (high / low).ln();
        a.between(b, share.clamp(0.0, 1.0))
    }
}

/// Reynolds numbers at which polars are computed: of the strips, the least, the largest and one between; one where they hardly differ.
fn members(reynolds: &[f64]) -> Vec<f64> {
    let low = reynolds
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min)
        .max(LEAST_REYNOLDS);
    let high = reynolds.iter().copied().fold(low, f64::max);
    if high < NEARLY_ONE * low {
        return vec![(low * high).sqrt()];
    }
    vec![low, (low * high).sqrt(), high]
}

/// Where the strips of the divided wing lie that end at these lengths along the span's polygon of the case [m].
fn places(case: &BareWing, divided: &Wing, cuts_m: &[f64]) -> Vec<Place> {
    let ends = case.wing.lengths_m();
    cuts_m
        .windows(2)
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
