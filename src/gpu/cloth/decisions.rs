//! What decides on the device between two evaluations, with its buffers (`shaders/minimiser.wgsl`), and what comes back of a solve.

use glam::DVec3;

use crate::gpu::commands::Commands;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders;
use crate::gpu::transfer::Staging;
use crate::solve::lbfgs::Stop;

use super::elements::joined;
use super::host_constants::constants_of_the_host;
use super::marker_reactions::{AtMarkers, MarkerPipelines, MarkerReactions};
use super::motion::OwnSteps;
use super::parameters::Minimiser;
use super::small_cloth::SmallCloth;

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
/// Dispatches of a trial whose workgroups come before those of the elements: along vectors, products.
pub(super) const ALONG_VECTORS: usize = 0;
pub(super) const PRODUCTS: usize = 1;
pub(super) const FIRST_ELEMENT: usize = 2;

/// Pipelines of what decides; `small` is the whole minimiser in one workgroup, where the fabric is small.
#[derive(Debug)]
pub(super) struct DecisionPipelines {
    decide: Pipeline,
    deliver: Pipeline,
    small: Option<Pipeline>,
}

impl DecisionPipelines {
    /// Builds the first two.
    pub fn new(
        device: &Device,
        small: Option<Pipeline>,
        constants: &[(&str, f64)],
    ) -> Result<Self, DeviceError> {
        let mut all = constants.to_vec();
        all.extend(constants_of_the_host());
        let [decide, deliver] =
            device.pipelines(&shaders::MINIMISE, ["decide", "deliver"], &all)?;
        Ok(Self {
            decide,
            deliver,
            small,
        })
    }
}

/// What decides on the device.
#[derive(Debug)]
pub(super) struct Decisions {
    pub minimiser: wgpu::Buffer,
    pub workgroups: wgpu::Buffer,
    delivered: wgpu::Buffer,
    staging: Staging,
    pub decide: Bound,
    pub deliver: Bound,
    /// The whole minimiser in one workgroup, where the fabric is small.
    pub small: Option<SmallCloth>,
    /// Where the device forms the reactions of the air at markers itself.
    pub in_air: Option<MarkerReactions>,
    pub nodes: usize,
}

/// What comes back after a batch.
#[derive(Debug, Default)]
pub(super) struct Brought {
    pub state: Minimiser,
    /// Positions of the nodes once the minimiser has ended [m].
    pub positions_m: Vec<DVec3>,
    /// H₀ g of the nodes, then [m].
    pub preconditioned: Vec<[f32; 3]>,
    /// At the markers, then.
    pub at_markers: Option<AtMarkers>,
}

/// Why the minimiser ended; `None` while it runs.
pub(super) fn stop(state: &Minimiser) -> Option<Stop> {
    STOPS.get(state.status as usize).copied().flatten()
}

