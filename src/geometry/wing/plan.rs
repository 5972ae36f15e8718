//! What a wing is made of, as its designer states it; checked values in SI units.

use glam::DVec3;

use super::frames::Station;
use super::section::{Profile, Side};
use crate::fabric::Fabric;
use crate::lines::Cable;

/// Plan of a wing, symmetric about the plane y = 0; x runs from nose to trailing edge, z up, and the nose of the middle is the origin.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Profiles that stations name by number.
    pub profiles: Vec<Profile>,
    /// From the middle (span 0, roll 0) to the tip.
    pub stations: Vec<Station>,
    /// Panels on each side from tip to tip; ribs stand between them and at both tips.
    pub cells: usize,
    /// Width of the outermost cell over that of the middlemost one; between them it changes evenly.
    pub tip_cell_width_ratio: f64,
    /// Distances of the ribs of the right half from the middle along the arc, outwards [m]: the first is 0 where the number of cells is even. `None`: they
    /// follow from the widths.
    pub rib_places_m: Option<Vec<f64>>,
    /// Width of a panel over the distance of its ribs, less 1: points (place on the chord, that) of the upper and the lower side. At the
    /// trailing edge, where both are sewn together, it is taken as 0, at the nose as the mean of both.
    pub ballooning: [Vec<[f64; 2]>; 2],
    /// Openings in the lower panels; `None`: the wing is closed.
    pub intakes: Option<Intakes>,
    /// Holes in all ribs but those at the tips.
    pub holes: Vec<Hole>,
    /// Where short ribs begin in the middle of every cell, per chord; they end at the trailing edge. `None`: there are none.
    pub mini_ribs_from: Option<f64>,
    /// Rows of lines, brakes among them.
    pub rows: Vec<Row>,
    /// Tapes along the span.
    pub tapes: Vec<Tape>,
    /// V- and H-ribs as drawn, of the right half.
    pub vh_ribs: Vec<VhRib>,
    /// Rods along the ribs' outlines.
    pub rods: Vec<Rod>,
    /// Where the risers of the right half are held [m].
    pub hang_point_m: DVec3,
    /// Stiffness with which a nose in the middle is kept from drifting along x [N/m]; `None`: the attitude follows from lines and loads
    /// alone.
    pub pitch_guide_n_m: Option<f64>,
    /// What panels, ribs and diagonals are made of.
    pub fabrics: PartFabrics,
}

/// Fabric of every part.
#[derive(Debug, Clone, PartialEq)]
pub struct PartFabrics {
    /// Of upper panels.
    pub upper: Fabric,
    /// Of lower panels.
    pub lower: Fabric,
    /// Of ribs and mini-ribs.
    pub ribs: Fabric,
    /// Of diagonals.
    pub diagonals: Fabric,
}

/// Openings of cells, from rib to rib.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intakes {
    /// Edges on the lower side, per chord.
    pub from: f64,
    /// See `from`.
    pub to: f64,
    /// Cells at each tip without an opening.
    pub closed_tip_cells: usize,
}

impl Intakes {
    /// The cells with an opening of a wing with so many; none where the closed ones meet.
    #[must_use]
    pub fn open_cells(&self, cells: usize) -> std::ops::Range<usize> {
        self.closed_tip_cells..cells.saturating_sub(self.closed_tip_cells)
    }
}

/// A hole in a rib: an ellipse that is bent with the rib.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hole {
    /// Place of its middle, per chord.
    pub position: f64,
    /// Length along the chord, per chord.
    pub width: f64,
    /// Height over that of the rib.
    pub height: f64,
}

/// Tape along the span, through the seams of the ribs.
#[derive(Debug, Clone, PartialEq)]
pub struct Tape {
    /// Side.
    pub side: Side,
    /// Place per chord.
    pub position: f64,
    /// True if it is sewn on the panels; else it runs straight from rib to rib.
    pub sewn: bool,
    /// What it is made of.
    pub cable: Cable,
}

/// Rods along the outline of ribs: straight where nothing bends them, and free to slide in their pockets.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Name.
    pub name: String,
    /// Places between which it lies on the upper and on the lower side, per chord; around the nose where both begin there.
    pub sides: [Option<[f64; 2]>; 2],
    /// E I [N m²].
    pub flexural_rigidity_nm2: f64,
    /// Mass per length [kg/m].
    pub mass_per_length_kg_m: f64,
    /// Ribs that have one, counted from the middle.
    pub ribs: Vec<usize>,
}

/// A row of lines, on both halves.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name, such as `A` or `brake`.
    pub name: String,
    /// Place of the attachments on the lower side, per chord; 1 is the trailing edge.
    pub position: f64,
    /// Ribs with attachments, counted from the middle (0 in the plane of symmetry if there is one), growing.
    pub ribs: Vec<usize>,
    /// Place of every attachment where they are not all at `position`; else empty.
    pub positions: Vec<f64>,
    /// Weight of every attachment in the means that nodes and the riser point to; empty: alike.
    pub weights: Vec<f64>,
    /// From the attachments down.
    pub levels: Vec<Level>,
    /// From where the lines of the row meet to the hang point.
    pub riser_length_m: f64,
    /// What it is made of.
    pub riser: Cable,
    /// By how much the riser is made longer than designed [m]: trim, or the slack of a brake.
    pub trim_m: f64,
    /// Fabric from the attachments to the upper seams of both neighbouring ribs; `None`: there is none.
    pub diagonals: Option<Diagonals>,
}

