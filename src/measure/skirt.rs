//! Geometry of a canopy's borders: wrinkles of the skirt, distances across it, width of slots and gaps.
//!
//! A wrinkle is the piece of the skirt between two neighbouring lines. Its height is the largest distance of a node from the chord
//! between the two attachments; with that node as its middle, its radius is that of the circle through the three points, and its
//! angle the one at the middle between them (after the read-outs of system P1 in `docs/papers.md`; the paper shows them in a figure only).

use glam::DVec3;

/// One wrinkle of the skirt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wrinkle {
    /// Distance of its middle from the chord [m].
    pub height_m: f64,
    /// One over the radius of the circle through both ends and the middle [1/m]; 0 where they are in line.
    pub curvature_1_m: f64,
    /// Angle at the middle between the ends [°].
    pub angle_deg: f64,
}

/// The wrinkle between the first and the last of `points`; `None` with fewer than three points, or ends that coincide.
pub(super) fn wrinkle(points: &[DVec3]) -> Option<Wrinkle> {
    let (&first, inner) = points.split_first()?;
    let (&last, inner) = inner.split_last()?;
    let along = (last - first).try_normalize()?;
    let height = |p: &DVec3| {
        let arm = *p - first;
        (arm - along * arm.dot(along)).length()
    };
    let middle = inner
        .iter()
        .copied()
        .max_by(|a, b| height(a).total_cmp(&height(b)))?;
    let [a, b] = [first - middle, last - middle];
    let sides = a.length() * b.length() * first.distance(last);
    let twice_area = a.cross(b).length();
    Some(Wrinkle {
        height_m: height(&middle),
        curvature_1_m: if sides > 0.0 {
            2.0 * twice_area / sides
        } else {
            0.0
        },
        angle_deg: a.angle_between(b).to_degrees(),
    })
}

/// Mean distance of points from their mean [m].
pub(super) fn mean_radius_m(points: &[DVec3]) -> f64 {
    let count = points.len() as f64;
    let centre = points.iter().copied().sum::<DVec3>() / count;
    points.iter().map(|p| p.distance(centre)).sum::<f64>() / count
}

/// Width of a narrow slot from its closed border [m]: enclosed area over half the perimeter, exact for a thin rectangle.
pub(super) fn slot_width_m(border: &[DVec3]) -> f64 {
    let Some(&origin) = border.first() else {
        return f64::NAN;
    };
    let pairs = || {
        border
            .iter()
            .zip(border.iter().cycle().skip(1))
            .map(|(a, b)| (*a - origin, *b - origin))
    };
    let area = 0.5 * pairs().map(|(a, b)| a.cross(b)).sum::<DVec3>().length();
    let perimeter: f64 = pairs().map(|(a, b)| a.distance(b)).sum();
    if perimeter > 0.0 {
        2.0 * area / perimeter
    } else {
        0.0
    }
}

/// Mean distance of the points of one border from the closed line through the other [m].
pub(super) fn gap_width_m(one: &[DVec3], other: &[DVec3]) -> f64 {
    let nearest = |p: DVec3| {
        let segments = other.iter().zip(other.iter().cycle().skip(1));
        segments
            .map(|(&a, &b)| {
                let along = b - a;
                let share = if along.length_squared() > 0.0 {
                    ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                p.distance(a + along * share)
            })
            .fold(f64::INFINITY, f64::min)
    };
    one.iter().map(|&p| nearest(p)).sum::<f64>() / one.len() as f64
}

/// Mean difference of opposite entries over the mean of all; NaN for an odd number of entries, or a mean of zero.
pub(super) fn asymmetry(values: &[f64]) -> f64 {
    let half = values.len() / 2;
    if half == 0 || 2 * half != values.len() {
        return f64::NAN;
    }
    let difference: f64 = (0..half)
        .map(|k| (values[k] - values[k + half]).abs())
        .sum();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    if mean == 0.0 {
        f64::NAN
    } else {
        difference / half as f64 / mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9 * b.abs().max(1.0)
    }

    /// An arc of radius 0.3 m that opens over 2 × 40°, in an oblique plane.
    #[test]
    fn an_arc_has_its_radius_height_and_angle() {
        let half = 40_f64.to_radians();
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1);
        let points: Vec<DVec3> = (-8..=8)
            .map(|k| {
                let angle = half * f64::from(k) / 8.0;
                turn * DVec3::new(0.3 * angle.sin(), 0.3 * angle.cos(), 0.0) + DVec3::splat(2.0)
            })
            .collect();
        let found = wrinkle(&points).unwrap();
        assert!(near(1.0 / found.curvature_1_m, 0.3), "{found:?}");
        assert!(near(found.height_m, 0.3 * (1.0 - half.cos())), "{found:?}");
        // Inscribed angle over the major arc: half of 360° − 80°.
        assert!(near(found.angle_deg, 140.0), "{found:?}");
        let flat: Vec<DVec3> = (0..5).map(|k| DVec3::X * f64::from(k)).collect();
        let flat = wrinkle(&flat).unwrap();
        assert_eq!((flat.height_m, flat.curvature_1_m), (0.0, 0.0));
        assert!((flat.angle_deg - 180.0).abs() < 1e-5);
        assert_eq!(wrinkle(&points[..2]), None);
    }

    #[test]
    fn widths_of_slots_and_gaps() {
        // A slot of 1 m by 2 mm with nodes all along.
        let mut border: Vec<DVec3> = (0..=20).map(|k| DVec3::X * 0.05 * f64::from(k)).collect();
        border.extend(
            (0..=20)
                .rev()
                .map(|k| DVec3::new(0.05 * f64::from(k), 0.0, 2e-3)),
        );
        assert!((slot_width_m(&border) / 2e-3 - 1.0).abs() < 3e-3);
        // Not opened yet: both sides coincide.
        let closed: Vec<DVec3> = border.iter().map(|p| DVec3::X * p.x).collect();
        assert_eq!(slot_width_m(&closed), 0.0);
        let circle = |radius: f64, count: u32| -> Vec<DVec3> {
            (0..count)
                .map(|k| {
                    let angle = TAU * f64::from(k) / f64::from(count);
                    DVec3::new(0.0, radius * angle.cos(), radius * angle.sin())
                })
                .collect()
        };
        let width = gap_width_m(&circle(1.0, 96), &circle(1.1, 480));
        assert!((width - 0.1).abs() < 1e-4, "{width}");
        assert!(near(mean_radius_m(&circle(0.25, 17)), 0.25));
    }

    #[test]
    fn asymmetry_compares_opposite_entries() {
        assert!(near(asymmetry(&[1.0, 2.0, 1.0, 2.0]), 0.0));
        assert!(near(asymmetry(&[1.0, 2.0, 3.0, 2.0]), 0.5));
        assert!(asymmetry(&[1.0, 2.0, 3.0]).is_nan());
    }
}
