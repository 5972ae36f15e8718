//! Fields on the nodes of a sheet, from what its cut links see: the pressure on both of its faces.

use glam::DVec3;
use rayon::prelude::*;

use super::bounce::{Return, SIDES};
use super::by_triangle::CutsByTriangle;
use super::search::CutLink;
use crate::lattice::WEIGHTS;

/// Share of a step that a face's pressure takes of what its links see: sound and single cells pass, the opening of a pleat stays.
pub const NEW_SHARE: f64 = 0.3;

/// Steps of carrying on to nodes without links, in every step of the air.
pub const CARRIED: usize = 3;

/// Links that a node has hardly any share in tell nothing of it: sum of their weights.
pub const LEAST_WEIGHT: f64 = 1e-4;

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
        }
    }

    /// Takes what the links of this step see, sorted by triangle.
    pub fn take(&mut self, seen: &Seen<'_>, cuts: &CutsByTriangle) {
        self.sums.fill([0.0; 2]);
        self.weights.fill([0.0; 2]);
        // By corner and face: sum, and sum of weights.
        let of_triangles: Vec<[[[f64; 2]; 2]; 3]> = (cuts.triangles().par_iter())
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
        for (triangle, of_corners) in cuts.triangles().iter().zip(of_triangles) {
            for (node, faces) in seen.triangles[*triangle as usize].iter().zip(of_corners) {
                for (face, [sum, weight]) in faces.into_iter().enumerate() {
                    self.sums[*node as usize][face] += sum;
                    self.weights[*node as usize][face] += weight;
                }
            }
        }
        for face in SIDES {
            for node in 0..self.excess.len() {
                if self.has_links(node, face) {
                    let now = self.sums[node][face] / self.weights[node][face];
                    let excess = &mut self.excess[node][face];
                    *excess += NEW_SHARE * (now - *excess);
                }
            }
        }
        for _ in 0..CARRIED {
            self.carry();
        }
    }

    /// Carries pressures on by a node: a Jacobi sweep, which does not hang on the numbers of the nodes.
    fn carry(&mut self) {
        let before = self.excess.clone();
        for node in 0..before.len() {
            let around = self.neighbours.of(node);
            for face in SIDES {
                if self.has_links(node, face) || around.is_empty() {
                    continue;
                }
                let of_others = around.iter().map(|other| before[*other as usize][face]);
                self.excess[node][face] = of_others.sum::<f64>() / around.len() as f64;
            }
        }
    }

    fn has_links(&self, node: usize, face: usize) -> bool {
        self.weights[node][face] > LEAST_WEIGHT
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
