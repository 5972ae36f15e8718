//! Steps that a device makes by itself, where it has air and fabric: the fabric goes from the end of one solve to the start of the next without the host
//! (`shaders/fabric_motion.wgsl`). What every step found waits on the device until the host asks for several of them at once.
//!
//! Positions are whole numbers of 2⁻⁴⁰ m, on the device and on the host, and velocities follow from them: it does not matter how many steps are made at once.
//!
//! *Departure from steps with the host*: that rounding. A solve that does not end stands as it is, as
//! where the host has come to its limit of evaluations.

use std::collections::VecDeque;

use glam::DVec3;

use crate::cloth::Structure;
use crate::cpu::cloth::integration::StepBase;
use crate::cpu::cloth::{Cloth as State, InitialHessian, SolverSettings, StepInput};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;
use crate::gpu::transfer::Staging;
use crate::solve::lbfgs::{Options, Outcome, REMAINDER, Stop};

use super::decisions::stop;
use super::elements::{UNITS_PER_M, damped_cables, joined};
use super::parameters::{ClothStage, FabricMotion, Minimiser};
use super::solve_cloth::{base, device_options};
use super::{AtMarkers, Cloth, Solution};

/// Bytes that wait on the device at most.
const MOST_BYTES: u64 = 64 << 20;

/// Where nodes and markers are while the device makes steps by itself.
#[derive(Debug, Clone)]
pub struct NodesOnDevice {
    /// Positions in fixed point.
    pub(in crate::gpu) whole: wgpu::Buffer,
    pub(in crate::gpu) remainder: wgpu::Buffer,
    /// Nodes and weights of the markers.
    pub(in crate::gpu) fabric_markers: wgpu::Buffer,
}

/// Pipelines, and what goes on from step to step.
#[derive(Debug)]
pub(super) struct OwnStepPipelines {
    predict: Pipeline,
    marker_velocities: Pipeline,
    end_step: Pipeline,
    parameters: wgpu::Buffer,
    whole: wgpu::Buffer,
    remainder: wgpu::Buffer,
    /// Ways of the last three steps.
    ways_whole: wgpu::Buffer,
    ways_remainder: wgpu::Buffer,
    base_velocities: wgpu::Buffer,
}

/// The same with all buffers.
#[derive(Debug)]
pub(super) struct OwnSteps {
    predict: Bound,
    marker_velocities: Bound,
    end_step: Bound,
    whole: wgpu::Buffer,
    remainder: wgpu::Buffer,
    nodes: usize,
}

/// Steps that were begun, in order.
#[derive(Debug)]
pub(super) struct Series {
    options: Options,
    /// Stage and minimiser as every solve starts.
    start: wgpu::Buffer,
    staging: Staging,
    step_bytes: u64,
    steps: usize,
    submitted: Option<wgpu::SubmissionIndex>,
    /// Of steps that the host has not taken.
    brought: VecDeque<Vec<u8>>,
}

impl OwnStepPipelines {
    /// For a structure with so many markers; `None` where a step needs more of the host.
    pub fn new(
        device: &Device,
        structure: &Structure,
        markers: usize,
    ) -> Result<Option<Self>, DeviceError> {
        if damped_cables(structure).next().is_some() || structure.has_line_drag() {
            return Ok(None);
        }
        let nodes = structure.node_count() as u64;
        let constants = [("NODES", nodes as f64), ("MARKERS", markers as f64)];
        let entries = ["predict", "marker_velocities", "end_step"];
        let [predict, marker_velocities, end_step] =
            device.pipelines(&shaders::FABRIC_MOTION, entries, &constants)?;
        Ok(Some(Self {
            predict,
            marker_velocities,
            end_step,
            parameters: device.uniform::<FabricMotion>("fabric motion")?,
            whole: device.storage("node positions", 12 * nodes)?,
            remainder: device.storage("node remainders", 12 * nodes)?,
            ways_whole: device.storage("ways of nodes", 36 * nodes)?,
            ways_remainder: device.storage("remainders of ways", 36 * nodes)?,
            base_velocities: device.storage("predicted velocities", 12 * nodes)?,
        }))
    }

