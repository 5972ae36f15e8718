//! What may be written in `[structure]`: one kind of structure, with its own table.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bodies::Rotation;
use super::canopy::{CanopyCommon, Folding};
use super::fabric::{CableMaterial, Fabric};
use super::wing::Wing;
use crate::geometry::mesh::doctor::Kind;
use crate::geometry::plate::Support;
use crate::geometry::sheet::FabricModel;

/// What hangs or flies; exactly one.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// A flat circular canopy.
    FlatCircular(FlatCircular),
    /// A conical canopy.
    Conical(Conical),
    /// A slotted canopy.
    Slotted(Slotted),
    /// An extended-skirt canopy.
    ExtendedSkirt(ExtendedSkirt),
    /// An annular canopy.
    Annular(Annular),
    /// A disk-gap-band canopy.
    DiskGapBand(DiskGapBand),
    /// A ringslot canopy.
    Ringslot(Ringslot),
    /// A cruciform canopy.
    Cruciform(Cruciform),
    /// A vertical sheet.
    Sheet(Sheet),
    /// A plate with bending stiffness.
    Plate(Plate),
    /// A hanging cable.
    Cable(HangingCable),
    /// A mesh from a file.
    Mesh(MeshFile),
    /// A wing from LEparagliding Studio.
    LepSim(LepSim),
    /// A square airbag.
    Airbag(Airbag),
    /// A clamped disc.
    Disc(Disc),
    /// A strip in a tensile test.
    Coupon(Coupon),
    /// A ram-air wing.
    Wing(Box<Wing>),
}

/// A canopy that is drawn in the case.
pub(in crate::case) struct DrawnCanopy<'a> {
    /// Name of its table.
    pub(in crate::case) name: &'static str,
    /// D_0, if it follows from the table [m].
    pub(in crate::case) diameter_m: Option<f64>,
    /// Where its lines meet.
    pub(in crate::case) confluence_m: &'a mut Option<[f64; 3]>,
}

impl Structure {
    /// True for a parachute canopy that is drawn in the case.
    #[must_use]
    pub const fn is_drawn_canopy(&self) -> bool {
        matches!(
            self,
            Self::FlatCircular(_)
                | Self::Conical(_)
                | Self::Slotted(_)
                | Self::ExtendedSkirt(_)
                | Self::Annular(_)
                | Self::DiskGapBand(_)
                | Self::Ringslot(_)
                | Self::Cruciform(_)
        )
    }

    /// True for a parachute canopy, drawn in the case or from a mesh with a nominal area.
    #[must_use]
    pub const fn is_canopy(&self) -> bool {
        self.is_drawn_canopy() || matches!(self, Self::Mesh(mesh) if mesh.nominal_area_m2.is_some())
    }

    /// What a canopy that is drawn in the case needs room for.
    pub(in crate::case) fn drawn_canopy(&mut self) -> Option<DrawnCanopy<'_>> {
        let (name, area_m2, confluence_m) = match self {
            Self::FlatCircular(t) => (
                "flat_circular",
                Some(t.nominal_area_m2),
                &mut t.confluence_m,
            ),
            Self::Conical(t) => ("conical", Some(t.nominal_area_m2), &mut t.confluence_m),
            Self::Slotted(t) => ("slotted", Some(t.nominal_area_m2), &mut t.confluence_m),
            Self::ExtendedSkirt(t) => (
                "extended_skirt",
                Some(t.nominal_area_m2),
                &mut t.confluence_m,
            ),
            Self::Annular(t) => ("annular", Some(t.nominal_area_m2), &mut t.confluence_m),
            Self::DiskGapBand(t) => {
                let of_diameter = t.nominal_diameter_m.map(|d| 0.25 * PI * d * d);
                let area_m2 = t.nominal_area_m2.or(of_diameter);
                ("disk_gap_band", area_m2, &mut t.confluence_m)
            }
            Self::Ringslot(t) => ("ringslot", Some(t.nominal_area_m2), &mut t.confluence_m),
            Self::Cruciform(t) => {
                let area_m2 = t.width_m * (2.0 * t.length_m - t.width_m);
                ("cruciform", Some(area_m2), &mut t.confluence_m)
            }
            _ => return None,
        };
        let diameter_m = area_m2
            .filter(|area| *area > 0.0)
            .map(|area| (4.0 * area / PI).sqrt());
        Some(DrawnCanopy {
            name,
            diameter_m,
            confluence_m,
        })
    }

    /// The wing, if it is one.
    #[must_use]
    pub fn wing(&self) -> Option<&Wing> {
        match self {
            Self::Wing(wing) => Some(wing),
            _ => None,
        }
    }

    /// Files that it is taken from, relative to the case.
    pub(super) fn named_files(&self) -> Vec<&str> {
        match self {
            Self::Mesh(mesh) => std::iter::once(mesh.file.as_str())
                .chain(mesh.start_file.as_deref())
                .chain(mesh.lines.as_deref())
                .chain(mesh.further.values().flat_map(|further| {
                    std::iter::once(further.file.as_str()).chain(further.start_file.as_deref())
                }))
                .collect(),
            Self::LepSim(wing) => vec![&wing.file],
            Self::Wing(wing) => (wing.profiles.values())
                .filter_map(|profile| profile.file.as_deref())
                .collect(),
            _ => Vec::new(),
        }
    }
}

