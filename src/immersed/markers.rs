//! Markers: quadrature points on the fabric's triangles, spaced by the lattice, not by the structural mesh.

/// Usual largest spacing of markers [cells].
pub const SPACING_CELLS: f64 = 1.0;

/// Spacings that a case may ask for [cells]: closer markers cost without a gain, a sheet with wider gaps lets air through
/// (`ripstop validate marker-spacing`).
pub const SPACING_RANGE_CELLS: [f64; 2] = [0.25, 1.5];

/// How far inside a closed rigid surface its markers stand [cells]. The kernel reaches two cells beyond a marker and makes a body act
/// larger than its surface of markers; calibrated with the drag of a sphere and a disk, see `docs/rigid-bodies.md` for the calibration.
pub const SURFACE_INSET_CELLS: f64 = 0.5;

/// How far inside the rim of an open rigid surface its outermost markers' triangles end [cells].
pub const RIM_INSET_CELLS: f64 = 0.65;

/// Rest size of a triangle, as far as markers care.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Area [m²].
    pub area_m2: f64,
    /// Longest edge [m].
    pub longest_edge_m: f64,
}

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

/// Parts per edge into which a triangle is divided, each part carrying one marker at its centroid, for markers at most `spacing_m` apart,
/// [`SPACING_CELLS`] cells as a rule. Centroids of equilateral
/// neighbours lie an edge over √3 apart; the longest edge decides, so that slivers are not undersampled along their length.
#[must_use]
pub fn subdivisions(extent: &Extent, spacing_m: f64) -> usize {
    let whole = extent.longest_edge_m / 3f64.sqrt();
    ((whole / spacing_m).ceil() as usize).max(1)
}

/// Number of markers that [`place`] would place.
#[must_use]
pub fn count(extents: impl Iterator<Item = Extent>, spacing_m: f64) -> u64 {
    extents.fold(0, |total, extent| {
        let n = subdivisions(&extent, spacing_m) as u64;
        total.saturating_add(n.saturating_mul(n))
    })
}

/// Places markers on triangles, at most `spacing_m` apart.
#[must_use]
pub fn place(extents: impl Iterator<Item = Extent>, spacing_m: f64) -> Vec<Marker> {
    let mut markers = Vec::new();
    for (triangle, extent) in extents.enumerate() {
        let n = subdivisions(&extent, spacing_m);
        let share = extent.area_m2 / (n * n) as f64;
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
        let extents =
            [(1.0, 1.5), (7.3, 4.0), (0.2, 0.7), (0.01, 5.0)].map(|(area_m2, longest_edge_m)| {
                Extent {
                    area_m2,
                    longest_edge_m,
                }
            });
        let markers = place(extents.into_iter(), 1.0);
        assert_eq!(markers.len() as u64, count(extents.into_iter(), 1.0));
        for (triangle, extent) in extents.iter().enumerate() {
            let own: Vec<_> = markers
                .iter()
                .filter(|m| m.triangle as usize == triangle)
                .collect();
            assert_eq!(own.len(), subdivisions(extent, 1.0).pow(2));
            let total: f64 = own.iter().map(|m| m.area_m2).sum();
            assert!((total - extent.area_m2).abs() < 1e-12);
            for corner in 0..3 {
                let share: f64 = own.iter().map(|m| m.area_m2 * m.weights[corner]).sum();
                assert!((share - extent.area_m2 / 3.0).abs() < 1e-12);
            }
        }
        // A sliver of 5 cells has markers no farther than a cell apart along its length.
        assert_eq!(subdivisions(&extents[3], 1.0), 3);
    }
}
