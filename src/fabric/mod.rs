//! Material laws of fabric: pure formulas, per unit of rest area.
//!
//! * [`membrane`]: orthotropic St Venant–Kirchhoff sheet that does not push (tension field).
//! * [`shear`]: shear law that is not linear.
//! * [`permeability`]: air that passes through.
//! * [`network`]: the mass–spring network of Lolies et al. (paper P0 of the documentation).

pub mod membrane;
pub mod named;
pub mod network;
pub mod permeability;
pub(crate) mod plane;
pub mod shear;
mod wrinkles;

use membrane::Membrane;
use shear::CubicShear;

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
    /// α of the shear law 2ε₁₂ = τ/G + α τ³ [1/Pa³]; `None`: linear.
    pub cubic_shear_compliance_1_pa3: Option<f64>,
    /// Share of the compressive stiffness that is kept, 0 for fabric that cannot push at all.
    pub residual_stiffness: f64,
    /// Strain along warp and weft of the fabric as it is laid out; positive where it is stretched already.
    pub initial_strain: [f64; 2],
    /// Von Mises stress from which fabric is flagged as yielding [Pa]; `None`: never. The law stays elastic.
    pub yield_stress_pa: Option<f64>,
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

    /// Flexural rigidity of a solid sheet [N m], rows and columns as in [`Fabric::stiffness_n_m`]: that times h²/12.
    #[must_use]
    pub fn rigidity_nm(&self) -> [[f64; 3]; 3] {
        let factor = self.thickness_m * self.thickness_m / 12.0;
        self.stiffness_n_m().map(|row| row.map(|k| k * factor))
    }

    /// Law of the membrane.
    #[must_use]
    pub fn membrane(&self) -> Membrane {
        let membrane = Membrane::new(self.stiffness_n_m(), self.residual_stiffness);
        match self.cubic_shear_compliance_1_pa3 {
            Some(cubic) => membrane.with_shear(CubicShear {
                compliance_m_n: 1.0 / (self.thickness_m * self.shear_modulus_pa),
                cubic_m3_n3: cubic / self.thickness_m.powi(3),
            }),
            None => membrane,
        }
    }

    /// Shear modulus of an isotropic sheet, E / (2 (1 + ν)) [Pa].
    #[must_use]
    pub fn isotropic_shear_modulus_pa(youngs_modulus_pa: f64, poisson_ratio: f64) -> f64 {
        youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio))
    }
}
