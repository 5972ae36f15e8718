//! Distances from the rims of fabric, along the fabric as it was cut (at rest), so that markers can stand a little inside them.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use super::{Structure, elements::EDGES};
use crate::immersed::markers;

/// How far inside the rims of a structure markers stand.
#[derive(Debug, Clone, PartialEq)]
pub struct RimInsets {
    /// Rims in general [m].
    pub rim_m: f64,
    /// Rims of the structure's openings [m], `[opening_count]`.
    pub openings_m: Vec<f64>,
}

impl RimInsets {
    /// Markers up to the rims.
    pub const NONE: Self = Self {
        rim_m: 0.0,
        openings_m: Vec::new(),
    };

    /// `rim_cells` inside rims, and more inside those of narrow openings (see [`markers::opening_inset_cells`]), in proportion.
    #[must_use]
    pub fn new(structure: &Structure, rim_cells: f64, cell_size_m: f64) -> Self {
        let rim_m = rim_cells * cell_size_m;
        let of = |width_m: f64| {
            rim_m * markers::opening_inset_cells(width_m / cell_size_m) / markers::RIM_INSET_CELLS
        };
        Self {
            rim_m,
            openings_m: structure.openings.iter().map(|o| of(o.width_m)).collect(),
        }
    }
}

impl Structure {
    /// Rest sizes of the triangles, and how far inside the line on which markers end they lie where that matters.
    pub fn extents(&self, insets: &RimInsets) -> impl Iterator<Item = markers::Extent> {
        let depths = (insets.rim_m > 0.0).then(|| depths_m(self, insets));
        self.triangles
            .iter()
            .enumerate()
            .map(move |(i, t)| markers::Extent {
                area_m2: t.rest_area_m2,
                longest_edge_m: t.rest_squares_m2.iter().copied().fold(0.0, f64::max).sqrt(),
                rim_depths_m: depths.as_ref().map_or([f64::INFINITY; 3], |d| d[i]),
            })
    }
}

/// How far every triangle's corners lie inside the line on which markers end [m], `[triangle_count]`; negative outside. Exact along straight rims, somewhat
/// short where fronts of two rims meet in long triangles, infinite where it cannot matter, or without
/// rims. A rim is made of the edges that one triangle alone has.
#[must_use]
pub fn depths_m(structure: &Structure, insets: &RimInsets) -> Vec<[f64; 3]> {
    let mut starts: HashMap<u32, f64> = HashMap::new();
    let mut start = |node: u32, inset_m: f64| {
        let depth = starts.entry(node).or_insert(-inset_m);
        *depth = depth.min(-inset_m);
    };
    for node in rim_edges(structure).into_iter().flatten() {
        start(node, insets.rim_m);
    }
    for (opening, inset_m) in structure.openings.iter().zip(&insets.openings_m) {
        for node in opening.rim.iter().flatten() {
            start(*node, *inset_m);
        }
    }
    let mut nodes = vec![f64::INFINITY; structure.node_count()];
    let mut queue = BinaryHeap::new();
    for (node, depth_m) in starts {
        nodes[node as usize] = depth_m;
        queue.push(Front { depth_m, node });
    }
    let around = triangles_around(structure);
    while let Some(Front { depth_m, node }) = queue.pop() {
        if depth_m > nodes[node as usize] || depth_m > 0.0 {
            continue;
        }
        for &triangle in around.of(node) {
            let triangle = &structure.triangles[triangle as usize];
            for (k, other) in triangle.nodes.into_iter().enumerate() {
                if other == node {
                    continue;
                }
                let known = triangle.nodes.map(|n| nodes[n as usize]);
                let arrival = arrival_m(k, known, triangle.rest_squares_m2);
                if arrival < nodes[other as usize] {
                    nodes[other as usize] = arrival;
                    queue.push(Front {
                        depth_m: arrival,
                        node: other,
                    });
                }
            }
        }
    }
    structure
        .triangles
        .iter()
        .map(|triangle| triangle.nodes.map(|node| nodes[node as usize]))
        .collect()
}

