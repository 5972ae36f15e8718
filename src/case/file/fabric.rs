//! What may be written in `[fabric]` and its permeability, in materials of cables, and in `[contact]`.

use schemars::JsonSchema;
use serde::Deserialize;

use super::friction::Friction;

/// Woven fabric, an orthotropic membrane.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fabric {
    /// Thickness [m].
    pub thickness_m: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus along the warp [Pa].
    pub youngs_modulus_pa: f64,
    /// Young's modulus along the weft [Pa]; that of the warp if absent.
    pub weft_youngs_modulus_pa: Option<f64>,
    /// Poisson's ratio, warp to weft.
    pub poisson_ratio: f64,
    /// Shear modulus [Pa]; that of isotropic fabric if absent.
    pub shear_modulus_pa: Option<f64>,
    /// α of the shear law 2ε₁₂ = τ/G + α τ³, 1e-40 to 1e-6 [1/Pa³]; linear if absent.
    pub cubic_shear_compliance_1_pa3: Option<f64>,
    /// Share of compressive stiffness kept by slack fabric; 1e-5 if absent, 1 for a plate. The result and column
    /// `residual_stiffness_load_share` tells how much of the load it carries (docs/case-files.md#residual-stiffness).
    pub residual_stiffness: Option<f64>,
    /// How far the fabric is stretched as it is laid out, along warp and weft; 0 if absent.
    pub initial_strain: Option<[f64; 2]>,
    /// Von Mises stress from which fabric counts as yielding [Pa]; the law stays elastic.
    pub yield_stress_pa: Option<f64>,
    /// How air passes the fabric, only with `[air]`; absent: not at all. Not in `[structure.wing.fabrics]`.
    pub permeability: Option<Permeability>,
    /// How the air passes along the fabric, only with `[air]`; `no_slip` if absent. Not in `[structure.wing.fabrics]`: a wing has `structure.wing.tunnel.friction`.
    pub friction: Option<Friction>,
}

/// A law of permeability; exactly one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Permeability {
    /// Ergun's law Δp/e = a v + b v|v|.
    Ergun(ErgunLaw),
    /// Points of a permeability test: one (taken as inertial, of constant effective porosity) or two (both coefficients).
    Measured(PermeabilityTest),
    /// C_d of an opening (vent, gap, slot) too narrow for cells, as a panel of Δp = ½ ρ (v/C_d)²; 0.05 to 1.
    DischargeCoefficient(f64),
    /// A specification, taken in the middle of the range that it allows at ½ inch of water: `mil_c_7020_type_1` (0.41 to 0.61 m/s),
    /// `mil_c_7020_type_3` (0.51 to 0.81), `pia_c_44378_type_2` (0.15 to 0.25), `pia_c_44378_type_4` (0.0025 to 0.015).
    Material(String),
}

/// Coefficients of Ergun's law.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErgunLaw {
    /// a of Δp/e = a v + b v|v| [Pa s/m²].
    pub viscous_coefficient_pa_s_m2: f64,
    /// b of Δp/e = a v + b v|v| [kg/m⁴].
    pub inertial_coefficient_kg_m4: f64,
    /// e of Δp/e = a v + b v|v| [m]; the fabric's thickness if absent. Required of rigid bodies.
    pub thickness_m: Option<f64>,
}

/// Points of a permeability test.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PermeabilityTest {
    /// Pressure differences, one or two [Pa].
    pub pressures_pa: Vec<f64>,
    /// Air that passes at each, per area [m/s]; at most what a hole without fabric lets pass.
    pub air_speeds_m_s: Vec<f64>,
}

/// Material of a cable. Exactly one of `youngs_modulus_pa` and `force_strain`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableMaterial {
    /// Cross section [m²].
    pub area_m2: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: Option<f64>,
    /// Points [strain, force in N] of a tensile test, rising from (0, 0); beyond the last it goes on straight.
    pub force_strain: Option<Vec<[f64; 2]>>,
    /// c of T = f(ε) + c dε/dt while taut [N s]; 0 if absent.
    pub damping_n_s: Option<f64>,
}

/// Material of belts or of a band: that of a cable, and its strength. Exactly one of `youngs_modulus_pa` and `force_strain`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TapeMaterial {
    /// Cross section [m²].
    pub area_m2: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: Option<f64>,
    /// Points [strain, force in N] of a tensile test, rising from (0, 0); beyond the last it goes on straight.
    pub force_strain: Option<Vec<[f64; 2]>>,
    /// c of T = f(ε) + c dε/dt while taut [N s]; 0 if absent.
    pub damping_n_s: Option<f64>,
    /// Breaking load [N], for margins; absent: not told.
    pub breaking_load_n: Option<f64>,
}

/// Contact of fabric with itself, on the host alone (docs/contact.md). Not with `coupling.structure_every` above 1.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Fabric pushes fabric whose middle surface is nearer than this, and never passes through it [m]. At most half the smallest
    /// altitude of a triangle.
    pub thickness_m: f64,
}
