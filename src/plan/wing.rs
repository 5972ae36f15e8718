//! What `ripstop check` tells of a wing.

use std::fmt::Write;

use glam::DVec3;

use super::wing_warnings;
use crate::aero::potential_flow;
use crate::case::Scene;
use crate::case::coupling::Scheme;
use crate::case::wing::{HeldName, LineKind, Profile, Side, Tunnel, Wing};
use crate::trim::Settings;
use crate::trim::skin::Skin;

/// Sizes, masses, parts, rows, and where the prescribed pressure pulls.
pub(super) fn write(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let (Some(wing), Some(body)) = (scene.wing(), &scene.body) else {
        return Ok(());
    };
    let measures = &wing.built.measures;
    writeln!(out, "\nwing")?;
    writeln!(
        out,
        "  flat                {:.3} m2, span {:.3} m, aspect ratio {:.3}",
        measures.flat_area_m2,
        measures.flat_span_m,
        measures.flat_aspect_ratio()
    )?;
    writeln!(
        out,
        "  projected           {:.3} m2, span {:.3} m, aspect ratio {:.3}",
        measures.projected_area_m2,
        measures.projected_span_m,
        measures.projected_aspect_ratio()
    )?;
    writeln!(
        out,
        "  mesh                {} edges along each side of a rib, {} across each of {} cells",
        wing.fineness.along_chord, wing.fineness.across_cell, wing.built.cells
    )?;
    if let Some(angle) = smallest_angle_deg(scene) {
        writeln!(out, "  smallest angle      {angle:.1} degrees")?;
    }
    for &(part, triangles, area, mass) in &measures.parts {
        writeln!(
            out,
            "  {:<19} {triangles} triangles, {area:.3} m2, {mass:.3} kg",
            part.name()
        )?;
    }
    writeln!(
        out,
        "  lines               {} with {:.2} m in all; with risers and tapes {:.3} kg",
        measures.lines, measures.line_length_m, measures.cable_mass_kg
    )?;
    for (row, name) in wing.built.row_names.iter().enumerate() {
        let of = |is: &dyn Fn(&LineKind) -> bool| {
            let cables = body.structure.cables.iter().zip(&wing.built.line_kinds);
            let lengths = cables.filter(|(_, kind)| is(kind));
            lengths.fold((0, 0.0), |(count, sum), (cable, _)| {
                (count + 1, sum + cable.rest_length_m)
            })
        };
        let (count, length) =
            of(&|kind| matches!(kind, LineKind::Line { row: r, .. } if *r == row));
        let (_, risers) = of(&|kind| matches!(kind, LineKind::Riser { row: r } if *r == row));
        writeln!(
            out,
            "    row {name:<13} {count} lines, {length:.2} m; riser {:.3} m",
            0.5 * risers
        )?;
    }
    if !wing.plan.rods.is_empty() {
        writeln!(out, "  rods                {:.3} kg", measures.rod_mass_kg)?;
    }
    for rod in &wing.plan.rods {
        let reach = |side: usize, name: &str| {
            let range = rod.sides[side];
            range.map(|[from, to]| format!("{from:.3} to {to:.3} {name}"))
        };
        let reach: Vec<String> = [reach(0, "above"), reach(1, "below")]
            .into_iter()
            .flatten()
            .collect();
        writeln!(
            out,
            "    rod {:<13} {} ribs from the middle to the tip, {} per chord; E I {:.2e} N m2, {:.2} g/m",
            rod.name,
            rod.ribs.len(),
            reach.join(", "),
            rod.flexural_rigidity_nm2,
            1e3 * rod.mass_per_length_kg_m
        )?;
    }
    for profile in &wing.plan.profiles {
        if let Profile::Points {
            nose_cut: Some(place),
            ..
        } = profile
        {
            writeln!(
                out,
                "  nose cut            ends at {place:.4} of the chord on the lower side"
            )?;
        }
    }
    if let Some(tunnel) = &wing.tunnel {
        write_tunnel(out, scene, (wing, tunnel))?;
    }
    if let Some(settings) = &wing.trim {
        write_trim(out, scene, (wing, settings))?;
    }
    if let Some(jumps_pa) = &wing.load_pa {
        let structure = &body.structure;
        let hang = structure.positions_m[wing.built.hang_points[0] as usize].with_y(0.0);
        let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for (triangle, jump) in structure.triangles.iter().zip(jumps_pa) {
            let places = triangle.nodes.map(|n| structure.positions_m[n as usize]);
            let pull = triangle.doubled_area_vector(&structure.positions_m) * (0.5 * jump);
            force += pull;
            moment += ((places[0] + places[1] + places[2]) / 3.0 - hang).cross(pull);
        }
        writeln!(
            out,
            "  prescribed pressure pulls with {:.1}, {:.1}, {:.1} N along x, y, z as designed,",
            force.x, force.y, force.z
        )?;
        writeln!(
            out,
            "                      along a line {:.3} m behind the points where the risers hang",
            -moment.y / force.z
        )?;
    }
    Ok(())
}

