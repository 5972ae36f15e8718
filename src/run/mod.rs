//! A complete run: advances a simulation to its end, samples it, and writes everything into one folder.

mod animation;
mod cadence;
mod device_use;
mod ending;
mod error;
mod fault;
mod files;
mod folder;
mod guard;
mod identity;
mod keeping;
mod log;
mod losses;
mod mesh_pictures;
mod missing;
mod names;
mod order;
mod outputs;
mod phases;
mod prepare;
mod requests;
mod rescue;
mod run_folder;
mod summary;
mod tables;
mod verdict;
mod verify;
mod written;

use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::case::Case;
use crate::checkpoint;
use crate::frame::Frame;
use crate::gpu::Device;
use crate::ledger::{Holder, Ledger, Lock};
use crate::measure::steady::Detector;
use crate::measure::{Record, SAMPLES_FILE};
use crate::output::{HistoryWriter, OutputError, prepare_directory, remove_leftovers};
use crate::plan::{Plan, steps_per};
use crate::simulation::{Failure, Simulation};
use crate::statics::Statics;
pub use error::RunError;
pub use fault::{Fault, caught, record_panics};
use files::Files;
pub use folder::{carried_over, holds_another, is_of_this_build, is_unfinished_run};
use guard::{OnPurpose, guarded, settle};
use identity::{COMPUTED_BY, account};
use log::Log;
use losses::{Losses, has_room};
pub use mesh_pictures::draw_findings;
use missing::Missing;
pub use order::{Observer, Order, Report, Start};
use phases::{Lattice, Stand};
pub use requests::Requests;

struct Run<'a> {
    case: &'a Case,
    folder: &'a Path,
    ledger: Ledger,
    identity: String,
    computed_by: String,
    checkpoint_interval: Duration,
    simulation: Simulation,
    statics: Statics,
    lattice: Lattice,
    stand: Stand,
    /// Stops the run once the means are steady; `None` where it goes to its end.
    detector: Option<Detector>,
    record: Record,
    history: HistoryWriter,
    files: Files<'a>,
    /// Structure at the last sample known to be sound, in case the next steps break down.
    good: Frame,
    /// Structure at a later sample, not yet known to be.
    sampled: Frame,
    notes: Vec<String>,
    /// Step of the checkpoint that the run went on from.
    resumed_at_step: Option<u64>,
    requests: Requests,
    /// When the last checkpoint was written; before the first, when the run began.
    last_checkpoint: Instant,
    /// Stop at the end alone, however steady the results are.
    to_the_end: bool,
    /// Keep the state at the end.
    keep_final: bool,
    /// The state is that between two steps, and nothing of it has been sampled.
    whole: bool,
    /// A fault that a test asks for.
    on_purpose: Option<OnPurpose>,
    /// Files that there was no room for.
    missing: Missing,
    /// Room for the results, given back before they are written.
    reserve: Option<File>,
}

/// Runs a case and writes its results; stops early, resumably, when it is asked to.
pub fn run(
    order: Order,
    requests: &Requests,
    observer: &mut dyn Observer,
) -> Result<Report, RunError> {
    let folder = order.folder;
    prepare_directory(order.folder)?;
    let lock = Lock::acquire(order.folder, &Holder::this(&order.case.name))?;
    let mut log = Log::new(folder, observer);
    if !lock.is_held() {
        log.note(
            "this file system has no locks: two runs in one folder would not notice each other",
        );
    }
    let mut result = guarded(|| run_locked(order, requests, &mut log));
    settle(folder, &mut result);
    log.end(&result);
    result
}

