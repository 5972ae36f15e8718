//! Stage `collide_stream`: one in-place step of the whole grid, then what enters through the faces.
//!
//! A submission is kept below a quarter of a second, so that no watchdog takes the device for hung: a step longer than that is cut into
//! runs of planes, which depend on nothing within the step.

use std::time::{Duration, Instant};

use super::force_box::ForceBox;
use super::held_eddy_viscosity::HeldEddyViscosity;
use super::parameters::StepParameters;
use super::{Bound, Fluid};
use crate::gpu::commands::{Commands, Pass};
use crate::gpu::error::DeviceError;

/// Longest submission that is aimed at; watchdogs bite after about two seconds.
const SUBMISSION_LIMIT: Duration = Duration::from_millis(250);

/// Planes of the first submission.
const FIRST_PLANES: usize = 8;

/// Submissions that are timed; some of them with every variant of the stage.
const TIMED_SUBMISSIONS: u32 = 12;

impl Fluid {
    /// Advances the air by one step under a uniform acceleration and the body force of a box of cells, if there are any. Begins with the
    /// stage `eddy_viscosity` where it is due and the caller has left it out. Where cells have gone ahead, only those follow that waited.
    pub fn collide_stream(
        &mut self,
        acceleration: Option<[f64; 3]>,
        forces: Option<&ForceBox>,
    ) -> Result<(), DeviceError> {
        match self.awaited.take() {
            Some(awaited) => self.collide_awaited(forces, awaited)?,
            None => {
                self.eddy_viscosity()?;
                self.last_acceleration = acceleration.unwrap_or_default();
                let bound = self.bound(acceleration, forces)?;
                let mut parameters = StepParameters {
                    acceleration: four(acceleration.unwrap_or_default()),
                    ..self.step_parameters_of()
                };
                if let Some(forces) = forces {
                    parameters.box_first[..3].copy_from_slice(&forces.first);
                    parameters.box_size[..3].copy_from_slice(&forces.size);
                }
                self.sweep(&bound, parameters)?;
            }
        }
        self.odd = !self.odd;
        self.steps += 1;
        Ok(())
    }

    /// What a step under these accelerations and forces is bound to.
    pub(super) fn bound(
        &mut self,
        acceleration: Option<[f64; 3]>,
        forces: Option<&ForceBox>,
    ) -> Result<Bound, DeviceError> {
        if let Some(forces) = forces
            && self
                .forced
                .as_ref()
                .is_none_or(|(_, generation)| *generation != forces.generation)
        {
            self.bind_forces(forces)?;
        }
        let parity = usize::from(self.odd);
        Ok(match (&self.forced, forces, acceleration) {
            (Some((forced, _)), Some(_), _) => forced[parity].clone(),
            (_, _, Some(_)) => self.accelerated[parity].clone(),
            _ => self.free[parity].clone(),
        })
    }

    /// Of a step without force, of all cells.
    pub(super) fn step_parameters_of(&self) -> StepParameters {
        StepParameters {
            inlet_velocity: four(self.inlet_velocity),
            ..StepParameters::default()
        }
    }

    /// One step of the cells of a part, plane by plane, then what enters through the faces.
    pub(super) fn sweep(
        &mut self,
        bound: &Bound,
        mut parameters: StepParameters,
    ) -> Result<(), DeviceError> {
        let parity = usize::from(self.odd);
        let planes = self.setup.cells[2];
        let mut first = 0;
        while first < planes {
            let count = self.planes_at_once().min(planes - first);
            parameters.first_plane = first as u32;
            self.device.write(&self.step_parameters, 0, &[parameters]);
            let mut commands = self.device.record("collide_stream");
            {
                let mut pass = commands.pass("collide_stream");
                bound.dispatch(&mut pass, [self.groups_per_plane(), count as u32]);
                if first + count == planes {
                    self.record_boundaries(&mut pass, parity);
                }
            }
            self.submit_timed(commands, count)?;
            first += count;
        }
        Ok(())
    }

    /// True once it is known how long a plane takes.
    pub(super) const fn is_timed(&self) -> bool {
        self.timed_submissions >= TIMED_SUBMISSIONS
    }

