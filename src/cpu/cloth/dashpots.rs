//! Axial damping of cables: over one implicit step, the dissipation ½ dt c/L (n·Δv)² between the ends, with the direction n at the start of
//! the step; cables that are slack there have none. Forces are equal and opposite along n, and can only take energy out.

use glam::{DMat3, DVec3};

use super::initial_hessian::outer;
use crate::cloth::Structure;

/// Damping of one cable segment during one step.
#[derive(Debug, Clone, Copy)]
pub struct Dashpot {
    /// Ends.
    pub nodes: [u32; 2],
    /// From the first end to the second, at the start of the step.
    pub direction: DVec3,
    /// c/(L dt) [N/m].
    pub stiffness_n_m: f64,
}

/// Those of a step of `time_step_s` that starts at `positions`.
#[must_use]
pub fn dashpots(
    structure: &Structure,
    positions: &[DVec3],
    time_step_s: Option<f64>,
) -> Vec<Dashpot> {
    let Some(dt) = time_step_s else {
        return Vec::new();
    };
    let damped = structure.cables.iter().filter(|c| c.damping_n_s > 0.0);
    damped
        .filter_map(|cable| {
            let [a, b] = cable.nodes.map(|n| positions[n as usize]);
            let length = a.distance(b);
            (length > cable.rest_length_m).then(|| Dashpot {
                nodes: cable.nodes,
                direction: (b - a) / length,
                stiffness_n_m: cable.damping_n_s / (cable.rest_length_m * dt),
            })
        })
        .collect()
}

impl Dashpot {
    /// Dissipation of a step from `start` to `point` [J], and the gradient at the second end [N]; the opposite at the first.
    #[must_use]
    pub fn energy_and_gradient(&self, start: &[DVec3], point: &[DVec3]) -> (f64, DVec3) {
        let [a, b] = self.nodes.map(|n| n as usize);
        let stretch = ((point[b] - start[b]) - (point[a] - start[a])).dot(self.direction);
        (
            0.5 * self.stiffness_n_m * stretch * stretch,
            self.direction * (self.stiffness_n_m * stretch),
        )
    }

    /// Hessian at one of the ends [N/m].
    #[must_use]
    pub fn block(&self) -> DMat3 {
        outer(self.direction, self.direction) * self.stiffness_n_m
    }
}
