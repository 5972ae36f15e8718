//! Stage `solve_cloth` with its transfers, part by part ([`super::Adaptive`]).

use super::adaptive::{Adaptive, Verdict};
use super::{Failure, Simulation, StructureState};
use crate::cloth::TimeIntegration;
use crate::cpu::cloth::Cloth;
use crate::cpu::cloth::integration::{FIRST_PARTS, error_over_difference};

/// Error of a part's positions, root mean square over the mass of nodes that can move [m].
fn error_m(
    cloth: &Cloth,
    before: &StructureState,
    (integration, part_s): (TimeIntegration, f64),
) -> f64 {
    let structure = &cloth.structure;
    let (mut sum, mut mass) = (0.0, 0.0);
    for node in (0..structure.node_count()).filter(|&node| !structure.held[node]) {
        let way = cloth.positions_m[node] - before.positions_m[node];
        let speeds = cloth.velocities_m_s[node] + before.velocities_m_s[node];
        sum += structure.masses_kg[node] * (way - speeds * (0.5 * part_s)).length_squared();
        mass += structure.masses_kg[node];
    }
    let difference = if mass > 0.0 { (sum / mass).sqrt() } else { 0.0 };
    difference * error_over_difference(integration, before.step_before.as_ref(), part_s)
}

impl Simulation {
    /// Parts of steps; `None` where every step is one solve.
    #[must_use]
    pub const fn adaptive(&self) -> Option<&Adaptive> {
        self.adaptive.as_ref()
    }

    /// True in the first step of a motion without air that is integrated by BDF2: it has no step before it.
    pub(super) fn starts_in_parts(&self) -> bool {
        let integration = self.scene.time.map(|time| time.integration);
        let alone = self.scene.air.is_none() && self.adaptive.is_none();
        alone && integration == Some(TimeIntegration::Bdf2) && self.step == self.origin.step
    }

    /// Stage `solve_cloth` with its transfers in that step.
    pub(super) fn solve_first_parts(&mut self) -> Result<(), Failure> {
        let step_s = self.scene.time.map_or(0.0, |time| time.step_s);
        let mut time_s = self.time_s();
        for share in FIRST_PARTS {
            let part_s = share * step_s;
            time_s += part_s;
            self.begin_energy();
            self.place_supports_at_work(time_s);
            let outcome = self.solve_part(part_s, self.plan.step_hessian)?;
            self.finite(Some(&outcome))?;
            self.settle_solve();
            self.add_energy(1);
        }
        Ok(())
    }

    /// Stage `solve_cloth` with its transfers, part by part.
    pub(super) fn solve_in_parts(&mut self, mut adaptive: Adaptive) -> Result<(), Failure> {
        let time = self.scene.time;
        let step_s = time.map_or(0.0, |time| time.step_s);
        let integration = time.map(|time| time.integration).unwrap_or_default();
        let start_s = self.time_s();
        let smallest = 1_u64 << adaptive.settings.halvings;
        let part_s = |parts: u64| step_s * (parts as f64 / smallest as f64);
        let mut done = 0;
        while done < smallest {
            let length = smallest >> adaptive.halvings;
            let before = self.structure_state();
            let held_still = self.energy.clone();
            self.begin_energy();
            self.place_supports_at_work(start_s + part_s(done + length));
            let part_s = part_s(length);
            let outcome = self.solve_part(part_s, adaptive.initial_hessian(part_s))?;
            let cloth = self.cloth.as_ref();
            let error_m = cloth.map_or(0.0, |cloth| error_m(cloth, &before, (integration, part_s)));
            let verdict = adaptive.judge(outcome.stop, error_m);
            if let (Verdict::Refused(halvings), Some(cloth)) = (verdict, &mut self.cloth) {
                before.put_back(cloth);
                self.energy = held_still;
                // Risers, too, are as long as where the part began.
                self.place_supports(start_s + step_s * (done as f64 / smallest as f64));
                adaptive.halvings += halvings;
                adaptive.most_halvings = adaptive.most_halvings.max(adaptive.halvings);
                continue;
            }
            self.finite(Some(&outcome))?;
            self.settle_solve();
            self.add_energy(1);
            done += length;
            let longer_fits = adaptive.halvings > 0 && done.is_multiple_of(2 * length);
            if verdict == Verdict::Lengthened && longer_fits {
                adaptive.halvings -= 1;
            }
        }
        self.adaptive = Some(adaptive);
        Ok(())
    }
}
