//! Openings of a wing: intakes of cells and holes of ribs, so that a lattice can be judged by them.

use std::collections::{HashMap, HashSet};

use super::builder::Builder;
use super::parts::Part;
use super::section::Side;
use crate::cloth::openings::{Opening, OpeningKind};
use crate::cloth::rims;

impl Builder<'_> {
    /// All openings, cell by cell and rib by rib from the left tip. Their rims are the edges of fabric that one triangle alone has; an intake's are
    /// those of both panels and of the ribs beside it.
    pub(super) fn openings(&self) -> Vec<Opening> {
        let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let rims: Vec<[u32; 2]> = rims::rim_edges(&self.structure);
        let known: HashSet<[u32; 2]> = rims.iter().map(|edge| sorted(*edge)).collect();
        let mut openings = Vec::new();
        if let Some(intakes) = self.plan.intakes {
            for cell in intakes.open_cells(self.plan.cells) {
                openings.extend(self.intake(cell, [intakes.from, intakes.to], &known));
            }
        }
        openings.extend(self.rib_holes(&rims));
        openings
    }

    fn intake(&self, cell: usize, ends: [f64; 2], rims: &HashSet<[u32; 2]>) -> Option<Opening> {
        let [front, rear] = ends.map(|x| self.places.nearest(Side::Lower, x));
        let ks: Vec<usize> = (front..=rear)
            .map(|j| self.on_outline(Side::Lower, j))
            .collect();
        let mut rim = Vec::new();
        let mut add = |a: u32, b: u32| {
            if rims.contains(&[a.min(b), a.max(b)]) {
                rim.push([a, b]);
            }
        };
        let [left, right] = [cell, cell + 1].map(|rib| &self.outlines[rib]);
        for outline in [left, right] {
            for pair in ks.windows(2) {
                add(outline[pair[0]], outline[pair[1]]);
            }
        }
        let (first, last) = (*ks.first()?, *ks.last()?);
        for k in [first, last] {
            let mut row = vec![left[k]];
            row.extend(&self.rows_across[cell][k]);
            row.push(right[k]);
            for pair in row.windows(2) {
                add(pair[0], pair[1]);
            }
        }
        let gap = |outline: &[u32]| {
            let [a, b] = [first, last].map(|k| self.position(outline[k]));
            a.distance(b)
        };
        // From rib to rib it is as wide as the cell.
        let span = self
            .position(left[first])
            .distance(self.position(right[first]));
        Some(Opening {
            kind: OpeningKind::Intake,
            width_m: gap(left).min(gap(right)).min(span),
            rim,
        })
    }

    /// Free edges inside ribs, joined into loops; every loop is the hole nearest to its middle.
    fn rib_holes(&self, rims: &[[u32; 2]]) -> Vec<Opening> {
        let on_outlines: HashSet<u32> = self.outlines.iter().flatten().copied().collect();
        let mut ribs: HashMap<u32, usize> = HashMap::new();
        for (triangle, tag) in self.structure.triangles.iter().zip(&self.tags) {
            if tag.part == Part::Rib {
                for node in triangle.nodes {
                    if !on_outlines.contains(&node) {
                        ribs.insert(node, tag.number as usize);
                    }
                }
            }
        }
        let mut next: HashMap<u32, u32> = HashMap::new();
        let mut starts = Vec::new();
        for &[a, b] in rims {
            if ribs.contains_key(&a) && ribs.contains_key(&b) {
                next.insert(a, b);
                starts.push(a);
            }
        }
        let mut seen: HashSet<u32> = HashSet::new();
        let mut found: Vec<(usize, Opening)> = Vec::new();
        for start in starts {
            if !seen.insert(start) {
                continue;
            }
            let mut loop_nodes = vec![start];
            let mut at = start;
            while let Some(&to) = next.get(&at).filter(|to| **to != start) {
                if !seen.insert(to) {
                    break;
                }
                loop_nodes.push(to);
                at = to;
            }
            let rib = ribs[&start];
            let frame = &self.frames[rib];
            let local = |node: &u32| {
                let place = (self.position(*node) - frame.quarter_m) / frame.chord_m;
                place.dot(frame.aft) + 0.25
            };
            let middle = loop_nodes.iter().map(local).sum::<f64>() / loop_nodes.len() as f64;
            let nearest = self.plan.holes.iter().min_by(|a, b| {
                let off = |hole: &super::plan::Hole| (hole.position - middle).abs();
                off(a).total_cmp(&off(b))
            });
            let Some(hole) = nearest else { continue };
            let height = |side| frame.height(&self.plan.profiles, side, hole.position);
            let tall = hole.height * (height(Side::Upper) - height(Side::Lower));
            let rim = (0..loop_nodes.len())
                .map(|i| [loop_nodes[i], loop_nodes[(i + 1) % loop_nodes.len()]])
                .collect();
            found.push((
                rib,
                Opening {
                    kind: OpeningKind::RibHole,
                    width_m: hole.width.min(tall) * frame.chord_m,
                    rim,
                },
            ));
        }
        found.sort_by_key(|(rib, _)| *rib);
        found.into_iter().map(|(_, opening)| opening).collect()
    }
}
