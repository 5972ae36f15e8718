//! The part of a case file that describes a wing.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::file::Fabric;

/// `[structure.wing]`: the whole plan of a wing, with the mesh to make of it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WingTable {
    /// Cells from tip to tip.
    pub cells: usize,
    /// Width of the outermost cell over the middlemost one's; 1 if absent.
    pub tip_cell_width_ratio: Option<f64>,
    /// Where the right half's risers are held [m].
    pub hang_point_m: [f64; 3],
    /// Keeps the middle from drifting along x, since prescribed pressure turns with the wing [N/m]; absent: nothing does.
    pub pitch_guide_n_m: Option<f64>,
    /// Where mini-ribs begin, per chord; absent: none.
    pub mini_ribs_from: Option<f64>,
    /// From the middle to the tip.
    pub stations: Vec<StationTable>,
    /// Profiles by name.
    pub profiles: BTreeMap<String, ProfileTable>,
    /// Absent: flat panels.
    pub ballooning: Option<BallooningTable>,
    /// Absent: a closed wing.
    pub intakes: Option<IntakesTable>,
    /// Holes of ribs.
    #[serde(default)]
    pub holes: Vec<HoleTable>,
    /// What it is sewn of.
    pub fabrics: WingFabrics,
    /// Materials of lines, risers and tapes, by name.
    pub line_materials: BTreeMap<String, LineMaterialTable>,
    /// Rows of lines, by name.
    pub rows: BTreeMap<String, RowTable>,
    /// Tapes along the span, by name.
    #[serde(default)]
    pub tapes: BTreeMap<String, TapeTable>,
    /// How fine the mesh is.
    pub mesh: WingMeshTable,
    /// How it stands in the wind; only with air.
    pub tunnel: Option<WingTunnelTable>,
}

/// `[structure.wing.tunnel]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WingTunnelTable {
    /// The middle between both hang points [m].
    pub place_m: [f64; 3],
    /// Turn about it, nose up [°]; 0 if absent.
    pub pitch_deg: Option<f64>,
    /// Thickness of the wing at the start over that of the design; 1 if absent.
    pub start_thickness_ratio: Option<f64>,
    /// What is held; the hang points if absent.
    pub held: Option<HeldName>,
    /// Which parts hold the air back along them, too; none if absent.
    pub friction: Option<FrictionName>,
}

/// Which parts of a wing in the wind hold the air back along them, not only across.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionName {
    /// None: air slides along them all.
    None,
    /// Panels and the ribs at the tips: what the wind outside meets.
    Outside,
    /// Ribs inside and diagonals, too.
    Everywhere,
}

/// What of a wing in the wind is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldName {
    /// Where the risers hang.
    HangPoints,
    /// Where the lines are sewn on, too, but for rows that are hauled in.
    Attachments,
    /// All nodes: a rigid wing.
    Everything,
}

/// An entry of `structure.wing.stations`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationTable {
    /// From the middle along the arc [m].
    pub span_m: f64,
    /// Chord [m].
    pub chord_m: f64,
    /// How far the leading edge lies behind that of the middle [m].
    pub sweep_m: f64,
    /// Lean of the rib [°].
    pub roll_deg: f64,
    /// Nose up [°].
    pub twist_deg: f64,
    /// Name of the profile.
    pub profile: String,
}

/// `[structure.wing.profiles.NAME]`: `naca` or `file`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileTable {
    /// Four digits.
    pub naca: Option<String>,
    /// Coordinates in Selig's format, relative to the case file.
    pub file: Option<String>,
    /// The nose is cut off from so far behind it above to so far below, per chord; absent: it is whole.
    pub nose_cut: Option<[f64; 2]>,
}

/// `[structure.wing.ballooning]`: points (x/c, width over the distance of the ribs less 1).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallooningTable {
    /// Upper panels.
    pub upper: Vec<[f64; 2]>,
    /// Lower panels.
    pub lower: Vec<[f64; 2]>,
}

