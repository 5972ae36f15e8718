//! What may be written in `[time]`, `[gravity]`, `[coupling]`, `[solver]`, `[equilibrium]` and `[steady]`: how a scene is computed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::wing_run::{LoadTest, PanelShaping, Trim, WingPressure};
use crate::cloth::TimeIntegration;

/// Acts on the structure and on what falls.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration [m/s²].
    pub acceleration_m_s2: [f64; 3],
}

/// Coupling of the air with fabric and rigid bodies.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// How air and surfaces meet; `"kernel"` if absent.
    pub scheme: Option<Scheme>,
    /// Over-relaxation a of the force, at most 8/3; 1.6 if absent.
    pub over_relaxation: Option<f64>,
    /// Steps of the air per step of the fabric at most, 1 to 10, only with fabric; fewer are taken where a marker would move more than
    /// 0.25 cells between two. If absent the plan takes 1, quietest and exact in momentum (docs/coupling.md).
    pub structure_every: Option<u32>,
    /// Passes of multi-direct forcing, only without fabric; 1 if absent. 5 with `over_relaxation = 1.0` is P0's scheme.
    pub passes: Option<u32>,
    /// How far markers stand inside closed surfaces of rigid bodies [cells]; 0.5 if absent.
    pub surface_inset_cells: Option<f64>,
    /// How far markers stand inside rims of rigid bodies and fabric [cells]; 0.65 if absent. Narrow openings have a wider inset, in
    /// proportion (docs/coupling.md#rims-and-openings).
    pub rim_inset_cells: Option<f64>,
    /// Largest distance of neighbouring markers, 0.25 to 1.5 [cells]; 1 if absent. Insets were calibrated with 1; the farther apart, the
    /// lower the drag (`ripstop validate marker-spacing`).
    pub marker_spacing_cells: Option<f64>,
    /// How vents narrower than two cells, and gaps and slots narrower than three, pass air, only with `scheme = "links"` and fabric; `"cells"` if absent (docs/cut-links.md#narrow-openings).
    pub narrow_openings: Option<NarrowOpenings>,
    /// Multiplies the masses of the structure, to study light and heavy sheets; 1 if absent.
    pub mass_factor: Option<f64>,
    /// Reynolds number of the length of run at which boundary layers of surfaces with `friction = "model"` turn from laminar to turbulent, 0 to 1e9; 0 if absent: they are
    /// turbulent from their front on (docs/cut-links.md#boundary-layers-that-the-cells-do-not-hold).
    pub transition_reynolds: Option<f64>,
}

/// How air and surfaces meet (docs/cut-links.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Markers on the surface act on the air within two cells.
    Kernel,
    /// Links of the lattice that the surface cuts: what leaves along them comes back.
    Links,
}

/// How vents narrower than two cells, and gaps and slots narrower than three, pass air.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NarrowOpenings {
    /// By the law of a sharp edge.
    Law,
    /// As the cells let them, which is too little.
    Cells,
}

/// Solver of the fabric (docs/case-files.md#when-a-solve-of-the-fabric-ends).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solver {
    /// Tolerance of one step, relative to the loads in the energy norm; 1e-2 if absent, with a payload 1e-3.
    pub tolerance: Option<f64>,
    /// Evaluations allowed in one step; 2000 if absent.
    pub evaluation_limit: Option<usize>,
    /// Damping in proportion to the mass [1/s]; 0 if absent.
    pub damping_1_s: Option<f64>,
    /// Whether a run whose solves missed their tolerance ends with exit code 0 all the same; its account says so as before. `false` if
    /// absent.
    pub allow_unsolved: Option<bool>,
}

/// Simulated time; required with air. Absent: no motion, only the equilibrium.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// End of the run [s].
    pub end_s: f64,
    /// Implicit step of the fabric [s]; required without air, and refused with it, which has its own. With `[time.adaptive]` the largest.
    pub step_s: Option<f64>,
    /// How the fabric's motion is integrated, only with fabric; `"bdf2"` if absent (docs/case-files.md#integration-in-time).
    pub integration: Option<TimeIntegration>,
    /// Divides steps as accuracy asks for, only without air; absent: every step is solved at once.
    pub adaptive: Option<AdaptiveSteps>,
}

/// Steps are halved where positions would err by more than a tolerance in one, or the solver does not reach its own (docs/case-files.md#adaptive-steps).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveSteps {
    /// Error of positions allowed in one step, root mean square over the mass [m].
    pub tolerance_m: f64,
    /// Shortest part of a step [s].
    pub smallest_step_s: f64,
}

/// Static equilibrium, after the motion if there is one; only without air. Not reached: exit code 20.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Equilibrium {
    /// Tolerance, relative to the loads in the energy norm; without loads to the smallest element.
    pub tolerance: f64,
    /// Evaluations allowed.
    pub evaluation_limit: usize,
    /// Pressure jump along the normals of the triangles, which follows the fabric [Pa]; 0 if absent. Required of
    /// `[structure.lep_sim]`, refused for `[structure.wing]`.
    pub pressure_pa: Option<f64>,
    /// Prescribed pressure inside and outside of a wing.
    pub wing_pressure: Option<WingPressure>,
    /// Steady glide of a wing: speed, glide angle and attitude are sought. Needs `[gravity]`.
    pub trim: Option<Trim>,
    /// The loads of a wing's equilibrium, several times over.
    pub load_test: Option<LoadTest>,
    /// Widths of panels with which the flown shape of a wing is the designed one.
    pub panel_shaping: Option<PanelShaping>,
}

/// The run stops when the mean drag is known well enough (docs/steady-runs.md, docs/rigid-bodies.md); absent: at its end. Refused where
/// nothing becomes steady.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Steady {
    /// Half width of the 95 % interval of the mean drag over it at which the run stops. Of a canopy over 6 D_0/U at least, averaged from
    /// 18 D_0/U after the first peak of the diameter on; of rigid bodies alone, of every body.
    pub drag_confidence: f64,
    /// Cell sizes of coarser grids that the run of a canopy begins on, as multiples of its own, falling; `[2.0]` is usual; absent: none.
    /// Fabric, time and forces go on from grid to grid.
    pub grid_sequence: Option<Vec<f64>>,
}
