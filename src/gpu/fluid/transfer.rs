//! Stages `restrict` and `fill`: what passes between a lattice and a box of finer cells in it ([`crate::lattice::nest`]).
//!
//! A shader has room for the populations of one lattice, so that states go through a buffer: four short dispatches in one submission.

use super::Fluid;
use super::held_eddy_viscosity::HeldEddyViscosity;
use super::names::{by_parity, constants};
use super::parameters::TransferParameters;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;
use crate::lattice::grid::Grid;
use crate::lattice::level_state::STATE_NUMBERS;
use crate::lattice::nest::{Nest, Planes, SHELL, SOURCE, band};

/// A box of finer cells, and what ties it to the lattice around it.
#[derive(Debug)]
pub struct Tie {
    nest: Nest,
    stages: [Stage; 4],
}

/// One dispatch.
#[derive(Debug)]
struct Stage {
    parameters: wgpu::Buffer,
    values: TransferParameters,
    threads: u64,
    /// By the parity of the lattice whose populations it touches.
    bound: [Bound; 2],
}

impl Tie {
    /// Of a box of `fine` cells in a lattice.
    pub fn new(coarse: &Fluid, fine: &Fluid, nest: Nest) -> Result<Self, DeviceError> {
        let device = &coarse.device;
        let [row, rows, planes] = nest.cells.map(|n| n as u32 + 2);
        let number_stride = row * rows * planes;
        let states = device.storage(
            "level states",
            4 * STATE_NUMBERS as u64 * u64::from(number_stride),
        )?;
        let entries = ["restrict_states", "write_band", "read_source", "fill_shell"];
        let pipelines = |fluid: &Fluid| -> Result<[Pipeline; 4], DeviceError> {
            let constants = constants(device.tuning(), &fluid.setup, &fluid.grid);
            let shader = match fluid.held_eddy_viscosity {
                Some(_) => &shaders::TRANSFER_HELD,
                None => &shaders::TRANSFER,
            };
            device.pipelines(&shader[fluid.storage as usize], entries, &constants)
        };
        let [of_fine, of_coarse] = [pipelines(fine)?, pipelines(coarse)?];
        // States of the band need no neighbours: they stand at their place in the box, as those of the source do.
        let state = |cell: [i64; 3]| {
            let [x, y, z] = cell.map(|place| (place + 1) as u32);
            x + row * (y + rows * z)
        };
        let wrapped = |cell: [i64; 3]| -> [i64; 3] {
            std::array::from_fn(|a| {
                let place = nest.first[a] as i64 + cell[a];
                if nest.spans[a] {
                    place.rem_euclid(coarse.grid.cells[a] as i64)
                } else {
                    place
                }
            })
        };
        let in_coarse = |cell| element(&coarse.grid, wrapped(cell));
        let in_fine = |cell: [i64; 3]| element(&fine.grid, cell.map(|place| 2 * place));
        // The shell begins with the first of 27 coarse states.
        let corner = |cell: [i64; 3]| state(cell.map(|place| place - 1));
        let stage = |pipeline: &Pipeline, fluid: &Fluid, cells: Vec<[u32; 2]>, each: u64| {
            let list = device.storage_of("transfer cells", &cells)?;
            let parameters = device.uniform::<TransferParameters>("transfer")?;
            let bound = |odd| {
                let mut named = by_parity(&fluid.populations, odd);
                named.extend([
                    ("transfer", &parameters),
                    ("transfer_cells", &list),
                    ("level_states", &states),
                ]);
                named.extend(
                    fluid
                        .held_eddy_viscosity
                        .iter()
                        .map(HeldEddyViscosity::named),
                );
                device.bind(pipeline, &named)
            };
            let bound = [bound(false)?, bound(true)?];
            let values = TransferParameters {
                count: cells.len() as u32,
                number_stride,
                row_stride: row,
                plane_stride: row * rows,
                ..TransferParameters::default()
            };
            device.write(&parameters, 0, &[values]);
            Ok::<_, DeviceError>(Stage {
                parameters,
                values,
                threads: each * cells.len() as u64,
                bound,
            })
        };
        let band = nest.cells_of(&band(coarse.setup.eddy_viscosity));
        let stages = [
            stage(&of_fine[0], fine, listed(&band, in_fine, state), 1)?,
            stage(&of_coarse[1], coarse, listed(&band, in_coarse, state), 1)?,
            stage(
                &of_coarse[2],
                coarse,
                listed(&nest.cells_of(&SOURCE), in_coarse, state),
                1,
            )?,
            stage(
                &of_fine[3],
                fine,
                listed(&nest.cells_of(&SHELL), in_fine, corner),
                8,
            )?,
        ];
        Ok(Self { nest, stages })
    }

    /// Where the box lies.
    #[must_use]
    pub const fn nest(&self) -> &Nest {
        &self.nest
    }

    /// Restricts, then fills: both lattices stand at one time.
    pub fn exchange(&mut self, coarse: &mut Fluid, fine: &mut Fluid) -> Result<(), DeviceError> {
        let device = &coarse.device;
        let lattices = [&*fine, &*coarse, &*coarse, &*fine];
        for (stage, lattice) in self.stages.iter_mut().zip(lattices) {
            let [x, y, z] = lattice.last_acceleration.map(|a| a as f32);
            let force = [x, y, z, 0.0];
            if stage.values.force != force {
                stage.values.force = force;
                device.write(&stage.parameters, 0, &[stage.values]);
            }
        }
        let mut commands = device.record("exchange");
        {
            let mut pass = commands.pass("exchange");
            for (stage, lattice) in self.stages.iter().zip(lattices) {
                stage.bound[usize::from(lattice.odd)]
                    .dispatch(&mut pass, device.workgroups(stage.threads));
            }
        }
        device.leave(commands);
        device.check()
    }
}

/// Element of a cell.
fn element(grid: &Grid, cell: [i64; 3]) -> u32 {
    grid.index(cell) as u32
}

/// Two numbers for each cell.
fn listed(
    planes: &Planes,
    first: impl Fn([i64; 3]) -> u32,
    second: impl Fn([i64; 3]) -> u32,
) -> Vec<[u32; 2]> {
    planes
        .cells()
        .map(|cell| [first(cell), second(cell)])
        .collect()
}
