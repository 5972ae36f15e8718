//! Density of the undisturbed air, and its speed of sound.

use super::file::Air;
use super::problem::Problem;
use super::usual;
use super::values::{absent, positive, within};

/// Altitudes of the standard atmosphere's lowest layer [m].
pub(super) const ALTITUDES_M: [f64; 2] = [-500.0, 11_000.0];

/// Sound in air at 15 °C [m/s].
pub const SOUND_M_S: f64 = 340.3;

/// Fluids from this density on are liquids, whose sound is too fast to matter [kg/m³].
pub const LIQUID_KG_M3: f64 = 10.0;

/// Density of the air: as given, or of the standard atmosphere.
pub(super) fn density_kg_m3(file: &Air) -> Result<f64, Problem> {
    let altitude = file.descent.as_ref().and_then(|descent| descent.altitude_m);
    match (file.density_kg_m3, altitude) {
        (Some(density), None) => positive("air.density_kg_m3", density),
        (None, Some(altitude)) => {
            let [lowest, highest] = ALTITUDES_M;
            within("air.descent.altitude_m", altitude, lowest, highest).map(|altitude_m| {
                usual::noted("air.density_kg_m3", standard_density_kg_m3(altitude_m))
            })
        }
        (Some(_), Some(_)) => Err(Problem::new(
            "air.descent.altitude_m",
            "air.density_kg_m3 and air.descent.altitude_m both say how dense the air is",
            "keep one of the two",
        )),
        (None, None) => Err(absent(
            "air.density_kg_m3",
            "air has a density (or air.descent.altitude_m)",
        )),
    }
}

/// Speed of sound of the air: at sea level, or that of the standard atmosphere at the altitude of a descent [m/s]; the altitude is checked.
/// `None` of liquids.
pub(super) fn sound_m_s(file: &Air, density_kg_m3: f64) -> Option<f64> {
    let altitude = file.descent.as_ref().and_then(|descent| descent.altitude_m);
    (density_kg_m3 < LIQUID_KG_M3)
        .then(|| SOUND_M_S * altitude.map_or(1.0, standard_temperature_ratio).sqrt())
}

/// Density of the standard atmosphere (ICAO Doc 7488, ISO 2533) in the troposphere, over the geometric altitude [kg/m³].
pub(super) fn standard_density_kg_m3(altitude_m: f64) -> f64 {
    const SEA_LEVEL_KG_M3: f64 = 1.225;
    // g M/(R L) − 1
    const EXPONENT: f64 = 4.255_88;
    SEA_LEVEL_KG_M3 * standard_temperature_ratio(altitude_m).powf(EXPONENT)
}

/// Kinematic viscosity of the same [m²/s]: Sutherland's law, as in ICAO Doc 7488.
pub(super) fn standard_kinematic_viscosity_m2_s(altitude_m: f64) -> f64 {
    const COEFFICIENT_KG_M_S_SQRT_K: f64 = 1.458e-6;
    const SUTHERLAND_K: f64 = 110.4;
    let temperature_k = SEA_LEVEL_K * standard_temperature_ratio(altitude_m);
    let dynamic =
        COEFFICIENT_KG_M_S_SQRT_K * temperature_k.powf(1.5) / (temperature_k + SUTHERLAND_K);
    dynamic / standard_density_kg_m3(altitude_m)
}

/// Temperature of the standard atmosphere at sea level [K].
const SEA_LEVEL_K: f64 = 288.15;

/// Temperature of the same over that at sea level, both in K.
fn standard_temperature_ratio(altitude_m: f64) -> f64 {
    const LAPSE_K_M: f64 = 0.0065;
    const EARTH_RADIUS_M: f64 = 6_356_766.0;
    let geopotential_m = EARTH_RADIUS_M * altitude_m / (EARTH_RADIUS_M + altitude_m);
    1.0 - LAPSE_K_M * geopotential_m / SEA_LEVEL_K
}

#[cfg(test)]
mod tests {
    /// Densities over geometric altitudes as tabulated in ICAO Doc 7488.
    #[test]
    fn densities_are_those_of_the_tables() {
        for (altitude, density) in [
            (0.0, 1.225),
            (1000.0, 1.11166),
            (5000.0, 0.736_43),
            (11_000.0, 0.364_80),
        ] {
            let found = super::standard_density_kg_m3(altitude);
            assert!((found / density - 1.0).abs() < 1e-4, "{altitude}: {found}");
        }
    }

    /// Kinematic viscosities of the same tables.
    #[test]
    fn viscosities_are_those_of_the_tables() {
        for (altitude, viscosity) in [(0.0, 1.4607e-5), (5000.0, 2.2110e-5), (10_000.0, 3.5251e-5)]
        {
            let found = super::standard_kinematic_viscosity_m2_s(altitude);
            assert!(
                (found / viscosity - 1.0).abs() < 1e-3,
                "{altitude}: {found}"
            );
        }
    }

    /// Speed of sound at 10 000 m of the same tables over that at sea level.
    #[test]
    fn sound_is_slower_in_the_cold() {
        let ratio = super::standard_temperature_ratio(10_000.0).sqrt();
        assert!((ratio / (299.532 / 340.294) - 1.0).abs() < 1e-4, "{ratio}");
    }
}
