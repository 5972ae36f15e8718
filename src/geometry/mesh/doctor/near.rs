//! What lies together or passes through something else, found without looking at all pairs.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::cloth::contact::crossing::pierces;
use crate::cloth::contact::grid::{Extent, Grid};

/// Calls `found` with the numbers of all boxes of `first` and `second` that overlap, in an order that depends on the boxes alone.
///
/// A grid is as coarse as its largest box, so boxes are sorted into classes of size, each with a grid of its own.
fn overlaps(first: &[Extent], second: &[Extent], mut found: impl FnMut(usize, usize)) {
    let theirs = classes(second);
    for mine in classes(first).values() {
        let widest = widest(mine.iter().map(|&number| &first[number]));
        for others in theirs.values() {
            let boxes: Vec<Extent> = others.iter().map(|&number| second[number]).collect();
            let scale = widest.max(self::widest(boxes.iter()));
            // Some reach, so that boxes without extent have cells all the same.
            let reach = 1e-9 * scale.max(f64::MIN_POSITIVE);
            let grid = Grid::new(&boxes, reach, widest);
            for &number in mine {
                grid.near(&first[number], |other| found(number, others[other]));
            }
        }
    }
}

fn widest<'a>(boxes: impl Iterator<Item = &'a Extent>) -> f64 {
    boxes.map(Extent::longest_side).fold(0.0, f64::max)
}

/// Numbers of the boxes by size: sizes of a class are alike within a factor of four.
fn classes(boxes: &[Extent]) -> BTreeMap<i32, Vec<usize>> {
    let mut classes: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
    for (number, extent) in boxes.iter().enumerate() {
        let class = (0.5 * extent.longest_side().max(f64::MIN_POSITIVE).log2()).floor();
        classes.entry(class as i32).or_default().push(number);
    }
    classes
}

/// Calls `found` with every pair of places that are no farther apart than the smaller of their reaches [m], and with their distance [m];
/// the smaller number comes first.
pub(super) fn together(
    places_m: &[DVec3],
    reaches_m: &[f64],
    mut found: impl FnMut(usize, usize, f64),
) {
    let around = |(place, reach): (&DVec3, &f64)| {
        let half = DVec3::splat(0.5 * reach);
        Extent::around(&[*place - half, *place + half])
    };
    let boxes: Vec<Extent> = places_m.iter().zip(reaches_m).map(around).collect();
    overlaps(&boxes, &boxes, |a, b| {
        let apart_m = places_m[a].distance(places_m[b]);
        if a < b && apart_m <= reaches_m[a].min(reaches_m[b]) {
            found(a, b, apart_m);
        }
    });
}

/// Calls `found` with the numbers of every place and line that may be nearer than the reach of the line [m].
pub(super) fn beside(
    places_m: &[DVec3],
    lines_m: &[[DVec3; 2]],
    reaches_m: &[f64],
    found: impl FnMut(usize, usize),
) {
    let points: Vec<Extent> = places_m.iter().map(|p| Extent::around(&[*p])).collect();
    let around = |(ends, reach): (&[DVec3; 2], &f64)| {
        let reach = DVec3::splat(*reach);
        let [a, b] = *ends;
        Extent::around(&[a - reach, a + reach, b - reach, b + reach])
    };
    let lines: Vec<Extent> = lines_m.iter().zip(reaches_m).map(around).collect();
    overlaps(&points, &lines, found);
}

/// Every pair of triangles that lie in one plane and cover each other in part, by more than `depth_m`, in order; the smaller number comes first.
/// Left out are those without area and those on the same three places: `places` gives nodes that lie together one number.
pub(super) fn overlapping(
    positions_m: &[DVec3],
    triangles: &[[u32; 3]],
    places: &[u32],
    depth_m: f64,
) -> Vec<(usize, usize)> {
    let corners: Vec<[DVec3; 3]> = triangles
        .iter()
        .map(|nodes| nodes.map(|node| positions_m[node as usize]))
        .collect();
    let normals: Vec<DVec3> = corners
        .iter()
        .map(|[a, b, c]| (*b - *a).cross(*c - *a).normalize_or_zero())
        .collect();
    let boxes: Vec<Extent> = corners.iter().map(|c| Extent::around(c)).collect();
    let mut found = Vec::new();
    overlaps(&boxes, &boxes, |a, b| {
        // Cheap questions come first: nearly all pairs are neighbours.
        if a < b
            && normals[a].cross(normals[b]).length_squared() < 1e-4
            && [(a, b), (b, a)]
                .iter()
                .all(|&(a, b)| covers(corners[a], normals[a], corners[b], depth_m))
        {
            let key = |t: usize| {
                let mut key = triangles[t].map(|node| places[node as usize]);
                key.sort_unstable();
                key
            };
            if key(a) != key(b) {
                found.push((a, b));
            }
        }
    });
    found.sort_unstable();
    found
}

