//! Mean forces of the air between samples, from the impulses that it has given.

use glam::DVec3;

use crate::gpu::DeviceError;
use crate::simulation::{BodyImpulse, Simulation};

/// Impulses at the last sample, and of bodies at the one before, too.
#[derive(Debug, Default)]
pub(super) struct Impulses {
    pub last: Option<Impulse>,
    /// Impulse and angular impulse of every rigid body at the last two samples.
    pub bodies: [Vec<BodyImpulse>; 2],
    /// Impulse of all markers along x at the last two samples [N s].
    markers_x: [Option<f64>; 2],
    /// Time between the last two samples [s].
    interval_s: f64,
}

/// Impulse of the air since release by the three routes [N s]; not a number where a route is not defined.
#[derive(Debug, Clone, Copy)]
pub(super) struct Impulse {
    pub time_s: f64,
    pub markers: DVec3,
    pub momentum_box: DVec3,
    pub supports: DVec3,
}

/// What a sample knows of the forces of the air.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forces {
    /// Impulses now.
    pub impulse: Impulse,
    /// Mean force since the last sample by markers [N].
    pub markers_n: DVec3,
    /// The same by the momentum of a box of air [N].
    pub momentum_box_n: DVec3,
    /// The same by lines and supports [N].
    pub supports_n: DVec3,
    /// Defect of the mass balance of that box, over its mass.
    pub mass_defect: f64,
}

impl Impulses {
    /// A new sample.
    pub fn sample(&mut self, simulation: &mut Simulation) -> Result<Forces, DeviceError> {
        let sample = simulation.impulse_sample()?;
        let unknown = DVec3::NAN;
        let now = Impulse {
            time_s: simulation.time_s(),
            markers: sample.as_ref().map_or(unknown, |s| s.markers),
            momentum_box: sample
                .as_ref()
                .and_then(|s| s.momentum_box)
                .unwrap_or(unknown),
            supports: sample.as_ref().and_then(|s| s.supports).unwrap_or(unknown),
        };
        let last = self.last;
        self.interval_s = last.map_or(f64::NAN, |last| now.time_s - last.time_s);
        let force = |pick: fn(&Impulse) -> DVec3| {
            last.map_or(unknown, |last| {
                (pick(&now) - pick(&last)) / (now.time_s - last.time_s)
            })
        };
        let forces = Forces {
            impulse: now,
            markers_n: force(|i| i.markers),
            momentum_box_n: force(|i| i.momentum_box),
            supports_n: force(|i| i.supports),
            mass_defect: sample.as_ref().map_or(f64::NAN, |s| s.mass_defect),
        };
        self.last = sample.as_ref().map(|_| now);
        self.markers_x = [last.map(|last| last.markers.x), Some(now.markers.x)];
        let bodies = sample.map_or_else(Vec::new, |sample| sample.bodies);
        self.bodies = [std::mem::take(&mut self.bodies[1]), bodies];
        Ok(forces)
    }

    /// Mean force along x since the last sample [N] on a body, or on all markers.
    pub fn force_x_n(&self, body: Option<usize>) -> f64 {
        let [before, now] = match body {
            Some(number) => {
                let impulse = |all: &Vec<BodyImpulse>| all.get(number).map(|body| body.force.x);
                [0, 1].map(|sample| impulse(&self.bodies[sample]))
            }
            None => self.markers_x,
        };
        let gained = now.zip(before).map(|(now, before)| now - before);
        gained.unwrap_or(f64::NAN) / self.interval_s
    }

    /// Mean force [N] and moment [N m] on a body since the last sample.
    pub fn of_body(&self, number: usize) -> [DVec3; 2] {
        let [last, now] = &self.bodies;
        match (now.get(number), last.get(number)) {
            (Some(now), Some(last)) => [
                (now.force - last.force) / self.interval_s,
                (now.moment - last.moment) / self.interval_s,
            ],
            _ => [DVec3::NAN; 2],
        }
    }
}
