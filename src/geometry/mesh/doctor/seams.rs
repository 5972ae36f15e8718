//! Seams whose vertices do not match: borders of fabric that run along each other with other vertices on either side (hanging nodes).
//!
//! They are sewn by splitting triangles: a vertex of one side becomes a corner of the triangles at the edge of the other that it lies on. No
//! vertex is made and none moves, so numbers stay those of the file, and areas change by no more than vertices lie off the edges.

use glam::DVec3;

use super::near;
use super::topology::Edges;
use crate::rigid::Surface;

/// A vertex that lies on a border edge of which it is no end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hanging {
    /// The vertex.
    pub vertex: u32,
    /// Ends of the edge, the smaller number first.
    pub edge: [u32; 2],
    /// Way from the first end to where the vertex lies, over the length of the edge.
    pub share: f64,
    /// Distance from the edge [m].
    pub apart_m: f64,
}

/// Every vertex of an open border that lies within reach of another border edge, away from its ends, where both borders run along each other. In
/// the order of edges, and along each.
///
/// `reach_m` gives the distance that counts for an edge and a vertex, `end_reach_m` the least one at the edge's ends; `places_m` should begin
/// near the origin.
pub(super) fn hanging(
    places_m: &[DVec3],
    triangles: &[[u32; 3]],
    edges: &Edges,
    largest_reach_m: impl Fn([u32; 2]) -> f64,
    reach_m: impl Fn([u32; 2], u32) -> f64,
    end_reach_m: f64,
) -> Vec<Hanging> {
    let at = |node: u32| places_m[node as usize];
    let borders: Vec<([u32; 2], u32)> = edges
        .iter()
        .filter(|uses| uses.len() == 1)
        .map(|uses| (uses[0].nodes, uses[0].triangle))
        .collect();
    // Ends of the border edges at each vertex of a border.
    let mut around: Vec<[u32; 2]> = borders
        .iter()
        .flat_map(|(nodes, _)| [*nodes, [nodes[1], nodes[0]]])
        .collect();
    around.sort_unstable();
    let mut vertices: Vec<u32> = around.iter().map(|pair| pair[0]).collect();
    vertices.dedup();
    let points: Vec<DVec3> = vertices.iter().map(|vertex| at(*vertex)).collect();
    let lines: Vec<[DVec3; 2]> = borders.iter().map(|(nodes, _)| nodes.map(at)).collect();
    let reaches: Vec<f64> = borders.iter().map(|(n, _)| largest_reach_m(*n)).collect();
    let mut found: Vec<Hanging> = Vec::new();
    near::beside(&points, &lines, &reaches, |point, line| {
        let (vertex, (edge, triangle)) = (vertices[point], borders[line]);
        if triangles[triangle as usize].contains(&vertex) {
            return;
        }
        let reach = reach_m(edge, vertex);
        let [a, b] = edge.map(at);
        let (share, apart_m) = beside(points[point], [a, b]);
        let is_at_end = [a, b]
            .iter()
            .any(|end| end.distance(points[point]) <= reach.max(end_reach_m));
        if is_at_end || apart_m > reach || !(0.0..=1.0).contains(&share) {
            return;
        }
        let from = around.partition_point(|pair| pair[0] < vertex);
        let next = around[from..].iter().take_while(|pair| pair[0] == vertex);
        let mut next = next.map(|pair| at(pair[1]));
        if next.any(|other| run_along([a, b], [points[point], other], reach)) {
            found.push(Hanging {
                vertex,
                edge,
                share,
                apart_m,
            });
        }
    });
    found.sort_by(|a, b| {
        let order = a.edge.cmp(&b.edge).then(a.share.total_cmp(&b.share));
        order.then(a.vertex.cmp(&b.vertex))
    });
    found
}

/// Where along a line a place lies, and how far from it [m].
fn beside(place: DVec3, [a, b]: [DVec3; 2]) -> (f64, f64) {
    let along = b - a;
    let share = (place - a).dot(along) / along.length_squared();
    (share, place.distance(a + share * along))
}

/// True if an edge from a place on a line goes on beside it, for longer than the reach, and no farther from it.
fn run_along(line: [DVec3; 2], [from, to]: [DVec3; 2], reach_m: f64) -> bool {
    let length_m = line[0].distance(line[1]);
    let (begin, _) = beside(from, line);
    let (end, apart_m) = beside(to, line);
    let last = end.clamp(0.0, 1.0);
    let apart_m = if last == end {
        apart_m
    } else {
        beside(line[usize::from(end > 1.0)], [from, to]).1
    };
    (last - begin).abs() * length_m > reach_m && apart_m <= reach_m
}

/// A mesh with the vertices of its seams inserted into the edges of the other side.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sewn {
    pub triangles: Vec<[u32; 3]>,
    /// Number in the file of the triangle that each one is a part of, from 0. `[triangle_count]`
    pub numbers: Vec<u32>,
    /// What was inserted.
    pub inserted: Vec<Hanging>,
}

