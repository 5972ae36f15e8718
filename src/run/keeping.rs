//! Checkpoints while the structure is solved at rest: when they are due or asked for, without a change to the minimisation.
//!
//! They hold the state from before. Those of an equilibrium also tell where the nodes are now: a run that goes on from there begins the minimisation anew at
//! those places, so its results agree with those of a run in one piece within the tolerance, not to the bit. Parts of a trim or of a load test begin anew.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::outputs::no_room;
use super::{Observer, Requests, Run, RunError};
use crate::checkpoint;
use crate::ledger::Ledger;
use crate::output::OutputError;
use crate::simulation::POSITIONS_SECTION;
use crate::solve::lbfgs::Progress;

/// Which positions a checkpoint takes from the minimisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sought {
    /// Those of the structure.
    Equilibrium,
    /// None: the part of a phase begins anew.
    Part,
}

/// Writes checkpoints of a minimisation.
pub(super) struct Keeping {
    folder: PathBuf,
    identity: String,
    ledger: Ledger,
    sought: Sought,
    /// The state before.
    sections: Vec<u8>,
    /// Where the nodes were before that are held [m]; `None` for the others.
    held_m: Vec<Option<DVec3>>,
    interval: Duration,
    last: Instant,
    requests: Requests,
    /// It was said that there is no room.
    told: Option<String>,
    failed: Option<RunError>,
}

impl Keeping {
    /// True if the minimisation is to go on; writes a checkpoint before, if it is time.
    pub(super) fn goes_on(&mut self, progress: &Progress, observer: &mut dyn Observer) -> bool {
        let asked = self.requests.takes_checkpoint();
        if asked || self.last.elapsed() >= self.interval {
            match self.write(progress) {
                Ok(true) if asked => observer.note(&format!(
                    "checkpoint after {} evaluations, as asked for",
                    progress.evaluations
                )),
                Ok(_) => {}
                Err(error) => match no_room(&error) {
                    Some(cause) if self.told.is_none() => {
                        let text = format!(
                            "warning: {cause}; the run goes on, and tries again with the next checkpoint"
                        );
                        observer.note(&text);
                        self.told = Some(text);
                    }
                    Some(_) => {}
                    None => self.failed = Some(error),
                },
            }
            // After it: a slow disk is not to be written to all the time.
            self.last = Instant::now();
        }
        self.failed.is_none() && !self.requests.to_stop()
    }

    /// False if the device cannot tell where the nodes are.
    fn write(&self, progress: &Progress) -> Result<bool, RunError> {
        let places_m = match self.sought {
            Sought::Part => None,
            Sought::Equilibrium => match progress.positions_m() {
                Some(places_m) => Some(self.with_held(places_m)),
                // The device that cannot tell them says why in the next trial.
                None => return Ok(false),
            },
        };
        self.ledger.write(&self.folder)?;
        checkpoint::write(&self.folder, &self.identity, |out| {
            out.put_all(&self.sections)?;
            match &places_m {
                Some(places_m) => out.put(POSITIONS_SECTION, places_m),
                None => Ok(()),
            }
        })?;
        self.requests.set_resumable(true);
        Ok(true)
    }

    /// Positions with those of held nodes to the last bit; a device rounds them.
    fn with_held(&self, mut places_m: Vec<DVec3>) -> Vec<DVec3> {
        for (place, held) in places_m.iter_mut().zip(&self.held_m) {
            *place = held.unwrap_or(*place);
        }
        places_m
    }
}

impl Run<'_> {
    /// Prepares checkpoints of a minimisation that begins now.
    pub(super) fn keep(&mut self, sought: Sought) -> Result<Keeping, RunError> {
        // Without room its rows wait in memory, and a checkpoint says so again.
        let _ = self.history.flush();
        super::account(&mut self.ledger, self.folder, &self.simulation);
        let sections = checkpoint::sections(|out| self.fill(out)).map_err(|cause| {
            OutputError::new("prepare", &self.folder.join(checkpoint::FILE_NAME), cause)
        });
        self.simulation.check_device()?;
        let cloth = self.simulation.cloth();
        let held_m = cloth.map_or_else(Vec::new, |cloth| {
            let nodes = cloth.positions_m.iter().zip(&cloth.structure.held);
            nodes.map(|(place, held)| held.then_some(*place)).collect()
        });
        Ok(Keeping {
            folder: self.folder.to_owned(),
            identity: self.identity.clone(),
            ledger: self.ledger.clone(),
            sought,
            sections: sections?,
            held_m,
            interval: self.checkpoint_interval,
            last: self.last_checkpoint,
            requests: self.requests.clone(),
            told: None,
            failed: None,
        })
    }

    /// Ends them; an error of one that could not be written ends the run.
    pub(super) fn kept(&mut self, keeping: Keeping) -> Result<(), RunError> {
        self.last_checkpoint = keeping.last;
        self.notes.extend(keeping.told);
        keeping.failed.map_or(Ok(()), Err)
    }
}
