//! One level on the device: buffers, and the dispatches of the cycle and of a refresh.

use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders::WORKGROUP;
use crate::solve::multigrid::coarsening::Interpolation;
use crate::solve::multigrid::hierarchy::{DIRECT_NODES, Shape};
use crate::solve::multigrid::{COARSEST_DEGREE, DEGREE, eigenvector_guess};

use super::parameters::MultigridLevel;
use super::sliced::Sliced;

/// Pipelines of the cycle.
#[derive(Debug)]
pub(super) struct Cycle {
    pub(super) smooth_from_zero: Pipeline,
    pub(super) smooth_again: Pipeline,
    pub(super) take_residual: Pipeline,
    pub(super) restrict_residual: Pipeline,
    pub(super) interpolate_correction: Pipeline,
    pub(super) smooth_corrected: Pipeline,
    pub(super) solve_coarsest: Pipeline,
    pub(super) multiply: Pipeline,
}

/// Pipelines of a refresh.
#[derive(Debug)]
pub(super) struct Refresh {
    pub(super) galerkin: Pipeline,
    pub(super) invert_diagonal: Pipeline,
    pub(super) power_start: Pipeline,
    pub(super) power_step: Pipeline,
    pub(super) power_normalise: Pipeline,
}

/// Workgroups that stride over the nodes where sums are wanted.
const STRIDES: usize = 256;

/// Buffers of a level.
#[derive(Debug)]
pub(super) struct Buffers {
    /// Bytes of a vector.
    pub vector_bytes: u64,
    groups: [u32; 2],
    strides: u32,
    /// Layout of the matrix.
    pub sliced: Sliced,
    named: Vec<(&'static str, wgpu::Buffer)>,
    steps: [wgpu::Buffer; 2],
}

fn packed(interpolation: &Interpolation, rows: usize) -> (Vec<u32>, Vec<[u32; 2]>) {
    let mut first = vec![0];
    let mut entries = Vec::new();
    for row in 0..rows {
        let row = interpolation.row(row).iter();
        entries.extend(row.map(|(node, weight)| [*node, weight.to_bits()]));
        first.push(entries.len() as u32);
    }
    (first, entries)
}

impl Buffers {
    /// Buffers for a level; `coarser` is the layout of the next one.
    pub fn new(
        device: &Device,
        shape: &Shape,
        sliced: Sliced,
        coarser: Option<&Sliced>,
    ) -> Result<Self, DeviceError> {
        let nodes = shape.pattern.row_count();
        let vector_bytes = 12 * nodes as u64;
        let strides = nodes.div_ceil(WORKGROUP as usize).clamp(1, STRIDES) as u32;
        let direct = coarser.is_none() && nodes <= DIRECT_NODES;
        let sizes = MultigridLevel {
            nodes: nodes as u32,
            coarse_places: coarser.map_or(0, |coarser| coarser.columns.len() as u32),
            strides,
            unknowns: if direct { 3 * nodes as u32 } else { 0 },
        };
        let level = device.uniform::<MultigridLevel>("multigrid level")?;
        device.write(&level, 0, &[sizes]);
        let mut named = vec![
            ("level", level),
            ("slices", device.storage_of("slices", &sliced.slices)?),
            ("columns", device.storage_of("columns", &sliced.columns)?),
            (
                "matrix",
                device.storage("multigrid matrix", 4 * sliced.numbers() as u64)?,
            ),
            (
                "inverse_diagonal",
                device.storage("inverse diagonal", 2 * vector_bytes)?,
            ),
            (
                "chebyshev",
                device.storage("smoother", 8 * COARSEST_DEGREE as u64)?,
            ),
            ("eigenvector", device.storage("eigenvector", vector_bytes)?),
            (
                "eigenvector_guess",
                device.storage_of("guess of the eigenvector", &eigenvector_guess(nodes))?,
            ),
            (
                "squares",
                device.storage("squares", 4 * u64::from(strides))?,
            ),
            (
                "right",
                device.storage("multigrid right side", vector_bytes)?,
            ),
            (
                "residual",
                device.storage("multigrid residual", vector_bytes)?,
            ),
            (
                "solution",
                device.storage("multigrid solution", vector_bytes)?,
            ),
        ];
        if let (Some([to_fine, to_coarse]), Some(coarser)) = (&shape.interpolation, coarser) {
            let (first, entries) = packed(to_fine, nodes);
            named.push((
                "interpolation_first",
                device.storage_of("interpolation rows", &first)?,
            ));
            named.push((
                "interpolation",
                device.storage_of("interpolation", &entries)?,
            ));
            let (first, entries) = packed(to_coarse, to_coarse.row_count());
            named.push((
                "restriction_first",
                device.storage_of("restriction rows", &first)?,
            ));
            named.push(("restriction", device.storage_of("restriction", &entries)?));
            named.push((
                "coarse_rows",
                device.storage_of("rows of coarse blocks", &coarser.rows)?,
            ));
        }
        if direct {
            let unknowns = 3 * nodes as u64;
            named.push((
                "coarsest_inverse",
                device.storage("coarsest inverse", 4 * unknowns * unknowns)?,
            ));
        }
        Ok(Self {
            vector_bytes,
            groups: device.workgroups(nodes as u64),
            strides,
            sliced,
            named,
            steps: [
                device.storage("multigrid step", vector_bytes)?,
                device.storage("multigrid step", vector_bytes)?,
            ],
        })
    }

