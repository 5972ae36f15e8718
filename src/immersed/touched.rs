//! The cells under the kernels of all markers, and the kernels.
//!
//! Work is confined to the bounding box of the markers. Cells are ordered by row (y + z · ny), then x, so that the four cells of a kernel's
//! row follow each other; no list of marker and cell pairs is needed. Every cell adds its markers in their order: spreading gives the same
//! bits on any number of threads.

use rayon::prelude::*;

use super::kernel::{self, WIDTH};

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
    /// Axes along which the domain repeats, so that a kernel that leaves it on one side enters it on the other; never x.
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
    let bounds: [[f64; 2]; 3] = std::array::from_fn(|a| {
        let cells = domain.cells[a] as f64;
        if domain.repeats[a] {
            [-0.5, cells - 0.5]
        } else {
            [1.0, cells - 2.0]
        }
    });
    let mut least = [f64::INFINITY; 3];
    let mut greatest = [f64::NEG_INFINITY; 3];
    for (marker, position) in positions.iter().enumerate() {
        for a in 0..3 {
            // Not finite counts as outside.
            let inside = position[a] >= bounds[a][0] && position[a] < bounds[a][1];
            if !inside {
                return Err(OutOfDomain {
                    marker,
                    position: *position,
                });
            }
            if position[a] < least[a] {
                least[a] = position[a];
            }
            if position[a] > greatest[a] {
                greatest[a] = position[a];
            }
        }
    }
    let mut low = least.map(|place| place.floor() as i64 - 1);
    let mut high = greatest.map(|place| place.floor() as i64 + 3);
    for a in 0..3 {
        let cells = domain.cells[a] as i64;
        if domain.repeats[a] && (low[a] < 0 || high[a] > cells) {
            (low[a], high[a]) = (0, cells);
        }
    }
    Ok((!positions.is_empty()).then_some((low, high)))
}

/// Rows of cells under a marker's kernel.
const ROWS: usize = WIDTH * WIDTH;

/// Markers below which one thread works alone: waking others takes longer.
const ALONE: usize = 512;

/// A marker's kernel: where each of its rows begins among the touched cells, and its weights along the axes.
#[derive(Debug, Clone, Copy)]
struct Kernel {
    /// First touched cell of the rows z, y, y fastest; the other three of a row follow it.
    rows: [u32; ROWS],
    /// Weights along x, y, z.
    weights: [[f64; WIDTH]; 3],
}

impl Kernel {
    /// The kernel of a marker at `position` [cells]; its rows begin at slots of the box of cells that begins at `low`.
    fn at(position: [f64; 3], low: [i64; 3], size: [usize; 3]) -> Self {
        let axes = position.map(kernel::weights);
        let x = (axes[0].0 - low[0]) as usize;
        // Where the box is the whole domain, a kernel may go on at its other end.
        let [ys, zs]: [[usize; WIDTH]; 2] = [1, 2].map(|a| {
            let first = axes[a].0 - low[a];
            std::array::from_fn(|i| wrapped(first + i as i64, size[a]))
        });
        Self {
            rows: std::array::from_fn(|row| {
                (size[0] * (ys[row % WIDTH] + size[1] * zs[row / WIDTH]) + x) as u32
            }),
            weights: axes.map(|(_, weights)| weights),
        }
    }

    /// Weight of row `row` for each of its cells.
    #[inline(always)]
    fn of_row(&self, row: usize) -> [f64; WIDTH] {
        let weight = self.weights[2][row / WIDTH] * self.weights[1][row % WIDTH];
        self.weights[0].map(|along| weight * along)
    }
}

/// Place in a box whose ends meet, for one at most a box length away.
#[inline(always)]
fn wrapped(place: i64, size: usize) -> usize {
    let size = size as i64;
    let place = if place < 0 {
        place + size
    } else if place >= size {
        place - size
    } else {
        place
    };
    place as usize
}

