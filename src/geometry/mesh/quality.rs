//! How good a triangle mesh is.

use glam::DVec3;

/// Quality of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Smallest shape quality 4√3 A / Σ l², 1 for equilateral, 0 for degenerate triangles.
    pub smallest_shape: f64,
    /// Mean shape quality.
    pub mean_shape: f64,
    /// Shortest edge [m].
    pub shortest_edge_m: f64,
    /// Longest edge [m].
    pub longest_edge_m: f64,
}

/// Shape quality of one triangle, 4√3 A / Σ l².
#[must_use]
pub fn shape(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(c - a).length();
    let squares = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
    4.0 * 3f64.sqrt() * area / squares
}

/// Quality of all `triangles`; `None` for an empty mesh.
#[must_use]
pub fn measure(positions: &[DVec3], triangles: &[[u32; 3]]) -> Option<Quality> {
    let corners = |triangle: &[u32; 3]| triangle.map(|node| positions[node as usize]);
    measure_corners(triangles.iter().map(corners))
}

/// Quality of triangles given by their corners; `None` without any.
#[must_use]
pub fn measure_corners(triangles: impl ExactSizeIterator<Item = [DVec3; 3]>) -> Option<Quality> {
    let count = triangles.len();
    if count == 0 {
        return None;
    }
    let mut quality = Quality {
        smallest_shape: f64::INFINITY,
        mean_shape: 0.0,
        shortest_edge_m: f64::INFINITY,
        longest_edge_m: 0.0,
    };
    for corners in triangles {
        let value = shape(corners);
        quality.smallest_shape = quality.smallest_shape.min(value);
        quality.mean_shape += value / count as f64;
        for i in 0..3 {
            let length = corners[i].distance(corners[(i + 1) % 3]);
            quality.shortest_edge_m = quality.shortest_edge_m.min(length);
            quality.longest_edge_m = quality.longest_edge_m.max(length);
        }
    }
    Some(quality)
}
