//! A complete run: advances a simulation to its end, samples it, and writes everything into one folder.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::DVec3;

use crate::case::Case;
use crate::case::scene::BodyKind;
use crate::frame::Frame;
use crate::measure::{Record, results};
use crate::output::{
    CaseInfo, HistoryWriter, MillisecondsPerStep, OutputError, Pvd, SCHEMA_VERSION, StopInfo,
    Summary, prepare_directory, write_atomically, write_canopy_vtp, write_flow_vti, write_summary,
};
use crate::plan::Plan;
use crate::render::{self, PictureOptions};
use crate::simulation::{Diverged, Simulation};
use crate::solve::lbfgs::Stop;
use crate::steady;

/// Why a run could not deliver.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The physics broke down; files up to then are kept.
    #[error("{0}")]
    Diverged(Diverged),
    /// A file could not be written.
    #[error("{0}")]
    Output(#[from] OutputError),
    /// A picture could not be drawn.
    #[error("cannot draw a picture: {0}")]
    Picture(#[from] render::RenderError),
}

/// Who watches a run.
pub trait Observer {
    /// Called now and then with steps done, steps planned and a short status.
    fn progress(&mut self, done: u64, planned: u64, status: &str);
    /// Called with single events worth a line.
    fn note(&mut self, line: &str);
}

/// How a run ended.
#[derive(Debug)]
pub struct Report {
    /// What `summary.json` holds.
    pub summary: Summary,
    /// True if it was interrupted.
    pub interrupted: bool,
    /// The picture of the last state.
    pub last_picture: Option<PathBuf>,
}

/// Files of a run.
struct Files<'a> {
    folder: &'a Path,
    canopies: Option<Pvd>,
    flows: Option<Pvd>,
    pictures: usize,
    last_picture: Option<PathBuf>,
}

