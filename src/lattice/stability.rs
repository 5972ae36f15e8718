//! The stability maps: the fastest flow that every operator survives, over the relaxation time, of free turbulence and past bluff bodies.
//!
//! The numbers are measured, not derived: `ripstop bench stability` writes the tables that lie beside this file (see
//! [`crate::bench::stability`] for the flows). To refresh them, copy the new `stability.csv` and `stability_at_bodies.csv` here.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::Operator;
use super::eddy_viscosity::{EddyViscosity, EddyViscosityModel};

/// τ − ½ of the map, descending.
pub const VISCOUS_PARTS: [f64; 7] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// Constants below this share of the measured one count as no eddy viscosity.
const SMALLEST_SHARE: f64 = 0.6;

/// Mach number of the fastest wind that was tried past bodies: 0.15 cells per step.
pub const FASTEST_AT_BODIES: f64 = 0.26;

/// The eddy viscosity with which the map was measured.
#[must_use]
pub const fn measured(model: EddyViscosityModel) -> EddyViscosity {
    match model {
        EddyViscosityModel::Smagorinsky => EddyViscosity::smagorinsky(0.15),
        EddyViscosityModel::Wale => EddyViscosity::wale(0.5),
        // 2.5 C_s² for C_s = 0.15.
        EddyViscosityModel::Vreman => EddyViscosity::vreman(0.056),
    }
}

/// One line of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Engine and precision.
    pub engine: String,
    /// Collision operator.
    pub operator: Operator,
    /// Model of the eddy viscosity, with the constant of [`measured`].
    pub eddy_viscosity: Option<EddyViscosityModel>,
    /// τ − ½.
    pub viscous_part: f64,
    /// Between wind and x axis [°].
    pub angle_deg: f64,
    /// Largest Mach number tried that was survived, with all below it; zero if none was.
    pub mach: f64,
}

/// What stands in a wind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// A sphere.
    Sphere,
    /// A square plate normal to the wind.
    Plate,
    /// A wing of one chord's span with the profile NACA 0020, at 5°.
    Profile,
    /// The shipped flat circular canopy, which moves.
    Canopy,
}

impl Body {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sphere, Self::Plate, Self::Profile, Self::Canopy];

    /// Those of the map: rigid ones, of which a flow takes seconds.
    pub const OF_MAP: [Self; 3] = [Self::Sphere, Self::Plate, Self::Profile];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Plate => "plate",
            Self::Profile => "profile",
            Self::Canopy => "canopy",
        }
    }
}

/// One line of the map of flows past bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointAtBody {
    /// Engine and precision.
    pub engine: String,
    /// Collision operator.
    pub operator: Operator,
    /// Model of the eddy viscosity, with the constant of [`measured`].
    pub eddy_viscosity: Option<EddyViscosityModel>,
    /// τ − ½.
    pub viscous_part: f64,
    /// What stands in the wind.
    pub body: Body,
    /// Mach number of the fastest wind tried that was survived; zero if none was.
    pub mach: f64,
}

static MAP: LazyLock<Vec<Point>> = LazyLock::new(|| lines(include_str!("stability.csv")));

static MAP_AT_BODIES: LazyLock<Vec<PointAtBody>> =
    LazyLock::new(|| lines(include_str!("stability_at_bodies.csv")));

fn lines<T: serde::de::DeserializeOwned>(table: &str) -> Vec<T> {
    csv::Reader::from_reader(table.as_bytes())
        .into_deserialize()
        // A test reads every line.
        .filter_map(Result::ok)
        .collect()
}

/// The measured map of free turbulence.
#[must_use]
pub fn map() -> &'static [Point] {
    &MAP
}

/// The measured map of flows past bodies.
#[must_use]
pub fn map_at_bodies() -> &'static [PointAtBody] {
    &MAP_AT_BODIES
}

/// The model that an eddy viscosity counts as: a small constant is none.
fn model_of(eddy_viscosity: Option<EddyViscosity>) -> Option<EddyViscosityModel> {
    eddy_viscosity
        .filter(|eddy| eddy.constant >= SMALLEST_SHARE * measured(eddy.model).constant)
        .map(|eddy| eddy.model)
}

