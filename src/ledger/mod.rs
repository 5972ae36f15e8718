//! `run.json`, the ledger of a run's folder: what was asked for, who computes it, how it stands, and every file that was written.
//!
//! It is written whole at the start, before every checkpoint and at the end. A file `run.lock` beside it is locked while the run goes on
//! ([`Lock`]): who finds the folder locked is refused; who finds it free but `running` in the ledger knows that the run was killed.

mod lock;
mod origin;
mod stock;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use lock::{FILE_NAME as LOCK_NAME, Holder, Lock, LockError};
pub use origin::{Machine, Program, now};
pub use stock::{FileEntry, take_stock};

use crate::output::{OutputError, write_atomically};

/// Name of the ledger in a run's folder.
pub const FILE_NAME: &str = "run.json";

/// Version of its layout.
const SCHEMA_VERSION: u32 = 1;

/// How a run stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It goes on, or was killed: the lock tells.
    Running,
    /// Ended early on request, with a checkpoint.
    Interrupted,
    /// Ended, with all its results.
    Finished,
    /// The physics broke down.
    Diverged,
    /// The device or a file failed.
    Failed,
}

impl State {
    /// Its word in messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Running => "running or killed",
            Self::Interrupted => "interrupted",
            Self::Finished => "finished",
            Self::Diverged => "diverged",
            Self::Failed => "failed",
        }
    }
}

/// The case of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaseEntry {
    /// Its title.
    pub title: String,
    /// Case file as given.
    pub file: String,
    /// Variant taken, if any.
    pub variant: Option<String>,
    /// `key.path=value` of the command line.
    pub overrides: Vec<String>,
    /// CRC-32 of `text` and of the files that it names, in hexadecimal.
    pub hash: String,
    /// The same without title, length, outputs and comparisons: what a checkpoint must agree with.
    pub physics: String,
    /// The case as it was run, with variant and overrides applied.
    pub text: String,
    /// What the run took for keys that the text leaves out, and what follows from others for time step, cells and box.
    #[serde(default)]
    pub resolved: BTreeMap<String, serde_json::Value>,
}

/// One process that worked on the run: its first start, or a resumption.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Session {
    /// When it began, UTC.
    pub began: String,
    /// When it ended, UTC; absent while it goes on and if it was killed.
    pub ended: Option<String>,
    /// Step that it began at.
    pub from_step: u64,
    /// Process number on its host.
    pub pid: u32,
    /// Who computes what.
    pub computed_by: String,
    /// The program.
    pub program: Program,
    /// The machine.
    pub machine: Machine,
}

/// How far a run has come.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reached {
    /// Steps done, those before release included.
    pub step: u64,
    /// Time since release [s].
    pub time_s: f64,
}

/// The contents of `run.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// 1.
    pub schema_version: u32,
    /// How the run stands.
    pub state: State,
    /// Why it ended; absent while it goes on.
    pub reason: Option<String>,
    /// Its case.
    pub case: CaseEntry,
    /// Precision of the air.
    pub precision: String,
    /// Time between samples [s].
    pub sample_interval_s: f64,
    /// Folder of another run whose state it began from; absent for one that began anew.
    #[serde(default)]
    pub begun_from: Option<String>,
    /// Where an extension after the end leads to [s]; absent without one.
    #[serde(default)]
    pub extended_to_s: Option<f64>,
    /// How far it had come when this was written.
    pub reached: Reached,
    /// Processes that worked on it, in order.
    pub sessions: Vec<Session>,
    /// Files that it wrote, by name; checkpoints carry checksums of their own and are not among them.
    pub files: Vec<FileEntry>,
}

impl Ledger {
    /// The ledger of a run that begins.
    #[must_use]
    pub fn new(case: CaseEntry, precision: &str, sample_interval_s: f64) -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            state: State::Running,
            reason: None,
            case,
            precision: precision.to_owned(),
            sample_interval_s,
            begun_from: None,
            extended_to_s: None,
            reached: Reached {
                step: 0,
                time_s: 0.0,
            },
            sessions: Vec::new(),
            files: Vec::new(),
        }
    }

    /// The ledger in `folder`; `None` if there is none.
    ///
    /// # Errors
    ///
    /// What is wrong with one that cannot be read.
    pub fn read(folder: &Path) -> Result<Option<Self>, String> {
        let text = match std::fs::read(folder.join(FILE_NAME)) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(format!("{FILE_NAME} cannot be read: {error}")),
        };
        let ledger: Self = serde_json::from_slice(&text)
            .map_err(|error| format!("{FILE_NAME} cannot be read: {error}"))?;
        if ledger.schema_version > SCHEMA_VERSION {
            return Err(format!(
                "a newer version of the program wrote its {FILE_NAME}"
            ));
        }
        Ok(Some(ledger))
    }

    /// Writes it into `folder`.
    ///
    /// # Errors
    ///
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        write_atomically(&folder.join(FILE_NAME), |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        })
    }

    /// The process that works, or worked last, on the run.
    #[must_use]
    pub fn session(&self) -> Option<&Session> {
        self.sessions.last()
    }

    /// Adds the present process.
    pub fn begin_session(&mut self, from_step: u64, computed_by: &str) {
        self.state = State::Running;
        self.reason = None;
        self.sessions.push(Session {
            began: now(),
            ended: None,
            from_step,
            pid: std::process::id(),
            computed_by: computed_by.to_owned(),
            program: Program::this(),
            machine: Machine::this(),
        });
    }

    /// Notes how the present process ended.
    pub fn end_session(&mut self, state: State, reason: &str) {
        self.state = state;
        self.reason = Some(reason.to_owned());
        if let Some(session) = self.sessions.last_mut() {
            session.ended = Some(now());
        }
    }
}
