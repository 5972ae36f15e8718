//! Boxes on whole cells of the lattices around them.

use glam::DVec3;

use super::written::{Branch, Corners, key};
use crate::case::air::{Air, Flow};
use crate::case::problem::Problem;
use crate::case::values::readable;
use crate::lattice::nest::{CLEARANCE, NARROWEST, Nest, Refinement};

/// Where the sponge begins [m].
pub(super) fn sponge_begins_m(air: &Air) -> Option<f64> {
    match air.flow {
        Flow::WindTunnel {
            sponge_length_m, ..
        } => {
            let end_m = air.cells[0] as f64 * air.units.cell_size_m;
            sponge_length_m.map(|length| end_m - length)
        }
        Flow::TaylorGreen { .. } => None,
    }
}

/// Axes along which the air repeats.
pub(super) fn repeats(air: &Air) -> [bool; 3] {
    match air.flow {
        Flow::WindTunnel { sides, .. } => {
            let [y, z] = sides.repeat();
            [false, y, z]
        }
        Flow::TaylorGreen { .. } => [true; 3],
    }
}

/// A lattice that boxes are laid in.
pub(super) struct Lattice {
    /// Its corner [m].
    pub corner_m: DVec3,
    /// Edge length of a cell [m].
    pub cell_m: f64,
    /// Its cells.
    pub cells: [usize; 3],
    /// Axes along which it repeats.
    pub repeats: [bool; 3],
}

impl Lattice {
    /// A box that ends at whole cells, outside `corners`; all of an axis that repeats where it would come near its ends.
    pub fn nest(&self, (low, high): Corners) -> Nest {
        let low = (low - self.corner_m) / self.cell_m;
        let high = (high - self.corner_m) / self.cell_m;
        let mut nest = Nest {
            first: [0; 3],
            cells: self.cells,
            spans: [false; 3],
        };
        // What ends at a cell does not reach into the next by round-off.
        const SLACK: f64 = 1e-6;
        for a in 0..3 {
            let first = (low[a] + SLACK).floor();
            let end = (high[a] - SLACK).ceil();
            let least = CLEARANCE as f64;
            if self.repeats[a] && (first < least || end > self.cells[a] as f64 - least) {
                nest.spans[a] = true;
                continue;
            }
            nest.first[a] = first.max(0.0) as usize;
            nest.cells[a] = (end - nest.first[a] as f64).max(0.0) as usize;
        }
        nest
    }

    /// The lattice of a box in this one.
    pub fn inside(&self, nest: &Nest) -> Self {
        let first = DVec3::from_array(nest.first.map(|n| n as f64));
        Self {
            corner_m: self.corner_m + first * self.cell_m,
            cell_m: 0.5 * self.cell_m,
            cells: nest.fine_cells(),
            repeats: nest.spans,
        }
    }

    /// Boxes in this lattice, and those in them.
    pub fn lay(&self, branches: &[Branch]) -> Result<Vec<Refinement>, Problem> {
        let mut laid: Vec<Refinement> = Vec::new();
        for branch in branches {
            let nest = self.nest(branch.corners);
            if !nest.fits(self.cells) {
                return Err(Problem::new(
                    key("boxes"),
                    format!(
                        "the box from {} to {} m does not lie {CLEARANCE} of the cells around it ({} m each) inside the faces of those, or is not \
                         {NARROWEST} of them wide",
                        branch.corners.0,
                        branch.corners.1,
                        readable(self.cell_m)
                    ),
                    "move or enlarge the box, or the one around it",
                ));
            }
            if let Some(near) = laid.iter().find(|other| !nest.is_apart_from(&other.nest)) {
                return Err(Problem::new(
                    key("boxes"),
                    format!(
                        "two boxes lie less than {CLEARANCE} of the cells around them apart: at cells {:?} and {:?}",
                        near.nest.first, nest.first
                    ),
                    "join them, or move them apart",
                ));
            }
            laid.push(Refinement {
                nest,
                inner: self.inside(&nest).lay(&branch.inner)?,
            });
        }
        Ok(laid)
    }
}
