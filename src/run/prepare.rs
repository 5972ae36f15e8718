//! The beginning of a run: what it goes on from, and the first entry in its ledger.

use std::time::Instant;

use super::files::Files;
use super::identity::{COMPUTED_BY, case_entry, computed_by, identity, reached};
use super::missing::Missing;
use super::phases::{Lattice, Stand};
use super::run_folder::RunFolder;
use super::verify::Lost;
use super::written::Written;
use super::{Observer, Order, Requests, Run, RunError, Start};
use super::{folder, keep_samples, names, outputs};
use crate::checkpoint;
use crate::ledger::Ledger;
use crate::measure::Record;
use crate::output::HistoryWriter;
use crate::statics::Statics;

impl<'a> Run<'a> {
    /// Reads what the run begins from, and makes the folder its own.
    pub(super) fn prepare(
        order: Order<'a>,
        earlier: Option<Ledger>,
        observer: &mut dyn Observer,
    ) -> Result<Self, RunError> {
        let Order {
            case,
            plan,
            device,
            folder,
            start,
            overwrite: _,
            keep_final,
            checkpoint_interval,
            fallback: _,
        } = order;
        let (identity, computed_by) = (identity(case, &plan), computed_by(&plan));
        // Read first: a checkpoint that cannot be used must leave the folder as it is.
        let from = match start {
            Start::New => None,
            Start::Resume | Start::Extend => Some(folder),
            Start::From(settled) => Some(settled),
        };
        let found = from
            .map(|from| checkpoint::open(from, &identity))
            .transpose()?;
        let (stored, mut notes) = match found {
            Some(found) => (Some(found.reader), found.passed_over),
            None => (None, Vec::new()),
        };
        if stored.is_some()
            && let Some(earlier) = &earlier
        {
            notes.extend(folder::what_changed(earlier, case));
        }
        if let Start::From(settled) = start
            && let Ok(Some(ledger)) = Ledger::read(settled)
        {
            notes.extend(folder::another_computer(&ledger, "the state"));
        }
        notes.iter().for_each(|note| observer.note(note));
        let precision = plan.placement.precision_name();
        let lattice = match &stored {
            Some(stored) => Lattice::restore(case, stored)?,
            None => Lattice::first(case),
        };
        let mut simulation = lattice.start(case, plan, device.clone())?;
        let mut record = Record::new(&simulation);
        let mut written = Written::default();
        let mut lost = Lost::default();
        let (mut statics, mut stand) = (Statics::default(), Stand::default());
        match &stored {
            Some(stored) => {
                statics = Statics::restore(stored, &case.scene, &mut simulation)?;
                simulation.restore(stored)?;
                stand = Stand::restore(case, stored, lattice)?;
                if simulation.steps_are_left() && stand.is_after_time(case) {
                    return Err(RunError::Resume(
                        "the run has begun to seek its state at rest, from where its steps ended: time.end_s may not be raised; leave it, or begin \
                         anew with --overwrite"
                            .to_owned(),
                    ));
                }
                folder::refuse_past_the_end(&simulation)?;
                if from == Some(folder) {
                    record.restore(stored, folder)?;
                    written = Written::restore(stored)?;
                    lost = Lost::find(folder, &written, earlier.as_ref());
                } else {
                    simulation.count_anew();
                    names::remove_earlier(folder);
                    keep_samples(&mut record, folder)?;
                }
                let others = |earlier| folder::has_other_pictures(earlier, case);
                if earlier.as_ref().is_none_or(others) {
                    written.expect_pictures(&simulation);
                }
                if let Some(note) = lost.note() {
                    observer.note(&note);
                    notes.push(note);
                }
                let text = format!(
                    "{} at t = {:.6} s, step {}",
                    match start {
                        Start::From(settled) =>
                            format!("begun from the state in {}", settled.display()),
                        _ => "resumed".to_owned(),
                    },
                    simulation.time_s(),
                    simulation.step_count()
                );
                observer.note(&text);
                notes.push(text);
                let before = stored.take::<u8>(COMPUTED_BY)?;
                if before != computed_by.as_bytes() {
                    let text = format!(
                        "before, {} was computed with {}, now with {computed_by}: results differ in rounding from those of one run on \
                         either",
                        match start {
                            Start::From(_) => "the state",
                            _ => "the run",
                        },
                        String::from_utf8_lossy(&before)
                    );
                    observer.note(&text);
                    notes.push(text);
                }
            }
            None => {
                names::remove_earlier(folder);
                keep_samples(&mut record, folder)?;
            }
        }
        let columns: Vec<&str> = record
            .columns()
            .iter()
            .map(|column| &*column.name)
            .collect();
        let mut history = HistoryWriter::create(&folder.join("history.csv"), &columns)?;
        for row in record.history_rows() {
            history.push(&row)?;
        }
        let run_folder = RunFolder::new(folder, case);
        let files = Files::create(run_folder, &case.scene, (&written, &lost))?;
        let entry = case_entry(case, checkpoint_interval);
        let sample_s = case.scene.output.sample_interval_s;
        let mut ledger = match earlier {
            Some(earlier) => Ledger {
                case: entry,
                precision: precision.to_owned(),
                sample_interval_s: sample_s,
                ..earlier
            },
            None => Ledger::new(entry, precision, sample_s),
        };
        if let Start::From(settled) = start {
            ledger.begun_from = Some(settled.display().to_string());
        }
        if start == Start::Extend {
            ledger.extended_to_s = case.scene.time.map(|time| time.end_s);
        }
        super::identity::write_case(case, folder)?;
        ledger.begin_session(simulation.step_count(), &computed_by);
        ledger.reached = reached(&simulation);
        ledger.write(folder)?;
        let resumed_at_step = stored.is_some().then(|| simulation.step_count());
        let good = simulation.structure_frame();
        let sampled = good.clone();
        Ok(Self {
            case,
            folder,
            ledger,
            identity,
            computed_by,
            checkpoint_interval,
            simulation,
            statics,
            lattice,
            stand,
            detector: None,
            record,
            history,
            files,
            good,
            sampled,
            notes,
            resumed_at_step,
            requests: Requests::default(),
            last_checkpoint: Instant::now(),
            to_the_end: start == Start::Extend,
            keep_final,
            whole: true,
            on_purpose: None,
            missing: Missing::default(),
            reserve: outputs::reserve(folder),
        })
    }
}
