//! The minimiser's vectors on the device (`shaders/vectors.wgsl`): [`VectorSpace`] with one transfer to the host per trial, where the host decides.
//!
//! Linear combinations are only noted down when they are asked for; the next trial uploads them as a small program, which runs
//! node by node before the step. Sums come back as one number per workgroup and are added on the host in `f64`, always in the
//! same order.

use glam::DVec3;

use crate::gpu::commands::{Commands, Pass};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::multigrid::Multigrid;
use crate::solve::{Attempt, Landing, Refreshed, Start, Step, VectorSpace};

use super::gathering::BoundGathering;
use super::parameters::ClothStage;
use super::points::{PointSlot, Points};
use super::slots::{DRIVE, DRIVE_STEP, ENERGY, FIRST_FREE, NONE, POINTS, ROUND_OFF};
use super::stiffness::Stiffness;
use super::workspace::{ENTRY, HEADER, Workspace};

/// A vector on the device.
#[derive(Debug)]
pub(super) struct Slot(pub u32);

/// One row of products (a, a′, b, b′).
#[derive(Debug, Clone, Copy)]
pub(super) struct Product {
    /// a·b; of the energies: their sum.
    pub plain: f64,
    /// (a − a′)·(b − b′); of the energies: the sum of their magnitudes.
    pub change: f64,
    /// a·(b − b′)
    mixed: f64,
    /// Longest displacement in b; NaN if an element is not finite.
    longest: f64,
}

