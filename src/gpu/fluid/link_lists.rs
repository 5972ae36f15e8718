//! Lists of populations on the device, for the stages of cut links. They are made anew where other links are cut; where a surface stands still, those of
//! even and of odd steps stay.

use super::at_rest::AtRest;
use super::names::by_number;
use crate::gpu::commands::Pass;
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

/// Array and element of a population.
pub(super) type Listed = [u32; 2];

/// Populations on the device that a stage reads or writes.
#[derive(Debug)]
pub(super) struct List {
    name: &'static str,
    pipeline: Pipeline,
    reads: bool,
    /// Room for so many times the populations that there are, when it is made anew.
    spare: usize,
    room: Option<Room>,
    /// Number of the search for links that the places were made of, and how many there are.
    made_of: (u64, usize),
}

/// Buffers for so many populations.
#[derive(Debug)]
struct Room {
    count: usize,
    parameters: wgpu::Buffer,
    places: wgpu::Buffer,
    numbers: wgpu::Buffer,
    /// Where they come back to the host.
    staging: Option<Staging>,
    /// What brings them; `None` until they are asked for.
    submitted: Option<wgpu::SubmissionIndex>,
    bound: Bound,
}

/// The lists of a fluid: of each stage, those of even and of odd steps.
#[derive(Debug)]
pub(super) struct LinkLists {
    pub(super) read_links: [List; 2],
    pub(super) read_images: [List; 2],
    pub(super) bounce: [List; 2],
    /// Places and numbers of the stage under way, before they are sent.
    pub(super) places: Vec<Listed>,
    pub(super) numbers: Vec<f32>,
    /// What goes to populations at rest.
    pub(super) at_rest: AtRest,
}

impl LinkLists {
    /// Lists without room.
    pub(super) fn new(device: &Device, storage: Storage) -> Result<Self, DeviceError> {
        let [read, bounce] = device.pipelines(
            &shaders::CUT_LINKS[storage as usize],
            ["read_links", "bounce"],
            &[],
        )?;
        let list = |name, pipeline: &Pipeline, reads| {
            [(); 2].map(|()| List {
                name,
                pipeline: pipeline.clone(),
                reads,
                spare: SPARE,
                room: None,
                made_of: (0, 0),
            })
        };
        Ok(Self {
            read_links: list("read_links", &read, true),
            read_images: list("read_images", &read, true),
            bounce: list("bounce", &bounce, false),
            places: Vec::new(),
            numbers: Vec::new(),
            at_rest: AtRest::default(),
        })
    }
}

impl LinkLists {
    /// Without room to spare, and without what brings numbers to the host: where walls stand, places are laid once, and the device answers by itself.
    pub(super) fn standing(mut self) -> Self {
        let all = [
            &mut self.read_links,
            &mut self.read_images,
            &mut self.bounce,
        ];
        for list in all.into_iter().flatten() {
            (list.reads, list.spare) = (false, 1);
        }
        self
    }
}

impl List {
    /// True if it holds the places of `count` populations by the links of a `search`.
    pub(super) fn is_of(&self, search: u64, count: usize) -> bool {
        self.room.is_some() && self.made_of == (search, count)
    }

    /// Sends the places, made of the links of a `search`.
    pub(super) fn lay(
        &mut self,
        device: &Device,
        populations: &[wgpu::Buffer],
        search: u64,
        places: &[Listed],
    ) -> Result<(), DeviceError> {
        let count = places.len();
        let room = match self.room.take() {
            Some(room) if room.count >= count => room,
            _ => Room::new(
                device,
                populations,
                &self.pipeline,
                (self.spare * count, self.reads),
            )?,
        };
        let parameters = LinkParameters {
            count: count as u32,
            ..LinkParameters::default()
        };
        device.write(&room.parameters, 0, &[parameters]);
        device.write(&room.places, 0, places);
        self.room = Some(room);
        self.made_of = (search, count);
        Ok(())
    }

    /// Records that the first `count` populations are read, or that the numbers of all of them are written.
    pub(super) fn record(&self, device: &Device, pass: &mut Pass<'_>, count: usize) {
        if let Some(room) = &self.room {
            let groups = device.workgroups(count as u64);
            room.bound.dispatch(pass, groups);
        }
    }

    /// What was read, or what is to be written; `None` before places were laid.
    pub(super) fn on_device(&self) -> Option<&wgpu::Buffer> {
        self.room.as_ref().map(|room| &room.numbers)
    }

    /// Submits that the first `count` populations are read; [`List::numbers`] waits for them.
    pub(super) fn read(&mut self, device: &Device, count: usize) {
        let mut commands = device.record(self.name);
        {
            let mut pass = commands.pass(self.name);
            self.record(device, &mut pass, count);
        }
        let Some(room) = &mut self.room else { return };
        if let Some(staging) = &room.staging {
            let bytes = 4 * count as u64;
            staging.copy(&mut commands, &room.numbers, 0, 0, bytes);
        }
        room.submitted = Some(device.submit_alone(commands));
    }

    /// Shows the first `count`, as they were read. Waits for nothing that was submitted later.
    pub(super) fn numbers(
        &mut self,
        device: &Device,
        count: usize,
        show: impl FnOnce(&[f32]),
    ) -> Result<(), DeviceError> {
        let asked = self.room.as_mut().and_then(|room| {
            let submitted = room.submitted.take()?;
            Some((room.staging.as_ref()?, submitted))
        });
        let Some((staging, submitted)) = asked else {
            let what = format!("{} is fetched before it is asked for", self.name);
            return Err(DeviceError::Command(what));
        };
        let bytes = 4 * count as u64;
        staging.read_of(device, submitted, bytes, |bytes| {
            show(bytemuck::cast_slice(bytes));
        })
    }

    /// Leaves to the next submission that `numbers` go to the populations.
    pub(super) fn write(&self, device: &Device, numbers: &[f32]) {
        let Some(room) = &self.room else { return };
        device.write(&room.numbers, 0, numbers);
        let mut commands = device.record(self.name);
        {
            let mut pass = commands.pass(self.name);
            self.record(device, &mut pass, numbers.len());
        }
        device.leave(commands);
    }
}

impl Room {
    fn new(
        device: &Device,
        populations: &[wgpu::Buffer],
        pipeline: &Pipeline,
        (count, reads): (usize, bool),
    ) -> Result<Self, DeviceError> {
        let bytes = 4 * count as u64;
        let parameters = device.uniform::<LinkParameters>("link parameters")?;
        let places = device.storage("link places", 2 * bytes)?;
        let numbers = device.storage("link populations", bytes)?;
        let mut named = by_number(populations);
        named.extend([
            ("link_parameters", &parameters),
            ("link_places", &places),
            ("link_populations", &numbers),
        ]);
        let bound = device.bind(pipeline, &named)?;
        Ok(Self {
            count,
            bound,
            parameters,
            places,
            numbers,
            staging: (reads.then(|| Staging::new(device, bytes))).transpose()?,
            submitted: None,
        })
    }
}