/// A table of a canopy: what all have, and keys of its own.
macro_rules! canopy_table {
    ($(#[$about:meta])* $name:ident { $($(#[$meaning:meta])* $key:ident: $kind:ty),* $(,)? }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($(#[$meaning])* pub $key: $kind,)*
            /// Rings of triangles from vent or apex to the skirt; at least 12 for results.
            pub rings: usize,
            /// Where all lines meet [m]. It is held, unless it carries a payload. If absent the canopy stands in the middle of the tunnel's section.
            pub confluence_m: Option<[f64; 3]>,
            /// Stiffness of a lateral spring at the apex, or where vent lines cross [N/m]; absent: none.
            pub apex_guide_n_m: Option<f64>,
            /// How the canopy is folded at the start.
            pub folding: Folding,
        }

        impl $name {
            /// What all canopies have.
            pub(in crate::case) fn common(&self) -> CanopyCommon {
                CanopyCommon {
                    confluence_m: self.confluence_m,
                    apex_guide_n_m: self.apex_guide_n_m,
                    folding: self.folding.clone(),
                }
            }
        }
    };
}

canopy_table! {
    /// A circle of fabric; with a vent a polygon.
    FlatCircular {
        /// Nominal area S_0, vent included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
    }
}

canopy_table! {
    /// A cone of gores.
    Conical {
        /// Nominal area S_0, vent included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
        /// Rise of the gores' centre lines from the plane of the skirt, 0 to 60 [°].
        cone_angle_deg: f64,
    }
}

canopy_table! {
    /// A flat or conical canopy with slots along seams.
    Slotted {
        /// Nominal area S_0, vent and slots included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
        /// Rise of the gores' centre lines from the plane of the skirt, 0 to 60 [°]; 0 if absent.
        cone_angle_deg: Option<f64>,
        /// Number of slots, a divisor of `gores`.
        slots: usize,
        /// Width of a slot [m]; 0 for cuts along seams.
        slot_width_m: f64,
        /// Where slots begin, along the centre line from the constructed apex [m].
        slot_from_m: f64,
        /// Where slots end, along the centre line [m].
        slot_to_m: f64,
    }
}

canopy_table! {
    /// A flat circular part with a ring sewn to its edge.
    ExtendedSkirt {
        /// Nominal area S_0, vent included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m]; absent: no vent.
        vent_diameter_m: Option<f64>,
        /// Width of the ring over the diameter of the flat part, 0.01 to 0.5.
        extension_ratio: f64,
        /// Width of a gore at the skirt over that at the edge of the flat part, 0.5 to 1; 1 if absent.
        skirt_width_ratio: Option<f64>,
    }
}

canopy_table! {
    /// A ring of fabric. No lines run across its opening or to the edge of it, and there is no guide.
    Annular {
        /// Nominal area S_0 of the fabric alone [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the opening's area [m].
        opening_diameter_m: f64,
    }
}

