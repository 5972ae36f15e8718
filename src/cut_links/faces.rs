//! Fields on the nodes of a sheet, from what its cut links see: the pressure on both of its faces.

use glam::DVec3;
use rayon::prelude::*;

use super::bounce::{Return, SIDES};
use super::by_triangle::CutsByTriangle;
use super::search::CutLink;
use crate::lattice::WEIGHTS;

/// Share of a step that a face's pressure takes of what its links see: sound and single cells pass, the opening of a pleat stays.
const NEW_SHARE: f64 = 0.3;

/// Steps of carrying on to nodes without links, in every step of the air.
const CARRIED: usize = 3;

/// Triangles that one task works on.
const TRIANGLES_AT_ONCE: usize = 128;

/// Nodes that a face of the sheet joins.
#[derive(Debug, Clone, Default)]
pub struct Neighbours {
    starts: Vec<u32>,
    nodes: Vec<u32>,
}

impl Neighbours {
    /// Of a surface of so many nodes; a neighbour at two triangles counts twice.
    #[must_use]
    pub fn new(triangles: &[[u32; 3]], count: usize) -> Self {
        let mut starts = vec![0_u32; count + 1];
        for node in triangles.iter().flatten() {
            starts[*node as usize + 1] += 2;
        }
        for node in 0..count {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut nodes = vec![0; 6 * triangles.len()];
        for triangle in triangles {
            for k in 0..3 {
                for other in [triangle[(k + 1) % 3], triangle[(k + 2) % 3]] {
                    let place = &mut next[triangle[k] as usize];
                    nodes[*place as usize] = other;
                    *place += 1;
                }
            }
        }
        Self { starts, nodes }
    }

    /// Those of a node.
    #[must_use]
    pub fn of(&self, node: usize) -> &[u32] {
        &self.nodes[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}

/// What a side of a link is seen from.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// Nodes of all triangles.
    pub triangles: &'a [[u32; 3]],
    /// Unit normals of the triangles.
    pub normals: &'a [DVec3],
    /// The links.
    pub links: &'a [CutLink],
    /// What comes back along them.
    pub returns: &'a [[Return; 2]],
}

impl Seen<'_> {
    /// Face of the triangle that a side of a link looks at: 0 where its normal points, 1 behind.
    fn face(&self, link: &CutLink, side: usize) -> usize {
        let normal = self.normals[link.cuts[side].triangle as usize];
        face(normal, link, side)
    }
}

/// Face that a side of a link looks at, of a triangle with this normal: 0 where it points, 1 behind.
#[must_use]
pub fn face(normal: DVec3, link: &CutLink, side: usize) -> usize {
    let towards = normal.dot(link.direction()) > 0.0;
    usize::from(towards == (side == 0))
}

/// Density excess of the air on both faces of every node: kept where a face has links, carried on along the sheet where it has none, inside folds.
#[derive(Debug, Clone)]
pub struct FacePressures {
    neighbours: Neighbours,
    excess: Vec<[f64; 2]>,
    sums: Vec<[f64; 2]>,
    weights: Vec<[f64; 2]>,
    /// Nodes that are taken, and the triangles around them; `None`: all.
    nodes: Vec<u32>,
    triangles: Option<Vec<u32>>,
}

impl FacePressures {
    /// Faces of a surface of so many nodes, in air at rest.
    #[must_use]
    pub fn new(triangles: &[[u32; 3]], count: usize) -> Self {
        Self {
            neighbours: Neighbours::new(triangles, count),
            excess: vec![[0.0; 2]; count],
            sums: vec![[0.0; 2]; count],
            weights: vec![[0.0; 2]; count],
            nodes: (0..count as u32).collect(),
            triangles: None,
        }
    }

