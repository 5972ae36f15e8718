//! [`crate::solve::multigrid`] on the device: one V-cycle as an approximate inverse (`shaders/multigrid.wgsl`), and what it needs of a
//! new matrix (`shaders/multigrid_refresh.wgsl`).
//!
//! Patterns and interpolation come from the host once; afterwards coarse matrices, inverse diagonals and eigenvalues are made where the
//! finest matrix is. Only the coarsest matrix, at most 150 nodes, goes to the host to be inverted in `f64`, and its inverse back.
//!
//! *Departures from the host*: the vector is not scaled before the cycle, since the exponents of `f32` suffice for forces; diagonal
//! blocks are inverted in `f32`, with the pivots kept above a millionth of the largest entry.

mod level;
pub mod parameters;
pub mod sliced;

use std::cell::Cell;

use crate::gpu::commands::Commands;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::shaders;
use crate::gpu::transfer::Staging;
use crate::solve::multigrid::blocks::BlockMatrix;
use crate::solve::multigrid::hierarchy::{DIRECT_NODES, Shape, coarsest_inverse};
use crate::solve::multigrid::{
    COARSEST_DEGREE, EIGENVALUE_MARGIN, POWER_ITERATIONS, SMOOTHED_SHARE,
};

use level::{Buffers, Cycle, Level, Refresh};
use sliced::Sliced;

/// Bytes that went over the bus for multigrid since it was made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Refreshes of the matrices.
    pub refreshes: u64,
    /// From the device to the host.
    pub fetched_bytes: u64,
    /// From the host to the device, patterns and interpolation not counted.
    pub sent_bytes: u64,
}

/// The levels on the device.
#[derive(Debug)]
pub struct Multigrid {
    shapes: Vec<Shape>,
    buffers: Vec<Buffers>,
    levels: Vec<Level>,
    /// Way back of the coarsest matrix, where it is solved directly.
    coarsest: Option<Staging>,
    /// The coarsest inverse could be made.
    direct: Cell<bool>,
    traffic: Cell<Traffic>,
}

impl Multigrid {
    /// Uploads patterns and interpolation of all levels, finest first.
    pub fn new(device: &Device, shapes: Vec<Shape>) -> Result<Self, DeviceError> {
        let [
            smooth_from_zero,
            smooth_again,
            take_residual,
            restrict_residual,
            interpolate_correction,
            smooth_corrected,
            solve_coarsest,
            multiply,
        ] = device.pipelines(
            &shaders::MULTIGRID,
            [
                "smooth_from_zero",
                "smooth_again",
                "take_residual",
                "restrict_residual",
                "interpolate_correction",
                "smooth_corrected",
                "solve_coarsest",
                "multiply",
            ],
            &[],
        )?;
        let cycle = Cycle {
            smooth_from_zero,
            smooth_again,
            take_residual,
            restrict_residual,
            interpolate_correction,
            smooth_corrected,
            solve_coarsest,
            multiply,
        };
        let [
            galerkin,
            invert_diagonal,
            power_start,
            power_step,
            power_normalise,
        ] = device.pipelines(
            &shaders::MULTIGRID_REFRESH,
            [
                "galerkin",
                "invert_diagonal",
                "power_start",
                "power_step",
                "power_normalise",
            ],
            &[
                ("SWEEPS", COARSEST_DEGREE as f64),
                ("SMOOTHED_SHARE", f64::from(SMOOTHED_SHARE)),
                ("EIGENVALUE_MARGIN", f64::from(EIGENVALUE_MARGIN)),
            ],
        )?;
        let refresh = Refresh {
            galerkin,
            invert_diagonal,
            power_start,
            power_step,
            power_normalise,
        };
        let mut sweeps = Vec::new();
        for sweep in 1..COARSEST_DEGREE as u32 {
            let buffer = device.uniform::<[u32; 4]>("sweep")?;
            device.write(&buffer, 0, &[[sweep, 0, 0, 0]]);
            sweeps.push(buffer);
        }
        // From the coarsest on, since a level reads the layout of the next.
        let mut buffers: Vec<Buffers> = Vec::new();
        for shape in shapes.iter().rev() {
            let coarser = buffers.last().map(|coarser| &coarser.sliced);
            let sliced = Sliced::new(&shape.pattern);
            buffers.push(Buffers::new(device, shape, sliced, coarser)?);
        }
        buffers.reverse();
        let mut levels = Vec::new();
        for (k, own) in buffers.iter().enumerate() {
            let coarser = buffers.get(k + 1);
            levels.push(Level::new(
                device,
                (&cycle, &refresh),
                own,
                coarser,
                &sweeps,
            )?);
        }
        let coarsest = match (shapes.last(), buffers.last()) {
            (Some(shape), Some(level)) if shape.pattern.row_count() <= DIRECT_NODES => {
                let bytes = 4 * level.sliced.numbers() as u64;
                Some(Staging::new(device, bytes)?)
            }
            _ => None,
        };
        Ok(Self {
            shapes,
            buffers,
            levels,
            coarsest,
            direct: Cell::new(false),
            traffic: Cell::default(),
        })
    }

