//! Displacements of a wing carried over to a finer or coarser mesh of the same plan.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::{BuiltWing, Part, Tag};
use crate::cloth::Structure;

/// Triangles whose middles are this far from a node's along the chord are looked at for it, per chord; where there are none, all of its panel or rib.
const REACH: f64 = 0.15;

/// A wing's mesh: what its triangles belong to, and the structure as built.
#[derive(Clone, Copy)]
pub struct Meshed<'a> {
    /// The wing.
    pub wing: &'a BuiltWing,
    /// Its structure at rest.
    pub structure: &'a Structure,
}

/// Where a triangle belongs, as a key.
fn place(tag: &Tag) -> (u8, u32) {
    let part = Part::ALL.iter().position(|part| *part == tag.part);
    (part.unwrap_or_default() as u8, tag.number)
}

/// Places of the nodes of `to` \[m\], displaced as the nearest points of the same panel or rib of `from` are, which stands at `positions_m`. Nodes of lines, which
/// both meshes have in the same order, move as their counterparts. `None` if their numbers differ.
#[must_use]
pub fn carried_over(from: Meshed, positions_m: &[DVec3], to: Meshed) -> Option<Vec<DVec3>> {
    let mut places: HashMap<(u8, u32), Vec<usize>> = HashMap::new();
    for (triangle, tag) in from.wing.tags.iter().enumerate() {
        places.entry(place(tag)).or_default().push(triangle);
    }
    let owners = |mesh: Meshed| {
        let mut owner = vec![None; mesh.structure.node_count()];
        for (triangle, t) in mesh.structure.triangles.iter().enumerate() {
            for node in t.nodes {
                owner[node as usize].get_or_insert(triangle);
            }
        }
        owner
    };
    let lines = |owner: &[Option<usize>]| -> Vec<usize> {
        let nodes = owner.iter().enumerate();
        nodes
            .filter(|(_, owner)| owner.is_none())
            .map(|(node, _)| node)
            .collect()
    };
    let owner = owners(to);
    let [from_lines, to_lines] = [lines(&owners(from)), lines(&owner)];
    if from_lines.len() != to_lines.len() {
        return None;
    }
    let rest = &from.structure.positions_m;
    let mut found: Vec<DVec3> = owner
        .par_iter()
        .zip(&to.structure.positions_m)
        .map(|(owner, &node)| {
            let Some(tag) = owner.map(|triangle| &to.wing.tags[triangle]) else {
                return node;
            };
            let Some(candidates) = places.get(&place(tag)) else {
                return node;
            };
            let displacement = |triangles: &mut dyn Iterator<Item = usize>| {
                let mut best = (f64::INFINITY, DVec3::ZERO);
                for triangle in triangles {
                    let nodes = from.structure.triangles[triangle].nodes.map(|n| n as usize);
                    let weights = nearest_weights(node, nodes.map(|n| rest[n]));
                    let sum = |of: &[DVec3]| -> DVec3 {
                        nodes.iter().zip(weights).map(|(&n, w)| of[n] * w).sum()
                    };
                    let there = sum(rest);
                    let distance = there.distance_squared(node);
                    if distance < best.0 {
                        best = (distance, sum(positions_m) - there);
                    }
                }
                best
            };
            let near = |triangle: &usize| {
                let away = from.wing.tags[*triangle].chord_place - tag.chord_place;
                f64::from(away.abs()) < REACH
            };
            let (distance, moved) = displacement(&mut candidates.iter().copied().filter(near));
            if distance.is_finite() {
                return node + moved;
            }
            node + displacement(&mut candidates.iter().copied()).1
        })
        .collect();
    for (&old, &new) in from_lines.iter().zip(&to_lines) {
        found[new] = to.structure.positions_m[new] + positions_m[old] - rest[old];
    }
    Some(found)
}

/// Weights of the corners at the point of a triangle nearest to `point` (Ericson, Real-Time Collision Detection, section 5.1.5).
fn nearest_weights(point: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let from = |corner: DVec3| {
        let to = point - corner;
        (ab.dot(to), ac.dot(to))
    };
    let ((d1, d2), (d3, d4), (d5, d6)) = (from(a), from(b), from(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let edge_ab = d1 * d4 - d3 * d2;
    if edge_ab <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let edge_ac = d5 * d2 - d1 * d6;
    if edge_ac <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let edge_bc = d3 * d6 - d5 * d4;
    if edge_bc <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = edge_ab + edge_ac + edge_bc;
    let [v, w] = [edge_ac / sum, edge_ab / sum];
    [1.0 - v - w, v, w]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_points_are_those_of_a_fine_search() {
        let corners = [
            DVec3::new(0.1, 0.2, 0.3),
            DVec3::new(1.0, 0.1, 0.4),
            DVec3::new(0.4, 0.9, -0.2),
        ];
        for k in 0..200 {
            let wave = |n: f64| 1.5 * (n * f64::from(k)).sin();
            let point = DVec3::new(wave(0.7), wave(1.9), wave(3.1));
            let weights = nearest_weights(point, corners);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(weights.iter().all(|w| *w >= -1e-12));
            let at = |w: [f64; 3]| corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
            let found = at(weights).distance(point);
            let steps = 200;
            let mut best = f64::INFINITY;
            for i in 0..=steps {
                for j in 0..=(steps - i) {
                    let [v, w] = [i, j].map(|n| f64::from(n) / f64::from(steps));
                    best = best.min(at([1.0 - v - w, v, w]).distance(point));
                }
            }
            assert!(
                found <= best + 1e-12 && best - found < 0.01,
                "{k}: {found} {best}"
            );
        }
    }
}
