//! Material law of suspension lines, belts and other cables.
//!
//! A cable carries tension only: T = EA · max(0, l/L − 1).

/// Elastic constants of a cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cable {
    /// Cross-section [m²].
    pub area_m2: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
}

impl Cable {
    /// Axial stiffness EA [N].
    #[must_use]
    pub const fn axial_stiffness_n(&self) -> f64 {
        self.area_m2 * self.youngs_modulus_pa
    }

    /// Mass per length [kg/m].
    #[must_use]
    pub const fn mass_per_length_kg_m(&self) -> f64 {
        self.area_m2 * self.density_kg_m3
    }
}

/// Tension [N] of a segment of rest length `rest_length_m` and present length `length_m`.
#[must_use]
pub fn tension_n(axial_stiffness_n: f64, rest_length_m: f64, length_m: f64) -> f64 {
    axial_stiffness_n * (length_m / rest_length_m - 1.0).max(0.0)
}
