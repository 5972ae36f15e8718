//! `resolution.shift_cells`: the same case, with all that stands in the air moved against the lattice by parts of a cell.

use glam::DVec3;

use super::Problem;
use super::file::{File, MotionTable};
use super::scene::{Air, Body, BodyKind, readable};
use super::wing::Wing;

/// The key.
const KEY: &str = "resolution.shift_cells";

/// How far everything is moved [m]; zero without the key.
pub(super) fn check(file: &File, air: Option<&Air>) -> Result<DVec3, Problem> {
    let written = file.resolution.as_ref().and_then(|r| r.shift_cells);
    let (Some(cells), Some(air)) = (written, air) else {
        return Ok(DVec3::ZERO);
    };
    if file.structure.is_none() && file.bodies.is_empty() {
        return Err(Problem::new(
            KEY,
            format!("{KEY} has no effect: the case has neither a structure nor a body to move"),
            format!("remove {KEY}"),
        ));
    }
    if !cells.iter().all(|cell| cell.abs() < 1.0) {
        return Err(Problem::new(
            KEY,
            format!(
                "{KEY} = [{}] is out of range",
                cells.map(readable).join(", ")
            ),
            "each part of a cell lies between -1 and 1: further on the lattice is the same again",
        ));
    }
    Ok(DVec3::from_array(cells) * air.units.cell_size_m)
}

/// Moves a structure with what holds and guides it.
pub(super) fn move_structure(by_m: DVec3, body: Option<&mut Body>, wing: Option<&mut Wing>) {
    if let Some(body) = body {
        for place in &mut body.structure.positions_m {
            *place += by_m;
        }
        for guide in &mut body.structure.guides {
            guide.anchor_m += by_m;
        }
        if let BodyKind::Plate(plate) = &mut body.kind {
            plate.held_edge_m += by_m;
        }
    }
    for place in wing
        .and_then(|wing| wing.tunnel.as_mut())
        .into_iter()
        .flat_map(|tunnel| &mut tunnel.designed_m)
    {
        *place += by_m;
    }
}

/// The file with its rigid bodies moved, and the centres of their motions and the points of their moments with them.
pub(super) fn with_moved_bodies(file: &File, by_m: DVec3) -> File {
    let moved = |place: [f64; 3]| (DVec3::from_array(place) + by_m).to_array();
    let centre = |place: &mut Option<[f64; 3]>| *place = place.map(moved);
    let mut file = file.clone();
    for body in file.bodies.values_mut() {
        body.position_m = moved(body.position_m);
        if let Some(reference) = &mut body.reference {
            centre(&mut reference.moment_point_m);
        }
        if let Some(MotionTable {
            constant_rotation,
            oscillation,
            table,
            ..
        }) = &mut body.motion
        {
            if let Some(given) = constant_rotation {
                centre(&mut given.centre_m);
            }
            if let Some(given) = oscillation {
                centre(&mut given.centre_m);
            }
            if let Some(given) = table {
                centre(&mut given.centre_m);
            }
        }
    }
    file
}