impl Decisions {
    /// Of a structure with `buffers`, those of its workspace among them, whose forces take so many dispatches.
    pub fn new(
        device: &Device,
        (pipelines, in_air): (&DecisionPipelines, Option<&MarkerPipelines>),
        buffers: &[(&str, &wgpu::Buffer)],
        (nodes, dispatches): (usize, usize),
    ) -> Result<Self, DeviceError> {
        let state_bytes = size_of::<Minimiser>() as u64;
        let node_bytes = (4 * NODE_WORDS * nodes) as u64;
        let minimiser = device.storage("cloth minimiser", state_bytes)?;
        let gram = device.storage("cloth gram matrix", 4 * GRAM_WORDS as u64)?;
        let workgroups = device.buffer(
            "cloth workgroups",
            (12 * (FIRST_ELEMENT + dispatches)) as u64,
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
        let small = pipelines.small.as_ref();
        let in_air = in_air
            .map(|in_air| in_air.bind(device, &all, nodes))
            .transpose()?;
        let marker_bytes = in_air.as_ref().map_or(0, MarkerReactions::brought_bytes);
        Ok(Self {
            staging: Staging::new(device, state_bytes + node_bytes + marker_bytes)?,
            in_air,
            decide: device.bind(&pipelines.decide, &all)?,
            deliver: device.bind(&pipelines.deliver, &all)?,
            small: small
                .map(|small| SmallCloth::new(device, small, &all))
                .transpose()?,
            minimiser,
            workgroups,
            delivered,
            nodes,
        })
    }

    /// What further stages read of it, by name in the shaders.
    pub const fn named(&self) -> [(&'static str, &wgpu::Buffer); 2] {
        [
            ("minimiser", &self.minimiser),
            ("delivered", &self.delivered),
        ]
    }

    /// What comes back of a solve, and its bytes.
    fn parts(&self) -> Vec<(&wgpu::Buffer, u64)> {
        let mut parts = vec![
            (&self.minimiser, size_of::<Minimiser>() as u64),
            (&self.delivered, (4 * NODE_WORDS * self.nodes) as u64),
        ];
        parts.extend(self.in_air.iter().flat_map(MarkerReactions::parts));
        parts
    }

    /// The same of a step of the device's own: the minimiser, then of the markers and of the nodes.
    fn parts_of_own_step(&self) -> Vec<(&wgpu::Buffer, u64)> {
        let mut parts = vec![(&self.minimiser, size_of::<Minimiser>() as u64)];
        if let Some(in_air) = &self.in_air {
            parts.extend(in_air.parts());
            parts.extend(in_air.sorted_parts());
            parts.extend(in_air.own_steps.iter().flat_map(OwnSteps::parts));
        }
        parts
    }

    /// Bytes that come back of a step of the device's own.
    pub fn own_step_bytes(&self) -> u64 {
        self.parts_of_own_step()
            .iter()
            .map(|(_, bytes)| bytes)
            .sum()
    }

    /// Records where the minimiser stands, to be read.
    pub fn bring_back(&self, commands: &mut Commands) {
        copy(commands, &self.parts(), &self.staging, 0);
    }

    /// The same of a step of the device's own, from byte `at` on of another way back.
    pub fn bring_own_step(&self, commands: &mut Commands, staging: &Staging, at: u64) {
        copy(commands, &self.parts_of_own_step(), staging, at);
    }

    /// Waits for what was brought back; of nodes and markers only once the minimiser has ended.
    pub fn read(&self, device: &Device) -> Result<Brought, DeviceError> {
        let mut found = Brought::default();
        self.staging.read(device, |bytes| {
            found.state = bytemuck::pod_read_unaligned(&bytes[..size_of::<Minimiser>()]);
            if stop(&found.state).is_some() {
                let whole: u64 = self.parts().iter().map(|(_, bytes)| bytes).sum();
                found = self.brought(&bytes[..whole as usize]);
            }
        })?;
        Ok(found)
    }

    /// What bytes hold that were brought back.
    pub fn brought(&self, bytes: &[u8]) -> Brought {
        let (state, nodes) = bytes.split_at(size_of::<Minimiser>());
        let (nodes, rest) = nodes.split_at(4 * NODE_WORDS * self.nodes);
        let words: Vec<[u32; NODE_WORDS]> = bytemuck::pod_collect_to_vec(nodes);
        let in_air = self.in_air.as_ref();
        let position = |node: &[u32; NODE_WORDS]| {
            let axis = |a: usize| joined(node[a].cast_signed(), f32::from_bits(node[3 + a]));
            DVec3::new(axis(0), axis(1), axis(2))
        };
        Brought {
            state: bytemuck::pod_read_unaligned(state),
            at_markers: in_air.map(|air| air.brought(rest)),
            positions_m: words.iter().map(position).collect(),
            preconditioned: words
                .iter()
                .map(|node| [6, 7, 8].map(|word: usize| f32::from_bits(node[word])))
                .collect(),
        }
    }
}

/// Records copies of one buffer after the other, from byte `at` on of a way back.
pub(super) fn copy(
    commands: &mut Commands,
    parts: &[(&wgpu::Buffer, u64)],
    staging: &Staging,
    mut at: u64,
) {
    for (buffer, bytes) in parts {
        staging.copy(commands, buffer, 0, at, *bytes);
        at += bytes;
    }
}
