//! The scales of a canopy's case that follow from its design.

use std::f64::consts::PI;

use toml::Table;

use super::super::density::{
    ALTITUDES_M, standard_density_kg_m3, standard_kinematic_viscosity_m2_s,
};
use super::super::file::CanopyDesign;
use super::super::problem::Problem;
use super::super::text::{lookup, number};
use super::super::values::absent;
use super::handbook::Published;
use super::units::{altitude_m, length, mass, speed_m_s};
use crate::case::scene::STANDARD_GRAVITY_M_S2;

/// The table of the design.
const TABLE: &str = "canopy";

/// Way in which a canopy of solid cloth fills, in D_0, as the trade quotes it (Knacke 1991).
const FILLING: f64 = 8.0;

/// Sizes, speeds and masses that all else is derived from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    /// D_0 [m].
    pub(super) diameter_m: f64,
    /// S_0 [m²].
    pub(super) area_m2: f64,
    /// Speed of the wind, or of release [m/s].
    pub(super) speed_m_s: f64,
    /// Speed on which the canopy ends: that of the wind, or of balance by the handbook [m/s].
    pub(super) final_speed_m_s: f64,
    /// Mass that hangs on the canopy [kg].
    pub(super) payload_kg: Option<f64>,
    /// True where that mass is released at a speed, and falls; otherwise the canopy stands in a wind tunnel.
    pub(super) falls: bool,
    pub(super) altitude_m: f64,
    pub(super) density_kg_m3: f64,
    pub(super) kinematic_viscosity_m2_s: f64,
}

/// A positive number that a case says itself; what others are refused for is told where the key is read.
fn written(case: &Table, path: &str) -> Option<f64> {
    let number = lookup(case, path).and_then(number);
    number.filter(|n| *n > 0.0 && n.is_finite())
}

/// Strength of the gravity that a case says itself [m/s²].
fn written_gravity_m_s2(case: &Table) -> Option<f64> {
    let parts = lookup(case, "gravity.acceleration_m_s2")?.as_array()?;
    let parts: Option<Vec<f64>> = parts.iter().map(number).collect();
    let strength = parts?.iter().map(|part| part * part).sum::<f64>().sqrt();
    (strength > 0.0 && strength.is_finite()).then_some(strength)
}

impl Scales {
    /// The scales of a design; what the case says itself of density, viscosity, gravity, speed and payload stands.
    pub(super) fn new(design: &CanopyDesign, case: &Table) -> Result<Self, Problem> {
        let diameter = length(TABLE, "diameter", [design.diameter_m, design.diameter_ft])?;
        let diameter = diameter.ok_or_else(|| {
            absent(
                "canopy.diameter_m",
                "a canopy has a nominal diameter (or canopy.diameter_ft)",
            )
        })?;
        let diameter_m = diameter.within(0.01, 200.0)?;
        let speeds = [
            design.speed_m_s,
            design.speed_km_h,
            design.speed_ft_s,
            design.speed_kt,
        ];
        let speed_m_s = speed_m_s(TABLE, speeds)?;
        let payload = mass(TABLE, "payload", [design.payload_kg, design.payload_lb])?;
        let payload_kg = payload.map(|mass| mass.si());
        let altitude_m = altitude_m(TABLE, [design.altitude_m, design.altitude_ft])?;
        let in_the_fall = lookup(case, "air.descent.altitude_m").and_then(number);
        let within_atmosphere =
            |altitude: &f64| (ALTITUDES_M[0]..=ALTITUDES_M[1]).contains(altitude);
        let altitude_m = in_the_fall.filter(within_atmosphere).unwrap_or(altitude_m);
        let falls = payload_kg.is_some() && speed_m_s.is_some();
        let speed_m_s = written(
            case,
            if falls {
                "air.descent.release_speed_m_s"
            } else {
                "air.wind_tunnel.speed_m_s"
            },
        )
        .or(speed_m_s);
        let payload_kg = payload_kg.map(|kg| written(case, "payload.mass_kg").unwrap_or(kg));
        // "absent" is none at all.
        let payload_area_m2 = match lookup(case, "payload.drag_area_m2") {
            Some(_) => written(case, "payload.drag_area_m2"),
            None => design.payload_drag_area_m2.filter(|area| *area > 0.0),
        };
        let payload_area_m2 = payload_area_m2.unwrap_or(0.0);
        let density_kg_m3 = written(case, "air.density_kg_m3")
            .unwrap_or_else(|| standard_density_kg_m3(altitude_m));
        let gravity_m_s2 = written_gravity_m_s2(case).unwrap_or(STANDARD_GRAVITY_M_S2);
        let area_m2 = 0.25 * PI * diameter_m * diameter_m;
        let drag_coefficient = Published::of(design.kind).mean_drag_coefficient();
        let balance_m_s = payload_kg.map(|mass| {
            let drag_area_m2 = drag_coefficient * area_m2 + payload_area_m2;
            (2.0 * mass * gravity_m_s2 / (density_kg_m3 * drag_area_m2)).sqrt()
        });
        // In a tunnel the canopy stands in the wind that the case gives, if it does.
        let in_a_tunnel = speed_m_s.filter(|_| !falls);
        let Some(final_speed_m_s) = in_a_tunnel.or(balance_m_s) else {
            return Err(absent(
                "canopy.speed_m_s",
                "a canopy stands in a wind, or falls with a payload (canopy.payload_kg)",
            ));
        };
        Ok(Self {
            diameter_m,
            area_m2,
            speed_m_s: speed_m_s.unwrap_or(final_speed_m_s),
            final_speed_m_s,
            payload_kg,
            falls,
            altitude_m,
            density_kg_m3,
            kinematic_viscosity_m2_s: written(case, "air.kinematic_viscosity_m2_s")
                .unwrap_or_else(|| standard_kinematic_viscosity_m2_s(altitude_m)),
        })
    }

