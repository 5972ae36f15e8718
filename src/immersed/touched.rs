//! The cells under the kernels of all markers, with the entries that a gather per cell needs.
//!
//! Work is confined to the bounding box of the markers. Cells are ordered by row (y + z · ny), then x; the entries of a cell
//! by marker: sums over them have one order, so spreading gives the same bits on any number of threads.

use super::kernel::{self, WIDTH};

/// Cells under one marker.
const SUPPORT: usize = WIDTH * WIDTH * WIDTH;

/// A marker whose kernel reaches out of the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfDomain {
    /// Index of the marker.
    pub marker: usize,
    /// Its position [cells, cell centres at whole numbers].
    pub position: [f64; 3],
}

/// The cells that markers may touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Domain {
    /// Cells along x, y, z.
    pub cells: [usize; 3],
    /// Axes along which the domain repeats, so that a kernel that leaves it on one side enters it on the other.
    pub repeats: [bool; 3],
}

impl From<[usize; 3]> for Domain {
    /// A domain that repeats along no axis.
    fn from(cells: [usize; 3]) -> Self {
        Self {
            cells,
            repeats: [false; 3],
        }
    }
}

/// First cell of a box, and one past its last.
pub type CellBox = ([i64; 3], [i64; 3]);

/// The smallest box of cells (first, one past the last) that holds the kernels of all markers at `positions` [cells]; the whole domain
/// along an axis where a kernel reaches through a side that repeats; `None` without markers.
pub fn bounding_box(
    positions: &[[f64; 3]],
    domain: Domain,
) -> Result<Option<CellBox>, OutOfDomain> {
    let mut low = [i64::MAX; 3];
    let mut high = [i64::MIN; 3];
    for (marker, position) in positions.iter().enumerate() {
        for a in 0..3 {
            // Not finite counts as outside.
            let cells = domain.cells[a] as f64;
            let [least, end] = if domain.repeats[a] {
                [-0.5, cells - 0.5]
            } else {
                [1.0, cells - 2.0]
            };
            let inside = position[a] >= least && position[a] < end;
            if !inside {
                return Err(OutOfDomain {
                    marker,
                    position: *position,
                });
            }
            let floor = position[a].floor() as i64;
            low[a] = low[a].min(floor - 1);
            high[a] = high[a].max(floor + 3);
        }
    }
    for a in 0..3 {
        let cells = domain.cells[a] as i64;
        if domain.repeats[a] && (low[a] < 0 || high[a] > cells) {
            (low[a], high[a]) = (0, cells);
        }
    }
    Ok((!positions.is_empty()).then_some((low, high)))
}

/// Touched cells and the marker–cell weights.
#[derive(Debug, Clone, Default)]
pub struct TouchedCells {
    /// Cells, ordered by row, then x.
    pub cells: Vec<[u32; 3]>,
    /// x of every cell (the collision reads it by itself).
    pub x: Vec<u32>,
    /// (row = y + z · ny, first cell, end), ascending rows.
    pub rows: Vec<(u32, u32, u32)>,
    /// First entry of every cell, and the end.
    cell_entries: Vec<u32>,
    /// Marker of every entry.
    entry_markers: Vec<u32>,
    /// Weight of every entry.
    entry_weights: Vec<f64>,
    /// Cell index of every marker's 64 kernel points, `[marker][point]`.
    marker_cells: Vec<u32>,
    /// Weights in the same order.
    marker_weights: Vec<f64>,
    box_map: Vec<u32>,
}

