//! What falls, and the drag of lines, for the report.

use std::fmt::Write;

use crate::case::Scene;
use crate::case::scene::Carrier;

/// Writes what falls and with what the box follows it.
pub(super) fn write(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let Some(air) = &scene.air else {
        return Ok(());
    };
    if let Some(descent) = &scene.descent {
        writeln!(
            out,
            "\nfall (the box follows along -x, the air comes along +x)"
        )?;
        let carrier = match descent.carrier {
            Carrier::Confluence { .. } => "payload where the lines meet".to_owned(),
            Carrier::RigidBody { number, .. } => scene
                .rigid_bodies
                .get(number)
                .map_or_else(String::new, |body| format!("body {}", body.name)),
        };
        writeln!(
            out,
            "  mass                {} kg, {carrier}",
            descent.mass_kg
        )?;
        writeln!(
            out,
            "  air                 {:.4} kg/m3 all the way, gravity {} m/s2, speed at release {} m/s",
            air.units.density_kg_m3,
            descent.gravity_m_s2,
            air.wind_or_reference_m_s()
        )?;
        writeln!(
            out,
            "  time step           follows the speed of the air: steps and duration below are those of the speed at release"
        )?;
        if descent.drag_area_m2 > 0.0 {
            writeln!(
                out,
                "  drag area           {} m2 of the payload itself, not given to the air",
                descent.drag_area_m2
            )?;
        }
        for body in &descent.bodies {
            writeln!(
                out,
                "  {:<19} {} kg, drag area {} m2, on a tether of {} m",
                format!("body {}", body.name),
                body.mass_kg,
                body.drag_area_m2,
                scene.body.as_ref().map_or(f64::NAN, |of| {
                    of.structure.cables[body.tether].rest_length_m
                })
            )?;
        }
    }
    let cables = scene.body.iter().flat_map(|body| &body.structure.cables);
    let drags: Vec<_> = cables.filter_map(|cable| cable.drag).collect();
    if let Some(drag) = drags.first() {
        let diameters_mm = drags.iter().map(|drag| 1e3 * drag.diameter_m);
        let thinnest = diameters_mm.clone().fold(f64::INFINITY, f64::min);
        let thickest = diameters_mm.fold(0.0, f64::max);
        let diameters = if thickest - thinnest < 1e-6 {
            format!("{thickest:.2}")
        } else {
            format!("{thinnest:.2} to {thickest:.2}")
        };
        writeln!(out, "\ndrag of lines")?;
        writeln!(
            out,
            "  C_d, d              {}, {diameters} mm across the lines, undisturbed wind, not given to the air",
            drag.coefficient
        )?;
    }
    Ok(())
}