    fn level(&self, k: usize) -> Result<&Buffers, DeviceError> {
        self.buffers
            .get(k)
            .ok_or_else(|| DeviceError::Command(format!("multigrid has no level {k}")))
    }

    /// The finest matrix, to be filled before a refresh, and its layout.
    pub(super) fn finest(&self) -> Result<(&wgpu::Buffer, &Sliced), DeviceError> {
        let level = self.level(0)?;
        Ok((level.get("matrix")?, &level.sliced))
    }

    /// Bytes that went over the bus so far.
    #[must_use]
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    /// Records what follows from a new finest matrix; [`Multigrid::invert_coarsest`] must come after the submission. The first refresh of
    /// a solve forgets the eigenvectors of the one before, so that a solve does not depend on others.
    pub(super) fn refresh(&self, commands: &mut Commands, first: bool) -> Result<(), DeviceError> {
        if first {
            for level in &self.buffers {
                let (from, to) = (level.get("eigenvector_guess")?, level.get("eigenvector")?);
                commands
                    .raw
                    .copy_buffer_to_buffer(from, 0, to, 0, level.vector_bytes);
            }
        }
        {
            let mut pass = commands.pass("multigrid_refresh");
            for level in &self.levels {
                level.refresh(&mut pass, POWER_ITERATIONS[usize::from(!first)]);
            }
        }
        if let (Some(staging), Some(level)) = (&self.coarsest, self.buffers.last()) {
            let bytes = 4 * level.sliced.numbers() as u64;
            staging.copy(commands, level.get("matrix")?, 0, 0, bytes);
        }
        Ok(())
    }

    /// Inverts the coarsest matrix on the host, after a submitted refresh.
    pub(super) fn invert_coarsest(&self, device: &Device) -> Result<(), DeviceError> {
        let mut traffic = self.traffic.get();
        traffic.refreshes += 1;
        if let (Some(staging), Some(shape), Some(level)) =
            (&self.coarsest, self.shapes.last(), self.buffers.last())
        {
            let numbers = level.sliced.numbers();
            let mut values: Vec<f32> = Vec::new();
            staging.read(device, |bytes| {
                values = bytemuck::pod_collect_to_vec(&bytes[..4 * numbers]);
            })?;
            traffic.fetched_bytes += 4 * numbers as u64;
            let inverse = coarsest_inverse(&level.sliced.matrix(&shape.pattern, &values));
            self.direct.set(!inverse.is_empty());
            if !inverse.is_empty() {
                device.write(level.get("coarsest_inverse")?, 0, &inverse);
                traffic.sent_bytes += 4 * inverse.len() as u64;
            }
        }
        self.traffic.set(traffic);
        Ok(())
    }

    /// Records one V-cycle for the vector at byte `from` of `vectors`; the result goes to byte `to`.
    pub(super) fn cycle(
        &self,
        commands: &mut Commands,
        vectors: &wgpu::Buffer,
        [from, to]: [u64; 2],
    ) -> Result<(), DeviceError> {
        let finest = self.level(0)?;
        let bytes = finest.vector_bytes;
        commands
            .raw
            .copy_buffer_to_buffer(vectors, from, finest.get("right")?, 0, bytes);
        {
            let mut pass = commands.pass("multigrid");
            for level in &self.levels {
                level.down(&mut pass, self.direct.get());
            }
            for level in self.levels.iter().rev() {
                level.up(&mut pass);
            }
        }
        commands
            .raw
            .copy_buffer_to_buffer(finest.get("solution")?, 0, vectors, to, bytes);
        Ok(())
    }

    /// Records the product of the finest matrix with the vector at byte `from` of `vectors`; it goes to byte `to`.
    pub(super) fn multiply(
        &self,
        commands: &mut Commands,
        vectors: &wgpu::Buffer,
        [from, to]: [u64; 2],
    ) -> Result<(), DeviceError> {
        let finest = self.level(0)?;
        let bytes = finest.vector_bytes;
        let operand = finest.get("solution")?;
        commands
            .raw
            .copy_buffer_to_buffer(vectors, from, operand, 0, bytes);
        if let Some(level) = self.levels.first() {
            level.multiply(&mut commands.pass("multigrid_multiply"));
        }
        commands
            .raw
            .copy_buffer_to_buffer(finest.product(), 0, vectors, to, bytes);
        Ok(())
    }

    /// Takes a finest matrix from the host, with the pattern of the first shape; `first` as in a refresh.
    pub fn set_matrix(
        &self,
        device: &Device,
        matrix: &BlockMatrix,
        first: bool,
    ) -> Result<(), DeviceError> {
        let (buffer, sliced) = self.finest()?;
        device.write(buffer, 0, &sliced.values(matrix));
        let mut commands = device.record("multigrid_refresh");
        self.refresh(&mut commands, first)?;
        device.submit(commands);
        self.invert_coarsest(device)
    }

    /// One V-cycle for `right`, from zero; one entry per node of the finest level.
    pub fn apply(&self, device: &Device, right: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, DeviceError> {
        let vectors = device.storage_of("multigrid vector", right)?;
        let mut commands = device.record("multigrid");
        self.cycle(&mut commands, &vectors, [0, 0])?;
        device.submit(commands);
        device.read(&vectors, 0, right.len())
    }
}
