//! The cells under the kernels of all markers, and the kernels.
//!
//! Work is confined to the bounding box of the markers. Cells are ordered by row (y + z · ny), then x, so that the four cells of a kernel's
//! row follow each other; no list of marker and cell pairs is needed. Every cell adds its markers in their order: spreading gives the same
//! bits on any number of threads.

use rayon::prelude::*;

use super::folds::Folds;
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
    /// Faces that a body passes through, at which kernels are folded; `None` where there are none.
    pub folds: Option<Folds>,
    /// Cells at faces that kernels keep off: those that a box of finer cells exchanges with the lattice around it.
    pub kept: usize,
}

impl From<[usize; 3]> for Domain {
    /// A domain that repeats along no axis, through whose faces no body passes.
    fn from(cells: [usize; 3]) -> Self {
        Self {
            cells,
            repeats: [false; 3],
            folds: None,
            kept: 0,
        }
    }
}

/// First cell of a box, and one past its last.
pub type CellBox = ([i64; 3], [i64; 3]);

/// The smallest box of cells (first, one past the last) that holds the kernels of all markers at `positions` [cells]; the whole domain
/// along an axis where a kernel reaches through a side that repeats; `None` without markers. Folded kernels lie in the domain.
pub fn bounding_box(
    positions: &[[f64; 3]],
    domain: Domain,
) -> Result<Option<CellBox>, OutOfDomain> {
    let bounds: [[f64; 2]; 3] = std::array::from_fn(|a| {
        let cells = domain.cells[a] as f64;
        let faces = [-0.5, cells - 0.5];
        if domain.repeats[a] {
            return faces;
        }
        let kept = domain.kept as f64;
        let mut bounds = [1.0 + kept, cells - 2.0 - kept];
        for (end, folded) in domain.folds.iter().flat_map(|f| f.at_ends(a)).enumerate() {
            if folded {
                bounds[end] = faces[end];
            }
        }
        bounds
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
        if domain.folds.is_some() && low[a] < 0 {
            (low[a], high[a]) = (0, high[a].max(WIDTH as i64));
        }
        if domain.folds.is_some() && high[a] > cells {
            (low[a], high[a]) = (low[a].min(cells - WIDTH as i64), cells);
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
        Self::of_axes(position.map(kernel::weights), low, size)
    }

    /// The same from first cells and weights along the axes.
    #[inline(always)]
    fn of_axes(axes: [(i64, [f64; WIDTH]); 3], low: [i64; 3], size: [usize; 3]) -> Self {
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

/// Where the component of a marker's vectors along the normal of a face has other weights than the others.
#[derive(Debug, Clone, Copy)]
struct NormalWeights {
    marker: u32,
    axis: u32,
    /// Its weights along `axis`, less those of the others.
    difference: [f64; WIDTH],
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
    /// At faces that a body passes through; empty without.
    normals: Vec<NormalWeights>,
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
        self.normals.clear();
        self.marks.clear();
        let Some((low, high)) = found else {
            return Ok(());
        };
        let size: [usize; 3] = std::array::from_fn(|a| (high[a] - low[a]) as usize);
        self.marks.resize(size[0] * size[1] * size[2], 0);
        self.numbers.resize(self.marks.len(), 0);
        match &domain.folds {
            None => positions
                .par_iter()
                .with_min_len(ALONE)
                .map(|position| Kernel::at(*position, low, size))
                .collect_into_vec(&mut self.kernels),
            Some(folds) => self.fold(positions, (domain.cells, folds), low, size),
        }
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

    /// Kernels of markers where some are folded at faces.
    fn fold(
        &mut self,
        positions: &[[f64; 3]],
        (cells, folds): ([usize; 3], &Folds),
        low: [i64; 3],
        size: [usize; 3],
    ) {
        for (marker, position) in positions.iter().enumerate() {
            let axes: [_; 3] =
                std::array::from_fn(|axis| folds.on_axis(axis, position[axis], cells[axis]));
            let plain = axes.map(|kernel| (kernel.first, kernel.weights));
            self.kernels.push(Kernel::of_axes(plain, low, size));
            for (axis, kernel) in axes.into_iter().enumerate() {
                if kernel.normal != kernel.weights {
                    let difference = std::array::from_fn(|i| kernel.normal[i] - kernel.weights[i]);
                    self.normals.push(NormalWeights {
                        marker: marker as u32,
                        axis: axis as u32,
                        difference,
                    });
                }
            }
        }
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

    /// The kernel with the weights by which a normal component differs.
    fn normal_kernel(&self, normal: &NormalWeights) -> Kernel {
        let mut kernel = self.kernels[normal.marker as usize];
        kernel.weights[normal.axis as usize] = normal.difference;
        kernel
    }

    /// What [`TouchedCells::interpolate`] of vectors leaves out at faces that a body passes through: (marker, component, to be added).
    pub fn interpolate_normals<'a, const N: usize>(
        &'a self,
        values: &'a [[f64; N]],
    ) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
        self.normals.iter().map(move |normal| {
            let axis = normal.axis as usize;
            let kernel = self.normal_kernel(normal);
            let mut sum = 0.0;
            for (row, &start) in kernel.rows.iter().enumerate() {
                let cells = &values[start as usize..start as usize + WIDTH];
                for (weight, value) in kernel.of_row(row).iter().zip(cells) {
                    sum += weight * value[axis];
                }
            }
            (normal.marker as usize, axis, sum)
        })
    }

    /// Adds what [`TouchedCells::spread`] of vectors leaves out there, marker by marker.
    pub fn spread_normals(&self, values: &[[f64; 3]], sums: &mut [[f64; 3]]) {
        for normal in &self.normals {
            let axis = normal.axis as usize;
            let kernel = self.normal_kernel(normal);
            let value = values[normal.marker as usize][axis];
            for (row, &start) in kernel.rows.iter().enumerate() {
                let cells = &mut sums[start as usize..start as usize + WIDTH];
                for (sum, weight) in cells.iter_mut().zip(kernel.of_row(row)) {
                    sum[axis] += weight * value;
                }
            }
        }
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
#[path = "touched_tests.rs"]
mod tests;
