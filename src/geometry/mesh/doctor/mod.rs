//! What a mesh of others is made of, and what in it would change a run without a word.
//!
//! [`examine`] looks at triangles alone: pieces, open borders, area and size are told of each mesh; what is hardly ever meant is a [`Finding`].
//! [`weld()`] joins vertices that lie together, [`orient()`] turns triangles alike, [`mouth()`] tells where an opening faces. Lengths are in metres; what counts as "together" or "touching" is a share of the mesh's own
//! edges, so that nothing depends on the unit of a file.

mod doubled;
mod findings;
pub mod mouth;
mod near;
pub mod orient;
pub mod seams;
mod topology;
pub mod weld;

use glam::DVec3;

use crate::rigid::Surface;
pub use mouth::{Mouth, mouth};
pub use orient::{NoSides, orient};
use topology::{Edges, Sets};
pub use weld::{TooWide, Welded, weld};

/// Distance below which vertices lie together, as a share of the median edge.
const TOGETHER: f64 = 0.01;

/// The same, as a share of the shortest edge at either vertex.
const TOGETHER_AT_VERTEX: f64 = 0.1;

/// Distance below which borders with other vertices count as a seam, as a share of the edge that vertices lie at: as far as the chords of a
/// quarter of a circle in five lie off it.
const SEAM: f64 = 0.05;

/// The same, as a share of the shortest edge at a vertex.
const SEAM_AT_VERTEX: f64 = 0.25;

/// How far an edge must pass through a triangle, as a share of the median edge; what is nearer only touches.
const CROSSING_DEPTH: f64 = 1e-4;

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

/// Lengths of all edges [m], each once; what begins and ends at one node is left out.
fn edge_lengths_m(surface: &Surface) -> Vec<f64> {
    let place = |node: u32| surface.positions_m[node as usize];
    Edges::new(&surface.triangles, |_| true)
        .iter()
        .map(|uses| {
            let [a, b] = uses[0].nodes.map(place);
            a.distance(b)
        })
        .collect()
}

/// The value in the middle; 0 without any.
fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// What all examinations of one mesh share.
struct Common {
    /// Places at rest, from the lowest corner of the box [m].
    places_m: Vec<DVec3>,
    areas_m2: Vec<f64>,
    median_edge_m: f64,
    /// Shortest edge at each node [m].
    shortest_m: Vec<f64>,
    /// Distance below which each node lies together with another [m].
    reaches_m: Vec<f64>,
    /// Smallest node of those that lie together.
    together: Vec<u32>,
    /// Triangles without those that name the same nodes as an earlier one.
    edges: Edges,
    borders: Vec<[u32; 2]>,
}

impl Common {
    fn new(surface: &Surface) -> Self {
        let (low, _) = surface.bounds_m();
        let places_m: Vec<DVec3> = surface.positions_m.iter().map(|p| *p - low).collect();
        let median_edge_m = median(edge_lengths_m(surface));
        let mut shortest_m = vec![f64::INFINITY; places_m.len()];
        for &[a, b, c] in &surface.triangles {
            for [a, b] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(|n| n as usize)) {
                let length_m = places_m[a].distance(places_m[b]);
                shortest_m[a] = shortest_m[a].min(length_m);
                shortest_m[b] = shortest_m[b].min(length_m);
            }
        }
        let reach_m = |edge_m: &f64| (TOGETHER * median_edge_m).min(TOGETHER_AT_VERTEX * edge_m);
        let reaches_m: Vec<f64> = shortest_m.iter().map(reach_m).collect();
        let mut sets = Sets::new(places_m.len());
        near::together(&places_m, &reaches_m, |a, b, _| {
            sets.join(a as u32, b as u32);
        });
        let is_repeated = repeated(&surface.triangles);
        let edges = Edges::new(&surface.triangles, |number| !is_repeated[number]);
        Self {
            areas_m2: surface.area_vectors_m2().map(DVec3::length).collect(),
            median_edge_m,
            shortest_m,
            reaches_m,
            together: sets.into_firsts(),
            borders: edges.borders(),
            edges,
            places_m,
        }
    }
}

/// True for triangles with the same three nodes as an earlier one.
fn repeated(triangles: &[[u32; 3]]) -> Vec<bool> {
    let mut keys: Vec<([u32; 3], usize)> = triangles
        .iter()
        .enumerate()
        .map(|(number, nodes)| {
            let mut nodes = *nodes;
            nodes.sort_unstable();
            (nodes, number)
        })
        .collect();
    keys.sort_unstable();
    let mut is_repeated = vec![false; triangles.len()];
    for pair in keys.windows(2) {
        is_repeated[pair[1].1] = pair[0].0 == pair[1].0;
    }
    is_repeated
}

/// Examines a mesh with finite places; the time grows with the number of triangles, not with its square.
#[must_use]
pub fn examine(subject: &Subject) -> Examination {
    let surface = subject.surface;
    let common = Common::new(surface);
    let (low, high) = surface.bounds_m();
    let borders = topology::chains(&common.borders);
    let mut borders: Vec<Border> = borders
        .into_iter()
        .map(|nodes| Border {
            length_m: nodes
                .windows(2)
                .map(|pair| {
                    let [a, b] = [pair[0], pair[1]].map(|n| common.places_m[n as usize]);
                    a.distance(b)
                })
                .sum(),
            nodes,
        })
        .collect();
    borders.sort_by(|a, b| b.length_m.total_cmp(&a.length_m));
    let mut examination = Examination {
        node_count: surface.positions_m.len(),
        triangle_count: surface.triangles.len(),
        pieces: pieces(subject, &common),
        borders,
        area_m2: common.areas_m2.iter().sum(),
        size_m: high - low,
        findings: Vec::new(),
    };
    examination.findings = findings::all(subject, &common, &examination);
    examination
}

fn pieces(subject: &Subject, common: &Common) -> Vec<Piece> {
    let node_count = subject.surface.positions_m.len();
    let mut sets = Sets::new(node_count);
    for &[a, b, c] in &subject.surface.triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let mut numbers = vec![usize::MAX; node_count];
    let mut pieces: Vec<Piece> = Vec::new();
    for (triangle, nodes) in subject.surface.triangles.iter().enumerate() {
        let first = sets.first(nodes[0]) as usize;
        if numbers[first] == usize::MAX {
            numbers[first] = pieces.len();
            pieces.push(Piece {
                nodes: 0,
                triangles: Vec::new(),
                area_m2: 0.0,
                is_anchored: false,
            });
        }
        let piece = &mut pieces[numbers[first]];
        piece.triangles.push(triangle as u32);
        piece.area_m2 += common.areas_m2[triangle];
    }
    for node in 0..node_count {
        let number = numbers[sets.first(node as u32) as usize];
        if let Some(piece) = pieces.get_mut(number) {
            piece.nodes += 1;
            piece.is_anchored |= match subject.used_as {
                Use::Fabric { anchored, .. } => anchored[node],
                Use::RigidBody => true,
            };
        }
    }
    pieces.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
    pieces
}

#[cfg(test)]
mod tests;