impl TouchedCells {
    /// Rebuilds the lists for markers at `positions` [cells] in a domain.
    pub fn rebuild(
        &mut self,
        positions: &[[f64; 3]],
        domain: impl Into<Domain>,
    ) -> Result<(), OutOfDomain> {
        let domain = domain.into();
        let found = bounding_box(positions, domain)?;
        self.clear();
        let Some((low, high)) = found else {
            return Ok(());
        };
        let size: [usize; 3] = std::array::from_fn(|a| (high[a] - low[a]) as usize);
        self.box_map.resize(size[0] * size[1] * size[2], 0);
        self.marker_cells.resize(positions.len() * SUPPORT, 0);
        self.marker_weights.resize(positions.len() * SUPPORT, 0.0);
        for (marker, position) in positions.iter().enumerate() {
            let axes = position.map(kernel::weights);
            // Where the box is the whole domain, a kernel may go on at its other end.
            let [xs, ys, zs]: [[usize; WIDTH]; 3] = std::array::from_fn(|a| {
                let first = axes[a].0 - low[a];
                std::array::from_fn(|i| (first + i as i64).rem_euclid(size[a] as i64) as usize)
            });
            let mut point = marker * SUPPORT;
            for k in 0..WIDTH {
                for j in 0..WIDTH {
                    let weight = axes[2].1[k] * axes[1].1[j];
                    let row = size[0] * (ys[j] + size[1] * zs[k]);
                    for i in 0..WIDTH {
                        self.box_map[row + xs[i]] += 1;
                        self.marker_cells[point] = (row + xs[i]) as u32;
                        self.marker_weights[point] = weight * axes[0].1[i];
                        point += 1;
                    }
                }
            }
        }
        self.number_cells(low, size, domain.cells[1]);
        self.sort_entries();
        Ok(())
    }

    fn clear(&mut self) {
        self.cells.clear();
        self.x.clear();
        self.rows.clear();
        self.cell_entries.clear();
        self.entry_markers.clear();
        self.entry_weights.clear();
        self.marker_cells.clear();
        self.marker_weights.clear();
        self.box_map.clear();
    }

    /// Turns counts per box cell into consecutive cell numbers and prefix sums.
    fn number_cells(&mut self, low: [i64; 3], size: [usize; 3], ny: usize) {
        let mut entries = 0;
        let mut slot = 0;
        for k in 0..size[2] {
            for j in 0..size[1] {
                let first = self.cells.len() as u32;
                let (y, z) = (low[1] + j as i64, low[2] + k as i64);
                for i in 0..size[0] {
                    let count = self.box_map[slot];
                    if count > 0 {
                        let x = (low[0] + i as i64) as u32;
                        self.box_map[slot] = self.cells.len() as u32;
                        self.cells.push([x, y as u32, z as u32]);
                        self.x.push(x);
                        self.cell_entries.push(entries);
                        entries += count;
                    }
                    slot += 1;
                }
                let end = self.cells.len() as u32;
                if end > first {
                    self.rows
                        .push(((y as usize + z as usize * ny) as u32, first, end));
                }
            }
        }
        self.cell_entries.push(entries);
    }

    /// Counting sort of marker–cell entries by cell, keeping the order of markers.
    fn sort_entries(&mut self) {
        let total = self.marker_cells.len();
        self.entry_markers.resize(total, 0);
        self.entry_weights.resize(total, 0.0);
        let mut next = self.cell_entries.clone();
        for point in 0..total {
            let cell = self.box_map[self.marker_cells[point] as usize];
            self.marker_cells[point] = cell;
            let entry = &mut next[cell as usize];
            self.entry_markers[*entry as usize] = (point / SUPPORT) as u32;
            self.entry_weights[*entry as usize] = self.marker_weights[point];
            *entry += 1;
        }
    }

    /// Σ over cells of weight · value for one marker.
    #[must_use]
    pub fn interpolate<const N: usize>(&self, marker: usize, values: &[[f64; N]]) -> [f64; N] {
        let range = marker * SUPPORT..(marker + 1) * SUPPORT;
        let mut sum = [0.0; N];
        for (&cell, &weight) in self.marker_cells[range.clone()]
            .iter()
            .zip(&self.marker_weights[range])
        {
            for n in 0..N {
                sum[n] += weight * values[cell as usize][n];
            }
        }
        sum
    }