/// Multigrid as H₀, in place of block-Jacobi.
#[derive(Debug)]
pub(super) struct MultigridHessian<'a> {
    pub multigrid: &'a Multigrid,
    pub stiffness: &'a Stiffness,
    pub gradient: BoundGathering,
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
    /// Absent where H₀ is block-Jacobi.
    pub multigrid: Option<MultigridHessian<'a>>,
    /// To be read by who watches.
    pub points: Option<Points<'a>>,
    nodes: usize,
    /// H₀ g at the end, where positions cannot hold it; empty where they can [m].
    pub remainder: Vec<[f32; 3]>,
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
        nodes: usize,
    ) -> Self {
        Self {
            nodes,
            remainder: Vec::new(),
            device,
            workspace,
            stage_buffer,
            stage,
            constant_j,
            multigrid: None,
            points: None,
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
    pub(super) fn run(
        &mut self,
        stage: ClothStage,
        rows: &[[u32; 4]],
        dispatches: impl FnOnce(&Self, &mut Commands) -> Result<(), DeviceError>,
    ) -> Result<(f64, Vec<Product>), DeviceError> {
        let workspace = self.workspace;
        self.upload(stage);
        self.device.write(&workspace.rows, 0, rows);
        let mut commands = self.device.record("cloth");
        self.combine_now(&mut commands);
        dispatches(self, &mut commands)?;
        {
            let mut pass = commands.pass("cloth products");
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

    /// Records the program that was uploaded.
    fn combine_now(&self, commands: &mut Commands) {
        let mut pass = commands.pass("cloth combine");
        let groups = [self.workspace.strides, 1];
        self.workspace.combine.dispatch(&mut pass, groups);
    }

    /// Energy and gradient of the point; and H₀ times the gradient where H₀ is block-Jacobi.
    fn evaluate(&self, pass: &mut Pass<'_>) {
        match &self.multigrid {
            Some(hessian) => hessian.gradient.dispatch(pass),
            None => self.workspace.forces.dispatch(pass),
        }
    }

    /// Moves and evaluates, as `stage_of_trial` says.
    pub(super) fn move_and_evaluate(&self, commands: &mut Commands) {
        let mut pass = commands.pass("cloth attempt");
        let groups = [self.workspace.strides, 1];
        self.workspace.advance.dispatch(&mut pass, groups);
        self.evaluate(&mut pass);
    }

    /// Parameters of a trial that writes its gradient and, with block-Jacobi, H₀ times it.
    pub(super) fn stage_of_trial(
        &self,
        from: &Step<'_, PointSlot, Slot>,
        point: &PointSlot,
        [gradient, preconditioned]: [&Slot; 2],
    ) -> ClothStage {
        ClothStage {
            point: point.0,
            start: from.point.0,
            direction: from.direction.0,
            gradient: gradient.0,
            preconditioned: preconditioned.0,
            length: from.length as f32,
            step_limit: from.step_limit_m.min(f64::from(f32::MAX)) as f32,
            ..self.stage
        }
    }

    /// H₀ times vectors, (from, to).
    pub(super) fn precondition(
        &self,
        commands: &mut Commands,
        transforms: &[[u32; 2]],
    ) -> Result<(), DeviceError> {
        let workspace = self.workspace;
        if let Some(hessian) = &self.multigrid {
            for slots in transforms {
                let places = slots.map(|slot| u64::from(slot) * workspace.vector_bytes);
                hessian
                    .multigrid
                    .cycle(commands, &workspace.vectors, places)?;
            }
            return Ok(());
        }
        self.device.write(&workspace.transforms, 0, transforms);
        let mut pass = commands.pass("cloth precondition");
        workspace
            .precondition
            .dispatch(&mut pass, [workspace.strides, transforms.len() as u32]);
        Ok(())
    }

    /// Rebuilds multigrid around the point of `stage`, where it is H₀; `first` in a solve.
    fn rebuild(&mut self, stage: ClothStage, first: bool) -> Result<(), DeviceError> {
        if self.multigrid.is_none() {
            return Ok(());
        }
        self.upload(stage);
        let mut commands = self.device.record("cloth stiffness");
        self.combine_now(&mut commands);
        let Some(hessian) = &self.multigrid else {
            return Ok(());
        };
        commands
            .raw
            .clear_buffer(hessian.multigrid.finest()?.0, 0, None);
        {
            let mut pass = commands.pass("cloth stiffness");
            hessian
                .stiffness
                .dispatch(&mut pass, self.stage.inertia > 0.0);
        }
        hessian.multigrid.refresh(&mut commands, first)?;
        self.device.submit(commands);
        hessian.multigrid.invert_coarsest(self.device)
    }

    /// Records block-Jacobi around the point, where it is H₀.
    fn rebuild_blocks(&self, pass: &mut Pass<'_>) {
        if self.multigrid.is_none() {
            self.workspace.blocks.dispatch(pass);
        }
    }

    pub(super) fn objective(&self, energy: &Product) -> (f64, f64) {
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

pub(super) fn incomplete() -> DeviceError {
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

    /// A device that fails says so in the next trial.
    fn positions_m(&self, point: &PointSlot) -> Option<Vec<DVec3>> {
        self.points.as_ref()?.positions_m(point).ok()
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
        let rows = [
            [ENERGY, NONE, NONE, NONE],
            [gradient.0, NONE, preconditioned.0, NONE],
            [DRIVE, NONE, DRIVE_STEP, NONE],
        ];
        let mut transforms = vec![[DRIVE, DRIVE_STEP]];
        if self.multigrid.is_some() {
            transforms.push([gradient.0, preconditioned.0]);
        }
        self.rebuild(stage, true)?;
        let (_, products) = self.run(stage, &rows, |space, commands| {
            {
                let mut pass = commands.pass("cloth start");
                space.rebuild_blocks(&mut pass);
                space.evaluate(&mut pass);
            }
            space.precondition(commands, &transforms)
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
        let stage = self.stage_of_trial(from, to.point, [to.gradient, to.preconditioned]);
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
        let (length, products) = self.run(stage, &rows, |space, commands| {
            space.move_and_evaluate(commands);
            if space.multigrid.is_some() {
                space.precondition(commands, &[[gradient, preconditioned]])?;
            }
            Ok(())
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
        self.rebuild(stage, false)?;
        let (_, products) = self.run(stage, &rows, |space, commands| {
            space.rebuild_blocks(&mut commands.pass("cloth blocks"));
            space.precondition(commands, &transforms)
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

    fn remainder(&mut self, preconditioned: &Slot) -> Result<(), DeviceError> {
        let first = preconditioned.0 as usize * self.nodes;
        let vectors = &self.workspace.vectors;
        self.remainder = self.device.read(vectors, first, self.nodes)?;
        Ok(())
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
                |_, _| Ok(()),
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
