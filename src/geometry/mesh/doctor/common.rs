//! What all examinations of one mesh share: distances, areas, edges, and what counts as together.

use glam::DVec3;

use super::near;
use super::topology::{Edges, repeated};
use crate::rigid::Surface;
use crate::sets::Sets;

/// Distance below which vertices lie together, as a share of the median edge.
pub(super) const TOGETHER: f64 = 0.01;

/// The same, as a share of the shortest edge at either vertex.
pub(super) const TOGETHER_AT_VERTEX: f64 = 0.1;

/// How far an edge must pass through a triangle, as a share of the median edge; what is nearer only touches.
pub(super) const CROSSING_DEPTH: f64 = 1e-4;

/// Lengths of all edges [m], each once; what begins and ends at one node is left out.
pub(super) fn edge_lengths_m(surface: &Surface) -> Vec<f64> {
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
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// What all examinations of one mesh share.
pub(super) struct Common {
    /// Places at rest, from the lowest corner of the box [m].
    pub(super) places_m: Vec<DVec3>,
    pub(super) areas_m2: Vec<f64>,
    pub(super) median_edge_m: f64,
    /// Shortest edge at each node [m].
    pub(super) shortest_m: Vec<f64>,
    /// Distance below which each node lies together with another [m].
    pub(super) reaches_m: Vec<f64>,
    /// Smallest node of those that lie together.
    pub(super) together: Vec<u32>,
    /// Triangles without those that name the same nodes as an earlier one.
    pub(super) edges: Edges,
    pub(super) borders: Vec<[u32; 2]>,
}

impl Common {
    pub(super) fn new(surface: &Surface) -> Self {
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
