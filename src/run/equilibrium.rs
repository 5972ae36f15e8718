//! The static equilibrium at the end of a run.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{INTERRUPTED, Observer, Run, RunError};
use crate::solve::lbfgs::{Progress, Stop};

/// Resolution of the progress that is reported.
const PARTS: u64 = 1000;

impl Run<'_> {
    /// Seeks the equilibrium if the case asks for it; returns why the run ended.
    ///
    /// An interrupt saves the state reached; resumed, the minimiser starts anew from there.
    pub(super) fn equilibrate(
        &mut self,
        interrupt: &AtomicBool,
        observer: &mut dyn Observer,
    ) -> Result<String, RunError> {
        let tolerance = self
            .case
            .scene
            .equilibrium
            .map_or(1.0, |equilibrium| equilibrium.tolerance);
        let mut watch = |progress: &Progress| {
            // The norm falls roughly by a constant factor per iteration.
            let share = progress.relative_norm.ln() / tolerance.ln();
            let status = format!(
                "equilibrium: energy norm {:.1e} of the loads', {tolerance:.0e} asked for, {} evaluations",
                progress.relative_norm, progress.evaluations
            );
            observer.progress(
                (share.clamp(0.001, 1.0) * PARTS as f64) as u64,
                PARTS,
                &status,
            );
            !interrupt.load(Ordering::Relaxed)
        };
        let Some(result) = self.simulation.equilibrate(&mut watch) else {
            return Ok("end time reached".to_owned());
        };
        let outcome = result?;
        if outcome.stop == Stop::Interrupted {
            self.save()?;
            return Ok(INTERRUPTED.to_owned());
        }
        let text = format!(
            "equilibrium: {} after {} iterations and {} evaluations, energy norm {:.3e}",
            match outcome.stop {
                Stop::Converged | Stop::RoundOff => "reached",
                Stop::Stalled => "STALLED before its tolerance",
                Stop::LimitReached => "NOT reached within evaluation_limit",
                Stop::NotFinite => "not finite",
                Stop::Indefinite => "NOT reached: the preconditioner is not positive there",
                Stop::Interrupted => "interrupted",
            },
            outcome.iterations,
            outcome.evaluations,
            outcome.energy_norm
        );
        observer.note(&text);
        if outcome.stop != Stop::Converged {
            self.unbalanced = true;
            let placement = &self.simulation.plan().placement;
            let remedy = match outcome.stop {
                Stop::Stalled if placement.cloth_on_device() => {
                    "a device computes forces in f32, which may not reach equilibrium.tolerance: use --cloth host, or raise it"
                }
                Stop::Stalled => "raise equilibrium.tolerance",
                Stop::Indefinite => {
                    "the mesh or the materials defeat the multigrid cycle: avoid slivers and jumps of stiffness, and report the case"
                }
                _ => "raise equilibrium.evaluation_limit or its tolerance",
            };
            self.notes.push(format!(
                "the results are those of a state out of balance: {remedy}"
            ));
        }
        self.sample(observer)?;
        Ok(text)
    }
}