canopy_table! {
    /// A disk, a gap and a band. What is absent has the proportions of the Viking type (docs/canopies.md). Exactly one of
    /// `nominal_area_m2` and `nominal_diameter_m`.
    DiskGapBand {
        /// Nominal area S_0 of disk, vent, gap and band [m²].
        nominal_area_m2: Option<f64>,
        /// Diameter D_0 of a circle of that area [m].
        nominal_diameter_m: Option<f64>,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m].
        vent_diameter_m: f64,
        /// Diameter of a circle of the disk's area [m]; 0.7224 D_0 if absent.
        disk_diameter_m: Option<f64>,
        /// Width of the gap [m]; 0.0432 D_0 if absent.
        gap_width_m: Option<f64>,
        /// Width of the band [m]; what the nominal area leaves if absent.
        band_width_m: Option<f64>,
    }
}

canopy_table! {
    /// Rings of fabric with slots between them, which run around the canopy. Rings and slots are alike; lines run on over the slots along the seams.
    Ringslot {
        /// Nominal area S_0, vent and slots included [m²].
        nominal_area_m2: f64,
        /// Number of gores, 3 to 200.
        gores: usize,
        /// Diameter of a circle of the vent's area [m].
        vent_diameter_m: f64,
        /// Number of slots, 1 to 50; there is one ring more.
        slots: usize,
        /// Width of a slot along the gores' centre lines [m], less than that of a ring.
        slot_width_m: f64,
        /// Tapes across every slot between two seams, 0 to 9, of the material of `[belts]`; 0 if absent. They begin and end at the nodes nearest to even distances, so that gores of few nodes have fewer. Without any, slots stretch.
        tapes_per_gore: Option<usize>,
    }
}

canopy_table! {
    /// Two crossed rectangles, one layer where they cross: S_0 = width · (2 length − width).
    Cruciform {
        /// Length of one whole rectangle [m].
        length_m: f64,
        /// Width of a rectangle [m].
        width_m: f64,
    }
}

/// Where a sheet is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SheetHold {
    /// At its two upper corners.
    UpperCorners,
    /// Along its upper edge.
    UpperEdge,
    /// Along both sides: a strip from side to side.
    Sides,
}

/// A vertical sheet.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Width and height [m].
    pub size_m: [f64; 2],
    /// Cells along width and height, 1 to 5000.
    pub divisions: [usize; 2],
    /// How its fabric is modelled.
    pub model: FabricModel,
    /// Upper left corner [m].
    pub corner_m: [f64; 3],
    /// Where it is held; at its upper corners if absent.
    pub held: Option<SheetHold>,
    /// Distance of the held corners or sides [m]: at most the width, between sides up to 1.2 times as much, which stretches a strip before it starts.
    pub hung_width_m: f64,
}

/// A rectangle of fabric with bending stiffness, held along one edge; its other edges are free. Pairs are along the length, from the held
/// edge to the free one, and across it. In air, markers stand inside all four edges, and the foot stands in the stream.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Length and width [m].
    pub size_m: [f64; 2],
    /// Cells along length and width.
    pub divisions: [usize; 2],
    /// Middle of the held edge [m].
    pub held_edge_m: [f64; 3],
    /// Direction of the length, the warp; of any length.
    pub along: [f64; 3],
    /// Direction of the held edge, at a right angle to it.
    pub across: [f64; 3],
    /// How the edge is held.
    pub support: Support,
    /// Bending stiffness D along the length [N m]; that of the fabric as a solid sheet, E h³/12(1 − ν²), if absent.
    pub flexural_rigidity_nm: Option<f64>,
}

/// A cable between two ends, which are held unless `[nodes.NAME]` frees them. Exactly one of `length_m` and `pretension_n`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HangingCable {
    /// Both ends [m].
    pub ends_m: [[f64; 3]; 2],
    /// Unstretched length, more than their distance [m].
    pub length_m: Option<f64>,
    /// Tension in which it starts, straight [N].
    pub pretension_n: Option<f64>,
    /// Straight pieces, 2 to 100000.
    pub segments: usize,
    /// What it is made of.
    pub material: CableMaterial,
}

/// Two square sheets joined along their edges, in the plane z = 0.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Airbag {
    /// Side of the flat bag [m].
    pub side_m: f64,
    /// Cells along a side; even.
    pub cells_per_side: usize,
}

/// A disc clamped at its rim, in the plane z = 0.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Radius [m].
    pub radius_m: f64,
    /// Rings of triangles.
    pub rings: usize,
}