    /// Gives them their buffers.
    pub fn bind(
        &self,
        device: &Device,
        buffers: &[(&str, &wgpu::Buffer)],
        nodes: usize,
    ) -> Result<OwnSteps, DeviceError> {
        let mut all = buffers.to_vec();
        all.extend([
            ("motion", &self.parameters),
            ("nodes_whole", &self.whole),
            ("nodes_remainder", &self.remainder),
            ("ways_whole", &self.ways_whole),
            ("ways_remainder", &self.ways_remainder),
            ("base_velocities", &self.base_velocities),
        ]);
        Ok(OwnSteps {
            predict: device.bind(&self.predict, &all)?,
            marker_velocities: device.bind(&self.marker_velocities, &all)?,
            end_step: device.bind(&self.end_step, &all)?,
            whole: self.whole.clone(),
            remainder: self.remainder.clone(),
            nodes,
        })
    }

    /// Where nodes are.
    pub fn nodes(&self, fabric_markers: &wgpu::Buffer) -> NodesOnDevice {
        NodesOnDevice {
            whole: self.whole.clone(),
            remainder: self.remainder.clone(),
            fabric_markers: fabric_markers.clone(),
        }
    }

    /// Uploads where the fabric is, and its last ways.
    fn upload(&self, device: &Device, state: &State, base: &StepBase, parameters: FabricMotion) {
        let (whole, remainder) = placed(&state.positions_m);
        let ways: Vec<DVec3> = (0..state.positions_m.len())
            .flat_map(|node| last_ways_m(state, node, base))
            .collect();
        let (ways_whole, ways_remainder) = placed(&ways);
        device.write(&self.parameters, 0, &[parameters]);
        device.write(&self.whole, 0, &whole);
        device.write(&self.remainder, 0, &remainder);
        device.write(&self.ways_whole, 0, &ways_whole);
        device.write(&self.ways_remainder, 0, &ways_remainder);
    }
}

/// Ways of a node in the last three steps [m], the last one first: those from which its velocities follow.
///
/// With h v = d for backward Euler, and h vⁿ = d₁ − d₂/3, h vⁿ⁻¹ = d₂ − d₃/3 for BDF2 in equal steps. Within some 300 m of the origin round-off of the velocities
/// is below half of 2⁻⁴⁰ m, so that they are the device's own.
fn last_ways_m(state: &State, node: usize, base: &StepBase) -> [DVec3; 3] {
    let h = base.time_step_s.unwrap_or_default();
    let moved = state.velocities_m_s[node] * h;
    match &state.step_before {
        _ if state.structure.held[node] => [DVec3::ZERO; 3],
        Some(before) if base.share > 0.0 => {
            let first = state.positions_m[node] - before.positions_m[node];
            let second = (first - moved) / base.share;
            let third = (second - before.velocities_m_s[node] * h) / base.share;
            [first, second, third]
        }
        _ => [moved, DVec3::ZERO, DVec3::ZERO],
    }
}

/// Places in fixed point, as the device leaves them: whole numbers of 2⁻⁴⁰ m, remainders from −½ to below ½ of a unit.
fn placed(positions_m: &[DVec3]) -> (Vec<i32>, Vec<f32>) {
    let coordinates = positions_m.iter().flat_map(|x| x.to_array());
    let place = |x: f64| {
        let settled = (x * FINEST_PER_M).round() / FINEST_PER_M;
        let whole = (settled * UNITS_PER_M + 0.5).floor();
        (whole as i32, (settled - whole / UNITS_PER_M) as f32)
    };
    coordinates.map(place).unzip()
}

/// 2⁻⁴⁰ m is the finest place.
const FINEST_PER_M: f64 = (1_u64 << 40) as f64;

impl OwnSteps {
    /// What comes back of the nodes after a step, and its bytes.
    pub fn parts(&self) -> [(&wgpu::Buffer, u64); 2] {
        let bytes = 12 * self.nodes as u64;
        [(&self.whole, bytes), (&self.remainder, bytes)]
    }

