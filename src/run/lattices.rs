//! Which lattice a run is on: the grids of a sequence, coarse to fine, and time steps that follow the speed of a fall; and who stops it.

use std::sync::Arc;

use super::{Run, RunError};
use crate::case::scene::BodyKind;
use crate::case::{Case, Scene};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::gpu::Device;
use crate::measure::{Record, bodies};
use crate::plan::{Placement, Plan};
use crate::simulation::{Failure, Simulation};
use crate::steady::{self, Detector};

/// In a descent the time step grows by [`STEP_RATIO`] once the air comes at less than this share of `lattice_speed`, and shrinks above the other.
const LATTICE_SPEED_SHARES: [f64; 2] = [0.8, 1.2];

/// From one time step to the next. Residual slip is proportional to the force and to the time step, so that after a change the air has to
/// accelerate through the fabric first: doubling takes a third off the drag for 40 steps, a quarter of an octave some 6 %.
const STEP_RATIO: f64 = 1.189_207_115_002_721;

/// Fastest cell or marker that longer steps may lead to [cells per step]: Mach 0.35; markers are meant to move less than 0.25.
const FASTEST_AFTER_CHANGE: f64 = 0.2;

/// Longest relaxation time of the air itself that longer steps may lead to.
const LONGEST_RELAXATION_TIME: f64 = 0.8;

/// Most changes between the case's time step and another: a factor of 4096.
const EXPONENT_LIMIT: i64 = 48;

/// The lattice of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Lattice {
    /// Grids left until the case's own.
    coarser: u64,
    /// Time step over the scene's, as a power of [`STEP_RATIO`].
    exponent: i64,
    /// Changes of the time step so far.
    changes: u64,
    /// Least and largest exponent so far.
    exponents: [i64; 2],
}

impl Lattice {
    /// The first of a run.
    pub(super) fn first(case: &Case) -> Self {
        Self {
            coarser: case.coarser.len() as u64,
            ..Self::default()
        }
    }

    /// How often the time step followed the speed of a fall, and from where to where; `None` if it never did.
    pub(super) fn note(self, case: &Case) -> Option<String> {
        let step_s = case.scene.time.filter(|_| self.changes > 0)?.step_s;
        let [shortest, longest, last] = [self.exponents[0], self.exponents[1], self.exponent]
            .map(|exponent| step_s * STEP_RATIO.powi(exponent as i32));
        Some(format!(
            "the time step followed the speed of the fall: {} change{}, from {step_s:.3e} s at release to {last:.3e} s at the end, between \
             {shortest:.3e} and {longest:.3e} s",
            self.changes,
            if self.changes == 1 { "" } else { "s" }
        ))
    }

    /// True on the case's own grid.
    pub(super) const fn is_finest(self) -> bool {
        self.coarser == 0
    }

    /// The scene on it.
    pub(super) fn scene(self, case: &Case) -> Scene {
        let number = case.coarser.len().checked_sub(self.coarser as usize);
        let mut scene = number
            .and_then(|number| case.coarser.get(number))
            .unwrap_or(&case.scene)
            .clone();
        if self.exponent != 0 {
            let factor = STEP_RATIO.powi(self.exponent as i32);
            if let (Some(air), Some(time)) = (&mut scene.air, &mut scene.time) {
                air.units = air.units.with_step_factor(factor);
                air.lattice_speed *= factor;
                time.step_s = air.units.time_step_s;
            }
        }
        scene
    }

    /// The simulation of a run that starts or is resumed on it.
    pub(super) fn start(
        self,
        case: &Case,
        plan: Plan,
        device: Option<Arc<Device>>,
    ) -> Result<Simulation, Failure> {
        if self.coarser == 0 && self.exponent == 0 {
            return Simulation::new(case.scene.clone(), plan, device);
        }
        let scene = self.scene(case);
        let plan = Plan::new(&scene, plan.placement);
        Simulation::new(scene, plan, device)
    }

    pub(super) fn save(self, out: &mut Writer) -> std::io::Result<()> {
        let [least, most] = self.exponents;
        out.put(
            "lattice",
            &[
                self.coarser as i64,
                self.exponent,
                self.changes as i64,
                least,
                most,
            ],
        )
    }

