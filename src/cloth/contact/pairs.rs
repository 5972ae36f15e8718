//! Which nodes and triangles, and which edges, are close enough to matter.
//!
//! Left out are pairs that share a node: they touch by being sewn together, and their distance is zero wherever they are. All others are
//! farther apart in the rest shape than the thickness, which [`super::check`] sees to: two fabrics of which one is bent round a single
//! row of triangles are meant to push each other. Pairs that start closer than the thickness (pleats near an apex, slots, wrinkled
//! starts) push only when they come closer than they were then, so that no start is under stress.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::distance::{edge_edge, node_triangle};
use super::grid::{Extent, Grid};
use crate::cloth::Structure;

/// What a pair is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A node and the three of a triangle.
    NodeTriangle,
    /// Two nodes of one edge and two of another.
    EdgeEdge,
}

/// Two pieces of fabric that may push each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// What it is made of.
    pub kind: Kind,
    /// Nodes of the first side, then of the second.
    pub nodes: [u32; 4],
    /// Distance below which the two push each other [m].
    pub thickness_m: f64,
    /// Edges whose cross product is below the root of this count as nearly parallel [m⁴].
    pub parallel_m4: f64,
}

/// Share of the product of squared rest lengths below which the squared cross product of edges is small (Li et al. 2020).
const PARALLEL: f64 = 1e-3;

impl Pair {
    /// Where its nodes are.
    #[inline]
    #[must_use]
    pub fn places(&self, positions: &[DVec3]) -> [DVec3; 4] {
        self.nodes.map(|node| positions[node as usize])
    }

    /// Distance of its sides, whose nodes are at `places` [m].
    #[inline]
    #[must_use]
    pub fn gap_m(&self, places: &[DVec3; 4]) -> f64 {
        match self.kind {
            Kind::NodeTriangle => node_triangle(places).gap_m(),
            Kind::EdgeEdge => edge_edge(places).gap_m(),
        }
    }

    /// Which nodes belong to either side.
    #[must_use]
    pub const fn sides(&self) -> [std::ops::Range<usize>; 2] {
        match self.kind {
            Kind::NodeTriangle => [0..1, 1..4],
            Kind::EdgeEdge => [0..2, 2..4],
        }
    }
}

/// Nodes, edges and triangles of a fabric that meets itself.
#[derive(Debug, Clone)]
pub struct Surface {
    /// Nodes of triangles, ascending.
    pub nodes: Vec<u32>,
    /// Edges with their squared rest lengths [m²]; the smaller node first, ascending.
    pub edges: Vec<([u32; 2], f64)>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    thickness_m: f64,
    /// Pairs that start closer than the thickness, with their distance [m].
    close_at_start: HashMap<(Kind, [u32; 4]), f64>,
}

/// Items that one task searches for.
const AT_ONCE: usize = 256;

/// Up to so many items one thread is faster.
const ALONE: usize = 1024;

/// What `of` finds for the numbers below `count`, in order.
fn collect(count: usize, of: impl Fn(usize, &mut Vec<Pair>) + Sync + Send) -> Vec<Pair> {
    let part = |chunk: usize| {
        let mut found = Vec::new();
        for number in chunk * AT_ONCE..((chunk + 1) * AT_ONCE).min(count) {
            of(number, &mut found);
        }
        found
    };
    let chunks = 0..count.div_ceil(AT_ONCE);
    if count <= ALONE {
        chunks.flat_map(part).collect()
    } else {
        let parts: Vec<Vec<Pair>> = chunks.into_par_iter().map(part).collect();
        parts.concat()
    }
}

