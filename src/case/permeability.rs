//! Checks of `permeability` tables.

use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{at_once, positive, within};
use crate::fabric::permeability::{NAMED_FABRICS, Permeability};

/// Checks the table at `key`; `thickness_m` is what Ergun's law takes without a thickness of its own, the density that of the air.
pub(super) fn check(
    key: &str,
    written: &file::Permeability,
    thickness_m: Option<f64>,
    density_kg_m3: f64,
) -> Result<Permeability, Problem> {
    match written {
        file::Permeability::Ergun(ergun) => {
            let key = |name: &str| format!("{key}.ergun.{name}");
            let coefficient = |name: &str, value: f64| {
                if value == 0.0 {
                    Ok(0.0)
                } else {
                    positive(&key(name), value)
                }
            };
            let viscous = coefficient(
                "viscous_coefficient_pa_s_m2",
                ergun.viscous_coefficient_pa_s_m2,
            )?;
            let inertial = coefficient(
                "inertial_coefficient_kg_m4",
                ergun.inertial_coefficient_kg_m4,
            )?;
            if viscous == 0.0 && inertial == 0.0 {
                return Err(Problem::new(
                    key("viscous_coefficient_pa_s_m2"),
                    "both coefficients of Ergun's law are zero: nothing would resist the air",
                    "give at least one positive coefficient",
                ));
            }
            let thickness_m = match (ergun.thickness_m, thickness_m) {
                (Some(own), _) => positive(&key("thickness_m"), own)?,
                (None, Some(fabric)) => usual::noted(key("thickness_m"), fabric),
                (None, None) => {
                    return Err(Problem::new(
                        key("thickness_m"),
                        format!(
                            "{} is missing: a rigid surface has no thickness of its own",
                            key("thickness_m")
                        ),
                        "add the thickness that the coefficients refer to",
                    ));
                }
            };
            Ok(Permeability::ergun(thickness_m, viscous, inertial))
        }
        file::Permeability::Measured(measured) => check_points(
            &format!("{key}.measured"),
            &measured.pressures_pa,
            &measured.air_speeds_m_s,
        ),
        file::Permeability::DischargeCoefficient(coefficient) => {
            let key = format!("{key}.discharge_coefficient");
            let coefficient = within(&key, *coefficient, 0.05, 1.0)?;
            Ok(Permeability::opening(density_kg_m3, coefficient))
        }
        file::Permeability::Material(name) => NAMED_FABRICS
            .iter()
            .find(|fabric| fabric.name == name)
            .map(crate::fabric::permeability::NamedFabric::permeability)
            .ok_or_else(|| {
                let known: Vec<&str> = NAMED_FABRICS.iter().map(|fabric| fabric.name).collect();
                Problem::new(
                    format!("{key}.material"),
                    format!("{key}.material = \"{name}\" is no known fabric"),
                    format!("known are {}; or give ergun or measured", known.join(", ")),
                )
            }),
    }
}

/// Air thinner than in any laboratory.
const THIN_AIR_KG_M3: f64 = 1.0;

fn check_points(key: &str, pressures: &[f64], speeds: &[f64]) -> Result<Permeability, Problem> {
    for pressure in pressures {
        at_once(|| positive(&format!("{key}.pressures_pa"), *pressure))?;
    }
    for speed in speeds {
        at_once(|| positive(&format!("{key}.air_speeds_m_s"), *speed))?;
    }
    for (pressure, speed) in pressures.iter().zip(speeds) {
        let of_a_hole = (2.0 * pressure / THIN_AIR_KG_M3).sqrt();
        if *speed > of_a_hole {
            return Err(Problem::new(
                format!("{key}.air_speeds_m_s"),
                format!(
                    "{speed} m/s at {pressure} Pa is more than a hole without any fabric lets pass ({of_a_hole:.1} m/s, in air of {THIN_AIR_KG_M3} kg/m³)"
                ),
                "give metres per second; cubic feet per minute and square foot are 0.00508 m/s each",
            ));
        }
    }
    match (pressures, speeds) {
        ([pressure], [speed]) => Ok(Permeability::from_point([*pressure, *speed])),
        ([p1, p2], [v1, v2]) => {
            let found = if p1 == p2 || v1 == v2 {
                None
            } else {
                Permeability::from_points([[*p1, *v1], [*p2, *v2]])
            };
            found.ok_or_else(|| {
                Problem::new(
                    format!("{key}.air_speeds_m_s"),
                    format!(
                        "no law with viscous and inertial resistance goes through {v1} m/s at {p1} Pa and {v2} m/s at {p2} Pa"
                    ),
                    "between the points the speed must rise with the pressure, at most in proportion and at least as its root; or give one point",
                )
            })
        }
        _ => Err(Problem::new(
            format!("{key}.pressures_pa"),
            format!(
                "{key} holds {} pressures and {} speeds",
                pressures.len(),
                speeds.len()
            ),
            "give one speed for each of one or two pressures, such as pressures_pa = [124.5] and air_speeds_m_s = [0.5]",
        )),
    }
}
