//! Fabric that cuts links of the air of the same device, which makes steps by itself ([`super::own_steps`], `shaders/cut_fabric.wgsl`): it places the nodes among the cells, and forms what the
//! air does to every triangle from what left along the links that it has found ([`crate::gpu::fluid::moving_walls`]).
//!
//! *Departure from the host's own* ([`crate::cut_links`]): all is formed in `f32`. The force of held fabric has the pressure between two layers in it, as the fabric feels it; the host's has it not.
//! So where one of two layers in a link is held, the impulse of the supports is not that of the host's steps; nowhere else.

use glam::DVec3;

use crate::cloth::Structure;
use crate::cloth::patches::{LEAST_COSINE, Member, Patches};
use crate::cut_links::faces::{CARRIED, LEAST_WEIGHT, NEW_SHARE};
use crate::gpu::commands::Pass;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;

use super::elements::{CUT_WORDS, corners_at_nodes, split};
use super::motion::{OwnStepPipelines, OwnSteps};
use super::parameters::{CellsInSpace, PatchMember};
use super::slots::DRIVE;

/// Scales of the air, and where its lattice is.
#[derive(Debug, Clone, Copy)]
pub struct AirScales {
    /// Centre of its first cell [m], moved by what the whole surface is moved.
    pub first_centre_m: DVec3,
    /// Size of a cell [m].
    pub cell_size_m: f64,
    /// A lattice unit of velocity [m/s].
    pub speed_m_s: f64,
    /// Of stiffness against motion [kg/s].
    pub stiffness_kg_s: f64,
    /// Of force [N].
    pub force_n: f64,
}

/// Buffers of the air, by their names in the shaders: nodes, triangles, links and what left along them.
pub type LinksInAir<'a> = Vec<(&'static str, &'a wgpu::Buffer)>;

/// What the air did to the triangles in a step of the device's own.
#[derive(Debug, Default)]
pub struct AtCuts {
    /// Word by word: of the corners 00, 11, 22, 01, 12, 20 the blocks (xx, yy, zz, xy, xz, yz) [kg/s].
    pub stiffness_kg_s: Vec<f32>,
    /// The same of the corners: pull on a triangle at rest [N].
    pub pull_n: Vec<f32>,
    /// Density excess on both faces of every node; then whether links see them, or 1 where no link has two layers.
    pub faces: Vec<[f32; 4]>,
    /// Not 0 where the links could not be found.
    pub trouble: u32,
    /// How many there are.
    pub links: u32,
}

/// Numbers of links, and where among them that of all is (`shaders/found_links.wgsl`).
const TOTALS_BYTES: u64 = 40;
const LINKS: usize = 8;

/// Words of a triangle that come back: stiffness, and pull.
const STIFFNESS_WORDS: usize = 36;
const PULL_WORDS: usize = CUT_WORDS - STIFFNESS_WORDS;

/// Pipelines, and what does not change between steps.
#[derive(Debug)]
pub(super) struct CutFabric {
    pipelines: [Pipeline; 10],
    pub own_steps: OwnStepPipelines,
    space: wgpu::Buffer,
    still_drive: wgpu::Buffer,
    triangle_first: wgpu::Buffer,
    triangle_corners: wgpu::Buffer,
    cut_pulls: wgpu::Buffer,
    face_sums: wgpu::Buffer,
    faces_taken: wgpu::Buffer,
    faces_carried: wgpu::Buffer,
    patch_starts: wgpu::Buffer,
    patch_members: wgpu::Buffer,
    patch_shares: wgpu::Buffer,
    middle_reactions: wgpu::Buffer,
    triangles: usize,
    nodes: usize,
    pub bound: Option<BoundCuts>,
}

/// With all buffers, for a series of steps.
#[derive(Debug)]
pub(super) struct BoundCuts {
    place_nodes: Bound,
    sum_faces: Bound,
    take_faces: Bound,
    carry_faces: [Bound; 2],
    share_cuts: Bound,
    react_cuts: Bound,
    share_reactions: Bound,
    drive_cuts: Bound,
    move_nodes: Bound,
    mean_velocities: Bound,
    pub own_steps: OwnSteps,
    cut_reactions: wgpu::Buffer,
    trouble: wgpu::Buffer,
    totals: wgpu::Buffer,
}

/// Who shares what the air does to each of so many triangles: itself alone, without patches.
fn members(patches: Option<&Patches>, triangles: usize) -> (Vec<u32>, Vec<PatchMember>) {
    let Some(patches) = patches else {
        let alone = |triangle| PatchMember {
            triangle,
            area: 1.0,
            ..PatchMember::default()
        };
        let all = 0..triangles as u32;
        return ((0..=triangles as u32).collect(), all.map(alone).collect());
    };
    let (starts, members) = patches.members();
    let member = |member: &Member| PatchMember {
        triangle: member.triangle,
        area: member.area as f32,
        via: member.via,
        back: member.back,
    };
    (starts.to_vec(), members.iter().map(member).collect())
}

fn not_bound() -> DeviceError {
    DeviceError::Command("fabric meets links that it was not told of".to_owned())
}

