//! Shipped cases, changed and run to their end, for the problems of fabric in the wind.

use std::path::Path;

use super::super::session::{Session, Stop};
use crate::case::{self, Case, Choices};
use crate::measure::{self, shared::TIME};
use crate::output::{ReadOut, Results};
use crate::plan::{Placement, Plan, Precision, steps_per};
use crate::simulation::{Failure, Simulation};
use crate::statics::Statics;

/// A shipped case with changes.
pub(super) fn case(
    name: &str,
    source: &str,
    variant: Option<&str>,
    changes: &[String],
) -> Result<Case, Stop> {
    let choices = Choices {
        variant: variant.map(str::to_owned),
        overrides: changes.to_vec(),
    };
    case::parse(name, source, Path::new("."), &choices)
        .map_err(|error| Stop::Refused(error.to_string()))
}

/// What a run showed.
pub(super) struct Outcome {
    /// Cells of the air.
    pub cells: [usize; 3],
    /// The named results; `None` where the run broke down.
    pub results: Option<Results>,
    /// The samples, also of a run that broke down.
    record: measure::Record,
}

impl Outcome {
    /// A result; not a number where there is none.
    pub fn value(&self, read_out: &ReadOut) -> f64 {
        let results = self.results.as_ref();
        results
            .and_then(|results| results.value(read_out))
            .unwrap_or(f64::NAN)
    }

    /// The samples of a column; none where the run broke down, so that nothing is read off its way there.
    pub fn column(&self, read_out: &ReadOut) -> Vec<f64> {
        let results = self.results.as_ref();
        results.map_or_else(Vec::new, |_| self.record.column(read_out))
    }

    /// Mean force along x over the second half of the run by three routes [N]: differences of impulses.
    pub fn forces(&self, impulses: [&ReadOut; 3]) -> [f64; 3] {
        let times = self.column(&TIME);
        let (first, last) = (times.len() / 2, times.len().saturating_sub(1));
        impulses.map(|column| {
            let impulse = self.column(column);
            match (impulse.get(first), impulse.get(last)) {
                (Some(then), Some(now)) => (now - then) / (times[last] - times[first]),
                _ => f64::NAN,
            }
        })
    }
}

/// Runs a case on the engine of the order.
pub(super) fn run(session: &mut Session, case: Case) -> Result<Outcome, Stop> {
    let placement = Placement {
        air: session.order.placement,
        ..Placement::from(Precision::F32)
    };
    let plan = Plan::new(&case.scene, placement);
    let (start, planned) = (plan.start_steps, plan.start_steps + plan.steps);
    let (Some(air), Some(_)) = (case.scene.air.clone(), case.scene.time) else {
        return Err(Stop::Refused("the case has no air".to_owned()));
    };
    let every = steps_per(&case.scene, case.scene.output.sample_interval_s);
    let failed = |failure| match failure {
        Failure::Device(error) => Stop::Device(error),
        other => Stop::Refused(other.to_string()),
    };
    let mut simulation =
        Simulation::new(case.scene, plan, session.order.device.clone()).map_err(failed)?;
    let mut record = measure::Record::new(&simulation);
    let updates = 1e-6 * air.updates_per_step();
    let done = session.done;
    let mut broke_down = false;
    while simulation.step_count() < planned {
        let step = simulation.step_count();
        if step.is_multiple_of(16) {
            session.check_interrupt()?;
            session.progress_to(done + updates * step as f64);
        }
        if step >= start && (step - start).is_multiple_of(every) {
            record.add(&mut simulation)?;
        }
        match simulation.advance_among_threads() {
            Err(Failure::Diverged(_)) => {
                broke_down = true;
                break;
            }
            advanced => advanced.map_err(failed)?,
        }
    }
    if !broke_down {
        record.add(&mut simulation)?;
    }
    Ok(Outcome {
        cells: air.cells,
        results: (!broke_down).then(|| measure::results(&simulation, &Statics::default(), &record)),
        record,
    })
}
