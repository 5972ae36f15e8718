//! Progress of a run: a bar on a terminal, plain lines otherwise.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::log::say;
use crate::run::Observer;

/// Time between plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// How far a phase has come, which never becomes less, and how long the rest takes at the pace of what was done.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Phase {
    planned: u64,
    done: u64,
    /// What was done when it was first told of: a resumed run did that before.
    first: u64,
    /// When that was [s].
    began_s: f64,
}

impl Phase {
    /// What is known after hearing that `done` of `planned` are done at `now_s`; another plan is another phase.
    fn heard(self, done: u64, planned: u64, now_s: f64) -> Self {
        let done = done.min(planned);
        if planned == self.planned {
            Self {
                done: done.max(self.done),
                ..self
            }
        } else {
            Self {
                planned,
                done,
                first: done,
                began_s: now_s,
            }
        }
    }

    /// In per cent.
    fn percent(self) -> f64 {
        100.0 * self.done as f64 / self.planned.max(1) as f64
    }

    /// Time left at `now_s` [s]; `None` before anything was done in sight.
    fn left_s(self, now_s: f64) -> Option<f64> {
        let gained = (self.done - self.first) as f64;
        (gained > 0.0).then(|| (now_s - self.began_s) * (self.planned - self.done) as f64 / gained)
    }
}

pub(super) struct Progress {
    bar: Option<ProgressBar>,
    began: Instant,
    last_line: Instant,
    phase: Phase,
}

impl Progress {
    pub(super) fn new() -> Self {
        let bar = ProgressBar::new(0);
        // Hidden means that standard error is not a terminal.
        let bar = if bar.is_hidden() {
            None
        } else {
            if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3} %  {msg}") {
                bar.set_style(style);
            }
            Some(bar)
        };
        Self {
            bar,
            began: Instant::now(),
            last_line: Instant::now(),
            phase: Phase::default(),
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn phase_begins(&mut self) {
        self.phase = Phase::default();
    }

    fn progress(&mut self, done: u64, planned: u64, status: &str) {
        let now_s = self.began.elapsed().as_secs_f64();
        self.phase = self.phase.heard(done, planned, now_s);
        let left = self
            .phase
            .left_s(now_s)
            .map_or_else(String::new, |left_s| format!("{left_s:.0} s left  "));
        if let Some(bar) = &self.bar {
            bar.set_length(self.phase.planned);
            bar.set_position(self.phase.done);
            bar.set_message(format!("{left}{status}"));
        } else if self.last_line.elapsed() >= LINE_INTERVAL {
            self.last_line = Instant::now();
            say(&format!("{:3.0} %  {left}{status}", self.phase.percent()));
        }
    }

    fn note(&mut self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None => say(line),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_never_runs_backwards() {
        let mut phase = Phase::default();
        let mut last = 0.0;
        for (done, now_s) in [
            (10, 1.0),
            (30, 3.0),
            (25, 3.5),
            (0, 4.0),
            (60, 6.0),
            (200, 9.0),
        ] {
            phase = phase.heard(done, 100, now_s);
            assert!(phase.percent() >= last, "{phase:?} after {last}");
            last = phase.percent();
        }
        assert_eq!(last, 100.0);
        assert_eq!(phase.left_s(9.0), Some(0.0));
        // The next phase begins anew.
        let next = phase.heard(5, 1000, 10.0);
        assert_eq!((next.percent(), next.left_s(10.0)), (0.5, None));
    }

    /// What a run had done before it was resumed took no time now.
    #[test]
    fn time_left_counts_what_was_done_in_sight() {
        let phase = Phase::default().heard(80, 100, 2.0).heard(90, 100, 12.0);
        assert_eq!(phase.left_s(12.0), Some(10.0));
    }
}
