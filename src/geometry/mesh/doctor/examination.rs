//! What is examined, and what is told of it.

use glam::DVec3;

use crate::rigid::Surface;

/// Kinds of findings, in the order in which they are told: what mends the first often settles those after it.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Vertices that lie on others along open borders: a seam that is not sewn.
    DoubledVertices,
    /// Vertices that lie on border edges of others: a seam that is not sewn, and whose vertices do not match.
    HangingNodes,
    /// Triangles that lie on others, corner on corner.
    DoubledFaces,
    /// Triangles that cover others in part, in one plane.
    OverlappingFaces,
    /// Edges of more than two triangles.
    NonManifoldEdges,
    /// Triangles that run against their neighbours.
    Orientation,
    /// Edges that pass through triangles.
    SelfCrossing,
    /// Several pieces without a common node, all of them held.
    Pieces,
    /// Pieces that neither a held node nor a line keeps from flying off.
    LoosePieces,
    /// Openings of a body that is all but closed.
    Holes,
    /// A size that no canopy or body has, or another one than the case says.
    Size,
}

impl Kind {
    /// Name in case files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::DoubledVertices => "doubled_vertices",
            Self::HangingNodes => "hanging_nodes",
            Self::DoubledFaces => "doubled_faces",
            Self::OverlappingFaces => "overlapping_faces",
            Self::NonManifoldEdges => "non_manifold_edges",
            Self::Orientation => "orientation",
            Self::SelfCrossing => "self_crossing",
            Self::Pieces => "pieces",
            Self::LoosePieces => "loose_pieces",
            Self::Holes => "holes",
            Self::Size => "size",
        }
    }
}

/// What a mesh is examined for, beside its triangles.
#[derive(Debug, Clone, Copy)]
pub enum Use<'a> {
    /// Fabric.
    Fabric {
        /// Nodes that are held or have a line, `[node_count]`.
        anchored: &'a [bool],
        /// S₀, where the case gives it [m²].
        nominal_area_m2: Option<f64>,
    },
    /// The surface of a rigid body.
    RigidBody,
}

/// A mesh to be examined.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// Nodes and triangles, at rest.
    pub surface: &'a Surface,
    /// Where the nodes are at the start [m], `[node_count]`.
    pub start_m: &'a [DVec3],
    /// Numbers of nodes and of triangles in the file, from 0; `None` where the file has none.
    pub numbers: Option<(&'a [u32], &'a [u32])>,
    /// What it is for.
    pub used_as: Use<'a>,
    /// Size of a cell of the air, where the case gives it [m].
    pub cell_size_m: Option<f64>,
}

/// What belongs to a finding, by numbers of nodes and triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Marks {
    /// Nodes.
    pub nodes: Vec<u32>,
    /// Edges.
    pub edges: Vec<[u32; 2]>,
    /// Triangles.
    pub triangles: Vec<u32>,
}

/// Something that is hardly ever meant.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What it is.
    pub kind: Kind,
    /// How many there are.
    pub count: usize,
    /// How many of what, and where the first is, in the coordinates of the file times its scale.
    pub what: String,
    /// What to do.
    pub remedy: String,
    /// What belongs to it.
    pub marks: Marks,
    /// True if it is one of the shape at the start, false if of that at rest.
    pub is_at_start: bool,
}

/// Triangles that share nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Nodes.
    pub nodes: usize,
    /// Triangles, by number.
    pub triangles: Vec<u32>,
    /// Area [m²].
    pub area_m2: f64,
    /// True if one of its nodes is held or has a line.
    pub is_anchored: bool,
}

/// A line of edges with one triangle each.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// Its nodes; the first again at the end of a closed one.
    pub nodes: Vec<u32>,
    /// Its length [m].
    pub length_m: f64,
}

/// What a mesh is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Examination {
    /// Nodes.
    pub node_count: usize,
    /// Triangles.
    pub triangle_count: usize,
    /// Pieces, the largest first.
    pub pieces: Vec<Piece>,
    /// Open borders, the longest first.
    pub borders: Vec<Border>,
    /// Area of all triangles [m²].
    pub area_m2: f64,
    /// Sides of the box around the mesh [m].
    pub size_m: DVec3,
    /// What is hardly ever meant, in the order of [`Kind`].
    pub findings: Vec<Finding>,
}
