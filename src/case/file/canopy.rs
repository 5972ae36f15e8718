//! What may be written of every canopy: how it is folded, and `[lines]`.

use schemars::JsonSchema;
use serde::Deserialize;

/// Keys that every canopy has.
#[derive(Debug, Clone)]
pub(in crate::case) struct CanopyCommon {
    pub(in crate::case) confluence_m: Option<[f64; 3]>,
    pub(in crate::case) apex_guide_n_m: Option<f64>,
    pub(in crate::case) folding: Folding,
}

/// How a canopy is folded at the start: pleats that keep all lengths (docs/canopies.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Folding {
    /// D_p/D_0 of the pleats, seams outward and centre lines inward; 0.02 to 0.95.
    pub folded_diameter_ratio: f64,
    /// D_p/D_0 to which pressure opens the canopy before the wind starts.
    pub opened_diameter_ratio: f64,
    /// Pressure that opens it to `opened_diameter_ratio` [Pa].
    pub loading_pressure_pa: f64,
    /// Turn of the folded canopy towards +y about the confluence, −45 to 45 [°]; 0 if absent. Not with `apex_guide_n_m`.
    pub tilt_deg: Option<f64>,
    /// a of pleats that are not alike, at most 0.8: gore g takes the azimuth 2π/N (1 + a cos(2π (g + ½)/N)); 0 if absent.
    pub asymmetry: Option<f64>,
}

/// Suspension lines of a canopy. Exactly one of `youngs_modulus_pa` and `force_strain`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lines {
    /// Number of lines: one per seam (`gores`), or one more on every centre line (twice that). Cruciform: a multiple of 4, shared out over
    /// the four ends from corner to corner.
    pub count: usize,
    /// Length of the line that reaches farthest from the folded canopy [m]; all have the same unstretched length.
    pub length_m: f64,
    /// Unstretched length beyond `length_m` [m]; negative for tight lines; 0 if absent.
    pub slack_m: Option<f64>,
    /// Straight pieces of a line, with its mass and drag along it, 1 to 200; 1 if absent.
    pub segments: Option<usize>,
    /// Length of a riser below the confluence, as strong and heavy as all lines together [m]; absent: none. Its lower end is held or
    /// carries the payload. With several risers, of those above it, and required.
    pub riser_length_m: Option<f64>,
    /// Risers above the confluence, a divisor of `count` and less than it: `count`/`riser_count` neighbouring lines join into each. 1, below
    /// it, if absent.
    pub riser_count: Option<usize>,
    /// Cross section of a line [m²].
    pub area_m2: f64,
    /// Density [kg/m³].
    pub density_kg_m3: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: Option<f64>,
    /// Points [strain, force in N] of a tensile test, rising from (0, 0); beyond the last it goes on straight.
    pub force_strain: Option<Vec<[f64; 2]>>,
    /// c of T = f(ε) + c dε/dt while taut [N s]; 0 if absent.
    pub damping_n_s: Option<f64>,
    /// C_d of drag across the lines, ½ ρ C_d d |u_n| u_n per length, in the undisturbed wind and not given to the air; absent: none.
    pub drag_coefficient: Option<f64>,
    /// Diameter d of `drag_coefficient` [m]; required with it, and refused without.
    pub diameter_m: Option<f64>,
    /// Breaking load of a line [N], for margins; absent: not told.
    pub breaking_load_n: Option<f64>,
}
