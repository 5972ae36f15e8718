//! The end of a run: everything that it leaves, the summary whatever else fails, and the last word in the ledger.

use std::path::Path;
use std::time::Instant;

use super::fault::caught;
use super::outputs::no_room;
use super::tables::{self, load_test, panel_shaping, trim};
use super::{INTERRUPTED, Report, Run, RunError, animation, summary};
use crate::checkpoint;
use crate::ledger::{Ledger, State};
use crate::measure::{SAMPLES_FILE, sail_warnings};
use crate::output::{write_canopy_vtp, write_summary};
use crate::report::{self, Finished};
use crate::simulation::Diverged;

/// How far the Reynolds number of flown sections may be from that of their polars, as a factor.
const FLOWN_REYNOLDS: f64 = 2.0;

/// What could not be delivered: the first error ends the run at last, all of them stand in its notes.
#[derive(Default)]
struct Undelivered {
    first: Option<RunError>,
    notes: Vec<String>,
}

impl Undelivered {
    fn note<E: Into<RunError>>(&mut self, delivered: Result<(), E>) {
        if let Err(error) = delivered {
            let error = error.into();
            self.notes.push(format!("warning: {error}"));
            self.first.get_or_insert(error);
        }
    }
}

impl Run<'_> {
    /// Writes what a run leaves that ended for `reason`.
    pub(super) fn end(
        mut self,
        reason: String,
        diverged: Option<Diverged>,
        began: Instant,
    ) -> Result<Report, RunError> {
        let mut undelivered = Undelivered::default();
        // Tried again below, where more room may be left.
        let _ = self.history.flush();
        let interrupted = diverged.is_none() && reason == INTERRUPTED;
        if diverged.is_some() {
            undelivered.note(self.last_good_state());
        } else {
            let canopy = self.files.canopy(&self.simulation).map_err(RunError::from);
            let bodies = self.files.bodies(&self.simulation).map_err(RunError::from);
            for (what, written) in [
                ("the canopy", canopy),
                ("the bodies", bodies),
                ("the air", self.files.flow(&self.simulation)),
                (
                    "the last picture",
                    self.files.picture(&self.simulation, &self.record),
                ),
            ] {
                self.deliver_or_miss(what, written, &mut undelivered);
            }
        }
        let mut frames = self.files.animation_frames;
        if !interrupted {
            match animation::join(self.folder, self.files.animation_frames) {
                Ok(0) => {}
                Ok(lost) => self.notes.push(format!(
                    "warning: {lost} of {} frames of the animation are not there any more",
                    self.files.animation_frames
                )),
                Err(error) => {
                    // They stay the files that they are.
                    frames = 0;
                    self.deliver_or_miss("the animation", Err(error.into()), &mut undelivered);
                }
            }
        }
        self.notes.append(&mut self.stand.balance_notes);
        if !interrupted && diverged.is_none() && !self.stand.unbalanced {
            self.warn_of_the_sail();
        }
        if self.record.unreadable() {
            self.notes.push(format!(
                "warning: samples could not be read back from {SAMPLES_FILE}; results that need them are missing"
            ));
        }
        let unbalanced = self.out_of_balance();
        let last_picture = self.files.last_picture.take();
        self.notes.append(&mut undelivered.notes);
        self.notes.extend(self.missing.note());
        let state = match &diverged {
            Some(_) => State::Diverged,
            None if interrupted => State::Interrupted,
            None => State::Finished,
        };
        let mut summary = summary::summarise(
            self.case,
            (&self.simulation, &self.statics),
            &self.record,
            (state, reason.clone()),
            std::mem::take(&mut self.notes),
            began.elapsed().as_secs_f64(),
            self.resumed_at_step,
        );
        let sought = self.sought().filter(|_| interrupted);
        let unsettled = match sought {
            Some(sought) => Some(format!("interrupted on the way to {sought}")),
            None => (unbalanced.as_ref()).map(|what| format!("out of balance: {what}")),
        };
        if let Some(what) = unsettled {
            for (_, quantity) in summary.results.iter_mut() {
                quantity.mark_unresolved(&what);
            }
        }
        let path = self.folder.join("summary.json");
        // Frames and pictures have taken no part of it.
        self.reserve = None;
        // Before what may still fail: results that were computed can then be read.
        undelivered.note(write_summary(&path, &summary));
        undelivered.note(self.history.finish());
        let (folder, scene) = (self.folder, &self.case.scene);
        let frame = self.simulation.structure_frame();
        undelivered.note(tables::write(
            &self.files.folder,
            self.simulation.scene(),
            (&self.record, frame.structure.as_ref()),
            &summary,
        ));
        undelivered.note(trim::write(
            &self.files.folder,
            &self.simulation,
            self.statics.trim.as_ref(),
        ));
        undelivered.note(load_test::write(
            &self.files.folder,
            scene,
            self.statics.load_test.as_ref(),
        ));
        undelivered.note(panel_shaping::write(
            &self.files.folder,
            scene,
            &self.simulation,
            &self.statics,
        ));
        if !interrupted {
            undelivered.note(report_page(folder, &self.ledger, state, &reason));
        }
        if !undelivered.notes.is_empty() {
            if state == State::Finished {
                State::Failed.name().clone_into(&mut summary.stop.state);
            }
            summary.notes.append(&mut undelivered.notes);
            undelivered.note(write_summary(&path, &summary));
        }
        let delivered = undelivered.first.is_none();
        if delivered && !interrupted {
            animation::remove_frames(folder, frames);
        }
        let state = match state {
            State::Finished if !delivered => State::Failed,
            state => state,
        };
        let told = undelivered.first.as_ref().map(ToString::to_string);
        self.ledger
            .end_session(state, told.as_deref().unwrap_or(&reason));
        super::identity::account(&mut self.ledger, folder, &self.simulation);
        undelivered.note(self.ledger.write(folder));
        // Last: a run that is killed before it is complete can still be resumed.
        if state == State::Finished && undelivered.first.is_none() {
            if self.keep_final && super::folder::can_go_on(scene) {
                undelivered.note(checkpoint::keep_final(folder));
            } else {
                checkpoint::remove(folder);
                // What only checkpoints refer to; there may be none.
                let _ = std::fs::remove_file(folder.join(SAMPLES_FILE));
            }
        }
        match (undelivered.first, diverged) {
            (Some(error), _) => Err(error),
            (None, Some(diverged)) => Err(RunError::Diverged(diverged)),
            (None, None) => Ok(Report {
                summary,
                interrupted,
                unbalanced: if interrupted { None } else { unbalanced },
                last_picture,
            }),
        }
    }

    /// Writes what a run leaves that failed in its midst: the summary of what was sampled before, and the ledger. The cause is told by the caller, so
    /// nothing is said of what fails now.
    pub(super) fn end_failed(&mut self, why: &str, began: Instant) {
        let _ = self.history.flush();
        self.notes.append(&mut self.stand.balance_notes);
        self.notes.extend(self.missing.note());
        self.notes.push(format!(
            "warning: the run failed, and the results are those up to then; {}",
            if checkpoint::exists(self.folder) {
                "--resume goes on from its last checkpoint"
            } else {
                "there is no checkpoint to go on from"
            }
        ));
        let notes = std::mem::take(&mut self.notes);
        // After a fault the state may be half changed, and what reads it may fail, too.
        let summary = caught(|| {
            summary::summarise(
                self.case,
                (&self.simulation, &self.statics),
                &self.record,
                (State::Failed, why.to_owned()),
                notes,
                began.elapsed().as_secs_f64(),
                self.resumed_at_step,
            )
        });
        self.reserve = None;
        if let Ok(summary) = summary {
            let _ = write_summary(&self.folder.join("summary.json"), &summary);
        }
        self.ledger.end_session(State::Failed, why);
        super::identity::account(&mut self.ledger, self.folder, &self.simulation);
        let _ = self.ledger.write(self.folder);
    }

    /// Does without a file that there is no room for.
    fn deliver_or_miss(
        &mut self,
        what: &str,
        written: Result<(), RunError>,
        undelivered: &mut Undelivered,
    ) {
        match &written {
            Err(error) if no_room(error).is_some() => {
                self.missing.add(what, self.simulation.time_s());
            }
            _ => undelivered.note(written),
        }
    }

    /// Notes where a wing in equilibrium lacks support, where stress gathers, and where it flew beyond its polars; of one that is out of balance it would mean nothing.
    fn warn_of_the_sail(&mut self) {
        let scene = self.simulation.scene();
        let (Some(wing), Some(body), Some(_)) = (scene.wing(), &scene.body, scene.equilibrium)
        else {
            return;
        };
        if let Some(structure) = &self.simulation.structure_frame().structure {
            let warnings = sail_warnings(wing, &body.structure, structure);
            let warnings = warnings.into_iter();
            self.notes
                .extend(warnings.map(|warning| format!("warning: {warning}")));
        }
        let flight = (self.statics.trim.as_ref()).and_then(|trim| trim.flight.as_ref());
        if let (Some(flight), Some(settings)) = (flight, &wing.trim) {
            let flown = flight.reynolds_number(settings.density_kg_m3);
            let given = settings.sections.reynolds;
            let computed = settings.sections.polars.iter().any(Option::is_none);
            if computed && !(given / FLOWN_REYNOLDS..=given * FLOWN_REYNOLDS).contains(&flown) {
                self.notes.push(format!(
                    "warning: the wing flies at a Reynolds number of {flown:.1e} on its mean chord, and the polars of its sections were computed for {given:.1e}: give equilibrium.trim.reynolds_number = {flown:.1e}"
                ));
            }
        }
        if flight.is_some_and(|flight| !flight.is_covered) {
            self.notes.push(
                "warning: some sections fly at angles of attack, or with their trailing edge turned, beyond their polars: drag and lift there are guesses"
                    .to_owned(),
            );
        }
    }

    /// Writes the structure as it was last known to be sound.
    fn last_good_state(&mut self) -> Result<(), RunError> {
        if let Some(structure) = &self.good.structure {
            let path = self.folder.join("canopy_last_good.vtp");
            write_canopy_vtp(&path, structure, self.files.folder.stamp(self.good.time_s))?;
        }
        self.notes.push(format!(
            "last good state, at t = {:.6} s, in canopy_last_good.vtp",
            self.good.time_s
        ));
        Ok(())
    }
}

/// Writes the page that shows the run.
fn report_page(folder: &Path, ledger: &Ledger, state: State, reason: &str) -> Result<(), RunError> {
    let Ok(mut finished) = Finished::read(folder) else {
        // What it would show could not be written, which is told already.
        return Ok(());
    };
    let mut ledger = ledger.clone();
    ledger.end_session(state, reason);
    finished.ledger = Some(ledger);
    Ok(report::write(&finished)?)
}