    /// D_0 over the speed of wind or release [s].
    pub(super) const fn time_s(&self) -> f64 {
        self.diameter_m / self.speed_m_s
    }

    /// D_0 over the speed that the canopy ends on [s].
    pub(super) const fn final_time_s(&self) -> f64 {
        self.diameter_m / self.final_speed_m_s
    }

    /// Share of the load of an opening in a wind that is left where the mass loses speed meanwhile: X_1 of Pflanz's method (Knacke 1991, section
    /// 5.4), with an area that grows as the square of time.
    pub(super) fn opening_load_reduction(&self, drag_coefficient: f64) -> f64 {
        let Some(mass_kg) = self.payload_kg.filter(|_| self.falls) else {
            return 1.0;
        };
        let drag_area_m2 = drag_coefficient * self.area_m2;
        let filled_m = FILLING * self.diameter_m;
        // Ballistic parameter A; speed and area over those at the start and at the end, at a share T of the filling time, are 1/(1 + T³/3A) and T².
        let ballistic = 2.0 * mass_kg / (self.density_kg_m3 * drag_area_m2 * filled_m);
        let share = (1.5 * ballistic).cbrt().min(1.0);
        (share / (1.0 + share.powi(3) / (3.0 * ballistic))).powi(2)
    }

    /// Dynamic pressure at a speed [Pa].
    pub(super) const fn dynamic_pressure_pa(&self, speed_m_s: f64) -> f64 {
        0.5 * self.density_kg_m3 * speed_m_s * speed_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest load of a canopy whose area grows as the square of time, by steps of its equation of motion, over that at constant speed.
    #[test]
    fn the_reduction_is_that_of_the_equation_of_motion() {
        for (payload_kg, speed_m_s) in [(10.0, 20.0), (100.0, 30.0), (2e3, 50.0), (1e6, 50.0)] {
            let design: CanopyDesign = toml::from_str(&format!(
                "type = \"flat_circular\"\ndiameter_m = 10.0\npayload_kg = {payload_kg}\nspeed_m_s = {speed_m_s:?}"
            ))
            .unwrap();
            let scales = Scales::new(&design, &Table::new()).unwrap();
            let drag_coefficient = 0.75;
            let (filling_s, steps) = (FILLING * scales.diameter_m / speed_m_s, 100_000);
            let full = 0.5 * scales.density_kg_m3 * drag_coefficient * scales.area_m2;
            let (mut speed, mut largest): (f64, f64) = (speed_m_s, 0.0);
            for step in 0..steps {
                let share = (f64::from(step) + 0.5) / f64::from(steps);
                let load = full * share * share * speed * speed;
                largest = largest.max(load);
                speed -= load / payload_kg * filling_s / f64::from(steps);
            }
            let expected = largest / (full * speed_m_s * speed_m_s);
            let found = scales.opening_load_reduction(drag_coefficient);
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }
}
