//! Integration in time: what velocities and accelerations of a step count from.
//!
//! Both schemes find the velocity v and the force F at the end of a step, so that they have the same objective with other constants,
//!
//! v = (x − x̂)/h,  M (v − v̂)/h = F:
//!
//! * backward Euler has h = dt, x̂ = xⁿ and v̂ = vⁿ. It is of first order, and takes 1 − exp(−2πω dt) of an oscillation's energy per period;
//! * BDF2, the backward differences of second order, has h = dt (1 + r)/(1 + 2r) and x̂ = xⁿ + r²/(1 + 2r) (xⁿ − xⁿ⁻¹), v̂ alike, r being the step
//!   over the one before (Hairer, Nørsett & Wanner, "Solving Ordinary Differential Equations I", III.5). It takes 1 − exp(−π (ω dt)³) per period.
//!   Like backward Euler it forgets at once what is far stiffer than the step (L-stable). It is stable up to r = 1 + √2.
//!
//! A step that has no step before it, or one that is more than 2.2 times as long, is one of backward Euler: one such step does not lower the order. It takes
//! (ω dt)² of the energy, so that a motion without air begins with short ones ([`FIRST_PARTS`]).
//! Positions between two steps of BDF2 are not xⁿ + dt v.

use std::borrow::Cow;

use glam::DVec3;

use super::loads::StepInput;
use crate::cloth::{Structure, TimeIntegration};

/// Parts of a first step of BDF2 without air, as shares of it: the first, of backward Euler, takes a hundredth of the energy per period that a whole one does.
pub const FIRST_PARTS: [f64; 4] = [0.125, 0.125, 0.25, 0.5];

/// Longest step over the one before that BDF2 takes; its limit is 1 + √2.
const LARGEST_RATIO: f64 = 2.2;

/// Where a structure was a step before.
#[derive(Debug, Clone, PartialEq)]
pub struct StepBefore {
    /// Positions at the start of that step [m], `[node_count]`.
    pub positions_m: Vec<DVec3>,
    /// Velocities there [m/s], `[node_count]`.
    pub velocities_m_s: Vec<DVec3>,
    /// Length of that step [s].
    pub time_step_s: f64,
}

impl StepBefore {
    /// r of a step of `time_step_s`; `None` where it is too long for BDF2.
    fn ratio(&self, time_step_s: f64) -> Option<f64> {
        let ratio = time_step_s / self.time_step_s;
        (ratio <= LARGEST_RATIO).then_some(ratio)
    }
}

/// Error of a step's positions over what they differ from by the trapezoidal rule, xⁿ + ½ dt (vⁿ + vⁿ⁺¹), for a step of `time_step_s` after `before`.
///
/// Backward Euler errs by ½ dt |vⁿ⁺¹ − vⁿ|, which is that difference. BDF2 errs by C dt³ |x‴|, C = (1 + r)²/(6 r (1 + 2r)), the rule by dt³ |x‴|/12.
#[must_use]
pub fn error_over_difference(
    integration: TimeIntegration,
    before: Option<&StepBefore>,
    time_step_s: f64,
) -> f64 {
    before
        .filter(|_| integration == TimeIntegration::Bdf2)
        .and_then(|before| before.ratio(time_step_s))
        .map_or(1.0, |r| {
            let constant = (1.0 + r).powi(2) / (6.0 * r * (1.0 + 2.0 * r));
            constant / (constant - 1.0 / 12.0)
        })
}

/// r²/(1 + 2r) and h of a step of BDF2 of so many nodes; `None` where it is one of backward Euler.
fn by_bdf2(before: Option<&StepBefore>, nodes: usize, input: &StepInput) -> Option<(f64, f64)> {
    let before = before.filter(|before| before.positions_m.len() == nodes)?;
    let dt = (input.time_step_s).filter(|_| input.integration == TimeIntegration::Bdf2)?;
    let ratio = before.ratio(dt)?;
    let twice = 1.0 + 2.0 * ratio;
    Some((ratio * ratio / twice, dt * (1.0 + ratio) / twice))
}

