//! Stages `read_links`, `bounce` and `fetch_wall_forces` where no wall moves ([`crate::cut_links::standing_walls`]): the device answers along cut links by itself. The sums of the forces wait on
//! it, step after step, until the host asks for them.

use super::Fluid;
use super::answers::Answers;
use super::link_lists::LinkLists;
use super::standing_tables::{Push, StandingParameters};
use crate::cut_links::images::Asked;
use crate::cut_links::{ChangedByPair, Images, StandingWalls};
use crate::gpu::error::DeviceError;
use crate::lattice::DIRECTION_COUNT;

/// No population changes along open links.
const NOTHING: &ChangedByPair = &[const { Vec::new() }; 4];

/// Force on a body in a step, and its moment about the body's moment point [lattice units].
pub type ForceAndMoment = [[f64; 3]; 2];

fn not_laid() -> DeviceError {
    DeviceError::Command("standing walls are answered before they are laid out".to_owned())
}

impl Fluid {
    /// Lays out what does not change while `walls` stand: places of even and of odd steps, tables, and room for the forces of `most` steps. `bodies` has the sides of each body. Nothing is
    /// done where that is so already.
    pub fn lay_walls(
        &mut self,
        walls: &StandingWalls,
        bodies: impl FnOnce() -> Vec<Vec<Push>>,
        most: usize,
    ) -> Result<(), DeviceError> {
        let search = walls.links.search();
        if (self.answers.as_ref()).is_some_and(|answers| answers.search == search) {
            return Ok(());
        }
        self.answers = None;
        let links = walls.links.links();
        if links.is_empty() {
            return Ok(());
        }
        let cells = (walls.images).map_or(&[][..], |images: &Images| images.cells(Asked::Images));
        let mut lists = LinkLists::new(&self.device, self.storage)?.standing();
        for odd in [false, true] {
            self.lay_read_links(&mut lists, (search, links), odd)?;
            if !cells.is_empty() {
                self.lay_read_images(&mut lists, (search, cells), odd)?;
            }
            self.lay_bounce(&mut lists, (search, links), NOTHING, odd)?;
        }
        let image_numbers = DIRECTION_COUNT * cells.len();
        let laid = (&lists, image_numbers);
        self.answers = Some(Answers::new(&self.device, walls, laid, (&bodies(), most))?);
        lists.places = Vec::new();
        self.link_lists = Some(lists);
        self.device.check()
    }

    /// Stage `read_links` at standing walls.
    pub fn read_walls(&mut self) {
        let (Some(answers), Some(lists)) = (&self.answers, &self.link_lists) else {
            return;
        };
        let parity = usize::from(self.odd);
        let mut commands = self.device.record("read_links");
        {
            let mut pass = commands.pass("read_links");
            let numbers = 2 * answers.counts.sides as usize;
            lists.read_links[parity].record(&self.device, &mut pass, numbers);
            if answers.image_numbers > 0 {
                lists.read_images[parity].record(&self.device, &mut pass, answers.image_numbers);
            }
        }
        self.device.leave(commands);
    }

    /// Stage `bounce` at standing walls. The sums of the forces wait on the device, those of the steps before with them.
    pub fn answer_walls(&mut self) -> Result<(), DeviceError> {
        let (Some(answers), Some(lists)) = (&mut self.answers, &self.link_lists) else {
            return Ok(());
        };
        if answers.waiting == answers.most {
            let what = format!("forces of {} steps wait on the device", answers.most);
            return Err(DeviceError::Command(what));
        }
        let counts = answers.counts;
        let parameters = StandingParameters {
            sums_from: 6 * counts.portions * answers.waiting as u32,
            ..counts
        };
        self.device.write(&answers.parameters, 0, &[parameters]);
        let parity = usize::from(self.odd);
        let mut commands = self.device.record("bounce");
        {
            let mut pass = commands.pass("bounce");
            answers.passes[parity].record(&mut pass);
            let numbers = (counts.sides + counts.cells) as usize;
            lists.bounce[parity].record(&self.device, &mut pass, numbers);
        }
        self.device.leave(commands);
        answers.waiting += 1;
        Ok(())
    }

    /// Has the device begin with what was recorded, and bring the forces of the steps that wait.
    pub fn ask_wall_forces(&mut self) {
        let Some(answers) = &mut self.answers else {
            return;
        };
        let bytes = answers.step_bytes() * answers.waiting as u64;
        let mut commands = self.device.record("fetch_wall_forces");
        (answers.staging).copy(&mut commands, &answers.sums, 0, 0, bytes);
        let submitted = self.device.submit_alone(commands);
        answers.submitted = Some((submitted, answers.waiting));
        answers.waiting = 0;
    }

    /// Leaves the forces of the steps that wait on the device: nobody asks for them.
    pub const fn forget_wall_forces(&mut self) {
        if let Some(answers) = &mut self.answers {
            answers.waiting = 0;
        }
    }

    /// Stage `fetch_wall_forces`: forces of the next of the steps that were asked for, and their moments, by body; nothing where no link is cut. Waits for all of them before the first.
    pub fn fetch_wall_forces(&mut self) -> Result<Vec<ForceAndMoment>, DeviceError> {
        let Some(answers) = &mut self.answers else {
            return Ok(Vec::new());
        };
        if let Some((submitted, steps)) = answers.submitted.take() {
            let step_bytes = answers.step_bytes();
            let (device, brought) = (&self.device, &mut answers.brought);
            (answers.staging).read_of(device, submitted, step_bytes * steps as u64, |bytes| {
                let of_steps = bytes.chunks_exact(step_bytes as usize);
                brought.extend(of_steps.map(|bytes| bytemuck::cast_slice(bytes).to_vec()));
            })?;
        }
        let portions = answers.brought.pop_front().ok_or_else(not_laid)?;
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
        Ok(answers.bodies.iter().map(of_body).collect())
    }
}
