//! Rigid bodies: surfaces of triangles, held or moved as prescribed. Pure geometry and kinematics, in SI units.

mod box_faces;
mod inset;
pub mod motion;
mod overlap;
mod rays;
mod thickness;

use std::collections::HashMap;

use glam::DVec3;

use crate::immersed::markers::Extent;
pub use box_faces::BoxFace;
pub use inset::inset;
pub use motion::{Motion, Placement, PrescribedMotion};

/// Nodes and triangles of a surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Node positions [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Node indices of every triangle, `[triangle_count]`.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Corners of a triangle [m].
    #[must_use]
    pub fn corners(&self, nodes: [u32; 3]) -> [DVec3; 3] {
        nodes.map(|n| self.positions_m[n as usize])
    }

    /// Half the cross product of two edges of every triangle: its area along its normal [m²].
    pub fn area_vectors_m2(&self) -> impl Iterator<Item = DVec3> {
        self.triangles.iter().map(|&nodes| {
            let [a, b, c] = self.corners(nodes);
            0.5 * (b - a).cross(c - a)
        })
    }

    /// Area of all triangles [m²].
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.area_vectors_m2().map(DVec3::length).sum()
    }

    /// Sizes of the triangles, as far as markers care.
    pub fn extents(&self) -> impl Iterator<Item = Extent> {
        self.triangles
            .iter()
            .zip(self.area_vectors_m2())
            .map(|(&nodes, area)| {
                let [a, b, c] = self.corners(nodes);
                Extent {
                    area_m2: area.length(),
                    longest_edge_m: a.distance(b).max(b.distance(c)).max(c.distance(a)),
                    // Rigid surfaces are drawn in as a whole.
                    rim_depths_m: [f64::INFINITY; 3],
                }
            })
    }

    /// Directed edges that no neighbour runs along the other way: the rim.
    #[must_use]
    pub fn rim(&self) -> Vec<[u32; 2]> {
        let mut counts: HashMap<[u32; 2], i32> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *counts.entry([from.min(to), from.max(to)]).or_default() +=
                    if from < to { 1 } else { -1 };
            }
        }
        let mut rim = Vec::new();
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if counts.get(&[from.min(to), from.max(to)]) != Some(&0) {
                    rim.push([from, to]);
                }
            }
        }
        rim
    }

    /// True if the surface encloses a volume.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        !self.triangles.is_empty() && self.rim().is_empty()
    }

    /// Volume enclosed (negative if the normals point inwards) and its centroid, by the divergence theorem.
    #[must_use]
    pub fn volume_m3(&self) -> (f64, DVec3) {
        let origin = self.positions_m.first().copied().unwrap_or_default();
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for &nodes in &self.triangles {
            let [a, b, c] = self.corners(nodes).map(|p| p - origin);
            let part = a.dot(b.cross(c)) / 6.0;
            volume += part;
            moment += 0.25 * part * (a + b + c);
        }
        (volume, origin + moment / volume)
    }

    /// Lowest and highest corner [m].
    #[must_use]
    pub fn bounds_m(&self) -> (DVec3, DVec3) {
        self.positions_m
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            })
    }
}

#[cfg(test)]
impl Surface {
    /// A box from `low` to `high` with normals outwards, for trials.
    fn block(low: DVec3, high: DVec3) -> Self {
        let corner = |i: usize| {
            let upper = [i & 1, i >> 1 & 1, i >> 2];
            DVec3::from_array(std::array::from_fn(|a| [low[a], high[a]][upper[a]]))
        };
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        Self {
            positions_m: (0..8).map(corner).collect(),
            triangles: (sides.iter())
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
        }
    }
}
