//! The stability map: the fastest flow that every operator survives, over the relaxation time.
//!
//! The numbers are measured, not derived: `ripstop bench stability` writes the table that lies beside this file (see
//! [`crate::bench::stability`] for the flow). To refresh it, copy the new `stability.csv` here.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::Operator;
use super::eddy_viscosity::{EddyViscosity, EddyViscosityModel};

/// τ − ½ of the map, descending.
pub const VISCOUS_PARTS: [f64; 7] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// Constants below this share of the measured one count as no eddy viscosity.
const SMALLEST_SHARE: f64 = 0.6;

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

static MAP: LazyLock<Vec<Point>> = LazyLock::new(|| {
    csv::Reader::from_reader(include_str!("stability.csv").as_bytes())
        .into_deserialize()
        // A test reads every line.
        .filter_map(Result::ok)
        .collect()
});

/// The measured map.
#[must_use]
pub fn map() -> &'static [Point] {
    &MAP
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
    let model = eddy_viscosity
        .filter(|eddy| eddy.constant >= SMALLEST_SHARE * measured(eddy.model).constant)
        .map(|eddy| eddy.model);
    let survived = |part: f64| {
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
    };
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
    fn every_line_of_the_map_is_read() {
        let lines = include_str!("stability.csv").trim().lines().count();
        assert_eq!(map().len() + 1, lines);
        for point in map() {
            assert!(VISCOUS_PARTS.contains(&point.viscous_part), "{point:?}");
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
