//! What is known of types of canopies: bands of published values, and what follows from them.
//!
//! Bands are those of T. W. Knacke, Parachute Recovery Systems Design Manual (NWC TP 6575, 1991), tables 5-1 and 5-2: of canopies in free descent.
//! Those of conical, ringslot and cruciform canopies are as the trade quotes them, and have not been read again in the manual itself.

use super::super::file::CanopyType;

/// Where bands are from.
pub(super) const SOURCE: &str = "Knacke 1991, tables 5-1 and 5-2";

/// Published values of a type, from and to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Published {
    /// In words.
    pub(super) name: &'static str,
    /// Drag coefficient, on S_0.
    pub(super) drag_coefficient: [f64; 2],
    /// Inflated projected diameter over D_0.
    pub(super) projected_diameter_ratio: [f64; 2],
    /// Opening-force factor C_x at infinite mass.
    pub(super) opening_force_factor: [f64; 2],
}

impl Published {
    pub(super) const fn of(kind: CanopyType) -> Self {
        let (name, drag_coefficient, projected_diameter_ratio, opening_force_factor) = match kind {
            CanopyType::FlatCircular => ("flat circular", [0.75, 0.80], [0.67, 0.70], [1.7, 1.8]),
            CanopyType::Conical => ("conical", [0.75, 0.90], [0.70, 0.70], [1.8, 1.8]),
            CanopyType::ExtendedSkirt => ("extended skirt", [0.78, 0.87], [0.66, 0.70], [1.4, 1.4]),
            CanopyType::DiskGapBand => ("disk-gap-band", [0.52, 0.58], [0.65, 0.65], [1.3, 1.3]),
            CanopyType::Ringslot => ("ringslot", [0.56, 0.65], [0.67, 0.70], [1.05, 1.05]),
            CanopyType::Cruciform => ("cruciform", [0.60, 0.85], [0.66, 0.72], [1.1, 1.2]),
        };
        Self {
            name,
            drag_coefficient,
            projected_diameter_ratio,
            opening_force_factor,
        }
    }

    /// The middle of the band of the drag coefficient.
    pub(super) const fn mean_drag_coefficient(&self) -> f64 {
        0.5 * (self.drag_coefficient[0] + self.drag_coefficient[1])
    }
}
