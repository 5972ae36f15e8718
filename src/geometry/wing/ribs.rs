//! What stands inside a wing: ribs with holes, mini-ribs and tapes.

use glam::{DVec2, DVec3};

use super::builder::{Builder, SeamPlace};
use super::parts::{LineKind, Part, Tag};
use super::plan::{VhRibEnd, WingFault};
use super::planar;
use super::section::Side;
use crate::frame::CableKind;

/// Least number of edges around a hole.
const LEAST_HOLE_EDGES: usize = 8;

/// Distance between a hole and the seam of a V- or H-rib below which the hole is left out, per chord and per height of the rib.
const BESIDE_A_HOLE: f64 = 0.02;

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

    /// But for those that lie where a V- or H-rib is sewn on.
    fn holes(&self, rib: usize, mean_edge: f64) -> Vec<Vec<DVec2>> {
        if self.is_tip(rib) {
            return Vec::new();
        }
        let seams: Vec<&VhRibEnd> = self.seams(rib).collect();
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
        let is_free = |hole: &&super::plan::Hole| {
            !seams.iter().any(|end| {
                let [first, last] = self.span(Side::Upper, end);
                let places = &self.places.upper;
                let reach = 0.5 * hole.width + BESIDE_A_HOLE;
                places[first] < hole.position + reach
                    && places[last] > hole.position - reach
                    && (end.height - 0.5).abs() < 0.5 * hole.height + BESIDE_A_HOLE
            })
        };
        self.plan.holes.iter().filter(is_free).map(bent).collect()
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
            let holes = self.holes(rib, mean_edge);
            let (seams, places) = self.seam_points(rib);
            let filled = planar::fill(&outline, &holes, &seams).ok_or(refused)?;
            let first = outline.len() + holes.iter().map(Vec::len).sum::<usize>();
            let other = self.plan.cells - rib;
            self.add_rib(rib, &filled, (first, &places))?;
            if other != rib {
                self.add_rib(other, &filled, (first, &places))?;
            }
        }
        if self.plan.mini_ribs_from.is_some() {
            for cell in (0..self.plan.cells).rev() {
                self.add_mini_rib(cell)?;
            }
        }
        Ok(())
    }

    /// Points of the filled outline from the `first` on lie at places of V- and H-ribs.
    fn add_rib(
        &mut self,
        rib: usize,
        filled: &planar::Filled,
        (first, places): (usize, &[SeamPlace]),
    ) -> Result<(), WingFault> {
        let mut nodes = self.outlines[rib].clone();
        let frame = self.frames[rib];
        for point in &filled.points[nodes.len()..] {
            nodes.push(self.structure.add_node(frame.point(point.x, point.y)));
        }
        let seams = places.iter().zip(&nodes[first..]);
        self.seam_nodes
            .extend(seams.map(|(place, node)| ((rib, *place), *node)));
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
        let filled = planar::fill(&outline, &[], &[]).ok_or(WingFault::MiniRib { cell })?;
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
