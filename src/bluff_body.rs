//! Drag of a sphere or a disk held in a stream: what [`crate::validate`] and [`crate::bench`] share.
//!
//! The body stands in a wind tunnel with frictionless walls, as in `cases/sphere.toml`. A steady flow ends as soon as its drag has settled;
//! one that may
//! shed vortices is kicked once and averaged over the second half of its time. Lengths are in diameters D, times in D/U.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::case::coupling::Scheme;
use crate::case::{self, Case, CaseError, Choices};
use crate::gpu::{Device, DeviceError};
use crate::lattice::Operator;
use crate::measure::flow_past_bodies::{disk_drag, sphere_drag};
use crate::measure::shared::{IMPULSE_MARKERS, IMPULSE_MOMENTUM_BOX, TIME};
use crate::measure::{ReadOut, Record};
use crate::plan::{AirPlacement, Placement, Plan, Precision, steps_per};
use crate::simulation::{Failure, Simulation};

/// Time between samples [D/U].
const SAMPLE_INTERVAL: f64 = 0.25;

/// Samples of each of the two windows whose mean drags are compared: 2 D/U.
const WINDOW: usize = 8;

/// Relative change of the mean drag from one window to the next below which it counts as settled.
const SETTLED: f64 = 2.5e-3;

/// Time that is given to the wake before [`SETTLED`] is asked for [D/U].
const SHORTEST: f64 = 6.0;

/// Way across the stream that a body takes at the beginning so that it sheds vortices [D], and how long that takes [D/U].
const KICK: [f64; 2] = [0.5, 4.0];

/// The wind rises over this time before t = 0 [D/U].
const RISE: f64 = 1.0;

/// π D²/4.
const FRONTAL_AREA: f64 = 0.25 * std::f64::consts::PI;

/// What stands in the stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A sphere.
    Sphere,
    /// A disk normal to the stream.
    Disk,
}

/// When a flow has been computed for long enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// Once the drag of a steady flow has settled; at this time at the latest [D/U].
    Settled(f64),
    /// At this time, averaged over the second half of it [D/U]; the body is moved across the stream at the beginning, so that it may shed
    /// vortices.
    Averaged(f64),
}

/// A body in a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BluffBody {
    /// What it is.
    pub shape: Shape,
    /// U D/ν.
    pub reynolds: f64,
    /// Cells per diameter.
    pub resolution: usize,
    /// Cells per step at U.
    pub lattice_speed: f64,
    /// Collision operator.
    pub operator: Operator,
    /// How air and body meet.
    pub scheme: Scheme,
    /// Boxes of finer cells around the body, one in the other; cells are halved so often towards it.
    pub levels: u32,
    /// Length, width and height of the tunnel [D].
    pub tunnel: [f64; 3],
    /// From the inlet to the middle of the body [D].
    pub upstream: f64,
    /// Length of the viscous layer before the outlet [D].
    pub sponge: f64,
    /// When to end.
    pub until: Until,
}

/// What the stream does to the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// Drag coefficient by the impulses that the markers spread; not finite where the flow broke down.
    pub coefficient: f64,
    /// The same from the balance of momentum of a box around the body.
    pub momentum_box: f64,
    /// False if the drag was still changing at the end.
    pub settled: bool,
    /// Time at the end [D/U].
    pub time: f64,
    /// Steps.
    pub steps: u64,
    /// Time of the steps by the clock [s].
    pub seconds: f64,
}

/// What keeps a drag from being computed.
#[derive(Debug, thiserror::Error)]
pub enum Stop {
    /// The watcher ended it.
    #[error("interrupted")]
    Interrupted,
    /// The device failed.
    #[error("{0}")]
    Device(#[from] DeviceError),
    /// The flow cannot be set up so.
    #[error("this flow cannot be computed: {0}")]
    Refused(String),
}

impl From<Box<CaseError>> for Stop {
    fn from(error: Box<CaseError>) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Device(error) => Self::Device(error),
            Failure::Start(why) => Self::Refused(why),
            Failure::Lacking(lacking) => Self::Refused(lacking.to_string()),
            Failure::Diverged(diverged) => Self::Refused(diverged.to_string()),
        }
    }
}

impl BluffBody {
    /// Frontal area over the tunnel's section.
    #[must_use]
    pub fn blockage(&self) -> f64 {
        FRONTAL_AREA / (self.tunnel[1] * self.tunnel[2])
    }

    /// Cells along x, y, z.
    #[must_use]
    pub fn cells(&self) -> [usize; 3] {
        self.tunnel
            .map(|size| (size * self.resolution as f64).round() as usize)
    }