    /// Keeps to the nodes that decide what stands between two layers, as long as the surface, its links sorted by triangle, does not move: those about the `doubled` links, and from each that has
    /// no links on a face on to its neighbours. What was taken last tells which have. The pressures at others stay as they are.
    pub fn narrow(&mut self, seen: &Seen<'_>, cuts: &CutsByTriangle, doubled: &[u32]) {
        let of_triangle = |triangle: u32| seen.triangles[triangle as usize];
        let mut next: Vec<u32> = (doubled.iter())
            .flat_map(|link| seen.links[*link as usize].cuts)
            .flat_map(|cut| of_triangle(cut.triangle))
            .collect();
        let mut wanted = vec![false; self.excess.len()];
        while let Some(node) = next.pop() {
            let node = node as usize;
            if std::mem::replace(&mut wanted[node], true) {
                continue;
            }
            if SIDES.iter().any(|face| !self.has_links(node, *face)) {
                next.extend(self.neighbours.of(node));
            }
        }
        self.nodes.clear();
        (self.nodes).extend(
            (0..)
                .zip(&wanted)
                .filter(|(_, wanted)| **wanted)
                .map(|(node, _)| node),
        );
        let about = |triangle: &u32| {
            of_triangle(*triangle)
                .iter()
                .any(|node| wanted[*node as usize])
        };
        self.triangles = Some(cuts.triangles().iter().copied().filter(about).collect());
    }

    /// Takes all nodes again.
    pub fn widen(&mut self) {
        if self.triangles.take().is_some() {
            self.nodes.clear();
            self.nodes.extend(0..self.excess.len() as u32);
        }
    }

    /// True while not all nodes are taken.
    #[must_use]
    pub const fn is_narrow(&self) -> bool {
        self.triangles.is_some()
    }

    /// Takes what the links of this step see, sorted by triangle.
    pub fn take(&mut self, seen: &Seen<'_>, cuts: &CutsByTriangle) {
        for node in &self.nodes {
            self.sums[*node as usize] = [0.0; 2];
            self.weights[*node as usize] = [0.0; 2];
        }
        let triangles = self.triangles.as_deref().unwrap_or(cuts.triangles());
        // By corner and face: sum, and sum of weights.
        let of_triangles: Vec<[[[f64; 2]; 2]; 3]> = (triangles.par_iter())
            .with_min_len(TRIANGLES_AT_ONCE)
            .map(|triangle| {
                let mut sums = [[[0.0; 2]; 2]; 3];
                for &(number, side) in cuts.of(*triangle) {
                    let (number, side) = (number as usize, usize::from(side));
                    let link = &seen.links[number];
                    let weight = WEIGHTS[link.leaving(0)];
                    let face = seen.face(link, side);
                    for (corner, share) in link.cuts[side].weights.into_iter().enumerate() {
                        sums[corner][face][0] += share * seen.returns[number][side].out;
                        sums[corner][face][1] += share * weight;
                    }
                }
                sums
            })
            .collect();
        for (triangle, of_corners) in triangles.iter().zip(of_triangles) {
            for (node, faces) in seen.triangles[*triangle as usize].iter().zip(of_corners) {
                for (face, [sum, weight]) in faces.into_iter().enumerate() {
                    self.sums[*node as usize][face] += sum;
                    self.weights[*node as usize][face] += weight;
                }
            }
        }
        for face in SIDES {
            for &node in &self.nodes {
                let node = node as usize;
                if self.has_links(node, face) {
                    let now = self.sums[node][face] / self.weights[node][face];
                    let excess = &mut self.excess[node][face];
                    *excess += NEW_SHARE * (now - *excess);
                }
            }
            for _ in 0..CARRIED {
                for &node in &self.nodes {
                    let node = node as usize;
                    let around = self.neighbours.of(node);
                    if !self.has_links(node, face) && !around.is_empty() {
                        let sum: f64 = (around.iter())
                            .map(|other| self.excess[*other as usize][face])
                            .sum();
                        self.excess[node][face] = sum / around.len() as f64;
                    }
                }
            }
        }
    }

