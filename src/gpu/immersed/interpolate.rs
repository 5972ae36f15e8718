//! Stage `interpolate`: u* at the markers and their strengths a_k.

use rayon::prelude::*;

use super::{Immersed, Marker, MarkerParameters};
use crate::gpu::error::DeviceError;
use crate::gpu::fluid::Fluid;
use crate::immersed::kernel::WIDTH;
use crate::immersed::strength::LARGEST_OVER_RELAXATION_RATIO;
use crate::immersed::touched::{OutOfDomain, bounding_box};

impl Immersed {
    /// u* and D_k at the markers where [`Immersed::send_markers`] put them. They stay on the device until somebody asks ([`Immersed::ask_air_velocities`]).
    pub fn interpolate(&mut self, fluid: &Fluid) {
        let count = self.areas.len();
        let Some(boxed) = self.boxed.as_ref().filter(|_| count > 0) else {
            return;
        };
        let cells: u64 = boxed.forces.size.iter().map(|&n| u64::from(n)).product();
        let device = &self.device;
        let mut commands = device.record("interpolate");
        {
            let mut pass = commands.pass("interpolate");
            let parity = usize::from(fluid.odd());
            boxed.touched_cells[parity].dispatch(&mut pass, device.workgroups(cells));
            boxed
                .interpolate
                .dispatch(&mut pass, device.workgroups(count as u64));
        }
        device.leave(commands);
    }

    /// Has the device begin with what [`Immersed::fetch_air_velocities`] will take.
    pub fn ask_air_velocities(&mut self) {
        let count = self.areas.len();
        if self.boxed.is_none() || count == 0 {
            return;
        }
        let mut commands = self.device.record("air velocities");
        self.staging
            .copy(&mut commands, &self.marker_states, 0, 0, 16 * count as u64);
        self.submitted = Some(self.device.submit_alone(commands));
    }

    /// Stage `fetch_air_velocities`: u* and a_k to the host. Waits for nothing that was submitted after the last `interpolate`.
    pub fn fetch_air_velocities(&mut self) -> Result<(), DeviceError> {
        if self.order.is_empty() {
            return self.device.check();
        }
        if self.submitted.is_none() {
            self.ask_air_velocities();
        }
        let not_asked = || {
            let what = "velocities at markers are fetched before they are interpolated";
            DeviceError::Command(what.to_owned())
        };
        let submitted = self.submitted.take().ok_or_else(not_asked)?;
        let mut states = Vec::new();
        let bytes = 16 * self.order.len() as u64;
        self.staging
            .read_of(&self.device, submitted, bytes, |bytes| {
                states = bytemuck::pod_collect_to_vec(bytes);
            })?;
        self.take_states(&states);
        Ok(())
    }

    /// Takes u* and a_k of all markers, in the sorted order.
    fn take_states(&mut self, states: &[[f32; 4]]) {
        for (state, &marker) in states.iter().zip(&self.order) {
            let [x, y, z, strength] = state.map(f64::from);
            self.air_velocities[marker as usize] = [x, y, z];
            self.strengths[marker as usize] = strength;
        }
    }

    /// Takes what a device did by itself: u* and a_k, and the forces that it spread, both in the sorted order. Returns their sum on the air [lattice units].
    pub fn take_brought(&mut self, states: &[[f32; 4]], forces: &[[f32; 4]]) -> [f64; 3] {
        self.take_states(states);
        self.forces.copy_from_slice(forces);
        let mut total = [0.0; 3];
        for force in forces {
            for a in 0..3 {
                total[a] += f64::from(force[a]);
            }
        }
        total
    }

