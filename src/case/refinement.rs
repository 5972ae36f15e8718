//! Boxes of finer cells: `[air.refinement]`.

mod around;
mod lattice;
mod reach;
pub(super) mod written;

use glam::DVec3;

use super::air::{Air, Flow};
use super::bodies::RigidBody;
use super::body::Body;
use super::file::{self, Around, File};
use super::friction;
use super::inlet;
use super::problem::Problem;
use super::time::Time;
use super::usual;
use super::values::within;
use crate::lattice::nest::{self, CHANGED_BY_LAYERS, Refinement};
use lattice::{Lattice, repeats, sponge_begins_m};
use reach::Standing;
use written::{Branch, KEY, by_hand, key, order, tree};

/// Lays the boxes, and tells the scales where positions on the lattice are counted from.
pub(super) fn check(
    file: &File,
    air: &mut Air,
    body: Option<&Body>,
    bodies: &[RigidBody],
    time: Option<&Time>,
) -> Result<(), Problem> {
    let Some(written) = file.air.as_ref().and_then(|air| air.refinement.as_ref()) else {
        return Ok(());
    };
    if written.around == Some(Around::Nothing) {
        return Ok(());
    }
    if let Some(body) = bodies.iter().find(|body| !body.faces.is_empty()) {
        return Err(Problem::new(
            format!("bodies.{}.position_m", body.name),
            format!(
                "the body {} passes through a face of the air, where no box of finer cells reaches",
                body.name
            ),
            format!("move it inside, or remove [{KEY}]"),
        ));
    }
    let end_s = time.map_or(0.0, |time| time.end_s);
    let mut standing = Standing::of(body, bodies, end_s);
    if friction::models_layers(file, body)
        && let Some(standing) = &mut standing
    {
        standing.kept_cells += CHANGED_BY_LAYERS;
    }
    let boxes = match &written.boxes {
        Some(boxes) => laid_by_hand(boxes, air, standing.as_ref())?,
        None => {
            let Some(standing) = &standing else {
                return Err(Problem::new(
                    key("around"),
                    "nothing stands in the air that boxes of finer cells could be laid around",
                    format!("remove [{KEY}], or give {}", key("boxes")),
                ));
            };
            let margin = usual::or(key("margin"), written.margin, around::MARGIN);
            let margin = within(&key("margin"), margin, 0.0, 10.0)?;
            around::lay(air, standing, margin, written.levels)?
        }
    };
    let depth = nest::depth(&boxes);
    if written.boxes.is_none() && written.levels.is_none() {
        usual::noted(key("levels"), depth);
    }
    air.boxes = boxes;
    if let Some(written) = &file.air
        && let Flow::WindTunnel {
            sides,
            inlet_profile,
            ..
        } = &mut air.flow
        && inlet_profile.is_some()
    {
        // At the inlet stand cells of the outermost lattice.
        let [cells, size_m] = [air.cells.map(|n| n >> depth), air.cells];
        let across = air.units.cell_size_m * size_m[0] as f64 / cells[0] as f64;
        *inlet_profile = inlet::check_inlet(written, cells, across, *sides)?;
    }
    let finest = air.finest();
    air.units.origin_m = DVec3::from_array(finest.corner.map(|n| n as f64)) * air.units.cell_size_m;
    if let Some(standing) = standing.as_ref().filter(|_| depth > 0) {
        refuse_cut(air, standing, written.boxes.is_some())?;
    }
    Ok(())
}

/// What stands in the air must lie well inside its box.
fn refuse_cut(air: &Air, standing: &Standing, by_hand: bool) -> Result<(), Problem> {
    let finest = air.finest();
    let cell = air.units.cell_size_m;
    let low = air.units.origin_m;
    let high = low + DVec3::from_array(finest.cells.map(|n| n as f64)) * cell;
    let kept = standing.kept_cells as f64 * cell;
    let axes = ['x', 'y', 'z'];
    for a in (0..3).filter(|a| !finest.spans[*a]) {
        let gaps = [standing.start.0[a] - low[a], high[a] - standing.start.1[a]];
        let least = gaps[0].min(gaps[1]);
        if least < kept {
            let name = key(if by_hand { "boxes" } else { "levels" });
            return Err(Problem::new(
                name,
                format!(
                    "the innermost box, from ({:.3}, {:.3}, {:.3}) to ({:.3}, {:.3}, {:.3}) m, leaves {:.3} m along {} to what stands in it, which \
                     is less than the {} cells ({:.3} m) that its markers or cut links need",
                    low.x,
                    low.y,
                    low.z,
                    high.x,
                    high.y,
                    high.z,
                    least,
                    axes[a],
                    standing.kept_cells,
                    kept,
                ),
                if by_hand {
                    "lay the boxes around all that stands in the air"
                } else {
                    "enlarge the tunnel, or take fewer levels"
                },
            ));
        }
    }
    Ok(())
}

/// Boxes that the case gives, on whole cells.
fn laid_by_hand(
    boxes: &[file::RefinementBox],
    air: &Air,
    standing: Option<&Standing>,
) -> Result<Vec<Refinement>, Problem> {
    let mut branches = tree(&by_hand(boxes)?);
    let deepest = branches.iter().map(Branch::depth).max().unwrap_or(0);
    order(&mut branches, standing.map(Standing::middle_m));
    let size_m = air.units.cell_size_m * f64::from(1_u32 << deepest);
    let outermost = Lattice {
        corner_m: DVec3::ZERO,
        cell_m: size_m,
        cells: air.cells.map(|n| n >> deepest),
        repeats: repeats(air),
    };
    let laid = outermost.lay(&branches)?;
    if nest::depth(&laid) != deepest as usize {
        return Err(Problem::new(
            key("boxes"),
            "the finest cells do not lie around what stands in the air",
            "[resolution] gives the cells around the structure: let no other chain of boxes be longer",
        ));
    }
    let sponge_m = sponge_begins_m(air);
    for branch in &branches {
        if sponge_m.is_some_and(|begins| branch.corners.1.x > begins) {
            return Err(Problem::new(
                key("boxes"),
                "a box of finer cells reaches into the sponge before the outlet",
                "let it end before air.wind_tunnel.sponge_length_m begins",
            ));
        }
    }
    Ok(laid)
}
