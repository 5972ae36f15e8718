//! The minimiser's vectors on the device (`shaders/vectors.wgsl`): [`VectorSpace`] with one transfer to the host per trial.
//!
//! Linear combinations are only noted down when they are asked for; the next trial uploads them as a small program, which runs
//! node by node before the step. Sums come back as one number per workgroup and are added on the host in `f64`, always in the
//! same order.

use crate::gpu::device::{Device, Staging};
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline, WORKGROUP, compute_pass};
use crate::gpu::shaders;
use crate::solve::{Attempt, Landing, Refreshed, Start, Step, VectorSpace};

use super::gathering::{BoundGathering, Gathering};
use super::parameters::ClothStage;

/// Workgroups that stride over the nodes.
const STRIDES: usize = 256;
/// Workgroups that stride over the nodes for one row of products; what they return goes to the host.
const PRODUCT_STRIDES: usize = 64;
/// Nodes that a thread adds up for a row of products at least, before its workgroup shares its sums.
const NODES_PER_THREAD: usize = 4;
/// In place of a slot: none.
const NONE: u32 = u32::MAX;
/// In place of a slot: the energies.
const ENERGY: u32 = u32::MAX - 1;
/// Words before the products in a report.
const HEADER: usize = 4;
/// Words of one workgroup in one row of a report.
const ENTRY: usize = 4;
/// Error of the energy by round-off, over the sum of its parts' magnitudes: a few roundings of 6e-8 per part.
const ROUND_OFF: f64 = 1e-6;

/// Slot of the loads that set the scale of the tolerance.
pub(super) const DRIVE: u32 = 0;
/// Slot of H₀ times these.
const DRIVE_STEP: u32 = 1;
const FIRST_FREE: u32 = 2;
/// Present point and trial.
pub(super) const POINTS: u64 = 2;

/// A vector on the device.
#[derive(Debug)]
pub(super) struct Slot(pub u32);

/// A point on the device.
#[derive(Debug)]
pub(super) struct PointSlot(pub u32);

/// Pipelines of the bulk operations.
#[derive(Debug)]
pub(super) struct Operations {
    combine: Pipeline,
    advance: Pipeline,
    precondition: Pipeline,
    products: Pipeline,
    strides: u32,
    product_strides: u32,
}