impl CutFabric {
    /// For a structure in air of these scales; `None` where a step needs more of the host.
    pub fn new(
        device: &Device,
        structure: &Structure,
        (air, patches): (&AirScales, Option<&Patches>),
    ) -> Result<Option<Self>, DeviceError> {
        let Some(own_steps) = OwnStepPipelines::new(device, structure, None)? else {
            return Ok(None);
        };
        let (nodes, triangles) = (structure.node_count(), structure.triangles.len());
        let constants = [
            ("NODES", nodes as f64),
            ("TRIANGLES", triangles as f64),
            ("DRIVE", f64::from(DRIVE)),
            ("SPEED", air.speed_m_s),
            ("STIFFNESS", air.stiffness_kg_s),
            ("FORCE_N", air.force_n),
            ("NEW_SHARE", NEW_SHARE),
            ("LEAST_WEIGHT", LEAST_WEIGHT),
            ("LEAST_COSINE", LEAST_COSINE),
        ];
        let entries = [
            "place_nodes",
            "sum_faces",
            "take_faces",
            "carry_faces",
            "share_cuts",
            "react_cuts",
            "share_reactions",
            "drive_cuts",
            "move_nodes",
            "mean_velocities",
        ];
        let pipelines = device.pipelines(&shaders::CUT_FABRIC, entries, &constants)?;
        let origin = air.first_centre_m.to_array().map(split);
        let (cell_whole, cell_remainder) = split(air.cell_size_m);
        let [x, y, z] = origin;
        let space = device.uniform::<CellsInSpace>("cells in space")?;
        let parameters = CellsInSpace {
            origin_whole: [x.0, y.0, z.0, 0],
            origin_remainder: [x.1, y.1, z.1, 0.0],
            cell_whole,
            cell_remainder,
            cells_per_m: (1.0 / air.cell_size_m) as f32,
            padding: 0,
        };
        device.write(&space, 0, &[parameters]);
        let of_triangles = structure.triangles.iter().map(|triangle| triangle.nodes);
        let (first, corners) = corners_at_nodes(nodes, of_triangles);
        let (patch_starts, patch_members) = members(patches, triangles);
        let of_nodes = |label, bytes: usize| device.storage(label, (bytes * nodes) as u64);
        let of_triangles = |label, bytes: usize| device.storage(label, (bytes * triangles) as u64);
        Ok(Some(Self {
            pipelines,
            own_steps,
            space,
            still_drive: of_nodes("loads beside the air", 12)?,
            triangle_first: device.storage_of("first triangles of nodes", &first)?,
            triangle_corners: device.storage_of("triangles of nodes", &corners)?,
            cut_pulls: of_triangles("pulls of the air", 4 * PULL_WORDS)?,
            face_sums: of_triangles("what faces see", 48)?,
            faces_taken: of_nodes("pressures of faces", 16)?,
            faces_carried: of_nodes("pressures carried on", 16)?,
            patch_starts: device.storage_of("first members of patches", &patch_starts)?,
            patch_members: device.storage_of("members of patches", &patch_members)?,
            patch_shares: device.storage("shares of members", 4 * patch_members.len() as u64)?,
            middle_reactions: of_triangles("reactions at middles", 36)?,
            triangles,
            nodes,
            bound: None,
        }))
    }

    /// Binds buffers for a series of steps: those of the fabric and of its workspace, and those of the air.
    pub fn bind(
        &mut self,
        device: &Device,
        own: &[(&str, &wgpu::Buffer)],
        air: &LinksInAir<'_>,
    ) -> Result<(), DeviceError> {
        let mut all = own.to_vec();
        all.extend(air.iter().copied());
        all.extend([
            ("space", &self.space),
            ("still_drive", &self.still_drive),
            ("triangle_first", &self.triangle_first),
            ("triangle_corners", &self.triangle_corners),
            ("cut_pulls", &self.cut_pulls),
            ("face_sums", &self.face_sums),
            ("faces_taken", &self.faces_taken),
            ("faces_carried", &self.faces_carried),
            ("patch_starts", &self.patch_starts),
            ("patch_members", &self.patch_members),
            ("patch_shares", &self.patch_shares),
            ("middle_reactions", &self.middle_reactions),
        ]);
        all.extend(self.own_steps.named());
        let find = |wanted: &str| {
            let found = all.iter().find(|(name, _)| *name == wanted);
            found.map(|(_, buffer)| (*buffer).clone())
        };
        let bind = |pipeline: &Pipeline| device.bind(pipeline, &all);
        let [
            place,
            sum,
            take,
            carry,
            share,
            react,
            share_reactions,
            drive,
            moving,
            means,
        ] = &self.pipelines;
        let carrying = |from, to| {
            let mut named = all.clone();
            named.extend([("faces_from", from), ("faces_to", to)]);
            device.bind(carry, &named)
        };
        let bound = BoundCuts {
            place_nodes: bind(place)?,
            sum_faces: bind(sum)?,
            take_faces: bind(take)?,
            carry_faces: [
                carrying(&self.faces_taken, &self.faces_carried)?,
                carrying(&self.faces_carried, &self.faces_taken)?,
            ],
            share_cuts: bind(share)?,
            react_cuts: bind(react)?,
            share_reactions: bind(share_reactions)?,
            drive_cuts: bind(drive)?,
            move_nodes: bind(moving)?,
            mean_velocities: bind(means)?,
            own_steps: self.own_steps.bind(device, &all, self.nodes)?,
            cut_reactions: find("cut_reactions").ok_or_else(not_bound)?,
            trouble: find("trouble").ok_or_else(not_bound)?,
            totals: find("totals").ok_or_else(not_bound)?,
        };
        self.bound = Some(bound);
        Ok(())
    }

