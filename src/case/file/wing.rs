//! What may be written in `[structure.wing]`: the plan of a wing.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::fabric::Fabric;
use super::friction::Friction;

/// The whole plan of a ram-air wing, and the mesh to make of it (docs/wings.md). x runs from nose to trailing edge, z up; the nose of the
/// middle is the origin. Both halves are mirror images. Ribs count from the middle outwards.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wing {
    /// Cells from tip to tip, 1 to 400.
    pub cells: usize,
    /// Width of the outermost cell over the middlemost one's, 0.1 to 3; 1 if absent.
    pub tip_cell_width_ratio: Option<f64>,
    /// Distances of the right half's ribs from the middle along the arc, outwards to the tip [m]; the first is 0 where the number of cells is even,
    /// else half the width of the cell in the middle. Absent: as `tip_cell_width_ratio` has it.
    pub rib_places_m: Option<Vec<f64>>,
    /// Where the right half's risers are held [m].
    pub hang_point_m: [f64; 3],
    /// Stiffness of a spring along x at the nose in the middle [N/m]; absent: none, in a trim 500. Prescribed pressure turns with the
    /// wing, and nothing else keeps it from drifting. Not in the wind.
    pub pitch_guide_n_m: Option<f64>,
    /// Where short ribs in the middle of every cell begin, per chord, 0.5 to 0.95; they end at the trailing edge. Absent: none.
    pub mini_ribs_from: Option<f64>,
    /// Sections from the middle to the tip, joined by monotone cubics.
    pub stations: Vec<Station>,
    /// Profiles by name. Exactly one of `naca` and `file` in each.
    pub profiles: BTreeMap<String, Profile>,
    /// How far panels stand out between their ribs; absent: flat panels.
    pub ballooning: Option<Ballooning>,
    /// Openings at the nose; absent: a closed wing.
    pub intakes: Option<Intakes>,
    /// Holes of all ribs but those at the tips; absent: none.
    #[serde(default)]
    pub holes: Vec<Hole>,
    /// What it is sewn of.
    pub fabrics: WingFabrics,
    /// Materials of lines, risers and tapes, by name.
    pub line_materials: BTreeMap<String, LineMaterial>,
    /// Rows of lines, by name, from the nose to the brakes.
    pub rows: BTreeMap<String, LineRow>,
    /// V- and H-ribs as drawn, beside the rows' `diagonals`; absent: none.
    #[serde(default)]
    pub vh_ribs: Vec<VhRib>,
    /// Rods in pockets along the ribs' seams, by name; absent: none.
    #[serde(default)]
    pub rods: BTreeMap<String, Rod>,
    /// Speed bar, which shortens risers; absent: none.
    pub speed_bar: Option<SpeedBar>,
    /// Pull on the brakes [m], 0 to 2; 0 if absent. It shortens the risers of rows behind 0.99 of the chord, beyond their `trim_m`.
    pub brake_pull_m: Option<f64>,
    /// Tapes along the span, by name: cables that share nodes with the fabric. Absent: none.
    #[serde(default)]
    pub tapes: BTreeMap<String, Tape>,
    /// How fine the mesh is.
    pub mesh: WingMesh,
    /// How it stands in the wind; only with `[air.wind_tunnel]`, and required there.
    pub tunnel: Option<WingTunnel>,
}

/// How a wing stands in the wind (docs/ram-air.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingTunnel {
    /// Where the middle between both hang points stands [m].
    pub place_m: [f64; 3],
    /// Turn about `place_m`, nose up [°]; 0 if absent.
    pub pitch_deg: Option<f64>,
    /// The panels start laid together: every point at this share of its height over the lower side of the ribs, 0.05 to 1; 1 if absent.
    pub start_thickness_ratio: Option<f64>,
    /// What is held; `hang_points` if absent.
    pub held: Option<HeldName>,
    /// C_d of lines and risers across the undisturbed wind, with the diameters of their materials; 1.1 if absent, 0 for none.
    pub line_drag_coefficient: Option<f64>,
    /// How the air passes along panels and the ribs at the tips, what the wind outside meets; `none` if absent.
    pub friction: Option<Friction>,
    /// How the air passes along ribs inside, mini-ribs and diagonals; `none` if absent.
    pub inner_friction: Option<Friction>,
}

