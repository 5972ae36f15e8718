//! What to run and where, who watches, and how it ended.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crate::case::Case;
use crate::gpu::Device;
use crate::output::Summary;
use crate::plan::Plan;

/// Who watches a run.
pub trait Observer {
    /// Called where another phase begins, or one of its parts whose progress counts from nothing again.
    fn phase_begins(&mut self) {}
    /// Called now and then with parts done, parts planned and a short status. What is planned stays the same until another phase begins.
    fn progress(&mut self, done: u64, planned: u64, status: &str);
    /// Called with single events worth a line.
    fn note(&mut self, line: &str);
    /// Called when the run goes on on other cells, or with another time step.
    fn lattice_changed(&mut self) {}
}

/// How a run ended.
#[derive(Debug)]
pub struct Report {
    /// What `summary.json` holds.
    pub summary: Summary,
    /// True if it was interrupted; a checkpoint is then in the folder.
    pub interrupted: bool,
    /// The picture of the last state.
    pub last_picture: Option<PathBuf>,
    /// What was not in balance: results are then not those of the case.
    pub unbalanced: Option<String>,
}

/// What to run, and where.
#[derive(Debug, Clone)]
pub struct Order<'a> {
    /// The case.
    pub case: &'a Case,
    /// Its plan.
    pub plan: Plan,
    /// The device that the plan names, if any.
    pub device: Option<Arc<Device>>,
    /// Plan to fall back on, without a device, if the device cannot hold the scene.
    pub fallback: Option<Plan>,
    /// Folder for all results.
    pub folder: &'a Path,
    /// Anew, or from what lies in a folder.
    pub start: Start<'a>,
    /// Begin anew whatever run the folder holds.
    pub overwrite: bool,
    /// Keep the state at the end, so that the run can be made longer and others can begin from it.
    pub keep_final: bool,
    /// Wall time between checkpoints.
    pub checkpoint_interval: Duration,
}

impl Order<'_> {
    /// The same by another plan, which takes no device.
    pub(super) fn on_cpu(&self, plan: &Plan) -> Self {
        Self {
            plan: plan.clone(),
            device: None,
            fallback: None,
            ..self.clone()
        }
    }

    /// The same, but it goes on from the newest checkpoint of its folder.
    pub(super) fn going_on(&self) -> Self {
        Self {
            start: match self.start {
                Start::Extend => Start::Extend,
                Start::New | Start::Resume | Start::From(_) => Start::Resume,
            },
            ..self.clone()
        }
    }
}

/// How a run begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start<'a> {
    /// Anew, in a folder that is empty, or holds a run of the very same case that is over.
    New,
    /// From the newest checkpoint in its folder.
    Resume,
    /// From the end of the run in its folder, and to the end of the case, however steady the results are.
    Extend,
    /// Anew, from the newest state in another folder, with its time and without its samples.
    From(&'a Path),
}
