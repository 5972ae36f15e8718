//! Quantities in the units that a designer writes them in, and the scales of a case that follow from them.

use std::f64::consts::PI;

use super::super::density::{
    ALTITUDES_M, standard_density_kg_m3, standard_kinematic_viscosity_m2_s,
};
use super::super::file::CanopyDesign;
use super::super::problem::Problem;
use super::super::values::{absent, positive, within};
use super::handbook::Published;

/// m of a foot.
const FOOT_M: f64 = 0.3048;

/// m/s of a knot.
const KNOT_M_S: f64 = 1852.0 / 3600.0;

/// kg of a pound.
const POUND_KG: f64 = 0.453_592_37;

/// Standard acceleration of gravity [m/s²].
pub(super) const GRAVITY_M_S2: f64 = 9.80665;

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

/// The one of several keys of `[canopy]` that is written, in SI units: name, value, unit in SI.
fn one_of(keys: &[(&str, Option<f64>, f64)]) -> Result<Option<f64>, Problem> {
    let mut written = keys
        .iter()
        .filter_map(|(name, value, unit)| Some((name, (*value)?, unit)));
    let Some((name, value, unit)) = written.next() else {
        return Ok(None);
    };
    if let Some((other, ..)) = written.next() {
        return Err(Problem::new(
            format!("canopy.{other}"),
            format!("canopy.{name} and canopy.{other} say the same thing twice"),
            "keep one of the two",
        ));
    }
    Ok(Some(value * unit))
}

impl Scales {
    pub(super) fn new(design: &CanopyDesign) -> Result<Self, Problem> {
        let diameter_m = one_of(&[
            ("diameter_m", design.diameter_m, 1.0),
            ("diameter_ft", design.diameter_ft, FOOT_M),
        ])?;
        let diameter_m = diameter_m.ok_or_else(|| {
            absent(
                "canopy.diameter_m",
                "a canopy has a nominal diameter (or canopy.diameter_ft)",
            )
        })?;
        let diameter_m = within("canopy.diameter_m", diameter_m, 0.01, 200.0)?;
        let speed_m_s = one_of(&[
            ("speed_m_s", design.speed_m_s, 1.0),
            ("speed_km_h", design.speed_km_h, 1.0 / 3.6),
            ("speed_ft_s", design.speed_ft_s, FOOT_M),
            ("speed_kt", design.speed_kt, KNOT_M_S),
        ])?;
        let speed_m_s = speed_m_s
            .map(|speed| positive("canopy.speed_m_s", speed))
            .transpose()?;
        let payload_kg = one_of(&[
            ("payload_kg", design.payload_kg, 1.0),
            ("payload_lb", design.payload_lb, POUND_KG),
        ])?;
        let payload_kg = payload_kg
            .map(|mass| positive("canopy.payload_kg", mass))
            .transpose()?;
        let altitude_m = one_of(&[
            ("altitude_m", design.altitude_m, 1.0),
            ("altitude_ft", design.altitude_ft, FOOT_M),
        ])?;
        let [lowest, highest] = ALTITUDES_M;
        let altitude_m = within(
            "canopy.altitude_m",
            altitude_m.unwrap_or(0.0),
            lowest,
            highest,
        )?;
        let density_kg_m3 = standard_density_kg_m3(altitude_m);
        let area_m2 = 0.25 * PI * diameter_m * diameter_m;
        let drag_coefficient = Published::of(design.kind).mean_drag_coefficient();
        let balance_m_s = payload_kg.map(|mass| {
            (2.0 * mass * GRAVITY_M_S2 / (density_kg_m3 * drag_coefficient * area_m2)).sqrt()
        });
        let Some(final_speed_m_s) = balance_m_s.or(speed_m_s) else {
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
            falls: payload_kg.is_some() && speed_m_s.is_some(),
            altitude_m,
            density_kg_m3,
            kinematic_viscosity_m2_s: standard_kinematic_viscosity_m2_s(altitude_m),
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

    /// Dynamic pressure at a speed [Pa].
    pub(super) const fn dynamic_pressure_pa(&self, speed_m_s: f64) -> f64 {
        0.5 * self.density_kg_m3 * speed_m_s * speed_m_s
    }
}