/// What of a wing in the wind is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeldName {
    /// Where the risers hang: the lines carry the wing, which swings about these points.
    HangPoints,
    /// Where the lines are sewn on, too, but for rows that are pulled in: the attitude stays.
    Attachments,
    /// All nodes: a rigid wing.
    Everything,
}

/// A section of the wing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Station {
    /// Distance from the middle along the arc, 0 in the middle [m].
    pub span_m: f64,
    /// Chord [m].
    pub chord_m: f64,
    /// How far the leading edge lies behind that of the middle [m].
    pub sweep_m: f64,
    /// Lean of the rib [°]. The arc is y, z = ∫ (cos, −sin) of it along the span, so the flat span stays whatever the arc.
    pub roll_deg: f64,
    /// Turn about the quarter chord, nose up [°].
    pub twist_deg: f64,
    /// Name of the profile.
    pub profile: String,
}

/// A profile.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Four digits of a NACA profile: thickness is added across the chord, the trailing edge is closed.
    pub naca: Option<String>,
    /// File of coordinates in Selig's format, relative to the case file (docs/wing-design.md).
    pub file: Option<String>,
    /// Places above and below, per chord, between which the nose is cut off along a straight line; what is left is scaled to the chord
    /// from the upper lip to the trailing edge. Absent: it is whole.
    pub nose_cut: Option<[f64; 2]>,
}

/// Points [x/c, b]: a panel is (1 + b) times as wide as the distance of its ribs, in a circular arc; 0 at the trailing edge.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ballooning {
    /// Upper panels.
    pub upper: Vec<[f64; 2]>,
    /// Lower panels.
    pub lower: Vec<[f64; 2]>,
}

/// Openings on the lower side of the nose.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Intakes {
    /// Front edge, per chord, 0 to 0.3.
    pub from: f64,
    /// Rear edge, per chord.
    pub to: f64,
    /// Cells at each tip without intake; 0 if absent.
    pub closed_tip_cells: Option<usize>,
}

/// A hole of ribs.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hole {
    /// Its middle, per chord.
    pub position: f64,
    /// Its length, per chord.
    pub width: f64,
    /// Its height over the rib's, 0.05 to 0.9.
    pub height: f64,
}

/// A rod that holds the outline of ribs against folding, straight until it is put in. With both sides it goes around the nose.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// Places on the upper side between which it lies, per chord; the first is 0 where it goes around the nose. Absent: it does not reach there.
    pub upper: Option<[f64; 2]>,
    /// Places on the lower side between which it lies, in the same way.
    pub lower: Option<[f64; 2]>,
    /// Diameter [m].
    pub diameter_m: f64,
    /// Modulus of elasticity [Pa]; 2.8e9, of nylon, if absent.
    pub youngs_modulus_pa: Option<f64>,
    /// Density [kg/m³]; 1140, of nylon, if absent.
    pub density_kg_m3: Option<f64>,
    /// Ribs with such a rod, counted from the middle; all if absent.
    pub ribs: Option<Vec<usize>>,
}

/// Fabrics of a wing.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingFabrics {
    /// Upper panels.
    pub upper: Fabric,
    /// Lower panels; the upper one's if absent.
    pub lower: Option<Fabric>,
    /// Ribs and mini-ribs; the upper panels' if absent.
    pub ribs: Option<Fabric>,
    /// Diagonals; the ribs' if absent.
    pub diagonals: Option<Fabric>,
}

/// Material of lines, risers or tapes. Exactly one of `axial_stiffness_n` and `force_strain`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineMaterial {
    /// Diameter, or what a round line of the same section has [m].
    pub diameter_m: f64,
    /// Mass per length [kg/m].
    pub mass_per_length_kg_m: f64,
    /// EA [N].
    pub axial_stiffness_n: Option<f64>,
    /// Points [strain, force in N] of a tensile test, rising from (0, 0).
    pub force_strain: Option<Vec<[f64; 2]>>,
    /// Breaking load [N], for margins; absent: not told.
    pub breaking_load_n: Option<f64>,
}

