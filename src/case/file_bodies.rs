//! Mirror of `[bodies.NAME]`: rigid bodies and their motions.

use serde::Deserialize;

use super::file_descent::FreeFall;
use super::file_permeability::PermeabilityTable;
use crate::geometry::mesh::doctor::Kind;

/// `[bodies.NAME]`; exactly one shape inside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct BodyTable {
    pub position_m: [f64; 3],
    pub rotation: Option<Rotation>,
    pub sphere: Option<SphereShape>,
    pub disk: Option<DiskShape>,
    pub plate: Option<PlateShape>,
    pub cylinder: Option<CylinderShape>,
    pub mesh: Option<SurfaceFile>,
    pub motion: Option<MotionTable>,
    pub reference: Option<Reference>,
    pub permeability: Option<PermeabilityTable>,
}

/// `[bodies.NAME.rotation]`, `[structure.mesh.rotation]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Rotation {
    pub axis: [f64; 3],
    pub angle_deg: f64,
}

/// `[bodies.NAME.sphere]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct SphereShape {
    pub diameter_m: f64,
}

/// `[bodies.NAME.disk]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct DiskShape {
    pub diameter_m: f64,
}

/// `[bodies.NAME.plate]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct PlateShape {
    pub size_m: [f64; 2],
}

/// `[bodies.NAME.cylinder]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct CylinderShape {
    pub diameter_m: f64,
    pub length_m: f64,
    pub closed: bool,
}

/// `[bodies.NAME.mesh]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct SurfaceFile {
    pub file: String,
    pub scale: f64,
    /// Vertices nearer than this are joined; 0 if absent.
    pub weld_tolerance_m: Option<f64>,
    /// Turns triangles that run against their neighbours.
    #[serde(default)]
    pub orient_triangles: bool,
    /// Findings that are meant.
    #[serde(default)]
    pub accept: Vec<Kind>,
}

/// `[bodies.NAME.reference]`; what is absent follows from the shape.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Reference {
    pub area_m2: Option<f64>,
    pub length_m: Option<f64>,
    pub moment_point_m: Option<[f64; 3]>,
}

/// `[bodies.NAME.motion]`; exactly one motion inside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct MotionTable {
    pub constant_velocity: Option<ConstantVelocity>,
    pub constant_rotation: Option<ConstantRotation>,
    pub oscillation: Option<Oscillation>,
    pub table: Option<MotionRows>,
    pub free_fall: Option<FreeFall>,
}

/// `[bodies.NAME.motion.constant_velocity]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct ConstantVelocity {
    pub velocity_m_s: [f64; 3],
    pub start_time_s: Option<f64>,
}

/// `[bodies.NAME.motion.constant_rotation]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct ConstantRotation {
    pub axis: [f64; 3],
    pub rate_rad_s: f64,
    pub centre_m: Option<[f64; 3]>,
    pub start_time_s: Option<f64>,
}

/// `[bodies.NAME.motion.oscillation]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Oscillation {
    pub frequency_hz: f64,
    pub phase_deg: Option<f64>,
    pub displacement_m: Option<[f64; 3]>,
    pub angle_deg: Option<f64>,
    pub axis: Option<[f64; 3]>,
    pub centre_m: Option<[f64; 3]>,
}

/// `[bodies.NAME.motion.table]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct MotionRows {
    pub times_s: Vec<f64>,
    pub displacements_m: Option<Vec<[f64; 3]>>,
    pub angles_deg: Option<Vec<f64>>,
    pub axis: Option<[f64; 3]>,
    pub centre_m: Option<[f64; 3]>,
}
