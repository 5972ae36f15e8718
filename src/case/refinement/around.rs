//! Boxes around what stands in the air, chosen by its length.
//!
//! The innermost holds all places to which the structure can come, with a margin, and the near wake. Between a box and the one around it lie so many
//! cells of the latter, whatever the level, and more of them downstream. Boxes end before the faces of the air and its sponge; a box that saves
//! no work is left out.

use glam::DVec3;

use super::lattice::{Lattice, repeats, sponge_begins_m};
use super::reach::Standing;
use super::written::key;
use crate::case::air::Air;
use crate::case::problem::Problem;
use crate::lattice::nest::{self, CLEARANCE, Refinement};

/// Room around the reach of the structure, in its lengths.
pub(super) const MARGIN: f64 = 0.15;

/// Of the wake in the innermost box, in lengths.
const NEAR_WAKE: f64 = 0.5;

/// Cells of a box between it and the one in it: upstream, to the sides, downstream.
const NEXT: [f64; 3] = [8.0, 8.0, 20.0];

/// Cells of the lattice around a box between it and that lattice's faces: more than it needs.
const GAP: f64 = (CLEARANCE + 1) as f64;

/// Share of the work without its outermost box that a nest of boxes may cost.
const WORTH: f64 = 0.9;

/// Boxes one in the other, so many where `levels` are asked for.
pub(super) fn lay(
    air: &Air,
    standing: &Standing,
    margin: f64,
    levels: Option<u32>,
) -> Result<Vec<Refinement>, Problem> {
    // The box of the air is made of whole cells of the outermost of so many levels.
    let most = air.most_levels;
    if levels.is_some() {
        return nested(air, standing, margin, most).ok_or_else(|| no_room(most));
    }
    let mut laid = None;
    for depth in 0..=most {
        let Some(boxes) = nested(air, standing, margin, depth) else {
            break;
        };
        let cost = cost(air, &boxes);
        if laid.as_ref().is_some_and(|(_, least)| cost > WORTH * least) {
            break;
        }
        laid = Some((boxes, cost));
    }
    Ok(laid.map_or_else(Vec::new, |(boxes, _)| boxes))
}

fn no_room(levels: u32) -> Problem {
    Problem::new(
        key("levels"),
        format!(
            "{levels} boxes one in the other find no room between the structure and the faces of the air"
        ),
        "enlarge the tunnel, or take fewer levels",
    )
}

/// Cell updates in a step of the lattice around the structure.
fn cost(air: &Air, boxes: &[Refinement]) -> f64 {
    let with = Air {
        boxes: boxes.to_vec(),
        ..air.clone()
    };
    with.updates_per_step()
}

/// `None` where there is no room for them.
fn nested(air: &Air, standing: &Standing, margin: f64, depth: u32) -> Option<Vec<Refinement>> {
    let length = standing.length_m;
    let cell = air.units.cell_size_m;
    let kept = (margin * length).max((standing.kept_cells + 2) as f64 * cell);
    let (low, high) = standing.reach;
    let mut wanted = vec![(
        low - DVec3::splat(kept),
        high + DVec3::splat(kept) + DVec3::X * (NEAR_WAKE * length),
    )];
    for level in 1..depth {
        let (low, high) = wanted[level as usize - 1];
        let [up, side, down] = NEXT.map(|n| n * cell * f64::from(1_u32 << level));
        wanted.push((
            low - DVec3::new(up, side, side),
            high + DVec3::new(down, side, side),
        ));
    }
    let mut lattice = Lattice {
        corner_m: DVec3::ZERO,
        cell_m: cell * f64::from(1_u32 << depth),
        cells: air.cells.map(|n| n >> depth),
        repeats: repeats(air),
    };
    let mut nests = Vec::new();
    let mut end_m = sponge_begins_m(air).unwrap_or(f64::INFINITY);
    for (low, high) in wanted.into_iter().take(depth as usize).rev() {
        let room = DVec3::splat(GAP * lattice.cell_m);
        let far =
            lattice.corner_m + DVec3::from_array(lattice.cells.map(|n| n as f64)) * lattice.cell_m;
        let (mut least, mut most) = (lattice.corner_m + room, far - room);
        // Along axes that repeat a box may span all.
        for a in (0..3).filter(|a| lattice.repeats[*a]) {
            (least[a], most[a]) = (lattice.corner_m[a], far[a]);
        }
        most.x = most.x.min(end_m);
        end_m = f64::INFINITY;
        let nest = lattice.nest((low.max(least), high.min(most)));
        if !nest.fits(lattice.cells) {
            return None;
        }
        lattice = lattice.inside(&nest);
        nests.push(nest);
    }
    let boxes = nests
        .into_iter()
        .rev()
        .fold(Vec::new(), |inner, nest| vec![Refinement { nest, inner }]);
    debug_assert_eq!(nest::depth(&boxes), depth as usize);
    let (low_m, high_m) = standing.reach;
    let fits = (0..3).all(|a| {
        let kept = standing.kept_cells as f64 * cell;
        let far = lattice.corner_m[a] + lattice.cells[a] as f64 * lattice.cell_m;
        lattice.repeats[a] || (low_m[a] - lattice.corner_m[a] >= kept && far - high_m[a] >= kept)
    });
    (fits || depth == 0).then_some(boxes)
}