impl Operations {
    /// Builds the pipelines.
    pub fn new(
        device: &Device,
        nodes: usize,
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
        Ok(Self {
            combine,
            advance,
            precondition,
            products,
            strides,
            product_strides,
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
    vector_slots: u32,
    program: wgpu::Buffer,
    program_words: usize,
    rows: wgpu::Buffer,
    transforms: wgpu::Buffer,
    report: wgpu::Buffer,
    staging: Staging,
    combine: Bound,
    advance: Bound,
    precondition: Bound,
    products: Bound,
    forces: BoundGathering,
    blocks: BoundGathering,
    strides: u32,
    product_strides: u32,
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
        [forces, blocks]: [&Gathering; 2],
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
        Ok(Self {
            history,
            vector_slots: vector_slots as u32,
            program_words,
            staging: Staging::new(device, report_bytes)?,
            combine: device.bind(&operations.combine, &all)?,
            advance: device.bind(&operations.advance, &all)?,
            precondition: device.bind(&operations.precondition, &all)?,
            products: device.bind(&operations.products, &all)?,
            forces: forces.bind(device, &all)?,
            blocks: blocks.bind(device, &all)?,
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

/// One row of products (a, a′, b, b′).
#[derive(Debug, Clone, Copy)]
struct Product {
    /// a·b; of the energies: their sum.
    plain: f64,
    /// (a − a′)·(b − b′); of the energies: the sum of their magnitudes.
    change: f64,
    /// a·(b − b′)
    mixed: f64,
    /// Longest displacement in b; NaN if an element is not finite.
    longest: f64,
}

/// The objective of one step, on device vectors.
#[derive(Debug)]
pub(super) struct Space<'a> {
    pub device: &'a Device,
    pub workspace: &'a Workspace,
    /// Buffer of [`ClothStage`].
    pub stage_buffer: &'a wgpu::Buffer,
    /// Parameters of this step; slots are filled in for every dispatch.
    pub stage: ClothStage,
    /// What the device leaves out of the objective because it never changes during a step [J].
    pub constant_j: f64,
    program: Vec<u32>,
    operations: u32,
    next_vector: u32,
    next_point: u32,
}

impl<'a> Space<'a> {
    pub fn new(
        device: &'a Device,
        workspace: &'a Workspace,
        stage_buffer: &'a wgpu::Buffer,
        stage: ClothStage,
        constant_j: f64,
    ) -> Self {
        Self {
            device,
            workspace,
            stage_buffer,
            stage,
            constant_j,
            program: Vec::new(),
            operations: 0,
            next_vector: FIRST_FREE,
            next_point: 0,
        }
    }

    /// Uploads the program and the parameters.
    fn upload(&mut self, stage: ClothStage) {
        let stage = ClothStage {
            operations: self.operations,
            ..stage
        };
        self.device.write(self.stage_buffer, 0, &[stage]);
        if !self.program.is_empty() {
            self.device.write(&self.workspace.program, 0, &self.program);
        }
        self.program.clear();
        self.operations = 0;
    }

    /// Runs the program, `dispatches`, then the products, and brings the length of the step and the products back.
    fn run(
        &mut self,
        stage: ClothStage,
        rows: &[[u32; 4]],
        dispatches: impl FnOnce(&Workspace, &mut wgpu::ComputePass<'_>),
    ) -> Result<(f64, Vec<Product>), DeviceError> {
        let workspace = self.workspace;
        self.upload(stage);
        self.device.write(&workspace.rows, 0, rows);
        let mut commands = self.device.record("cloth");
        {
            let mut pass = compute_pass(&mut commands, "cloth");
            workspace
                .combine
                .dispatch(&mut pass, [workspace.strides, 1]);
            dispatches(workspace, &mut pass);
            workspace
                .products
                .dispatch(&mut pass, [workspace.product_strides, rows.len() as u32]);
        }
        let groups = workspace.product_strides as usize;
        let words = HEADER + ENTRY * groups * rows.len();
        workspace
            .staging
            .copy(&mut commands, &workspace.report, 0, 0, 4 * words as u64);
        self.device.submit(commands);
        let mut answer = (0.0, Vec::new());
        workspace.staging.read(self.device, |bytes| {
            let report: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes[..4 * words]);
            let products = report[HEADER..].chunks_exact(ENTRY * groups).map(sum_row);
            answer = (f64::from(f32::from_bits(report[0])), products.collect());
        })?;
        Ok(answer)
    }

    fn objective(&self, energy: &Product) -> (f64, f64) {
        (energy.plain + self.constant_j, ROUND_OFF * energy.change)
    }
}

fn sum_row(row: &[u32]) -> Product {
    let mut sums = [0.0; 3];
    let mut longest = 0;
    for entry in row.chunks_exact(ENTRY) {
        for (sum, bits) in sums.iter_mut().zip(entry) {
            *sum += f64::from(f32::from_bits(*bits));
        }
        longest = longest.max(entry[3]);
    }
    let square = f64::from(f32::from_bits(longest));
    Product {
        plain: sums[0],
        change: sums[1],
        mixed: sums[2],
        longest: if square.is_finite() {
            square.sqrt()
        } else {
            f64::NAN
        },
    }
}

fn incomplete() -> DeviceError {
    DeviceError::Command("a report of the cloth is incomplete".to_owned())
}

impl VectorSpace for Space<'_> {
    type Point = PointSlot;
    type Vector = Slot;
    type Error = DeviceError;

    fn point(&mut self) -> Result<PointSlot, DeviceError> {
        let slot = self.next_point;
        if u64::from(slot) >= POINTS {
            return Err(DeviceError::Command("no room for a point".to_owned()));
        }
        self.next_point += 1;
        Ok(PointSlot(slot))
    }

    fn vector(&mut self) -> Result<Slot, DeviceError> {
        let slot = self.next_vector;
        if slot >= self.workspace.vector_slots {
            return Err(DeviceError::Command("no room for a vector".to_owned()));
        }
        self.next_vector += 1;
        Ok(Slot(slot))
    }

    fn start(
        &mut self,
        point: &PointSlot,
        gradient: &mut Slot,
        preconditioned: &mut Slot,
    ) -> Result<Start, DeviceError> {
        let stage = ClothStage {
            point: point.0,
            direction: NONE,
            gradient: gradient.0,
            preconditioned: preconditioned.0,
            ..self.stage
        };
        self.device
            .write(&self.workspace.transforms, 0, &[[DRIVE, DRIVE_STEP]]);
        let rows = [
            [ENERGY, NONE, NONE, NONE],
            [gradient.0, NONE, preconditioned.0, NONE],
            [DRIVE, NONE, DRIVE_STEP, NONE],
        ];
        let (_, products) = self.run(stage, &rows, |workspace, pass| {
            workspace.blocks.dispatch(pass);
            workspace.forces.dispatch(pass);
            workspace
                .precondition
                .dispatch(pass, [workspace.strides, 1]);
        })?;
        let [energy, norm, drive] = products[..] else {
            return Err(incomplete());
        };
        let (objective, round_off) = self.objective(&energy);
        Ok(Start {
            objective,
            round_off,
            norm_square: norm.plain,
            longest_m: norm.longest,
            reference: drive.plain.max(0.0).sqrt(),
        })
    }

    fn attempt(
        &mut self,
        from: &Step<'_, PointSlot, Slot>,
        to: &mut Landing<'_, PointSlot, Slot>,
        stored: &[&Slot],
    ) -> Result<Attempt, DeviceError> {
        let (gradient, preconditioned) = (to.gradient.0, to.preconditioned.0);
        let stage = ClothStage {
            point: to.point.0,
            start: from.point.0,
            direction: from.direction.0,
            gradient,
            preconditioned,
            length: from.length as f32,
            step_limit: from.step_limit_m.min(f64::from(f32::MAX)) as f32,
            ..self.stage
        };
        let mut rows = vec![
            [ENERGY, NONE, NONE, NONE],
            [gradient, from.gradient.0, from.direction.0, NONE],
            [
                gradient,
                from.gradient.0,
                preconditioned,
                from.preconditioned.0,
            ],
        ];
        rows.extend(
            stored
                .iter()
                .map(|vector| [gradient, from.gradient.0, vector.0, NONE]),
        );
        let (length, products) = self.run(stage, &rows, |workspace, pass| {
            workspace.advance.dispatch(pass, [workspace.strides, 1]);
            workspace.forces.dispatch(pass);
        })?;
        let [energy, along, norm, ref stored @ ..] = products[..] else {
            return Err(incomplete());
        };
        let (objective, round_off) = self.objective(&energy);
        Ok(Attempt {
            objective,
            round_off,
            length,
            slope: along.plain,
            slope_change: along.change,
            norm_square: norm.plain,
            gradient_change: norm.mixed,
            change_square: norm.change,
            longest_m: norm.longest,
            stored: stored.iter().map(|p| [p.plain, p.change]).collect(),
        })
    }

    fn refresh(
        &mut self,
        point: &PointSlot,
        gradient: &Slot,
        preconditioned: &mut Slot,
        pairs: &mut [(&Slot, &mut Slot)],
    ) -> Result<Refreshed, DeviceError> {
        let stage = ClothStage {
            point: point.0,
            direction: NONE,
            ..self.stage
        };
        let mut transforms = vec![[gradient.0, preconditioned.0], [DRIVE, DRIVE_STEP]];
        let mut rows = vec![
            [gradient.0, NONE, preconditioned.0, NONE],
            [DRIVE, NONE, DRIVE_STEP, NONE],
        ];
        for (y, z) in pairs.iter() {
            transforms.push([y.0, z.0]);
            rows.push([gradient.0, NONE, z.0, NONE]);
        }
        for i in 0..pairs.len() {
            for j in 0..=i {
                rows.push([pairs[i].0.0, NONE, pairs[j].1.0, NONE]);
            }
        }
        self.device
            .write(&self.workspace.transforms, 0, &transforms);
        let (_, products) = self.run(stage, &rows, |workspace, pass| {
            workspace.blocks.dispatch(pass);
            workspace
                .precondition
                .dispatch(pass, [workspace.strides, transforms.len() as u32]);
        })?;
        let [norm, drive, ref rest @ ..] = products[..] else {
            return Err(incomplete());
        };
        let plain = |products: &[Product]| products.iter().map(|p| p.plain).collect();
        let (of_gradient, of_pairs) = rest.split_at(pairs.len());
        Ok(Refreshed {
            norm_square: norm.plain,
            longest_m: norm.longest,
            gradient_change: plain(of_gradient),
            change_change: plain(of_pairs),
            reference: drive.plain.max(0.0).sqrt(),
        })
    }

    fn combine(&mut self, result: &mut Slot, terms: &[(f64, &Slot)]) -> Result<(), DeviceError> {
        let words = 2 + 2 * terms.len();
        if self.program.len() + words > self.workspace.program_words {
            // What was noted down so far is run first.
            self.run(
                ClothStage {
                    direction: NONE,
                    ..self.stage
                },
                &[[ENERGY, NONE, NONE, NONE]],
                |_, _| (),
            )?;
        }
        self.program.extend([result.0, terms.len() as u32]);
        for (coefficient, vector) in terms {
            self.program
                .extend([vector.0, (*coefficient as f32).to_bits()]);
        }
        self.operations += 1;
        Ok(())
    }
}