    /// Advances force-free air by many steps, as many in one submission as fit.
    pub fn collide_stream_steps(&mut self, steps: usize) -> Result<(), DeviceError> {
        let planes = self.setup.cells[2];
        self.last_acceleration = [0.0; 3];
        let mut left = steps;
        while left > 0 {
            let at_once = self.planes_at_once() / planes;
            if at_once < 2 {
                self.collide_stream(None, None)?;
                left -= 1;
                continue;
            }
            let parameters = self.step_parameters_of();
            self.device.write(&self.step_parameters, 0, &[parameters]);
            let cells = self.grid.cell_count() as u64;
            self.write_eddy_parameters(0, cells);
            let count = at_once.min(left).min(32);
            let mut commands = self.device.record("collide_stream");
            {
                let mut pass = commands.pass("collide_stream");
                for _ in 0..count {
                    self.record_eddy_viscosity(&mut pass, cells);
                    let parity = usize::from(self.odd);
                    self.free[parity].dispatch(&mut pass, [self.groups_per_plane(), planes as u32]);
                    self.record_boundaries(&mut pass, parity);
                    self.odd = !self.odd;
                    self.steps += 1;
                }
            }
            self.device.submit(commands);
            left -= count;
        }
        Ok(())
    }

    /// Recorded after the sweep of a step of the given parity.
    fn record_boundaries(&self, pass: &mut Pass<'_>, parity: usize) {
        if let Some(faces) = &self.absorbing_faces {
            faces.record_inlet(pass, 1 - parity);
        }
        if let Some(boundaries) = &self.boundaries {
            let (bound, groups) = &boundaries[1 - parity];
            bound.dispatch(pass, *groups);
        }
        if let Some(faces) = &self.absorbing_faces {
            faces.record_sides(pass, 1 - parity);
        }
    }

    fn groups_per_plane(&self) -> u32 {
        self.grid
            .stride_z
            .div_ceil(self.device.tuning().workgroup as usize) as u32
    }

    /// Planes that one submission may hold.
    pub(super) fn planes_at_once(&self) -> usize {
        match self.plane_time {
            None => FIRST_PLANES,
            Some(time) => {
                let planes = SUBMISSION_LIMIT.as_secs_f64() / time.as_secs_f64().max(1e-9);
                (planes as usize).clamp(1, 1 << 24)
            }
        }
    }

    /// Submits a run of planes; the first ones are waited for, to learn how long a plane takes. The shortest counts: dispatches that
    /// also compile, or find a device still asleep, take longer.
    fn submit_timed(&mut self, commands: Commands, planes: usize) -> Result<(), DeviceError> {
        if self.is_timed() {
            self.leave_if_short(commands, planes as f64);
            return self.device.check();
        }
        self.device.wait()?;
        let start = Instant::now();
        self.device.submit(commands);
        self.device.wait()?;
        let now = start.elapsed() / planes as u32;
        self.plane_time = Some(self.plane_time.map_or(now, |best| best.min(now)));
        self.timed_submissions += 1;
        Ok(())
    }

    /// Leaves what works on so many planes to the next submission, where that takes a short time.
    pub(super) fn leave_if_short(&self, commands: Commands, planes: f64) {
        let takes = self.plane_time.unwrap_or_default().mul_f64(planes);
        if takes <= self.device.tuning().longest_left {
            self.device.leave(commands);
        } else {
            self.device.submit(commands);
        }
    }

    fn bind_forces(&mut self, forces: &ForceBox) -> Result<(), DeviceError> {
        let bound = |odd| -> Result<Bound, DeviceError> {
            let mut named = self.named_populations(odd);
            named.push(("step", &self.step_parameters));
            named.push(("cell_forces", &forces.forces));
            named.extend(
                self.held_eddy_viscosity
                    .iter()
                    .map(HeldEddyViscosity::named),
            );
            named.extend(
                self.inlet_profile
                    .iter()
                    .map(|profile| ("profile", profile)),
            );
            self.device.bind(&self.forced_pipeline, &named)
        };
        self.forced = Some(([bound(false)?, bound(true)?], forces.generation));
        Ok(())
    }
}

fn four(v: [f64; 3]) -> [f32; 4] {
    [v[0] as f32, v[1] as f32, v[2] as f32, 0.0]
}
