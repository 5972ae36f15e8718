//! The part of a case file that describes test specimens of fabric.

use serde::Deserialize;

/// `[structure.airbag]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Airbag {
    /// Side of the flat square bag [m].
    pub side_m: f64,
    /// Cells along a side; even.
    pub cells_per_side: usize,
}

/// `[structure.disc]`: clamped at its rim, in the plane z = 0.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Radius [m].
    pub radius_m: f64,
    /// Rings of triangles.
    pub rings: usize,
}

/// `[structure.coupon]`: a strip along x, clamped at both ends, pulled at one.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupon {
    /// Length between the clamps [m].
    pub length_m: f64,
    /// Width [m].
    pub width_m: f64,
    /// Cells over the width.
    pub cells_across: usize,
    /// From the length to the warp [°].
    pub warp_angle_deg: f64,
    /// Way of the pulled clamp over the length.
    pub elongation: f64,
}
