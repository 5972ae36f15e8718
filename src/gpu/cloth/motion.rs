//! Fabric from the end of one solve to the start of the next, where a device makes steps by itself ([`super::own_steps`], `shaders/fabric_motion.wgsl`).
//!
//! Positions are whole numbers of 2⁻⁴⁰ m, on the device and on the host, and velocities follow from them: it does not matter how many steps are made at once.

use std::collections::VecDeque;

use glam::DVec3;

use crate::cloth::Structure;
use crate::cpu::cloth::Cloth as State;
use crate::cpu::cloth::integration::StepBase;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;
use crate::gpu::transfer::Staging;
use crate::solve::lbfgs::Options;

use super::elements::{UNITS_PER_M, damped_cables, joined};
use super::parameters::FabricMotion;

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
    marker_velocities: Option<Pipeline>,
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
    pub predict: Bound,
    /// Where there are markers.
    pub marker_velocities: Option<Bound>,
    pub end_step: Bound,
    whole: wgpu::Buffer,
    remainder: wgpu::Buffer,
    nodes: usize,
}

/// Steps that were begun, in order.
#[derive(Debug)]
pub(super) struct Series {
    pub options: Options,
    /// Stage and minimiser as every solve starts.
    pub start: wgpu::Buffer,
    pub staging: Staging,
    pub step_bytes: u64,
    pub steps: usize,
    pub submitted: Option<wgpu::SubmissionIndex>,
    /// Of steps that the host has not taken.
    pub brought: VecDeque<Vec<u8>>,
}

impl OwnStepPipelines {
    /// For a structure with so many markers, or of fabric that cuts links; `None` where a step needs more of the host.
    pub fn new(
        device: &Device,
        structure: &Structure,
        markers: Option<usize>,
    ) -> Result<Option<Self>, DeviceError> {
        if damped_cables(structure).next().is_some() || structure.has_line_drag() {
            return Ok(None);
        }
        let nodes = structure.node_count() as u64;
        let constants = [
            ("NODES", nodes as f64),
            ("MARKERS", markers.unwrap_or_default() as f64),
        ];
        let entries = ["predict", "end_step"];
        let [predict, end_step] = device.pipelines(&shaders::FABRIC_MOTION, entries, &constants)?;
        let of_markers = markers
            .map(|_| device.pipelines(&shaders::FABRIC_MOTION, ["marker_velocities"], &constants));
        let marker_velocities = of_markers.transpose()?.map(|[pipeline]| pipeline);
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
        all.extend(self.named());
        Ok(OwnSteps {
            predict: device.bind(&self.predict, &all)?,
            marker_velocities: (self.marker_velocities.as_ref())
                .map(|pipeline| device.bind(pipeline, &all))
                .transpose()?,
            end_step: device.bind(&self.end_step, &all)?,
            whole: self.whole.clone(),
            remainder: self.remainder.clone(),
            nodes,
        })
    }

    /// Their buffers, by name in the shaders.
    pub fn named(&self) -> [(&'static str, &wgpu::Buffer); 6] {
        [
            ("motion", &self.parameters),
            ("nodes_whole", &self.whole),
            ("nodes_remainder", &self.remainder),
            ("ways_whole", &self.ways_whole),
            ("ways_remainder", &self.ways_remainder),
            ("base_velocities", &self.base_velocities),
        ]
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
    pub fn upload(
        &self,
        device: &Device,
        state: &State,
        base: &StepBase,
        parameters: FabricMotion,
    ) {
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
    pub fn brought(&self, bytes: &[u8]) -> Vec<DVec3> {
        let (whole, remainder) = bytes.split_at(12 * self.nodes);
        let whole: Vec<[i32; 3]> = bytemuck::pod_collect_to_vec(whole);
        let remainder: Vec<[f32; 3]> = bytemuck::pod_collect_to_vec(remainder);
        let position = |(whole, remainder): (&[i32; 3], &[f32; 3])| {
            DVec3::from_array(std::array::from_fn(|a| joined(whole[a], remainder[a])))
        };
        whole.iter().zip(&remainder).map(position).collect()
    }
}
