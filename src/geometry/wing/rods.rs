//! Rods in pockets along the ribs' seams, which keep noses from folding in.
//!
//! A rod is straight where nothing bends it and slides in its pocket, so that all it stores is ½ E I ∫ κ² ds. At a node between edges of lengths a and b the
//! curvature is κ = 2/(a + b) |(x₊ − x)/b − (x − x₋)/a|, over half of both. Lengths are those of the drawn seam, which makes it quadratic in the places: where a seam is
//! shortened by folds, the rod is taken as bent by less than it is.

use super::builder::Builder;
use super::plan::Rod;
use super::section::Side;
use crate::cloth::Bending;

impl Builder<'_> {
    /// Rods of all ribs that have some.
    pub(super) fn add_rods(&mut self) {
        let plan = self.plan;
        for rod in &plan.rods {
            let places = self.places_of(rod);
            for rib in 0..=plan.cells {
                if rod.ribs.contains(&self.count_of(rib)) {
                    let nodes = places.iter().map(|&k| self.outlines[rib][k]);
                    let nodes: Vec<u32> = nodes.collect();
                    self.add_rod(&nodes, rod);
                }
            }
        }
    }

    /// Places of its nodes on an outline, from the end below to that above: the nearest to its ends, with two edges at least.
    fn places_of(&self, rod: &Rod) -> Vec<usize> {
        let [upper, lower] = rod.sides;
        let edges = if upper.is_some() && lower.is_some() {
            1
        } else {
            2
        };
        let on = |side, [from, to]: [f64; 2]| {
            let last = self.fineness.along_chord;
            let from = self.places.nearest(side, from).min(last - edges);
            let to = self.places.nearest(side, to).max(from + edges);
            (from..=to).map(move |j| self.on_outline(side, j))
        };
        let below = lower.into_iter().flat_map(|range| on(Side::Lower, range));
        let mut places: Vec<usize> = below.collect();
        places.reverse();
        places.extend(upper.into_iter().flat_map(|range| on(Side::Upper, range)));
        // The nose is on both sides.
        places.dedup();
        places
    }

    fn add_rod(&mut self, nodes: &[u32], rod: &Rod) {
        let length = |pair: &[u32]| self.position(pair[0]).distance(self.position(pair[1]));
        let lengths: Vec<f64> = nodes.windows(2).map(length).collect();
        for (pair, length) in nodes.windows(2).zip(&lengths) {
            let mass_kg = rod.mass_per_length_kg_m * length;
            self.rod_mass_kg += mass_kg;
            for &node in pair {
                self.structure.masses_kg[node as usize] += 0.5 * mass_kg;
            }
        }
        for (three, pair) in nodes.windows(3).zip(lengths.windows(2)) {
            self.structure.bendings.push(Bending::of_rod(
                [three[0], three[1], three[2]],
                [pair[0], pair[1]],
                rod.flexural_rigidity_nm2,
            ));
        }
    }
}
