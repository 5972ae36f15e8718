//! Openings of a canopy, in cells of the air, for `ripstop check`.

use std::fmt::Write;

use crate::case::Scene;
use crate::case::scene::{Opening, OpeningKind};

/// Cells across an opening below which the flow through it is not resolved.
const RESOLVED_CELLS: f64 = 6.0;

/// Openings of one kind and width: the first of them and how many they are.
fn kinds(openings: &[Opening]) -> Vec<(&Opening, usize)> {
    let mut found: Vec<(&Opening, usize)> = Vec::new();
    for opening in openings {
        let same = |known: &&Opening| {
            known.kind == opening.kind && known.width_m.to_bits() == opening.width_m.to_bits()
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
    let cell = scene.air.map(|air| air.units.cell_size_m);
    for (opening, count) in kinds(&body.structure.openings) {
        let what = match opening.kind {
            OpeningKind::Slot => format!("{count} slots"),
            kind => kind.name().to_owned(),
        };
        let cells = match cell {
            None => String::new(),
            Some(_) if opening.width_m == 0.0 => {
                ": cuts along seams, which open under load".to_owned()
            }
            Some(cell) => {
                let cells = opening.width_m / cell;
                let judged = if cells < RESOLVED_CELLS {
                    format!(" (below {RESOLVED_CELLS}: the flow through it is not resolved)")
                } else {
                    String::new()
                };
                format!(", {cells:.1} cells{judged}")
            }
        };
        writeln!(out, "  {what:<19} {:.4} m wide{cells}", opening.width_m)?;
    }
    Ok(())
}
