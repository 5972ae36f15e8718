//! Part of stage `solve_cloth` where the fabric cuts the lattice: the reactions of the air on its triangles ([`super::triangle_reaction`]), summed once a solve.
//!
//! In the velocities v_n of the nodes they are ½ Σ v_nᵀ S_nm v_m − Σ p_n·v_n, with blocks S for each node and for each edge between two. What an evaluation costs does not depend on how many
//! links there are.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::edges::Edges;
use super::gather::Gather;
use super::loads::StepInput;
use super::triangle_reaction::TriangleReaction;
use super::vectors::each_summed;
use crate::cloth::Structure;

/// A symmetric block: xx, yy, zz and yz, xz, xy.
#[derive(Debug, Clone, Copy, Default)]
struct Block([DVec3; 2]);

impl Block {
    fn add(&mut self, matrix: DMat3) {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        self.0[0] += DVec3::new(x.x, y.y, z.z);
        self.0[1] += DVec3::new(y.z, x.z, x.y);
    }

    fn times(&self, v: DVec3) -> DVec3 {
        let [diagonal, off] = self.0;
        DVec3::new(
            diagonal.x * v.x + off.z * v.y + off.y * v.z,
            off.z * v.x + diagonal.y * v.y + off.x * v.z,
            off.y * v.x + off.x * v.y + diagonal.z * v.z,
        )
    }

    fn matrix(&self) -> DMat3 {
        let [d, off] = self.0;
        DMat3::from_cols(
            DVec3::new(d.x, off.z, off.y),
            DVec3::new(off.z, d.y, off.x),
            DVec3::new(off.y, off.x, d.z),
        )
    }
}

/// The sums of a solve; empty where nothing is cut.
#[derive(Debug, Clone, Default)]
pub(super) struct CutSums {
    between: Arc<Edges>,
    /// Σ S of every node with itself, and of every edge [kg/s].
    nodes: Vec<Block>,
    edges: Vec<Block>,
    /// Σ p [N].
    pulls_n: Vec<DVec3>,
    /// What is left where the fabric moves as the air does [W].
    rest_w: f64,
}

impl CutSums {
    /// Of the reactions on triangles with these nodes.
    fn of<'a>(
        edges: Arc<Edges>,
        triangles: impl Fn(&TriangleReaction) -> [u32; 3],
        reactions: impl Iterator<Item = &'a TriangleReaction>,
    ) -> Self {
        let node_count = edges.node_count();
        let mut sums = Self {
            nodes: vec![Block::default(); node_count],
            edges: vec![Block::default(); edges.count()],
            pulls_n: vec![DVec3::ZERO; node_count],
            rest_w: 0.0,
            between: edges,
        };
        for reaction in reactions {
            let of_triangle = sums.between.of_triangle(reaction.triangle);
            for (corner, node) in triangles(reaction).into_iter().enumerate() {
                sums.nodes[node as usize].add(reaction.between(corner, corner));
                sums.pulls_n[node as usize] += reaction.pull_n[corner];
                let edge = of_triangle[corner] as usize;
                sums.edges[edge].add(reaction.between(corner, (corner + 1) % 3));
            }
            sums.rest_w += reaction.rest_w;
        }
        sums
    }

    /// Those of a step; none in the static limit.
    pub(super) fn new(structure: &Structure, gather: &Gather, input: &StepInput) -> Self {
        if input.cut_triangles.is_empty() || input.time_step_s.is_none() {
            return Self::default();
        }
        let nodes =
            |reaction: &TriangleReaction| structure.triangles[reaction.triangle as usize].nodes;
        Self::of(gather.edges(structure), nodes, input.cut_triangles.iter())
    }

    /// The reactions at `point`, with velocities (x − x̂)/dt: gradient [N] and part of the objective [J] of a node. Nothing where nothing is cut.
    #[inline]
    pub(super) fn at(&self, [base, point]: [&[DVec3]; 2], dt: f64, node: usize) -> (DVec3, f64) {
        let Some(own) = self.nodes.get(node) else {
            return (DVec3::ZERO, 0.0);
        };
        let way = point[node] - base[node];
        let mut resistance = own.times(way);
        for &[other, edge] in self.between.at(node) {
            let other = other as usize;
            resistance += self.edges[edge as usize].times(point[other] - base[other]);
        }
        let (resistance, pull) = (resistance / dt, self.pulls_n[node]);
        (resistance - pull, way.dot(0.5 * resistance - pull))
    }

    /// The part of the objective that belongs to no node [J].
    pub(super) fn rest_j(&self, dt: f64) -> f64 {
        dt * self.rest_w
    }

    /// Adds the reactions at `point` to the gradient [N]; returns their part of the objective [J].
    pub(super) fn add_reactions(
        &self,
        places: [&[DVec3]; 2],
        dt: f64,
        gradient: &mut [DVec3],
    ) -> f64 {
        if self.nodes.is_empty() {
            return 0.0;
        }
        let value = each_summed(gradient, |node, gradient| {
            let (force, energy) = self.at(places, dt, node);
            *gradient += force;
            energy
        });
        value + self.rest_j(dt)
    }

    /// Adds their blocks [N/m] to block-Jacobi's.
    pub(super) fn add_blocks(&self, dt: f64, blocks: &mut [DMat3]) {
        for (block, own) in blocks.iter_mut().zip(&self.nodes) {
            *block += own.matrix() * (1.0 / dt);
        }
    }
}

