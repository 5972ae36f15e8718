//! Room on the device for the populations of cut links.

use super::names::by_number;
use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::pipeline::{Bound, Pipeline};
use crate::gpu::shaders::{self, parameters};
use crate::gpu::transfer::Staging;
use crate::lattice::Storage;

parameters! {
    /// How many populations a dispatch reads or writes.
    LinkParameters {
        /// Populations in the list.
        count: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
        /// Unused.
        padding_c: u32,
    }
}

/// Room for more populations than there are, when the room is made anew.
const SPARE: usize = 2;

/// Lists of populations on the device.
#[derive(Debug)]
pub(super) struct LinkLists {
    pub(super) parameters: wgpu::Buffer,
    pipelines: [Pipeline; 2],
    pub(super) room: Room,
    /// Places and numbers of the stage under way, before they are sent.
    pub(super) places: Vec<[u32; 2]>,
    pub(super) numbers: Vec<f32>,
    /// What goes to populations at rest, by element.
    pub(super) rest: Vec<(u32, f64)>,
}

/// Buffers for so many populations.
#[derive(Debug)]
pub(super) struct Room {
    count: usize,
    pub(super) places: wgpu::Buffer,
    pub(super) numbers: wgpu::Buffer,
    pub(super) staging: Staging,
    /// Stages `read_links` and `bounce`.
    pub(super) bound: [Bound; 2],
}

impl LinkLists {
    /// Room for so many.
    pub(super) fn new(
        device: &Device,
        storage: Storage,
        populations: &[wgpu::Buffer],
        count: usize,
    ) -> Result<Self, DeviceError> {
        let pipelines = device.pipelines(
            &shaders::CUT_LINKS[storage as usize],
            ["read_links", "bounce"],
            &[],
        )?;
        let parameters = device.uniform::<LinkParameters>("link parameters")?;
        Ok(Self {
            room: Room::new(
                device,
                populations,
                (&pipelines, &parameters),
                SPARE * count.max(1),
            )?,
            parameters,
            pipelines,
            places: Vec::new(),
            numbers: Vec::new(),
            rest: Vec::new(),
        })
    }

    /// Makes room for so many populations.
    pub(super) fn reserve(
        &mut self,
        device: &Device,
        populations: &[wgpu::Buffer],
        count: usize,
    ) -> Result<(), DeviceError> {
        if count > self.room.count {
            let needs = (&self.pipelines, &self.parameters);
            self.room = Room::new(device, populations, needs, SPARE * count)?;
        }
        Ok(())
    }
}

impl Room {
    fn new(
        device: &Device,
        populations: &[wgpu::Buffer],
        (pipelines, parameters): (&[Pipeline; 2], &wgpu::Buffer),
        count: usize,
    ) -> Result<Self, DeviceError> {
        let bytes = 4 * count as u64;
        let places = device.storage("link places", 2 * bytes)?;
        let numbers = device.storage("link populations", bytes)?;
        let mut named = by_number(populations);
        named.extend([
            ("link_parameters", parameters),
            ("link_places", &places),
            ("link_populations", &numbers),
        ]);
        let bound = [
            device.bind(&pipelines[0], &named)?,
            device.bind(&pipelines[1], &named)?,
        ];
        Ok(Self {
            count,
            bound,
            places,
            numbers,
            staging: Staging::new(device, bytes)?,
        })
    }
}
