//! Whether the cells are fine enough for the fabric's rims: markers stand a little inside them.

use super::air::Air;
use super::body::Body;
use super::problem::Problem;
use super::values::readable;
use crate::cloth::rims::RimInsets;

/// Least share of the fabric's area that markers must stand for.
const LEAST_MARKED_SHARE: f64 = 0.3;

/// Refuses fabric of which too little lies more than `inset_cells` inside its rims.
pub(super) fn check(body: &Body, air: &Air, inset_cells: f64) -> Result<(), Problem> {
    let insets = RimInsets::new(&body.structure, inset_cells, air.units.cell_size_m);
    let share = body.marked_share(&insets);
    if share >= LEAST_MARKED_SHARE {
        return Ok(());
    }
    Err(Problem::new(
        "resolution",
        format!(
            "cells of {} m are too coarse for this fabric: only {:.0} % of its area lies more than {inset_cells} cells inside its rims, where the \
             air can feel it",
            readable(air.units.cell_size_m),
            100.0 * share
        ),
        "choose smaller cells (resolution.cells_per_diameter, resolution.cell_size_m)",
    ))
}
