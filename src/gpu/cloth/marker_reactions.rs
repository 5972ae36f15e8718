//! Where air and fabric meet at markers, and a device has both: it forms the reactions that a solve has inside, and afterwards the forces on the air, by
//! itself (`shaders/marker_reactions.wgsl`). The host hears of both when it fetches the solution.
//!
//! *Departure from the host's own* ([`crate::cpu::cloth::loads`], `gpu/immersed/spread.rs`): both are formed in `f32`, from velocities of the prediction that the host has rounded.
//! Fabric and air have the same numbers u* and a_k as there.

use glam::DVec3;

use crate::cloth::Structure;
use crate::gpu::commands::{Commands, Pass};
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;

use super::elements::narrow;
use super::slots::DRIVE;

/// The markers of the fabric in the air of the same device.
#[derive(Debug, Clone)]
pub struct MarkersInAir {
    /// In the order of cells: which they are, (u*, a_k), and the forces on the air.
    pub(in crate::gpu) sorted: wgpu::Buffer,
    pub(in crate::gpu) states: wgpu::Buffer,
    pub(in crate::gpu) forces: wgpu::Buffer,
    /// Stiffness of every marker over its strength a_k [kg/s].
    pub(in crate::gpu) stiffness_kg_s: Vec<f64>,
    /// A lattice unit of velocity [m/s] and of force [N].
    pub(in crate::gpu) speed_m_s: f64,
    pub(in crate::gpu) force_n: f64,
}

/// Bytes that come back of a marker: its state and its force.
const BROUGHT_BYTES: u64 = 32;

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
}

/// The same with all buffers.
#[derive(Debug)]
pub(super) struct MarkerReactions {
    react: Bound,
    drive: Bound,
    react_back: Bound,
    states: wgpu::Buffer,
    forces: wgpu::Buffer,
    markers: usize,
    nodes: usize,
}

/// What the device found at the markers and did there, in the order of cells.
#[derive(Debug, Default)]
pub struct AtMarkers {
    /// (u*, a_k) [lattice units].
    pub states: Vec<[f32; 4]>,
    /// Force on the air [lattice units].
    pub forces: Vec<[f32; 4]>,
}

/// Where the markers of every node begin, and which they are: 3 · marker + corner.
fn at_nodes(structure: &Structure, markers: &[(u32, [f64; 3])]) -> (Vec<u32>, Vec<u32>) {
    let mut at_nodes = vec![Vec::new(); structure.node_count()];
    for (number, (triangle, _)) in markers.iter().enumerate() {
        for (corner, node) in (structure.triangles[*triangle as usize].nodes.iter()).enumerate() {
            at_nodes[*node as usize].push((3 * number + corner) as u32);
        }
    }
    let mut first = vec![0];
    for of_node in &at_nodes {
        first.push(first.last().copied().unwrap_or(0) + of_node.len() as u32);
    }
    (first, at_nodes.concat())
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
            states: self.air.states.clone(),
            forces: self.air.forces.clone(),
            markers: self.air.stiffness_kg_s.len(),
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
    /// Bytes that come back.
    pub const fn brought_bytes(&self) -> u64 {
        BROUGHT_BYTES * self.markers as u64
    }

    /// Before a solve.
    pub fn react(&self, device: &Device, pass: &mut Pass<'_>) {
        self.react
            .dispatch(pass, device.workgroups(self.markers as u64));
        self.drive
            .dispatch(pass, device.workgroups(self.nodes as u64));
    }

    /// After it.
    pub fn react_back(&self, device: &Device) {
        let mut commands = device.record("react_back");
        {
            let mut pass = commands.pass("react_back");
            self.react_back
                .dispatch(&mut pass, device.workgroups(self.markers as u64));
        }
        device.leave(commands);
    }

    /// Records what comes back, from a byte of what is brought on.
    pub fn bring_back(
        &self,
        commands: &mut Commands,
        copy: impl Fn(&mut Commands, &wgpu::Buffer, u64, u64),
        from: u64,
    ) {
        let bytes = self.brought_bytes() / 2;
        copy(commands, &self.states, from, bytes);
        copy(commands, &self.forces, from + bytes, bytes);
    }

    /// What came back.
    pub fn brought(&self, bytes: &[u8]) -> AtMarkers {
        let (states, forces) = bytes.split_at(bytes.len() / 2);
        AtMarkers {
            states: bytemuck::pod_collect_to_vec(states),
            forces: bytemuck::pod_collect_to_vec(forces),
        }
    }
}