/// Edges that one triangle alone has, in its sense of rotation.
#[must_use]
pub fn rim_edges(structure: &Structure) -> Vec<[u32; 2]> {
    let mut counts: HashMap<[u32; 2], u32> = HashMap::new();
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let edges = || {
        structure
            .triangles
            .iter()
            .flat_map(|t| EDGES.map(|[from, to]| [t.nodes[from], t.nodes[to]]))
    };
    for edge in edges() {
        *counts.entry(sorted(edge)).or_default() += 1;
    }
    edges().filter(|edge| counts[&sorted(*edge)] == 1).collect()
}

/// A node that the front from the rims has reached; the nearest is the greatest.
#[derive(Debug, PartialEq)]
struct Front {
    depth_m: f64,
    node: u32,
}

impl Eq for Front {}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        (other.depth_m.total_cmp(&self.depth_m)).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// When a front of unit speed reaches corner `k` of a triangle through the other two, whose times are known: as a straight front across the
/// triangle where it comes through it, along an edge otherwise (fast marching; Kimmel & Sethian 1998, doi:10.1073/pnas.95.15.8431).
fn arrival_m(k: usize, known_m: [f64; 3], squares_m2: [f64; 3]) -> f64 {
    let [i, j] = EDGES[k];
    let (ti, tj) = (known_m[i], known_m[j]);
    // Edge k lies opposite corner k.
    let (to_i, to_j, base) = (squares_m2[j], squares_m2[i], squares_m2[k]);
    let along_edges = (ti + to_i.sqrt()).min(tj + to_j.sqrt());
    if !(ti.is_finite() && tj.is_finite()) {
        return along_edges;
    }
    // Corner i at the origin, j on the x axis, k above it.
    let length = base.sqrt();
    let x = 0.5 * (to_i - to_j + base) / length;
    let y = (to_i - x * x).max(0.0).sqrt();
    let slope = (tj - ti) / length;
    let Some(across) = Some(1.0 - slope * slope).filter(|rest| *rest >= 0.0) else {
        return along_edges;
    };
    let across = across.sqrt();
    // The ray that ends in k crosses the base between its ends.
    let foot = if across > 0.0 {
        x - y * slope / across
    } else {
        f64::INFINITY
    };
    if (0.0..=length).contains(&foot) {
        ti + slope * x + across * y
    } else {
        along_edges
    }
}

/// Triangles around every node.
struct Around {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn of(&self, node: u32) -> &[u32] {
        let [from, to] = [node, node + 1].map(|n| self.starts[n as usize] as usize);
        &self.triangles[from..to]
    }
}

