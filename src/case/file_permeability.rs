//! Mirror of `[fabric.permeability]` and `[bodies.NAME.permeability]`.

use serde::Deserialize;

/// A permeability; exactly one law inside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct PermeabilityTable {
    pub ergun: Option<ErgunTable>,
    pub measured: Option<MeasuredTable>,
    /// Discharge coefficient of an opening that is not resolved.
    pub discharge_coefficient: Option<f64>,
    /// Name of a known fabric.
    pub material: Option<String>,
}

/// `ergun`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct ErgunTable {
    pub viscous_coefficient_pa_s_m2: f64,
    pub inertial_coefficient_kg_m4: f64,
    /// The fabric's own if absent.
    pub thickness_m: Option<f64>,
}

/// `measured`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct MeasuredTable {
    pub pressures_pa: Vec<f64>,
    pub air_speeds_m_s: Vec<f64>,
}
