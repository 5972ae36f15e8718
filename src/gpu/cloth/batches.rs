//! Stage `minimise` on the device: the L-BFGS of [`crate::solve::lbfgs`] in time steps with block-Jacobi, many trials per submission.
//!
//! The host records a batch of trials. After each, one workgroup decides what [`crate::solve::lbfgs::minimise`] would decide, in `f32` instead of `f64`
//! (`shaders/minimise.wgsl`), and lays out the next. Once it has ended, all further dispatches have no workgroups. Where it stands comes back with the
//! positions in one transfer.

use glam::DVec3;

use crate::gpu::commands::Pass;
use crate::gpu::error::DeviceError;
use crate::solve::lbfgs::{Options, Outcome, REMAINDER, Stop, relative};

use super::decisions::{ALONG_VECTORS, Brought, FIRST_ELEMENT, PRODUCTS, stop};
use super::parameters::{ClothStage, Minimiser};
use super::slots::{DRIVE, DRIVE_STEP, ENERGY, FIRST_FREE, NONE};
use super::vectors::Space;

/// Trials in the first batch of a solve, at least and at most.
const FIRST_BATCH: [usize; 2] = [4, 64];
/// Rows of products of a start.
const START_ROWS: usize = 3;
/// Trials in every further one.
const FURTHER_BATCH: usize = 16;

/// Evaluations to be expected of the next solve, where so many were expected of this one and it took `evaluations`. They are rather too many: a trial
/// without workgroups is cheap beside another batch.
pub(super) const fn expected_next(expected: usize, evaluations: usize) -> usize {
    let more = evaluations + evaluations / 4 + 2;
    let less = expected - expected / 10;
    if more > less { more } else { less }
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

impl Space<'_> {
    /// Minimises from the prediction, which is the first point, in about so many evaluations as expected.
    pub(super) fn minimise_in_batches(
        &self,
        options: &Options,
        expected: usize,
    ) -> Result<Solved, DeviceError> {
        self.begin(options, expected);
        loop {
            let brought = self.bring()?;
            if let Some(solved) = self.solved(brought, options) {
                return Ok(solved);
            }
            self.go_on();
        }
    }

    /// Leaves the first batch to the next submission. Where the device has the air, it begins with the reactions at the markers.
    pub(super) fn begin(&self, options: &Options, expected: usize) {
        let decisions = &self.workspace.decisions;
        self.ask(options);
        let mut commands = self.device.record("cloth");
        {
            let mut pass = commands.pass("cloth minimise");
            if let Some(in_air) = &decisions.in_air {
                in_air.react(self.device, &mut pass);
            }
            self.workspace.blocks.dispatch(&mut pass);
            if decisions.small.is_none() {
                self.start_minimising(&mut pass);
            }
            self.batch(&mut pass, expected.clamp(FIRST_BATCH[0], FIRST_BATCH[1]));
        }
        self.device.leave(commands);
    }

    /// Leaves a further batch to the next submission.
    pub(super) fn go_on(&self) {
        let mut commands = self.device.record("cloth");
        self.batch(&mut commands.pass("cloth minimise"), FURTHER_BATCH);
        self.device.leave(commands);
    }

    /// So many trials, and where they lead.
    fn batch(&self, pass: &mut Pass<'_>, trials: usize) {
        let decisions = &self.workspace.decisions;
        if let Some(small) = &decisions.small {
            small.bound.dispatch(pass, [1, 1]);
            return;
        }
        for _ in 0..trials {
            self.trial(pass);
        }
        let groups = self.device.workgroups(decisions.nodes as u64);
        decisions.deliver.dispatch(pass, groups);
    }

    /// Submits what was left, and waits for where the minimiser stands.
    pub(super) fn bring(&self) -> Result<Brought, DeviceError> {
        let decisions = &self.workspace.decisions;
        let mut commands = self.device.record("cloth solution");
        decisions.bring_back(&mut commands);
        self.device.submit(commands);
        decisions.read(self.device)
    }

    /// How it ended; `None` while it has not.
    pub(super) fn solved(&self, brought: Brought, options: &Options) -> Option<Solved> {
        let stop = stop(&brought.state)?;
        let mut remainder = brought.preconditioned;
        let longest_m = f64::from(brought.state.longest);
        if stop != Stop::Converged || longest_m > REMAINDER * options.displacement_floor_m {
            remainder.clear();
        }
        Some(Solved {
            outcome: self.outcome(&brought.state, stop),
            positions_m: brought.positions_m,
            remainder,
        })
    }

    /// Where the minimiser stood when it stopped.
    pub(super) fn outcome(&self, state: &Minimiser, stop: Stop) -> Outcome {
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

    /// Stage and minimiser as a solve starts.
    pub(super) fn start_of(&self, options: &Options) -> (ClothStage, Minimiser) {
        let (gradient, preconditioned) = (FIRST_FREE, FIRST_FREE + 1);
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
            rows: START_ROWS as u32,
            point: stage.point,
            gradient,
            preconditioned,
            ..Minimiser::default()
        };
        (stage, minimiser)
    }

    /// Uploads what a solve starts from.
    fn ask(&self, options: &Options) {
        let workspace = self.workspace;
        let decisions = &workspace.decisions;
        let (stage, minimiser) = self.start_of(options);
        let rows: [[u32; 4]; START_ROWS] = [
            [ENERGY, NONE, NONE, NONE],
            [stage.gradient, NONE, stage.preconditioned, NONE],
            [DRIVE, NONE, DRIVE_STEP, NONE],
        ];
        let device = self.device;
        device.write(self.stage_buffer, 0, &[stage]);
        device.write(&decisions.minimiser, 0, &[minimiser]);
        if decisions.small.is_some() {
            return;
        }
        let mut workgroups = vec![[0; 3]; FIRST_ELEMENT];
        workgroups[ALONG_VECTORS] = [workspace.strides, 1, 1];
        workgroups[PRODUCTS] = [workspace.product_strides, 1, 1];
        workgroups.extend(workspace.forces.groups().map(|[x, y]| [x, y, 1]));
        device.write(&workspace.rows, 0, &rows);
        device.write(&workspace.transforms, 0, &[[DRIVE, DRIVE_STEP]]);
        device.write(&decisions.workgroups, 0, &workgroups);
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
        workspace.decisions.decide.dispatch(pass, [1, 1]);
    }

    /// One trial, with as many workgroups as the device has decided on; what decides on them has its one always.
    fn trial(&self, pass: &mut Pass<'_>) {
        let workspace = self.workspace;
        let decisions = &workspace.decisions;
        let groups = &decisions.workgroups;
        for vectors in [&workspace.combine, &workspace.advance] {
            vectors.dispatch_indirect(pass, groups, ALONG_VECTORS);
        }
        workspace
            .forces
            .dispatch_indirect(pass, groups, FIRST_ELEMENT);
        workspace.products.dispatch_indirect(pass, groups, PRODUCTS);
        decisions.decide.dispatch(pass, [1, 1]);
    }
}
