//! Markers: quadrature points on the fabric's triangles, spaced by the lattice, not by the structural mesh.

/// Usual largest spacing of markers [cells].
pub const SPACING_CELLS: f64 = 1.0;

/// Spacings that a case may ask for [cells]: closer markers cost without a gain, a sheet with wider gaps lets air through
/// (`ripstop validate marker-spacing`).
pub const SPACING_RANGE_CELLS: [f64; 2] = [0.25, 1.5];

/// How far inside a closed rigid surface its markers stand [cells]. The kernel reaches two cells beyond a marker and makes a body act
/// larger than its surface of markers; calibrated with the drag of a sphere and a disk, see `docs/rigid-bodies.md` for the calibration.
pub const SURFACE_INSET_CELLS: f64 = 0.5;

/// How far inside the rim of an open surface, rigid or of fabric, its outermost markers' triangles end [cells].
pub const RIM_INSET_CELLS: f64 = 0.65;

/// The same along rims of openings narrower than three cells: widths [cells] and insets, straight between them. Calibrated so that square
/// holes pass what sharp-edged ones do (`ripstop validate openings`, which shows slots, too: those of one cell pass a third too little); a closed cut
/// stays closed.
const OPENING_INSETS: [[f64; 2]; 5] = [
    [0.0, 0.65],
    [0.5, 0.84],
    [1.0, 0.91],
    [2.0, 0.73],
    [3.0, RIM_INSET_CELLS],
];

/// How far inside the rim of an opening of the given width markers stand, all in cells.
#[must_use]
pub fn opening_inset_cells(width_cells: f64) -> f64 {
    for pair in OPENING_INSETS.windows(2) {
        let [[from, low], [to, high]] = [pair[0], pair[1]];
        if width_cells < to {
            return low + (high - low) * ((width_cells - from) / (to - from)).max(0.0);
        }
    }
    RIM_INSET_CELLS
}

/// Rest size of a triangle, as far as markers care.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Area [m²].
    pub area_m2: f64,
    /// Longest edge [m].
    pub longest_edge_m: f64,
    /// How far its corners lie inside the line, near the rims, on which markers end [m]; negative outside, infinite where it does not matter.
    pub rim_depths_m: [f64; 3],
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

/// Parts per edge beyond which the markers of a cut triangle are estimated from its area, not counted one by one.
const COUNTED_SUBDIVISIONS: u64 = 64;

/// Number of markers that [`place`] would place; within some per cent where a triangle that is cut carries thousands.
#[must_use]
pub fn count(extents: impl Iterator<Item = Extent>, spacing_m: f64) -> u64 {
    extents.fold(0, |total, extent| {
        let n = subdivisions(&extent, spacing_m) as u64;
        let own = if is_cut(&extent) && n > COUNTED_SUBDIVISIONS {
            let share = marked_share(std::iter::once(extent));
            (share * (n as f64).powi(2)) as u64
        } else if is_cut(&extent) {
            let mut count = 0;
            place_on(0, &extent, spacing_m, &mut |_| count += 1);
            count
        } else {
            n.saturating_mul(n)
        };
        total.saturating_add(own)
    })
}

/// Share of the area of triangles for which markers stand.
#[must_use]
pub fn marked_share(extents: impl Iterator<Item = Extent>) -> f64 {
    let (mut whole, mut marked) = (0.0, 0.0);
    for extent in extents {
        whole += extent.area_m2;
        if is_cut(&extent) {
            place_on(0, &extent, f64::INFINITY, &mut |marker| {
                marked += marker.area_m2;
            });
        } else {
            marked += extent.area_m2;
        }
    }
    marked / whole
}

/// Places markers on triangles, at most `spacing_m` apart, and none beyond the line near the rims on which they end: parts of triangles that lie across that line
/// are cut along it, and their marker stands at the centroid of what is left.
#[must_use]
pub fn place(extents: impl Iterator<Item = Extent>, spacing_m: f64) -> Vec<Marker> {
    let mut markers = Vec::new();
    for (triangle, extent) in extents.enumerate() {
        place_on(triangle as u32, &extent, spacing_m, &mut |marker| {
            markers.push(marker)
        });
    }
    markers
}

fn is_cut(extent: &Extent) -> bool {
    extent.rim_depths_m.iter().any(|d| *d < 0.0)
}

