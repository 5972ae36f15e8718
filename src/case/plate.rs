//! Checks of `[structure.plate]`.

use super::air::Air;
use super::body::{Body, BodyKind};
use super::file;
use super::problem::Problem;
use super::usual;
use super::values::{at_once, direction, positive, readable, vector};
use crate::fabric::Fabric;
use crate::geometry::plate::{self, Plate};

const KEY: &str = "structure.plate";

/// Most cells along a side.
const DIVISION_LIMIT: usize = 2_000;

/// Largest cosine of the angle between length and held edge.
const SKEW: f64 = 1e-6;

/// Least width of the rectangle of markers [cells].
const LEAST_WIDTH_CELLS: f64 = 2.0;

fn key(name: &str) -> String {
    format!("{KEY}.{name}")
}

pub(super) fn check(written: &file::Plate, fabric: &Fabric) -> Result<Body, Problem> {
    for size in written.size_m {
        at_once(|| positive(&key("size_m"), size))?;
    }
    let [along_count, across_count] = written.divisions;
    if !(2..=DIVISION_LIMIT).contains(&along_count) || !(1..=DIVISION_LIMIT).contains(&across_count)
    {
        return Err(Problem::new(
            key("divisions"),
            format!(
                "{} = {:?} is out of range",
                key("divisions"),
                written.divisions
            ),
            format!(
                "allowed are 2 to {DIVISION_LIMIT} cells along the length and 1 to {DIVISION_LIMIT} across it; about square ones are usual"
            ),
        ));
    }
    let (along, across) = (
        direction(&key("along"), written.along)?,
        direction(&key("across"), written.across)?,
    );
    if along.dot(across).abs() > SKEW {
        return Err(Problem::new(
            key("across"),
            format!(
                "{} = {:?} is not perpendicular to {} = {:?}",
                key("across"),
                written.across,
                key("along"),
                written.along
            ),
            "give the direction of the held edge, at a right angle to the length",
        ));
    }
    let solid_nm = fabric.rigidity_nm()[0][0];
    let flexural_rigidity_nm = match written.flexural_rigidity_nm {
        Some(given) => positive(&key("flexural_rigidity_nm"), given)?,
        None => {
            usual::noted(key("flexural_rigidity_nm"), solid_nm);
            solid_nm
        }
    };
    let shape = Plate {
        size_m: written.size_m,
        divisions: written.divisions,
        held_edge_m: vector(&key("held_edge_m"), written.held_edge_m)?,
        along,
        across: (across - along * along.dot(across)).normalize(),
        support: written.support,
        flexural_rigidity_nm,
    };
    let structure = plate::build(&shape, fabric).ok_or_else(|| {
        Problem::new(
            key("divisions"),
            format!("[{KEY}] has triangles without area"),
            "make the plate larger, or divide it less",
        )
    })?;
    Ok(Body::at_rest(structure, BodyKind::Plate(shape)))
}

/// Refuses a plate that the cells are too coarse for, with its markers' rim `inset_cells` inside its own.
pub(super) fn check_cells(plate: &Plate, air: &Air, inset_cells: f64) -> Result<(), Problem> {
    let narrow = plate.size_m[0].min(plate.size_m[1]);
    let cells = narrow / air.units.cell_size_m;
    let least = LEAST_WIDTH_CELLS + 2.0 * inset_cells;
    if cells >= least {
        return Ok(());
    }
    Err(Problem::new(
        key("size_m"),
        format!(
            "the plate is {} m wide, only {cells:.1} cells of {} m",
            readable(narrow),
            readable(air.units.cell_size_m)
        ),
        format!("choose smaller cells: at least {least:.1} over the plate, 8 or more for results"),
    ))
}
