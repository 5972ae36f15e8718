//! Stage `minimise` on the device (`shaders/minimise.wgsl`): the L-BFGS of [`crate::solve::lbfgs`] in time steps with block-Jacobi, many trials per submission.
//!
//! The host records a batch of trials. After each, one workgroup on the device decides what [`crate::solve::lbfgs::minimise`] would decide, in `f32`
//! instead of `f64`, and lays out the next; once it has ended it takes the workgroups of all further dispatches away. Where it stands comes back with
//! the positions in one transfer, so that most solves take one submission and one transfer instead of one per evaluation.

use glam::DVec3;

use crate::gpu::commands::{Commands, Pass};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;
use crate::gpu::transfer::Staging;
use crate::solve::lbfgs::{
    ARMIJO, LEAST_CURVATURE, LINE_SEARCH_LIMIT, OUT_OF_BALANCE, Options, Outcome, PROGRESS,
    REMAINDER, RETREAT, ROUND_OFF_LIMIT, SHORTER, STAGNATION_LIMIT, Stop, WOLFE, relative,
};

use super::elements::joined;
use super::gathering::BoundGathering;
use super::parameters::{ClothStage, Minimiser};
use super::vectors::{DRIVE, DRIVE_STEP, ENERGY, NONE, ROUND_OFF, Space};
use super::workspace::FIRST_FREE;

/// Longest history that the device has room for.
pub(super) const LONGEST_HISTORY: usize = 8;
/// Dot products of so many pairs and one more, what a direction is made of, and linear combinations before the next trial.
const GRAM_WORDS: usize = 216 + 52;
/// Why the minimiser ended, by its status; the first two have it go on.
const STOPS: [Option<Stop>; 8] = [
    None,
    None,
    Some(Stop::Converged),
    Some(Stop::RoundOff),
    Some(Stop::Stalled),
    Some(Stop::LimitReached),
    Some(Stop::NotFinite),
    Some(Stop::Indefinite),
];
/// Words of a node in what comes back: whole numbers and remainders of its position, H₀ g.
const NODE_WORDS: usize = 9;
/// Trials in the first batch of a solve, at least and at most.
const FIRST_BATCH: [usize; 2] = [4, 64];
/// Trials in every further one.
const FURTHER_BATCH: usize = 16;
/// Dispatches of a trial whose workgroups come before those of the elements: along vectors, products.
const ALONG_VECTORS: usize = 0;
const PRODUCTS: usize = 1;
const FIRST_ELEMENT: usize = 2;

/// What decides on the device, with its buffers.
#[derive(Debug)]
pub(super) struct Batches {
    minimiser: wgpu::Buffer,
    workgroups: wgpu::Buffer,
    delivered: wgpu::Buffer,
    staging: Staging,
    decide: Bound,
    deliver: Bound,
    /// The whole minimiser in one workgroup, where the fabric is small.
    small: Option<Bound>,
    nodes: usize,
}