    pub(super) fn restore(case: &Case, from: &Reader) -> Result<Self, CheckpointError> {
        let numbers: Vec<i64> = from.take_exactly("lattice", 5)?;
        let known = usize::try_from(numbers[0]).is_ok_and(|grid| grid <= case.coarser.len());
        let exponents = [numbers[3], numbers[4]];
        let in_order = exponents[0] <= numbers[1] && numbers[1] <= exponents[1];
        let reach = exponents.iter().any(|e| e.abs() > EXPONENT_LIMIT);
        if !known || !in_order || reach || numbers[2] < 0 {
            return Err(from.damaged("it names a lattice that the case does not have".to_owned()));
        }
        Ok(Self {
            coarser: numbers[0] as u64,
            exponent: numbers[1],
            changes: numbers[2] as u64,
            exponents,
        })
    }

    /// The lattice to go on on after a sample, and why if its cells are others; `None` to stay.
    fn next(
        self,
        simulation: &Simulation,
        record: &Record,
    ) -> Result<Option<(Self, Option<&'static str>)>, Failure> {
        let scene = simulation.scene();
        let (Some(air), true) = (&scene.air, simulation.spans_are_over()) else {
            return Ok(None);
        };
        if let (Some(BodyKind::Canopy(canopy)), false) =
            (scene.body.as_ref().map(|b| b.kind), self.is_finest())
        {
            let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
            let done = steady::coarse_grid_is_done(record, unit_s);
            return Ok(done.then(|| {
                let finer = Self {
                    coarser: self.coarser - 1,
                    ..self
                };
                (finer, Some("the flow has settled on the coarser grid"))
            }));
        }
        if scene.descent.is_none() {
            return Ok(None);
        }
        let speed_m_s = simulation.wind_speed_m_s();
        // `lattice_speed` grows with the time step: what the case asked for is that of the first.
        let asked = air.lattice_speed / STEP_RATIO.powi(self.exponent as i32);
        let share = speed_m_s / air.units.speed_m_s() / asked;
        let [low, high] = LATTICE_SPEED_SHARES;
        let change = if share > high {
            -1
        } else if share < low
            && air.units.relaxation_time(air.kinematic_viscosity_m2_s) < LONGEST_RELAXATION_TIME
            && STEP_RATIO * simulation.fastest_in_lattice()? < FASTEST_AFTER_CHANGE
        {
            1
        } else {
            return Ok(None);
        };
        let exponent = self.exponent + change;
        let [least, most] = self.exponents;
        let next = Self {
            exponent,
            changes: self.changes + 1,
            exponents: [least.min(exponent), most.max(exponent)],
            ..self
        };
        Ok((exponent.abs() <= EXPONENT_LIMIT).then_some((next, None)))
    }
}

/// Who decides when the run may stop: a canopy, else all rigid bodies; `None` where the case does not ask.
pub(super) fn detector(scene: &Scene) -> Option<Detector> {
    let confidence = scene.steady_drag_confidence?;
    if let Some(BodyKind::Canopy(canopy)) = scene.body.as_ref().map(|body| body.kind) {
        let unit_s = canopy.nominal_diameter_m / scene.air?.wind_or_reference_m_s();
        return Some(Detector::new(unit_s, confidence));
    }
    let watched = bodies::watched(scene).ok().filter(|all| !all.is_empty())?;
    Some(Detector::of_bodies(watched, confidence))
}

impl Run<'_> {
    /// After a sample: goes on on another lattice if it is time to; returns what is to be said of it, which of a mere change of the time step is
    /// nothing: [`Lattice::note`] sums those up.
    pub(super) fn follow_lattice(&mut self) -> Result<Option<Option<String>>, RunError> {
        let Some((next, why)) = self.lattice.next(&self.simulation, &self.record)? else {
            return Ok(None);
        };
        let scene = next.scene(self.case);
        let placement: Placement = self.simulation.plan().placement.clone();
        let plan = Plan::new(&scene, placement);
        let (cells, units) = (scene.air.map(|a| a.cells), scene.air.map(|a| a.units));
        self.simulation.change_lattice(scene, plan)?;
        self.lattice = next;
        let Some(why) = why else {
            return Ok(Some(None));
        };
        self.record.grid_changes(self.simulation.time_s());
        let text = match (cells, units) {
            (Some([nx, ny, nz]), Some(units)) => format!(
                "t = {:.4} s: {why}; {nx} x {ny} x {nz} cells, steps of {:.3e} s from here",
                self.simulation.time_s(),
                units.time_step_s
            ),
            _ => why.to_owned(),
        };
        self.notes.push(text.clone());
        Ok(Some(Some(text)))
    }
}