    /// Stage `send_markers`: sorts the markers at `positions` [cells, cell centres at whole numbers], sends them, and marks the
    /// touched cells.
    pub fn send_markers(
        &mut self,
        fluid: &Fluid,
        positions: &[[f64; 3]],
    ) -> Result<Result<(), OutOfDomain>, DeviceError> {
        let (low, high) = match bounding_box(positions, self.domain) {
            Ok(Some(found)) => found,
            Ok(None) => return Ok(Ok(())),
            Err(left) => return Ok(Err(left)),
        };
        let size: [u64; 3] = std::array::from_fn(|a| (high[a] - low[a]) as u64);
        let box_count: u64 = size.iter().product();
        self.boxed(fluid, box_count)?;
        let (cells, folds) = (self.domain.cells, self.domain.folds);
        let corner = |position: &[f64; 3]| -> u64 {
            let c: [u64; 3] = std::array::from_fn(|a| {
                let first = position[a].floor() as i64 - 1;
                let first = folds.map_or(first, |folds| folds.first(a, first, cells[a]));
                (first - low[a]).rem_euclid(size[a] as i64) as u64
            });
            c[0] + size[0] * (c[1] + size[1] * c[2])
        };
        // Sorted by corner, then by marker: one order, whatever the sort.
        let mut keys: Vec<u64> = positions
            .par_iter()
            .enumerate()
            .with_min_len(4096)
            .map(|(marker, position)| (corner(position) << 32) | marker as u64)
            .collect();
        keys.par_sort_unstable();
        self.take_order(keys.iter().map(|&key| key as u32));
        self.kernels = Some((low, high));
        let sorted: Vec<Marker> = keys
            .iter()
            .map(|&key| {
                let marker = (key & 0xffff_ffff) as usize;
                let position = positions[marker];
                let fraction = position.map(|x| (x - x.floor()) as f32);
                Marker {
                    corner: (key >> 32) as u32,
                    area: self.areas[marker] as f32,
                    fold: folds.map_or(0, |folds| folds.code(position, cells)),
                    number: marker as u32,
                    fraction: [fraction[0], fraction[1], fraction[2], 0.0],
                }
            })
            .collect();
        let repeats = |a: usize| {
            let whole = self.domain.repeats[a] && size[a] == self.domain.cells[a] as u64;
            u32::from(whole)
        };
        self.lay_box(low, size, repeats(1) + 2 * repeats(2));
        debug_assert!(size.iter().all(|&n| n >= WIDTH as u64));
        self.device.write(&self.markers, 0, &sorted);
        let Some(boxed) = &self.boxed else {
            return Ok(Ok(()));
        };
        let mut commands = self.device.record("place_markers");
        commands
            .raw
            .clear_buffer(&boxed.marks, 0, Some(4 * box_count));
        {
            let mut pass = commands.pass("place_markers");
            boxed
                .place_markers
                .dispatch(&mut pass, self.device.workgroups(sorted.len() as u64));
        }
        self.device.leave(commands);
        Ok(Ok(()))
    }

    /// Takes the sorted order.
    pub(super) fn take_order(&mut self, order: impl Iterator<Item = u32>) {
        self.order.clear();
        self.order.extend(order);
        for (place, &marker) in self.order.iter().enumerate() {
            self.places[marker as usize] = place as u32;
        }
    }

    /// Lays the box of cells from `low` on that kernels may reach; `through` tells through which sides they go on.
    pub(super) fn lay_box(&mut self, low: [i64; 3], size: [u64; 3], through: u32) {
        let Some(boxed) = &mut self.boxed else {
            return;
        };
        boxed.forces.first = low.map(|c| c as u32);
        boxed.forces.size = size.map(|n| n as u32);
        let four = |v: [u32; 3], last| [v[0], v[1], v[2], last];
        let parameters = MarkerParameters {
            box_first: four(boxed.forces.first, 0),
            box_size: four(boxed.forces.size, through),
            marker_count: self.areas.len() as u32,
            box_count: size.iter().product::<u64>() as u32,
            over_relaxation: self.over_relaxation as f32,
            largest_strength: (LARGEST_OVER_RELAXATION_RATIO * self.over_relaxation) as f32,
        };
        self.device.write(&self.parameters, 0, &[parameters]);
    }
}