impl Surface {
    /// The fabric of a structure with this contact thickness [m].
    #[must_use]
    pub fn new(structure: &Structure, thickness_m: f64) -> Self {
        let triangles: Vec<[u32; 3]> = structure.triangles.iter().map(|t| t.nodes).collect();
        let mut nodes = triangles.as_flattened().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        let mut edges: Vec<([u32; 2], f64)> = Vec::with_capacity(3 * triangles.len());
        for triangle in &structure.triangles {
            for (i, [from, to]) in crate::cloth::elements::EDGES.into_iter().enumerate() {
                let (a, b) = (triangle.nodes[from], triangle.nodes[to]);
                edges.push(([a.min(b), a.max(b)], triangle.rest_squares_m2[i]));
            }
        }
        edges.sort_unstable_by_key(|(nodes, _)| *nodes);
        edges.dedup_by_key(|(nodes, _)| *nodes);
        let mut surface = Self {
            nodes,
            edges,
            triangles,
            thickness_m,
            close_at_start: HashMap::new(),
        };
        let close = surface.search(&structure.positions_m, thickness_m);
        surface.close_at_start = close
            .into_iter()
            .map(|pair| {
                let gap = pair.gap_m(&pair.places(&structure.positions_m));
                ((pair.kind, pair.nodes), gap)
            })
            .collect();
        surface
    }

    /// Mean rest length of the edges [m]; zero without any.
    #[must_use]
    pub fn mean_edge_m(&self) -> f64 {
        let sum: f64 = self.edges.iter().map(|(_, square)| square.sqrt()).sum();
        sum / (self.edges.len().max(1)) as f64
    }

    /// Smallest thickness of any pair [m].
    #[must_use]
    pub fn least_thickness_m(&self) -> f64 {
        let starts = self.close_at_start.values().copied();
        starts.fold(self.thickness_m, f64::min)
    }

    fn pair(&self, kind: Kind, nodes: [u32; 4], parallel_m4: f64) -> Pair {
        let thickness_m = if self.close_at_start.is_empty() {
            self.thickness_m
        } else {
            let own = self.close_at_start.get(&(kind, nodes));
            own.copied().unwrap_or(self.thickness_m)
        };
        Pair {
            kind,
            nodes,
            thickness_m,
            parallel_m4,
        }
    }

    /// All pairs at most `reach` apart [m], in an order that depends on nothing but the positions.
    #[must_use]
    pub fn search(&self, positions: &[DVec3], reach: f64) -> Vec<Pair> {
        let place = |node: u32| positions[node as usize];
        let largest =
            |extents: &[Extent]| extents.iter().map(Extent::longest_side).fold(0.0, f64::max);
        let extents: Vec<Extent> = self
            .triangles
            .iter()
            .map(|nodes| Extent::around(&nodes.map(place)))
            .collect();
        let grid = Grid::new(&extents, reach, 0.0);
        let mut pairs = collect(self.nodes.len(), |number, found| {
            let node = self.nodes[number];
            grid.near(&Extent::around(&[place(node)]), |triangle| {
                let [a, b, c] = self.triangles[triangle];
                if a == node || b == node || c == node {
                    return;
                }
                let pair = self.pair(Kind::NodeTriangle, [node, a, b, c], 0.0);
                if pair.gap_m(&pair.places(positions)) <= reach {
                    found.push(pair);
                }
            });
        });
        let extents: Vec<Extent> = self
            .edges
            .iter()
            .map(|(nodes, _)| Extent::around(&nodes.map(place)))
            .collect();
        let grid = Grid::new(&extents, reach, largest(&extents));
        pairs.extend(collect(self.edges.len(), |number, found| {
            let ([a, b], square) = self.edges[number];
            grid.near(&extents[number], |other| {
                let ([c, d], other_square) = self.edges[other];
                if other <= number || a == c || a == d || b == c || b == d {
                    return;
                }
                let parallel_m4 = PARALLEL * square * other_square;
                let pair = self.pair(Kind::EdgeEdge, [a, b, c, d], parallel_m4);
                if pair.gap_m(&pair.places(positions)) <= reach {
                    found.push(pair);
                }
            });
        }));
        pairs
    }

    /// The pair that is nearest now among those at most `reach` apart, with its distance [m].
    #[must_use]
    pub fn nearest(&self, positions: &[DVec3], reach: f64) -> Option<(Pair, f64)> {
        self.search(positions, reach)
            .into_iter()
            .map(|pair| (pair, pair.gap_m(&pair.places(positions))))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
