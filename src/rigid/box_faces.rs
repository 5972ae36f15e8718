//! Faces of the box of air, and the part of a surface that lies before those which it passes through.

use std::collections::HashMap;

use glam::DVec3;

use super::Surface;

/// Depths before a face smaller than this share of the box's longest side are none: corners on a face are never cut.
const ON_THE_FACE: f64 = 1e-9;

/// Share of a triangle's area below which a piece of it is left out.
const SMALLEST_SHARE: f64 = 1e-9;

/// A face of the box of air.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoxFace {
    /// Axis of its normal.
    pub axis: usize,
    /// At the upper end of the axis.
    pub upper: bool,
}

impl BoxFace {
    /// Where the wind comes in.
    pub const INLET: Self = Self {
        axis: 0,
        upper: false,
    };

    /// All six, the inlet first.
    pub const ALL: [Self; 6] = [
        Self::INLET,
        Self::at(0, true),
        Self::at(1, false),
        Self::at(1, true),
        Self::at(2, false),
        Self::at(2, true),
    ];

    const fn at(axis: usize, upper: bool) -> Self {
        Self { axis, upper }
    }

    /// How far a place lies before the face of a box of `size_m`; negative beyond it [m].
    #[must_use]
    pub fn depth_m(self, place_m: DVec3, size_m: DVec3) -> f64 {
        let along_m = place_m[self.axis];
        if self.upper {
            size_m[self.axis] - along_m
        } else {
            along_m
        }
    }

    /// Its name as in a case, or in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match (self.axis, self.upper) {
            (0, false) => "the inlet",
            (0, true) => "the outlet",
            (1, false) => "air.faces.y_lower",
            (1, true) => "air.faces.y_upper",
            (_, false) => "air.faces.z_lower",
            (_, true) => "air.faces.z_upper",
        }
    }
}

impl Surface {
    /// Area that it shows to a wind along x: of what faces the wind and of what faces away, the larger [m²].
    #[must_use]
    pub fn frontal_area_m2(&self) -> f64 {
        let (mut towards, mut away) = (0.0, 0.0);
        for area in self.area_vectors_m2() {
            if area.x < 0.0 {
                towards -= area.x;
            } else {
                away += area.x;
            }
        }
        f64::max(towards, away)
    }

    /// The part before `faces` of a box of `size_m`; triangles across a face are cut along it.
    #[must_use]
    pub fn before(&self, faces: &[BoxFace], size_m: DVec3) -> Self {
        let none_m = ON_THE_FACE * size_m.max_element();
        let depth_m = |face: BoxFace, place: DVec3| {
            let depth = face.depth_m(place, size_m);
            if depth.abs() < none_m { 0.0 } else { depth }
        };
        let cut = |polygon: Vec<DVec3>, face: &BoxFace| {
            let mut part = Vec::with_capacity(polygon.len() + 1);
            for (k, &from) in polygon.iter().enumerate() {
                let to = polygon[(k + 1) % polygon.len()];
                let [a, b] = [from, to].map(|place| depth_m(*face, place));
                if a >= 0.0 {
                    part.push(from);
                }
                // Corners on the face are no new ones.
                if a.min(b) < 0.0 && a.max(b) > 0.0 {
                    let mut crossing = from + (to - from) * (a / (a - b));
                    crossing[face.axis] = if face.upper { size_m[face.axis] } else { 0.0 };
                    part.push(crossing);
                }
            }
            part
        };
        let mut part = Self::default();
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        for &nodes in &self.triangles {
            let corners = self.corners(nodes);
            let polygon = faces.iter().fold(corners.to_vec(), cut);
            let on_a_face = |face: &BoxFace| polygon.iter().all(|&p| depth_m(*face, p) == 0.0);
            if polygon.len() < 3 || faces.iter().any(on_a_face) {
                continue;
            }
            if polygon == corners {
                part.triangles.push(nodes.map(|node| {
                    *numbers.entry(node).or_insert_with(|| {
                        part.positions_m.push(self.positions_m[node as usize]);
                        part.positions_m.len() as u32 - 1
                    })
                }));
                continue;
            }
            let doubled = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
            let least = SMALLEST_SHARE * doubled(corners);
            for k in 2..polygon.len() {
                let piece = [polygon[0], polygon[k - 1], polygon[k]];
                if doubled(piece) > least {
                    let first = part.positions_m.len() as u32;
                    part.positions_m.extend(piece);
                    part.triangles.push([first, first + 1, first + 2]);
                }
            }
        }
        part
    }

    /// Volume and its centroid [m³, m] of what a closed surface encloses before sides and the outlet of a box of length `length_m`, of which this
    /// is the part: by fluxes of vectors along x that are zero on the outlet. None passes through sides.
    #[must_use]
    pub fn volume_before_m3(&self, length_m: f64) -> (f64, DVec3) {
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for (&nodes, area) in self.triangles.iter().zip(self.area_vectors_m2()) {
            let corners = self.corners(nodes).map(|p| p - DVec3::X * length_m);
            let sum: DVec3 = corners.iter().sum();
            let products: DVec3 = corners.iter().map(|p| p.x * *p).sum::<DVec3>() + sum.x * sum;
            volume += area.x * sum.x / 3.0;
            moment += area.x / 12.0 * products * DVec3::new(0.5, 1.0, 1.0);
        }
        (volume.abs(), DVec3::X * length_m + moment / volume)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of a block at one, two and three faces has the areas, the volume and the centroid of a smaller block without lids.
    #[test]
    fn what_lies_before_faces_is_a_smaller_block() {
        let size = DVec3::new(5.0, 4.0, 3.0);
        let whole = Surface::block(DVec3::new(3.0, -1.0, 1.0), DVec3::new(6.0, 2.5, 4.0));
        assert!(whole.is_closed());
        let [_, outlet, y_lower, _, _, z_upper] = BoxFace::ALL;
        for faces in [
            vec![y_lower],
            vec![outlet, y_lower],
            vec![outlet, y_lower, z_upper],
            vec![],
        ] {
            let (mut low, mut high) = (DVec3::new(3.0, -1.0, 1.0), DVec3::new(6.0, 2.5, 4.0));
            for face in &faces {
                if face.upper {
                    high[face.axis] = size[face.axis];
                } else {
                    low[face.axis] = 0.0;
                }
            }
            let part = whole.before(&faces, size);
            assert_eq!(part.bounds_m(), (low, high));
            let sides = high - low;
            assert!((part.frontal_area_m2() - sides.y * sides.z).abs() < 1e-12);
            let lids: f64 = faces
                .iter()
                .map(|face| sides.element_product() / sides[face.axis])
                .sum();
            let whole_m2 = 2.0 * (sides.x * sides.y + sides.y * sides.z + sides.z * sides.x) - lids;
            assert!((part.area_m2() - whole_m2).abs() < 1e-12);
            let (volume, centroid) = part.volume_before_m3(size.x);
            assert!((volume - sides.element_product()).abs() < 1e-12);
            assert!((centroid - 0.5 * (low + high)).length() < 1e-12);
        }
        // Corners on the face are kept as they are, and what lies in it is left out.
        let beside = Surface::block(DVec3::new(1.0, 0.0, 1.0), DVec3::new(2.0, 1.0, 2.0));
        let open = beside.before(&[y_lower], size);
        assert_eq!(open.positions_m.len(), 8);
        assert_eq!(open.triangles.len(), 10);
        let beyond = Surface::block(DVec3::new(1.0, -1.0, 1.0), DVec3::new(2.0, 0.0, 2.0));
        assert!(beyond.before(&[y_lower], size).triangles.is_empty());
    }
}
