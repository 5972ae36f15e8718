//! What may be written in `[payload]`: what hangs on a canopy and falls with it.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::fabric::CableMaterial;

/// A point mass where a canopy's lines meet, or at the lower end of its riser, in `[air.descent]`. Absent: that node is held. In
/// `[air.wind_tunnel]` it is held, too: there the run tells at which rate canopy and payload would descend.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass [kg].
    pub mass_kg: f64,
    /// C_D S of the payload itself, in the undisturbed wind [m²]; 0 if absent.
    pub drag_area_m2: Option<f64>,
    /// What hangs below it, by name. The box follows the payload.
    #[serde(default)]
    pub bodies: BTreeMap<String, PayloadBody>,
}

/// A further point mass on a tether, straight down and without tension at release. Columns `NAME_tether_tension_n` and
/// `NAME_tether_swing_deg`, from straight down; results: the largest of both.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PayloadBody {
    /// Mass [kg].
    pub mass_kg: f64,
    /// C_D S, in the undisturbed wind [m²]; 0 if absent.
    pub drag_area_m2: Option<f64>,
    /// Name of another body that it hangs from; the payload if absent.
    pub hangs_from: Option<String>,
    /// Length of the tether [m].
    pub tether_length_m: f64,
    /// What the tether is made of.
    pub tether: CableMaterial,
}
