//! A hashed grid over boxes: which boxes come close to a given one.
//!
//! Every box is kept once, in the cell of its middle; cells are as wide as the largest box and the reach, so what is near lies in the
//! 27 cells around. Cells are hashed to buckets (Teschner et al. 2003); those that share a bucket are told apart by their coordinates.
//! Results come in the order of the boxes' numbers within a cell and of the cells, whatever the hash.

use glam::DVec3;

/// An axis-aligned box [m].
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    /// Around some points.
    #[must_use]
    pub fn around(points: &[DVec3]) -> Self {
        let mut extent = Self {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        for point in points {
            extent.low = extent.low.min(*point);
            extent.high = extent.high.max(*point);
        }
        extent
    }

    fn middle(&self) -> DVec3 {
        (self.low + self.high) * 0.5
    }

    /// True if the boxes are nearer than `reach` along every axis.
    #[must_use]
    pub fn is_near(&self, other: &Self, reach: f64) -> bool {
        (self.low - other.high)
            .max(other.low - self.high)
            .max_element()
            <= reach
    }

    /// Longest of its sides [m].
    #[must_use]
    pub fn longest_side(&self) -> f64 {
        (self.high - self.low).max_element()
    }
}

type Cell = [i32; 3];

/// The grid.
#[derive(Debug)]
pub struct Grid<'a> {
    extents: &'a [Extent],
    cell_size: f64,
    reach: f64,
    starts: Vec<u32>,
    entries: Vec<(Cell, u32)>,
    mask: u64,
}

impl<'a> Grid<'a> {
    /// For boxes that are looked for within `reach` of others, no longer than `largest_other` [m].
    #[must_use]
    pub fn new(extents: &'a [Extent], reach: f64, largest_other: f64) -> Self {
        let largest = extents.iter().map(Extent::longest_side).fold(0.0, f64::max);
        // Middles are at most half of either box and the reach apart; a little more for rounding.
        let cell_size = (0.5 * (largest + largest_other) + reach) * (1.0 + 1e-9);
        let buckets = (2 * extents.len()).next_power_of_two().max(2);
        let mask = buckets as u64 - 1;
        let mut grid = Self {
            extents,
            cell_size,
            reach,
            starts: vec![0; buckets + 1],
            entries: vec![([0; 3], 0); extents.len()],
            mask,
        };
        let cells: Vec<Cell> = extents.iter().map(|e| grid.cell(e.middle())).collect();
        for cell in &cells {
            let bucket = grid.bucket(*cell);
            grid.starts[bucket + 1] += 1;
        }
        for i in 0..buckets {
            grid.starts[i + 1] += grid.starts[i];
        }
        let mut next = grid.starts.clone();
        for (number, cell) in cells.into_iter().enumerate() {
            let slot = &mut next[grid.bucket(cell)];
            grid.entries[*slot as usize] = (cell, number as u32);
            *slot += 1;
        }
        grid
    }

    /// Cells so far away that they have no number are put into the last one, where they do no harm but to speed.
    fn cell(&self, point: DVec3) -> Cell {
        const FARTHEST: f64 = 1e9;
        (point / self.cell_size)
            .floor()
            .clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST))
            .as_ivec3()
            .to_array()
    }

    fn bucket(&self, [x, y, z]: Cell) -> usize {
        let mixed = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
            ^ (z as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
        ((mixed ^ (mixed >> 32)) & self.mask) as usize
    }

    /// Calls `found` with the number of every box within reach of `extent`.
    pub fn near(&self, extent: &Extent, mut found: impl FnMut(usize)) {
        let [x, y, z] = self.cell(extent.middle());
        for dz in -1..=1 {
            for dy in -1..=1 {
                for dx in -1..=1 {
                    let cell = [x + dx, y + dy, z + dz];
                    let bucket = self.bucket(cell);
                    let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
                    for &(own, number) in &self.entries[range] {
                        let number = number as usize;
                        if own == cell && self.extents[number].is_near(extent, self.reach) {
                            found(number);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all pairs, one by one.
    #[test]
    fn finds_what_is_near_and_nothing_twice() {
        let mut seed = 11u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let extents: Vec<Extent> = (0..300)
            .map(|_| {
                let a = DVec3::new(random(), random(), random());
                let b = a + DVec3::new(random(), random(), random()) * 0.1;
                Extent::around(&[a, b])
            })
            .collect();
        let largest = extents.iter().map(Extent::longest_side).fold(0.0, f64::max);
        for reach in [0.0, 0.05, 1.0] {
            let grid = Grid::new(&extents, reach, largest);
            for extent in &extents {
                let mut found = Vec::new();
                grid.near(extent, |n| found.push(n));
                found.sort_unstable();
                let expected: Vec<usize> = (0..extents.len())
                    .filter(|&n| extents[n].is_near(extent, reach))
                    .collect();
                assert_eq!(found, expected);
            }
        }
    }
}
