//! How many steps of the air a step of the fabric spans.

use std::fmt::{self, Write};

use crate::case::Scene;

/// Motion of a marker between two solves of the fabric beyond which the coupling is no longer trusted [cells].
pub const MARKER_MOTION_LIMIT: f64 = 0.25;

/// What the plan chooses. Measured (`ripstop bench coupling`, docs/coupling.md): the quietest, as cheap as 2 and cheaper than 4 or 10, and alone
/// exact in momentum.
const CHOSEN: u32 = 1;

/// Steps of the air per step of the fabric, at most: what the case asks for, or what the plan chooses.
#[must_use]
pub fn structure_every(scene: &Scene) -> u32 {
    let coupling = scene.coupling.as_ref();
    coupling.and_then(|c| c.structure_every).unwrap_or(CHOSEN)
}

/// Says it with the reason, for a scene with air and fabric.
pub(super) fn write(out: &mut String, scene: &Scene) -> fmt::Result {
    let (Some(air), Some(coupling)) = (&scene.air, &scene.coupling) else {
        return Ok(());
    };
    let every = structure_every(scene);
    let motion = f64::from(every) * air.wind_or_reference_m_s() / air.units.speed_m_s();
    let steps = if every == 1 { "step" } else { "steps" };
    let origin = match coupling.structure_every {
        Some(_) => "asked for",
        None => "chosen: quietest, exact in momentum, none cheaper",
    };
    writeln!(out, "  structure every     {every} {steps} ({origin})")?;
    let consequence = match (every, motion > MARKER_MOTION_LIMIT) {
        (_, false) => "allowed are",
        (1, true) => "lower resolution.lattice_speed: allowed are",
        (_, true) => "fewer steps are taken while it moves farther than",
    };
    writeln!(
        out,
        "  motion in them      {motion:.3} cells for a sheet as fast as the wind; {consequence} {MARKER_MOTION_LIMIT}"
    )
}