fn triangles_around(structure: &Structure) -> Around {
    let mut starts = vec![0u32; structure.node_count() + 1];
    for triangle in &structure.triangles {
        for node in triangle.nodes {
            starts[node as usize + 1] += 1;
        }
    }
    for node in 0..structure.node_count() {
        starts[node + 1] += starts[node];
    }
    let mut next = starts.clone();
    let mut triangles = vec![0; 3 * structure.triangles.len()];
    for (index, triangle) in structure.triangles.iter().enumerate() {
        for node in triangle.nodes {
            triangles[next[node as usize] as usize] = index as u32;
            next[node as usize] += 1;
        }
    }
    Around { starts, triangles }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::cloth::openings::{Opening, OpeningKind};
    use crate::fabric::Fabric;
    use crate::geometry::sheet::{self, FabricModel, SheetShape};

    fn sheet(size_m: [f64; 2], divisions: [usize; 2]) -> Structure {
        let shape = SheetShape {
            size_m,
            divisions,
            corner_m: DVec3::ZERO,
            across: DVec3::X,
            down: DVec3::Y,
        };
        let fabric = Fabric {
            thickness_m: 1e-4,
            density_kg_m3: 500.0,
            warp_modulus_pa: 4e8,
            weft_modulus_pa: 4e8,
            poisson_ratio: 0.14,
            shear_modulus_pa: 1.8e8,
            cubic_shear_compliance_1_pa3: None,
            residual_stiffness: 1e-3,
            initial_strain: [0.0; 2],
            yield_stress_pa: None,
        };
        sheet::build(&shape, &fabric, FabricModel::Membrane).unwrap()
    }

    fn distances(structure: &Structure, reach_m: f64) -> Vec<[f64; 3]> {
        let insets = RimInsets {
            rim_m: reach_m,
            openings_m: Vec::new(),
        };
        let depths = depths_m(structure, &insets);
        let from_rim = |corners: [f64; 3]| corners.map(|depth| depth + reach_m);
        depths.into_iter().map(from_rim).collect()
    }

    /// On a rectangle with cells of any shape the distance is that to the nearest side, less where the fronts of two sides meet.
    #[test]
    fn distances_on_a_rectangle_are_those_from_its_sides() {
        for divisions in [[10, 8], [4, 20], [3, 3]] {
            let size = [1.0, 0.8];
            let structure = sheet(size, divisions);
            assert_eq!(
                rim_edges(&structure).len(),
                2 * (divisions[0] + divisions[1])
            );
            let distances = distances(&structure, 10.0);
            for (triangle, distances) in structure.triangles.iter().zip(&distances) {
                for (node, distance) in triangle.nodes.into_iter().zip(distances) {
                    let p = structure.positions_m[node as usize];
                    let mut sides = [p.x, size[0] - p.x, p.y, size[1] - p.y];
                    sides.sort_by(f64::total_cmp);
                    let [exact, next, ..] = sides;
                    let longest =
                        (size[0] / divisions[0] as f64).max(size[1] / divisions[1] as f64);
                    // Near the line where fronts from two sides meet, they cut its corners.
                    let least = if next > exact + 2.0 * longest {
                        exact
                    } else {
                        0.7 * exact
                    };
                    assert!(
                        (least - 1e-12..=exact + 1e-12).contains(distance),
                        "{p}: {distance} {exact}"
                    );
                }
            }
        }
    }

    /// Beyond the reach nothing is known, within it all.
    #[test]
    fn distances_end_at_their_reach() {
        let structure = sheet([1.0, 1.0], [20, 20]);
        let all = distances(&structure, 10.0);
        let distances = distances(&structure, 0.12);
        for (near, exact) in distances.iter().flatten().zip(all.iter().flatten()) {
            if *exact <= 0.12 - 1e-9 {
                assert!((near - exact).abs() < 1e-12);
            } else {
                assert!(near + 1e-12 >= *exact);
            }
        }
        assert!(distances.iter().flatten().any(|d| d.is_infinite()));
    }

    /// The rim of an opening has an inset of its own, wider the narrower it is; a cut and a wide one have that of other rims.
    #[test]
    fn narrow_openings_have_wider_insets() {
        let mut structure = sheet([1.0, 1.0], [10, 10]);
        let side: Vec<[u32; 2]> = rim_edges(&structure)
            .into_iter()
            .filter(|edge| {
                edge.iter()
                    .all(|&n| structure.positions_m[n as usize].x == 0.0)
            })
            .collect();
        assert_eq!(side.len(), 10);
        let cell = 0.1;
        for (width_cells, expected) in [(0.0, 0.065), (1.0, 0.091), (2.0, 0.073), (8.0, 0.065)] {
            structure.openings = vec![Opening {
                kind: OpeningKind::Slot,
                width_m: width_cells * cell,
                rim: side.clone(),
            }];
            let insets = RimInsets::new(&structure, markers::RIM_INSET_CELLS, cell);
            let depths = depths_m(&structure, &insets);
            for (triangle, depths) in structure.triangles.iter().zip(&depths) {
                for (node, depth) in triangle.nodes.into_iter().zip(depths) {
                    let p = structure.positions_m[node as usize];
                    // Half way up, only the two sides matter.
                    if (0.35..0.65).contains(&p.y) && depth.is_finite() {
                        let exact = (p.x - expected).min(1.0 - p.x - 0.065);
                        assert!((depth - exact).abs() < 1e-12, "{width_cells}: {p} {depth}");
                    }
                }
            }
        }
        assert_eq!(RimInsets::new(&structure, 0.0, cell).openings_m, [0.0]);
    }
}
