//! Stages `find_links`, `read_links` and `bounce` where walls move, as is prescribed or as the device itself solves, and it needs the host for nothing more: it finds the links that they cut
//! (`shaders/find_links.wgsl`), and answers along them (`shaders/moving_walls.wgsl`).
//!
//! *Departures from the host's search* ([`crate::cut_links::search`]): distances of cuts are in single precision, from the nodes' nearest cells, so that they differ by some 1e-7 of the size of a triangle. Its edges are 16 cells long at most.

use super::Fluid;
use super::moving_answers::{BLOCK, Moving, MovingWalls, not_laid};
use super::moving_tables::{WallNode, WallParameters};
use crate::gpu::cloth::LinksInAir;
use crate::gpu::error::DeviceError;
use crate::gpu::shaders::WORKGROUP;

impl Fluid {
    /// Lays out what does not change while `walls` move: triangles, room for links, and for the forces of `most_steps` steps. Nothing is done where that is so already, and room is left.
    pub fn lay_moving_walls(
        &mut self,
        walls: &MovingWalls<'_>,
        most_steps: usize,
    ) -> Result<(), DeviceError> {
        if (self.moving.as_ref()).is_none_or(|moving| !moving.has_room(walls.area)) {
            let air = (&self.grid, self.storage, &*self.populations);
            self.moving = Some(Moving::new(&self.device, air, walls, most_steps)?);
        }
        Ok(())
    }

    /// Lays a box around the surface for the steps to come: its first cell, and its size.
    pub fn enclose_walls(&mut self, first: [i32; 3], size: [u32; 3]) -> Result<(), DeviceError> {
        let moving = self.moving.as_mut().ok_or_else(not_laid)?;
        self.device.write(moving.buffer("trouble")?, 0, &[0_u32]);
        let count: u64 = size.iter().map(|&cells| u64::from(cells)).product();
        moving.make_room(&self.device, count)?;
        let [x, y, z] = first;
        moving.counts.box_first = [x, y, z, 0];
        let [x, y, z] = size.map(|cells| cells as i32);
        moving.counts.box_size = [x, y, z, 0];
        moving.counts.box_count = count as u32;
        moving.counts.block_count = count.div_ceil(BLOCK) as u32;
        Ok(())
    }

    /// Stage `find_links`, for `nodes` and, of fabric and each body, the points that moments are about.
    pub fn find_moving_links(
        &mut self,
        nodes: &[WallNode],
        moment_points: &[WallNode],
    ) -> Result<(), DeviceError> {
        let sums_from = self.moving.as_mut().ok_or_else(not_laid)?.sums.next()?;
        let moving = self.moving.as_ref().ok_or_else(not_laid)?;
        let device = &self.device;
        device.write(moving.buffer("wall_nodes")?, 0, nodes);
        device.write(moving.buffer("moment_points")?, 0, moment_points);
        self.find_links(sums_from)
    }

    /// The same for nodes where they are on the device; nobody asks for the sums of the forces.
    pub fn find_links_of_nodes(&self) -> Result<(), DeviceError> {
        self.find_links(0)
    }

    fn find_links(&self, sums_from: u32) -> Result<(), DeviceError> {
        let moving = self.moving.as_ref().ok_or_else(not_laid)?;
        let device = &self.device;
        let counts = WallParameters {
            odd: u32::from(self.odd),
            sums_from,
            ..moving.counts
        };
        device.write(&moving.parameters, 0, &[counts]);
        let boxed = moving.boxed.as_ref().ok_or_else(not_laid)?;
        let triangles = device.workgroups(u64::from(counts.triangles));
        let blocks = device.workgroups(u64::from(WORKGROUP * counts.block_count));
        let links = device.workgroups(u64::from(counts.most_links));
        let mut commands = device.record("find_links");
        let cells = 4 * u64::from(counts.box_count);
        commands.raw.clear_buffer(&boxed.around, 0, Some(cells));
        commands.raw.clear_buffer(moving.buffer("found")?, 0, None);
        // No link has two layers yet.
        let trouble = moving.buffer("trouble")?;
        commands.raw.clear_buffer(trouble, 4, Some(4));
        let [which, ends, whose] = &boxed.look_along;
        {
            let mut pass = commands.pass("find_links");
            which.dispatch(&mut pass, triangles);
            boxed.scan_cells.dispatch(&mut pass, blocks);
            boxed.scan_blocks.dispatch(&mut pass, [1, 1]);
            ends.dispatch(&mut pass, triangles);
            whose.dispatch(&mut pass, triangles);
            boxed.lay_links.dispatch(&mut pass, links);
        }
        let totals = moving.buffer("totals")?;
        for (at, to) in [
            (0, &moving.read_parameters),
            (16, &moving.bounce_parameters),
        ] {
            commands.raw.copy_buffer_to_buffer(totals, at, to, 0, 16);
        }
        device.leave(commands);
        Ok(())
    }

    /// Links that walls cut in the last step whose forces were fetched, where the device finds them.
    #[must_use]
    pub const fn moving_links(&self) -> usize {
        self.moving_links
    }

    /// Buffers that fabric of the same device meets, by name in the shaders.
    pub fn links_in_air(&self) -> Result<LinksInAir<'_>, DeviceError> {
        let moving = self.moving.as_ref().ok_or_else(not_laid)?;
        let boxed = moving.boxed.as_ref().ok_or_else(not_laid)?;
        let mut all: LinksInAir<'_> = vec![
            ("walls", &moving.parameters),
            ("around", &boxed.around),
            ("starts", &boxed.starts),
            ("blocks", &boxed.blocks),
        ];
        all.extend(moving.named.iter().map(|(name, buffer)| (*name, buffer)));
        Ok(all)
    }

    /// Stage `read_links` at walls that move.
    pub fn read_moving_walls(&self) -> Result<(), DeviceError> {
        let moving = self.moving.as_ref().ok_or_else(not_laid)?;
        let populations = 4 * u64::from(moving.counts.most_links);
        let mut commands = self.device.record("read_links");
        {
            let mut pass = commands.pass("read_links");
            let groups = self.device.workgroups(populations);
            moving.read_links.dispatch(&mut pass, groups);
        }
        self.device.leave(commands);
        Ok(())
    }

    /// Stage `bounce` at walls that move.
    pub(super) fn answer_moving_walls(&self) -> Result<(), DeviceError> {
        let moving = self.moving.as_ref().ok_or_else(not_laid)?;
        let boxed = moving.boxed.as_ref().ok_or_else(not_laid)?;
        let (device, counts) = (&self.device, moving.counts);
        let links = device.workgroups(u64::from(counts.most_links));
        let cells = device.workgroups(u64::from(counts.box_count));
        let portions = u64::from(WORKGROUP) * moving.sums.portions() as u64;
        let written = 2 * u64::from(counts.most_links) + u64::from(counts.most_cells);
        let mut commands = device.record("bounce");
        {
            let mut pass = commands.pass("bounce");
            boxed.answer.dispatch(&mut pass, links);
            boxed.gather_rest.dispatch(&mut pass, cells);
            if moving.sums_forces {
                let groups = device.workgroups(portions);
                boxed.sum_forces.dispatch(&mut pass, groups);
            }
            (moving.bounce).dispatch(&mut pass, device.workgroups(written));
        }
        device.leave(commands);
        Ok(())
    }
}