    fn has_links(&self, node: usize, face: usize) -> bool {
        /// Links that a node has hardly any share in tell nothing of it.
        const LEAST: f64 = 1e-4;
        self.weights[node][face] > LEAST
    }

    /// Density excess between two layers on a link: the mean of the faces that look at each other.
    #[must_use]
    pub fn between(&self, seen: &Seen<'_>, link: &CutLink) -> f64 {
        let inside = SIDES.map(|side| {
            let face = 1 - seen.face(link, side);
            let cut = &link.cuts[side];
            let nodes = seen.triangles[cut.triangle as usize].iter();
            let parts = nodes.zip(cut.weights);
            let sum: f64 = parts
                .map(|(node, share)| share * self.excess[*node as usize][face])
                .sum();
            sum
        });
        0.5 * (inside[0] + inside[1])
    }

    /// Density excess on both faces of every node.
    #[must_use]
    pub fn excess(&self) -> &[[f64; 2]] {
        &self.excess
    }

    /// Goes on with these.
    pub fn go_on(&mut self, excess: Vec<[f64; 2]>) {
        self.excess = excess;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut_links::{CutLinks, Domain};

    /// Two plates of 16 by 16 cells, half a cell apart over a part of them: what stands between them is the same to the bit where only what decides on it is taken.
    #[test]
    fn what_decides_is_enough() {
        const ACROSS: u32 = 9;
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for plate in 0..2_u32 {
            let first = plate * ACROSS * ACROSS;
            for (i, j) in (0..ACROSS).flat_map(|i| (0..ACROSS).map(move |j| (i, j))) {
                let apart = f64::from(plate) * (0.4 + f64::from(i.saturating_sub(3)));
                positions.push(DVec3::new(f64::from(2 * i), f64::from(2 * j), 5.2 + apart) + 4.1);
                if i + 1 < ACROSS && j + 1 < ACROSS {
                    let [a, b] = [first + i * ACROSS + j, first + (i + 1) * ACROSS + j];
                    triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
                }
            }
        }
        let domain = Domain {
            cells: [32; 3],
            repeats: [false; 3],
            kept: 0,
            open_from: None,
        };
        let (mut links, mut cuts) = (CutLinks::default(), CutsByTriangle::default());
        links.find(&positions, &triangles, &domain).unwrap();
        cuts.sort(&links, triangles.len());
        let normals: Vec<DVec3> = (triangles.iter())
            .map(|nodes| {
                let [a, b, c] = nodes.map(|node| positions[node as usize]);
                (b - a).cross(c - a).normalize()
            })
            .collect();
        let mut all = FacePressures::new(&triangles, positions.len());
        let mut narrow = all.clone();
        for step in 0..30_u32 {
            let out = |link: usize, side: usize| {
                1e-3 * (f64::from(step) + 0.7 * link as f64 + 1.3 * side as f64).sin()
            };
            let returns: Vec<[Return; 2]> = (0..links.links().len())
                .map(|link| {
                    SIDES.map(|side| Return {
                        out: out(link, side),
                        ..Return::default()
                    })
                })
                .collect();
            let seen = Seen {
                triangles: &triangles,
                normals: &normals,
                links: links.links(),
                returns: &returns,
            };
            all.take(&seen, &cuts);
            narrow.take(&seen, &cuts);
            if step == 0 {
                narrow.narrow(&seen, &cuts, links.doubled());
                assert!(narrow.is_narrow() && !all.is_narrow());
                let taken = narrow.nodes.len();
                assert!(taken > 20 && taken < positions.len() * 2 / 3, "{taken}");
            }
            for link in links.doubled() {
                let link = &seen.links[*link as usize];
                assert_eq!(all.between(&seen, link), narrow.between(&seen, link));
            }
        }
        assert_ne!(all.excess(), narrow.excess());
        narrow.widen();
        assert_eq!(narrow.nodes, all.nodes);
    }
}
