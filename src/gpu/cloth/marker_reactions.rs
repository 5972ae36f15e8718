//! Where air and fabric meet at markers, and a device has both: it forms the reactions that a solve has inside, and afterwards the forces on the air, by
//! itself (`shaders/marker_reactions.wgsl`). The host hears of both when it fetches the solution.
//!
//! *Departure from the host's own* ([`crate::cpu::cloth::loads`], `gpu/immersed/spread.rs`): both are formed in `f32`, from velocities of the prediction that the host has rounded.
//! Fabric and air have the same numbers u* and a_k as there.

use glam::DVec3;

use crate::cloth::Structure;
use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;

use super::elements::{corners_at_nodes, narrow};
use super::motion::{OwnStepPipelines, OwnSteps};
use super::slots::DRIVE;

/// The markers of the fabric in the air of the same device.
#[derive(Debug, Clone)]
pub struct MarkersInAir {
    /// In the order of cells: which they are, (u*, a_k), and the forces on the air.
    pub(in crate::gpu) sorted: wgpu::Buffer,
    pub(in crate::gpu) states: wgpu::Buffer,
    pub(in crate::gpu) forces: wgpu::Buffer,
    /// Where the device sorts them itself: numbers in that order, and one more than the number of a marker that left the box.
    pub(in crate::gpu) order: wgpu::Buffer,
    pub(in crate::gpu) strayed: wgpu::Buffer,
    /// Stiffness of every marker over its strength a_k [kg/s].
    pub(in crate::gpu) stiffness_kg_s: Vec<f64>,
    /// A lattice unit of velocity [m/s] and of force [N].
    pub(in crate::gpu) speed_m_s: f64,
    pub(in crate::gpu) force_n: f64,
}

/// Bytes that come back of a marker: its state and its force.
const BROUGHT_BYTES: u64 = 32;
/// The same of a step of the device's own, besides: a number in the sorted order; and of all markers, which one left the box.
const SORTED_BYTES: u64 = 4;
const STRAYED_BYTES: u64 = 4;

/// Pipelines, and what does not change between steps.
#[derive(Debug)]
pub(super) struct MarkerPipelines {
    react: Pipeline,
    drive: Pipeline,
    react_back: Pipeline,
    air: MarkersInAir,
    motions: wgpu::Buffer,
    still_drive: wgpu::Buffer,
    first: wgpu::Buffer,
    corners: wgpu::Buffer,
    /// Absent where a step needs more of the host.
    pub own_steps: Option<OwnStepPipelines>,
}

/// The same with all buffers.
#[derive(Debug)]
pub(super) struct MarkerReactions {
    react: Bound,
    drive: Bound,
    react_back: Bound,
    air: MarkersInAir,
    pub own_steps: Option<OwnSteps>,
    nodes: usize,
}

/// What the device found at the markers and did there, in the order of cells.
#[derive(Debug, Default)]
pub struct AtMarkers {
    /// (u*, a_k) [lattice units].
    pub states: Vec<[f32; 4]>,
    /// Force on the air [lattice units].
    pub forces: Vec<[f32; 4]>,
    /// Which markers they are, where the device has sorted them itself.
    pub order: Vec<u32>,
    /// A marker that had left the box of cells that the device knew of.
    pub strayed: Option<u32>,
}

/// Where the markers of every node begin, and which they are: 3 · marker + corner.
fn at_nodes(structure: &Structure, markers: &[(u32, [f64; 3])]) -> (Vec<u32>, Vec<u32>) {
    let of_marker = |(triangle, _): &(u32, _)| structure.triangles[*triangle as usize].nodes;
    corners_at_nodes(structure.node_count(), markers.iter().map(of_marker))
}

impl MarkerPipelines {
    /// For the `markers` of a structure, which stand in the air.
    pub fn new(
        device: &Device,
        structure: &Structure,
        (markers, air): (&[(u32, [f64; 3])], MarkersInAir),
    ) -> Result<Self, DeviceError> {
        let constants = [
            ("NODES", structure.node_count() as f64),
            ("MARKERS", markers.len() as f64),
            ("DRIVE", f64::from(DRIVE)),
            ("SPEED", air.speed_m_s),
            ("FORCE", 1.0 / air.force_n),
        ];
        let entries = ["react", "drive", "react_back"];
        let [react, drive, react_back] =
            device.pipelines(&shaders::MARKER_REACTIONS, entries, &constants)?;
        let (first, corners) = at_nodes(structure, markers);
        Ok(Self {
            react,
            drive,
            react_back,
            motions: device.storage("motions of markers", 16 * markers.len() as u64)?,
            still_drive: device
                .storage("loads beside the air", 12 * structure.node_count() as u64)?,
            first: device.storage_of("first markers of nodes", &first)?,
            corners: device.storage_of("markers of nodes", &corners)?,
            own_steps: OwnStepPipelines::new(device, structure, Some(markers.len()))?,
            air,
        })
    }

