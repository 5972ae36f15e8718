//! What may be written in `[mesh]`: a mesh in a stream by a few lines, from which all other tables follow.

use schemars::JsonSchema;
use serde::Deserialize;

use super::bodies::Rotation;
use super::design::Quality;
use crate::geometry::mesh::doctor::Kind;

/// A mesh from a file in a wind: all other tables follow from it, and may be written to change what follows (docs/design.md). The wind comes along
/// +x.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshDesign {
    /// What the mesh is.
    #[serde(rename = "type")]
    pub kind: MeshType,
    /// OBJ, STL or PLY file, relative to the case file: a canopy or sheet as it is sewn.
    pub file: String,
    /// Metres per unit of the file; 1 if absent.
    pub scale: Option<f64>,
    /// Turns all that the files name about their origin; absent: not at all.
    pub rotation: Option<Rotation>,
    /// OBJ file with the same faces where they are at the start, such as a folded canopy; as sewn if absent. Not of a rigid body.
    pub start_file: Option<String>,
    /// Speed of the wind [m/s].
    pub speed_m_s: Option<f64>,
    /// `speed_m_s` in another unit [km/h].
    pub speed_km_h: Option<f64>,
    /// `speed_m_s` in another unit [ft/s].
    pub speed_ft_s: Option<f64>,
    /// `speed_m_s` in another unit [kt].
    pub speed_kt: Option<f64>,
    /// Altitude whose standard atmosphere is taken, −500 to 11000 [m]; 0 if absent.
    pub altitude_m: Option<f64>,
    /// `altitude_m` in another unit [ft].
    pub altitude_ft: Option<f64>,
    /// Table of suspension lines in metres (CSV, docs/canopies.md), relative to the case file: required of a canopy, and of nothing else.
    pub line_table: Option<String>,
    /// Suspension lines by their name (docs/design.md); a nylon cord by the diameter, as of a drawn canopy, if absent.
    pub lines: Option<String>,
    /// Cloth by its name (docs/design.md); `"ripstop 40 g/m²"` if absent. Not of a rigid body.
    pub fabric: Option<String>,
    /// Numbers of held nodes, from 1 as in an OBJ file: required of a sheet.
    pub held_nodes: Option<Vec<u32>>,
    /// Area that coefficients refer to [m²]; of a canopy the area of its fabric, of a rigid body its frontal area if absent. Not of a sheet.
    pub reference_area_m2: Option<f64>,
    /// Vertices nearer than this are joined [m]; 0 if absent (docs/meshes.md#joining-seams).
    pub weld_tolerance_m: Option<f64>,
    /// Turns triangles that run against their neighbours (docs/meshes.md#turning-triangles-alike); `false` if absent.
    pub orient_triangles: Option<bool>,
    /// Findings that are meant; others refuse the case (docs/meshes.md). None if absent.
    pub accept: Option<Vec<Kind>>,
    /// Cells over the length, and how well the mean drag is to be known; `"normal"` if absent. `--quality` on the command line.
    pub quality: Option<Quality>,
}

/// What a mesh is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeshType {
    /// Fabric on lines that lead upstream (−x), to where they are held.
    Canopy,
    /// Fabric some of whose nodes are held.
    Sheet,
    /// A body that keeps its shape and is held.
    Rigid,
}
