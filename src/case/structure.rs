//! The structure of a case: `[structure]`, one kind each, and what all kinds have in common.

use glam::DVec3;

use super::body::{Body, BodyKind, HangingCable};
use super::cable_material::check_material;
use super::fabric::{check_fabric, check_permeability};
use super::file::{self, File, Structure};
use super::mesh_examination::FromFiles;
use super::problem::Problem;
use super::values::{positive, vector, within};
use super::{canopy, contact, lep_sim, mesh, plate, specimens, wing};
use crate::geometry::{cable, sheet};

/// Most cells of a sheet: some 5 GB.
const SHEET_CELL_LIMIT: usize = 4_000_000;

/// Builds the structure of a case, if it has one; what is known of meshes of others is kept with the files.
pub(super) fn check(
    file: &File,
    files: &mut FromFiles,
    gravity: Option<DVec3>,
) -> Result<Option<Body>, Problem> {
    wing::check_loads(file)?;
    let Some(written) = &file.structure else {
        return Ok(None);
    };
    let mut body = build(file, written, files, gravity)?;
    body.structure.permeability = check_permeability(file)?;
    let moves = file.time.is_some() || file.air.is_some();
    body.structure.check(moves).map_err(|fault| {
        Problem::new(
            "structure",
            format!("the structure cannot be solved: {fault} (numbers count from 0)"),
            "mend the mesh or the lengths, or hold the node",
        )
    })?;
    contact::check(file, &mut body)?;
    Ok(Some(body))
}

/// Builds a structure of its kind.
fn build(
    file: &File,
    written: &Structure,
    files: &mut FromFiles,
    gravity: Option<DVec3>,
) -> Result<Body, Problem> {
    match written {
        Structure::FlatCircular(table) => canopy::flat_circular(file, table),
        Structure::Conical(table) => canopy::conical(file, table),
        Structure::Slotted(table) => canopy::slotted(file, table),
        Structure::ExtendedSkirt(table) => canopy::extended_skirt(file, table),
        Structure::Annular(table) => canopy::annular(file, table),
        Structure::DiskGapBand(table) => canopy::disk_gap_band(file, table),
        Structure::Cruciform(table) => canopy::cruciform(file, table),
        Structure::Sheet(table) => check_sheet(file, table),
        Structure::Plate(table) => plate::check(table, &check_fabric(file)?),
        Structure::Cable(table) => check_cable(table, gravity),
        Structure::Mesh(table) => mesh::check(file, table, files),
        Structure::LepSim(table) => lep_sim::check(file, table, files),
        Structure::Airbag(table) => specimens::check_airbag(table, &check_fabric(file)?),
        Structure::Disc(table) => specimens::check_disc(table, &check_fabric(file)?),
        Structure::Coupon(table) => specimens::check_coupon(table, &check_fabric(file)?),
        Structure::Wing(table) => {
            let (wing, structure) = wing::check(file, table, files.folder)?;
            Ok(Body::at_rest(structure, BodyKind::Wing(Box::new(wing))))
        }
    }
}

fn check_sheet(file: &File, written: &file::Sheet) -> Result<Body, Problem> {
    const KEY: &str = "structure.sheet";
    let key = |name: &str| format!("{KEY}.{name}");
    let fabric = check_fabric(file)?;
    for size in written.size_m {
        positive(&key("size_m"), size)?;
    }
    let [across, down] = written.divisions;
    let in_range = |n: usize| (1..=5_000).contains(&n);
    if !in_range(across) || !in_range(down) || across * down > SHEET_CELL_LIMIT {
        return Err(Problem::new(
            key("divisions"),
            format!(
                "{} = {:?} is out of range",
                key("divisions"),
                written.divisions
            ),
            format!("allowed are 1 to 5000 cells along each side, and {SHEET_CELL_LIMIT} in all"),
        ));
    }
    let hung_width_m = within(
        &key("hung_width_m"),
        written.hung_width_m,
        0.05 * written.size_m[0],
        written.size_m[0],
    )?;
    let shape = sheet::SheetShape {
        size_m: written.size_m,
        divisions: written.divisions,
        corner_m: vector(&key("corner_m"), written.corner_m)?,
        across: DVec3::X,
        down: -DVec3::Z,
    };
    let mut structure = sheet::build(&shape, &fabric, written.model).ok_or_else(|| {
        Problem::new(
            key("divisions"),
            "the cells of the spring network are too elongated for this shear modulus: a spring would push on its own",
            "make the cells squarer, or use model = \"membrane\"",
        )
    })?;
    let positions = structure.positions_m.clone();
    let [width, height] = written.size_m;
    // Gather the width in a smooth bulge, so that the start is neither flat nor torn.
    let ratio = hung_width_m / width;
    let bulge = width * (0.5 * (1.0 - ratio * ratio)).max(0.0).sqrt() / std::f64::consts::PI;
    for (place, rest) in structure.positions_m.iter_mut().zip(&positions) {
        let s = (rest.x - shape.corner_m.x) / width;
        let t = (shape.corner_m.z - rest.z) / height;
        *place = DVec3::new(
            shape.corner_m.x + s * hung_width_m,
            rest.y + bulge * (std::f64::consts::PI * s).sin() * (1.0 + 0.2 * t),
            rest.z,
        );
    }
    for corner in [shape.node(0, 0), shape.node(written.divisions[0], 0)] {
        structure.held[corner as usize] = true;
    }
    Ok(Body::new(structure, &positions, BodyKind::Sheet))
}

fn check_cable(written: &file::HangingCable, gravity: Option<DVec3>) -> Result<Body, Problem> {
    const KEY: &str = "structure.cable";
    let material = check_material(&format!("{KEY}.material"), &written.material)?;
    let ends = [
        vector(&format!("{KEY}.ends_m"), written.ends_m[0])?,
        vector(&format!("{KEY}.ends_m"), written.ends_m[1])?,
    ];
    let span_m = ends[0].distance(ends[1]);
    let length_m = positive(&format!("{KEY}.length_m"), written.length_m)?;
    if length_m <= span_m {
        return Err(Problem::new(
            format!("{KEY}.length_m"),
            format!("a cable of {length_m} m does not reach over {span_m} m"),
            "make the cable longer than the distance of its ends",
        ));
    }
    if !(2..=100_000).contains(&written.segments) {
        return Err(Problem::new(
            format!("{KEY}.segments"),
            format!("{KEY}.segments = {} is out of range", written.segments),
            "allowed are 2 to 100000 segments",
        ));
    }
    let weight_n_m = material.mass_per_length_kg_m() * gravity.map_or(0.0, DVec3::length);
    Ok(Body {
        structure: cable::build(ends, length_m, written.segments, &material),
        quality: None,
        kind: BodyKind::Cable(HangingCable {
            span_m,
            length_m,
            weight_n_m,
        }),
    })
}