impl Row {
    /// Attachments: rib, counted from the middle, and place.
    pub fn attachments(&self) -> impl Iterator<Item = (usize, f64)> {
        let place = |number: usize| self.positions.get(number).copied();
        let ribs = self.ribs.iter().enumerate();
        ribs.map(move |(number, rib)| (*rib, place(number).unwrap_or(self.position)))
    }
}

/// Lines from the nodes of a row down to where they join.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// How many lines join at each node below, from the middle to the tip; empty: all meet at the riser.
    pub joins: Vec<usize>,
    /// Where they join.
    pub place: JoinPlace,
    /// Name of the material.
    pub material: String,
    /// What they are made of.
    pub cable: Cable,
}

/// Shortest line between two nodes [m].
pub const LEAST_LINE_M: f64 = 0.02;

/// Where lines of a level join.
#[derive(Debug, Clone, PartialEq)]
pub enum JoinPlace {
    /// Share of the way from the riser to the mean of the attachments above.
    Height(f64),
    /// Way from each node to the sail [m], along the way from the node or riser below to the mean of the attachments above: the lowest node is as far
    /// from that mean, and the line between two nodes as long as their ways differ.
    ToSail(Vec<f64>),
}

/// Shape of diagonals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diagonals {
    /// Width along the chord at the attachment, per chord; at least one edge of the mesh on each side.
    pub foot: f64,
    /// The same at the upper seam.
    pub head: f64,
}

/// Fabric between two neighbouring ribs: a V-rib from one seam towards the other, or an H-rib along one.
#[derive(Debug, Clone, PartialEq)]
pub struct VhRib {
    /// Ribs, counted from the middle.
    pub ribs: [usize; 2],
    /// Where it is sewn to each.
    pub ends: [VhRibEnd; 2],
}

/// Where a V- or H-rib is sewn to a rib.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VhRibEnd {
    /// Places between which it reaches, per chord; at least one edge of the mesh on each side of their middle.
    pub between: [f64; 2],
    /// Height over that of the rib there: 0 at the lower seam, 1 at the upper one.
    pub height: f64,
}

impl VhRibEnd {
    /// The seam that it lies on, if it does.
    #[must_use]
    pub const fn seam(&self) -> Option<Side> {
        if self.height <= 0.0 {
            Some(Side::Lower)
        } else if self.height >= 1.0 {
            Some(Side::Upper)
        } else {
            None
        }
    }
}

/// How fine the mesh is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fineness {
    /// Edges along each side of a rib.
    pub along_chord: usize,
    /// Edges across each cell; even.
    pub across_cell: usize,
}

impl Fineness {
    /// About half as many edges each way; `None` if those would be too few to tell the shape.
    #[must_use]
    pub fn halved(self) -> Option<Self> {
        let halved = Self {
            along_chord: self.along_chord / 2,
            across_cell: self.across_cell / 4 * 2,
        };
        (halved.along_chord >= 10 && halved.across_cell >= 2).then_some(halved)
    }
}

/// Why a plan makes no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WingFault {
    /// More places are named than the chord has edges.
    #[error(
        "{along_chord} edges along the chord cannot hold the {places} places on the {side} side where lines and intakes end"
    )]
    TooCoarse {
        /// Edges asked for.
        along_chord: usize,
        /// Intervals between the places.
        places: usize,
        /// "upper" or "lower"
        side: &'static str,
    },
    /// The outline of a rib crosses itself or one of its holes.
    #[error(
        "rib {rib} (counted from the middle) cannot be filled with triangles: its outline crosses itself or a hole"
    )]
    Rib {
        /// Counted from the middle.
        rib: usize,
    },
    /// The outline of a mini-rib crosses itself.
    #[error(
        "the mini-rib of cell {cell} (from the left tip, from 0) cannot be filled with triangles: its outline crosses itself"
    )]
    MiniRib {
        /// From the left tip, from 0.
        cell: usize,
    },
    /// Triangles without area.
    #[error(
        "a triangle of the {part} of cell or rib {number} (from the left tip, from 0) has no area"
    )]
    Degenerate {
        /// Part.
        part: &'static str,
        /// Number.
        number: usize,
    },
    /// A node of lines would stand at the riser or below it.
    #[error(
        "lines of row {row} join {to_sail_m} m below the sail, but the node below, or the end of the riser, is {way_m:.2} m below it, and lines are {LEAST_LINE_M} m long at least"
    )]
    BelowRiser {
        /// Name of the row.
        row: String,
        /// Way from the node to the sail [m].
        to_sail_m: f64,
        /// Way from the node below it, or from the end of the riser, to the sail [m].
        way_m: f64,
    },
}