/// A row of lines.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineRow {
    /// Place on the lower side, per chord; 1 is the trailing edge, where brakes are.
    pub position: f64,
    /// Ribs with attachments, counted from the middle; they grow outwards, but for a row with `positions`.
    pub ribs: Vec<usize>,
    /// Place of every attachment on the lower side, per chord, where they are not all at `position`: a line may then lead to any rib, and several to one.
    pub positions: Option<Vec<f64>>,
    /// Weights of the attachments, in the order of `ribs`, in the means that nodes and the riser point to, such as the loads that a design takes for them; alike if absent.
    pub weights: Option<Vec<f64>>,
    /// Levels of lines from the attachments down.
    pub levels: Vec<LineLevel>,
    /// Length of the riser [m].
    pub riser_length_m: f64,
    /// Name of the material of the riser.
    pub riser_material: String,
    /// Length by which the riser is made longer [m]; 0 if absent.
    pub trim_m: Option<f64>,
    /// Diagonals (V-ribs) at the attachments; absent: none.
    pub diagonals: Option<Diagonals>,
    /// How its risers are pulled in; absent: not at all.
    pub pull: Option<Pull>,
}

/// A speed bar: pulleys that shorten the risers of the front rows.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedBar {
    /// By how much it shortens the riser of each row at full travel [m], by the row's name.
    pub shortening_m: BTreeMap<String, f64>,
    /// Share of the travel that the pilot has taken, 0 to 1; 0 if absent. `ripstop polar --bar` varies it.
    pub used: Option<f64>,
}

/// How risers are pulled in over time; needs `[time]`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pull {
    /// Length by which the riser is shortened [m].
    pub length_m: f64,
    /// Points [time in s, share of `length_m`], from t = 0 and a share of 0 on, straight between them.
    pub table: Vec<[f64; 2]>,
    /// On one half of the wing; on both if absent.
    pub half: Option<HalfName>,
}

/// Half of a wing, as the pilot sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HalfName {
    /// y < 0.
    Left,
    /// y > 0.
    Right,
}

/// A level of lines. All but the last have `joins`, and either `height` or `to_sail_m`; lines of the last meet at the riser.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineLevel {
    /// Name of the material of the lines.
    pub material: String,
    /// How many lines join at each node below, from the middle to the tip; absent: all meet at the riser.
    pub joins: Option<Vec<usize>>,
    /// Where they join: share of the way from the riser to the mean of the attachments above.
    pub height: Option<f64>,
    /// Where they join, in place of `height`: way from each node to the sail, a number for each of `joins` [m]. A node lies on the way from the riser or node below to the mean of the attachments above; the line between two nodes is as long as their numbers differ.
    pub to_sail_m: Option<Vec<f64>>,
}

/// Diagonals from an attachment to the upper seams of both neighbouring ribs; their ends lie at nodes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Diagonals {
    /// Width at the attachment, per chord.
    pub foot: f64,
    /// Width at the upper seam, per chord.
    pub head: f64,
}

/// Fabric between two neighbouring ribs on both halves: a V-rib from one seam towards the other, or an H-rib (strap) along one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VhRib {
    /// The ribs, counted from the middle. With an odd number of cells [0, 1] lies across the middle cell.
    pub ribs: [usize; 2],
    /// Places between which it is sewn to each of them, per chord; at least one edge of the mesh on each side of their middle.
    pub between: [[f64; 2]; 2],
    /// Heights there over those of the ribs: 0 is the lower seam, 1 the upper one; else 0.1 to 0.9. A hole that lies in the way is left out of the rib.
    pub heights: [f64; 2],
}

/// Side of a wing.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SideName {
    /// Upper side.
    Upper,
    /// Lower side.
    Lower,
}

/// A tape along the span.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tape {
    /// Side of the wing.
    pub side: SideName,
    /// Place, per chord.
    pub position: f64,
    /// Whether it is sewn on the panels; else it runs straight from rib to rib.
    pub sewn: bool,
    /// Name of the material.
    pub material: String,
}

/// How fine the mesh of a wing is.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingMesh {
    /// Edges along each side of a rib.
    pub along_chord: usize,
    /// Edges across each cell; even.
    pub across_cell: usize,
}