    /// Uploads what goes on from step to step: loads beside the air, and the density excess on both faces of every node.
    pub fn upload(&self, device: &Device, still_drive: &[[f32; 3]], faces: &[[f64; 2]]) {
        let faces: Vec<[f32; 4]> = (faces.iter().take(self.nodes))
            .map(|[front, back]| [*front as f32, *back as f32, 0.0, 0.0])
            .collect();
        device.write(&self.still_drive, 0, still_drive);
        device.write(&self.faces_carried, 0, &faces);
    }

    fn bound(&self) -> Result<&BoundCuts, DeviceError> {
        self.bound.as_ref().ok_or_else(not_bound)
    }

    /// Before links are found.
    pub fn place(&self, device: &Device, pass: &mut Pass<'_>) -> Result<(), DeviceError> {
        let nodes = device.workgroups(self.nodes as u64);
        self.bound()?.place_nodes.dispatch(pass, nodes);
        Ok(())
    }

    /// Before the solve.
    pub fn react(&self, device: &Device, pass: &mut Pass<'_>) -> Result<(), DeviceError> {
        let bound = self.bound()?;
        let nodes = device.workgroups(self.nodes as u64);
        let triangles = device.workgroups(self.triangles as u64);
        bound.sum_faces.dispatch(pass, triangles);
        bound.take_faces.dispatch(pass, nodes);
        // An odd number of times, so that they end up where they are read.
        for carried in 0..CARRIED {
            bound.carry_faces[carried % 2].dispatch(pass, nodes);
        }
        bound.share_cuts.dispatch(pass, triangles);
        bound.react_cuts.dispatch(pass, triangles);
        bound.share_reactions.dispatch(pass, triangles);
        bound.drive_cuts.dispatch(pass, nodes);
        Ok(())
    }

    /// After it.
    pub fn move_nodes(&self, device: &Device, pass: &mut Pass<'_>) -> Result<(), DeviceError> {
        let bound = self.bound()?;
        let nodes = device.workgroups(self.nodes as u64);
        let triangles = device.workgroups(self.triangles as u64);
        bound.move_nodes.dispatch(pass, nodes);
        bound.mean_velocities.dispatch(pass, triangles);
        Ok(())
    }

    /// Bytes that come back of a step besides the minimiser.
    pub const fn brought_bytes(&self) -> u64 {
        (4 * CUT_WORDS * self.triangles + 40 * self.nodes + 4) as u64 + TOTALS_BYTES
    }

    /// What comes back of a step besides the minimiser, and its bytes.
    pub fn parts(&self) -> Result<Vec<(&wgpu::Buffer, u64)>, DeviceError> {
        let bound = self.bound()?;
        let words = |count: usize| (4 * count * self.triangles) as u64;
        let mut parts = vec![
            (&bound.cut_reactions, words(STIFFNESS_WORDS)),
            (&self.cut_pulls, words(PULL_WORDS)),
            (&self.faces_carried, 16 * self.nodes as u64),
            (&bound.trouble, 4),
            (&bound.totals, TOTALS_BYTES),
        ];
        parts.extend(bound.own_steps.parts());
        Ok(parts)
    }

    /// What bytes hold that came back.
    pub fn brought(&self, bytes: &[u8]) -> Result<(AtCuts, Vec<DVec3>), DeviceError> {
        let words = |count: usize| 4 * count * self.triangles;
        let (stiffness, rest) = bytes.split_at(words(STIFFNESS_WORDS));
        let (pull, rest) = rest.split_at(words(PULL_WORDS));
        let (faces, rest) = rest.split_at(16 * self.nodes);
        let (trouble, rest) = rest.split_at(4);
        let (totals, of_nodes) = rest.split_at(TOTALS_BYTES as usize);
        let totals: Vec<u32> = bytemuck::pod_collect_to_vec(totals);
        let at_cuts = AtCuts {
            stiffness_kg_s: bytemuck::pod_collect_to_vec(stiffness),
            pull_n: bytemuck::pod_collect_to_vec(pull),
            faces: bytemuck::pod_collect_to_vec(faces),
            trouble: bytemuck::pod_read_unaligned(trouble),
            links: totals.get(LINKS).copied().unwrap_or_default(),
        };
        Ok((at_cuts, self.bound()?.own_steps.brought(of_nodes)))
    }
}

const _: () = assert!(CARRIED % 2 == 1, "pressures end up in the wrong buffer");