/// Touched cells and the markers' kernels.
#[derive(Debug, Clone, Default)]
pub struct TouchedCells {
    /// Cells, ordered by row, then x.
    pub cells: Vec<[u32; 3]>,
    /// x of every cell (the collision reads it by itself).
    pub x: Vec<u32>,
    /// (row = y + z · ny, first cell, end), ascending rows.
    pub rows: Vec<(u32, u32, u32)>,
    /// `[marker_count]`
    kernels: Vec<Kernel>,
    /// True for the touched cells of the bounding box.
    marks: Vec<u8>,
    /// Number of every cell of the bounding box among the touched ones; not set elsewhere.
    numbers: Vec<u32>,
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
        self.cells.clear();
        self.x.clear();
        self.rows.clear();
        self.kernels.clear();
        self.marks.clear();
        let Some((low, high)) = found else {
            return Ok(());
        };
        let size: [usize; 3] = std::array::from_fn(|a| (high[a] - low[a]) as usize);
        self.marks.resize(size[0] * size[1] * size[2], 0);
        self.numbers.resize(self.marks.len(), 0);
        positions
            .par_iter()
            .with_min_len(ALONE)
            .map(|position| Kernel::at(*position, low, size))
            .collect_into_vec(&mut self.kernels);
        for kernel in &self.kernels {
            for &slot in &kernel.rows {
                self.marks[slot as usize..slot as usize + WIDTH].fill(1);
            }
        }
        self.number_cells(low, size, domain.cells[1]);
        let numbers = &self.numbers;
        self.kernels
            .par_iter_mut()
            .with_min_len(ALONE)
            .for_each(|kernel| kernel.rows = kernel.rows.map(|slot| numbers[slot as usize]));
        Ok(())
    }

    /// Gives the touched cells consecutive numbers.
    fn number_cells(&mut self, low: [i64; 3], size: [usize; 3], ny: usize) {
        for k in 0..size[2] {
            for j in 0..size[1] {
                let first = self.cells.len() as u32;
                let (y, z) = (low[1] + j as i64, low[2] + k as i64);
                let row = size[0] * (j + size[1] * k)..size[0] * (j + 1 + size[1] * k);
                let numbers = &mut self.numbers[row.clone()];
                for (i, (&mark, number)) in self.marks[row].iter().zip(numbers).enumerate() {
                    if mark != 0 {
                        let x = (low[0] + i as i64) as u32;
                        *number = self.cells.len() as u32;
                        self.cells.push([x, y as u32, z as u32]);
                        self.x.push(x);
                    }
                }
                let end = self.cells.len() as u32;
                if end > first {
                    self.rows
                        .push(((y as usize + z as usize * ny) as u32, first, end));
                }
            }
        }
    }

    /// Σ over cells of weight · value for one marker.
    #[must_use]
    #[inline]
    pub fn interpolate<const N: usize>(&self, marker: usize, values: &[[f64; N]]) -> [f64; N] {
        let kernel = &self.kernels[marker];
        let mut sum = [0.0; N];
        for (row, &start) in kernel.rows.iter().enumerate() {
            let start = start as usize;
            let weights = kernel.of_row(row);
            for (weight, value) in weights.iter().zip(&values[start..start + WIDTH]) {
                for n in 0..N {
                    sum[n] += weight * value[n];
                }
            }
        }
        sum
    }

    /// Σ over markers of weight · value for every cell, `[touched]`: every thread takes a range of cells, and every cell its markers in
    /// order, so that the bits do not depend on the number of threads.
    pub fn spread<const N: usize>(&self, values: &[[f64; N]], sums: &mut Vec<[f64; N]>) {
        sums.clear();
        sums.resize(self.cells.len(), [0.0; N]);
        let parts = if self.kernels.len() < ALONE {
            1
        } else {
            rayon::current_num_threads().max(1)
        };
        if parts == 1 {
            for (kernel, value) in self.kernels.iter().zip(values) {
                for (row, &start) in kernel.rows.iter().enumerate() {
                    let start = start as usize;
                    add_row(&mut sums[start..start + WIDTH], kernel.of_row(row), value);
                }
            }
            return;
        }
        let share = self.cells.len().div_ceil(parts);
        sums.par_chunks_mut(share)
            .enumerate()
            .for_each(|(part, sums)| {
                let (first, end) = (part * share, part * share + sums.len());
                for (kernel, value) in self.kernels.iter().zip(values) {
                    for (row, &start) in kernel.rows.iter().enumerate() {
                        let start = start as usize;
                        if start >= first && start + WIDTH <= end {
                            let cells = start - first..start - first + WIDTH;
                            add_row(&mut sums[cells], kernel.of_row(row), value);
                        } else if start + WIDTH > first && start < end {
                            // A row that reaches over the end of the range.
                            let weights = kernel.of_row(row);
                            for cell in start.max(first)..(start + WIDTH).min(end) {
                                for n in 0..N {
                                    sums[cell - first][n] += weights[cell - start] * value[n];
                                }
                            }
                        }
                    }
                }
            });
    }
}

/// Adds a marker's value to the cells of one row.
#[inline(always)]
fn add_row<const N: usize>(sums: &mut [[f64; N]], weights: [f64; WIDTH], value: &[f64; N]) {
    for (sum, weight) in sums.iter_mut().zip(weights) {
        for n in 0..N {
            sum[n] += weight * value[n];
        }
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
        let mut spread = Vec::new();
        touched.spread(&force, &mut spread);
        let right: f64 = spread.iter().zip(&field).map(|(s, f)| s[0] * f[0]).sum();
        assert!((left - right).abs() < 1e-12 * force.len() as f64);
        let total: f64 = spread.iter().map(|s| s[0]).sum();
        assert!((total - force.iter().map(|f| f[0]).sum::<f64>()).abs() < 1e-12);
    }

    /// However many threads share the cells, each gets the same sum of its markers, in their order.
    #[test]
    fn spreading_has_the_same_bits_on_any_number_of_threads() {
        let positions: Vec<[f64; 3]> = (0..5).flat_map(|_| positions()).collect();
        let force: Vec<[f64; 3]> = (0..positions.len())
            .map(|m| [(m as f64).cos(), (m as f64).sin(), 1.0 / (1.0 + m as f64)])
            .collect();
        let mut touched = TouchedCells::default();
        touched.rebuild(&positions, [24, 20, 18]).unwrap();
        let mut plain = vec![[0.0; 3]; touched.cells.len()];
        for (position, force) in positions.iter().zip(&force) {
            let axes = position.map(kernel::weights);
            for (sum, cell) in plain.iter_mut().zip(&touched.cells) {
                let at = |a: usize| {
                    usize::try_from(i64::from(cell[a]) - axes[a].0)
                        .ok()
                        .and_then(|i| axes[a].1.get(i))
                };
                if let (Some(x), Some(y), Some(z)) = (at(0), at(1), at(2)) {
                    for a in 0..3 {
                        sum[a] += z * y * x * force[a];
                    }
                }
            }
        }
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let mut sums = Vec::new();
            pool.install(|| touched.spread(&force, &mut sums));
            assert!(sums == plain, "{threads}");
        }
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
        let mut sums = Vec::new();
        touched.spread(&[[1.0]; 30], &mut sums);
        let (_, along) = kernel::weights(5.3);
        for (cell, place) in touched.cells.iter().enumerate() {
            let expected = along[place[0] as usize - 4];
            assert!((sums[cell][0] - expected).abs() < 1e-14);
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
