//! Phase `equilibrium`: the structure at rest.

use super::PARTS;
use super::stand::Next;
use crate::run::keeping::Sought;
use crate::run::{Observer, Run, RunError};
use crate::solve::lbfgs::{Progress, Stop};

impl Run<'_> {
    /// Seeks the equilibrium. An interrupt saves the state reached; resumed, the minimiser starts anew from there.
    pub(super) fn seek_equilibrium(
        &mut self,
        observer: &mut dyn Observer,
    ) -> Result<Next, RunError> {
        if self.pause(observer)? {
            return Ok(Next::Interrupted);
        }
        let tolerance = self
            .case
            .scene
            .equilibrium
            .map_or(1.0, |equilibrium| equilibrium.tolerance);
        let mut keeping = self.keep(Sought::Equilibrium)?;
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
            keeping.goes_on(progress, observer)
        };
        self.whole = false;
        let result = self.statics.equilibrate(&mut self.simulation, &mut watch);
        self.kept(keeping)?;
        let Some(result) = result else {
            return Ok(Next::Phase);
        };
        let outcome = result?;
        if outcome.stop == Stop::Interrupted {
            self.save()?;
            return Ok(Next::Interrupted);
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
        let on_device = self.simulation.plan().placement.cloth_on_device();
        let remedy = match outcome.stop {
            Stop::Converged | Stop::RoundOff => None,
            Stop::Stalled if on_device => Some(
                "a device computes forces in f32, which may not reach equilibrium.tolerance: use --cloth host, or raise it",
            ),
            Stop::Stalled => Some("raise equilibrium.tolerance"),
            Stop::Indefinite => Some(
                "the mesh or the materials defeat the multigrid cycle: avoid slivers and jumps of stiffness, and report the case",
            ),
            _ => Some("raise equilibrium.evaluation_limit or its tolerance"),
        };
        let out_of_balance = remedy
            .map(|remedy| format!("the results are those of a state out of balance: {remedy}"));
        self.settle_balance(text, out_of_balance, observer)
    }
}