    /// Positions that came back [m].
    fn brought(&self, bytes: &[u8]) -> Vec<DVec3> {
        let (whole, remainder) = bytes.split_at(12 * self.nodes);
        let whole: Vec<[i32; 3]> = bytemuck::pod_collect_to_vec(whole);
        let remainder: Vec<[f32; 3]> = bytemuck::pod_collect_to_vec(remainder);
        let position = |(whole, remainder): (&[i32; 3], &[f32; 3])| {
            DVec3::from_array(std::array::from_fn(|a| joined(whole[a], remainder[a])))
        };
        whole.iter().zip(&remainder).map(position).collect()
    }
}

impl Cloth {
    /// Where its nodes are while the device makes steps by itself; `None` where it cannot.
    #[must_use]
    pub fn nodes_on_device(&self) -> Option<NodesOnDevice> {
        let own_steps = self.in_air.as_ref()?.own_steps.as_ref()?;
        let decisions = &self.workspace.as_ref()?.decisions;
        let markers = self.buffer("markers").ok()?;
        (decisions.small.is_some()).then(|| own_steps.nodes(markers))
    }

    /// Steps that can wait on the device together.
    #[must_use]
    pub fn most_own_steps(&self) -> u64 {
        let bytes = self
            .workspace
            .as_ref()
            .map_or(1, |w| w.decisions.own_step_bytes());
        MOST_BYTES / bytes.max(1)
    }

    /// Has the device make at most so many steps by itself from a `state` on, in each of which acts what `input` says. [`Cloth::make_own_step`] records each of them.
    pub fn begin_own_steps(
        &mut self,
        (state, input): (&State, &StepInput),
        settings: &SolverSettings,
        most: usize,
    ) -> Result<(), DeviceError> {
        self.send_nodes(state, input, settings)?;
        // The device writes the loads of every step itself.
        self.loads.clear();
        let options = device_options(&state.structure, input, settings);
        let base = base(state, input);
        let parameters = FabricMotion {
            share: base.share as f32,
            rate: base.time_step_s.map_or(0.0, |h| 1.0 / h) as f32,
            damping: input.damping_1_s as f32,
            longest_remainder: (REMAINDER * options.displacement_floor_m) as f32,
        };
        let own_steps = self.in_air.as_ref().and_then(|air| air.own_steps.as_ref());
        let own_steps = own_steps.ok_or_else(not_begun)?;
        own_steps.upload(&self.device, state, &base, parameters);
        let space = self.space(0.0, settings.initial_hessian)?;
        let (stage, minimiser) = space.start_of(&options);
        let device = &self.device;
        let step_bytes = self.workspace()?.decisions.own_step_bytes();
        let start = device.storage("start of a solve", STAGE_BYTES + MINIMISER_BYTES)?;
        device.write(&start, 0, &[stage]);
        let words: &[u32] = bytemuck::cast_slice(std::slice::from_ref(&minimiser));
        device.write(&start, STAGE_BYTES as usize / 4, words);
        let series = Series {
            options,
            start,
            staging: Staging::new(device, step_bytes * most as u64)?,
            step_bytes,
            steps: 0,
            submitted: None,
            brought: VecDeque::new(),
        };
        drop(space);
        self.series = Some(series);
        Ok(())
    }

