//! What the steps of the fabric will cost: evaluations of a solve, as far as they can be told before a run.
//!
//! Measured on the shipped canopies over winds of 1 to 30 m/s and stiffnesses of 0.1 to 100 times their own
//! (docs/results/2026-11-26-motion-of-fabric.md): they follow the elements that a stretching wave crosses in a step, and whether the fabric is taut.

use std::fmt::{self, Write};

use super::Placement;
use super::initial_hessian::elements_crossed;
use crate::case::Scene;
use crate::case::scene::{BodyKind, Carrier};

/// Evaluations of a solve whatever the step.
const AT_LEAST: f64 = 6.0;

/// Elements crossed up to which taut fabric needs no more than those.
const TAUT_FROM: f64 = 10.0;

/// Evaluations per element crossed of taut fabric, beyond.
const TAUT: f64 = 4.5;

/// Evaluations per square of the elements crossed of fabric that is folded or hangs loose.
const SLACK: f64 = 0.3;

/// Elements crossed from which slack fabric is stiffened step by step on the host, which takes about so many evaluations whatever the step
/// (`src/cpu/cloth/driver.rs`; 7, 33 and 72 measured at 39, 59 and 117 elements).
const STIFFENED_FROM: f64 = 34.0;
const STIFFENED: f64 = 25.0;

/// Evaluations of a device before it leaves such a step to the host (`src/cpu/cloth/driver.rs`; 334 and 365 in all were measured where the host alone took
/// 33 and 72).
const BEFORE_LEAVING: f64 = 300.0;

/// The forecast of these may err by more.
const STIFFENED_FACTOR: f64 = 4.0;

/// Drag coefficient of a canopy that has reached its terminal speed, from which its longest steps are told.
const DRAG_COEFFICIENT: f64 = 0.75;

/// The forecast may err by so much either way.
const FACTOR: f64 = 3.0;

/// Evaluations of a solve of the fabric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evaluations {
    /// Nothing is known beforehand, and why.
    Unknown(&'static str),
    /// About so many, within a factor of three.
    About {
        /// Evaluations of the longest step.
        evaluations: f64,
        /// Elements that a stretching wave crosses in it.
        crossed: f64,
        /// Whether fabric that is folded or loose was reckoned with.
        slack: bool,
        /// By how much the forecast may err either way.
        factor: f64,
    },
}

/// Whether the steps of slack fabric are so long that its stiffening is raised step by step, which only the host does: a device would leave them all to it.
#[must_use]
pub fn steps_are_left_to_host(scene: &Scene) -> bool {
    let Some(crossed) = elements_crossed(scene) else {
        return false;
    };
    scene.air.is_some() && is_slack(scene) && is_stiffened(crossed * slowing(scene))
}

fn is_stiffened(crossed: f64) -> bool {
    crossed > STIFFENED_FROM
}

/// Whether the fabric is folded or loose when it is released.
fn is_slack(scene: &Scene) -> bool {
    scene.body.as_ref().is_some_and(|body| match &body.kind {
        BodyKind::Canopy(canopy) => canopy.loading.is_some(),
        BodyKind::Sheet => true,
        // A flag lies along the wind.
        BodyKind::Plate(plate) => plate.along.x.abs() > 0.5,
        _ => false,
    })
}

/// The forecast for a scene; `None` without fabric or without time steps.
pub(super) fn of(scene: &Scene, placement: &Placement) -> Option<Evaluations> {
    let body = scene.body.as_ref()?;
    let crossed = elements_crossed(scene)?;
    if scene.air.is_none() {
        return Some(Evaluations::Unknown(
            "without air it depends on how slack the fabric becomes",
        ));
    }
    if body.structure.contact.is_some() {
        return Some(Evaluations::Unknown(
            "with contact it depends on how often fabric meets itself",
        ));
    }
    let slack = is_slack(scene);
    let crossed = crossed * slowing(scene);
    let is_stiffened = slack && is_stiffened(crossed);
    let factor = if is_stiffened {
        STIFFENED_FACTOR
    } else {
        FACTOR
    };
    let evaluations = if is_stiffened && placement.cloth_on_device() {
        BEFORE_LEAVING + STIFFENED
    } else if is_stiffened {
        STIFFENED
    } else if slack {
        AT_LEAST + SLACK * crossed * crossed
    } else if crossed <= TAUT_FROM {
        AT_LEAST
    } else {
        TAUT * crossed
    };
    Some(Evaluations::About {
        evaluations,
        crossed,
        slack,
        factor,
    })
}

/// By how much the steps of a fall grow, as they follow its speed: speed at release over terminal speed, at least 1.
fn slowing(scene: &Scene) -> f64 {
    let (Some(air), Some(descent), Some(body)) = (&scene.air, &scene.descent, &scene.body) else {
        return 1.0;
    };
    let (Carrier::Confluence { .. }, BodyKind::Canopy(canopy)) = (descent.carrier, &body.kind)
    else {
        return 1.0;
    };
    let weight_n = descent.all_masses_kg() * descent.gravity_m_s2;
    let drag_area_m2 = DRAG_COEFFICIENT * canopy.nominal_area_m2;
    let terminal_m_s = (2.0 * weight_n / (air.units.density_kg_m3 * drag_area_m2)).sqrt();
    (air.wind_or_reference_m_s() / terminal_m_s).max(1.0)
}

impl Evaluations {
    /// A warning where a solve will hardly reach its tolerance within so many evaluations.
    #[must_use]
    pub fn warning(&self, limit: usize) -> Option<String> {
        let Self::About {
            evaluations,
            factor,
            ..
        } = *self
        else {
            return None;
        };
        (evaluations > limit as f64 / factor).then(|| {
            let verb = if evaluations > limit as f64 {
                "will"
            } else {
                "may"
            };
            format!(
                "steps of the fabric want about {evaluations:.0} evaluations and solver.evaluation_limit is {limit}: solves {verb} miss their \
                 tolerance, and such a run ends with exit code 20; raise solver.evaluation_limit, lower resolution.lattice_speed, or soften what \
                 is stiff"
            )
        })
    }

    /// The forecast as a line of the report.
    pub(super) fn write(&self, out: &mut String, limit: usize) -> fmt::Result {
        match *self {
            Self::Unknown(why) => writeln!(out, "  evaluations         not known: {why}"),
            Self::About {
                evaluations,
                crossed,
                slack,
                factor,
            } => {
                let fabric = if slack {
                    "fabric that is folded or loose"
                } else {
                    "taut fabric"
                };
                writeln!(
                    out,
                    "  evaluations         about {evaluations:.0} per step of the fabric, within a factor of {factor:.0} (a stretching wave crosses \
                     {crossed:.1} elements in the longest, {fabric}); at most {limit}"
                )
            }
        }
    }

    /// Evaluations of a step that a duration is reckoned with; `None` where nothing is known.
    pub(super) const fn per_step(&self, limit: usize) -> Option<f64> {
        match *self {
            Self::Unknown(_) => None,
            Self::About { evaluations, .. } => Some(evaluations.min(limit as f64)),
        }
    }
}
