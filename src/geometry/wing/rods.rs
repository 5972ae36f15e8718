//! Rods in pockets along the ribs' seams, which keep noses from folding in.
//!
//! A rod is straight where nothing bends it and slides in its pocket, so that all it stores is ½ E I ∫ κ² ds. At a node between edges of lengths a and b the
//! curvature is κ = 2/(a + b) |(x₊ − x)/b − (x − x₋)/a|, over half of both: quadratic in the places, since rods do not stretch.

use super::builder::Builder;
use super::plan::{Rod, WingFault};
use super::section::Side;
use crate::cloth::Bending;

impl Builder<'_> {
    /// Rods of all ribs that have some.
    pub(super) fn add_rods(&mut self) -> Result<(), WingFault> {
        let plan = self.plan;
        for rod in &plan.rods {
            let places = self.places_of(rod);
            let edges = places.len() - 1;
            if edges < 2 {
                let name = rod.name.clone();
                return Err(WingFault::Rod { name, edges });
            }
            for rib in 0..=plan.cells {
                if rod.ribs.contains(&self.count_of(rib)) {
                    let nodes = places.iter().map(|&k| self.outlines[rib][k]);
                    let nodes: Vec<u32> = nodes.collect();
                    self.add_rod(&nodes, rod);
                }
            }
        }
        Ok(())
    }

    /// Places of its nodes on an outline, from the end below to that above.
    fn places_of(&self, rod: &Rod) -> Vec<usize> {
        let on = |side, [from, to]: [f64; 2]| {
            let [from, to] = [from, to].map(|place| self.places.nearest(side, place));
            (from..=to).map(move |j| self.on_outline(side, j))
        };
        let [upper, lower] = rod.sides;
        let mut places: Vec<usize> =
            lower.map_or(Vec::new(), |range| on(Side::Lower, range).collect());
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
            for &node in pair {
                self.structure.masses_kg[node as usize] += 0.5 * rod.mass_per_length_kg_m * length;
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
