//! Flat circular canopy cut into gores, and its triangle mesh.
//!
//! The pattern lies in the plane x = 0 with the apex at the origin. Ring i carries ⌈i/2⌉ segments per half gore, so seams and
//! the centre lines of gores are mesh lines from apex to skirt: a pleated canopy folds along mesh lines only and keeps
//! every rest length.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Dimensions of a flat circular canopy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatCircular {
    /// Nominal area S₀ [m²].
    pub nominal_area_m2: f64,
    /// Number of gores.
    pub gores: usize,
    /// Rings of triangles between apex and skirt.
    pub rings: usize,
}

impl FlatCircular {
    /// Nominal diameter D₀ = √(4 S₀/π) [m].
    #[must_use]
    pub fn nominal_diameter_m(&self) -> f64 {
        (4.0 * self.nominal_area_m2 / PI).sqrt()
    }

    /// Segments of ring `ring` in one half gore.
    #[must_use]
    pub const fn segments(&self, ring: usize) -> usize {
        ring.div_ceil(2)
    }

    /// Radius of the skirt's nodes [m], such that the mesh, a polygon, has exactly the nominal area.
    #[must_use]
    pub fn skirt_radius_m(&self) -> f64 {
        let sides = (2 * self.gores * self.segments(self.rings)) as f64;
        (2.0 * self.nominal_area_m2 / (sides * (TAU / sides).sin())).sqrt()
    }

    /// Angle of half a gore [rad].
    #[must_use]
    pub fn half_gore_rad(&self) -> f64 {
        PI / self.gores as f64
    }

    /// Number of nodes of the mesh.
    #[must_use]
    pub fn node_count(&self) -> usize {
        1 + (1..=self.rings)
            .map(|ring| 2 * self.gores * self.segments(ring))
            .sum::<usize>()
    }

    /// Number of triangles of the mesh.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        2 * self.gores
            * (1..=self.rings)
                .map(|ring| self.segments(ring) + self.segments(ring - 1))
                .sum::<usize>()
    }
}

/// Mesh of the flat pattern.
#[derive(Debug, Clone)]
pub struct GoreMesh {
    /// Node positions in the plane x = 0 [m]; node 0 is the apex.
    pub flat_positions_m: Vec<DVec3>,
    /// Half gore (0 … 2·gores − 1) in which a node lies; nodes on a line between two belong to the one that starts there.
    pub half_gores: Vec<usize>,
    /// Triangles; normals along +x.
    pub triangles: Vec<[u32; 3]>,
    /// Warp direction of every triangle: the centre line of its gore.
    pub warps: Vec<DVec3>,
    /// Nodes along every seam, from the apex to the skirt.
    pub seams: Vec<Vec<u32>>,
    /// Nodes along the centre line of every gore, from the apex to the skirt.
    pub centres: Vec<Vec<u32>>,
}

/// Meshes the pattern.
#[must_use]
pub fn mesh(pattern: &FlatCircular) -> GoreMesh {
    let halves = 2 * pattern.gores;
    let radius = pattern.skirt_radius_m();
    let mut flat_positions_m = vec![DVec3::ZERO];
    let mut half_gores = vec![0];
    let mut first_of_ring = vec![0u32];
    for ring in 1..=pattern.rings {
        first_of_ring.push(flat_positions_m.len() as u32);
        let per_half = pattern.segments(ring);
        for k in 0..halves * per_half {
            let angle = TAU * k as f64 / (halves * per_half) as f64;
            let r = radius * ring as f64 / pattern.rings as f64;
            flat_positions_m.push(DVec3::new(0.0, r * angle.cos(), r * angle.sin()));
            half_gores.push(k / per_half);
        }
    }
    let node = |ring: usize, half: usize, k: usize| -> u32 {
        if ring == 0 {
            return 0;
        }
        let count = halves * pattern.segments(ring);
        first_of_ring[ring] + ((half * pattern.segments(ring) + k) % count) as u32
    };
    let mut triangles = Vec::with_capacity(pattern.triangle_count());
    let mut warps = Vec::with_capacity(pattern.triangle_count());
    for half in 0..halves {
        let centre = TAU * ((half / 2) as f64 + 0.5) / pattern.gores as f64;
        let warp = DVec3::new(0.0, centre.cos(), centre.sin());
        for ring in 1..=pattern.rings {
            let (inner, outer) = (pattern.segments(ring - 1), pattern.segments(ring));
            let (mut i, mut o) = (0, 0);
            // Advance on whichever side lags behind in angle.
            while i < inner || o < outer {
                let advance_outer =
                    i == inner || (o < outer && (2 * o + 1) * inner <= (2 * i + 1) * outer);
                if advance_outer {
                    triangles.push([
                        node(ring - 1, half, i),
                        node(ring, half, o),
                        node(ring, half, o + 1),
                    ]);
                    o += 1;
                } else {
                    triangles.push([
                        node(ring - 1, half, i),
                        node(ring, half, o),
                        node(ring - 1, half, i + 1),
                    ]);
                    i += 1;
                }
                warps.push(warp);
            }
        }
    }
    let down = |half: usize| {
        (0..=pattern.rings)
            .map(|ring| node(ring, half, 0))
            .collect()
    };
    let seams = (0..pattern.gores).map(|g| down(2 * g)).collect();
    let centres = (0..pattern.gores).map(|g| down(2 * g + 1)).collect();
    GoreMesh {
        flat_positions_m,
        half_gores,
        triangles,
        warps,
        seams,
        centres,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::quality;

    const P4: FlatCircular = FlatCircular {
        nominal_area_m2: 0.78,
        gores: 8,
        rings: 12,
    };

    #[test]
    fn the_mesh_has_the_nominal_area_and_faces_downstream() {
        let mesh = mesh(&P4);
        assert_eq!(mesh.triangles.len(), P4.triangle_count());
        assert_eq!(mesh.flat_positions_m.len(), P4.node_count());
        let mut area = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|n| mesh.flat_positions_m[n as usize]);
            let normal = (b - a).cross(c - a);
            assert!(normal.x > 0.0);
            area += 0.5 * normal.length();
        }
        assert!((area - 0.78).abs() < 1e-12);
    }

    #[test]
    fn every_inner_edge_is_shared_by_two_triangles() {
        let mesh = mesh(&P4);
        let mut edges = std::collections::HashMap::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
        let border = edges.values().filter(|&&n| n == 1).count();
        assert_eq!(border, 2 * 8 * P4.segments(12));
        assert!(edges.values().all(|&n| n <= 2));
    }

    #[test]
    fn triangles_are_well_shaped() {
        let mesh = mesh(&P4);
        let quality = quality::measure(&mesh.flat_positions_m, &mesh.triangles).unwrap();
        assert!(quality.smallest_shape > 0.5, "{quality:?}");
        assert!(quality.mean_shape > 0.8, "{quality:?}");
    }
}