/// Runs `case` as planned and writes into `folder`; stops early when `interrupt` turns true.
pub fn run(
    case: &Case,
    plan: Plan,
    folder: &Path,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Report, RunError> {
    prepare_directory(folder)?;
    let began = Instant::now();
    let scene = &case.scene;
    let planned = plan.start_steps + plan.steps;
    let mut simulation = Simulation::new(scene.clone(), plan).map_err(RunError::Diverged)?;
    if let Some(opening) = simulation.opening() {
        observer.note(&format!(
            "canopy opened by loading pressure: D_p/D_0 {:.3} -> {:.3} in {} steps",
            opening.folded_ratio, opening.opened_ratio, opening.steps
        ));
    }
    let mut record = Record::new(&simulation);
    let mut history = HistoryWriter::create(&folder.join("history.csv"), record.columns())?;
    let mut files = Files {
        folder,
        canopies: scene
            .body
            .is_some()
            .then(|| Pvd::create(&folder.join("canopy.pvd")))
            .transpose()?,
        flows: scene
            .air
            .is_some()
            .then(|| Pvd::create(&folder.join("flow.pvd")))
            .transpose()?,
        pictures: 0,
        last_picture: None,
    };
    let mut good = simulation.frame(false);
    let outcome = drive(
        &mut simulation,
        &mut record,
        &mut history,
        &mut files,
        &mut good,
        interrupt,
        observer,
        planned,
    );
    let mut notes = Vec::new();
    let (reason, diverged) = match outcome {
        Ok(reason) => (reason, None),
        Err(RunError::Diverged(diverged)) => (diverged.to_string(), Some(diverged)),
        Err(other) => return Err(other),
    };
    history.finish()?;
    let interrupted = diverged.is_none() && interrupt.load(Ordering::Relaxed);
    if diverged.is_some() {
        if let Some(structure) = &good.structure {
            write_canopy_vtp(&folder.join("canopy_last_good.vtp"), structure, good.time_s)?;
        }
        notes.push(format!(
            "last good state, at t = {:.6} s, in canopy_last_good.vtp",
            good.time_s
        ));
    } else {
        files.canopy(&simulation)?;
        files.flow(&simulation)?;
        files.picture(&simulation, &record)?;
    }
    if simulation.cost().unconverged > 0 {
        notes.push(format!(
            "{} of {} fabric solves ended before their tolerance was reached",
            simulation.cost().unconverged,
            simulation.cost().solves
        ));
    }
    let summary = summarise(
        case,
        &simulation,
        &record,
        reason,
        notes,
        began.elapsed().as_secs_f64(),
    );
    write_summary(&folder.join("summary.json"), &summary)?;
    match diverged {
        Some(diverged) => Err(RunError::Diverged(diverged)),
        None => Ok(Report {
            summary,
            interrupted,
            last_picture: files.last_picture,
        }),
    }
}

#[allow(
    clippy::too_many_arguments,
    reason = "the parts of a run, borrowed together only here"
)]
fn drive(
    simulation: &mut Simulation,
    record: &mut Record,
    history: &mut HistoryWriter,
    files: &mut Files,
    good: &mut Frame,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
    planned: u64,
) -> Result<String, RunError> {
    let output = simulation.scene().output.clone();
    let step_s = simulation.scene().time.map_or(f64::INFINITY, |t| t.step_s);
    let every = |interval: f64| ((interval / step_s).round() as u64).max(1);
    let sample_every = every(output.sample_interval_s);
    let canopy_every = output.canopy_interval_s.map(every);
    let flow_every = output.flow_interval_s.map(every);
    let start_steps = simulation.plan().start_steps;
    let mut picture_times = output.picture_times_s;
    picture_times.sort_by(f64::total_cmp);
    let mut next_picture = 0;
    let steady_unit_s = match (&simulation.scene().body, &simulation.scene().air) {
        (Some(body), Some(air)) => match body.kind {
            BodyKind::Canopy(canopy) => Some(canopy.nominal_diameter_m / air.reference_speed_m_s),
            _ => None,
        },
        _ => None,
    };
    let steady_drag_confidence = simulation.scene().steady_drag_confidence;
    let began = Instant::now();
    while simulation.step_count() < planned {
        if simulation.step_count() >= start_steps {
            let since = simulation.step_count() - start_steps;
            if since.is_multiple_of(sample_every) {
                history.push(record.add(simulation))?;
                *good = simulation.frame(false);
            }
            if canopy_every.is_some_and(|n| since.is_multiple_of(n)) {
                files.canopy(simulation)?;
            }
            if flow_every.is_some_and(|n| since.is_multiple_of(n)) {
                files.flow(simulation)?;
            }
            while next_picture < picture_times.len()
                && picture_times[next_picture] <= simulation.time_s() + 0.5 * step_s
            {
                files.picture(simulation, record)?;
                next_picture += 1;
            }
            if since.is_multiple_of(sample_every)
                && let (Some(unit_s), Some(confidence)) = (steady_unit_s, steady_drag_confidence)
                && let Some(reason) = steady::reason_to_stop(record, unit_s, confidence)
            {
                observer.note(&reason);
                return Ok(reason);
            }
        }
        if interrupt.load(Ordering::Relaxed) {
            return Ok("interrupted".to_owned());
        }
        simulation.advance().map_err(RunError::Diverged)?;
        if simulation.step_count().is_multiple_of(20) || simulation.step_count() == planned {
            observer.progress(
                simulation.step_count(),
                planned,
                &status(simulation, record, began),
            );
        }
    }
    if simulation.scene().time.is_some() {
        history.push(record.add(simulation))?;
    }
    if let Some(result) = simulation.equilibrate() {
        let outcome = result.map_err(RunError::Diverged)?;
        let text = format!(
            "equilibrium: {} after {} iterations and {} evaluations, energy norm {:.3e}",
            match outcome.stop {
                Stop::Converged => "reached",
                Stop::Stalled => "STALLED before its tolerance",
                Stop::LimitReached => "NOT reached within evaluation_limit",
                Stop::NotFinite => "not finite",
            },
            outcome.iterations,
            outcome.evaluations,
            outcome.energy_norm
        );
        observer.note(&text);
        return Ok(text);
    }
    Ok("end time reached".to_owned())
}

fn status(simulation: &Simulation, record: &Record, began: Instant) -> String {
    let rate = simulation.step_count() as f64 / began.elapsed().as_secs_f64();
    let mut text = format!("t = {:.4} s, {rate:.0} steps/s", simulation.time_s());
    for (column, label) in [
        ("projected_diameter_ratio", "D_p/D_0"),
        ("drag_coefficient", "C_D"),
    ] {
        if let Some(value) = record.latest(column).filter(|v| v.is_finite()) {
            text.push_str(&format!(", {label} {value:.3}"));
        }
    }
    text
}

