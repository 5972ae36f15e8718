//! The mesh of a wing while it is built: what panels, ribs and lines are added to.

use std::collections::HashMap;

use glam::DVec3;

use super::chord::Places;
use super::frames::Frame;
use super::parts::{LineKind, Part, Tag};
use super::plan::{Fineness, Plan, WingFault};
use super::section::Side;
use crate::cloth::{Structure, Triangle};
use crate::fabric::Fabric;

/// Where a V- or H-rib is sewn to a rib between its seams: number of the place on the upper side, and the height in fiftieths.
pub(super) type SeamPlace = (usize, u32);

/// Nodes on the outline of a rib or along a line across a cell, and what builders add to.
pub(super) struct Builder<'a> {
    pub(super) plan: &'a Plan,
    pub(super) fineness: Fineness,
    pub(super) places: Places,
    pub(super) frames: Vec<Frame>,
    pub(super) structure: Structure,
    pub(super) tags: Vec<Tag>,
    pub(super) line_kinds: Vec<LineKind>,
    pub(super) fabrics: Vec<Fabric>,
    /// Node at every place of the outline of every rib: nose, upper side, trailing edge, lower side back to the nose.
    pub(super) outlines: Vec<Vec<u32>>,
    /// Nodes across every cell, the ribs' left out, by place of the outline; none where the panel is open.
    pub(super) rows_across: Vec<Vec<Vec<u32>>>,
    /// Nodes along the edges of diagonals, by their ends on the seams: on a coarse mesh diagonals of neighbouring rows meet there.
    pub(super) diagonal_edges: HashMap<[u32; 2], Vec<u32>>,
    /// Nodes of ribs between their seams that V- and H-ribs are sewn to.
    pub(super) seam_nodes: HashMap<(usize, SeamPlace), u32>,
    /// Mass of all rods [kg].
    pub(super) rod_mass_kg: f64,
}

impl Builder<'_> {
    /// Numbers along an outline.
    pub(super) const fn outline_len(&self) -> usize {
        2 * self.fineness.along_chord
    }

    /// Number on the outline of node `j` of a side, counted from the nose.
    pub(super) const fn on_outline(&self, side: Side, j: usize) -> usize {
        match side {
            Side::Upper => j,
            Side::Lower => (self.outline_len() - j) % self.outline_len(),
        }
    }

    /// Side and number, counted from the nose, of a place on the outline; the nose and the trailing edge count as upper.
    pub(super) const fn side_of(&self, k: usize) -> (Side, usize) {
        if k <= self.fineness.along_chord {
            (Side::Upper, k)
        } else {
            (Side::Lower, self.outline_len() - k)
        }
    }

    /// Place of an outline's node along the chord, and its height above it, per chord.
    pub(super) fn chord_point(&self, rib: usize, k: usize) -> [f64; 2] {
        let (side, j) = self.side_of(k);
        let x = self.places.of(side)[j];
        [x, self.frames[rib].height(&self.plan.profiles, side, x)]
    }

    pub(super) fn position(&self, node: u32) -> DVec3 {
        self.structure.positions_m[node as usize]
    }

    pub(super) fn fabric_number(&mut self, part: Part) -> usize {
        let fabrics = &self.plan.fabrics;
        let fabric = match part {
            Part::Upper => fabrics.upper,
            Part::Lower => fabrics.lower,
            Part::Rib | Part::MiniRib => fabrics.ribs,
            Part::Diagonal => fabrics.diagonals,
        };
        if let Some(known) = self.fabrics.iter().position(|f| *f == fabric) {
            return known;
        }
        self.fabrics.push(fabric);
        self.fabrics.len() - 1
    }

    /// Adds a triangle that is free of stress as its nodes stand.
    pub(super) fn add_triangle(
        &mut self,
        nodes: [u32; 3],
        warp: DVec3,
        tag: Tag,
    ) -> Result<(), WingFault> {
        let number = self.fabric_number(tag.part);
        let fabric = self.fabrics[number];
        let corners = nodes.map(|n| self.position(n));
        let mut triangle = Triangle::laid_out(nodes, corners, warp, fabric.initial_strain).ok_or(
            WingFault::Degenerate {
                part: tag.part.name(),
                number: tag.number as usize,
            },
        )?;
        triangle.fabric = number as u32;
        let mass = fabric.areal_density_kg_m2() * triangle.rest_area_m2 / 3.0;
        for node in nodes {
            self.structure.masses_kg[node as usize] += mass;
        }
        self.structure.triangles.push(triangle);
        self.tags.push(tag);
        Ok(())
    }
}
