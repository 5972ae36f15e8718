//! The part of a case file that describes a plate of fabric.

use serde::Deserialize;

use crate::geometry::plate::Support;

/// `[structure.plate]`: a rectangle of fabric with bending stiffness, held along one edge. Pairs are along the length, from the held edge to
/// the free one, and across it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Length and width [m].
    pub size_m: [f64; 2],
    /// Cells along length and width.
    pub divisions: [usize; 2],
    /// Middle of the held edge [m].
    pub held_edge_m: [f64; 3],
    /// Direction of the length.
    pub along: [f64; 3],
    /// Direction of the held edge.
    pub across: [f64; 3],
    /// How the edge is held.
    pub support: Support,
    /// Flexural rigidity of bending along the length [N m]; that of a solid sheet if absent.
    pub flexural_rigidity_nm: Option<f64>,
}
