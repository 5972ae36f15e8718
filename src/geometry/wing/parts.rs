//! What triangles and cables of a wing are part of.

/// What a triangle is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Upper panel.
    Upper,
    /// Lower panel.
    Lower,
    /// Rib.
    Rib,
    /// Short rib at the trailing edge.
    MiniRib,
    /// From an attachment to a neighbouring rib.
    Diagonal,
}

impl Part {
    /// All parts.
    pub const ALL: [Self; 5] = [
        Self::Upper,
        Self::Lower,
        Self::Rib,
        Self::MiniRib,
        Self::Diagonal,
    ];

    /// Name in reports and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Upper => "upper panels",
            Self::Lower => "lower panels",
            Self::Rib => "ribs",
            Self::MiniRib => "mini-ribs",
            Self::Diagonal => "diagonals",
        }
    }
}

/// Where a triangle belongs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tag {
    /// Its part.
    pub part: Part,
    /// Number of its cell (panels, mini-ribs) or rib, from the left tip, from 0; of a diagonal the rib at its foot.
    pub number: u32,
    /// Place of its middle along the chord, per chord.
    pub chord_place: f32,
}

/// What a cable is, beside being one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineKind {
    /// Line of a row at a level, 0 at the attachments.
    Line {
        /// Number of the row in the plan.
        row: usize,
        /// From the attachments down.
        level: usize,
    },
    /// Riser of a row.
    Riser {
        /// Number of the row in the plan.
        row: usize,
    },
    /// Tape, by its number in the plan.
    Tape(usize),
}