    /// Published drag coefficient in an unbounded stream at this Reynolds number, and who published it.
    #[must_use]
    pub fn published_drag(&self) -> Option<(f64, &'static str)> {
        match self.shape {
            Shape::Sphere if self.reynolds == 300.0 => {
                Some((0.656, "Johnson & Patel 1999, J. Fluid Mech. 378:19"))
            }
            Shape::Sphere => sphere_drag(self.reynolds).map(|drag| {
                let source = "Schiller & Naumann 1933: 24/Re (1 + 0.15 Re^0.687)";
                (drag, source)
            }),
            Shape::Disk if self.reynolds > 1000.0 => {
                Some((1.17, "Clift, Grace & Weber 1978, Re > 1000"))
            }
            Shape::Disk => disk_drag(self.reynolds).map(|drag| {
                let source = "Clift, Grace & Weber 1978: 64/(pi Re) (1 + 0.138 Re^0.792)";
                (drag, source)
            }),
        }
    }

    /// Cell updates in a step, on the mean.
    pub fn updates(&self) -> Result<f64, Stop> {
        let case = self.case()?;
        Ok(case.scene.air.map_or(0.0, |air| air.updates_per_step()))
    }

    /// Steps at most, those in which the wind rises included.
    #[must_use]
    pub fn steps(&self) -> f64 {
        let (Until::Settled(end) | Until::Averaged(end)) = self.until;
        (end + RISE) * self.resolution as f64 / self.lattice_speed
    }

    /// The flow as a case, with D, U and ρ of one.
    fn case(&self) -> Result<Case, Box<CaseError>> {
        let [length, width, height] = self.tunnel;
        let (Until::Settled(end) | Until::Averaged(end)) = self.until;
        let shape = match self.shape {
            Shape::Sphere => "sphere",
            Shape::Disk => "disk",
        };
        let scheme = match self.scheme {
            Scheme::Kernel => "kernel",
            Scheme::Links => "links",
        };
        let mut source = format!(
            r#"version = 1
title = "A {shape} in a stream"
[air]
density_kg_m3 = 1.0
kinematic_viscosity_m2_s = {viscosity:?}
[air.wind_tunnel]
speed_m_s = 1.0
size_m = [{length:?}, {width:?}, {height:?}]
start_time_s = {RISE:?}
sponge_length_m = {sponge:?}
[resolution]
cells_per_diameter = {resolution:?}
lattice_speed = {lattice_speed:?}
operator = "recursive_regularised"
[bodies.{shape}]
position_m = [{upstream:?}, {y:?}, {z:?}]
[bodies.{shape}.{shape}]
diameter_m = 1.0
[coupling]
scheme = "{scheme}"
[time]
end_s = {end:?}
[output]
sample_interval_s = {SAMPLE_INTERVAL:?}
"#,
            viscosity = 1.0 / self.reynolds,
            resolution = self.resolution as f64,
            lattice_speed = self.lattice_speed,
            upstream = self.upstream,
            sponge = self.sponge,
            y = 0.5 * width,
            z = 0.5 * height,
        );
        if self.levels > 0 {
            source.push_str(&format!(
                "[air.refinement]\naround = \"structure\"\nlevels = {}\n",
                self.levels
            ));
        }
        if let Until::Averaged(_) = self.until {
            source.push_str(&kick(shape, end));
        }
        let choices = Choices::default();
        let mut case = case::parse(shape, &source, Path::new("."), &choices)?;
        if let Some(air) = &mut case.scene.air {
            air.operator = self.operator;
        }
        Ok(case)
    }

    /// Computes the flow; `go_on` is asked four times per D/U.
    pub fn drag(
        &self,
        placement: AirPlacement,
        device: Option<&Arc<Device>>,
        go_on: &mut dyn FnMut(&Simulation) -> bool,
    ) -> Result<Drag, Stop> {
        let case = self.case()?;
        let plan = Plan::new(
            &case.scene,
            Placement {
                air: placement,
                ..Placement::from(Precision::F32)
            },
        );
        let sample_every = steps_per(&case.scene, SAMPLE_INTERVAL);
        let (start_steps, planned) = (plan.start_steps, plan.start_steps + plan.steps);
        let mut simulation = Simulation::new(case.scene, plan, device.cloned())?;
        let mut record = Record::new(&simulation);
        let mut settled = false;
        let began = Instant::now();
        let end = loop {
            let step = simulation.step_count();
            if step.is_multiple_of(sample_every) && !go_on(&simulation) {
                return Err(Stop::Interrupted);
            }
            if step >= start_steps && (step - start_steps).is_multiple_of(sample_every) {
                record.add(&mut simulation)?;
                if let Until::Settled(_) = self.until {
                    settled = has_settled(&record, WINDOW);
                }
            }
            if settled || step >= planned {
                break Ok(());
            }
            match simulation.advance_among_threads() {
                Err(Failure::Diverged(diverged)) => break Err(diverged),
                advanced => advanced?,
            }
        };
        if let Some(device) = device {
            device.wait()?;
        }
        let mut drag = Drag {
            coefficient: f64::NAN,
            momentum_box: f64::NAN,
            settled,
            time: simulation.time_s(),
            steps: simulation.step_count(),
            seconds: began.elapsed().as_secs_f64(),
        };
        if end.is_ok() {
            let samples = record.sample_count();
            let window = match self.until {
                Until::Settled(_) => WINDOW.min(samples.saturating_sub(1)),
                Until::Averaged(_) => samples / 2,
            };
            [drag.coefficient, drag.momentum_box] = [&IMPULSE_MARKERS, &IMPULSE_MOMENTUM_BOX]
                .map(|route| mean_force(&record, route, 0, window) / (0.5 * FRONTAL_AREA));
        }
        Ok(drag)
    }
}