    /// The markers, to be met by another structure.
    pub fn into_air(self) -> MarkersInAir {
        self.air
    }

    /// Gives them their buffers, those of the structure and of its workspace among them.
    pub fn bind(
        &self,
        device: &Device,
        buffers: &[(&str, &wgpu::Buffer)],
        nodes: usize,
    ) -> Result<MarkerReactions, DeviceError> {
        let mut all = buffers.to_vec();
        let of_markers = buffers.iter().find(|(name, _)| *name == "markers");
        all.extend(of_markers.map(|(_, buffer)| ("fabric_markers", *buffer)));
        all.extend([
            ("sorted_markers", &self.air.sorted),
            ("marker_states", &self.air.states),
            ("marker_forces", &self.air.forces),
            ("marker_motions", &self.motions),
            ("still_drive", &self.still_drive),
            ("marker_first", &self.first),
            ("marker_corners", &self.corners),
        ]);
        Ok(MarkerReactions {
            react: device.bind(&self.react, &all)?,
            drive: device.bind(&self.drive, &all)?,
            react_back: device.bind(&self.react_back, &all)?,
            own_steps: (self.own_steps.as_ref())
                .map(|own_steps| own_steps.bind(device, &all, nodes))
                .transpose()?,
            air: self.air.clone(),
            nodes,
        })
    }

    /// Uploads what the prediction does at the markers, `velocities_m_s`, and the loads beside the air.
    pub fn upload(
        &self,
        device: &Device,
        velocities_m_s: impl Iterator<Item = DVec3>,
        still_drive: &[[f32; 3]],
    ) {
        let motions: Vec<[f32; 4]> = velocities_m_s
            .zip(&self.air.stiffness_kg_s)
            .map(|(velocity, stiffness)| {
                let [x, y, z] = narrow(&velocity);
                [x, y, z, *stiffness as f32]
            })
            .collect();
        device.write(&self.motions, 0, &motions);
        device.write(&self.still_drive, 0, still_drive);
    }
}

impl MarkerReactions {
    /// Number of markers.
    pub const fn marker_count(&self) -> usize {
        self.air.stiffness_kg_s.len()
    }

    /// Bytes that come back of a solve.
    pub const fn brought_bytes(&self) -> u64 {
        BROUGHT_BYTES * self.marker_count() as u64
    }

    /// Bytes that come back besides of a step of the device's own.
    pub const fn sorted_bytes(&self) -> u64 {
        SORTED_BYTES * self.marker_count() as u64 + STRAYED_BYTES
    }

    /// Before a solve.
    pub fn react(&self, device: &Device, pass: &mut Pass<'_>) {
        self.react
            .dispatch(pass, device.workgroups(self.marker_count() as u64));
        self.drive
            .dispatch(pass, device.workgroups(self.nodes as u64));
    }

    /// After it.
    pub fn react_back(&self, device: &Device) {
        let mut commands = device.record("react_back");
        self.record_back(device, &mut commands.pass("react_back"));
        device.leave(commands);
    }

    /// The same in a pass of others.
    pub fn record_back(&self, device: &Device, pass: &mut Pass<'_>) {
        self.react_back
            .dispatch(pass, device.workgroups(self.marker_count() as u64));
    }

    /// What comes back of a solve, and its bytes.
    pub fn parts(&self) -> [(&wgpu::Buffer, u64); 2] {
        let bytes = self.brought_bytes() / 2;
        [(&self.air.states, bytes), (&self.air.forces, bytes)]
    }

    /// What comes back besides of a step of the device's own, and its bytes.
    pub fn sorted_parts(&self) -> [(&wgpu::Buffer, u64); 2] {
        let bytes = self.sorted_bytes() - STRAYED_BYTES;
        [(&self.air.order, bytes), (&self.air.strayed, STRAYED_BYTES)]
    }

    /// What came back, with the further bytes of a step of the device's own or none.
    pub fn brought(&self, bytes: &[u8]) -> AtMarkers {
        let (states_and_forces, sorted) = bytes.split_at(self.brought_bytes() as usize);
        let (states, forces) = states_and_forces.split_at(states_and_forces.len() / 2);
        let (order, strayed) = sorted.split_at(sorted.len().saturating_sub(4));
        AtMarkers {
            states: bytemuck::pod_collect_to_vec(states),
            forces: bytemuck::pod_collect_to_vec(forces),
            order: bytemuck::pod_collect_to_vec(order),
            strayed: bytemuck::pod_collect_to_vec::<u8, u32>(strayed)
                .first()
                .and_then(|number| number.checked_sub(1)),
        }
    }
}