/// Largest Mach number survived at every angle by an operator at τ − ½ = `viscous_part`, interpolated over its logarithm between the lines
/// of the map. `None` if nothing like it was measured. `precision` as engines name it (`f64`, `f32`, `f16-storage`).
#[must_use]
pub fn largest_mach(
    operator: Operator,
    eddy_viscosity: Option<EddyViscosity>,
    precision: &str,
    viscous_part: f64,
) -> Option<f64> {
    let model = model_of(eddy_viscosity);
    interpolated(viscous_part, |part| {
        map()
            .iter()
            .filter(|point| {
                point.operator == operator
                    && point.eddy_viscosity == model
                    && point.engine.ends_with(precision)
                    && point.viscous_part == part
            })
            .map(|point| point.mach)
            .reduce(f64::min)
    })
}

/// Mach number of the fastest wind that an operator survived at every body of the map, in single precision (double precision breaks down
/// alike). Otherwise as [`largest_mach`].
#[must_use]
pub fn largest_mach_at_bodies(
    operator: Operator,
    eddy_viscosity: Option<EddyViscosity>,
    viscous_part: f64,
) -> Option<f64> {
    let model = model_of(eddy_viscosity);
    interpolated(viscous_part, |part| {
        map_at_bodies()
            .iter()
            .filter(|point| {
                point.operator == operator
                    && point.eddy_viscosity == model
                    && point.viscous_part == part
            })
            .map(|point| point.mach)
            .reduce(f64::min)
    })
}

/// A limit between those of the lines, over the logarithm of τ − ½.
fn interpolated(viscous_part: f64, survived: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let [first, .., last] = VISCOUS_PARTS;
    let sought = viscous_part.clamp(last, first);
    let after = VISCOUS_PARTS
        .iter()
        .position(|&part| part <= sought)?
        .max(1);
    let [upper, lower] = [VISCOUS_PARTS[after - 1], VISCOUS_PARTS[after]];
    let share = (sought / lower).ln() / (upper / lower).ln();
    Some(share * survived(upper)? + (1.0 - share) * survived(lower)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_maps_is_read() {
        let lines = |table: &str| table.trim().lines().count();
        assert_eq!(map().len() + 1, lines(include_str!("stability.csv")));
        let at_bodies = map_at_bodies();
        assert_eq!(
            at_bodies.len() + 1,
            lines(include_str!("stability_at_bodies.csv"))
        );
        let parts = map().iter().map(|point| point.viscous_part);
        for part in parts.chain(at_bodies.iter().map(|point| point.viscous_part)) {
            assert!(VISCOUS_PARTS.contains(&part), "{part}");
        }
        // Each operator, with and without each model, past each body.
        let settings = Operator::ALL.len() * 4 * VISCOUS_PARTS.len();
        assert_eq!(at_bodies.len(), settings * Body::OF_MAP.len());
    }

    /// What the map is for: one operator needs an eddy viscosity past bodies, one stands without.
    #[test]
    fn bodies_ask_for_more_than_turbulence() {
        for part in VISCOUS_PARTS {
            let at_bodies = |operator| largest_mach_at_bodies(operator, None, part).unwrap();
            assert!(at_bodies(Operator::StabilisedRegularised) >= FASTEST_AT_BODIES);
            let regularised = Operator::RecursiveRegularised;
            assert_eq!(largest_mach(regularised, None, "f32", part), Some(0.6));
            assert_eq!(at_bodies(regularised) < 0.1, part <= 1e-3, "{part}");
        }
    }

    #[test]
    fn between_lines_the_limit_is_interpolated() {
        let operator = Operator::TwoRelaxationTimes;
        let at = |part: f64| largest_mach(operator, None, "f32", part).unwrap();
        for pair in VISCOUS_PARTS.windows(2) {
            let between = at((pair[0] * pair[1]).sqrt());
            assert!((between - 0.5 * (at(pair[0]) + at(pair[1]))).abs() < 1e-12);
        }
        assert_eq!(at(1e-9), at(1e-7));
        assert_eq!(at(3.0), at(1e-1));
        // What the map is for: this operator needs viscosity.
        assert!(at(1e-7) < at(1e-1));
        assert_eq!(largest_mach(operator, None, "f8", 1e-3), None);
    }
}
