//! Stages `read_links`, `bounce` and `fetch_wall_forces` where no wall moves ([`crate::cut_links::standing_walls`]): the device answers along cut links by itself. The sums of the forces wait on
//! it, step after step, until the host asks for them.

use std::sync::Arc;

use super::Fluid;
use super::answers::Answers;
use super::force_sums::{ForceAndMoment, ForceSums};
use super::link_lists::LinkLists;
use super::moving_answers::untroubled;
use super::standing_tables::{Push, StandingParameters};
use crate::cut_links::images::Asked;
use crate::cut_links::{ChangedByPair, Images, StandingWalls};
use crate::gpu::error::DeviceError;
use crate::lattice::DIRECTION_COUNT;

/// No population changes along open links.
const NOTHING: &ChangedByPair = &[const { Vec::new() }; 4];

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

    /// Stage `bounce` at walls along whose links the device answers by itself. The sums of the forces wait on the device, those of the steps before with them.
    pub fn answer_walls(&mut self) -> Result<(), DeviceError> {
        if self.moving.is_some() {
            return self.answer_moving_walls();
        }
        let (Some(answers), Some(lists)) = (&mut self.answers, &self.link_lists) else {
            return Ok(());
        };
        let counts = answers.counts;
        let parameters = StandingParameters {
            sums_from: answers.sums.next()?,
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
        Ok(())
    }

    const fn force_sums(&mut self) -> Option<&mut ForceSums> {
        match (&mut self.moving, &mut self.answers) {
            (Some(moving), _) => Some(&mut moving.sums),
            (None, Some(answers)) => Some(&mut answers.sums),
            (None, None) => None,
        }
    }

    /// Has the device begin with what was recorded, and bring the forces of the steps that wait.
    pub fn ask_wall_forces(&mut self) {
        let device = Arc::clone(&self.device);
        if let Some(sums) = self.force_sums() {
            sums.ask(&device);
        }
    }

    /// Leaves the forces of the steps that wait on the device: nobody asks for them.
    pub const fn forget_wall_forces(&mut self) {
        if let Some(sums) = self.force_sums() {
            sums.forget();
        }
    }

    /// Stage `fetch_wall_forces`: forces of the next of the steps that were asked for, and their moments, by body; nothing where no link is cut. Waits for all of them before the first.
    pub fn fetch_wall_forces(&mut self) -> Result<Vec<ForceAndMoment>, DeviceError> {
        let device = Arc::clone(&self.device);
        let moves = self.moving.is_some();
        let Some(sums) = self.force_sums() else {
            return Ok(Vec::new());
        };
        let mut found = sums.take(&device)?;
        if moves {
            let behind = found.pop().unwrap_or_default();
            untroubled(&behind)?;
            self.moving_links = behind[0][1] as usize;
        }
        Ok(found)
    }
}
