//! Turning triangles alike.

use glam::DVec3;

use super::topology::{Edges, repeated, turned};
use crate::rigid::Surface;

/// Why triangles cannot be turned alike; each with the nodes of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoSides {
    /// More than two triangles meet there, so that not one is the neighbour of another.
    NonManifold([u32; 2]),
    /// The surface has one side only, as a Möbius strip.
    OneSided([u32; 2]),
}

/// Turns the triangles of each connected piece the way in which most of its area runs; returns how many were turned.
///
/// # Errors
///
/// [`NoSides`] where more than two triangles meet at an edge, or no turning helps; nothing is turned then.
pub fn orient(surface: &mut Surface) -> Result<usize, NoSides> {
    let is_repeated = repeated(&surface.triangles);
    let edges = Edges::new(&surface.triangles, |number| !is_repeated[number]);
    if let Some(uses) = edges.iter().find(|uses| uses.len() > 2) {
        return Err(NoSides::NonManifold(uses[0].nodes));
    }
    let areas_m2: Vec<f64> = surface.area_vectors_m2().map(DVec3::length).collect();
    let turned = turned(&edges, &areas_m2);
    if let Some(edge) = turned.edges.first() {
        return Err(NoSides::OneSided(*edge));
    }
    for number in &turned.triangles {
        surface.triangles[*number as usize].swap(1, 2);
    }
    Ok(turned.triangles.len())
}
