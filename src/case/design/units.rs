//! Quantities in the units that a designer writes them in.

use super::super::density::ALTITUDES_M;
use super::super::problem::Problem;
use super::super::values::{positive, within};

/// m of a foot.
const FOOT_M: f64 = 0.3048;

/// m/s of a knot.
const KNOT_M_S: f64 = 1852.0 / 3600.0;

/// kg of a pound.
const POUND_KG: f64 = 0.453_592_37;

/// Standard acceleration of gravity [m/s²].
pub(super) const GRAVITY_M_S2: f64 = 9.80665;

/// The one of several keys of a design that is written, in SI units: name, value, unit in SI.
fn one_of(table: &str, keys: &[(&str, Option<f64>, f64)]) -> Result<Option<f64>, Problem> {
    let mut written = keys
        .iter()
        .filter_map(|(name, value, unit)| Some((name, (*value)?, unit)));
    let Some((name, value, unit)) = written.next() else {
        return Ok(None);
    };
    if let Some((other, ..)) = written.next() {
        return Err(Problem::new(
            format!("{table}.{other}"),
            format!("{table}.{name} and {table}.{other} say the same thing twice"),
            "keep one of the two",
        ));
    }
    let key = format!("{table}.{name}");
    Ok(Some(positive_or_altitude(&key, value)? * unit))
}

/// Sizes, speeds and masses are positive.
fn positive_or_altitude(key: &str, value: f64) -> Result<f64, Problem> {
    if key.contains(".altitude_") {
        return Ok(value);
    }
    positive(key, value)
}

/// A length [m].
pub(super) fn length_m(
    table: &str,
    name: &str,
    m: Option<f64>,
    ft: Option<f64>,
) -> Result<Option<f64>, Problem> {
    let [in_m, in_ft] = ["m", "ft"].map(|unit| format!("{name}_{unit}"));
    one_of(table, &[(&in_m, m, 1.0), (&in_ft, ft, FOOT_M)])
}

/// A mass [kg].
pub(super) fn mass_kg(
    table: &str,
    name: &str,
    kg: Option<f64>,
    lb: Option<f64>,
) -> Result<Option<f64>, Problem> {
    let [in_kg, in_lb] = ["kg", "lb"].map(|unit| format!("{name}_{unit}"));
    one_of(table, &[(&in_kg, kg, 1.0), (&in_lb, lb, POUND_KG)])
}

/// A speed that is written in m/s, km/h, ft/s or kt [m/s].
pub(super) fn speed_m_s(table: &str, written: [Option<f64>; 4]) -> Result<Option<f64>, Problem> {
    let [m_s, km_h, ft_s, kt] = written;
    one_of(
        table,
        &[
            ("speed_m_s", m_s, 1.0),
            ("speed_km_h", km_h, 1.0 / 3.6),
            ("speed_ft_s", ft_s, FOOT_M),
            ("speed_kt", kt, KNOT_M_S),
        ],
    )
}

/// An altitude of the standard atmosphere; sea level if absent [m].
pub(super) fn altitude_m(table: &str, m: Option<f64>, ft: Option<f64>) -> Result<f64, Problem> {
    let [lowest, highest] = ALTITUDES_M;
    let altitude_m = length_m(table, "altitude", m, ft)?.unwrap_or(0.0);
    within(&format!("{table}.altitude_m"), altitude_m, lowest, highest)
}
