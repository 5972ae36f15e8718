//! What a run writes between its steps, and what it does without for want of room.
//!
//! Frames, pictures and checkpoints that there is no room for end nothing: the run says so once, goes on, and tries again with the next.
//! Rows of the history wait in memory until there is room.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use super::cadence::Cadence;
use super::{Observer, Run, RunError};
use crate::output::OutputError;

/// Bytes kept free for summary, history and tables while a run goes on.
const RESERVE_BYTES: usize = 2 << 20;

/// A file without a name that keeps room in `folder`, until it is dropped, even by a kill; `None` where there is none to keep.
pub(super) fn reserve(folder: &Path) -> Option<File> {
    let mut file = tempfile::tempfile_in(folder).ok()?;
    file.write_all(&vec![0; RESERVE_BYTES]).ok()?;
    Some(file)
}

/// What there is no room for.
pub(super) enum Lacking {
    /// A file that is left out, by its kind.
    File(&'static str),
    /// Rows of the history.
    Rows,
    /// A checkpoint.
    Checkpoint,
}

/// The error, if it is one of a full disk.
pub(super) fn no_room(error: &RunError) -> Option<&OutputError> {
    match error {
        RunError::Output(error) if error.is_no_room() => Some(error),
        _ => None,
    }
}

impl Run<'_> {
    /// Passes over an error for want of room, which it tells once; true without any error.
    pub(super) fn spare(
        &mut self,
        lacking: &Lacking,
        written: Result<(), RunError>,
        observer: &mut dyn Observer,
    ) -> Result<bool, RunError> {
        let Err(error) = written else {
            return Ok(true);
        };
        let Some(cause) = no_room(&error) else {
            return Err(error);
        };
        let (kind, what) = match lacking {
            Lacking::File(what) => {
                self.missing.add(what, self.simulation.time_s());
                (
                    0,
                    "the run goes on without it, and tries again with the next",
                )
            }
            Lacking::Rows => (1, "the run goes on, and rows wait until there is room"),
            Lacking::Checkpoint => (
                2,
                "the run goes on, and tries again with the next checkpoint",
            ),
        };
        if !std::mem::replace(&mut self.missing.told[kind], true) {
            let text = format!("warning: {cause}; {what}");
            observer.note(&text);
            self.notes.push(text);
        }
        Ok(false)
    }

    /// Writes the frames of structure, bodies and air that are due `since` so many steps.
    pub(super) fn write_frames(
        &mut self,
        cadence: &Cadence,
        since: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let due = |every: Option<u64>| every.is_some_and(|n| since.is_multiple_of(n));
        if due(cadence.canopy) {
            let written = self.files.canopy(&self.simulation).map_err(RunError::from);
            self.spare(&Lacking::File("the canopy"), written, observer)?;
        }
        if due(cadence.bodies) {
            let written = self.files.bodies(&self.simulation).map_err(RunError::from);
            self.spare(&Lacking::File("the bodies"), written, observer)?;
        }
        if due(cadence.flow) {
            let written = self.files.flow(&self.simulation);
            self.spare(&Lacking::File("the air"), written, observer)?;
        }
        Ok(())
    }

    /// Draws the frame of the animation that is due `since` so many steps, and the pictures of `times_s`, in order, whose time has come.
    pub(super) fn draw_pictures(
        &mut self,
        cadence: &Cadence,
        since: u64,
        times_s: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        if cadence.animation.is_some_and(|n| since.is_multiple_of(n)) {
            let drawn = self.files.animation_frame(&self.simulation, &self.record);
            self.spare(&Lacking::File("a frame of the animation"), drawn, observer)?;
        }
        while times_s
            .get(self.files.timed_pictures)
            .is_some_and(|&t| t <= self.simulation.time_s() + 0.5 * cadence.step_s)
        {
            let drawn = self.files.picture(&self.simulation, &self.record);
            self.spare(&Lacking::File("a picture"), drawn, observer)?;
            self.files.timed_pictures += 1;
        }
        Ok(())
    }

    /// Adds a row to the history.
    pub(super) fn sample(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let row = self.record.add(&mut self.simulation)?;
        let written = self.history.push(row).map_err(RunError::from);
        self.spare(&Lacking::Rows, written, observer).map(drop)
    }

    /// Writes a checkpoint; false if there is no room for one.
    pub(super) fn try_save(&mut self, observer: &mut dyn Observer) -> Result<bool, RunError> {
        let saved = self.save();
        self.spare(&Lacking::Checkpoint, saved, observer)
    }

    /// Writes a checkpoint of the end, if it is to be kept and the run can go on from it; without room there is none.
    pub(super) fn save_final(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        if self.keep_final && super::folder::can_go_on(&self.case.scene) {
            // An older one is not that of the end.
            self.keep_final = self.try_save(observer)?;
            if !self.keep_final {
                let text = "warning: there was no room for the state at the end: the run cannot be made longer";
                observer.note(text);
                self.notes.push(text.to_owned());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Error, ErrorKind};
    use std::path::Path;

    #[test]
    fn only_want_of_room_is_passed_over() {
        let of =
            |cause: Error| RunError::from(OutputError::new("write", Path::new("a.vtp"), cause));
        for kind in [
            ErrorKind::StorageFull,
            ErrorKind::QuotaExceeded,
            ErrorKind::FileTooLarge,
        ] {
            assert!(no_room(&of(kind.into())).is_some(), "{kind}");
        }
        for kind in [
            ErrorKind::PermissionDenied,
            ErrorKind::ReadOnlyFilesystem,
            ErrorKind::NotFound,
        ] {
            assert!(no_room(&of(kind.into())).is_none(), "{kind}");
        }
        if cfg!(unix) {
            // Too many open files.
            assert!(no_room(&of(Error::from_raw_os_error(24))).is_some());
        }
    }
}
