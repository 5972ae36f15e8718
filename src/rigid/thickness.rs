//! How thick a body is: rays from its surface through its inside to the far side. The box around a body that lies askew says nothing of it.

use super::Surface;
use super::rays::{Bundles, points};

/// Points that rays begin at.
const LOOKS: usize = 256;

/// Share of the surface's size below which a ray has met where it began.
const NOWHERE: f64 = 1e-9;

/// Share of the area that must have a far side.
const SHARE: f64 = 0.5;

impl Surface {
    /// Median over the area of the way along the normals through what a closed surface encloses [m]. It is nearly the diameter of a sphere, the
    /// thickness of a slab, and three quarters of the largest thickness of a profile.
    ///
    /// Normals may point outwards or inwards: inside is the side on which more area has a far side. Area without one does not count. `None` where
    /// that is more than half, as of open surfaces, and of some that are cut at a face of the box.
    #[must_use]
    pub fn thickness_m(&self) -> Option<f64> {
        let (low, high) = self.bounds_m();
        let least_m = NOWHERE * (high - low).length();
        let bundles = Bundles::of(self);
        let points = points(self, LOOKS);
        // Ways to a far side, against the normals and along them.
        let mut ways_m: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
        for &(triangle, place_m) in &points {
            let [a, b, c] = self.corners(self.triangles[triangle]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for (ways_m, direction) in ways_m.iter_mut().zip([-normal, normal]) {
                let nearest = bundles
                    .meetings(place_m, direction)
                    .filter(|met| met.triangle != triangle && met.distance_m > least_m)
                    .map(|met| met.distance_m)
                    .min_by(f64::total_cmp);
                ways_m.extend(nearest);
            }
        }
        let [against, along] = ways_m;
        let mut inside_m = if against.len() >= along.len() {
            against
        } else {
            along
        };
        if (inside_m.len() as f64) < SHARE * points.len() as f64 {
            return None;
        }
        inside_m.sort_by(f64::total_cmp);
        inside_m.get(inside_m.len() / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::geometry::surfaces;

    #[test]
    fn a_sphere_is_as_thick_as_its_diameter() {
        for edge_m in [0.3, 0.1] {
            let sphere = surfaces::sphere(1.0, edge_m);
            let thickness_m = sphere.thickness_m().unwrap();
            assert!((thickness_m / 2.0 - 1.0).abs() < 0.02, "{thickness_m}");
        }
    }

    /// Whichever way a slab is turned, and its normals point.
    #[test]
    fn a_slab_is_as_thick_as_its_short_side() {
        let mut slab = Surface::block(DVec3::ZERO, DVec3::new(1.0, 0.05, 1.4));
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.8);
        for is_turned in [false, true] {
            if is_turned {
                for place_m in &mut slab.positions_m {
                    *place_m = turn * *place_m;
                }
                let (low, high) = slab.bounds_m();
                assert!((high - low).min_element() > 0.3);
            }
            for _ in 0..2 {
                let thickness_m = slab.thickness_m().unwrap();
                assert!((thickness_m - 0.05).abs() < 1e-9, "{thickness_m}");
                for triangle in &mut slab.triangles {
                    triangle.swap(1, 2);
                }
            }
        }
    }

    #[test]
    fn a_long_cylinder_is_as_thick_as_its_diameter_and_a_flat_one_as_its_length() {
        for (length_m, expected_m) in [(6.0, 2.0), (0.2, 0.2)] {
            let cylinder = surfaces::cylinder(1.0, length_m, true, 0.15);
            let thickness_m = cylinder.thickness_m().unwrap();
            assert!(
                (thickness_m / expected_m - 1.0).abs() < 0.02,
                "{thickness_m}"
            );
        }
    }

    #[test]
    fn a_sheet_has_no_thickness() {
        assert_eq!(surfaces::plate([1.0, 1.0], 0.1).thickness_m(), None);
        assert_eq!(surfaces::disk(1.0, 0.1).thickness_m(), None);
        assert_eq!(Surface::default().thickness_m(), None);
    }
}
