//! Samples in a checkpoint.

use glam::DVec3;

use super::{LastImpulses, Record};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::simulation::BodyImpulse;

impl Record {
    /// Writes all samples.
    pub fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        let flat: Vec<f64> = self.rows.iter().flatten().copied().collect();
        out.put("record", &flat)?;
        let changed: Vec<f64> = self.grid_changed_s.into_iter().collect();
        out.put("record_grid_changed", &changed)?;
        let last: Vec<DVec3> = self
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
        let bodies: Vec<DVec3> = self.body_impulses[1]
            .iter()
            .flat_map(|body| [body.force, body.moment])
            .collect();
        out.put("record_last_bodies", &bodies)
    }

    /// Takes them from a checkpoint of the same case.
    pub fn restore(&mut self, from: &Reader) -> Result<(), CheckpointError> {
        let flat: Vec<f64> = from.take("record")?;
        self.rows = flat
            .chunks_exact(self.columns.len())
            .map(<[f64]>::to_vec)
            .collect();
        self.grid_changed_s = from.take::<f64>("record_grid_changed")?.first().copied();
        let last: Vec<DVec3> = from.take("record_last")?;
        self.last = match last.as_slice() {
            [time, markers, momentum_box, supports] => Some(LastImpulses {
                time_s: time.x,
                markers: *markers,
                momentum_box: *momentum_box,
                supports: *supports,
            }),
            _ => None,
        };
        let bodies: Vec<DVec3> = from.take("record_last_bodies")?;
        self.body_impulses[1] = bodies
            .chunks_exact(2)
            .map(|pair| BodyImpulse {
                force: pair[0],
                moment: pair[1],
            })
            .collect();
        Ok(())
    }
}
