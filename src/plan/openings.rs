//! Openings of a canopy or a wing, in cells of the air, for `ripstop check`.

use std::fmt::Write;

use crate::case::Scene;
use crate::case::coupling::{NARROW_CELLS, NarrowOpenings, Scheme};
use crate::case::scene::{Opening, OpeningKind};
use crate::immersed::markers;

/// Cells across an opening from which the jet through it is resolved (`ripstop validate openings`).
const RESOLVED_CELLS: f64 = 6.0;

/// Cells from which on holes pass what sharp-edged ones do within 20 %, and gaps and slots do; narrower ones pass too little.
const SMALLEST_HOLE_CELLS: f64 = 1.0;
const SMALLEST_SLOT_CELLS: f64 = 2.0;

/// Cells from which on holes, and gaps and slots, in a surface that cuts links pass what they should within 15 % (`ripstop validate openings`).
const SMALLEST_CUT_CELLS: [f64; 2] = [2.0, 3.0];

/// Relative difference of widths that are meant to be the same.
const ROUND_OFF: f64 = 1e-9;

/// Openings of one kind, which stand together in the report.
struct Group<'a> {
    narrowest: &'a Opening,
    widest_m: f64,
    count: usize,
}

/// Slots, intakes and holes of ribs by their kind, of which a wing has many; others by kind and width.
fn groups(openings: &[Opening]) -> Vec<Group<'_>> {
    let mut found: Vec<Group> = Vec::new();
    for opening in openings {
        let belongs = |known: &&mut Group| {
            let width_m = known.narrowest.width_m;
            known.narrowest.kind == opening.kind
                && (is_counted(opening.kind)
                    || (width_m - opening.width_m).abs() <= ROUND_OFF * width_m)
        };
        match found.iter_mut().find(belongs) {
            Some(group) => {
                group.count += 1;
                group.widest_m = group.widest_m.max(opening.width_m);
                if opening.width_m < group.narrowest.width_m {
                    group.narrowest = opening;
                }
            }
            None => found.push(Group {
                narrowest: opening,
                widest_m: opening.width_m,
                count: 1,
            }),
        }
    }
    found
}

const fn is_counted(kind: OpeningKind) -> bool {
    matches!(
        kind,
        OpeningKind::Slot | OpeningKind::Intake | OpeningKind::RibHole
    )
}

pub(super) fn write(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let Some(body) = &scene.body else {
        return Ok(());
    };
    let by_links = scene
        .coupling
        .is_some_and(|coupling| coupling.scheme == Scheme::Links);
    let inset = |width_m: f64| {
        let (air, coupling) = (scene.air.as_ref()?, scene.coupling.as_ref()?);
        let cell = air.units.cell_size_m;
        let of_rims = coupling.rim_inset_cells / markers::RIM_INSET_CELLS;
        let inset = of_rims * markers::opening_inset_cells(width_m / cell);
        Some((width_m / cell, inset))
    };
    let openings = &body.structure.openings;
    let covers = match (&scene.air, &scene.coupling) {
        (Some(air), Some(coupling)) => coupling.covers(&body.structure, air.units.cell_size_m),
        _ => vec![None; openings.len()],
    };
    let has_law = |opening: &Opening| {
        let mut all = openings.iter().zip(&covers);
        all.any(|(known, covers)| std::ptr::eq(known, opening) && covers.is_some())
    };
    let by_law =
        scene.coupling.as_ref().and_then(|c| c.narrow_openings) == Some(NarrowOpenings::Law);
    if by_law && covers.iter().all(Option::is_none) {
        writeln!(
            out,
            "  narrow openings     none: no vent is below {} cells, no gap or slot below {}; coupling.narrow_openings = \"law\" changes nothing",
            NARROW_CELLS[0], NARROW_CELLS[1]
        )?;
    }
    for group in groups(openings) {
        let opening = group.narrowest;
        let what = if is_counted(opening.kind) {
            format!("{} {}s", group.count, opening.kind.name())
        } else {
            opening.kind.name().to_owned()
        };
        let is_range = group.widest_m > (1.0 + ROUND_OFF) * opening.width_m;
        let narrowest = if is_range { " the narrowest" } else { "" };
        let cells = match inset(opening.width_m) {
            None => String::new(),
            Some(_) if by_links && opening.width_m == 0.0 => {
                let law = if has_law(opening) {
                    "; air passes by the law of a sharp edge"
                } else {
                    ""
                };
                format!(": cuts along seams, which open under load{law}")
            }
            Some((cells, _)) if has_law(opening) => {
                format!(",{narrowest} {cells:.1} cells: air passes by the law of a sharp edge")
            }
            Some((cells, _)) if by_links => {
                let is_slot = !matches!(opening.kind, OpeningKind::Vent | OpeningKind::RibHole);
                let of_wing = matches!(opening.kind, OpeningKind::Intake | OpeningKind::RibHole);
                let judged = if cells >= SMALLEST_CUT_CELLS[usize::from(is_slot)] {
                    "passes what it should within 15 %"
                } else if cells >= SMALLEST_CUT_CELLS[0] && of_wing {
                    "its jets lean to one side: it passes up to 30 % more than it should"
                } else if cells >= SMALLEST_CUT_CELLS[0] {
                    "its jets lean to one side: it passes up to 30 % more than it should (coupling.narrow_openings)"
                } else if of_wing {
                    "too narrow: it passes less than it should"
                } else {
                    "too narrow for cells: it passes less than it should (coupling.narrow_openings)"
                };
                format!(",{narrowest} {cells:.1} cells: {judged}")
            }
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
                    ",{narrowest} {cells:.1} cells: markers stand {inset:.2} cells inside its rim; {judged}"
                )
            }
        };
        let widest = if is_range {
            format!(" to {:.4}", group.widest_m)
        } else {
            String::new()
        };
        writeln!(
            out,
            "  {what:<19} {:.4}{widest} m wide{cells}",
            opening.width_m
        )?;
    }
    Ok(())
}