/// True if another triangle lies in the plane of the first and reaches over each of its sides by more than `depth_m`. Two triangles that do so
/// to each other have no line between them.
fn covers(corners: [DVec3; 3], normal: DVec3, other: [DVec3; 3], depth_m: f64) -> bool {
    let is_in_plane = || {
        let heights = other.map(|place| (place - corners[0]).dot(normal));
        heights.iter().all(|height| height.abs() <= depth_m)
    };
    let reaches = |k: usize| {
        let [a, b] = [corners[k], corners[(k + 1) % 3]];
        let inward = normal.cross(b - a).normalize_or_zero();
        other.iter().any(|place| (*place - a).dot(inward) > depth_m)
    };
    normal != DVec3::ZERO && (0..3).all(reaches) && is_in_plane()
}

/// Every edge that passes through a triangle by more than `depth_m`, as (number of the edge, number of the triangle), in order.
/// Left out are those that meet at a place: `places` gives nodes that lie together one number.
pub(super) fn crossings(
    positions_m: &[DVec3],
    edges: &[[u32; 2]],
    triangles: &[[u32; 3]],
    places: &[u32],
    depth_m: f64,
) -> Vec<(usize, usize)> {
    let at = |node: u32| positions_m[node as usize];
    let lines: Vec<Extent> = edges
        .iter()
        .map(|nodes| Extent::around(&nodes.map(at)))
        .collect();
    let faces: Vec<Extent> = triangles
        .iter()
        .map(|nodes| Extent::around(&nodes.map(at)))
        .collect();
    let mut found = Vec::new();
    overlaps(&lines, &faces, |edge, triangle| {
        let (ends, nodes) = (edges[edge], triangles[triangle]);
        let place = |node: u32| places[node as usize];
        let meet = ends
            .iter()
            .any(|end| nodes.iter().any(|node| place(*node) == place(*end)));
        let (ends, corners) = (ends.map(at), nodes.map(at));
        if !meet && pierces(ends, corners) && is_deep(ends, corners, depth_m) {
            found.push((edge, triangle));
        }
    });
    found.sort_unstable();
    found
}

/// True if both ends are farther from the triangle's plane than `depth_m`: what only touches lies on either side by round-off.
fn is_deep(ends: [DVec3; 2], [a, b, c]: [DVec3; 3], depth_m: f64) -> bool {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    ends.iter()
        .all(|end| (*end - a).dot(normal).abs() > depth_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all pairs one by one, with sizes that differ by a factor of a thousand.
    #[test]
    fn pairs_are_those_of_a_search_through_all() {
        let mut seed = 7u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut places = Vec::new();
        let mut reaches = Vec::new();
        for number in 0..400 {
            let size = 10f64.powi(-(number % 4));
            places.push(DVec3::new(random(), random(), random()) * size);
            reaches.push(0.8 * size * random().abs());
        }
        let mut found = Vec::new();
        together(&places, &reaches, |a, b, _| found.push([a, b]));
        found.sort_unstable();
        let mut expected = Vec::new();
        for b in 0..places.len() {
            for a in 0..b {
                if places[a].distance(places[b]) <= reaches[a].min(reaches[b]) {
                    expected.push([a, b]);
                }
            }
        }
        expected.sort_unstable();
        assert!(expected.len() > 100, "{}", expected.len());
        assert_eq!(found, expected);

        let triangles: Vec<[u32; 3]> = (0..130).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let edges: Vec<[u32; 2]> = (0..199).map(|e| [e, e + 200]).collect();
        let own: Vec<u32> = (0..400).collect();
        let found = crossings(&places, &edges, &triangles, &own, 0.0);
        let mut expected = Vec::new();
        for (edge, ends) in edges.iter().enumerate() {
            for (triangle, nodes) in triangles.iter().enumerate() {
                let apart = ends.iter().all(|end| !nodes.contains(end));
                let at = |node: u32| places[node as usize];
                if apart && pierces(ends.map(at), nodes.map(at)) {
                    expected.push((edge, triangle));
                }
            }
        }
        assert!(expected.len() > 5, "{}", expected.len());
        assert_eq!(found, expected);
    }
}
