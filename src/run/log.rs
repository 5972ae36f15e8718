//! `run.log`: what a run says, with the time of day, for who was not there. Nothing that happens to it ends a run.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::error::RunError;
use super::fault::LOG_NAME;
use super::order::{Observer, Report, Start};
use crate::ledger::now;

/// What it was called before it had grown too long.
const PREVIOUS_NAME: &str = "run.log.previous";

/// Length after which another file is begun: two of them hold a year of lines of progress.
const LIMIT_BYTES: u64 = 1 << 20;

/// Time between lines of progress.
const PROGRESS_INTERVAL: Duration = Duration::from_secs(60);

/// Watches a run for another observer, and writes down what it hears.
pub(super) struct Log<'a> {
    observer: &'a mut dyn Observer,
    folder: PathBuf,
    limit_bytes: u64,
    /// Absent before the folder is the run's, and where the file cannot be opened.
    file: Option<File>,
    length: u64,
    /// Lines from before the folder was the run's.
    waiting: String,
    last_progress: Instant,
}

impl<'a> Log<'a> {
    /// Writes nothing before [`Log::open`].
    pub(super) fn new(folder: &Path, observer: &'a mut dyn Observer) -> Self {
        Self {
            observer,
            folder: folder.to_owned(),
            limit_bytes: LIMIT_BYTES,
            file: None,
            length: 0,
            waiting: String::new(),
            last_progress: Instant::now(),
        }
    }

    /// Begins the file, or goes on with that of the run that is gone on with.
    pub(super) fn open(&mut self, start: Start<'_>) {
        if !matches!(start, Start::Resume | Start::Extend) {
            for name in [LOG_NAME, PREVIOUS_NAME] {
                // There may be none.
                let _ = fs::remove_file(self.folder.join(name));
            }
        }
        self.begin_file();
        let waiting = std::mem::take(&mut self.waiting);
        self.append(&waiting);
    }

    /// Writes down how the run ended, with all that is known of a fault.
    pub(super) fn end(&mut self, result: &Result<Report, RunError>) {
        match result {
            Ok(report) => self.write(&format!("ended: {}", report.summary.stop.reason)),
            Err(error) => self.write(&format!("error: {error}")),
        }
        if let Err(RunError::Fault(fault)) = result
            && let Some(backtrace) = &fault.backtrace
        {
            self.write(&format!("where the fault was:\n{}", backtrace.trim_end()));
        }
    }

    fn begin_file(&mut self) {
        let path = self.folder.join(LOG_NAME);
        self.file = OpenOptions::new().create(true).append(true).open(path).ok();
        let found = self.file.as_ref().and_then(|file| file.metadata().ok());
        self.length = found.map_or(0, |found| found.len());
    }

    /// Adds a line; further ones of the same text are indented.
    fn write(&mut self, text: &str) {
        let line = format!("{}  {}\n", now(), text.replace('\n', "\n    "));
        if self.file.is_none() {
            self.waiting.push_str(&line);
        } else {
            self.append(&line);
        }
    }

    fn append(&mut self, lines: &str) {
        if self.length > 0 && self.length + lines.len() as u64 > self.limit_bytes {
            let path = self.folder.join(LOG_NAME);
            // Where it cannot be renamed it goes on to grow.
            let _ = fs::rename(path, self.folder.join(PREVIOUS_NAME));
            self.begin_file();
        }
        if let Some(file) = &mut self.file {
            // A line that there is no room for is lost.
            let _ = file.write_all(lines.as_bytes());
            self.length += lines.len() as u64;
        }
    }
}

impl Observer for Log<'_> {
    fn phase_begins(&mut self) {
        self.observer.phase_begins();
    }

    fn progress(&mut self, done: u64, planned: u64, status: &str) {
        if self.last_progress.elapsed() >= PROGRESS_INTERVAL {
            self.last_progress = Instant::now();
            let percent = 100.0 * done as f64 / planned.max(1) as f64;
            self.write(&format!("{percent:.0} %  {status}"));
        }
        self.observer.progress(done, planned, status);
    }

    fn note(&mut self, line: &str) {
        self.write(line);
        self.observer.note(line);
    }

    fn lattice_changed(&mut self) {
        self.observer.lattice_changed();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Nobody;

    impl Observer for Nobody {
        fn progress(&mut self, _: u64, _: u64, _: &str) {}
        fn note(&mut self, _: &str) {}
    }

    fn text(folder: &Path, name: &str) -> String {
        fs::read_to_string(folder.join(name)).unwrap_or_default()
    }

    #[test]
    fn lines_wait_for_the_folder_and_a_resumed_run_adds_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let mut nobody = Nobody;
        let mut say = |start: Start, line: &str| {
            let mut log = Log::new(folder.path(), &mut nobody);
            log.note(line);
            log.open(start);
            log.note("two\nlines");
        };
        say(Start::New, "first");
        say(Start::Resume, "second");
        let lines = text(folder.path(), LOG_NAME);
        let lines: Vec<&str> = lines.lines().collect();
        assert_eq!(lines.len(), 6, "{lines:?}");
        assert!(lines[0].ends_with("Z  first") && lines[3].ends_with("Z  second"));
        assert_eq!(lines[2], "    lines");
        say(Start::New, "third");
        assert_eq!(text(folder.path(), LOG_NAME).lines().count(), 3);
        // A run that never began leaves the one before alone.
        Log::new(folder.path(), &mut nobody).note("refused");
        assert!(!text(folder.path(), LOG_NAME).contains("refused"));
    }

    #[test]
    fn it_does_not_grow_without_end() {
        let folder = tempfile::tempdir().unwrap();
        let mut nobody = Nobody;
        let mut log = Log::new(folder.path(), &mut nobody);
        log.limit_bytes = 1000;
        log.open(Start::New);
        for number in 0..200 {
            log.note(&format!("line {number}"));
        }
        let now = text(folder.path(), LOG_NAME);
        let before = text(folder.path(), PREVIOUS_NAME);
        assert!(now.ends_with("line 199\n"), "{now}");
        assert!(now.len() <= 1000 && before.len() <= 1000 && before.len() > 900);
    }

    #[test]
    fn a_folder_that_goes_away_ends_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut nobody = Nobody;
        let mut log = Log::new(&folder.path().join("missing"), &mut nobody);
        log.open(Start::New);
        log.note("nobody will know");
    }
}