    /// A buffer by its name in the shaders.
    pub fn get(&self, wanted: &str) -> Result<&wgpu::Buffer, DeviceError> {
        self.named
            .iter()
            .find_map(|(name, buffer)| (*name == wanted).then_some(buffer))
            .ok_or_else(|| DeviceError::Command(format!("no buffer {wanted} on a level")))
    }

    /// Where [`Level::multiply`] leaves the product.
    pub const fn product(&self) -> &wgpu::Buffer {
        &self.steps[0]
    }

    /// Gives a pipeline the buffers of this level, and `more`.
    fn bind(
        &self,
        device: &Device,
        pipeline: &Pipeline,
        more: &[(&str, &wgpu::Buffer)],
    ) -> Result<Bound, DeviceError> {
        let own = self.named.iter().map(|(name, buffer)| (*name, buffer));
        let all: Vec<(&str, &wgpu::Buffer)> = own.chain(more.iter().copied()).collect();
        device.bind(pipeline, &all)
    }
}

/// A dispatch with its workgroups.
#[derive(Debug)]
struct Dispatch(Bound, [u32; 2]);

fn record(dispatches: &[Dispatch], pass: &mut Pass<'_>) {
    for Dispatch(bound, groups) in dispatches {
        bound.dispatch(pass, *groups);
    }
}

/// What the cycle does on a level on its way down and up, and what a refresh does.
#[derive(Debug)]
pub(super) struct Level {
    down: Vec<Dispatch>,
    up: Vec<Dispatch>,
    /// With the inverse instead of the smoother.
    direct: Option<Dispatch>,
    /// The matrix times the solution, into a step.
    multiply: Dispatch,
    galerkin: Option<Dispatch>,
    invert_diagonal: Dispatch,
    power_start: Dispatch,
    power: [Dispatch; 2],
}

impl Level {
    /// Binds the dispatches of a level to its buffers and those of the next coarser one; `sweeps` hold their numbers, from 1.
    pub fn new(
        device: &Device,
        (cycle, refresh): (&Cycle, &Refresh),
        own: &Buffers,
        coarser: Option<&Buffers>,
        sweeps: &[wgpu::Buffer],
    ) -> Result<Self, DeviceError> {
        let [a, b] = [&own.steps[0], &own.steps[1]];
        let rows = |pipeline, more: &[(&str, &wgpu::Buffer)]| {
            Ok::<_, DeviceError>(Dispatch(own.bind(device, pipeline, more)?, own.groups))
        };
        // Sweeps alternate between the two steps; the last one's is in the second of the pair returned.
        let again = |degree: usize| {
            let mut dispatches = Vec::new();
            let (mut old, mut new) = (a, b);
            for sweep in sweeps.iter().take(degree - 1) {
                let more = [("operand", old), ("new_step", new), ("sweep", sweep)];
                dispatches.push(rows(&cycle.smooth_again, &more)?);
                (old, new) = (new, old);
            }
            Ok::<_, DeviceError>((dispatches, old, new))
        };
        let mut level = Self {
            down: vec![rows(&cycle.smooth_from_zero, &[("new_step", a)])?],
            up: Vec::new(),
            direct: None,
            multiply: rows(
                &cycle.multiply,
                &[("operand", own.get("solution")?), ("new_step", a)],
            )?,
            galerkin: None,
            invert_diagonal: rows(&refresh.invert_diagonal, &[])?,
            power_start: rows(&refresh.power_start, &[])?,
            power: [
                Dispatch(
                    own.bind(
                        device,
                        &refresh.power_step,
                        &[("operand", own.get("eigenvector")?), ("new_step", a)],
                    )?,
                    [own.strides, 1],
                ),
                Dispatch(
                    own.bind(device, &refresh.power_normalise, &[("new_step", a)])?,
                    [own.strides, 1],
                ),
            ],
        };
        let Some(coarser) = coarser else {
            level.down.extend(again(COARSEST_DEGREE)?.0);
            if let Ok(inverse) = own.get("coarsest_inverse") {
                let more = [("coarsest_inverse", inverse)];
                let bound = own.bind(device, &cycle.solve_coarsest, &more)?;
                let unknowns = own.vector_bytes / 4;
                level.direct = Some(Dispatch(bound, device.workgroups(unknowns)));
            }
            return Ok(level);
        };
        let (sweeps_down, last, _) = again(DEGREE)?;
        level.down.extend(sweeps_down);
        level
            .down
            .push(rows(&cycle.take_residual, &[("operand", last)])?);
        let from_fine = [
            ("fine_residual", own.get("residual")?),
            ("coarse_right", coarser.get("right")?),
            ("restriction_first", own.get("restriction_first")?),
            ("restriction", own.get("restriction")?),
        ];
        level.down.push(Dispatch(
            coarser.bind(device, &cycle.restrict_residual, &from_fine)?,
            coarser.groups,
        ));
        let from_coarse = [
            ("coarse_solution", coarser.get("solution")?),
            ("new_step", b),
        ];
        level
            .up
            .push(rows(&cycle.interpolate_correction, &from_coarse)?);
        let corrected = [("operand", b), ("new_step", a)];
        level.up.push(rows(&cycle.smooth_corrected, &corrected)?);
        level.up.extend(again(DEGREE)?.0);
        let products = [
            ("coarse_columns", coarser.get("columns")?),
            ("coarse_matrix", coarser.get("matrix")?),
        ];
        level.galerkin = Some(Dispatch(
            own.bind(device, &refresh.galerkin, &products)?,
            device.workgroups(coarser.sliced.columns.len() as u64),
        ));
        Ok(level)
    }

    /// Smooths and restricts; on the coarsest level solves, with the inverse if `direct`.
    pub fn down(&self, pass: &mut Pass<'_>, direct: bool) {
        match &self.direct {
            Some(Dispatch(bound, groups)) if direct => bound.dispatch(pass, *groups),
            _ => record(&self.down, pass),
        }
    }

    /// The matrix times the solution; the product is in the first of the steps.
    pub fn multiply(&self, pass: &mut Pass<'_>) {
        self.multiply.0.dispatch(pass, self.multiply.1);
    }

    /// Corrects and smooths.
    pub fn up(&self, pass: &mut Pass<'_>) {
        record(&self.up, pass);
    }

    /// Inverse diagonal, polynomial of the smoother and the next coarser matrix.
    pub fn refresh(&self, pass: &mut Pass<'_>, power_iterations: usize) {
        self.invert_diagonal
            .0
            .dispatch(pass, self.invert_diagonal.1);
        self.power_start.0.dispatch(pass, self.power_start.1);
        for _ in 0..power_iterations {
            record(&self.power, pass);
        }
        if let Some(Dispatch(bound, groups)) = &self.galerkin {
            bound.dispatch(pass, *groups);
        }
    }
}