/// The reaction of every triangle by its number; empty where nothing is cut.
pub(super) fn by_triangle<'a>(
    structure: &Structure,
    input: &StepInput<'a>,
) -> Vec<Option<&'a TriangleReaction>> {
    if input.cut_triangles.is_empty() {
        return Vec::new();
    }
    let mut found = vec![None; structure.triangles.len()];
    for reaction in input.cut_triangles {
        found[reaction.triangle as usize] = Some(reaction);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power, forces and blocks are those of the cuts one by one, on two triangles at one edge.
    #[test]
    fn triangles_do_what_their_cuts_do() {
        let triangles = [[0, 1, 2], [2, 1, 3]];
        let cuts = [
            (0, [0.2, 0.5, 0.3], DVec3::new(0.6, 0.0, 0.8), [2.0, 0.3]),
            (0, [0.7, 0.1, 0.2], DVec3::new(0.0, 1.0, 0.0), [0.5, -1.1]),
            (1, [0.4, 0.4, 0.2], DVec3::new(0.0, -0.6, 0.8), [1.5, 0.7]),
        ];
        let dt = 0.25;
        let base = [DVec3::new(0.3, -0.1, 0.2); 4];
        let velocities = [
            DVec3::new(0.1, -0.4, 0.3),
            DVec3::new(-0.2, 0.6, 0.5),
            DVec3::new(0.9, 0.1, -0.7),
            DVec3::new(-0.5, 0.8, 0.4),
        ];
        let mut reactions = [0, 1].map(TriangleReaction::none);
        let (mut value, mut forces) = (0.0, [DVec3::ZERO; 4]);
        let mut diagonal = [DMat3::ZERO; 4];
        for (triangle, weights, direction, [k, p]) in cuts {
            reactions[triangle].add(weights, direction, [k, p]);
            let nodes = triangles[triangle].map(|node| node as usize);
            let v: DVec3 = (0..3).map(|a| velocities[nodes[a]] * weights[a]).sum();
            value += dt * 0.5 * k * (direction.dot(v) - p / k).powi(2);
            for (node, weight) in nodes.into_iter().zip(weights) {
                forces[node] += direction * (weight * (k * direction.dot(v) - p));
                diagonal[node] += super::super::initial_hessian::outer(direction, direction)
                    * (k * weight * weight / dt);
            }
        }
        let edges = Arc::new(Edges::new(4, triangles.into_iter()));
        let of = |reaction: &TriangleReaction| triangles[reaction.triangle as usize];
        let sums = CutSums::of(edges, of, reactions.iter());
        let point: Vec<DVec3> = (base.iter().zip(velocities))
            .map(|(b, v)| *b + v * dt)
            .collect();
        let mut gradient = [DVec3::ZERO; 4];
        let found = sums.add_reactions([&base, &point], dt, &mut gradient);
        assert!((found - value).abs() < 1e-14, "{found} {value}");
        for (found, force) in gradient.iter().zip(forces) {
            assert!((*found - force).length() < 1e-14);
        }
        // As a device takes them, triangle by triangle.
        let (mut power, mut of_triangles) = (0.0, [DVec3::ZERO; 4]);
        for (reaction, nodes) in reactions.iter().zip(triangles) {
            let nodes = nodes.map(|node| node as usize);
            let (of_one, forces) = reaction.at(nodes.map(|node| velocities[node]));
            power += of_one;
            for (node, force) in nodes.into_iter().zip(forces) {
                of_triangles[node] += force;
            }
        }
        assert!((dt * power - value).abs() < 1e-14, "{power} {value}");
        for (found, force) in of_triangles.iter().zip(forces) {
            assert!((*found - force).length() < 1e-14);
        }
        let mut blocks = [DMat3::ZERO; 4];
        sums.add_blocks(dt, &mut blocks);
        for (found, block) in blocks.iter().zip(diagonal) {
            assert!(found.abs_diff_eq(block, 1e-14));
        }
    }
}
