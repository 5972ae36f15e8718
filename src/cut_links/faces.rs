//! Fields on the nodes of a sheet, from what its cut links see: the pressure on both of its faces, and the air through it.

use glam::DVec3;
use rayon::prelude::*;

use super::bounce::{Return, SIDES};
use super::by_triangle::CutsByTriangle;
use super::search::CutLink;
use crate::immersed::permeable::Resistance;
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

    fn of(&self, node: usize) -> &[u32] {
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
        let towards = normal.dot(link.direction()) > 0.0;
        usize::from(towards == (side == 0))
    }
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
            for _ in 0..CARRIED {
                for node in 0..self.excess.len() {
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

/// Velocity of the air through the sheet along its normals, at every node.
///
/// It follows from A Δp(v) = K (w − v). Here w is the normal slip that the links around a node see, and K the stiffness with which they hold it. A is
/// the area that it stands for, and Δp(v) = r v + s v|v| the fabric's law. All three are smoothed along the sheet over about a cell. So single links, which see the slip along the sheet, too,
/// do not decide. The fabric's own velocity is that of the last step.
#[derive(Debug, Clone)]
pub struct Through {
    neighbours: Neighbours,
    /// r and s of the triangles at every node [lattice units]; `None` where nothing passes.
    laws: Vec<Option<[f64; 2]>>,
    /// Smoothing steps.
    smoothing: usize,
    /// Σ K (w·), Σ K, A.
    sums: Vec<[f64; 3]>,
    velocities: Vec<f64>,
    /// Mean over the permeable area [cells per step].
    mean: f64,
}

impl Through {
    /// Of a surface whose triangles follow these laws, its edges so many cells long in the mean; `None` where nothing passes.
    #[must_use]
    pub fn new(
        triangles: &[[u32; 3]],
        laws_of_triangles: &[Option<[f64; 2]>],
        count: usize,
        edge_cells: f64,
    ) -> Option<Self> {
        let mut laws = vec![None; count];
        for (nodes, law) in triangles.iter().zip(laws_of_triangles) {
            for node in nodes {
                laws[*node as usize] = laws[*node as usize].or(*law);
            }
        }
        laws.iter().any(Option::is_some).then(|| Self {
            neighbours: Neighbours::new(triangles, count),
            laws,
            smoothing: ((1.0 / edge_cells).powi(2).ceil() as usize).clamp(1, 12),
            sums: vec![[0.0; 3]; count],
            velocities: vec![0.0; count],
            mean: 0.0,
        })
    }

    /// Works out what passes, from what the links of this step see and the sheet's own `velocities` and `areas` of triangles [lattice units].
    /// `inside` is the density excess between the layers of every link.
    pub fn take(
        &mut self,
        seen: &Seen<'_>,
        inside: &[f64],
        (velocities, areas): (&[DVec3], &[f64]),
    ) {
        self.sums.fill([0.0; 3]);
        for ((link, returns), inside) in seen.links.iter().zip(seen.returns).zip(inside) {
            let weight = WEIGHTS[link.leaving(0)];
            for side in SIDES {
                let cut = &link.cuts[side];
                let nodes = seen.triangles[cut.triangle as usize];
                let leaving = link.direction() * if side == 0 { 1.0 } else { -1.0 };
                let across = leaving.dot(seen.normals[cut.triangle as usize]);
                let own: DVec3 = (nodes.iter().zip(cut.weights))
                    .map(|(node, share)| velocities[*node as usize] * share)
                    .sum();
                let stiffness = 6.0 * weight * returns[side].strength;
                let push =
                    returns[side].push() - 2.0 * weight * inside - stiffness * leaving.dot(own);
                for (node, share) in nodes.into_iter().zip(cut.weights) {
                    let sums = &mut self.sums[node as usize];
                    sums[0] += share * across * push;
                    sums[1] += share * across * across * stiffness;
                }
            }
        }
        for (nodes, area) in seen.triangles.iter().zip(areas) {
            for node in nodes {
                self.sums[*node as usize][2] += area / 3.0;
            }
        }
        for _ in 0..self.smoothing {
            let old = self.sums.clone();
            // Every node gives half of its own away, in equal parts: nothing is lost.
            for (node, sums) in self.sums.iter_mut().enumerate() {
                for sum in sums.iter_mut() {
                    *sum *= 0.5;
                }
                for other in self.neighbours.of(node) {
                    let other = *other as usize;
                    let parts = 2.0 * self.neighbours.of(other).len() as f64;
                    for (sum, old) in sums.iter_mut().zip(old[other]) {
                        *sum += old / parts;
                    }
                }
            }
        }
        let (mut flow, mut whole) = (0.0, 0.0);
        for (node, law) in self.laws.iter().enumerate() {
            let [push, stiffness, area] = self.sums[node];
            self.velocities[node] = 0.0;
            let Some([viscous, inertial]) = *law else {
                continue;
            };
            if stiffness > 0.0 {
                let resistance = Resistance {
                    viscous: viscous * area / stiffness,
                    inertial: inertial * area / stiffness,
                };
                self.velocities[node] = resistance.through_velocity(push / stiffness);
            }
            flow += self.velocities[node] * area;
            whole += area;
        }
        self.mean = flow / whole;
    }

    /// Velocity through the sheet at a cut, along the normal.
    #[must_use]
    pub fn at(&self, nodes: [u32; 3], weights: [f64; 3]) -> f64 {
        let parts = nodes.into_iter().zip(weights);
        parts
            .map(|(node, share)| share * self.velocities[node as usize])
            .sum()
    }

    /// Mean over the permeable area [cells per step].
    #[must_use]
    pub const fn mean(&self) -> f64 {
        self.mean
    }
}
