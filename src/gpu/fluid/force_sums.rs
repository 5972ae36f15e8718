//! Sums of the forces on walls along whose cut links a device answers by itself. They wait on it, step after step, until the host asks for them.

use std::collections::VecDeque;

use crate::gpu::device::Device;
use crate::gpu::error::DeviceError;
use crate::gpu::transfer::Staging;

/// Force on a body in a step, and its moment about the body's moment point [lattice units].
pub type ForceAndMoment = [[f64; 3]; 2];

/// Bytes of a portion's force and moment.
const PORTION_BYTES: u64 = 24;

/// What waits on the device, and what was brought.
#[derive(Debug)]
pub(super) struct ForceSums {
    pub buffer: wgpu::Buffer,
    staging: Staging,
    /// End of the portions of each body.
    bodies: Vec<usize>,
    /// Steps that fit, and those that wait.
    most: usize,
    waiting: usize,
    submitted: Option<(wgpu::SubmissionIndex, usize)>,
    /// Of steps that were brought, by portion.
    brought: VecDeque<Vec<[f32; 6]>>,
}

impl ForceSums {
    /// Room for `most` steps of bodies whose portions end there.
    pub fn new(device: &Device, bodies: Vec<usize>, most: usize) -> Result<Self, DeviceError> {
        let portions = bodies.last().copied().unwrap_or_default();
        let bytes = PORTION_BYTES * (portions * most) as u64;
        Ok(Self {
            buffer: device.storage("force sums", bytes)?,
            staging: Staging::new(device, bytes.max(16))?,
            bodies,
            most,
            waiting: 0,
            submitted: None,
            brought: VecDeque::new(),
        })
    }

    /// Portions of a step.
    pub fn portions(&self) -> usize {
        self.bodies.last().copied().unwrap_or_default()
    }

    /// Where those of the step to come go [numbers].
    pub fn next(&mut self) -> Result<u32, DeviceError> {
        if self.waiting == self.most {
            let what = format!("forces of {} steps wait on the device", self.most);
            return Err(DeviceError::Command(what));
        }
        let at = 6 * self.portions() * self.waiting;
        self.waiting += 1;
        Ok(at as u32)
    }

    /// Has the device begin with what was recorded, and bring those of the steps that wait.
    pub fn ask(&mut self, device: &Device) {
        let bytes = self.step_bytes() * self.waiting as u64;
        let mut commands = device.record("fetch_wall_forces");
        (self.staging).copy(&mut commands, &self.buffer, 0, 0, bytes);
        let submitted = device.submit_alone(commands);
        self.submitted = Some((submitted, self.waiting));
        self.waiting = 0;
    }

    /// Leaves those of the steps that wait on the device: nobody asks for them.
    pub const fn forget(&mut self) {
        self.waiting = 0;
    }

    /// Of the next of the steps that were asked for, by body. Waits for all of them before the first.
    pub fn take(&mut self, device: &Device) -> Result<Vec<ForceAndMoment>, DeviceError> {
        if let Some((submitted, steps)) = self.submitted.take() {
            let step_bytes = self.step_bytes();
            let brought = &mut self.brought;
            (self.staging).read_of(device, submitted, step_bytes * steps as u64, |bytes| {
                let of_steps = bytes.chunks_exact(step_bytes as usize);
                brought.extend(of_steps.map(|bytes| bytemuck::cast_slice(bytes).to_vec()));
            })?;
        }
        let Some(portions) = self.brought.pop_front() else {
            let what = "forces on walls are taken before they are asked for";
            return Err(DeviceError::Command(what.to_owned()));
        };
        let mut first = 0;
        let of_body = |end: &usize| {
            let mut sum = [[0.0; 3]; 2];
            for portion in &portions[first..*end] {
                for (of, number) in portion.iter().enumerate() {
                    sum[of / 3][of % 3] += f64::from(*number);
                }
            }
            first = *end;
            sum
        };
        Ok(self.bodies.iter().map(of_body).collect())
    }

    fn step_bytes(&self) -> u64 {
        PORTION_BYTES * self.portions() as u64
    }
}
