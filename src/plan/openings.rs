//! Openings of a canopy or a wing, in cells of the air, for `ripstop check`.

use std::fmt::Write;

use crate::case::Scene;
use crate::case::scene::{Opening, OpeningKind};
use crate::immersed::markers;

/// Cells across an opening from which the jet through it is resolved (`ripstop validate openings`).
const RESOLVED_CELLS: f64 = 6.0;

/// Cells from which on holes pass what sharp-edged ones do within 20 %, and gaps and slots do; narrower ones pass too little.
const SMALLEST_HOLE_CELLS: f64 = 1.0;
const SMALLEST_SLOT_CELLS: f64 = 2.0;

/// Relative difference of widths that are meant to be the same.
const ROUND_OFF: f64 = 1e-9;

/// Openings of one kind and width: the first of them and how many they are.
fn kinds(openings: &[Opening]) -> Vec<(&Opening, usize)> {
    let mut found: Vec<(&Opening, usize)> = Vec::new();
    for opening in openings {
        let same = |known: &&Opening| {
            let same_width = (known.width_m - opening.width_m).abs() <= ROUND_OFF * known.width_m;
            known.kind == opening.kind && same_width
        };
        match found.iter_mut().find(|(known, _)| same(known)) {
            Some((_, count)) => *count += 1,
            None => found.push((opening, 1)),
        }
    }
    found
}

pub(super) fn write(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let Some(body) = &scene.body else {
        return Ok(());
    };
    let inset = |width_m: f64| {
        let (air, coupling) = (scene.air.as_ref()?, scene.coupling.as_ref()?);
        let cell = air.units.cell_size_m;
        let of_rims = coupling.rim_inset_cells / markers::RIM_INSET_CELLS;
        let inset = of_rims * markers::opening_inset_cells(width_m / cell);
        Some((width_m / cell, inset))
    };
    for (opening, count) in kinds(&body.structure.openings) {
        let what = match opening.kind {
            OpeningKind::Slot | OpeningKind::Intake | OpeningKind::RibHole => {
                format!("{count} {}s", opening.kind.name())
            }
            kind => kind.name().to_owned(),
        };
        let cells = match inset(opening.width_m) {
            None => String::new(),
            Some((_, inset)) if opening.width_m == 0.0 => format!(
                ": cuts along seams, which open under load; markers stand {inset:.2} cells inside their rims"
            ),
            Some((cells, inset)) => {
                let smallest = match opening.kind {
                    OpeningKind::Vent | OpeningKind::RibHole => SMALLEST_HOLE_CELLS,
                    _ => SMALLEST_SLOT_CELLS,
                };
                let judged = match cells {
                    _ if cells >= RESOLVED_CELLS => "its jet is resolved",
                    _ if cells >= smallest => {
                        "its jet is not resolved, but passes what it should within 20 %"
                    }
                    _ => "too narrow: it passes less than it should",
                };
                format!(
                    ", {cells:.1} cells: markers stand {inset:.2} cells inside its rim; {judged}"
                )
            }
        };
        writeln!(out, "  {what:<19} {:.4} m wide{cells}", opening.width_m)?;
    }
    Ok(())
}
