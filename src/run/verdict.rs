//! Whether the results of a run are those of its case.

use super::Run;
use crate::plan::{Phase, phases};
use crate::simulation::LAST;

impl Run<'_> {
    /// What an interrupted run was looking for; `None` where it marched in time, which leaves means of what there was.
    pub(super) fn sought(&self) -> Option<&'static str> {
        match phases(&self.case.scene, &self.case.coarser).get(self.stand.phase_under_way())? {
            Phase::Equilibrium => Some("an equilibrium"),
            Phase::Trim => Some("a trim"),
            Phase::PanelShaping => Some("the shape of the panels"),
            Phase::LoadTest => Some("the end of the load test"),
            Phase::OpenCanopy
            | Phase::RaiseWind
            | Phase::March { .. }
            | Phase::ChangeLattice { .. } => None,
        }
    }

    /// What is not in balance at the end: the static equilibrium, or the steps of the fabric, unless the case allows those.
    pub(super) fn out_of_balance(&self) -> Option<String> {
        if self.stand.unbalanced {
            return Some("the static equilibrium was not reached".to_owned());
        }
        let account = self.simulation.solver_account();
        let allowed = self.simulation.scene().solver.allow_unsolved;
        (account.out_of_balance() && !allowed).then(|| {
            format!(
                "{} of {} solves of the fabric missed their tolerance, up to {:.1} % of 1000 in a row, {} of the last {LAST}: \
                 raise solver.evaluation_limit, lower resolution.lattice_speed or time.step_s, or soften what is stiff \
                 (solver.allow_unsolved = true takes the results as they are)",
                account.unsolved(),
                account.solves(),
                100.0 * account.worst_share(),
                account.unsolved_at_end(),
            )
        })
    }
}
