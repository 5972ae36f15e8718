//! Mirror of `[air.descent]`, `[payload]` with its bodies, and `free_fall`.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::file::{CableMaterial, WindTunnel};

/// `[air.descent]`: a box that falls along −x with what it holds, so that the air comes along +x.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct Descent {
    pub release_speed_m_s: f64,
    pub size_m: [f64; 3],
    pub start_time_s: f64,
    pub sponge_length_m: Option<f64>,
    /// Instead of `air.density_kg_m3`.
    pub altitude_m: Option<f64>,
}

impl Descent {
    /// The tunnel that the box is at release.
    pub(super) const fn tunnel(&self) -> WindTunnel {
        WindTunnel {
            speed_m_s: self.release_speed_m_s,
            size_m: self.size_m,
            start_time_s: self.start_time_s,
            sponge_length_m: self.sponge_length_m,
        }
    }
}

/// `[payload]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct PayloadTable {
    pub mass_kg: f64,
    pub drag_area_m2: Option<f64>,
    /// What hangs below it, by name.
    #[serde(default)]
    pub bodies: BTreeMap<String, PayloadBodyTable>,
}

/// `[payload.bodies.NAME]`: a point mass on a tether.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct PayloadBodyTable {
    pub mass_kg: f64,
    pub drag_area_m2: Option<f64>,
    /// Another of them; absent: the payload.
    pub hangs_from: Option<String>,
    pub tether_length_m: f64,
    pub tether: CableMaterial,
}

/// `[bodies.NAME.motion.free_fall]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the keys are documented in docs/case-files.md and name quantity and unit"
)]
pub struct FreeFall {
    pub mass_kg: f64,
}
