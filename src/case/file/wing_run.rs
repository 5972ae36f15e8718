//! What may be written in the tables of `[equilibrium]` that are for wings: their pressure, trim, load test and panel shaping.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::wing::Ballooning;

/// Prescribed pressure of a wing: q (C_i − C_o) acts along the normals of the panels and follows them (docs/wings.md). Exactly one of `inside`
/// and `inside_per_cell`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingPressure {
    /// Dynamic pressure q [Pa].
    pub dynamic_pressure_pa: f64,
    /// C_i of all cells; 1 at a stagnation point.
    pub inside: Option<f64>,
    /// C_i of each cell, from the left tip.
    pub inside_per_cell: Option<Vec<f64>>,
    /// Points [x/c, C_o] outside over the upper side.
    pub upper: Vec<[f64; 2]>,
    /// Points [x/c, C_o] outside over the lower side.
    pub lower: Vec<[f64; 2]>,
    /// Points [distance from the middle over the half span, share of C_o]; 1 everywhere if absent.
    pub along_span: Option<Vec<[f64; 2]>>,
}

/// Steady glide of a wing, whose pressures are computed by panels (docs/wings.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trim {
    /// Density of the air [kg/m³].
    pub air_density_kg_m3: f64,
    /// Mass that hangs at the hang points, harness and all [kg]. The wing brings its own.
    pub pilot_mass_kg: f64,
    /// C_D A of the pilot [m²].
    pub pilot_drag_area_m2: f64,
    /// C_d of lines and risers across the stream, with the diameters of their materials; 1.1 if absent.
    pub line_drag_coefficient: Option<f64>,
    /// C_i of all cells; if absent it follows from the pressure along the open intakes (docs/wings.md). A closed wing must have it.
    pub internal_pressure_coefficient: Option<f64>,
    /// Rows [angle in °, C_l, C_d] by name of the profile; absent: computed by boundary layers, for the flown turn of the trailing edge, too (docs/low-order-aerodynamics.md). Given ones are of sections as drawn: a sweep of brakes is refused with them.
    #[serde(default)]
    pub polars: BTreeMap<String, Vec<[f64; 3]>>,
    /// Reynolds number of computed polars; 1.5e6 if absent.
    pub reynolds_number: Option<f64>,
    /// Exponent of the amplification at which a laminar layer turns turbulent, 0.5 to 20, of computed polars; 9 if absent.
    pub critical_amplification: Option<f64>,
    /// Places x/c, above and below, at which layers are turbulent at the latest, of computed polars; absent: below at the rear edge of the intakes, of cells that have one.
    pub transition: Option<[f64; 2]>,
    /// Drag coefficient of seams, wrinkles and pores, beside that of the intakes, of computed polars; 0.004 if absent (Ware & Hassell 1969).
    pub surface_drag_coefficient: Option<f64>,
    /// Panels along each side of a section; 20 if absent.
    pub panels_per_side: Option<usize>,
    /// Strips of the half wing, at most one per cell; 40 if absent.
    pub strips: Option<usize>,
    /// Share of the new shape that the air sees; 1 if absent.
    pub relaxation: Option<f64>,
    /// Whether the trim is sought first on meshes with half, a quarter, … of the edges each way, not below 10 along the chord and 2 across a
    /// cell; each carries its displacements over to the next. `true` if absent; `false`: from the drawn shape at once.
    pub from_coarser_meshes: Option<bool>,
    /// When the wing stands still; absent: with the values of its keys.
    #[serde(default)]
    pub tolerance: TrimTolerance,
    /// Outer iterations allowed; 20 if absent. Not settled by then: exit code 20.
    pub iteration_limit: Option<usize>,
}

/// When a wing stands still in its trim.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrimTolerance {
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

/// The loads of the equilibrium, several times over (docs/wing-design.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadTest {
    /// Multiples of the loads, growing, above 1 and at most 100, e.g. `[2.0, 3.0, 4.0, 6.0, 8.0]`.
    pub load_factors: Vec<f64>,
}

/// Panels that fly as they were designed (docs/wing-design.md).
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PanelShaping {
    /// What is to come out; `ballooning` if absent.
    pub aim: Option<ShapingAim>,
    /// Ballooning to be flown, only with `aim = "ballooning"`; that of the plan if absent.
    pub target: Option<Ballooning>,
    /// Largest difference of the flown ballooning from `target`, or of the distance of ribs over the designed one; 0.002 if absent.
    pub tolerance: Option<f64>,
    /// Share of the difference by which panels are changed; 0.7 if absent.
    pub relaxation: Option<f64>,
    /// Changes of the panels allowed; 10 if absent. Not reached by then: exit code 20.
    pub iteration_limit: Option<usize>,
}

/// What panels are shaped for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShapingAim {
    /// Ribs fly as far apart as they were designed.
    CellWidth,
    /// Panels stand out as far as is wanted.
    Ballooning,
}
