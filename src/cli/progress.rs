//! Progress of a run: a bar on a terminal, plain lines otherwise.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::run::Observer;

/// Time between plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

pub(super) struct Progress {
    bar: Option<ProgressBar>,
    began: Instant,
    last_line: Instant,
}

impl Progress {
    pub(super) fn new() -> Self {
        let bar = ProgressBar::new(0);
        // Hidden means that standard error is not a terminal.
        let bar = if bar.is_hidden() {
            None
        } else {
            if let Ok(style) =
                ProgressStyle::with_template("{wide_bar} {percent:>3} %  {eta} left  {msg}")
            {
                bar.set_style(style);
            }
            Some(bar)
        };
        Self {
            bar,
            began: Instant::now(),
            last_line: Instant::now(),
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn progress(&mut self, done: u64, planned: u64, status: &str) {
        if let Some(bar) = &self.bar {
            bar.set_length(planned);
            bar.set_position(done);
            bar.set_message(status.to_owned());
        } else if self.last_line.elapsed() >= LINE_INTERVAL {
            self.last_line = Instant::now();
            let left = self.began.elapsed().as_secs_f64() * (planned - done) as f64 / done as f64;
            eprintln!(
                "{:3.0} %  {left:.0} s left  {status}",
                100.0 * done as f64 / planned as f64
            );
        }
    }

    fn note(&mut self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None => eprintln!("{line}"),
        }
    }
}
