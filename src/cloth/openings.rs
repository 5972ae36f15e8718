//! Openings that a canopy or a wing is built with: where they are and how wide, so that a lattice can be judged by them.

/// What an opening is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OpeningKind {
    /// Hole at the apex.
    Vent,
    /// Circumferential gap between two parts of a canopy.
    Gap,
    /// Slot between two gores.
    Slot,
    /// Intake of a cell.
    Intake,
    /// Hole in a rib.
    RibHole,
}

impl OpeningKind {
    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vent => "vent",
            Self::Gap => "gap",
            Self::Slot => "slot",
            Self::Intake => "intake",
            Self::RibHole => "rib hole",
        }
    }
}

/// An opening.
#[derive(Debug, Clone, PartialEq)]
pub struct Opening {
    /// What it is.
    pub kind: OpeningKind,
    /// Smallest width as constructed \[m\]; zero for a cut.
    pub width_m: f64,
    /// Edges of fabric that bound it.
    pub rim: Vec<[u32; 2]>,
}