/// How a wing stands in the wind, and what of it the cells can resolve.
fn write_tunnel(
    out: &mut String,
    scene: &Scene,
    (wing, tunnel): (&Wing, &Tunnel),
) -> std::fmt::Result {
    let (Some(air), measures) = (&scene.air, &wing.built.measures) else {
        return Ok(());
    };
    let cell = air.units.cell_size_m;
    let held = match tunnel.held {
        HeldName::HangPoints => "its hang points are held",
        HeldName::Attachments => "hang points and attachments of lines are held",
        HeldName::Everything => "all of it is held: rigid",
    };
    let pitch = tunnel.pitch_rad.to_degrees();
    writeln!(
        out,
        "  in the wind         nose up {pitch:.1} degrees at the start; {held}"
    )?;
    for pull in &wing.pulls {
        let most = pull.points.iter().map(|p| p[1]).fold(0.0, f64::max);
        writeln!(
            out,
            "  hauled in           {} risers of row {} by up to {most:.3} m, until {:.3} s",
            pull.cables.len(),
            wing.built.row_names[pull.row],
            pull.end_s()
        )?;
    }
    let chord = measures.largest_chord_m;
    let rib = &wing.built.frames[wing.built.cells / 2];
    let thickness = (1..20)
        .map(|i| f64::from(i) / 20.0)
        .map(|x| {
            let height = |side| rib.height(&wing.built.profiles, side, x);
            height(Side::Upper) - height(Side::Lower)
        })
        .fold(0.0, f64::max);
    let width = measures.flat_span_m / wing.built.cells as f64;
    let reach = match scene.coupling.map(|coupling| coupling.scheme) {
        Some(Scheme::Links) => "",
        _ => "; the kernel reaches 2 on both sides of fabric",
    };
    writeln!(
        out,
        "  cells of air        {:.1} per chord, {:.1} across the thickest section, {:.1} across a cell{reach}",
        chord / cell,
        thickness * rib.chord_m / cell,
        width / cell
    )?;
    let section = air.section_m2();
    writeln!(
        out,
        "  blockage            flat area/section = {:.1} %, span/width = {:.1} %",
        100.0 * measures.flat_area_m2 / section,
        100.0 * measures.projected_span_m / (air.cells[1] as f64 * cell)
    )?;
    writeln!(
        out,
        "  Reynolds number     {:.2e} of the chord",
        air.wind_or_reference_m_s() * chord / air.kinematic_viscosity_m2_s
    )
}

/// Unknowns of the air and what they take.
fn write_trim(
    out: &mut String,
    scene: &Scene,
    (wing, settings): (&Wing, &Settings),
) -> std::fmt::Result {
    let skin = Skin::new(&wing.built, settings.panels_per_side, settings.strips);
    let (panels, strips) = (skin.panel_count(), skin.sections.len() - 1);
    writeln!(
        out,
        "  pilot               {} kg, drag area {} m2",
        settings.pilot_mass_kg, settings.pilot_drag_area_m2
    )?;
    let mass_kg = wing_warnings::flying_mass_kg(scene, settings);
    writeln!(
        out,
        "  in flight           {mass_kg:.2} kg with wing and lines, {:.2} kg per m2 of the flat area",
        mass_kg / wing.built.measures.flat_area_m2
    )?;
    writeln!(
        out,
        "  air of the trim     {panels} panels of the half wing, {strips} strips; matrix {:.1} MB",
        potential_flow::memory_bytes(panels, strips) as f64 / 1e6
    )?;
    let sections = &settings.sections;
    for (number, polar) in sections.polars.iter().enumerate() {
        writeln!(
            out,
            "  polar of profile {}   {}",
            number + 1,
            if polar.is_some() {
                "from the case, of the section as drawn: brakes count as a larger angle of attack, not as a turned trailing edge"
                    .to_owned()
            } else {
                let intakes = if sections.intake.is_some() {
                    " and of the intakes of open cells"
                } else {
                    ""
                };
                format!(
                    "computed at a Reynolds number of {:.1e}, drag of surface {}{intakes} added",
                    sections.reynolds, sections.surface_drag
                )
            }
        )?;
    }
    match settings.inside {
        Some(coefficient) => writeln!(
            out,
            "  pressure inside     {coefficient} of the dynamic one"
        ),
        None => writeln!(
            out,
            "  pressure inside     by the pressure along the intakes"
        ),
    }
}

fn smallest_angle_deg(scene: &Scene) -> Option<f64> {
    let structure = &scene.body.as_ref()?.structure;
    let angles = structure.triangles.iter().map(|t| {
        // Law of cosines over the squared rest lengths.
        let [a, b, c] = t.rest_squares_m2;
        let angle =
            |a: f64, b: f64, c: f64| ((b + c - a) / (2.0 * (b * c).sqrt())).clamp(-1.0, 1.0);
        angle(a, b, c).max(angle(b, c, a)).max(angle(c, a, b))
    });
    let largest_cosine = angles.fold(f64::NAN, f64::max);
    largest_cosine
        .is_finite()
        .then(|| largest_cosine.acos().to_degrees())
}
