//! Phases `raise_wind` and `march`: steps of air and structure, with what is sampled and written between them.

use std::time::Instant;

use super::stand::Next;
use crate::case::scene::Flow;
use crate::measure::shared::{DRAG_COEFFICIENT, PROJECTED_DIAMETER_RATIO, TIME};
use crate::run::cadence::{Cadence, PROGRESS_PARTS, parts_done};
use crate::run::{Observer, Run, RunError};

/// Steps between reports of progress.
const PROGRESS_INTERVAL: u64 = 20;

/// When a march began, and what it is part of.
struct Clock {
    began: Instant,
    first_step: u64,
    /// Beginning and end of the run [s].
    span_s: [f64; 2],
}

impl Run<'_> {
    /// Steps to the release; nothing is written of them.
    pub(super) fn raise_wind(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        let clock = self.clock();
        while !self.simulation.released() {
            if self.pause(observer)? {
                return Ok(Next::Interrupted);
            }
            self.step(&clock, u64::MAX, observer)?;
        }
        Ok(Next::Phase)
    }

    /// Steps on one grid: to the end, until the means are steady, or on a coarser grid until its flow has settled.
    pub(super) fn march(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        let mut cadence = Cadence::new(&self.simulation);
        let mut picture_times = self.case.scene.output.picture_times_s.clone();
        picture_times.sort_by(f64::total_cmp);
        let clock = self.clock();
        // A run that stopped as it was steady had written all of that step, its last sample too.
        let written_at = (self.record.latest(&TIME) == Some(self.simulation.time_s()))
            .then_some(clock.first_step);
        while self.simulation.step_count() < cadence.planned {
            // Before anything of this step is written, so that a resumed run writes it once. Where a device is ahead nothing is due, and a checkpoint waits for the next step.
            if !self.simulation.is_ahead() && self.pause(observer)? {
                return Ok(Next::Interrupted);
            }
            // What a change of the lattice follows has been written on the one before.
            if !cadence.just_changed(&self.simulation)
                && written_at != Some(self.simulation.step_count())
            {
                let since = self.simulation.step_count() - cadence.origin;
                self.write_frames(&cadence, since, observer)?;
                let sampled = since.is_multiple_of(cadence.sample);
                self.whole = !sampled;
                if sampled {
                    self.sample(observer)?;
                    // A sample counts as good once the air has been searched at or after it.
                    if self.simulation.sound_step() >= self.sampled.step {
                        self.good =
                            std::mem::replace(&mut self.sampled, self.simulation.structure_frame());
                    }
                }
                self.draw_pictures(&cadence, since, &picture_times, observer)?;
                if sampled && self.coarse_grid_is_done() {
                    return Ok(Next::Phase);
                }
                if sampled && self.follow_speed()? {
                    observer.lattice_changed();
                    cadence = Cadence::new(&self.simulation);
                    continue;
                }
                if sampled
                    && self.lattice.is_finest()
                    && let Some(reason) = self
                        .detector
                        .as_mut()
                        .and_then(|d| d.reason_to_stop(&self.record))
                {
                    observer.note(&reason);
                    self.save_final(observer)?;
                    return Ok(Next::End(reason));
                }
            }
            let next_reading = match self.is_to_pause() {
                true => 0,
                false => {
                    let picture_s = picture_times.get(self.files.timed_pictures).copied();
                    let now = (self.simulation.step_count(), self.simulation.time_s());
                    cadence.next_reading(now, picture_s)
                }
            };
            self.simulation.set_next_reading(next_reading);
            self.step(&clock, cadence.planned, observer)?;
        }
        self.whole = false;
        self.save_final(observer)?;
        if !self.lattice.is_finest() {
            self.notes.push(
                "warning: the run ended on a coarser grid than the case's own: results are those of that grid; raise time.end_s".to_owned(),
            );
        }
        let since = self.simulation.step_count() - cadence.origin;
        // A run that goes on from its end has this row already.
        if (since.is_multiple_of(cadence.sample) || self.record.sample_count() < 2)
            && self.record.latest(&TIME) != Some(self.simulation.time_s())
        {
            self.sample(observer)?;
        }
        Ok(Next::AfterTime)
    }

    fn clock(&self) -> Clock {
        let scene = &self.case.scene;
        let start_s = scene.air.as_ref().map_or(0.0, |air| match air.flow {
            Flow::WindTunnel { start_time_s, .. } => -start_time_s,
            Flow::TaylorGreen { .. } => 0.0,
        });
        Clock {
            began: Instant::now(),
            first_step: self.simulation.step_count(),
            span_s: [start_s, scene.time.map_or(0.0, |time| time.end_s)],
        }
    }

    /// One step of all the air, told now and then and at the last of those `planned`.
    fn step(
        &mut self,
        clock: &Clock,
        planned: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        self.fail_on_purpose();
        self.whole = false;
        self.fail_on_purpose();
        let before = self.simulation.step_count();
        self.simulation.advance_among_threads()?;
        // Boxes of finer cells are ahead until the air around them has made its step.
        while !self.simulation.stands_together() {
            self.simulation.advance_among_threads()?;
        }
        self.whole = true;
        let done = self.simulation.step_count();
        if done / PROGRESS_INTERVAL > before / PROGRESS_INTERVAL || done == planned {
            let rate = (done - clock.first_step) as f64 / clock.began.elapsed().as_secs_f64();
            let parts = parts_done(self.simulation.time_s(), clock.span_s);
            observer.progress(parts, PROGRESS_PARTS, &self.status(rate));
        }
        Ok(())
    }

    fn status(&self, rate: f64) -> String {
        let mut text = format!("t = {:.4} s, {rate:.0} steps/s", self.simulation.time_s());
        for (column, label) in [
            (&PROJECTED_DIAMETER_RATIO, "D_p/D_0"),
            (&DRAG_COEFFICIENT, "C_D"),
        ] {
            if let Some(value) = self.record.latest(column).filter(|v| v.is_finite()) {
                text.push_str(&format!(", {label} {value:.3}"));
            }
        }
        text
    }
}