impl Files<'_> {
    fn canopy(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        let Some(collection) = &mut self.canopies else {
            return Ok(());
        };
        let frame = simulation.frame(false);
        if let Some(structure) = &frame.structure {
            let name = format!("canopy_{:05}.vtp", collection.entries().len());
            write_canopy_vtp(&self.folder.join(&name), structure, frame.time_s)?;
            collection.append(frame.time_s, &name)?;
        }
        Ok(())
    }

    fn flow(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        let Some(collection) = &mut self.flows else {
            return Ok(());
        };
        let frame = simulation.frame(true);
        if let Some(fluid) = &frame.fluid {
            let name = format!("flow_{:05}.vti", collection.entries().len());
            write_flow_vti(&self.folder.join(&name), fluid, frame.time_s)?;
            collection.append(frame.time_s, &name)?;
        }
        Ok(())
    }

    fn picture(&mut self, simulation: &Simulation, record: &Record) -> Result<(), RunError> {
        let scene = simulation.scene();
        let frame = simulation.frame(true);
        let mut caption = String::new();
        for (column, label) in [
            ("drag_coefficient", "C_D"),
            ("projected_diameter_ratio", "D_p/D_0"),
        ] {
            if let Some(value) = record.latest(column).filter(|v| v.is_finite()) {
                caption.push_str(&format!("{label} {value:.2}  "));
            }
        }
        let mut options = PictureOptions {
            title: Some(scene.title.clone()),
            caption: Some(caption).filter(|c| !c.is_empty()),
            speed_range_m_s: scene.air.map(|air| [0.0, 1.4 * air.reference_speed_m_s]),
            ..PictureOptions::default()
        };
        if let (Some(body), Some(structure)) = (&scene.body, &frame.structure)
            && let BodyKind::Canopy(canopy) = &body.kind
        {
            // The same box for all pictures of a run, so that the camera stands still.
            let confluence = structure.positions_m[canopy.canopy_node_count];
            let reach = canopy.nominal_diameter_m;
            options.framing_box_m = Some([
                confluence - DVec3::new(0.1, 0.6, 0.6) * reach,
                confluence + DVec3::new(2.3, 0.6, 0.6) * reach,
            ]);
        }
        let bytes = render::snapshot_png_bytes(&frame, &options)?;
        let path = self
            .folder
            .join(format!("snapshot_{:03}.png", self.pictures));
        write_atomically(&path, |out| out.write_all(&bytes))?;
        self.pictures += 1;
        self.last_picture = Some(path);
        Ok(())
    }
}

fn summarise(
    case: &Case,
    simulation: &Simulation,
    record: &Record,
    reason: String,
    mut notes: Vec<String>,
    wall_s: f64,
) -> Summary {
    let scene = simulation.scene();
    let plan = simulation.plan();
    let steps = simulation.step_count();
    let cost = simulation.cost();
    let per_step = |duration: std::time::Duration, present: bool| {
        (present && steps > 0).then(|| 1e3 * duration.as_secs_f64() / steps as f64)
    };
    let cells = scene.air.map(|air| air.cells);
    let fluid_seconds = cost.fluid.as_secs_f64();
    if let Some(opening) = simulation.opening() {
        notes.push(format!(
            "canopy opened by loading pressure from D_p/D_0 {:.3} to {:.3} before the wind",
            opening.folded_ratio, opening.opened_ratio
        ));
    }
    if cost.solves > 0 {
        notes.push(format!(
            "fabric: {:.1} iterations and {:.1} evaluations per solve",
            cost.iterations as f64 / cost.solves as f64,
            cost.evaluations as f64 / cost.solves as f64
        ));
    }
    if let Some(quality) = scene.body.as_ref().and_then(|b| b.quality) {
        notes.push(format!(
            "triangle quality: smallest {:.3}, mean {:.3} (1 = equilateral)",
            quality.smallest_shape, quality.mean_shape
        ));
    }
    Summary {
        schema_version: SCHEMA_VERSION,
        ripstop_version: env!("CARGO_PKG_VERSION").to_owned(),
        case: CaseInfo {
            title: scene.title.clone(),
            file: case.name.clone(),
            variant: case.variant.clone(),
            hash: case.hash.clone(),
        },
        engine: "cpu".to_owned(),
        device: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        precision: plan.precision.name().to_owned(),
        threads: rayon::current_num_threads(),
        cells,
        markers: simulation
            .coupled()
            .map_or(0, |c| c.immersed().marker_count()),
        nodes: plan.sizes.nodes as usize,
        triangles: plan.sizes.triangles as usize,
        steps,
        simulated_s: simulation.time_s().max(0.0),
        wall_s,
        million_lattice_updates_per_s: (cells.is_some() && fluid_seconds > 0.0)
            .then(|| plan.sizes.cells as f64 * steps as f64 / fluid_seconds / 1e6),
        milliseconds_per_step: MillisecondsPerStep {
            fluid: per_step(cost.fluid, scene.air.is_some()),
            coupling: per_step(cost.coupling, scene.coupling.is_some()),
            cloth: per_step(cost.cloth, scene.body.is_some()),
            other: per_step(cost.measure, true),
        },
        stop: StopInfo {
            reason,
            when_s: simulation.time_s(),
        },
        skipped: plan
            .skips
            .iter()
            .map(|s| format!("{}: {}", s.what, s.why))
            .collect(),
        notes,
        results: results(simulation, record),
    }
}
