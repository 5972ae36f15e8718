//! Checks of `[time]`.

use super::air::{Air, Flow};
use super::file::{self, File};
use super::problem::Problem;
use super::usual;
use super::values::{absent, positive};
use crate::cloth::TimeIntegration;

/// Most times that a step is halved.
const HALVING_LIMIT: u32 = 30;

/// Most steps of a run.
const STEP_LIMIT: f64 = 1e9;

/// Simulated time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Time {
    /// End [s].
    pub end_s: f64,
    /// Step of the structure (without air) or of the air [s].
    pub step_s: f64,
    /// How the fabric's motion is integrated; first order where there is no fabric.
    pub integration: TimeIntegration,
    /// Divides steps as accuracy asks for; `None`: every step is solved at once.
    pub adaptive: Option<AdaptiveStep>,
}

/// Steps of the fabric that choose their own length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveStep {
    /// Error of positions allowed in one solve, root mean square over the mass [m].
    pub tolerance_m: f64,
    /// How often a step may be halved.
    pub halvings: u32,
}

impl AdaptiveStep {
    /// Shortest part of a step \[s\].
    #[must_use]
    pub fn smallest_s(&self, step_s: f64) -> f64 {
        step_s / (1_u64 << self.halvings) as f64
    }
}

/// Checks `[time]`.
pub(super) fn check(file: &File, air: Option<&Air>) -> Result<Option<Time>, Problem> {
    let Some(time) = &file.time else {
        return if air.is_some() {
            Err(absent("time.end_s", "air needs an end time"))
        } else {
            Ok(None)
        };
    };
    let end_s = positive("time.end_s", time.end_s)?;
    let step_s = match (air, time.step_s) {
        (Some(air), None) => usual::noted("time.step_s", air.units.time_step_s),
        (None, Some(step)) => positive("time.step_s", step)?,
        (Some(_), Some(_)) => {
            return Err(Problem::new(
                "time.step_s",
                "with air the time step follows from cell size and lattice speed",
                "remove time.step_s",
            ));
        }
        (None, None) => {
            return Err(absent(
                "time.step_s",
                "without air the structure needs a time step",
            ));
        }
    };
    let start_s = match air.map(|a| &a.flow) {
        Some(Flow::WindTunnel { start_time_s, .. }) => *start_time_s,
        _ => 0.0,
    };
    if (end_s + start_s) / step_s > STEP_LIMIT {
        return Err(Problem::new(
            "time.end_s",
            format!(
                "the run would take {:.1e} steps of {step_s:.3e} s",
                (end_s + start_s) / step_s
            ),
            format!("at most {STEP_LIMIT:.0e} are allowed: lower time.end_s or the start time"),
        ));
    }
    let adaptive = time
        .adaptive
        .as_ref()
        .map(|written| check_adaptive(written, step_s, air.is_some()))
        .transpose()?;
    let integration = check_integration(time.integration, file.structure.is_some())?;
    Ok(Some(Time {
        end_s,
        step_s,
        integration,
        adaptive,
    }))
}

fn check_integration(
    written: Option<TimeIntegration>,
    has_fabric: bool,
) -> Result<TimeIntegration, Problem> {
    const KEY: &str = "time.integration";
    match (written, has_fabric) {
        (None, true) => Ok(usual::or(KEY, written, TimeIntegration::Bdf2)),
        (Some(written), true) => Ok(written),
        (None, false) => Ok(TimeIntegration::default()),
        (Some(_), false) => Err(Problem::new(
            KEY,
            "it is the fabric's motion that is integrated so, and there is no [structure]",
            format!("remove {KEY}"),
        )),
    }
}

fn check_adaptive(
    written: &file::AdaptiveSteps,
    step_s: f64,
    in_air: bool,
) -> Result<AdaptiveStep, Problem> {
    const KEY: &str = "time.adaptive";
    if in_air {
        return Err(Problem::new(
            KEY,
            "with air the fabric takes the steps of the air",
            "remove [time.adaptive]",
        ));
    }
    let key = format!("{KEY}.smallest_step_s");
    let smallest_s = positive(&key, written.smallest_step_s)?;
    // A power of two may be rounded down.
    let halvings = (step_s / smallest_s).log2() + 1e-9;
    if !(0.0..=f64::from(HALVING_LIMIT)).contains(&halvings) {
        return Err(Problem::new(
            key.as_str(),
            format!("{key} = {smallest_s:e} does not suit time.step_s = {step_s:e}"),
            format!(
                "allowed are {:.0e} to {step_s:e} s: a step is halved {HALVING_LIMIT} times at most",
                step_s / (1_u64 << HALVING_LIMIT) as f64
            ),
        ));
    }
    Ok(AdaptiveStep {
        tolerance_m: positive(&format!("{KEY}.tolerance_m"), written.tolerance_m)?,
        halvings: halvings as u32,
    })
}
