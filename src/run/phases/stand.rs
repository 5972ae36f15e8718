//! How far a run has come in its phases, and what follows one.

use serde::{Deserialize, Serialize};

use super::lattice::Lattice;
use crate::case::Case;
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::plan::{Phase, phases};

/// Name of the stand in a checkpoint.
const STAND: &str = "stand";

/// How far a run has come in its phases.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::run) struct Stand {
    /// Number of the phase that is under way.
    pub(super) phase: usize,
    /// Why the run ends, by the phases so far.
    pub(super) reason: String,
    /// What was sought was not found.
    pub(in crate::run) unbalanced: bool,
    /// What is to be said of the last equilibrium or trim; it goes when another is sought.
    pub(in crate::run) balance_notes: Vec<String>,
}

impl Default for Stand {
    fn default() -> Self {
        Self {
            phase: 0,
            reason: "end time reached".to_owned(),
            unbalanced: false,
            balance_notes: Vec::new(),
        }
    }
}

impl Stand {
    pub(in crate::run) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        let bytes = postcard::to_stdvec(self).map_err(std::io::Error::other)?;
        out.put(STAND, &bytes)
    }

    /// Takes it from a checkpoint of a run that is on that lattice.
    pub(in crate::run) fn restore(
        case: &Case,
        from: &Reader,
        lattice: Lattice,
    ) -> Result<Self, CheckpointError> {
        let bytes: Vec<u8> = from.take(STAND)?;
        let stand: Self = postcard::from_bytes(&bytes)
            .map_err(|error| from.damaged(format!("its phase cannot be read: {error}")))?;
        let phases = phases(&case.scene, &case.coarser);
        let is_known = match phases.get(stand.phase) {
            Some(Phase::March { coarser }) => *coarser == lattice.coarser(),
            phase => phase.is_some(),
        };
        if !is_known {
            return Err(from.damaged("it names a phase that the case does not have".to_owned()));
        }
        Ok(stand)
    }

    /// Number of the phase that is under way.
    pub(in crate::run) const fn phase_under_way(&self) -> usize {
        self.phase
    }

    /// True once all steps are behind the run.
    pub(in crate::run) fn is_after_time(&self, case: &Case) -> bool {
        let phases = phases(&case.scene, &case.coarser);
        let last = phases
            .iter()
            .rposition(|p| matches!(p, Phase::March { .. }));
        last.is_some_and(|march| self.phase > march)
    }
}

/// What follows a phase.
pub(super) enum Next {
    /// The next phase.
    Phase,
    /// What comes after the last steps: the time is over.
    AfterTime,
    /// Nothing: the run was interrupted, and a checkpoint is written.
    Interrupted,
    /// Nothing: what the run is for has been found.
    End(String),
}
