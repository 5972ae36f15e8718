//! The lock on a run's folder: held by the process, so that the system takes it back however the process ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::origin::{host, now};
use crate::output::OutputError;

/// Name of the locked file.
pub const FILE_NAME: &str = "run.lock";

/// Attempts to lock a file that others remove in between.
const ATTEMPTS: usize = 16;

/// Who holds a lock.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// Process number on its host.
    pub pid: u32,
    /// Name of its host; absent where the system does not tell.
    pub host: Option<String>,
    /// Since when, UTC.
    pub since: String,
    /// Case file as given.
    pub case: String,
}

impl Holder {
    /// This process with a case.
    #[must_use]
    pub fn this(case: &str) -> Self {
        Self {
            pid: std::process::id(),
            host: host(),
            since: now(),
            case: case.to_owned(),
        }
    }
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "process {}", self.pid)?;
        if let Some(host) = &self.host {
            write!(f, " on {host}")?;
        }
        write!(f, " with {}, since {}", self.case, self.since)
    }
}

/// Why a folder could not be locked.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another run holds it.
    #[error(
        "another run works in {}: {by}; wait for its end, or choose another folder with --out",
        folder.display()
    )]
    Held {
        /// The folder.
        folder: PathBuf,
        /// Who.
        by: String,
    },
    /// The file cannot be made.
    #[error("{0}")]
    Output(#[from] OutputError),
}

/// A locked folder; free again when dropped, and when the process ends in whatever way.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: File,
    held: bool,
}

impl Lock {
    /// Locks `folder`, which exists.
    ///
    /// # Errors
    ///
    /// When another process holds it, or the file cannot be written.
    pub fn acquire(folder: &Path, holder: &Holder) -> Result<Self, LockError> {
        let path = folder.join(FILE_NAME);
        let fail = |cause: io::Error| OutputError::new("lock", &path, cause);
        for _ in 0..ATTEMPTS {
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .map_err(fail)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(LockError::Held {
                        folder: folder.to_owned(),
                        by: holder_in(&mut file),
                    });
                }
                // A file system without locks.
                Err(TryLockError::Error(_)) => {
                    return Ok(Self {
                        path,
                        file,
                        held: false,
                    });
                }
            }
            // Who held it may have removed it after it was opened here.
            let own = file.try_clone().and_then(same_file::Handle::from_file);
            let there = same_file::Handle::from_path(&path);
            if !matches!((own, there), (Ok(own), Ok(there)) if own == there) {
                continue;
            }
            file.set_len(0)
                .and_then(|()| Ok(serde_json::to_writer(&file, holder)?))
                .and_then(|()| file.flush())
                .map_err(fail)?;
            return Ok(Self {
                path,
                file,
                held: true,
            });
        }
        Err(fail(io::ErrorKind::ResourceBusy.into()).into())
    }

    /// False on a file system without locks, where two runs would not notice each other.
    #[must_use]
    pub const fn is_held(&self) -> bool {
        self.held
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.held {
            // Before it is unlocked, so that nobody's else is removed. What stays behind does no harm.
            let _ = std::fs::remove_file(&self.path);
            let _ = self.file.unlock();
        }
    }
}

/// What the locked file says of its holder. Where locks are mandatory it cannot be read.
fn holder_in(file: &mut File) -> String {
    let mut text = String::new();
    let holder = file
        .rewind()
        .and_then(|()| file.read_to_string(&mut text))
        .ok()
        .and_then(|_| serde_json::from_str::<Holder>(&text).ok());
    holder.map_or_else(
        || "a process that has just begun".to_owned(),
        |h| h.to_string(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_locked_folder_is_refused_with_who_holds_it_and_free_afterwards() {
        let folder = tempfile::tempdir().unwrap();
        let holder = Holder::this("canopy.toml");
        let lock = Lock::acquire(folder.path(), &holder).unwrap();
        assert!(lock.is_held());
        let refused = Lock::acquire(folder.path(), &Holder::this("sphere.toml")).unwrap_err();
        let text = refused.to_string();
        assert!(
            text.contains(&format!("process {}", std::process::id())),
            "{text}"
        );
        assert!(text.contains("canopy.toml, since 20"), "{text}");
        drop(lock);
        assert!(!folder.path().join(FILE_NAME).exists());
        // What a killed process leaves behind is no obstacle.
        std::fs::write(folder.path().join(FILE_NAME), "{\"pid\": 1, \"hos").unwrap();
        drop(Lock::acquire(folder.path(), &holder).unwrap());
    }
}