/// `[structure.wing.intakes]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IntakesTable {
    /// Front edge on the lower side, per chord.
    pub from: f64,
    /// Rear edge.
    pub to: f64,
    /// Cells at each tip without intake; 0 if absent.
    pub closed_tip_cells: Option<usize>,
}

/// An entry of `structure.wing.holes`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoleTable {
    /// Middle, per chord.
    pub position: f64,
    /// Length, per chord.
    pub width: f64,
    /// Height over the rib's.
    pub height: f64,
}

/// `[structure.wing.fabrics]`.
#[derive(Debug, Clone, Deserialize)]
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

/// `[structure.wing.line_materials.NAME]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineMaterialTable {
    /// Diameter, or what a round line of the same section has [m].
    pub diameter_m: f64,
    /// Mass per length [kg/m].
    pub mass_per_length_kg_m: f64,
    /// EA [N]; or a table.
    pub axial_stiffness_n: Option<f64>,
    /// Points (strain, force [N]) of a tensile test.
    pub force_strain: Option<Vec<[f64; 2]>>,
    /// Breaking load [N], for margins; absent: not told.
    pub breaking_load_n: Option<f64>,
}

/// `[structure.wing.rows.NAME]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RowTable {
    /// On the lower side, per chord; 1 is the trailing edge.
    pub position: f64,
    /// Ribs with attachments, counted from the middle.
    pub ribs: Vec<usize>,
    /// From the attachments down.
    pub levels: Vec<LevelTable>,
    /// Length of the riser [m].
    pub riser_length_m: f64,
    /// Its material.
    pub riser_material: String,
    /// Made longer by [m]; 0 if absent.
    pub trim_m: Option<f64>,
    /// Diagonals at the attachments; absent: none.
    pub diagonals: Option<DiagonalsTable>,
    /// How its risers are hauled in; absent: not at all.
    pub pull: Option<PullTable>,
}

/// `structure.wing.rows.NAME.pull`: how risers are hauled in.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PullTable {
    /// Length by which the riser is shortened [m].
    pub length_m: f64,
    /// Points (time [s], share of that length).
    pub table: Vec<[f64; 2]>,
    /// Of one half of the wing; absent: of both.
    pub half: Option<HalfName>,
}

/// Half of a wing, as the pilot sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HalfName {
    /// y < 0.
    Left,
    /// y > 0.
    Right,
}

/// An entry of `structure.wing.rows.NAME.levels`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelTable {
    /// Material of the lines.
    pub material: String,
    /// How many join at each node below; absent: all meet at the riser.
    pub joins: Option<Vec<usize>>,
    /// Where they join: share of the way from the riser up.
    pub height: Option<f64>,
}

/// `structure.wing.rows.NAME.diagonals`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiagonalsTable {
    /// Width at the attachment, per chord.
    pub foot: f64,
    /// Width at the upper seam, per chord.
    pub head: f64,
}

/// Side of a wing.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SideName {
    /// Upper side.
    Upper,
    /// Lower side.
    Lower,
}

/// `[structure.wing.tapes.NAME]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TapeTable {
    /// Side.
    pub side: SideName,
    /// Per chord.
    pub position: f64,
    /// On the panels, or straight from rib to rib.
    pub sewn: bool,
    /// Name of the material.
    pub material: String,
}

/// `[structure.wing.mesh]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WingMeshTable {
    /// Edges along each side of a rib.
    pub along_chord: usize,
    /// Edges across each cell; even.
    pub across_cell: usize,
}

/// `[equilibrium.wing_pressure]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WingPressureTable {
    /// q [Pa].
    pub dynamic_pressure_pa: f64,
    /// Coefficient inside all cells; or one per cell.
    pub inside: Option<f64>,
    /// From the left tip.
    pub inside_per_cell: Option<Vec<f64>>,
    /// Points (x/c, C) outside over the upper side.
    pub upper: Vec<[f64; 2]>,
    /// The same over the lower side.
    pub lower: Vec<[f64; 2]>,
    /// Points (distance from the middle over the half span, share of C outside); 1 everywhere if absent.
    pub along_span: Option<Vec<[f64; 2]>>,
}
