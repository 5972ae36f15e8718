//! Joining vertices that lie together, such as those of seams that were exported piece by piece.

use std::collections::BTreeSet;

use glam::DVec3;

use super::common::{TOGETHER, edge_lengths_m, median};
use super::near;
use super::seams::{self, Hanging};
use super::topology::Edges;
use crate::rigid::Surface;
use crate::sets::Sets;

/// Largest tolerance, as a share of the median edge.
pub const LARGEST_SHARE: f64 = 0.1;

/// Least length of edges that remain where vertices are joined, in their distance, and of parts of sewn edges, in tolerances.
const SHORTEST_REMAINING: f64 = 4.0;

/// Farthest that a vertex may be from where it comes to lie, in tolerances.
const LONGEST_CHAIN: f64 = 2.0;

/// A mesh with its vertices joined, and what became of those of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Welded {
    /// The mesh.
    pub surface: Surface,
    /// Node of each vertex of the file; `None` for those of which no triangle is left.
    pub nodes: Vec<Option<u32>>,
    /// Number of each node in the file, from 0: the smallest of those joined. `[node_count]`
    pub numbers: Vec<u32>,
    /// Number of each triangle in the file, from 0. `[triangle_count]`
    pub triangle_numbers: Vec<u32>,
    /// Vertices of seams that were inserted into edges of the other side, by numbers of the file.
    pub inserted: Vec<Hanging>,
    /// Vertices that were joined to others.
    pub joined: usize,
    /// Triangles that collapsed and were dropped.
    pub collapsed: usize,
}

/// Why a tolerance would eat into the mesh.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TooWide {
    /// It is no longer small against the mesh.
    #[error("half of the edges are shorter than {median_m:.3e} m, of which it may be a tenth")]
    Median {
        /// Median edge [m].
        median_m: f64,
    },
    /// Edges that remain would be about as short.
    #[error(
        "along what it joins there is an edge of {edge_m:.3e} m, which it would neither keep nor join"
    )]
    Edge {
        /// That edge [m].
        edge_m: f64,
    },
    /// Vertices would be joined one by one over a longer way.
    #[error("vertices {apart_m:.3e} m apart would be joined through others between them")]
    Chain {
        /// Distance of two vertices that would be one [m].
        apart_m: f64,
    },
}

impl TooWide {
    /// Largest tolerance that would do [m], as far as it is known.
    #[must_use]
    pub fn largest_m(self) -> Option<f64> {
        match self {
            Self::Median { median_m } => Some(LARGEST_SHARE * median_m),
            Self::Edge { edge_m } => Some(edge_m / SHORTEST_REMAINING),
            Self::Chain { .. } => None,
        }
    }
}

impl Welded {
    /// The mesh as it is.
    #[must_use]
    pub fn untouched(surface: Surface) -> Self {
        let nodes = surface.positions_m.len() as u32;
        Self {
            nodes: (0..nodes).map(Some).collect(),
            numbers: (0..nodes).collect(),
            triangle_numbers: (0..surface.triangles.len() as u32).collect(),
            inserted: Vec::new(),
            joined: 0,
            collapsed: 0,
            surface,
        }
    }

    /// Places of the nodes in another shape of the same file [m], and the vertices that are farthest from the node they were joined to,
    /// with their distance [m]; `None` if all lie at their nodes.
    #[must_use]
    pub fn carried_over(&self, places_m: &[DVec3]) -> (Vec<DVec3>, Option<([u32; 2], f64)>) {
        let carried: Vec<DVec3> = self
            .numbers
            .iter()
            .map(|number| places_m[*number as usize])
            .collect();
        let farthest = self
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(vertex, node)| {
                let node = (*node)? as usize;
                let apart_m = places_m[vertex].distance(carried[node]);
                Some(([self.numbers[node], vertex as u32], apart_m))
            })
            .filter(|(_, apart_m)| *apart_m > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        (carried, farthest)
    }
}