/// A strip along x, clamped at both ends, of which one is pulled.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupon {
    /// Length between the clamps [m].
    pub length_m: f64,
    /// Width [m].
    pub width_m: f64,
    /// Cells over the width.
    pub cells_across: usize,
    /// Angle from the length to the warp [°].
    pub warp_angle_deg: f64,
    /// Way of the pulled clamp over the length.
    pub elongation: f64,
}

/// Triangles of an OBJ, STL or PLY file: the shape at rest. With `nominal_area_m2` a parachute canopy (docs/canopies.md).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// The mesh as it is sewn, relative to the case file.
    pub file: String,
    /// Metres per unit of the file.
    pub scale: f64,
    /// Numbers of held nodes, from 1 as in an OBJ file.
    pub held_nodes: Vec<u32>,
    /// Vertices nearer than this are joined, and seams with other vertices on either side are sewn [m]; 0 if absent (docs/meshes.md#joining-seams).
    pub weld_tolerance_m: Option<f64>,
    /// Turns triangles that run against their neighbours (docs/meshes.md#turning-triangles-alike); `false` if absent.
    #[serde(default)]
    pub orient_triangles: bool,
    /// Findings that are meant; others refuse the case (docs/meshes.md). None if absent.
    #[serde(default)]
    pub accept: Vec<Kind>,
    /// OBJ file with the same faces where they are at the start, such as a folded canopy; as sewn if absent. Edges may be 10 % longer than
    /// at rest, at most.
    pub start_file: Option<String>,
    /// Where the origin of the files is in the box of the air [m]; 0 if absent.
    pub position_m: Option<[f64; 3]>,
    /// Turns all that the files name about their origin, before it is moved.
    pub rotation: Option<Rotation>,
    /// Nominal area S_0 [m²]: makes it a parachute canopy, whose lines lead upstream (−x).
    pub nominal_area_m2: Option<f64>,
    /// Table of lines (CSV), with `line_material`; absent: none.
    pub lines: Option<String>,
    /// Material of `lines`; required with them.
    pub line_material: Option<CableMaterial>,
    /// Further meshes of the same structure, by name, not of canopies; absent: none. Springs (`[springs.NAME]`) join them, and supports by place.
    #[serde(default)]
    pub further: BTreeMap<String, FurtherMesh>,
}

/// One more mesh of a structure, with a fabric of its own or that of the case. What its keys mean is said of `[structure.mesh]`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FurtherMesh {
    /// The mesh as it is sewn, relative to the case file.
    pub file: String,
    /// Metres per unit of the file.
    pub scale: f64,
    /// Numbers of held nodes of this file, from 1.
    pub held_nodes: Vec<u32>,
    /// Vertices nearer than this are joined [m]; 0 if absent.
    pub weld_tolerance_m: Option<f64>,
    /// Turns triangles that run against their neighbours; `false` if absent.
    #[serde(default)]
    pub orient_triangles: bool,
    /// Findings that are meant. None if absent.
    #[serde(default)]
    pub accept: Vec<Kind>,
    /// OBJ file with the same faces where they are at the start; as sewn if absent.
    pub start_file: Option<String>,
    /// Where the origin of the files is [m]; 0 if absent.
    pub position_m: Option<[f64; 3]>,
    /// Turns all that the files name about their origin, before it is moved.
    pub rotation: Option<Rotation>,
    /// What it is made of; the fabric of the case if absent.
    pub fabric: Option<Fabric>,
}

impl FurtherMesh {
    /// The same as a table of the first mesh.
    pub(in crate::case) fn as_mesh(&self) -> MeshFile {
        MeshFile {
            file: self.file.clone(),
            scale: self.scale,
            held_nodes: self.held_nodes.clone(),
            weld_tolerance_m: self.weld_tolerance_m,
            orient_triangles: self.orient_triangles,
            accept: self.accept.clone(),
            start_file: self.start_file.clone(),
            position_m: self.position_m,
            rotation: self.rotation.clone(),
            nominal_area_m2: None,
            lines: None,
            line_material: None,
            further: BTreeMap::new(),
        }
    }
}

/// A wing that LEparagliding Studio has drawn, blown up by `equilibrium.pressure_pa` (docs/wing-design.md). Without air and motion.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LepSim {
    /// Its `lep-sim.json`, relative to the case file.
    pub file: String,
    /// What all its lines are made of.
    pub line_material: CableMaterial,
}
