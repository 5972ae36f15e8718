//! Density and velocity read back from the populations, their sums, and the cells that stand out.

use std::cmp::Reverse;

use rayon::prelude::*;

use super::parameters::Region;
use super::read_back::SUMS;
use super::{Bound, Fluid};
use crate::gpu::error::DeviceError;
use crate::gpu::shaders::WORKGROUP;
use crate::lattice::DIRECTION_COUNT;
use crate::lattice::control_volume::{ControlVolume, MassMomentum};
use crate::lattice::grid::{CellState, Extremes};
use crate::lattice::start::{Stress, add_to_stress, less_equilibrium};

/// What the shader writes where no cell of a workgroup is finite.
const NO_CELL: u32 = u32::MAX;

impl Fluid {
    fn whole(&self) -> Region {
        self.region([0; 3], self.setup.cells)
    }

    fn region(&self, first: [usize; 3], end: [usize; 3]) -> Region {
        let size: [usize; 3] = std::array::from_fn(|a| end[a] - first[a]);
        let four = |v: [usize; 3]| [v[0] as u32, v[1] as u32, v[2] as u32, 0];
        Region {
            first_cell: four(first),
            size: four(size),
            count: size.iter().product::<usize>() as u32,
            ..Region::default()
        }
    }

    /// Cells that one submission may look at; looking costs at most half of what a step costs. Whole workgroups, so that the sums of
    /// `totals` are the same however they are cut.
    pub(super) fn cells_at_once(&self) -> u64 {
        let per_plane = self.setup.cells[0] as u64 * self.setup.cells[1] as u64;
        let cells = per_plane.saturating_mul(self.planes_at_once() as u64);
        let group = u64::from(WORKGROUP);
        (cells / group).max(1) * group
    }

    fn dispatch(
        &self,
        bound: &Bound,
        mut region: Region,
        threads: u64,
        label: &'static str,
    ) -> Result<(), DeviceError> {
        self.check_readable()?;
        region.at_once = threads as u32;
        self.device.write(&self.read_back.region, 0, &[region]);
        let mut commands = self.device.record(label);
        {
            let mut pass = commands.pass(label);
            bound.dispatch(&mut pass, self.device.workgroups(threads));
        }
        self.device.submit(commands);
        Ok(())
    }

    /// Density excess and bare velocity of every cell, x fastest, `[cell_count]`.
    pub fn macroscopic(&self) -> Result<Vec<(f32, [f32; 3])>, DeviceError> {
        let count = self.grid.cell_count() as u64;
        let mut result = Vec::with_capacity(count as usize);
        let mut offset = 0;
        while offset < count {
            let now = self.read_back.states_at_once.min(count - offset);
            let region = Region {
                offset: offset as u32,
                ..self.whole()
            };
            let bound = &self.read_back.macroscopic[usize::from(self.odd)];
            self.dispatch(bound, region, now, "macroscopic")?;
            let states: Vec<[f32; 4]> =
                self.device.read(&self.read_back.states, 0, now as usize)?;
            result.extend(states.iter().map(|s| (s[3], [s[0], s[1], s[2]])));
            offset += now;
        }
        Ok(result)
    }

    /// Stress of every cell beyond equilibrium, x fastest; worked out on the host, one array of populations after the other.
    pub fn stresses(&self) -> Result<Vec<Stress>, DeviceError> {
        let states = self.macroscopic()?;
        let mut stresses = vec![Stress::default(); states.len()];
        let [nx, ny, _] = self.grid.cells;
        let cell = |i: usize| [i % nx, i / nx % ny, i / nx / ny].map(|c| c as i64);
        for direction in 0..DIRECTION_COUNT {
            let (array, _) = self.grid.slot(0, direction, self.odd);
            let populations = self.read_stored(&self.populations[array], self.grid.total)?;
            stresses.par_iter_mut().enumerate().for_each(|(i, stress)| {
                let (_, element) = self
                    .grid
                    .slot(self.grid.index(cell(i)), direction, self.odd);
                add_to_stress(stress, direction, populations[element]);
            });
        }
        for (stress, (density_excess, velocity)) in stresses.iter_mut().zip(&states) {
            less_equilibrium(stress, f64::from(*density_excess), velocity.map(f64::from));
        }
        Ok(stresses)
    }

    /// Σ δρ, Σ f c and Σ ½ ρ u² of a box of cells.
    fn totals(&self, first: [usize; 3], end: [usize; 3]) -> Result<[f64; 5], DeviceError> {
        let region = self.region(first, end);
        let bound = &self.read_back.totals[usize::from(self.odd)];
        let mut total = [0.0; 5];
        let (count, at_once) = (u64::from(region.count), self.cells_at_once());
        for offset in (0..count).step_by(at_once as usize) {
            let threads = at_once.min(count - offset);
            let part = Region {
                offset: offset as u32,
                ..region
            };
            self.dispatch(bound, part, threads, "totals")?;
            let [x, y] = self.device.workgroups(threads);
            let groups = x as usize * y as usize;
            let sums: Vec<f32> =
                self.device
                    .read(&self.read_back.partial_sums, 0, SUMS * groups)?;
            for group in sums.chunks_exact(SUMS) {
                for k in 0..5 {
                    total[k] += f64::from(group[k]);
                }
            }
        }
        Ok(total)
    }

    /// Σ δρ and Σ ½ ρ u² of all cells.
    pub fn mass_and_energy(&self) -> Result<(f64, f64), DeviceError> {
        let total = self.totals([0; 3], self.setup.cells)?;
        Ok((total[0], total[4]))
    }

    /// Mass and momentum inside a box now.
    pub fn storage(&self, volume: &ControlVolume) -> Result<MassMomentum, DeviceError> {
        let total = self.totals(volume.first, volume.end)?;
        Ok(MassMomentum {
            mass_excess: total[0],
            momentum: [total[1], total[2], total[3]],
        })
    }

    /// What stands out among the cells from `first` to before `end`; `None` in an empty box.
    pub fn extremes(
        &self,
        first: [usize; 3],
        end: [usize; 3],
    ) -> Result<Option<Extremes>, DeviceError> {
        if (0..3).any(|a| end[a] <= first[a]) {
            return Ok(None);
        }
        let region = self.region(first, end);
        let bound = &self.read_back.extremes[usize::from(self.odd)];
        let (count, at_once) = (u64::from(region.count), self.cells_at_once());
        for offset in (0..count).step_by(at_once as usize) {
            let part = Region {
                offset: offset as u32,
                ..region
            };
            self.dispatch(bound, part, at_once.min(count - offset), "extremes")?;
        }
        let groups = count.div_ceil(u64::from(WORKGROUP)) as usize;
        let found: Vec<[[u32; 4]; 2]> =
            self.device.read(&self.read_back.partial_sums, 0, groups)?;
        let most = |of: usize| {
            let of_groups = found.iter().map(|group| group[of]);
            of_groups
                .filter(|[_, cell, ..]| *cell != NO_CELL)
                .max_by_key(|&[value, cell, ..]| (value, Reverse(cell)))
        };
        let state = |[_, cell, excess, square]: [u32; 4]| {
            let index = cell as usize;
            let [nx, ny, ..] = region.size.map(|n| n as usize);
            CellState {
                cell: [
                    first[0] + index % nx,
                    first[1] + index / nx % ny,
                    first[2] + index / nx / ny,
                ],
                density_excess: f32::from_bits(excess).into(),
                speed: f64::from(f32::from_bits(square)).sqrt(),
            }
        };
        Ok(most(1).map(|farthest| Extremes {
            fastest: most(0).map(state),
            farthest: state(farthest),
        }))
    }
}
