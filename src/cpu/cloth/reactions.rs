//! Part of stage `solve_cloth`: all that the air does to the structure in a step.

use glam::DVec3;

use super::cut_reactions::CutSums;
use super::loads::StepInput;
use super::marker_sums::MarkerSums;
use super::{Cloth, permeable};
use crate::cloth::Structure;

/// Adds all but those of cut links at `point`, with velocities (x − x̂)/dt, to the gradient [N]; returns their part of the objective [J].
pub(super) fn add_reactions(
    structure: &Structure,
    sums: &MarkerSums,
    (base, dt): (&[DVec3], f64),
    input: &StepInput,
    point: &[DVec3],
    gradient: &mut [DVec3],
) -> f64 {
    let mut value = 0.0;
    for drag in input.drags {
        let node = drag.node as usize;
        let slip = (point[node] - base[node]) / dt - drag.air_velocity_m_s;
        value += 0.5 * dt * drag.coefficient_kg_s * slip.length_squared();
        gradient[node] += slip * drag.coefficient_kg_s;
    }
    value += permeable::add_reactions(structure, base, dt, input, point, gradient);
    value + sums.add_reactions([base, point], dt, gradient)
}

impl Cloth {
    /// Forces of the air on every node at the present velocities \[N\], `[node_count]`: with the velocities at the end of a step those that it was solved with.
    #[must_use]
    pub fn forces_of_the_air_n(&self, input: &StepInput) -> Vec<DVec3> {
        let rest = vec![DVec3::ZERO; self.structure.node_count()];
        let mut forces = rest.clone();
        let sums = MarkerSums::new(&self.structure, input);
        let cuts = CutSums::new(&self.structure, &self.prepared.gather, input);
        // Displacements in a unit of time are velocities.
        let base = (&rest[..], 1.0);
        let velocities = &self.velocities_m_s;
        add_reactions(&self.structure, &sums, base, input, velocities, &mut forces);
        cuts.add_reactions([&rest, velocities], 1.0, &mut forces);
        for force in &mut forces {
            *force = -*force;
        }
        forces
    }
}