    /// Σ over markers of weight · value for one cell.
    #[must_use]
    pub fn spread<const N: usize>(&self, cell: usize, values: &[[f64; N]]) -> [f64; N] {
        let range = self.cell_entries[cell] as usize..self.cell_entries[cell + 1] as usize;
        let mut sum = [0.0; N];
        for (&marker, &weight) in self.entry_markers[range.clone()]
            .iter()
            .zip(&self.entry_weights[range])
        {
            for n in 0..N {
                sum[n] += weight * values[marker as usize][n];
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions() -> Vec<[f64; 3]> {
        (0..200)
            .map(|k| {
                let t = f64::from(k) * 0.37;
                [
                    10.0 + 4.0 * t.sin(),
                    9.0 + 3.0 * (1.7 * t).cos(),
                    8.0 + 0.01 * t,
                ]
            })
            .collect()
    }

    /// ⟨S u, F⟩ = ⟨u, S* F⟩ and total spread force = total force.
    #[test]
    fn interpolation_and_spreading_are_adjoint() {
        let positions = positions();
        let mut touched = TouchedCells::default();
        touched.rebuild(&positions, [24, 20, 18]).unwrap();
        let field: Vec<[f64; 1]> = touched
            .cells
            .iter()
            .map(|c| [f64::from(c[0] * 7 + c[1] * 3 + c[2]).sin()])
            .collect();
        let force: Vec<[f64; 1]> = (0..positions.len()).map(|m| [(m as f64).cos()]).collect();
        let left: f64 = (0..positions.len())
            .map(|m| touched.interpolate(m, &field)[0] * force[m][0])
            .sum();
        let spread: Vec<f64> = (0..touched.cells.len())
            .map(|c| touched.spread(c, &force)[0])
            .collect();
        let right: f64 = spread.iter().zip(&field).map(|(s, f)| s * f[0]).sum();
        assert!((left - right).abs() < 1e-12 * force.len() as f64);
        let total: f64 = spread.iter().sum();
        assert!((total - force.iter().map(|f| f[0]).sum::<f64>()).abs() < 1e-12);
    }

    #[test]
    fn linear_fields_are_interpolated_exactly() {
        let positions = positions();
        let mut touched = TouchedCells::default();
        touched.rebuild(&positions, [24, 20, 18]).unwrap();
        let field: Vec<[f64; 3]> = touched.cells.iter().map(|c| c.map(f64::from)).collect();
        for (m, position) in positions.iter().enumerate() {
            let value = touched.interpolate(m, &field);
            for a in 0..3 {
                assert!((value[a] - position[a]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn rows_are_ordered_and_cover_all_cells() {
        let mut touched = TouchedCells::default();
        touched.rebuild(&positions(), [24, 20, 18]).unwrap();
        let mut covered = 0;
        for (row, first, end) in &touched.rows {
            assert_eq!(*first, covered);
            covered = *end;
            for c in *first..*end {
                let [_, y, z] = touched.cells[c as usize];
                assert_eq!(y + z * 20, *row);
            }
        }
        assert_eq!(covered as usize, touched.cells.len());
        assert!(touched.rows.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    /// Through a side that repeats, a sheet of markers one cell apart covers every cell alike.
    #[test]
    fn kernels_go_on_through_sides_that_repeat() {
        let domain = Domain {
            cells: [12, 6, 5],
            repeats: [false, true, true],
        };
        let positions: Vec<[f64; 3]> = (0..30)
            .map(|i| [5.3, f64::from(i % 6) - 0.2, f64::from(i / 6) - 0.4])
            .collect();
        let mut touched = TouchedCells::default();
        touched.rebuild(&positions, domain).unwrap();
        assert_eq!(touched.cells.len(), 4 * 30);
        let ones = vec![[1.0]; 30];
        let (_, along) = kernel::weights(5.3);
        for (cell, place) in touched.cells.iter().enumerate() {
            let expected = along[place[0] as usize - 4];
            assert!((touched.spread(cell, &ones)[0] - expected).abs() < 1e-14);
        }
        assert!(touched.rebuild(&[[5.3, 5.6, 1.0]], domain).is_err());
    }

    #[test]
    fn markers_near_the_border_are_reported() {
        let mut touched = TouchedCells::default();
        let error = touched
            .rebuild(&[[5.0, 5.0, 5.0], [0.5, 5.0, 5.0]], [10, 10, 10])
            .unwrap_err();
        assert_eq!(error.marker, 1);
        assert!(
            touched
                .rebuild(&[[f64::NAN, 5.0, 5.0]], [10, 10, 10])
                .is_err()
        );
    }
}
