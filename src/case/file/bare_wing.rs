//! What may be written in `[aero]`: a wing by itself, whose forces are computed without a lattice.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

/// Low-order aerodynamics of what stands in the case, for `ripstop polar` (docs/polars.md). A case with this table has no air, structure or time.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Aero {
    /// A wing by its sections: kites, tails, anyone's wing.
    pub wing: BareWing,
}

/// A wing by its sections. x runs downstream, y to the right, z up.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BareWing {
    /// Speed of the air [m/s]; Reynolds numbers and loads follow from it.
    pub speed_m_s: f64,
    /// Density of the air [kg/m³]; 1.225 if absent.
    pub air_density_kg_m3: Option<f64>,
    /// Kinematic viscosity of the air [m²/s]; 1.46e-5 if absent.
    pub kinematic_viscosity_m2_s: Option<f64>,
    /// Angles of attack against the x axis: from, to, step [°]; −6 to 20 by 1 if absent. `--angle` changes it.
    pub angles_deg: Option<[f64; 3]>,
    /// Angle of sideslip, air from the right [°]; 0 if absent.
    pub sideslip_deg: Option<f64>,
    /// Whether the stations are the right half of a wing that is symmetric about y = 0; `true` if absent. Else they run from the left tip to the right one.
    pub symmetric: Option<bool>,
    /// Where along the chord the positions of the stations are, 0 at the nose; 0.25 if absent.
    pub chord_fraction: Option<f64>,
    /// Sections in order of the span; everything varies linearly between them. Either these or `mesh`.
    #[serde(default)]
    pub stations: Vec<BareStation>,
    /// Profiles with their polars, by name.
    #[serde(default)]
    pub profiles: BTreeMap<String, BareProfile>,
    /// Surface of a wing to be cut into sections, in place of `stations`; its right half counts, and the wing is symmetric.
    pub mesh: Option<BareMesh>,
    /// Area of the coefficients [m²]; that of the chords, the wing laid flat, if absent.
    pub reference_area_m2: Option<f64>,
    /// Length of the coefficients of moments [m]; the mean aerodynamic chord if absent.
    pub reference_chord_m: Option<f64>,
    /// Point that moments are about [m]; the quarter of the mean aerodynamic chord if absent.
    pub moment_point_m: Option<[f64; 3]>,
    /// Panels along each side of a section, 4 to 200; 20 if absent.
    pub panels_per_side: Option<usize>,
    /// Strips along the span (of the half of a symmetric wing), 2 to 400; 24 if absent.
    pub strips: Option<usize>,
    /// How much narrower strips become towards tips, from 0 (equal strips) to 1 (cosine spacing); 0.8 if absent.
    pub tip_clustering: Option<f64>,
}

impl BareWing {
    /// Files that it names.
    pub(in crate::case) fn named_files(&self) -> impl Iterator<Item = &str> {
        let of_profiles = self
            .profiles
            .values()
            .flat_map(|p| [&p.file, &p.polar_file]);
        let mesh = self.mesh.iter().map(|mesh| mesh.file.as_str());
        of_profiles.flatten().map(String::as_str).chain(mesh)
    }
}

/// A section of a wing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BareStation {
    /// Point of the chord at `chord_fraction` [m].
    pub position_m: [f64; 3],
    /// Chord [m]; 0 is allowed at a tip.
    pub chord_m: f64,
    /// Turn about that point, nose up [°]; 0 if absent.
    pub twist_deg: Option<f64>,
    /// Lean of the section, the right tip up [°]; absent: across the span, half-way at its corners.
    pub roll_deg: Option<f64>,
    /// Name of the profile.
    pub profile: String,
}

/// The surface of a wing in a file. Polars of its sections are computed.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BareMesh {
    /// OBJ, STL or PLY file, relative to the case file: x downstream, y along the span, z up.
    pub file: String,
    /// Metres per unit of the file.
    pub scale: f64,
    /// Sections of the half wing, 3 to 60; 12 are usual.
    pub sections: usize,
    /// Exponent of the amplification at which a laminar layer turns turbulent, 0.5 to 20; 9 if absent.
    pub critical_amplification: Option<f64>,
    /// Places x/c, above and below, at which layers are turbulent at the latest; absent: by their amplification alone.
    pub transition: Option<[f64; 2]>,
}

/// A profile and what viscosity does to it. Exactly one of `naca` and `file`; at most one of `polar` and `polar_file`, without which the polar is computed
/// at the Reynolds number of each strip.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BareProfile {
    /// Four or five digits of a NACA profile.
    pub naca: Option<String>,
    /// File of coordinates in Selig's format, relative to the case file.
    pub file: Option<String>,
    /// Rows [angle in °, C_l, C_d], by growing angle.
    pub polar: Option<Vec<[f64; 3]>>,
    /// Polar as XFOIL writes it (columns alpha, CL, CD, CDp, CM), relative to the case file.
    pub polar_file: Option<String>,
    /// Exponent of the amplification at which a laminar layer turns turbulent, 0.5 to 20; 9 if absent (a quiet wind tunnel). Of a computed polar.
    pub critical_amplification: Option<f64>,
    /// Places x/c, above and below, at which layers are turbulent at the latest; absent: by their amplification alone. Of a computed polar.
    pub transition: Option<[f64; 2]>,
}