/// Momentum that a step over dt gives the nodes that can move, from velocities at its start to those at its end [m/s]: M (v − v̂) dt/h, which is F dt [kg m/s].
///
/// The change of M v is another, by up to half of what the last step gives.
pub(super) fn momentum_given_kg_m_s(
    structure: &Structure,
    [start, end]: [&[DVec3]; 2],
    before: Option<&StepBefore>,
    input: &StepInput,
) -> DVec3 {
    let Some(dt) = input.time_step_s else {
        return DVec3::ZERO;
    };
    let bdf2 = by_bdf2(before, start.len(), input).zip(before);
    let free = structure.held.iter().zip(&structure.masses_kg).enumerate();
    free.filter(|(_, (held, _))| !**held)
        .map(|(node, (_, mass))| {
            let change = end[node] - start[node];
            *mass
                * match bdf2 {
                    None => change,
                    Some(((share, h), before)) => {
                        let earlier = start[node] - before.velocities_m_s[node];
                        (change - earlier * share) * (dt / h)
                    }
                }
        })
        .sum()
}

/// What velocities and accelerations of a step count from.
#[derive(Debug, Clone)]
pub struct StepBase<'a> {
    /// Positions at the start of the step xⁿ [m], `[node_count]`.
    pub start_m: &'a [DVec3],
    /// x̂ [m], `[node_count]`.
    pub positions_m: Cow<'a, [DVec3]>,
    /// v̂ [m/s], `[node_count]`.
    pub velocities_m_s: Cow<'a, [DVec3]>,
    /// Share of the last step by which x̂ and v̂ lie beyond xⁿ and vⁿ, r²/(1 + 2r); 0 in a step of backward Euler.
    pub share: f64,
    /// h [s]; `None` in the static limit.
    pub time_step_s: Option<f64>,
}

impl<'a> StepBase<'a> {
    /// Of a step from these positions [m] and velocities [m/s], both `[node_count]`.
    #[must_use]
    pub fn new(
        [start_m, velocities_m_s]: [&'a [DVec3]; 2],
        before: Option<&StepBefore>,
        input: &StepInput,
    ) -> Self {
        let backward_euler = Self {
            start_m,
            positions_m: Cow::Borrowed(start_m),
            velocities_m_s: Cow::Borrowed(velocities_m_s),
            share: 0.0,
            time_step_s: input.time_step_s,
        };
        let bdf2 = by_bdf2(before, start_m.len(), input).zip(before);
        let Some(((share, h), before)) = bdf2 else {
            return backward_euler;
        };
        let beyond = |now: &[DVec3], before: &[DVec3]| -> Vec<DVec3> {
            let pairs = now.iter().zip(before);
            pairs
                .map(|(now, before)| *now + (*now - *before) * share)
                .collect()
        };
        Self {
            start_m,
            positions_m: Cow::Owned(beyond(start_m, &before.positions_m)),
            velocities_m_s: Cow::Owned(beyond(velocities_m_s, &before.velocities_m_s)),
            share,
            time_step_s: Some(h),
        }
    }

    /// What acts, over h in place of the step.
    #[must_use]
    pub fn input<'b>(&self, input: &StepInput<'b>) -> StepInput<'b> {
        StepInput {
            time_step_s: self.time_step_s,
            ..*input
        }
    }

    /// Where the minimisation starts \[m\]: every node that is not held goes on without forces, supports are where they are to be. H₀ is built
    /// there too, which for long steps of drapes halves the evaluations against the old positions.
    #[must_use]
    pub fn prediction(&self, structure: &Structure, input: &StepInput) -> Vec<DVec3> {
        let mut point = self.start_m.to_vec();
        if let Some(h) = self.time_step_s {
            for (node, x) in point.iter_mut().enumerate() {
                if !structure.held[node] {
                    *x = self.positions_m[node] + self.velocities_m_s[node] * h;
                }
            }
        }
        for &(node, place) in input.moved_supports {
            let node = node as usize;
            if structure.held[node] {
                point[node] = place;
            }
        }
        point
    }

    /// Velocity of a node that ends the step at `point_m` [m/s]; zero in the static limit.
    #[must_use]
    pub fn velocity_m_s(&self, node: usize, point_m: DVec3) -> DVec3 {
        self.time_step_s
            .map_or(DVec3::ZERO, |h| (point_m - self.positions_m[node]) / h)
    }
}
