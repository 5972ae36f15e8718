//! When what is written in a run, and how far it has come.

use crate::plan::steps_per;
use crate::simulation::Simulation;

/// Parts of the simulated time that progress is told in: steps may change their length, and with it their number.
pub(super) const PROGRESS_PARTS: u64 = 10_000;

/// Parts of [`PROGRESS_PARTS`] that are done at `time_s` of what began at `start_s`.
pub(super) fn parts_done(time_s: f64, [start_s, end_s]: [f64; 2]) -> u64 {
    let share = (time_s - start_s) / (end_s - start_s);
    // Not a number, of a run without length, becomes nothing.
    (share.clamp(0.0, 1.0) * PROGRESS_PARTS as f64) as u64
}

/// When what is written, in steps of the present lattice.
pub(super) struct Cadence {
    pub(super) step_s: f64,
    /// Step that cadences count from.
    pub(super) origin: u64,
    /// Step after which the run ends.
    pub(super) planned: u64,
    pub(super) start_steps: u64,
    pub(super) sample: u64,
    pub(super) canopy: Option<u64>,
    pub(super) flow: Option<u64>,
    pub(super) bodies: Option<u64>,
    pub(super) animation: Option<u64>,
}

impl Cadence {
    pub(super) fn new(simulation: &Simulation) -> Self {
        let (scene, plan) = (simulation.scene(), simulation.plan());
        let every = |interval_s| steps_per(scene, interval_s);
        Self {
            step_s: scene.time.map_or(f64::INFINITY, |t| t.step_s),
            origin: simulation.origin().step,
            planned: plan.start_steps.saturating_add(plan.steps),
            start_steps: plan.start_steps,
            sample: every(scene.output.sample_interval_s),
            canopy: scene.output.canopy_interval_s.map(every),
            flow: scene.output.flow_interval_s.map(every),
            bodies: scene.output.bodies_interval_s.map(every),
            animation: scene.output.animation_interval_s.map(every),
        }
    }

    /// Step after the present one, at `time_s`, at which the state is read next: for a row, a file, a picture, or at the end. The next picture is drawn at `picture_s`.
    pub(super) fn next_reading(&self, (step, time_s): (u64, f64), picture_s: Option<f64>) -> u64 {
        let since = step - self.origin;
        let others = [self.canopy, self.flow, self.bodies, self.animation];
        let every = (others.into_iter().flatten()).chain([self.sample]);
        let rows_and_files = every.map(|every| self.origin + (since / every + 1) * every);
        // At the earliest: a step before it may be taken for it.
        let picture = picture_s.map(|picture_s| {
            let left = ((picture_s - time_s) / self.step_s - 0.5).floor();
            step + left.max(1.0) as u64
        });
        let soonest = rows_and_files.chain(picture).min();
        soonest.map_or(self.planned, |soonest| soonest.min(self.planned))
    }

    /// True at the very change of the lattice, other than at release.
    pub(super) fn just_changed(&self, simulation: &Simulation) -> bool {
        self.origin > self.start_steps && simulation.step_count() == self.origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every step after which something is read is told before: rows, files, pictures and the end, also where steps are counted from a change of the lattice.
    #[test]
    fn the_next_reading_is_never_late() {
        let cadence = Cadence {
            step_s: 0.01,
            origin: 7,
            planned: 100,
            start_steps: 7,
            sample: 12,
            canopy: Some(9),
            flow: None,
            bodies: Some(50),
            animation: None,
        };
        let time_s = |step: u64| (step - 7) as f64 * cadence.step_s;
        // As `draw_pictures` has it: the first step within half a step of its time, or after.
        let picture_s = 0.333;
        let drawn = (7..).find(|step| time_s(*step) + 0.5 * cadence.step_s >= picture_s);
        let is_read = |step: u64| {
            let since = step - 7;
            let files = since.is_multiple_of(12) || since.is_multiple_of(9) || since == 50;
            files || Some(step) == drawn || step == 100
        };
        for step in 7..100 {
            let picture = (Some(step) < drawn).then_some(picture_s);
            let told = cadence.next_reading((step, time_s(step)), picture);
            let next = (step + 1..=100).find(|step| is_read(*step)).unwrap();
            assert!(step < told && told <= next, "{step}: {told}, {next}");
            assert!(told + 1 >= next, "{step}: {told} is early for {next}");
        }
    }

    /// Steps that grow and shrink: what is done never becomes less, and ends where the run ends.
    #[test]
    fn progress_goes_with_simulated_time() {
        let span_s = [-1.0, 3.0];
        let (mut time_s, mut last) = (span_s[0], 0);
        assert_eq!(parts_done(time_s, span_s), 0);
        for step in 0..400 {
            time_s += if step % 100 < 50 { 0.004 } else { 0.016 };
            let done = parts_done(time_s, span_s);
            assert!(
                done >= last && done <= PROGRESS_PARTS,
                "{done} after {last}"
            );
            last = done;
        }
        assert_eq!(last, PROGRESS_PARTS);
        assert_eq!(parts_done(1.0, span_s), PROGRESS_PARTS / 2);
        assert_eq!(parts_done(0.0, [0.0, 0.0]), 0);
    }
}
