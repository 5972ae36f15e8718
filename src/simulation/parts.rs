//! Stage `solve_cloth` with its transfers, part by part ([`super::Adaptive`]).

use glam::DVec3;

use super::adaptive::{Adaptive, Verdict};
use super::{Failure, Simulation};
use crate::cpu::cloth::Cloth;

/// Root mean square over the mass of the change of velocity of nodes that can move [m/s].
fn change_of_velocity_m_s(cloth: &Cloth, before_m_s: &[DVec3]) -> f64 {
    let structure = &cloth.structure;
    let (mut sum, mut mass) = (0.0, 0.0);
    for (node, (now, before)) in cloth.velocities_m_s.iter().zip(before_m_s).enumerate() {
        if !structure.held[node] {
            sum += structure.masses_kg[node] * now.distance_squared(*before);
            mass += structure.masses_kg[node];
        }
    }
    if mass > 0.0 { (sum / mass).sqrt() } else { 0.0 }
}

impl Simulation {
    /// Parts of steps; `None` where every step is one solve.
    #[must_use]
    pub const fn adaptive(&self) -> Option<&Adaptive> {
        self.adaptive.as_ref()
    }

    /// Stage `solve_cloth` with its transfers, part by part.
    pub(super) fn solve_in_parts(&mut self, mut adaptive: Adaptive) -> Result<(), Failure> {
        let step_s = self.scene.time.map_or(0.0, |time| time.step_s);
        let start_s = self.time_s();
        let smallest = 1_u64 << adaptive.settings.halvings;
        let part_s = |parts: u64| step_s * (parts as f64 / smallest as f64);
        let mut done = 0;
        while done < smallest {
            let length = smallest >> adaptive.halvings;
            let before = self.structure_state();
            self.place_supports(start_s + part_s(done + length));
            let part_s = part_s(length);
            let outcome = self.solve_part(part_s, adaptive.initial_hessian(part_s))?;
            let error_m = self.cloth.as_ref().map_or(0.0, |cloth| {
                0.5 * part_s * change_of_velocity_m_s(cloth, &before.velocities_m_s)
            });
            let verdict = adaptive.judge(outcome.stop, error_m);
            if let (Verdict::Refused(halvings), Some(cloth)) = (verdict, &mut self.cloth) {
                before.put_back(cloth);
                adaptive.halvings += halvings;
                adaptive.most_halvings = adaptive.most_halvings.max(adaptive.halvings);
                continue;
            }
            self.finite(Some(&outcome))?;
            self.settle_solve();
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