impl Sewn {
    /// Shortest part that is left of an edge [m].
    pub fn shortest_part_m(&self, places_m: &[DVec3]) -> f64 {
        let at = |node: u32| places_m[node as usize];
        let of_edge = self.inserted.chunk_by(|a, b| a.edge == b.edge);
        let parts = of_edge.flat_map(|hanging| {
            let [a, b] = hanging[0].edge;
            let inside = hanging.iter().map(|h| h.vertex);
            let nodes: Vec<u32> = std::iter::once(a).chain(inside).chain([b]).collect();
            let lengths = nodes
                .windows(2)
                .map(|pair| at(pair[0]).distance(at(pair[1])));
            lengths.collect::<Vec<f64>>()
        });
        parts.fold(f64::INFINITY, f64::min)
    }
}

/// Splits triangles at open borders where vertices of others lie within the tolerance. What lies nearer than `end_reach_m` to a vertex of the
/// other side belongs to that: it is left to be joined by a wider tolerance, and no sliver is made of it.
pub(super) fn sew(
    places_m: &[DVec3],
    surface: &Surface,
    edges: &Edges,
    tolerance_m: f64,
    end_reach_m: f64,
) -> Sewn {
    let mut inserted = hanging(
        places_m,
        &surface.triangles,
        edges,
        |_| tolerance_m,
        |_, _| tolerance_m,
        end_reach_m,
    );
    // Of those that will be one, the first is enough.
    inserted.dedup_by(|later, kept| {
        let [a, b] = [&later, &kept].map(|hanging| places_m[hanging.vertex as usize]);
        later.edge == kept.edge && a.distance(b) <= tolerance_m
    });
    let on = |a: u32, b: u32| {
        let edge = [a.min(b), a.max(b)];
        let from = inserted.partition_point(|hanging| hanging.edge < edge);
        let of_edge = inserted[from..].iter().take_while(|h| h.edge == edge);
        let mut vertices: Vec<u32> = of_edge.map(|hanging| hanging.vertex).collect();
        if a > b {
            vertices.reverse();
        }
        vertices
    };
    let mut sewn = Sewn {
        triangles: Vec::with_capacity(surface.triangles.len()),
        numbers: Vec::with_capacity(surface.triangles.len()),
        inserted: Vec::new(),
    };
    let mut is_touched = vec![false; surface.positions_m.len()];
    for node in inserted.iter().flat_map(|hanging| hanging.edge) {
        is_touched[node as usize] = true;
    }
    for (number, &[a, b, c]) in surface.triangles.iter().enumerate() {
        let touched = [a, b, c].map(|node| usize::from(is_touched[node as usize]));
        if touched.iter().sum::<usize>() < 2 {
            sewn.triangles.push([a, b, c]);
        } else {
            split(
                [a, b, c],
                [on(a, b), on(b, c), on(c, a)],
                &mut sewn.triangles,
            );
        }
        sewn.numbers.resize(sewn.triangles.len(), number as u32);
    }
    sewn.inserted = inserted;
    sewn
}

/// Splits a triangle at the vertices on its three sides, which come in the order in which the triangle runs.
fn split([a, b, c]: [u32; 3], on: [Vec<u32>; 3], triangles: &mut Vec<[u32; 3]>) {
    let [on_ab, on_bc, on_ca] = on;
    if on_ab.is_empty() {
        if on_bc.is_empty() && on_ca.is_empty() {
            triangles.push([a, b, c]);
        } else {
            split([b, c, a], [on_bc, on_ca, on_ab], triangles);
        }
        return;
    }
    let (mut on_bc, mut on_ca) = (Some(on_bc), Some(on_ca));
    let mut from = a;
    for &to in on_ab.iter().chain([&b]) {
        // The side c to a is that of the first part, b to c that of the last.
        let first = on_ca.take().unwrap_or_default();
        let last = if to == b { on_bc.take() } else { None };
        let sides = [Vec::new(), last.unwrap_or_default(), first];
        split([from, to, c], sides, triangles);
        from = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertices on two sides at once, or on all three: the parts fill the triangle and run as it does.
    #[test]
    fn parts_fill_a_triangle() {
        let corners = [DVec3::ZERO, DVec3::X * 6.0, DVec3::Y * 6.0];
        let mut places = corners.to_vec();
        places.extend([
            DVec3::X * 2.0,
            DVec3::X * 4.0,
            DVec3::new(3.0, 3.0, 0.0),
            DVec3::Y * 5.0,
            DVec3::Y * 1.0,
        ]);
        for sides in [
            [vec![3, 4], vec![], vec![]],
            [vec![], vec![5], vec![6, 7]],
            [vec![3, 4], vec![5], vec![6, 7]],
        ] {
            let count = 1 + sides.iter().map(Vec::len).sum::<usize>();
            let mut triangles = Vec::new();
            split([0, 1, 2], sides, &mut triangles);
            assert_eq!(triangles.len(), count);
            let area = |[a, b, c]: [u32; 3]| {
                let [a, b, c] = [a, b, c].map(|n| places[n as usize]);
                0.5 * (b - a).cross(c - a).z
            };
            assert!(triangles.iter().all(|t| area(*t) > 0.1), "{triangles:?}");
            let sum: f64 = triangles.iter().map(|t| area(*t)).sum();
            assert!((sum - 18.0).abs() < 1e-12);
        }
    }
}
