//! The sides of the air's box: `[air.faces]`.

use super::file;
use super::problem::Problem;
use super::usual;
use crate::lattice::grid::{Faces, Sides, Wall};

/// Checks `[air.faces]` of a tunnel; `falls` for that of a descent.
pub(super) fn check_sides(air: &file::Air, falls: bool) -> Result<Sides, Problem> {
    let written = air.faces.clone().unwrap_or_default();
    let usual_side = usual::or("air.faces.sides", written.sides, file::Side::Absorbing);
    let of = |axis: &str, [lower, upper]: [Option<file::Side>; 2]| {
        let lower = usual::or(format!("air.faces.{axis}_lower"), lower, usual_side);
        let upper = usual::or(format!("air.faces.{axis}_upper"), upper, usual_side);
        let key = |end: &str| format!("air.faces.{axis}_{end}");
        match [lower, upper] {
            [file::Side::Periodic, file::Side::Periodic] => return Ok(Faces::Periodic),
            [file::Side::Periodic, _] | [_, file::Side::Periodic] => {
                return Err(Problem::new(
                    key("lower"),
                    format!(
                        "{} and {} differ, and one of them is periodic: a box repeats at both ends of an axis or at none",
                        key("lower"),
                        key("upper")
                    ),
                    "make both of them \"periodic\", or neither",
                ));
            }
            _ => {}
        }
        if falls && [lower, upper].contains(&file::Side::NoSlip) {
            return Err(Problem::new(
                "air.faces",
                "walls to which the air sticks stand still, but the box of [air.descent] falls",
                "allowed are \"absorbing\", \"frictionless\", \"symmetry\" and \"periodic\"",
            ));
        }
        Ok(Faces::Walls([lower, upper].map(wall)))
    };
    Ok(Sides::Each([
        of("y", [written.y_lower, written.y_upper])?,
        of("z", [written.z_lower, written.z_upper])?,
    ]))
}

/// Refuses `[air.faces]` where there are no sides.
pub(super) fn refuse_faces(air: &file::Air) -> Result<(), Problem> {
    match air.faces {
        None => Ok(()),
        Some(_) => Err(Problem::new(
            "air.faces",
            "Taylor–Green vortices fill a box that repeats: it has no faces",
            "remove [air.faces]",
        )),
    }
}

const fn wall(side: file::Side) -> Wall {
    match side {
        file::Side::Absorbing => Wall::Absorbing,
        file::Side::NoSlip => Wall::AT_REST,
        // Both ends periodic was told apart before.
        file::Side::Frictionless | file::Side::Symmetry | file::Side::Periodic => Wall::FreeSlip,
    }
}
