//! How the air passes along the surfaces of a scene, for the report.

use std::fmt::Write;

use crate::case::Scene;
use crate::case::coupling::Friction;

/// Writes the friction of every part, if the air sticks to some only.
pub(super) fn write(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let Some(friction) = &scene.friction else {
        return Ok(());
    };
    if !friction.has(Friction::None) && !friction.has(Friction::Model) {
        return Ok(());
    }
    writeln!(out, "\nfriction")?;
    let layers = match friction.transition_reynolds {
        0.0 => "turbulent from their front on".to_owned(),
        reynolds => format!("turbulent from Re = {reynolds:.3e} of the run on"),
    };
    let mut part = |name: &str, friction: Friction| match friction {
        Friction::None => writeln!(out, "  {name:<20}none: the air slides"),
        Friction::Model => writeln!(out, "  {name:<20}model of boundary layers, {layers}"),
        Friction::NoSlip => writeln!(out, "  {name:<20}the air sticks: the cells hold its layers"),
    };
    if let Some(tunnel) = scene.wing().and_then(|wing| wing.tunnel.as_ref()) {
        part("panels and tips", tunnel.friction)?;
        part("ribs, diagonals", tunnel.inner_friction)?;
    } else {
        for own in [Friction::None, Friction::Model, Friction::NoSlip] {
            if friction.fabric.contains(&own) {
                part("fabric", own)?;
            }
        }
    }
    for (body, own) in scene.rigid_bodies.iter().zip(&friction.bodies) {
        part(&body.name, *own)?;
    }
    Ok(())
}
