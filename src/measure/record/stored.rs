//! Samples in a checkpoint.

use std::path::Path;

use glam::DVec3;

use super::series::Record;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::measure::impulses::Impulse;
use crate::simulation::BodyImpulse;

impl Record {
    /// Writes what is not in the file of the samples, and how to know that file again.
    pub fn save(&mut self, out: &mut Writer) -> std::io::Result<()> {
        let (recent, newest, in_file) = self.samples.for_checkpoint()?;
        out.put("record_recent", recent)?;
        out.put("record_newest", newest)?;
        out.put("record_in_file", &in_file)?;
        out.put("record_kept", self.samples.kept())?;
        let changed: Vec<f64> = self.grid_changed_s.into_iter().collect();
        out.put("record_grid_changed", &changed)?;
        let last: Vec<DVec3> = self
            .impulses
            .last
            .iter()
            .flat_map(|l| {
                [
                    DVec3::splat(l.time_s),
                    l.markers,
                    l.momentum_box,
                    l.supports,
                ]
            })
            .collect();
        out.put("record_last", &last)?;
        let bodies: Vec<DVec3> = self.impulses.bodies[1]
            .iter()
            .flat_map(|body| [body.force, body.moment])
            .collect();
        out.put("record_last_bodies", &bodies)
    }

    /// Takes the samples from a checkpoint of the same case in `folder`, where the file of older samples is.
    pub fn restore(&mut self, from: &Reader, folder: &Path) -> Result<(), CheckpointError> {
        let in_memory = (
            from.take("record_kept")?,
            from.take("record_recent")?,
            from.take("record_newest")?,
        );
        let in_file: Vec<u64> = from.take_exactly("record_in_file", 2)?;
        let restored = self
            .samples
            .restore(in_memory, [in_file[0], in_file[1]], folder);
        restored.map_err(|what| from.damaged(what))?;
        self.grid_changed_s = from.take::<f64>("record_grid_changed")?.first().copied();
        let last: Vec<DVec3> = from.take("record_last")?;
        self.impulses.last = match last.as_slice() {
            [time, markers, momentum_box, supports] => Some(Impulse {
                time_s: time.x,
                markers: *markers,
                momentum_box: *momentum_box,
                supports: *supports,
            }),
            _ => None,
        };
        let bodies: Vec<DVec3> = from.take("record_last_bodies")?;
        self.impulses.bodies[1] = bodies
            .chunks_exact(2)
            .map(|pair| BodyImpulse {
                force: pair[0],
                moment: pair[1],
            })
            .collect();
        Ok(())
    }
}
