//! What a scene lets pass, for the report.

use std::fmt::Write;

use crate::case::Scene;
use crate::case::coupling::Scheme;
use crate::fabric::permeability::{HALF_INCH_OF_WATER_PA, Permeability};
use crate::immersed::kernel::SUM_OF_SQUARES;

/// Writes what every permeable surface lets pass, beside what the residual slip of one pass of the kernel lets pass; at cut links there is none.
pub(super) fn write(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let (Some(air), Some(coupling)) = (&scene.air, &scene.coupling) else {
        return Ok(());
    };
    let fabric = scene
        .body
        .as_ref()
        .and_then(|body| body.structure.permeability);
    let bodies = scene
        .rigid_bodies
        .iter()
        .filter_map(|body| Some((body.name.as_str(), body.permeability?)));
    let all: Vec<(&str, Permeability)> = fabric
        .map(|p| ("fabric", p))
        .into_iter()
        .chain(bodies)
        .collect();
    if all.is_empty() {
        return Ok(());
    }
    writeln!(out, "\npermeability")?;
    let speed = air.wind_or_reference_m_s();
    let dynamic = 0.5 * air.units.density_kg_m3 * speed * speed;
    for (name, permeability) in all {
        writeln!(
            out,
            "  {name:<20}{:.3e} m/s at {HALF_INCH_OF_WATER_PA} Pa, {:.3e} m/s at the dynamic pressure of {speed} m/s",
            permeability.through_velocity_m_s(HALF_INCH_OF_WATER_PA),
            permeability.through_velocity_m_s(dynamic)
        )?;
    }
    if coupling.scheme == Scheme::Links {
        return Ok(());
    }
    let a = coupling.over_relaxation;
    let slip =
        (1.0 - SUM_OF_SQUARES * a) / (2.0 * a) / (air.units.density_kg_m3 * air.units.speed_m_s());
    writeln!(
        out,
        "  residual slip       {:.3e} m/s and {:.3e} m/s more (flat sheet, a = {a}): permeability of the method itself",
        slip * HALF_INCH_OF_WATER_PA,
        slip * dynamic
    )
}
