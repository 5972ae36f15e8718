//! The wind at the inlet that is not the same everywhere: `[air.faces.inlet]`.

use super::file::{self, BoxSide, Inlet};
use super::problem::Problem;
use super::usual;
use super::values::{at_once, positive, readable, within};
use crate::geometry::table::lookup;
use crate::lattice::grid::{Faces, InletProfile, Sides, Wall};

/// Exponent of the power law of a turbulent boundary layer (Prandtl; Schlichting).
const USUAL_EXPONENT: f64 = 1.0 / 7.0;

/// Largest distance of a table [m].
const FARTHEST_M: f64 = 1e6;

/// Largest ratio of a table: beyond it the speed of the wind is hardly the one that coefficients should refer to.
const LARGEST_RATIO: f64 = 3.0;

/// Checks `[air.faces.inlet]` of a box of `cells`; `None` where the wind is the same everywhere.
pub(super) fn check_inlet(
    air: &file::Air,
    cells: [usize; 3],
    cell_size_m: f64,
    sides: Sides,
) -> Result<Option<InletProfile>, Problem> {
    let Some(inlet) = air.faces.as_ref().and_then(|faces| faces.inlet.as_ref()) else {
        return Ok(None);
    };
    if air.descent.is_some() {
        return Err(Problem::new(
            "air.faces.inlet",
            "the box of [air.descent] falls through air at rest: its wind is the same everywhere",
            "remove [air.faces.inlet]",
        ));
    }
    let size_m = cells.map(|n| n as f64 * cell_size_m);
    let middle_m = |cell: usize| (cell as f64 + 0.5) * cell_size_m;
    let profile = match inlet {
        Inlet::BoundaryLayer(layer) => {
            const TABLE: &str = "air.faces.inlet.boundary_layer";
            let thickness_m = positive(&format!("{TABLE}.thickness_m"), layer.thickness_m)?;
            let exponent = usual::or(format!("{TABLE}.exponent"), layer.exponent, USUAL_EXPONENT);
            at_once(|| within(&format!("{TABLE}.exponent"), exponent, 0.01, 1.0))?;
            let sides = usual::or(format!("{TABLE}.sides"), layer.sides.clone(), sticky(sides));
            if sides.is_empty() {
                return Err(Problem::new(
                    format!("{TABLE}.sides"),
                    "the boundary layer has no side to lie on: no side of the tunnel is \"no_slip\"",
                    format!(
                        "add {TABLE}.sides, such as [\"z_lower\"], or make a side of [air.faces] \"no_slip\""
                    ),
                ));
            }
            InletProfile::new(cells, |y, z| {
                let distance_m = sides
                    .iter()
                    .map(|side| side.distance_m(size_m, [middle_m(y), middle_m(z)]))
                    .fold(f64::INFINITY, f64::min);
                (distance_m / thickness_m).min(1.0).powf(exponent)
            })
        }
        Inlet::Table(table) => {
            const KEY: &str = "air.faces.inlet.table.points";
            let points = &table.points;
            let rise = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            if points.len() < 2 || !rise {
                return Err(Problem::new(
                    KEY,
                    format!(
                        "{KEY} needs two pairs or more of [distance in m, ratio], the distances rising"
                    ),
                    "distances are those from the lower side, y = 0 or z = 0",
                ));
            }
            for [distance_m, ratio] in points {
                at_once(|| within(KEY, *distance_m, 0.0, FARTHEST_M))?;
                at_once(|| within(KEY, *ratio, 0.0, LARGEST_RATIO))?;
            }
            InletProfile::new(cells, |y, z| {
                let place_m = match table.along {
                    file::Across::Y => middle_m(y),
                    file::Across::Z => middle_m(z),
                };
                lookup(points, place_m)
            })
        }
    };
    if profile.mean() <= 0.0 {
        return Err(Problem::new(
            "air.faces.inlet",
            "air.faces.inlet lets no air in: all ratios are 0",
            "give ratios to air.wind_tunnel.speed_m_s, 1 where the wind has that speed",
        ));
    }
    Ok(Some(profile))
}

/// Refuses a wind that is too fast for the lattice where the profile is fastest.
pub(super) fn refuse_too_fast(
    profile: &InletProfile,
    lattice_speed: f64,
    limit: f64,
) -> Result<(), Problem> {
    let fastest = profile.largest() * lattice_speed;
    if fastest <= limit {
        return Ok(());
    }
    Err(Problem::new(
        "air.faces.inlet",
        format!(
            "the wind at the inlet is {} cells per step where it is fastest, more than {limit}",
            readable((fastest * 1e3).round() / 1e3)
        ),
        "lower resolution.lattice_speed, or the ratios",
    ))
}

/// Sides to which the air sticks.
fn sticky(sides: Sides) -> Vec<BoxSide> {
    let Sides::Each([y, z]) = sides else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (faces, names) in [
        (y, [BoxSide::YLower, BoxSide::YUpper]),
        (z, [BoxSide::ZLower, BoxSide::ZUpper]),
    ] {
        if let Faces::Walls(walls) = faces {
            for (wall, name) in walls.into_iter().zip(names) {
                if matches!(wall, Wall::NoSlip { .. }) {
                    found.push(name);
                }
            }
        }
    }
    found
}