fn place_on(triangle: u32, extent: &Extent, spacing_m: f64, push: &mut impl FnMut(Marker)) {
    let n = subdivisions(extent, spacing_m);
    let share = extent.area_m2 / (n * n) as f64;
    let is_cut = is_cut(extent);
    // Distance from the line beyond which there are no markers.
    let inside_m = |[a, b]: [f64; 2]| {
        let [d0, d1, d2] = extent.rim_depths_m;
        (1.0 - a - b) * d0 + a * d1 + b * d2
    };
    let mut part = |centroid: [f64; 2], corners: [[usize; 2]; 3]| {
        let (mut at, mut area_m2) = (centroid.map(|c| c / n as f64), share);
        if is_cut {
            let corners = corners.map(|corner| corner.map(|c| c as f64 / n as f64));
            let Some((left, centroid)) = clipped(corners, corners.map(inside_m)) else {
                return;
            };
            at = centroid;
            area_m2 *= left;
        }
        let [a, b] = at;
        push(Marker {
            triangle,
            weights: [1.0 - a - b, a, b],
            area_m2,
        });
    };
    let thirds = |i: usize, j: usize, k: f64| [i as f64 + k / 3.0, j as f64 + k / 3.0];
    for i in 0..n {
        for j in 0..n - i {
            part(thirds(i, j, 1.0), [[i, j], [i + 1, j], [i, j + 1]]);
            if i + j + 1 < n {
                part(thirds(i, j, 2.0), [[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
            }
        }
    }
}

/// Share of a triangle's area where a linear function, given at its corners, is positive, and the centroid of that part; `None` without one.
fn clipped(corners: [[f64; 2]; 3], values: [f64; 3]) -> Option<(f64, [f64; 2])> {
    /// Smaller parts do not count: the fabric's weight would not notice them, the lists of markers would.
    const SMALLEST_SHARE: f64 = 1e-3;
    let mut polygon: Vec<[f64; 2]> = Vec::with_capacity(4);
    for k in 0..3 {
        let l = (k + 1) % 3;
        if values[k] >= 0.0 {
            polygon.push(corners[k]);
        }
        if (values[k] >= 0.0) != (values[l] >= 0.0) {
            let t = values[k] / (values[k] - values[l]);
            polygon.push([0, 1].map(|a| corners[k][a] + t * (corners[l][a] - corners[k][a])));
        }
    }
    let doubled =
        |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for k in 2..polygon.len() {
        let fan = [polygon[0], polygon[k - 1], polygon[k]];
        let own = doubled(fan);
        area += own;
        for a in 0..2 {
            moment[a] += own * (fan[0][a] + fan[1][a] + fan[2][a]) / 3.0;
        }
    }
    let share = area / doubled(corners);
    (share > SMALLEST_SHARE).then(|| (share, moment.map(|m| m / area)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_markers_are_estimated() {
        let cut = Extent {
            area_m2: 1.0,
            longest_edge_m: 1.5,
            rim_depths_m: [-0.3, 0.4, 0.6],
        };
        for n in [65.0, 200.0] {
            let spacing_m = 1.5 / 3f64.sqrt() / n;
            let estimated = count(std::iter::once(cut), spacing_m) as f64;
            let placed = place(std::iter::once(cut), spacing_m).len() as f64;
            assert!(
                (estimated / placed - 1.0).abs() < 0.05,
                "{estimated} {placed}"
            );
        }
        // Counted one by one, this would not end.
        assert!(count(std::iter::once(cut), 1e-9) > 1_000_000_000_000_000);
    }

    #[test]
    fn markers_integrate_linear_functions_exactly() {
        let extents =
            [(1.0, 1.5), (7.3, 4.0), (0.2, 0.7), (0.01, 5.0)].map(|(area_m2, longest_edge_m)| {
                Extent {
                    area_m2,
                    longest_edge_m,
                    rim_depths_m: [f64::INFINITY; 3],
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

    /// Markers of a triangle with one side on a rim stand for just what lies farther inside, with its centroid, whatever the division.
    #[test]
    fn markers_near_a_rim_stand_for_what_lies_inside() {
        for spacing in [0.3, 0.7, 5.0] {
            for inset in [0.0, 0.2, 0.65, 0.9] {
                // Corner 2 is one unit from the rim, where the others are.
                let extent = Extent {
                    area_m2: 2.0,
                    longest_edge_m: 4.0,
                    rim_depths_m: [-inset, -inset, 1.0 - inset],
                };
                let markers = place([extent].into_iter(), spacing);
                assert_eq!(markers.len() as u64, count([extent].into_iter(), spacing));
                let sum = |of: &dyn Fn(&Marker) -> f64| -> f64 {
                    markers.iter().map(|m| m.area_m2 * of(m)).sum()
                };
                let left = (1.0 - inset) * (1.0 - inset);
                // Parts of less than a thousandth of their triangle are left out.
                let off = 1e-3 * 2.0;
                assert!(
                    (sum(&|_| 1.0) - 2.0 * left).abs() < off,
                    "{spacing} {inset}"
                );
                let height = inset + (1.0 - inset) / 3.0;
                assert!((sum(&|m| m.weights[2]) - 2.0 * left * height).abs() < off);
                assert!(markers.iter().all(|m| m.weights[2] >= inset));
            }
        }
        let outside = Extent {
            area_m2: 1.0,
            longest_edge_m: 1.0,
            rim_depths_m: [-0.65, -0.55, -0.05],
        };
        assert!(place([outside].into_iter(), 1.0).is_empty());
    }
}
