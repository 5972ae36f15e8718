//! Markers: quadrature points on the fabric's triangles, spaced by the lattice, not by the structural mesh.

/// Markers farther apart than this let air through [cells].
pub const SPACING_LIMIT_CELLS: f64 = 1.5;

/// Spacing aimed at [cells].
pub const SPACING_TARGET_CELLS: f64 = 1.0;

/// One marker on a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric weights of its nodes.
    pub weights: [f64; 3],
    /// Rest area it stands for [m²].
    pub area_m2: f64,
}

/// Parts per edge into which a triangle of `area_m2` is divided, each part carrying one marker at its centroid.
#[must_use]
pub fn subdivisions(area_m2: f64, cell_size_m: f64) -> usize {
    ((area_m2.sqrt() / (SPACING_TARGET_CELLS * cell_size_m)).ceil() as usize).max(1)
}

/// Places markers on triangles of the given rest areas [m²].
#[must_use]
pub fn place(areas_m2: &[f64], cell_size_m: f64) -> Vec<Marker> {
    let mut markers = Vec::new();
    for (triangle, &area_m2) in areas_m2.iter().enumerate() {
        let n = subdivisions(area_m2, cell_size_m);
        let share = area_m2 / (n * n) as f64;
        let mut push = |i: f64, j: f64| {
            let (a, b) = (i / n as f64, j / n as f64);
            markers.push(Marker {
                triangle: triangle as u32,
                weights: [1.0 - a - b, a, b],
                area_m2: share,
            });
        };
        for i in 0..n {
            for j in 0..n - i {
                push(i as f64 + 1.0 / 3.0, j as f64 + 1.0 / 3.0);
                if i + j + 1 < n {
                    push(i as f64 + 2.0 / 3.0, j as f64 + 2.0 / 3.0);
                }
            }
        }
    }
    markers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_integrate_linear_functions_exactly() {
        let areas = [1.0, 7.3, 0.2];
        let markers = place(&areas, 1.0);
        for (triangle, area) in areas.iter().enumerate() {
            let own: Vec<_> = markers
                .iter()
                .filter(|m| m.triangle as usize == triangle)
                .collect();
            assert_eq!(own.len(), subdivisions(*area, 1.0).pow(2));
            let total: f64 = own.iter().map(|m| m.area_m2).sum();
            assert!((total - area).abs() < 1e-12);
            for corner in 0..3 {
                let share: f64 = own.iter().map(|m| m.area_m2 * m.weights[corner]).sum();
                assert!((share - area / 3.0).abs() < 1e-12);
            }
        }
    }
}
