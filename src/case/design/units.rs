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

/// Units that keys name, and what one of each is in SI units.
const UNITS: [(&str, f64); 8] = [
    ("m", 1.0),
    ("ft", FOOT_M),
    ("kg", 1.0),
    ("lb", POUND_KG),
    ("m_s", 1.0),
    ("km_h", 1.0 / 3.6),
    ("ft_s", FOOT_M),
    ("kt", KNOT_M_S),
];

/// To six digits.
pub(super) fn rounded(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

/// True where a key is that quantity in one of the units, such as `speed_kt` of `speed`.
pub(super) fn is_quantity(key: &str, quantity: &str) -> bool {
    let unit = key
        .strip_prefix(quantity)
        .and_then(|rest| rest.strip_prefix('_'));
    unit.is_some_and(|unit| UNITS.iter().any(|(known, _)| *known == unit))
}

/// A quantity of a design, under the key and in the unit that it is written in.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Written {
    /// Dotted path of its key.
    pub(super) key: String,
    value: f64,
    /// One of its unit in SI units.
    unit: f64,
}

impl Written {
    /// The value in SI units.
    pub(super) const fn si(&self) -> f64 {
        self.value * self.unit
    }

    /// The value in SI units; refused outside a closed range in SI units, told by its own key and in its own unit.
    pub(super) fn within(&self, low: f64, high: f64) -> Result<f64, Problem> {
        let [lowest, highest] = [low, high].map(|bound| {
            if self.unit == 1.0 {
                bound
            } else {
                rounded(bound / self.unit)
            }
        });
        let value = within(&self.key, self.value, lowest, highest)?;
        Ok((value * self.unit).clamp(low, high))
    }
}

/// The one of several keys of a design that is written, each in one of [`UNITS`].
fn one_of(
    table: &str,
    quantity: &str,
    keys: &[(&str, Option<f64>)],
) -> Result<Option<Written>, Problem> {
    let mut written = keys.iter().filter_map(|(unit, value)| {
        let (_, in_si) = UNITS.iter().find(|(known, _)| known == unit)?;
        Some(Written {
            key: format!("{table}.{quantity}_{unit}"),
            value: (*value)?,
            unit: *in_si,
        })
    });
    let Some(one) = written.next() else {
        return Ok(None);
    };
    if let Some(other) = written.next() {
        return Err(Problem::new(
            other.key.as_str(),
            format!("{} and {} say the same thing twice", one.key, other.key),
            "keep one of the two",
        ));
    }
    Ok(Some(one))
}

/// The same of sizes, speeds and masses, which are positive.
fn positive_one_of(
    table: &str,
    quantity: &str,
    keys: &[(&str, Option<f64>)],
) -> Result<Option<Written>, Problem> {
    let written = one_of(table, quantity, keys)?;
    let checked = written.map(|one| {
        let value = positive(&one.key, one.value)?;
        Ok(Written { value, ..one })
    });
    checked.transpose()
}

/// A length.
pub(super) fn length(
    table: &str,
    name: &str,
    [m, ft]: [Option<f64>; 2],
) -> Result<Option<Written>, Problem> {
    positive_one_of(table, name, &[("m", m), ("ft", ft)])
}

/// A mass.
pub(super) fn mass(
    table: &str,
    name: &str,
    [kg, lb]: [Option<f64>; 2],
) -> Result<Option<Written>, Problem> {
    positive_one_of(table, name, &[("kg", kg), ("lb", lb)])
}

/// A speed that is written in m/s, km/h, ft/s or kt [m/s].
pub(super) fn speed_m_s(table: &str, written: [Option<f64>; 4]) -> Result<Option<f64>, Problem> {
    let [m_s, km_h, ft_s, kt] = written;
    let keys = [("m_s", m_s), ("km_h", km_h), ("ft_s", ft_s), ("kt", kt)];
    let speed = positive_one_of(table, "speed", &keys)?;
    Ok(speed.map(|speed| speed.si()))
}

/// An altitude of the standard atmosphere; sea level if absent [m].
pub(super) fn altitude_m(table: &str, [m, ft]: [Option<f64>; 2]) -> Result<f64, Problem> {
    let [lowest, highest] = ALTITUDES_M;
    match one_of(table, "altitude", &[("m", m), ("ft", ft)])? {
        Some(altitude) => altitude.within(lowest, highest),
        None => Ok(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_told_in_the_unit_that_is_written() {
        let feet = |value: f64| length("canopy", "diameter", [None, Some(value)]).unwrap();
        let told = feet(1000.0).unwrap().within(0.01, 200.0).unwrap_err();
        assert_eq!(told.key, "canopy.diameter_ft");
        assert_eq!(told.message, "canopy.diameter_ft = 1000 is out of range");
        assert_eq!(told.help, "allowed are values from 0.0328084 to 656.168");
        assert_eq!(feet(10.0).unwrap().within(0.01, 200.0), Ok(3.048));
        // Whatever the rounding of a bound, what comes out lies within the range.
        assert_eq!(altitude_m("wing", [None, Some(-1640.42)]), Ok(-500.0));
        let told = altitude_m("wing", [None, Some(40e3)]).unwrap_err();
        assert_eq!(told.key, "wing.altitude_ft");
        let metres = length("canopy", "diameter", [Some(201.0), None]).unwrap();
        let told = metres.unwrap().within(0.01, 200.0).unwrap_err();
        assert_eq!(told.message, "canopy.diameter_m = 201 is out of range");
        assert_eq!(told.help, "allowed are values from 0.01 to 200");
    }

    #[test]
    fn keys_are_known_by_their_quantity() {
        assert!(is_quantity("speed_kt", "speed") && is_quantity("payload_lb", "payload"));
        assert!(!is_quantity("payload_drag_area_m2", "payload"));
        assert!(!is_quantity("span", "span") && !is_quantity("speed_m_s", "speed_m"));
    }
}
