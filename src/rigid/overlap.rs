//! How much of a body lies in another one.

use glam::DVec3;

use super::rays::{Bundles, points};
use super::{BoxFace, Surface};

/// Points of a surface that are looked at.
const LOOKS: usize = 512;

/// Where rays run: along no axis, no diagonal and no plane that meshes are likely to have.
const DIRECTION: DVec3 = DVec3::new(0.6131, 0.5477, 0.5692);

/// What is left of it across two faces that a body passes through both.
const ACROSS: f64 = 1e-3;

impl Surface {
    /// Share of its area that lies inside `other`, where that `has_inside`, or within `near_m` of its surface. `None` where the boxes around both
    /// stand apart. It is read off at 512 points. `faces` are those of the box of air at which the other is cut.
    #[must_use]
    pub fn share_within(
        &self,
        other: &Self,
        has_inside: bool,
        faces: &[BoxFace],
        near_m: f64,
    ) -> Option<f64> {
        let [own, others] = [self, other].map(Self::bounds_m);
        let near = DVec3::splat(near_m);
        let low = own.0.max(others.0 - near);
        let high = own.1.min(others.1 + near);
        if low.cmpgt(high).any() {
            return None;
        }
        let bundles = Bundles::of(other);
        let direction = away_from(faces);
        let is_within = |place: DVec3| {
            let is_in_both_boxes = place.cmpge(low).all() && place.cmple(high).all();
            let is_inside = || has_inside && bundles.encloses(place, direction);
            is_in_both_boxes && (bundles.is_near(place, near_m) || is_inside())
        };
        let points = points(self, LOOKS);
        let within = points.iter().filter(|(_, place)| is_within(*place)).count();
        Some(within as f64 / points.len().max(1) as f64)
    }
}

/// Direction of rays that do not leave by a face at which the surface is open.
fn away_from(faces: &[BoxFace]) -> DVec3 {
    let mut direction = DIRECTION;
    for axis in 0..3 {
        let is_open = |upper: bool| faces.contains(&BoxFace { axis, upper });
        match (is_open(false), is_open(true)) {
            (true, true) => direction[axis] *= ACROSS,
            (false, true) => direction[axis] = -direction[axis],
            (_, false) => {}
        }
    }
    direction.normalize()
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::geometry::surfaces;

    const NEAR_M: f64 = 0.02;

    fn ball(radius_m: f64, middle_m: DVec3) -> Surface {
        let mut ball = surfaces::sphere(radius_m, 0.2 * radius_m);
        for place_m in &mut ball.positions_m {
            *place_m += middle_m;
        }
        ball
    }

    fn share(of: &Surface, other: &Surface) -> Option<f64> {
        of.share_within(other, true, &[], NEAR_M)
    }

    #[test]
    fn balls_at_one_place_are_one_in_the_other() {
        let one = ball(1.0, DVec3::ZERO);
        assert_eq!(share(&one, &one), Some(1.0));
        // With other triangles.
        let mut turned = one.clone();
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.4);
        for place_m in &mut turned.positions_m {
            *place_m = turn * *place_m;
        }
        assert_eq!(share(&one, &turned), Some(1.0));
    }

    /// A cap of half the radius has a quarter of a sphere's area.
    #[test]
    fn balls_that_overlap_share_a_cap() {
        let one = ball(1.0, DVec3::ZERO);
        let mut other = ball(1.0, DVec3::X);
        for _ in 0..2 {
            for share in [share(&one, &other), share(&other, &one)] {
                let share = share.unwrap();
                assert!((0.18..0.32).contains(&share), "{share}");
            }
            // Whichever way normals point.
            for triangle in &mut other.triangles {
                triangle.swap(1, 2);
            }
        }
    }

    #[test]
    fn balls_that_stand_apart_share_nothing() {
        let one = ball(1.0, DVec3::ZERO);
        assert_eq!(share(&one, &ball(1.0, 3.0 * DVec3::X)), None);
        // Their boxes meet.
        assert_eq!(share(&one, &ball(1.0, DVec3::splat(1.3))), Some(0.0));
    }

    #[test]
    fn one_inside_the_other() {
        let (large, small) = (ball(1.0, DVec3::ZERO), ball(0.3, DVec3::splat(0.2)));
        assert_eq!(share(&small, &large), Some(1.0));
        assert_eq!(share(&large, &small), Some(0.0));
        // A disk has no inside.
        let disk = surfaces::disk(0.5, 0.1);
        assert_eq!(share(&disk, &large), Some(1.0));
        assert_eq!(large.share_within(&disk, false, &[], NEAR_M), Some(0.0));
        assert_eq!(disk.share_within(&disk, false, &[], NEAR_M), Some(1.0));
    }

    /// What a face of the box cuts off is not where a body ends.
    #[test]
    fn bodies_that_pass_through_faces() {
        let size_m = DVec3::splat(4.0);
        for (upper, y) in [(false, 0.0), (true, 4.0)] {
            let faces = [BoxFace { axis: 1, upper }];
            let half = ball(1.0, DVec3::new(2.0, y, 2.0)).before(&faces, size_m);
            let towards = if upper { -0.4 } else { 0.4 };
            let small = ball(0.2, DVec3::new(2.0, y + towards, 2.0));
            let share = |of: &Surface| of.share_within(&half, true, &faces, NEAR_M);
            assert_eq!(share(&small), Some(1.0));
            let beside = ball(0.2, DVec3::new(2.9, y + 2.0 * towards, 2.9));
            assert_eq!(share(&beside), Some(0.0));
        }
        // A column through both sides.
        let faces = [false, true].map(|upper| BoxFace { axis: 2, upper });
        let mut column = surfaces::cylinder(1.0, 6.0, true, 0.2);
        for place_m in &mut column.positions_m {
            *place_m += 2.0;
        }
        let column = column.before(&faces, size_m);
        for z in [0.3, 2.0, 3.7] {
            let small = ball(0.2, DVec3::new(2.0, 2.0, z));
            let share = small.share_within(&column, true, &faces, NEAR_M);
            assert_eq!(share, Some(1.0), "{z}");
        }
    }
}
