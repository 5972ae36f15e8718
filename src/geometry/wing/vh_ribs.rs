//! Fabric between neighbouring ribs: diagonals at the attachments of rows, and V- and H-ribs as drawn.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::builder::{Builder, SeamPlace};
use super::parts::{Part, Tag};
use super::plan::{Row, VhRibEnd, WingFault};
use super::section::Side;

/// Places of attachments at which diagonals have room, per chord.
const DIAGONALS: std::ops::RangeInclusive<f64> = 0.02..=0.9;

/// Heights between the seams at which ribs have nodes, over the height of the rib.
const HEIGHTS: f64 = 50.0;

impl Builder<'_> {
    /// Diagonals of all rows, from every attachment to the upper seams of the neighbouring ribs.
    pub(super) fn add_diagonals(&mut self) -> Result<(), WingFault> {
        let plan = self.plan;
        for row in &plan.rows {
            let sewn = |place: f64| row.diagonals.is_some() && DIAGONALS.contains(&place);
            for (from_middle, place) in row.attachments().filter(|(_, place)| sewn(*place)) {
                let [right, left] = self.counted(from_middle);
                for (rib, out) in [(right, true), (left, false)] {
                    if right == left && !out {
                        continue;
                    }
                    // Outer neighbour first on both halves.
                    let outer = if out { rib + 1 } else { rib.wrapping_sub(1) };
                    let inner = if out { rib.wrapping_sub(1) } else { rib + 1 };
                    for head in [outer, inner] {
                        if head <= plan.cells {
                            self.add_diagonal(row, place, [rib, head])?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Its foot at `rib`, its other end at the upper seam of `head`.
    fn add_diagonal(
        &mut self,
        row: &Row,
        place: f64,
        [rib, head]: [usize; 2],
    ) -> Result<(), WingFault> {
        let Some(shape) = row.diagonals else {
            return Ok(());
        };
        let feet = self.places.around(Side::Lower, place, shape.foot);
        let heads = self.places.around(Side::Upper, place, shape.head);
        let foot = self.on_seam(rib, Side::Lower, feet);
        let top = self.on_seam(head, Side::Upper, heads);
        self.add_between([foot, top], rib, place)
    }

    /// Nodes of a rib's outline, from the nose on.
    fn on_seam(&self, rib: usize, side: Side, [first, last]: [usize; 2]) -> Vec<u32> {
        (first..=last)
            .map(|j| self.outlines[rib][self.on_outline(side, j)])
            .collect()
    }

    /// V- and H-ribs as drawn, on both halves.
    pub(super) fn add_vh_ribs(&mut self) -> Result<(), WingFault> {
        let plan = self.plan;
        let mut sewn: HashSet<[Vec<u32>; 2]> = HashSet::new();
        for piece in &plan.vh_ribs {
            let [one, other] = piece.ribs.map(|rib| self.counted(rib));
            for ribs in [0, 1].map(|half| [one[half], other[half]]) {
                let mut ends = [0, 1].map(|k| self.end_nodes(ribs[k], &piece.ends[k]));
                let place = 0.5 * piece.ends[0].between.iter().sum::<f64>();
                let known = ends.clone();
                // Across the middle both halves may be the same piece.
                ends.sort();
                if sewn.insert(ends) {
                    self.add_between(known, ribs[0], place)?;
                }
            }
        }
        Ok(())
    }

    /// First and last node of a side that an end is sewn to.
    pub(super) fn span(&self, side: Side, end: &VhRibEnd) -> [usize; 2] {
        let [from, to] = end.between;
        self.places.around(side, 0.5 * (from + to), to - from)
    }

    fn end_nodes(&self, rib: usize, end: &VhRibEnd) -> Vec<u32> {
        match end.seam() {
            Some(side) => self.on_seam(rib, side, self.span(side, end)),
            None => {
                let places = self.places_between_seams(end);
                places
                    .filter_map(|place| self.seam_nodes.get(&(rib, place)).copied())
                    .collect()
            }
        }
    }

    /// Ends of V- and H-ribs that are sewn to a rib between its seams.
    pub(super) fn seams(&self, rib: usize) -> impl Iterator<Item = &VhRibEnd> {
        let pieces = self.plan.vh_ribs.iter();
        let ends = pieces.flat_map(|piece| piece.ribs.iter().zip(&piece.ends));
        ends.filter(move |(at, end)| end.seam().is_none() && self.counted(**at).contains(&rib))
            .map(|(_, end)| end)
    }

    /// Places of an end that lies between the seams, away from where these meet; two at least. Heights are to a fiftieth, so that pieces that end near each other share nodes.
    fn places_between_seams(&self, end: &VhRibEnd) -> impl Iterator<Item = SeamPlace> + use<> {
        let beyond = self.places.upper.len() - 1;
        let [first, last] = self.span(Side::Upper, end);
        let first = first.clamp(1, beyond - 2);
        let last = last.clamp(first + 1, beyond - 1);
        let height = (end.height * HEIGHTS).round() as u32;
        (first..=last).map(move |place| (place, height))
    }

    /// Points of a rib to which V- and H-ribs are sewn between its seams, in its plane per chord; and their places.
    pub(super) fn seam_points(&self, rib: usize) -> (Vec<DVec2>, Vec<SeamPlace>) {
        let frame = &self.frames[rib];
        let height = |side, x| frame.height(&self.plan.profiles, side, x);
        let mut points = Vec::new();
        let mut places: Vec<SeamPlace> = Vec::new();
        for end in self.seams(rib) {
            for place in self.places_between_seams(end) {
                if places.contains(&place) {
                    continue;
                }
                places.push(place);
                let x = self.places.upper[place.0];
                let (up, down) = (height(Side::Upper, x), height(Side::Lower, x));
                let share = f64::from(place.1) / HEIGHTS;
                points.push(DVec2::new(x, down + share * (up - down)));
            }
        }
        (points, places)
    }

    /// Fabric between two lines of nodes, free of stress as it is drawn.
    fn add_between(
        &mut self,
        [foot, top]: [Vec<u32>; 2],
        rib: usize,
        place: f64,
    ) -> Result<(), WingFault> {
        let line =
            |nodes: &[u32]| -> Vec<DVec3> { nodes.iter().map(|&n| self.position(n)).collect() };
        let (foot_line, top_line) = (line(&foot), line(&top));
        let warp = top_line[top_line.len() / 2] - foot_line[foot_line.len() / 2];
        // As many rows of triangles as make edges along both directions alike.
        let edges = |line: &[DVec3]| line.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
        let mean = (edges(&foot_line) + edges(&top_line)) / (foot.len() + top.len() - 2) as f64;
        let height = warp.length();
        let rows = ((height / mean).round() as usize).max(1);
        let ends = [0, 1].map(|side| {
            let end = |nodes: &[u32]| nodes[side * (nodes.len() - 1)];
            [end(&foot), end(&top)]
        });
        let known = ends.map(|key| {
            let edge = self.diagonal_edges.get(&key).cloned();
            edge.filter(|nodes| nodes.len() + 1 == rows)
        });
        let mut made = [Vec::new(), Vec::new()];
        let mut last = foot.clone();
        for r in 1..=rows {
            let share = r as f64 / rows as f64;
            let next = if r == rows {
                top.clone()
            } else {
                let count = (foot.len() as f64 + (top.len() as f64 - foot.len() as f64) * share)
                    .round() as usize;
                let mut nodes = Vec::with_capacity(count);
                for i in 0..count {
                    let side = [0, count - 1].iter().position(|&end| end == i);
                    let shared = side.and_then(|side| known[side].as_ref());
                    nodes.push(match shared {
                        Some(edge) => edge[r - 1],
                        None => {
                            let t = i as f64 / (count - 1) as f64;
                            self.structure
                                .add_node(along(&foot_line, t).lerp(along(&top_line, t), share))
                        }
                    });
                }
                for (side, edge) in made.iter_mut().enumerate() {
                    edge.push(nodes[side * (count - 1)]);
                }
                nodes
            };
            let tag = Tag {
                part: Part::Diagonal,
                number: rib as u32,
                chord_place: place as f32,
            };
            for nodes in strip(&last, &next) {
                // Normals to the right on both halves do not matter: no pressure acts on diagonals.
                self.add_triangle(nodes, warp, tag)?;
            }
            last = next;
        }
        self.diagonal_edges.extend(ends.into_iter().zip(made));
        Ok(())
    }
}

/// Point of a polyline with evenly counted corners.
fn along(line: &[DVec3], t: f64) -> DVec3 {
    let at = t * (line.len() - 1) as f64;
    let i = (at as usize).min(line.len() - 2);
    line[i].lerp(line[i + 1], at - i as f64)
}

/// Triangles between two rows of nodes, whose ends belong together.
fn strip(lower: &[u32], upper: &[u32]) -> Vec<[u32; 3]> {
    let (m, n) = (lower.len() - 1, upper.len() - 1);
    let (mut i, mut j) = (0, 0);
    let mut triangles = Vec::with_capacity(m + n);
    while i < m || j < n {
        // Go on where the next node is less far along its row.
        let advance_lower = j == n || (i < m && (2 * i + 1) * n <= (2 * j + 1) * m);
        if advance_lower {
            triangles.push([lower[i], lower[i + 1], upper[j]]);
            i += 1;
        } else {
            triangles.push([lower[i], upper[j + 1], upper[j]]);
            j += 1;
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_use_every_edge_once() {
        for (m, n) in [(1, 1), (3, 3), (2, 7), (6, 1)] {
            let lower: Vec<u32> = (0..=m).collect();
            let upper: Vec<u32> = (100..=100 + n).collect();
            let triangles = strip(&lower, &upper);
            assert_eq!(triangles.len() as u32, m + n);
            let along_rows = triangles
                .iter()
                .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
                .filter(|(a, b)| (*a < 100) == (*b < 100))
                .count();
            assert_eq!(along_rows as u32, m + n);
        }
    }
}
