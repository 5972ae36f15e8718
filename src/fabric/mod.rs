//! Material laws of fabric: pure formulas, per unit of rest area.
//!
//! * [`membrane`]: orthotropic St Venant–Kirchhoff sheet that does not push (tension field).
//! * [`network`]: the mass–spring network of Lolies et al. (paper P0 of the documentation).

pub mod membrane;
pub mod network;

/// Elastic constants of a fabric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fabric {
    /// Thickness [m].
    pub thickness_m: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus along the warp [Pa].
    pub warp_modulus_pa: f64,
    /// Young's modulus along the weft [Pa].
    pub weft_modulus_pa: f64,
    /// Poisson's ratio ν₁₂ (weft strain under warp stress).
    pub poisson_ratio: f64,
    /// In-plane shear modulus [Pa], independent of the others.
    pub shear_modulus_pa: f64,
    /// Share of the compressive stiffness that is kept, 0 for fabric that cannot push at all.
    pub residual_stiffness: f64,
}

impl Fabric {
    /// Mass per area [kg/m²].
    #[must_use]
    pub fn areal_density_kg_m2(&self) -> f64 {
        self.thickness_m * self.density_kg_m3
    }

    /// Membrane stiffness [N/m], rows and columns xx, yy, engineering shear xy: thickness times plane-stress moduli.
    #[must_use]
    pub fn stiffness_n_m(&self) -> [[f64; 3]; 3] {
        let weft_poisson = self.poisson_ratio * self.weft_modulus_pa / self.warp_modulus_pa;
        let scale = self.thickness_m / (1.0 - self.poisson_ratio * weft_poisson);
        let coupling = scale * self.poisson_ratio * self.weft_modulus_pa;
        [
            [scale * self.warp_modulus_pa, coupling, 0.0],
            [coupling, scale * self.weft_modulus_pa, 0.0],
            [0.0, 0.0, self.thickness_m * self.shear_modulus_pa],
        ]
    }

    /// Shear modulus of an isotropic sheet, E / (2 (1 + ν)) [Pa].
    #[must_use]
    pub fn isotropic_shear_modulus_pa(youngs_modulus_pa: f64, poisson_ratio: f64) -> f64 {
        youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio))
    }
}
