//! Buffers and pipelines of the minimiser's vectors, for one length of history.

use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;
use crate::gpu::shaders::WORKGROUP;
use crate::gpu::transfer::Staging;

use super::decisions::{DecisionPipelines, Decisions};
use super::elements::Kind;
use super::gathering::{BoundGathering, Gathering};
use super::marker_reactions::MarkerPipelines;
use super::slots::FIRST_FREE;
use super::small_cloth;

/// Workgroups that stride over the nodes.
const STRIDES: usize = 256;
/// Workgroups that stride over the nodes for one row of products; what they return goes to the host.
const PRODUCT_STRIDES: usize = 64;
/// Nodes that a thread adds up for a row of products at least, before its workgroup shares its sums.
const NODES_PER_THREAD: usize = 4;
/// Words before the products in a report.
pub(super) const HEADER: usize = 4;
/// Words of one workgroup in one row of a report.
pub(super) const ENTRY: usize = 4;

/// Pipelines of the bulk operations.
#[derive(Debug)]
pub(super) struct Operations {
    combine: Pipeline,
    advance: Pipeline,
    precondition: Pipeline,
    products: Pipeline,
    strides: u32,
    product_strides: u32,
    decisions: DecisionPipelines,
}

impl Operations {
    /// Builds the pipelines.
    pub fn new(
        device: &Device,
        (nodes, kinds): (usize, &[Kind]),
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        let groups = nodes.div_ceil(WORKGROUP as usize).max(1);
        let strides = groups.min(STRIDES) as u32;
        let product_strides = groups.div_ceil(NODES_PER_THREAD).min(PRODUCT_STRIDES) as u32;
        let mut constants = constants.to_vec();
        constants.push(("STRIDES", f64::from(strides)));
        constants.push(("PRODUCT_STRIDES", f64::from(product_strides)));
        let [combine, advance, precondition, products] = device.pipelines(
            &shaders::VECTORS,
            ["combine", "advance", "precondition", "products"],
            &constants,
        )?;
        let small = small_cloth::pipeline(device, nodes, kinds, &constants)?;
        Ok(Self {
            combine,
            advance,
            precondition,
            products,
            strides,
            product_strides,
            decisions: DecisionPipelines::new(device, small, &constants)?,
        })
    }
}

/// Everything with its buffers, for one length of history.
#[derive(Debug)]
pub(super) struct Workspace {
    /// Pairs of the minimiser that there is room for.
    pub history: usize,
    /// Vectors, `[slot][node][axis]`.
    pub vectors: wgpu::Buffer,
    pub vector_slots: u32,
    /// Bytes of a vector.
    pub vector_bytes: u64,
    pub program: wgpu::Buffer,
    pub program_words: usize,
    pub rows: wgpu::Buffer,
    pub transforms: wgpu::Buffer,
    pub report: wgpu::Buffer,
    pub staging: Staging,
    pub combine: Bound,
    pub advance: Bound,
    pub precondition: Bound,
    pub products: Bound,
    pub forces: BoundGathering,
    pub blocks: BoundGathering,
    pub strides: u32,
    pub product_strides: u32,
    pub decisions: Decisions,
}

/// Vectors kept for `history` pairs.
pub(super) const fn vector_slots(history: usize) -> usize {
    // g, H₀ g, g⁺, H₀ g⁺, d; one pair more than the history while the oldest goes.
    FIRST_FREE as usize + 5 + 3 * (history + 1)
}

impl Workspace {
    /// Room for `history` pairs of vectors of `nodes`; `buffers` are those that do not depend on the history.
    pub fn new(
        device: &Device,
        operations: &Operations,
        ([forces, blocks], in_air): ([&Gathering; 2], Option<&MarkerPipelines>),
        buffers: &[(&str, &wgpu::Buffer)],
        history: usize,
        nodes: usize,
    ) -> Result<Self, DeviceError> {
        let pairs = history + 1;
        let vector_slots = vector_slots(history);
        // Four combinations of one iteration, of at most 2 · history + 1 terms.
        let program_words = 4 * (2 + 2 * (2 * pairs + 1));
        let row_count = (2 * pairs + 3).max(2 + pairs + pairs * (pairs + 1) / 2);
        let report_bytes =
            4 * (HEADER + ENTRY * row_count * operations.product_strides as usize) as u64;
        let vectors = device.storage("cloth vectors", (vector_slots * nodes * 12) as u64)?;
        let program = device.storage("cloth program", 4 * program_words as u64)?;
        let rows = device.storage("cloth products", 16 * row_count as u64)?;
        let transforms = device.storage("cloth transforms", 8 * (pairs as u64 + 2))?;
        let reach = device.storage("cloth reach", 4 * u64::from(operations.strides))?;
        let report = device.storage("cloth report", report_bytes)?;
        let mut all = buffers.to_vec();
        all.extend([
            ("vectors", &vectors),
            ("program", &program),
            ("rows", &rows),
            ("transforms", &transforms),
            ("reach", &reach),
            ("report", &report),
        ]);
        let forces = forces.bind(device, &all)?;
        let sizes = (nodes, forces.len());
        let decisions = Decisions::new(device, (&operations.decisions, in_air), &all, sizes)?;
        Ok(Self {
            history,
            vector_slots: vector_slots as u32,
            vector_bytes: 12 * nodes as u64,
            program_words,
            staging: Staging::new(device, report_bytes)?,
            combine: device.bind(&operations.combine, &all)?,
            advance: device.bind(&operations.advance, &all)?,
            precondition: device.bind(&operations.precondition, &all)?,
            products: device.bind(&operations.products, &all)?,
            forces,
            blocks: blocks.bind(device, &all)?,
            decisions,
            strides: operations.strides,
            product_strides: operations.product_strides,
            vectors,
            program,
            rows,
            transforms,
            report,
        })
    }
}
