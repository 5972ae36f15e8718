//! Phase `trim`: the steady glide of a wing.

use super::PARTS;
use super::stand::Next;
use crate::case::Scene;
use crate::run::keeping::Sought;
use crate::run::{Observer, Run, RunError};
use crate::solve::lbfgs::Progress;
use crate::statics::{Trim, TrimEnd, TrimIteration, TrimPart};

impl Run<'_> {
    /// Seeks the trim, an outer iteration at a time. An interrupted one is begun anew when the run goes on.
    pub(super) fn seek_trim(&mut self, observer: &mut dyn Observer) -> Result<Next, RunError> {
        let scene = &self.case.scene;
        let Some(equilibrium) = scene.equilibrium else {
            return Ok(Next::Phase);
        };
        // What is done never becomes less.
        let mut done = 0;
        loop {
            if self.pause(observer)? {
                return Ok(Next::Interrupted);
            }
            // Before a checkpoint is prepared: that is of the mesh which the trim is on.
            self.statics.trim(scene, &mut self.simulation)?;
            let mut keeping = self.keep(Sought::Part)?;
            let trim = self.statics.trim(scene, &mut self.simulation)?;
            let number = trim.iterations.len();
            done = done.max((share_done(scene, trim) * PARTS as f64) as u64);
            let mut watch = |progress: &Progress| {
                observer.progress(
                    done,
                    PARTS,
                    &format!(
                        "trim: iteration {}, fabric's energy norm {:.1e} of the loads', {:.0e} asked for, {} evaluations",
                        number + 1,
                        progress.relative_norm,
                        equilibrium.tolerance,
                        progress.evaluations
                    ),
                );
                keeping.goes_on(progress, observer)
            };
            self.whole = false;
            let part = trim.advance(scene, &mut self.simulation, &mut watch)?;
            self.whole = true;
            if let (TrimPart::Iterated, Some(iteration)) = (&part, trim.iterations.last()) {
                observer.note(&line(iteration));
            }
            self.kept(keeping)?;
            let end = match part {
                TrimPart::Iterated | TrimPart::Refined => continue,
                TrimPart::Interrupted => {
                    self.save()?;
                    return Ok(Next::Interrupted);
                }
                TrimPart::Ended(end) => end,
            };
            let (reason, out_of_balance) = told(end, number);
            return self.settle_balance(reason, out_of_balance, observer);
        }
    }
}

/// How a trim ended, and why its results are not those of one.
fn told(end: TrimEnd, iterations: usize) -> (String, Option<String>) {
    match end {
        TrimEnd::Settled => (
            format!("trim: reached after {iterations} outer iterations"),
            None,
        ),
        TrimEnd::Moving(what) => (
            format!("trim: NOT reached within {iterations} outer iterations: {what}"),
            Some(format!(
                "the results are those of a wing that does not stand still yet: {what}; raise equilibrium.trim.iteration_limit or its tolerances, or lower its relaxation"
            )),
        ),
        TrimEnd::Refused(why) => (
            format!("trim: NOT reached: {why}"),
            Some(format!(
                "the results are not those of a trim, which was given up: {why}"
            )),
        ),
    }
}

/// How much of a trim is done, as far as can be told: meshes count by their nodes, and on each what still moves falls by a constant factor.
fn share_done(scene: &Scene, trim: &Trim) -> f64 {
    let (Some(wing), Some(body)) = (scene.wing(), &scene.body) else {
        return 0.0;
    };
    let mut nodes = vec![body.structure.node_count()];
    let mut finer = wing;
    while let Some(coarser) = &finer.coarser {
        nodes.push(coarser.structure.node_count());
        finer = &coarser.wing;
    }
    let over: usize = nodes[trim.coarser() + 1..].iter().sum();
    let here = nodes[trim.coarser()] as f64 * trim.share_done(wing.trim.as_ref());
    (over as f64 + here) / nodes.iter().sum::<usize>() as f64
}

/// An outer iteration in a line.
fn line(i: &TrimIteration) -> String {
    format!(
        "trim {:>2}, {} nodes: {:.3} m/s, sink {:.3} m/s, glide {:.3}, angle of attack {:.2} deg, pressure inside {:.2}, pitch {:.2} deg; turned by {:.3} deg, outlines moved {:.1e}, guide {:.1} N, risers lack {:.1e} of the weight, {} evaluations",
        i.number,
        i.nodes,
        i.speed_m_s,
        i.sink_m_s,
        i.glide_ratio,
        i.attack_rad.to_degrees(),
        i.inside,
        i.pitch_rad.to_degrees(),
        i.turn_rad.to_degrees(),
        i.shape_change,
        i.guide_n,
        i.balance_error,
        i.outcome.evaluations
    )
}
