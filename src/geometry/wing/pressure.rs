//! Pressure jumps across the fabric of a wing for a prescribed distribution; that of a glide is computed (`crate::trim`).
//!
//! On a panel the jump is q (C_i − f C_o), positive outwards: q dynamic pressure, C_i the coefficient inside the cell (1 at a stagnation
//! point), C_o(x/c) outside, f(η) its share along the half span. On a rib it is the difference of its two cells; at a tip C_o is the mean
//! of both sides. Diagonals and mini-ribs have the same pressure on both sides.

use super::{BuiltWing, Part};
use crate::geometry::table::lookup;

/// A prescribed distribution of pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Dynamic pressure q [Pa].
    pub dynamic_pressure_pa: f64,
    /// Coefficients inside: one for all cells, or one per cell from the left tip.
    pub inside: Vec<f64>,
    /// Coefficients outside over the upper side: points (x/c, C).
    pub upper: Vec<[f64; 2]>,
    /// The same over the lower side.
    pub lower: Vec<[f64; 2]>,
    /// Share of the coefficients outside: points (distance from the middle over the half span, share).
    pub along_span: Vec<[f64; 2]>,
}

impl Distribution {
    fn inside(&self, cell: usize) -> f64 {
        match self.inside[..] {
            [all] => all,
            _ => self.inside[cell],
        }
    }
}

/// Jumps along the normals of the triangles [Pa], `[triangle_count]`.
#[must_use]
pub fn jumps_pa(wing: &BuiltWing, distribution: &Distribution) -> Vec<f64> {
    let share = |cell: usize| lookup(&distribution.along_span, wing.cell_places[cell]);
    let outside = |cell: usize, table: &[[f64; 2]], place: f64| share(cell) * lookup(table, place);
    let of_tip = |cell: usize, place: f64| {
        0.5 * (outside(cell, &distribution.upper, place)
            + outside(cell, &distribution.lower, place))
    };
    wing.tags
        .iter()
        .map(|tag| {
            let (number, place) = (tag.number as usize, f64::from(tag.chord_place));
            let coefficient = match tag.part {
                Part::Upper => {
                    distribution.inside(number) - outside(number, &distribution.upper, place)
                }
                Part::Lower => {
                    distribution.inside(number) - outside(number, &distribution.lower, place)
                }
                // Normals of ribs point to the right: the cell on the left pushes along them.
                Part::Rib if number == 0 => of_tip(0, place) - distribution.inside(0),
                Part::Rib if number == wing.cells => {
                    distribution.inside(number - 1) - of_tip(number - 1, place)
                }
                Part::Rib => distribution.inside(number - 1) - distribution.inside(number),
                Part::MiniRib | Part::Diagonal => 0.0,
            };
            distribution.dynamic_pressure_pa * coefficient
        })
        .collect()
}
