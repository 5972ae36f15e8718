//! What may be written in `[air.refinement]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Boxes of finer cells. `[resolution]` gives the cells around the structure; each box that holds it doubles those of the air outside.
/// If absent, all cells are alike, unless the tunnel's size is left out as well: then as with `around = "structure"`.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refinement {
    /// What boxes are laid around, one in the other; not beside `boxes`.
    pub around: Option<Around>,
    /// Their number, 1 to 4: cells are halved so often. If absent as many as leave 6 cells of the outermost lattice to a nominal
    /// diameter, a chord or the extent of a body, and save work.
    pub levels: Option<u32>,
    /// Room in the innermost box around all places to which the structure can come, in nominal diameters, chords, or extents of the
    /// body; 0.15 if absent.
    pub margin: Option<f64>,
    /// Boxes by hand. A box in another one has cells of half the size. Two boxes lie one in the other, or apart; one chain of them holds
    /// all that stands in the air.
    pub boxes: Option<Vec<RefinementBox>>,
}

/// What boxes are laid around.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Around {
    /// The structure and all bodies, and more of their wake from box to box.
    Structure,
    /// Nothing: all cells are alike.
    Nothing,
}

/// A box of cells half as large as those around it. It ends at whole cells of those, outside what is written.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinementBox {
    /// Its lowest corner [m].
    pub lower_m: [f64; 3],
    /// Its highest corner [m].
    pub upper_m: [f64; 3],
}
