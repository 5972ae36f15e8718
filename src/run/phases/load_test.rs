//! Phase `load_test`: the loads of the equilibrium several times over.

use super::stand::Next;
use crate::case::wing::Wing;
use crate::measure::{self, LineName};
use crate::run::keeping::Sought;
use crate::run::outputs::Lacking;
use crate::run::{Observer, Run, RunError};
use crate::solve::lbfgs::Progress;
use crate::statics::{LoadStep, LoadTestPart};

impl Run<'_> {
    /// Raises the loads step by step. An interrupted one is begun anew when the run goes on.
    pub(super) fn test_loads(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        let scene = &self.case.scene;
        let (Some(wing), Some(body)) = (scene.wing(), &scene.body) else {
            return Ok(Next::Phase);
        };
        let Some(asked) = &wing.load_test else {
            return Ok(Next::Phase);
        };
        let names = measure::line_names(wing, &body.structure);
        let steps = asked.load_factors.len() as u64;
        let last = asked.load_factors.last().copied().unwrap_or(1.0);
        loop {
            if self.pause(observer)? {
                return Ok(Next::Interrupted);
            }
            let mut keeping = self.keep(Sought::Part)?;
            let Some(test) = self.statics.load_test(scene, &self.simulation) else {
                self.notes
                    .push("no load test was done: there are no loads of an equilibrium".to_owned());
                return Ok(Next::Phase);
            };
            let done = (test.steps.len() as u64).min(steps);
            let mut watch = |progress: &Progress| {
                let status = format!(
                    "load test: step {done} of {steps}, fabric's energy norm {:.1e} of the loads', {} evaluations",
                    progress.relative_norm, progress.evaluations
                );
                observer.progress(done, steps, &status);
                keeping.goes_on(progress, observer)
            };
            self.whole = false;
            let part = test.advance(scene, &mut self.simulation, &mut watch)?;
            self.kept(keeping)?;
            let Some(test) = &self.statics.load_test else {
                return Ok(Next::Phase);
            };
            match part {
                LoadTestPart::Loaded => {
                    if let Some(step) = test.steps.last() {
                        observer.note(&line(wing, &names, step));
                        if step.load_factor == last {
                            let drawn = self.files.loaded_wing(&self.simulation, last);
                            self.spare(&Lacking::File("the loaded wing"), drawn, observer)?;
                        }
                    }
                }
                LoadTestPart::Interrupted => {
                    self.save()?;
                    return Ok(Next::Interrupted);
                }
                LoadTestPart::Ended => {
                    let missed = test.steps.iter().filter(|step| !step.is_balanced());
                    let missed: Vec<f64> = missed.map(|step| step.load_factor).collect();
                    if !missed.is_empty() {
                        self.stand.unbalanced = true;
                        self.notes.push(format!(
                            "the load test is not in balance at load factors {missed:?}: lower equilibrium.tolerance, or raise equilibrium.evaluation_limit"
                        ));
                    }
                    return Ok(Next::Phase);
                }
            }
            self.whole = true;
        }
    }
}

/// A step in a line.
fn line(wing: &Wing, names: &[LineName], step: &LoadStep) -> String {
    let reading = measure::read_load_step(wing, step);
    let nearest = reading.nearest.as_ref().map_or_else(
        || "breaking loads are not told".to_owned(),
        |n| {
            let breaks = if n.share >= 1.0 {
                ", which breaks; it is computed as if it held"
            } else {
                ""
            };
            format!(
                "nearest to breaking {} at {:.2}{breaks}",
                names[n.cable].text(),
                n.share
            )
        },
    );
    let rows: Vec<String> = wing
        .built
        .row_names
        .iter()
        .zip(&reading.row_loads_n)
        .map(|(name, load)| format!("{name} {load:.0}"))
        .collect();
    let stress = reading.stresses.iter().map(|s| s.1).fold(0.0, f64::max);
    format!(
        "load factor {:>5.2}: risers {:.0} N (rows {} N), {nearest}; largest stress {:.1} MPa, projected area {:.3} m2, guide {:.1} N, risers lack {:.1e}, {} evaluations",
        step.load_factor,
        reading.riser_forces_n.iter().sum::<f64>(),
        rows.join(", "),
        1e-6 * stress,
        reading.projected_area_m2,
        step.guide_n,
        step.balance_error,
        step.evaluations
    )
}
