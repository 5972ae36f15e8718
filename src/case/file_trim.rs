//! The part of a case file that describes the trim of a wing.

use std::collections::BTreeMap;

use serde::Deserialize;

/// `[equilibrium.trim]`: steady glide, whose pressures are computed.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimTable {
    /// [kg/m³].
    pub air_density_kg_m3: f64,
    /// What hangs at the hang points, harness and all [kg].
    pub pilot_mass_kg: f64,
    /// Its C_D A [m²].
    pub pilot_drag_area_m2: f64,
    /// Of lines and risers, across the stream; 1.1 if absent.
    pub line_drag_coefficient: Option<f64>,
    /// Of all cells; absent: what stands before the intakes.
    pub internal_pressure_coefficient: Option<f64>,
    /// Rows (angle [°], C_l, C_d) by name of the profile; absent: the rough polar.
    #[serde(default)]
    pub polars: BTreeMap<String, Vec<[f64; 3]>>,
    /// Of the rough polar; 1.5e6 if absent.
    pub reynolds_number: Option<f64>,
    /// Along each side of a section; 20 if absent.
    pub panels_per_side: Option<usize>,
    /// Most strips of the half wing; 40 if absent.
    pub strips: Option<usize>,
    /// Share of the new shape that the air sees; 1 if absent.
    pub relaxation: Option<f64>,
    /// Whether the trim is sought on coarser meshes first; true if absent.
    pub from_coarser_meshes: Option<bool>,
    /// When the wing stands still.
    #[serde(default)]
    pub tolerance: TrimToleranceTable,
    /// 20 if absent.
    pub iteration_limit: Option<usize>,
}

/// `equilibrium.trim.tolerance`.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimToleranceTable {
    /// Change of the speed over it; 0.002 if absent.
    pub speed: Option<f64>,
    /// Change of the glide ratio over it; 0.005 if absent.
    pub glide: Option<f64>,
    /// How far the balance still turns the wing [°]; 0.1 if absent.
    pub pitch_deg: Option<f64>,
    /// How far outlines move over the mean chord, root mean square; 0.002 if absent.
    pub shape: Option<f64>,
    /// What the risers carry less what acts, over the weight; 0.01 if absent.
    pub balance: Option<f64>,
}
