//! Triangles that shut openings of a fabric, for schemes in which air passes these by a law instead of through cells.

use std::collections::HashMap;

use glam::DVec3;

use super::Structure;
use super::openings::Opening;

/// A triangle between the rims of an opening, turned as the fabric around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cover {
    /// Its nodes, all of the fabric.
    pub nodes: [u32; 3],
    /// A triangle of the fabric at each of them, and which of its corners that is.
    pub at: [(u32, u8); 3],
}

/// Triangles that shut each of these openings; `None` where its rim is not one loop or two, or fabric of two sides meets there.
#[must_use]
pub fn covers<'a>(
    structure: &Structure,
    openings: impl Iterator<Item = &'a Opening>,
) -> Vec<Option<Vec<Cover>>> {
    let borders = Borders::new(structure);
    let places = &structure.positions_m;
    let of = |opening: &Opening| {
        let triangles = match borders.loops(opening)?.as_slice() {
            [rim] => zigzag(rim, places),
            [one, other] => strip(one, other, places),
            _ => return None,
        };
        let cover = |nodes: [u32; 3]| Cover {
            nodes,
            at: nodes.map(|node| borders.at[&node]),
        };
        Some(triangles.into_iter().map(cover).collect())
    };
    openings.map(of).collect()
}

const fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// Edges of the fabric, each as its triangle runs along it; `None` of those that several have. And a corner of a triangle at every node.
struct Borders {
    edges: HashMap<[u32; 2], Option<[u32; 2]>>,
    at: HashMap<u32, (u32, u8)>,
}

impl Borders {
    fn new(structure: &Structure) -> Self {
        let mut edges = HashMap::new();
        let mut at = HashMap::new();
        for (number, triangle) in structure.triangles.iter().enumerate() {
            let [a, b, c] = triangle.nodes;
            for edge in [[a, b], [b, c], [c, a]] {
                (edges.entry(sorted(edge)))
                    .and_modify(|known| *known = None)
                    .or_insert(Some(edge));
            }
            for (corner, node) in triangle.nodes.into_iter().enumerate() {
                at.entry(node).or_insert((number as u32, corner as u8));
            }
        }
        Self { edges, at }
    }

    /// The rim as loops of nodes, against the turn of the fabric; none shorter than three nodes.
    fn loops(&self, opening: &Opening) -> Option<Vec<Vec<u32>>> {
        let mut next: HashMap<u32, u32> = HashMap::new();
        for edge in &opening.rim {
            let [to, from] = (*self.edges.get(&sorted(*edge))?)?;
            if next.insert(from, to).is_some() {
                return None;
            }
        }
        let mut starts: Vec<u32> = next.keys().copied().collect();
        starts.sort_unstable();
        let mut found = Vec::new();
        for start in starts {
            let mut nodes = Vec::new();
            let mut node = start;
            while let Some(after) = next.remove(&node) {
                nodes.push(node);
                node = after;
            }
            if nodes.is_empty() {
                continue;
            }
            if node != start || nodes.len() < 3 {
                return None;
            }
            found.push(nodes);
        }
        Some(found)
    }
}

/// Across one loop, from side to side: from that node on from which both sides lie closest together.
fn zigzag(rim: &[u32], places: &[DVec3]) -> Vec<[u32; 3]> {
    let count = rim.len();
    let at = |k: usize| rim[k % count];
    let apart = |start: usize| -> f64 {
        (1..count.div_ceil(2))
            .map(|k| {
                let [ahead, behind] = [at(start + k), at(start + count - k)];
                places[ahead as usize].distance_squared(places[behind as usize])
            })
            .sum()
    };
    let start = (0..count)
        .min_by(|a, b| apart(*a).total_cmp(&apart(*b)))
        .unwrap_or(0);
    let (mut ahead, mut behind) = (start + 1, start + count - 1);
    let mut triangles = vec![[at(behind), at(start), at(ahead)]];
    while ahead + 1 < behind {
        triangles.push([at(ahead), at(ahead + 1), at(behind)]);
        ahead += 1;
        if ahead + 1 < behind {
            triangles.push([at(behind - 1), at(behind), at(ahead)]);
            behind -= 1;
        }
    }
    triangles
}

/// Between two loops that run opposite ways around, from where they lie closest together.
fn strip(one: &[u32], other: &[u32], places: &[DVec3]) -> Vec<[u32; 3]> {
    let [n, m] = [one.len(), other.len()];
    let of_one = |k: usize| one[k % n];
    // Backwards, so that both run the same way.
    let of_other = |k: usize| other[(m - k % m) % m];
    let apart = |start: usize| -> f64 {
        (0..n)
            .map(|k| {
                let [a, b] = [of_one(k), of_other(start + k * m / n)];
                places[a as usize].distance_squared(places[b as usize])
            })
            .sum()
    };
    let start = (0..m)
        .min_by(|a, b| apart(*a).total_cmp(&apart(*b)))
        .unwrap_or(0);
    let mut triangles = Vec::with_capacity(n + m);
    let (mut i, mut j) = (0, 0);
    while i < n || j < m {
        let (a, b) = (of_one(i), of_other(start + j));
        if j >= m || (i < n && (i + 1) * m <= (j + 1) * n) {
            triangles.push([a, of_one(i + 1), b]);
            i += 1;
        } else {
            triangles.push([of_other(start + j + 1), b, a]);
            j += 1;
        }
    }
    triangles
}