/// What the shaders that decide know of the host's minimiser.
pub(super) fn decisions() -> [(&'static str, f64); 13] {
    [
        ("FIRST_FREE", f64::from(FIRST_FREE)),
        ("ROUND_OFF", ROUND_OFF),
        ("OUT_OF_BALANCE", OUT_OF_BALANCE),
        ("ARMIJO", ARMIJO),
        ("WOLFE", WOLFE),
        ("RETREAT", RETREAT),
        ("SHORTEST", SHORTER[0]),
        ("SHORTENED", SHORTER[1]),
        ("LEAST_CURVATURE", LEAST_CURVATURE),
        ("PROGRESS", PROGRESS),
        ("LINE_SEARCH_LIMIT", LINE_SEARCH_LIMIT as f64),
        ("STAGNATION_LIMIT", STAGNATION_LIMIT as f64),
        ("ROUND_OFF_LIMIT", ROUND_OFF_LIMIT as f64),
    ]
}

/// What comes back after a batch.
#[derive(Debug, Default)]
struct Brought {
    state: Minimiser,
    /// Positions of the nodes once the minimiser has ended [m].
    positions_m: Vec<DVec3>,
    /// H₀ g of the nodes, then [m].
    preconditioned: Vec<[f32; 3]>,
}

/// Evaluations to be expected of the next solve, where so many were expected of this one and it took `evaluations`: rather too many, since a trial
/// without workgroups costs a tenth of what another batch does.
pub(super) const fn expected_next(expected: usize, evaluations: usize) -> usize {
    let more = evaluations + evaluations / 4 + 2;
    let less = expected - expected / 10;
    if more > less { more } else { less }
}

/// Why the minimiser ended; `None` while it runs.
fn stop(state: &Minimiser) -> Option<Stop> {
    STOPS.get(state.status as usize).copied().flatten()
}

/// How a solve ended.
#[derive(Debug)]
pub(super) struct Solved {
    pub outcome: Outcome,
    /// Positions [m].
    pub positions_m: Vec<DVec3>,
    /// H₀ g at the end, where positions cannot hold it; empty where they can [m].
    pub remainder: Vec<[f32; 3]>,
}

impl Batches {
    /// Of a structure with `buffers`, those of its workspace among them.
    pub fn new(
        device: &Device,
        buffers: &[(&str, &wgpu::Buffer)],
        nodes: usize,
        constants: &[(&str, f64)],
        (forces, small): (&BoundGathering, Option<&Pipeline>),
    ) -> Result<Self, DeviceError> {
        let mut constants = constants.to_vec();
        constants.extend(decisions());
        let [decide, deliver] =
            device.pipelines(&shaders::MINIMISE, ["decide", "deliver"], &constants)?;
        let state_bytes = size_of::<Minimiser>() as u64;
        let node_bytes = (4 * NODE_WORDS * nodes) as u64;
        let minimiser = device.storage("cloth minimiser", state_bytes)?;
        let gram = device.storage("cloth gram matrix", 4 * GRAM_WORDS as u64)?;
        let workgroups = device.buffer(
            "cloth workgroups",
            (12 * (FIRST_ELEMENT + forces.len())) as u64,
            wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::INDIRECT
                | wgpu::BufferUsages::COPY_DST,
        )?;
        let delivered = device.storage("cloth delivered", node_bytes)?;
        let mut all = buffers.to_vec();
        let stage = buffers.iter().filter(|(name, _)| *name == "stage");
        all.extend(stage.map(|(_, buffer)| ("next_stage", *buffer)));
        all.extend([
            ("minimiser", &minimiser),
            ("gram_between", &gram),
            ("workgroups", &workgroups),
            ("delivered", &delivered),
        ]);
        Ok(Self {
            staging: Staging::new(device, state_bytes + node_bytes)?,
            decide: device.bind(&decide, &all)?,
            deliver: device.bind(&deliver, &all)?,
            small: small.map(|small| device.bind(small, &all)).transpose()?,
            minimiser,
            workgroups,
            delivered,
            nodes,
        })
    }

    /// Records where the minimiser stands, to be read.
    fn bring_back(&self, commands: &mut Commands) {
        let state_bytes = size_of::<Minimiser>() as u64;
        let node_bytes = (4 * NODE_WORDS * self.nodes) as u64;
        self.staging
            .copy(commands, &self.minimiser, 0, 0, state_bytes);
        self.staging
            .copy(commands, &self.delivered, 0, state_bytes, node_bytes);
    }

    /// Waits for what was brought back.
    fn read(&self, device: &Device) -> Result<Brought, DeviceError> {
        let mut found = Brought::default();
        self.staging.read(device, |bytes| {
            let (state, nodes) = bytes.split_at(size_of::<Minimiser>());
            found.state = bytemuck::pod_read_unaligned(state);
            if stop(&found.state).is_none() {
                return;
            }
            let words: Vec<[u32; NODE_WORDS]> =
                bytemuck::pod_collect_to_vec(&nodes[..4 * NODE_WORDS * self.nodes]);
            let position = |node: &[u32; NODE_WORDS]| {
                let axis = |a: usize| joined(node[a].cast_signed(), f32::from_bits(node[3 + a]));
                DVec3::new(axis(0), axis(1), axis(2))
            };
            found.positions_m = words.iter().map(position).collect();
            found.preconditioned = words
                .iter()
                .map(|node| [6, 7, 8].map(|word: usize| f32::from_bits(node[word])))
                .collect();
        })?;
        Ok(found)
    }
}

impl Space<'_> {
    /// Minimises from the prediction, which is the first point, in about so many evaluations as expected.
    pub(super) fn minimise_in_batches(
        &mut self,
        options: &Options,
        expected: usize,
    ) -> Result<Solved, DeviceError> {
        let batches = &self.workspace.batches;
        let mut trials = expected.clamp(FIRST_BATCH[0], FIRST_BATCH[1]);
        self.ask(options);
        let mut commands = self.device.record("cloth");
        let mut pass = commands.pass("cloth minimise");
        self.workspace.blocks.dispatch(&mut pass);
        if batches.small.is_none() {
            self.start_minimising(&mut pass);
        }
        loop {
            if let Some(small) = &batches.small {
                small.dispatch(&mut pass, [1, 1]);
            } else {
                for _ in 0..trials {
                    self.trial(&mut pass);
                }
                let groups = self.device.workgroups(batches.nodes as u64);
                batches.deliver.dispatch(&mut pass, groups);
            }
            drop(pass);
            batches.bring_back(&mut commands);
            self.device.submit(commands);
            let brought = batches.read(self.device)?;
            if let Some(stop) = stop(&brought.state) {
                let mut remainder = brought.preconditioned;
                let longest_m = f64::from(brought.state.longest);
                if stop != Stop::Converged || longest_m > REMAINDER * options.displacement_floor_m {
                    remainder.clear();
                }
                return Ok(Solved {
                    outcome: self.outcome(&brought.state, stop),
                    positions_m: brought.positions_m,
                    remainder,
                });
            }
            trials = FURTHER_BATCH;
            commands = self.device.record("cloth");
            pass = commands.pass("cloth minimise");
        }
    }

    fn outcome(&self, state: &Minimiser, stop: Stop) -> Outcome {
        let norm = f64::from(state.norm);
        Outcome {
            stop,
            iterations: state.iterations as usize,
            evaluations: state.evaluations as usize,
            energy_norm: norm,
            relative_norm: relative(norm, f64::from(state.scale)),
            objective: f64::from(state.objective) + self.constant_j,
        }
    }

    /// Uploads what a solve starts from.
    fn ask(&self, options: &Options) {
        let workspace = self.workspace;
        let batches = &workspace.batches;
        let (gradient, preconditioned) = (FIRST_FREE, FIRST_FREE + 1);
        let rows = [
            [ENERGY, NONE, NONE, NONE],
            [gradient, NONE, preconditioned, NONE],
            [DRIVE, NONE, DRIVE_STEP, NONE],
        ];
        let stage = ClothStage {
            point: 0,
            direction: NONE,
            gradient,
            preconditioned,
            step_limit: options.step_limit_m.min(f64::from(f32::MAX)) as f32,
            ..self.stage
        };
        let minimiser = Minimiser {
            tolerance: options.tolerance as f32,
            displacement_floor: options.displacement_floor_m as f32,
            history: options.history as u32,
            evaluation_limit: u32::try_from(options.evaluation_limit).unwrap_or(u32::MAX),
            rows: rows.len() as u32,
            point: stage.point,
            gradient,
            preconditioned,
            ..Minimiser::default()
        };
        let device = self.device;
        device.write(self.stage_buffer, 0, &[stage]);
        device.write(&batches.minimiser, 0, &[minimiser]);
        if batches.small.is_some() {
            return;
        }
        let mut workgroups = vec![[0; 3]; FIRST_ELEMENT];
        workgroups[ALONG_VECTORS] = [workspace.strides, 1, 1];
        workgroups[PRODUCTS] = [workspace.product_strides, 1, 1];
        workgroups.extend(workspace.forces.groups().map(|[x, y]| [x, y, 1]));
        device.write(&workspace.rows, 0, &rows);
        device.write(&workspace.transforms, 0, &[[DRIVE, DRIVE_STEP]]);
        device.write(&batches.workgroups, 0, &workgroups);
    }

    /// The objective at the prediction, and what follows from it.
    fn start_minimising(&self, pass: &mut Pass<'_>) {
        let workspace = self.workspace;
        workspace.forces.dispatch(pass);
        workspace
            .precondition
            .dispatch(pass, [workspace.strides, 1]);
        workspace
            .products
            .dispatch(pass, [workspace.product_strides, 3]);
        workspace.batches.decide.dispatch(pass, [1, 1]);
    }

    /// One trial, with as many workgroups as the device has decided on; what decides on them has its one always.
    fn trial(&self, pass: &mut Pass<'_>) {
        let workspace = self.workspace;
        let batches = &workspace.batches;
        let groups = &batches.workgroups;
        for vectors in [&workspace.combine, &workspace.advance] {
            vectors.dispatch_indirect(pass, groups, ALONG_VECTORS);
        }
        workspace
            .forces
            .dispatch_indirect(pass, groups, FIRST_ELEMENT);
        workspace.products.dispatch_indirect(pass, groups, PRODUCTS);
        batches.decide.dispatch(pass, [1, 1]);
    }
}
