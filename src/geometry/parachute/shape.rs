//! Shape of a canopy: projected area and diameter, height.

use std::f64::consts::PI;

use glam::DVec3;

/// Samples along the longer side of the projection.
pub const RESOLUTION: usize = 256;

/// Area of the shadow that triangles throw along x [m²], counted on a fine grid (error about 0.2 % for a canopy).
#[must_use]
pub fn projected_area_m2(
    positions_m: &[DVec3],
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
) -> f64 {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for node in triangles.clone().flatten() {
        let p = positions_m[node as usize];
        for (a, value) in [p.y, p.z].into_iter().enumerate() {
            if !value.is_finite() {
                return f64::NAN;
            }
            low[a] = low[a].min(value);
            high[a] = high[a].max(value);
        }
    }
    let pitch = (high[0] - low[0]).max(high[1] - low[1]) / RESOLUTION as f64;
    if !(pitch > 0.0 && pitch.is_finite()) {
        return 0.0;
    }
    let counts = [0, 1].map(|a| ((high[a] - low[a]) / pitch).ceil() as usize + 1);
    let mut covered = vec![false; counts[0] * counts[1]];
    for triangle in triangles {
        let corners = triangle.map(|node| {
            let p = positions_m[node as usize];
            [(p.y - low[0]) / pitch, (p.z - low[1]) / pitch]
        });
        cover(&corners, &counts, &mut covered);
    }
    covered.iter().filter(|&&c| c).count() as f64 * pitch * pitch
}

/// Marks the sample points, at half-integer places, inside a triangle.
fn cover(corners: &[[f64; 2]; 3], counts: &[usize; 2], covered: &mut [bool]) {
    let bottom = corners.iter().map(|c| c[1]).fold(f64::INFINITY, f64::min);
    let top = corners
        .iter()
        .map(|c| c[1])
        .fold(f64::NEG_INFINITY, f64::max);
    let first = (bottom - 0.5).ceil().max(0.0) as usize;
    let last = ((top - 0.5).floor()).min(counts[1] as f64 - 1.0);
    if last < 0.0 {
        return;
    }
    for row in first..=last as usize {
        let height = row as f64 + 0.5;
        let mut left = f64::INFINITY;
        let mut right = f64::NEG_INFINITY;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if (a[1] <= height) != (b[1] <= height) {
                let x = a[0] + (height - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
                left = left.min(x);
                right = right.max(x);
            }
        }
        if left > right {
            continue;
        }
        let from = (left - 0.5).ceil().max(0.0) as usize;
        let to = (right - 0.5).floor().min(counts[0] as f64 - 1.0);
        if to >= 0.0 {
            for column in from..=to as usize {
                covered[row * counts[0] + column] = true;
            }
        }
    }
}

/// Diameter of the disk with the projected area [m].
#[must_use]
pub fn projected_diameter_m(
    positions_m: &[DVec3],
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
) -> f64 {
    (4.0 * projected_area_m2(positions_m, triangles) / PI).sqrt()
}

/// Extent along x [m].
#[must_use]
pub fn height_m(positions_m: &[DVec3]) -> f64 {
    let (low, high) = positions_m
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(p.x), high.max(p.x))
        });
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::parachute::{folding, gores};

    #[test]
    fn the_flat_and_the_folded_pattern_have_their_known_areas() {
        let pattern = gores::FlatCircular {
            nominal_area_m2: 0.78,
            gores: 8,
            rings: 12,
        };
        let mesh = gores::mesh(&pattern);
        let triangles = mesh.triangles.iter().copied();
        let flat = projected_area_m2(&mesh.flat_positions_m, triangles.clone());
        assert!((flat / 0.78 - 1.0).abs() < 3e-3, "{flat}");
        let folded = folding::pleated_cone(&pattern, &mesh, 0.4).unwrap();
        let ratio = projected_diameter_m(&folded, triangles) / pattern.nominal_diameter_m();
        assert!((ratio - 0.4).abs() < 0.01, "{ratio}");
    }

    /// Two layers over each other count once.
    #[test]
    fn overlapping_layers_count_once() {
        let square = |x: f64| {
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[y, z]| DVec3::new(x, y, z))
        };
        let positions: Vec<DVec3> = square(0.0).into_iter().chain(square(1.0)).collect();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let area = projected_area_m2(&positions, triangles.into_iter());
        assert!((area - 1.0).abs() < 0.01, "{area}");
        assert_eq!(height_m(&positions), 1.0);
    }
}
