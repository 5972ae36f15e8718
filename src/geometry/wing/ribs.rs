//! What stands inside a wing: ribs with holes, mini-ribs, diagonals and tapes.

use glam::{DVec2, DVec3};

use super::builder::Builder;
use super::parts::{LineKind, Part, Tag};
use super::plan::{Row, WingFault};
use super::planar;
use super::section::Side;
use crate::frame::CableKind;

/// Least number of edges around a hole.
const LEAST_HOLE_EDGES: usize = 8;

/// Places of attachments at which diagonals have room, per chord.
const DIAGONALS: std::ops::RangeInclusive<f64> = 0.02..=0.9;

impl Builder<'_> {
    /// Rib of a number counted from the middle, on the right and on the left; both are the same in the plane of symmetry.
    pub(super) fn counted(&self, from_middle: usize) -> [usize; 2] {
        let cells = self.plan.cells;
        if cells.is_multiple_of(2) {
            [cells / 2 + from_middle, cells / 2 - from_middle]
        } else {
            // There is no rib 0.
            [
                cells.div_ceil(2) + from_middle - 1,
                cells / 2 + 1 - from_middle,
            ]
        }
    }

    /// Number of a rib counted from the middle.
    pub(super) fn count_of(&self, rib: usize) -> usize {
        let cells = self.plan.cells;
        let twice = (2 * rib).abs_diff(cells);
        twice.div_ceil(2)
    }

    fn is_tip(&self, rib: usize) -> bool {
        rib == 0 || rib == self.plan.cells
    }

    /// Outline of a rib in its plane, per chord.
    fn outline(&self, rib: usize) -> Vec<DVec2> {
        (0..self.outline_len())
            .map(|k| DVec2::from_array(self.chord_point(rib, k)))
            .collect()
    }

    fn holes(&self, rib: usize, mean_edge: f64) -> Vec<Vec<DVec2>> {
        if self.is_tip(rib) {
            return Vec::new();
        }
        let frame = &self.frames[rib];
        let height = |side, x| frame.height(&self.plan.profiles, side, x);
        let bent = |hole: &super::plan::Hole| {
            let (up, down) = (
                height(Side::Upper, hole.position),
                height(Side::Lower, hole.position),
            );
            let around = std::f64::consts::PI * 0.5 * (hole.width + hole.height * (up - down));
            let count = ((around / mean_edge).round() as usize).max(LEAST_HOLE_EDGES);
            (0..count)
                .map(|i| {
                    let (sin, cos) = (std::f64::consts::TAU * i as f64 / count as f64).sin_cos();
                    let x = hole.position + 0.5 * hole.width * cos;
                    let (up, down) = (height(Side::Upper, x), height(Side::Lower, x));
                    DVec2::new(x, 0.5 * (up + down) + 0.5 * hole.height * (up - down) * sin)
                })
                .collect()
        };
        self.plan.holes.iter().map(bent).collect()
    }

    /// Ribs from the middle outwards; the triangulation of the right one serves the left one, too.
    pub(super) fn add_ribs(&mut self) -> Result<(), WingFault> {
        let first = self.plan.cells.div_ceil(2);
        for rib in first..=self.plan.cells {
            let outline = self.outline(rib);
            let mean_edge = mean_edge(&outline);
            let refused = WingFault::Rib {
                rib: self.count_of(rib),
            };
            let filled = planar::fill(&outline, &self.holes(rib, mean_edge)).ok_or(refused)?;
            let other = self.plan.cells - rib;
            self.add_rib(rib, &filled)?;
            if other != rib {
                self.add_rib(other, &filled)?;
            }
        }
        if self.plan.mini_ribs_from.is_some() {
            for cell in (0..self.plan.cells).rev() {
                self.add_mini_rib(cell)?;
            }
        }
        Ok(())
    }

    fn add_rib(&mut self, rib: usize, filled: &planar::Filled) -> Result<(), WingFault> {
        let mut nodes = self.outlines[rib].clone();
        let frame = self.frames[rib];
        for point in &filled.points[nodes.len()..] {
            nodes.push(self.structure.add_node(frame.point(point.x, point.y)));
        }
        self.add_filled(filled, &nodes, Part::Rib, rib, frame.aft)
    }

    /// Adds the triangles of a filled outline in a plane along the chord, with normals to the right.
    fn add_filled(
        &mut self,
        filled: &planar::Filled,
        nodes: &[u32],
        part: Part,
        number: usize,
        warp: DVec3,
    ) -> Result<(), WingFault> {
        for &[a, b, c] in &filled.triangles {
            let middle = [a, b, c]
                .map(|i| filled.points[i as usize].x)
                .iter()
                .sum::<f64>()
                / 3.0;
            let tag = Tag {
                part,
                number: number as u32,
                chord_place: middle as f32,
            };
            // Counter-clockwise in (x, z) looks to the left.
            self.add_triangle([a, c, b].map(|i| nodes[i as usize]), warp, tag)?;
        }
        Ok(())
    }

    /// A short rib between the middles of both panels of a cell, where both have nodes.
    fn add_mini_rib(&mut self, cell: usize) -> Result<(), WingFault> {
        let chosen: Vec<usize> = (0..self.outline_len())
            .filter(|&k| self.has_mini_rib(k))
            .collect();
        let middle = self.fineness.across_cell / 2 - 1;
        let found: Option<Vec<u32>> = chosen
            .iter()
            .map(|&k| self.rows_across[cell][k].get(middle).copied())
            .collect();
        let Some(mut nodes) = found else {
            return Ok(());
        };
        // Along the upper side to the trailing edge and back along the lower one.
        let mean = |k: usize| {
            let [a, b] = [cell, cell + 1].map(|rib| DVec2::from_array(self.chord_point(rib, k)));
            0.5 * (a + b)
        };
        let mut outline: Vec<DVec2> = chosen.iter().map(|&k| mean(k)).collect();
        let (upper, lower) = (outline[0], outline[outline.len() - 1]);
        let front = upper.distance(lower);
        let count = ((front / mean_edge(&outline)).round() as usize).max(1);
        for i in 1..count {
            outline.push(lower.lerp(upper, i as f64 / count as f64));
        }
        // Counter-clockwise.
        outline.reverse();
        let refused = WingFault::Rib {
            rib: self.count_of(cell),
        };
        let filled = planar::fill(&outline, &[]).ok_or(refused)?;
        let frames = [self.frames[cell], self.frames[cell + 1]];
        let place = |p: DVec2| 0.5 * (frames[0].point(p.x, p.y) + frames[1].point(p.x, p.y));
        for i in 1..count {
            let on_front = lower.lerp(upper, i as f64 / count as f64);
            nodes.push(self.structure.add_node(place(on_front)));
        }
        nodes.reverse();
        for point in &filled.points[nodes.len()..] {
            nodes.push(self.structure.add_node(place(*point)));
        }
        let warp = frames[0].aft + frames[1].aft;
        self.add_filled(&filled, &nodes, Part::MiniRib, cell, warp)
    }

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

    fn add_diagonal(
        &mut self,
        row: &Row,
        place: f64,
        [rib, head]: [usize; 2],
    ) -> Result<(), WingFault> {
        let Some(shape) = row.diagonals else {
            return Ok(());
        };
        let span = |side, width| self.places.around(side, place, width);
        let feet = span(Side::Lower, shape.foot);
        let heads = span(Side::Upper, shape.head);
        let nodes_of = |rib: usize, side, [first, last]: [usize; 2]| -> Vec<u32> {
            (first..=last)
                .map(|j| self.outlines[rib][self.on_outline(side, j)])
                .collect()
        };
        let foot = nodes_of(rib, Side::Lower, feet);
        let top = nodes_of(head, Side::Upper, heads);
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

    /// Tapes from tip to tip.
    pub(super) fn add_tapes(&mut self) {
        let plan = self.plan;
        for (number, tape) in plan.tapes.iter().enumerate() {
            let j = self.places.nearest(tape.side, tape.position);
            let k = self.on_outline(tape.side, j);
            let mut nodes = vec![self.outlines[0][k]];
            for cell in 0..plan.cells {
                if tape.sewn {
                    nodes.extend(&self.rows_across[cell][k]);
                }
                nodes.push(self.outlines[cell + 1][k]);
            }
            let places: Vec<DVec3> = nodes.iter().map(|&n| self.position(n)).collect();
            let lengths: Vec<f64> = places.windows(2).map(|p| p[0].distance(p[1])).collect();
            let kinds = lengths.iter().map(|_| LineKind::Tape(number));
            self.line_kinds.extend(kinds);
            self.structure
                .add_cable(&nodes, &lengths, &tape.cable, CableKind::Belt);
        }
    }
}

fn mean_edge(outline: &[DVec2]) -> f64 {
    let lengths = outline.windows(2).map(|p| p[0].distance(p[1]));
    lengths.sum::<f64>() / (outline.len() - 1) as f64
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