    /// Records the next step of the fabric, at markers whose air is known, with the forces of the markers on the air.
    pub fn make_own_step(&mut self) -> Result<(), DeviceError> {
        let workspace = self.workspace.as_ref().ok_or_else(not_begun)?;
        let series = self.series.as_ref().ok_or_else(not_begun)?;
        let decisions = &workspace.decisions;
        let (Some(in_air), Some(small)) = (&decisions.in_air, &decisions.small) else {
            return Err(not_begun());
        };
        let own_steps = in_air.own_steps.as_ref().ok_or_else(not_begun)?;
        let device = &self.device;
        let nodes = device.workgroups(decisions.nodes as u64);
        let markers = device.workgroups(in_air.marker_count() as u64);
        let buffer = |wanted: &str| self.buffer(wanted);
        let node_bytes = 12 * decisions.nodes as u64;
        let mut commands = device.record("fabric step");
        {
            let mut pass = commands.pass("fabric step");
            own_steps.predict.dispatch(&mut pass, nodes);
            own_steps.marker_velocities.dispatch(&mut pass, markers);
        }
        // A solve starts at the prediction, which is point 0.
        for (from, at, to, bytes) in [
            (&series.start, 0, buffer("stage")?, STAGE_BYTES),
            (
                &series.start,
                STAGE_BYTES,
                &decisions.minimiser,
                MINIMISER_BYTES,
            ),
            (buffer("predicted_whole")?, 0, buffer("whole")?, node_bytes),
            (
                buffer("predicted_remainder")?,
                0,
                buffer("remainder")?,
                node_bytes,
            ),
        ] {
            commands.raw.copy_buffer_to_buffer(from, at, to, 0, bytes);
        }
        {
            let mut pass = commands.pass("fabric step");
            in_air.react(device, &mut pass);
            workspace.blocks.dispatch(&mut pass);
            for _ in 0..small.dispatches(series.options.evaluation_limit) {
                small.bound.dispatch(&mut pass, [1, 1]);
            }
            own_steps.end_step.dispatch(&mut pass, nodes);
            in_air.record_back(device, &mut pass);
        }
        let at = series.step_bytes * series.steps as u64;
        decisions.bring_own_step(&mut commands, &series.staging, at);
        device.leave(commands);
        if let Some(series) = &mut self.series {
            series.steps += 1;
        }
        Ok(())
    }

    /// Has the device begin with the steps that were recorded.
    pub fn submit_own_steps(&mut self) -> Result<(), DeviceError> {
        let series = self.series.as_mut().ok_or_else(not_begun)?;
        let commands = self.device.record("own steps");
        series.submitted = Some(self.device.submit_alone(commands));
        Ok(())
    }

    /// Takes the next of the steps that were made: how the solve ended, and what the device found and did at the markers. Waits for all of them before the first.
    pub fn take_own_step(&mut self) -> Result<(Outcome, AtMarkers), DeviceError> {
        let series = self.series.as_mut().ok_or_else(not_begun)?;
        if let Some(submitted) = series.submitted.take() {
            let bytes = series.step_bytes * series.steps as u64;
            let steps = &mut series.brought;
            series
                .staging
                .read_of(&self.device, submitted, bytes, |bytes| {
                    let of_steps = bytes.chunks_exact(series.step_bytes as usize);
                    steps.extend(of_steps.map(<[u8]>::to_vec));
                })?;
        }
        let bytes = series.brought.pop_front().ok_or_else(not_begun)?;
        let decisions = &self.workspace()?.decisions;
        let (Some(in_air), (state, rest)) =
            (&decisions.in_air, bytes.split_at(MINIMISER_BYTES as usize))
        else {
            return Err(not_begun());
        };
        let own_steps = in_air.own_steps.as_ref().ok_or_else(not_begun)?;
        let (at_markers, of_nodes) =
            rest.split_at((in_air.brought_bytes() + in_air.sorted_bytes()) as usize);
        let state: Minimiser = bytemuck::pod_read_unaligned(state);
        let at_markers = in_air.brought(at_markers);
        let ended = own_steps.brought(of_nodes);
        let stop = stop(&state).unwrap_or(Stop::LimitReached);
        let outcome = self
            .space(0.0, InitialHessian::BlockJacobi)?
            .outcome(&state, stop);
        self.solution = (stop != Stop::NotFinite).then_some(Solution::Ended(ended));
        Ok((outcome, at_markers))
    }
}

const STAGE_BYTES: u64 = size_of::<ClothStage>() as u64;
const MINIMISER_BYTES: u64 = size_of::<Minimiser>() as u64;

fn not_begun() -> DeviceError {
    DeviceError::Command("no steps of the device's own were begun".to_owned())
}
