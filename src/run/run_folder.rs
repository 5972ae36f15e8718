//! Where a run's files go, and what they say of where they are from.

use std::path::{Path, PathBuf};

use crate::case::Case;
use crate::ledger::Program;
use crate::output::{Provenance, Stamp};

/// A run's folder, and what frames and pictures in it carry of the run.
pub(super) struct RunFolder<'a> {
    path: &'a Path,
    provenance: Provenance,
}

impl<'a> RunFolder<'a> {
    /// Frames of a run that is resumed, or made longer, carry the same as those before: only what acts on the state.
    pub(super) fn new(path: &'a Path, case: &Case) -> Self {
        let file = Path::new(&case.name).file_name().unwrap_or_default();
        let mut source = file.to_string_lossy().into_owned();
        if let Some(variant) = &case.variant {
            source += &format!(", variant {variant}");
        }
        for change in case.physical_overrides() {
            source += &format!(", --set {change}");
        }
        let provenance = Provenance {
            program: format!("ripstop {}", Program::this()),
            source,
            case: case.physics_text.clone(),
        };
        Self { path, provenance }
    }

    /// Path of a file.
    pub(super) fn join(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path.join(name)
    }

    pub(super) const fn path(&self) -> &'a Path {
        self.path
    }

    /// What a frame says of itself.
    pub(super) const fn stamp(&self, time_s: f64) -> Stamp<'_> {
        Stamp {
            time_s,
            provenance: &self.provenance,
        }
    }

    /// What its files are from.
    pub(super) const fn provenance(&self) -> &Provenance {
        &self.provenance
    }
}
