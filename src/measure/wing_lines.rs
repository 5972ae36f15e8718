//! Names of a wing's lines, as a line plan has them: row, level, and the ribs that they carry.

use std::collections::{BTreeSet, HashMap};

use glam::DVec3;

use crate::case::wing::Wing;
use crate::geometry::wing::LineKind;

/// A line, riser or tape.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineName {
    /// What it is.
    pub kind: LineKind,
    /// Its row, or `tape` with its number.
    pub row: String,
    /// `right`, `left` or `middle`.
    pub half: &'static str,
    /// Ribs that it carries, counted from the middle.
    pub ribs: Vec<usize>,
}

impl LineName {
    /// In words.
    #[must_use]
    pub fn text(&self) -> String {
        let ribs: Vec<String> = self.ribs.iter().map(ToString::to_string).collect();
        let ribs = match &ribs[..] {
            [] => String::new(),
            [one] => format!(" of rib {one}"),
            many => format!(" of ribs {}", many.join(", ")),
        };
        match self.kind {
            LineKind::Line { level, .. } => {
                format!(
                    "{} level {} from the wing{ribs}, {}",
                    self.row,
                    level + 1,
                    self.half
                )
            }
            LineKind::Riser { .. } => format!("riser {}, {}", self.row, self.half),
            LineKind::Tape(_) => format!("{}, {}", self.row, self.half),
        }
    }
}

/// Number of a rib from the left tip, counted from the middle.
#[must_use]
pub fn from_the_middle(cells: usize, rib: usize) -> usize {
    (2 * rib).abs_diff(cells).div_ceil(2)
}

/// Half of the wing in which a place lies.
#[must_use]
pub fn half_of(y_m: f64) -> &'static str {
    if y_m > 1e-6 {
        "right"
    } else if y_m < -1e-6 {
        "left"
    } else {
        "middle"
    }
}

/// Names of all cable segments, `[cable_count]`; `cables` are their nodes, upper first, and `positions_m` places of the nodes.
#[must_use]
pub fn names(wing: &Wing, cables: &[[u32; 2]], positions_m: &[DVec3]) -> Vec<LineName> {
    let mut rib_of = HashMap::new();
    for (rib, outline) in wing.built.outlines.iter().enumerate() {
        for node in outline {
            rib_of.insert(*node, rib);
        }
    }
    // Lines stand level by level from the attachments down.
    let mut carried: HashMap<u32, BTreeSet<usize>> = HashMap::new();
    let mut names = Vec::with_capacity(cables.len());
    for (nodes, kind) in cables.iter().zip(&wing.built.line_kinds) {
        let [upper, lower] = *nodes;
        let (row, ribs) = match kind {
            LineKind::Line { row, level } => {
                let own: BTreeSet<usize> = if *level == 0 {
                    rib_of.get(&upper).copied().into_iter().collect()
                } else {
                    carried.get(&upper).cloned().unwrap_or_default()
                };
                carried.entry(lower).or_default().extend(&own);
                (wing.built.row_names[*row].clone(), own)
            }
            LineKind::Riser { row } => (
                wing.built.row_names[*row].clone(),
                carried.get(&upper).cloned().unwrap_or_default(),
            ),
            LineKind::Tape(number) => (format!("tape {}", number + 1), BTreeSet::new()),
        };
        let y_m = 0.5 * (positions_m[upper as usize].y + positions_m[lower as usize].y);
        // From the middle to the tip, whichever half.
        let mut ribs: Vec<usize> = ribs
            .into_iter()
            .map(|rib| from_the_middle(wing.built.cells, rib))
            .collect();
        ribs.sort_unstable();
        names.push(LineName {
            kind: *kind,
            row,
            half: half_of(y_m),
            ribs,
        });
    }
    names
}
