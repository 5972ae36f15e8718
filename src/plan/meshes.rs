//! What the meshes of others in a case are made of, for `ripstop check`.

use std::fmt::Write;

use crate::case::ExaminedMesh;
use crate::case::mesh_examination::Heading;

/// Borders whose lengths are told one by one.
const TOLD_BORDERS: usize = 4;

/// Pieces whose triangles are told one by one.
const TOLD_PIECES: usize = 6;

/// All meshes as text.
#[must_use]
pub fn report(meshes: &[ExaminedMesh]) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut text, meshes);
    text
}

pub(super) fn write(out: &mut String, meshes: &[ExaminedMesh]) -> std::fmt::Result {
    for mesh in meshes {
        write_mesh(out, mesh)?;
    }
    Ok(())
}

fn write_mesh(out: &mut String, mesh: &ExaminedMesh) -> std::fmt::Result {
    let examination = &mesh.examination;
    writeln!(out, "\nmesh: {} ({})", mesh.file, mesh.key)?;
    if let Some(weld) = mesh.weld {
        writeln!(
            out,
            "  joined              {} vertices to others within {} m; {} triangles collapsed and were dropped",
            weld.joined, weld.tolerance_m, weld.collapsed
        )?;
        if weld.inserted > 0 {
            writeln!(
                out,
                "  sewn                {} vertices inserted into edges of the other side of their seam",
                weld.inserted
            )?;
        }
    }
    if let Some(count) = mesh.oriented {
        writeln!(
            out,
            "  turned              {count} triangles, so that those of each piece run alike"
        )?;
    }
    let sizes: Vec<String> = (examination.pieces.iter())
        .take(TOLD_PIECES)
        .map(|piece| piece.triangles.len().to_string())
        .collect();
    let count = examination.pieces.len();
    writeln!(
        out,
        "  pieces              {count}, of {}{} triangles ({} nodes in all)",
        sizes.join(", "),
        if count > TOLD_PIECES { ", ..." } else { "" },
        examination.node_count
    )?;
    writeln!(out, "  open borders        {}", borders(mesh))?;
    let mut measures = vec![format!("area {} m2", short(examination.area_m2))];
    measures.extend(mesh.mass_kg.map(|mass| format!("mass {} kg", short(mass))));
    measures.extend(
        mesh.volume_m3
            .map(|volume| format!("volume {} m3", short(volume))),
    );
    writeln!(out, "  measures            {}", measures.join(", "))?;
    let [x, y, z] = examination.size_m.to_array().map(short);
    let against = mesh
        .nominal_diameter_m
        .map_or_else(String::new, |diameter| {
            format!(" (D_0 = {} m)", short(diameter))
        });
    writeln!(out, "  size                {x} x {y} x {z} m{against}")?;
    if let Some(heading) = &mesh.heading {
        writeln!(out, "  opening             {}", opening(heading))?;
    }
    if examination.findings.is_empty() {
        writeln!(out, "  findings            none")?;
    }
    for finding in &examination.findings {
        let standing = if mesh.is_told_only {
            "told"
        } else if mesh.accepted.contains(&finding.kind) {
            "accepted"
        } else {
            "REFUSED"
        };
        writeln!(
            out,
            "  {standing:<9} {:<19} {}",
            finding.kind.name(),
            finding.what
        )?;
    }
    for kind in mesh.accepted_in_vain() {
        writeln!(
            out,
            "  accepted  {:<19} but there is none: remove it from accept",
            kind.name()
        )?;
    }
    Ok(())
}

/// Where the opening faces, and what would turn it into the wind.
fn opening(heading: &Heading) -> String {
    let plain = |value: f64| format!("{:.2}", value + 0.0).replace("-0.00", "0.00");
    let [x, y, z] = heading.direction.to_array().map(plain);
    let faces = format!("faces ({x}, {y}, {z})");
    if !heading.is_odd() {
        return format!("{faces}, {:.0} deg off the wind", heading.off_wind_deg);
    }
    let (axis, angle_deg) = heading.rotation;
    let [x, y, z] = axis.to_array().map(|c| (1e4 * c).round() / 1e4 + 0.0);
    format!(
        "{faces}, {:.0} deg off the wind, which blows along +x; rotation = {{ axis = [{x:?}, {y:?}, {z:?}], angle_deg = {angle_deg:.1} }} turns it there",
        heading.off_wind_deg
    )
}

fn borders(mesh: &ExaminedMesh) -> String {
    let borders = &mesh.examination.borders;
    let lengths_m: Vec<f64> = borders.iter().map(|border| border.length_m).collect();
    match lengths_m[..] {
        [] => "none: the surface is closed".to_owned(),
        [only_m] => format!("1, {} m long", short(only_m)),
        _ if lengths_m.len() <= TOLD_BORDERS => {
            let told: Vec<String> = lengths_m.iter().map(|length| short(*length)).collect();
            format!("{}, {} m long", lengths_m.len(), told.join(", "))
        }
        [longest_m, .., shortest_m] => format!(
            "{}, {} to {} m long, {} m in all",
            lengths_m.len(),
            short(longest_m),
            short(shortest_m),
            short(lengths_m.iter().sum())
        ),
    }
}

/// Four digits, whatever the size.
fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&value.abs()) {
        let decimals = (3.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}