/// Sews seams whose vertices do not match, and joins vertices that are at most `tolerance_m` apart, of which one lies on an open border or
/// both on one edge; each takes the place of the vertex with the smallest number. Fabric that lies upon fabric away from its borders stays apart.
///
/// # Errors
///
/// [`TooWide`] where the median edge would be shorter than ten tolerances, edges at a vertex that is joined than four times its way, parts of a
/// sewn edge than four tolerances, or where a vertex would move by more than two.
pub fn weld(surface: &Surface, tolerance_m: f64) -> Result<Welded, TooWide> {
    let lengths_m = edge_lengths_m(surface);
    let median_m = median(lengths_m);
    if tolerance_m > LARGEST_SHARE * median_m {
        return Err(TooWide::Median { median_m });
    }
    let (low, _) = surface.bounds_m();
    let places_m: Vec<DVec3> = surface.positions_m.iter().map(|p| *p - low).collect();
    let edges = Edges::new(&surface.triangles, |_| true);
    let shortest_m = shortest_remaining_m(&places_m, surface, tolerance_m);
    let together_m = TOGETHER * median_m;
    let sewn = seams::sew(&places_m, surface, &edges, tolerance_m, together_m);
    let shortest_part_m = sewn.shortest_part_m(&places_m);
    if shortest_part_m < SHORTEST_REMAINING * tolerance_m {
        return Err(TooWide::Edge {
            edge_m: shortest_part_m,
        });
    }
    let mut on_border = vec![false; places_m.len()];
    let mut is_edge = BTreeSet::new();
    for uses in edges.iter() {
        let [a, b] = uses[0].nodes.map(|node| node as usize);
        if uses.len() == 1 {
            on_border[a] = true;
            on_border[b] = true;
        }
        if places_m[a].distance(places_m[b]) <= tolerance_m {
            is_edge.insert([a, b]);
        }
    }
    let mut sets = Sets::new(places_m.len());
    let mut short_m = f64::INFINITY;
    near::together(
        &places_m,
        &vec![tolerance_m; places_m.len()],
        |a, b, apart_m| {
            if on_border[a] || on_border[b] || is_edge.contains(&[a, b]) {
                let edge_m = shortest_m[a].min(shortest_m[b]);
                if SHORTEST_REMAINING * apart_m > edge_m {
                    short_m = short_m.min(edge_m);
                }
                sets.join(a as u32, b as u32);
            }
        },
    );
    if short_m < f64::INFINITY {
        return Err(TooWide::Edge { edge_m: short_m });
    }
    let firsts = sets.into_firsts();
    let apart = firsts.iter().zip(&places_m);
    let apart_m = apart
        .map(|(first, place)| place.distance(places_m[*first as usize]))
        .fold(0.0, f64::max);
    if apart_m > LONGEST_CHAIN * tolerance_m {
        return Err(TooWide::Chain { apart_m });
    }
    let surface = Surface {
        positions_m: surface.positions_m.clone(),
        triangles: sewn.triangles,
    };
    let mut welded = renumbered(&surface, &firsts);
    for number in &mut welded.triangle_numbers {
        *number = sewn.numbers[*number as usize];
    }
    welded.inserted = sewn.inserted;
    Ok(welded)
}

/// Shortest edge at each vertex that is longer than the tolerance [m].
fn shortest_remaining_m(places_m: &[DVec3], surface: &Surface, tolerance_m: f64) -> Vec<f64> {
    let mut shortest_m = vec![f64::INFINITY; places_m.len()];
    for &[a, b, c] in &surface.triangles {
        for [a, b] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(|n| n as usize)) {
            let length_m = places_m[a].distance(places_m[b]);
            if length_m > tolerance_m {
                shortest_m[a] = shortest_m[a].min(length_m);
                shortest_m[b] = shortest_m[b].min(length_m);
            }
        }
    }
    shortest_m
}

/// The mesh with one node for each set, without collapsed triangles and what they alone used.
fn renumbered(surface: &Surface, firsts: &[u32]) -> Welded {
    let mut triangles = Vec::new();
    let mut triangle_numbers = Vec::new();
    let mut is_used = vec![false; firsts.len()];
    for (number, nodes) in surface.triangles.iter().enumerate() {
        let [a, b, c] = nodes.map(|node| firsts[node as usize]);
        if a != b && b != c && c != a {
            triangles.push([a, b, c]);
            triangle_numbers.push(number as u32);
            for node in [a, b, c] {
                is_used[node as usize] = true;
            }
        }
    }
    let mut node_of = vec![None; firsts.len()];
    let mut numbers: Vec<u32> = Vec::new();
    for (vertex, _) in is_used.iter().enumerate().filter(|(_, used)| **used) {
        node_of[vertex] = Some(numbers.len() as u32);
        numbers.push(vertex as u32);
    }
    let joined = (0..firsts.len()).filter(|&v| firsts[v] as usize != v);
    let place = |number: &u32| surface.positions_m[*number as usize];
    Welded {
        inserted: Vec::new(),
        joined: joined.count(),
        collapsed: surface.triangles.len() - triangles.len(),
        surface: Surface {
            positions_m: numbers.iter().map(place).collect(),
            triangles: triangles
                .iter()
                .map(|nodes| nodes.map(|node| node_of[node as usize].unwrap_or(0)))
                .collect(),
        },
        nodes: firsts
            .iter()
            .map(|first| node_of[*first as usize])
            .collect(),
        numbers,
        triangle_numbers,
    }
}