/// The same in a folder that is locked; on a device opened anew where one is lost.
fn run_locked(
    mut order: Order,
    requests: &Requests,
    observer: &mut Log<'_>,
) -> Result<Report, RunError> {
    let on_purpose = OnPurpose::asked_for()?;
    let mut losses = Losses::default();
    loop {
        let began = Instant::now();
        let mut run = begin(&order, requests, observer)?;
        run.notes.extend(losses.notes.iter().cloned());
        if let Some(on_purpose) =
            on_purpose.filter(|asked| asked.is_due(run.resumed_at_step.is_some()))
        {
            observer.note(&on_purpose.to_string());
            run.on_purpose = Some(on_purpose);
        }
        let (reason, diverged) = match guarded(|| run.drive(observer)) {
            Ok(reason) => (reason, None),
            Err(RunError::Diverged(diverged)) => {
                run.leave_phase();
                (diverged.to_string(), Some(diverged))
            }
            Err(mut other) => {
                if let RunError::Fault(fault) = &mut other {
                    run.rescue(fault);
                }
                run.leave_phase();
                run.end_failed(&other.to_string(), began);
                let step = run.simulation.step_count();
                drop(run);
                losses.survive(&mut order, step, other, observer)?;
                continue;
            }
        };
        if let Some(note) = run.lattice.note(run.case) {
            if diverged.is_some() || reason != INTERRUPTED {
                observer.note(&note);
            }
            run.notes.push(note);
        }
        return run.end(reason, diverged, began);
    }
}

/// Admits a run to its folder and reads what it begins from; on the CPU where a device that the program chose by itself turns out too small.
fn begin<'a>(
    order: &Order<'a>,
    requests: &Requests,
    observer: &mut Log<'_>,
) -> Result<Run<'a>, RunError> {
    let earlier = folder::admit(order)?;
    remove_leftovers(order.folder);
    let mut run = match (
        Run::prepare(order.clone(), earlier.clone(), observer),
        &order.fallback,
    ) {
        (Err(RunError::Device(error)), Some(plan)) if has_room(plan) => {
            observer.note(&format!("the CPU computes, since {error}"));
            Run::prepare(order.on_cpu(plan), earlier, observer)?
        }
        (prepared, _) => prepared?,
    };
    requests.set_resumable(matches!(order.start, Start::Resume | Start::Extend));
    run.requests = requests.clone();
    observer.open(order.start);
    Ok(run)
}

/// Runs a case to its end without writing anything; samples at the case's cadence, and once at the end.
pub fn without_files(
    case: &Case,
    plan: Plan,
    device: Option<Arc<Device>>,
) -> Result<(Simulation, Record), Failure> {
    let planned = plan.start_steps.saturating_add(plan.steps);
    let start_steps = plan.start_steps;
    let sample_every = steps_per(&case.scene, case.scene.output.sample_interval_s);
    let mut simulation = Simulation::new(case.scene.clone(), plan, device)?;
    let mut record = Record::new(&simulation);
    while simulation.step_count() < planned {
        if simulation.released()
            && (simulation.step_count() - start_steps).is_multiple_of(sample_every)
        {
            record.add(&mut simulation)?;
        }
        simulation.advance()?;
    }
    record.add(&mut simulation)?;
    Ok((simulation, record))
}

/// Older samples go to a file of the folder.
fn keep_samples(record: &mut Record, folder: &Path) -> Result<(), OutputError> {
    record
        .keep_in(folder)
        .map_err(|cause| OutputError::new("write", &folder.join(SAMPLES_FILE), cause))
}

const INTERRUPTED: &str = "interrupted; --resume continues from the checkpoint";

impl Run<'_> {
    fn save(&mut self) -> Result<(), RunError> {
        // The ledger first: whatever a checkpoint says was written is then listed.
        self.history.flush()?;
        account(&mut self.ledger, self.folder, &self.simulation);
        self.ledger.write(self.folder)?;
        let (folder, identity) = (self.folder, self.identity.clone());
        let written = checkpoint::write(folder, &identity, |out| self.fill(out));
        // A device that fails while its state is read is the cause, not the file.
        self.simulation.check_device()?;
        written?;
        self.requests.set_resumable(true);
        Ok(())
    }

    /// Writes the sections of a checkpoint.
    fn fill(&mut self, out: &mut checkpoint::Writer) -> std::io::Result<()> {
        out.put(COMPUTED_BY, self.computed_by.as_bytes())?;
        self.lattice.save(out)?;
        self.stand.save(out)?;
        self.statics.save(&self.simulation, out)?;
        self.simulation.save(out)?;
        self.record.save(out)?;
        self.files.save(out)
    }
}
