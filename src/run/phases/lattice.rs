//! The lattice of a run: which grid of a sequence, and which time step of a fall; and who decides when its flow has settled.

use std::sync::Arc;

use crate::case::scene::BodyKind;
use crate::case::{Case, Scene};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::gpu::Device;
use crate::measure::steady::{self, Detector};
use crate::measure::{self, Record};
use crate::plan::Plan;
use crate::simulation::{Failure, Simulation};

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
pub(in crate::run) struct Lattice {
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
    pub(in crate::run) fn first(case: &Case) -> Self {
        Self {
            coarser: case.coarser.len() as u64,
            ..Self::default()
        }
    }

    /// How often the time step followed the speed of a fall, and from where to where; `None` if it never did.
    pub(in crate::run) fn note(self, case: &Case) -> Option<String> {
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

    /// Grids left until the case's own.
    pub(in crate::run) const fn coarser(self) -> usize {
        self.coarser as usize
    }

    /// The next finer grid of the sequence.
    pub(super) const fn finer(self) -> Self {
        Self {
            coarser: self.coarser.saturating_sub(1),
            ..self
        }
    }

    /// True on the case's own grid.
    pub(in crate::run) const fn is_finest(self) -> bool {
        self.coarser == 0
    }

    /// The scene on it.
    pub(in crate::run) fn scene(self, case: &Case) -> Scene {
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
    pub(in crate::run) fn start(
        self,
        case: &Case,
        plan: Plan,
        device: Option<Arc<Device>>,
    ) -> Result<Simulation, Failure> {
        if self.coarser == 0 && self.exponent == 0 {
            return Simulation::as_drawn(case.scene.clone(), plan, device);
        }
        let scene = self.scene(case);
        let plan = Plan::new(&scene, plan.placement);
        Simulation::as_drawn(scene, plan, device)
    }

    pub(in crate::run) fn save(self, out: &mut Writer) -> std::io::Result<()> {
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

    pub(in crate::run) fn restore(case: &Case, from: &Reader) -> Result<Self, CheckpointError> {
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

    /// True after a sample on a coarser grid whose flow has settled.
    pub(super) fn coarse_grid_is_done(self, simulation: &Simulation, record: &Record) -> bool {
        let scene = simulation.scene();
        let (Some(air), Some(BodyKind::Canopy(canopy)), true) = (
            &scene.air,
            scene.body.as_ref().map(|b| &b.kind),
            simulation.spans_are_over(),
        ) else {
            return false;
        };
        let unit_s = canopy.nominal_diameter_m / air.wind_or_reference_m_s();
        !self.is_finest() && steady::coarse_grid_is_done(record, unit_s)
    }

    /// The lattice with a longer or shorter time step to go on on after a sample in a fall; `None` to stay.
    pub(super) fn next_step(self, simulation: &Simulation) -> Result<Option<Self>, Failure> {
        let scene = simulation.scene();
        let (Some(air), Some(_), true) = (&scene.air, &scene.descent, simulation.spans_are_over())
        else {
            return Ok(None);
        };
        if !self.is_finest() {
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
        Ok((exponent.abs() <= EXPONENT_LIMIT).then_some(next))
    }
}

/// Who decides when the run may stop: a canopy, else all rigid bodies; `None` where the case does not ask.
pub(in crate::run) fn detector(scene: &Scene) -> Option<Detector> {
    let confidence = scene.steady_drag_confidence?;
    if let Some(BodyKind::Canopy(canopy)) = scene.body.as_ref().map(|body| &body.kind) {
        let unit_s = canopy.nominal_diameter_m / scene.air.as_ref()?.wind_or_reference_m_s();
        return Some(Detector::new(unit_s, confidence));
    }
    let watched = measure::watched(scene).ok().filter(|all| !all.is_empty())?;
    Some(Detector::of_bodies(watched, confidence))
}