/// A motion that brings a body to its place along +z: `[bodies.NAME.motion.table]`.
fn kick(name: &str, end: f64) -> String {
    let [way, duration] = KICK;
    // As long at rest: else the spline swings on.
    let mut times: Vec<f64> = (0..=40).map(|i| duration * f64::from(i) / 20.0).collect();
    let mut ways: Vec<[f64; 3]> = times
        .iter()
        .map(|t| (std::f64::consts::PI * t / duration).min(std::f64::consts::PI))
        .map(|phase| [0.0, 0.0, -0.5 * way * (1.0 + phase.cos())])
        .collect();
    let last = 2.0 * duration;
    for i in 1..=8 {
        times.push(last + (end - last) * f64::from(i) / 8.0);
        ways.push([0.0; 3]);
    }
    format!("[bodies.{name}.motion.table]\ntimes_s = {times:?}\ndisplacements_m = {ways:?}\n")
}

/// Mean force over `samples` intervals that end `back` samples before the last [ρ U² D²]; NaN where the record is too short.
fn mean_force(record: &Record, route: &ReadOut, back: usize, samples: usize) -> f64 {
    let (times, impulses) = (record.column(&TIME), record.column(route));
    let Some(last) = times.len().checked_sub(back + 1) else {
        return f64::NAN;
    };
    match last.checked_sub(samples) {
        Some(first) => (impulses[last] - impulses[first]) / (times[last] - times[first]),
        None => f64::NAN,
    }
}

/// True once the mean drag of two windows of so many samples, one after the other, differ by little.
fn has_settled(record: &Record, window: usize) -> bool {
    let route = &IMPULSE_MARKERS;
    let [before, now] = [window, 0].map(|back| mean_force(record, route, back, window));
    let time = record.latest(&TIME).unwrap_or(0.0);
    time >= SHORTEST && (now - before).abs() <= SETTLED * now.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPHERE: BluffBody = BluffBody {
        shape: Shape::Sphere,
        reynolds: 50.0,
        resolution: 5,
        lattice_speed: 0.15,
        operator: Operator::TwoRelaxationTimes,
        scheme: Scheme::Kernel,
        levels: 0,
        tunnel: [5.0, 4.0, 4.0],
        upstream: 2.0,
        sponge: 1.0,
        until: Until::Settled(20.0),
    };

    fn drag(body: &BluffBody) -> Result<Drag, Stop> {
        body.drag(AirPlacement::Cpu(Precision::F64), None, &mut |_| true)
    }

    /// A coarse sphere at Re 50 (1.54 in an unbounded stream) settles before its time is over, and both routes agree.
    #[test]
    fn a_drag_settles() {
        let drag = drag(&SPHERE).unwrap();
        assert!(drag.settled && drag.time < 15.0, "{drag:?}");
        assert!((1.3..2.3).contains(&drag.coefficient), "{drag:?}");
        assert!(
            (drag.momentum_box / drag.coefficient - 1.0).abs() < 1e-6,
            "{drag:?}"
        );
        let early = super::tests::drag(&BluffBody {
            until: Until::Settled(3.0),
            ..SPHERE
        })
        .unwrap();
        assert!(!early.settled && early.time < 3.1, "{early:?}");
        assert!(early.coefficient > drag.coefficient, "{early:?}");
    }

    /// A kick brings the body to its place, slowly, and leaves it there.
    #[test]
    fn a_kick_ends_in_place() {
        let case = BluffBody {
            until: Until::Averaged(30.0),
            ..SPHERE
        }
        .case()
        .unwrap();
        let motion = &case.scene.rigid_bodies[0].motion;
        let at = |time: f64| motion.at(time).position_m(motion.centre_m) - motion.centre_m;
        assert!((at(0.0).z + KICK[0]).abs() < 1e-9, "{}", at(0.0));
        assert!((at(2.0).z + 0.5 * KICK[0]).abs() < 1e-3, "{}", at(2.0));
        for time in [4.0, 5.0, 12.0, 29.0] {
            assert!(at(time).length() < 2e-3 * KICK[0], "{time}: {}", at(time));
        }
    }

    #[test]
    fn what_cannot_be_computed_says_so() {
        let narrow = BluffBody {
            tunnel: [5.0, 1.0, 1.0],
            ..SPHERE
        };
        assert!(matches!(drag(&narrow), Err(Stop::Refused(_))));
        let stopped = SPHERE.drag(AirPlacement::Cpu(Precision::F32), None, &mut |_| false);
        assert!(matches!(stopped, Err(Stop::Interrupted)));
    }
}
