//! The surface that the air sees: sections at the ribs of the flown mesh, widened by what the cells beside them bulge in the mean.
//!
//! Both halves are averaged to one symmetric half. Places around a section are counted by s = −√(x/c) on the lower and +√(x/c) on the upper side,
//! along which a round nose is smooth; sections are curves through the rib's nodes (cubic Hermite over s with slopes of parabolas). The openings of
//! the cells are closed: what stands before them is the pressure of their panels.

use glam::DVec3;

use crate::aero::surface::mirrored;
use crate::geometry::wing::BuiltWing;

/// Panels before a mouth stand so many times as close as far from it: the pressure inside hangs on them.
const CLOSER_AT_MOUTHS: f64 = 3.0;

/// Lengths of the mouth over which that fades on either side, since neighbours of unlike length disturb each other's pressure.
const FADES_OVER: f64 = 2.0;

/// Points of the sum by which panels are spread along a side.
const GRADING_POINTS: usize = 2000;

/// Which ribs and places of the mesh make panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Skin {
    /// Panels along each side.
    pub per_side: usize,
    /// Sections as distance from the middle in cells, growing, from 0 to half the cells.
    pub sections: Vec<f64>,
    /// Coordinate s of the panels' nodes, from −1 to 1, `[2 per_side + 1]`.
    pub around: Vec<f64>,
    /// Coordinate s of the outline's nodes from the trailing edge below to that above, `[2 along_chord + 1]`.
    knots: Vec<f64>,
    cells: usize,
}

/// Nodes s = √(x/c) of the panels of a side, from 0 to 1: even in arcsin s, which is close together at the trailing edge, and closer before a mouth.
fn graded(per_side: usize, mouth: Option<[f64; 2]>) -> Vec<f64> {
    let quarter = 0.5 * std::f64::consts::PI;
    let Some(lips) = mouth else {
        let node = |i: usize| (quarter * i as f64 / per_side as f64).sin();
        return (0..=per_side).map(node).collect();
    };
    let [front, rear] = lips.map(f64::asin);
    let fades_over = FADES_OVER * (rear - front);
    let step = quarter / GRADING_POINTS as f64;
    // Growing sums of the density.
    let mut sums = vec![0.0];
    for i in 0..GRADING_POINTS {
        let angle = (i as f64 + 0.5) * step;
        let away = (front - angle).max(angle - rear).max(0.0);
        let closeness = (1.0 - away / fades_over).max(0.0);
        let density = 1.0 + (CLOSER_AT_MOUTHS - 1.0) * closeness;
        sums.push(sums[i] + density * step);
    }
    // Lips are nodes: the outline may have a corner there.
    let whole = sums[GRADING_POINTS];
    let at = |angle: f64| sums[((angle / step).round() as usize).min(GRADING_POINTS)];
    let ends = [0.0, at(front), at(rear), whole];
    let counts = shared_out(per_side, [0, 1, 2].map(|k| (ends[k + 1] - ends[k]) / whole));
    let mut nodes = vec![0.0];
    for (pair, count) in ends.windows(2).zip(counts) {
        for i in 1..=count {
            let sum = pair[0] + (pair[1] - pair[0]) * i as f64 / count as f64;
            let next = sums.partition_point(|s| *s < sum).clamp(1, GRADING_POINTS);
            let share = (sum - sums[next - 1]) / (sums[next] - sums[next - 1]);
            nodes.push((((next - 1) as f64 + share) * step).sin());
        }
    }
    nodes[counts[0]] = lips[0];
    nodes[counts[0] + counts[1]] = lips[1];
    nodes[per_side] = 1.0;
    nodes
}

/// Whole numbers with a sum, next to shares of it; one at least of each share that is there.
fn shared_out(sum: usize, shares: [f64; 3]) -> [usize; 3] {
    let wanted = |share: f64| match (share * sum as f64).round() as usize {
        0 => usize::from(share > 0.0),
        count => count,
    };
    let [ahead, within] = [shares[0], shares[1]].map(wanted);
    let ahead = ahead.min(sum - 2);
    let within = within.min(sum - ahead - 1);
    [ahead, within, sum - ahead - within]
}

impl Skin {
    /// Sections at all ribs, or at about `strips + 1` of them.
    #[must_use]
    pub fn new(wing: &BuiltWing, per_side: usize, strips: usize) -> Self {
        let cells = wing.cells;
        let half = 0.5 * cells as f64;
        let mut all: Vec<f64> = (0..=cells)
            .map(|rib| rib as f64 - half)
            .filter(|u| *u >= 0.0)
            .collect();
        if all[0] > 0.0 {
            // An odd number of cells: the middle of the middle one.
            all.insert(0, 0.0);
        }
        let last = all.len() - 1;
        let count = strips.clamp(2.min(last), last);
        let mut sections: Vec<f64> = (0..=count)
            .map(|i| all[(i * last + count / 2) / count])
            .collect();
        sections.dedup();
        let mouth = wing
            .intakes
            .map(|intakes| [intakes.from, intakes.to].map(f64::sqrt));
        let side = graded(per_side, mouth);
        let lower = side.iter().skip(1).rev().map(|s| -s);
        let around = lower.chain(side.iter().copied()).collect();
        let lower = wing.places.lower.iter().rev().map(|x| -x.sqrt());
        let upper = wing.places.upper.iter().skip(1).map(|x| x.sqrt());
        Self {
            per_side,
            sections,
            around,
            knots: lower.chain(upper).collect(),
            cells,
        }
    }

    /// Number of panels, the cap's included.
    #[must_use]
    pub const fn panel_count(&self) -> usize {
        2 * self.per_side * (self.sections.len() - 1) + self.per_side
    }

    /// Distance of a cell's middle from the plane of symmetry, in cells.
    #[must_use]
    pub fn of_cell(&self, cell: usize) -> f64 {
        (cell as f64 + 0.5 - 0.5 * self.cells as f64).abs()
    }

    /// Middles of the strips, in cells from the plane of symmetry.
    #[must_use]
    pub fn strip_middles(&self) -> Vec<f64> {
        let pairs = self.sections.windows(2);
        pairs.map(|p| 0.5 * (p[0] + p[1])).collect()
    }

    /// The strip that a cell lies in.
    #[must_use]
    pub fn strip_of(&self, cell: usize) -> usize {
        let next = self.sections.partition_point(|u| *u < self.of_cell(cell));
        next.clamp(1, self.sections.len() - 1) - 1
    }

    /// Share of the area of every strip, as designed, whose cells have an intake.
    #[must_use]
    pub fn open_shares(&self, wing: &BuiltWing) -> Vec<f64> {
        let open = wing.intakes.map(|intakes| intakes.open_cells(wing.cells));
        let mut areas = vec![[0.0; 2]; self.sections.len() - 1];
        for cell in 0..wing.cells {
            let [all, opened] = &mut areas[self.strip_of(cell)];
            let area = wing.flat_cell_area_m2(cell);
            *all += area;
            if open.as_ref().is_some_and(|open| open.contains(&cell)) {
                *opened += area;
            }
        }
        areas.iter().map(|[all, opened]| opened / all).collect()
    }

    /// Nodes of the panel surface for positions of the mesh [m], section by section as `PanelSurface::new` takes them.
    #[must_use]
    pub fn nodes_m(&self, wing: &BuiltWing, positions_m: &[DVec3]) -> Vec<DVec3> {
        let mut nodes = Vec::with_capacity(self.sections.len() * self.around.len());
        for &u in &self.sections {
            let half = 0.5 * self.cells as f64;
            let outline = if (u + half).fract() == 0.0 {
                let [right, left] = [half + u, half - u].map(|rib| rib as usize);
                let [a, b] = [right, left].map(|rib| self.at_rib(wing, positions_m, rib));
                mean_of_halves(&a, &b)
            } else {
                let cell = self.cells / 2;
                let bulge = self.bulge(wing, positions_m, cell);
                let [a, b] = [cell, cell + 1].map(|rib| self.outline(wing, positions_m, rib));
                let middle: Vec<DVec3> = a
                    .iter()
                    .zip(&b)
                    .zip(&bulge)
                    .map(|((a, b), bulge)| 0.5 * (*a + *b) + *bulge)
                    .collect();
                mean_of_halves(&middle, &middle)
            };
            nodes.extend(self.around.iter().map(|&s| self.curve(&outline, s)));
        }
        nodes
    }

    /// Nodes of a rib's outline from the trailing edge along the lower side to the trailing edge.
    fn outline(&self, wing: &BuiltWing, positions_m: &[DVec3], rib: usize) -> Vec<DVec3> {
        let nodes = &wing.outlines[rib];
        let count = nodes.len();
        (0..=count)
            .map(|m| positions_m[nodes[(count / 2 + m) % count] as usize])
            .collect()
    }

    /// The same with half of what the cells on both sides bulge; tips as they are.
    fn at_rib(&self, wing: &BuiltWing, positions_m: &[DVec3], rib: usize) -> Vec<DVec3> {
        let mut outline = self.outline(wing, positions_m, rib);
        if rib == 0 || rib == self.cells {
            return outline;
        }
        for cell in [rib - 1, rib] {
            let bulge = self.bulge(wing, positions_m, cell);
            for (place, bulge) in outline.iter_mut().zip(bulge) {
                *place += 0.5 * bulge;
            }
        }
        outline
    }

    /// How far the mean of a cell's panel stands from the straight line between its ribs [m], along the outline; over an opening as at its
    /// edges.
    fn bulge(&self, wing: &BuiltWing, positions_m: &[DVec3], cell: usize) -> Vec<DVec3> {
        let count = wing.outlines[cell].len();
        let place = |node: u32| positions_m[node as usize];
        let known: Vec<Option<DVec3>> = (0..=count)
            .map(|m| {
                let k = (count / 2 + m) % count;
                let across = &wing.rows_across[cell][k];
                if across.is_empty() {
                    return None;
                }
                let ends =
                    0.5 * (place(wing.outlines[cell][k]) + place(wing.outlines[cell + 1][k]));
                let inside: DVec3 = across.iter().map(|n| place(*n)).sum();
                // Trapezoidal rule.
                Some((inside + ends) / (across.len() + 1) as f64 - ends)
            })
            .collect();
        let nearest = |m: usize, step: isize| -> Option<(usize, DVec3)> {
            let mut at = m as isize;
            while let Ok(index) = usize::try_from(at) {
                match known.get(index)? {
                    Some(bulge) => return Some((index, *bulge)),
                    None => at += step,
                }
            }
            None
        };
        (0..=count)
            .map(|m| match (nearest(m, -1), nearest(m, 1)) {
                (Some((a, p)), Some((b, q))) if b > a => p.lerp(q, (m - a) as f64 / (b - a) as f64),
                (Some((_, p)), _) | (None, Some((_, p))) => p,
                (None, None) => DVec3::ZERO,
            })
            .collect()
    }

    /// Point of a curve through an outline's nodes at s.
    fn curve(&self, points: &[DVec3], s: f64) -> DVec3 {
        let knots = &self.knots;
        let last = knots.len() - 1;
        let i = knots.partition_point(|k| *k <= s).clamp(1, last) - 1;
        let slope = |i: usize| (points[i + 1] - points[i]) / (knots[i + 1] - knots[i]);
        let tangent = |i: usize| {
            if i == 0 {
                slope(0)
            } else if i == last {
                slope(last - 1)
            } else {
                let (a, b) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
                (slope(i - 1) * b + slope(i) * a) / (a + b)
            }
        };
        let width = knots[i + 1] - knots[i];
        let t = (s - knots[i]) / width;
        let (t2, t3) = (t * t, t * t * t);
        points[i] * (2.0 * t3 - 3.0 * t2 + 1.0)
            + tangent(i) * (width * (t3 - 2.0 * t2 + t))
            + points[i + 1] * (3.0 * t2 - 2.0 * t3)
            + tangent(i + 1) * (width * (t3 - t2))
    }
}

fn mean_of_halves(right: &[DVec3], left: &[DVec3]) -> Vec<DVec3> {
    right
        .iter()
        .zip(left)
        .map(|(r, l)| 0.5 * (*r + mirrored(*l)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Growing from the nose to the trailing edge, with nodes at the lips and three panels of 20 between them at least, and no great jump in their length; even without a mouth.
    #[test]
    fn panels_stand_closer_before_a_mouth() {
        // Of a mouth far behind the nose, too.
        for per_side in [4, 20] {
            let nodes = graded(per_side, Some([0.95, 0.99]));
            assert!(nodes.windows(2).all(|pair| pair[1] > pair[0]), "{nodes:?}");
        }
        for (mouth, least) in [([0.126, 0.251], 3), ([0.1, 0.22], 3), ([0.0, 0.256], 4)] {
            for per_side in [4, 10, 20, 40] {
                let nodes = graded(per_side, Some(mouth));
                assert_eq!(
                    (nodes.len(), nodes[0], nodes[per_side]),
                    (per_side + 1, 0.0, 1.0)
                );
                assert!(nodes.windows(2).all(|pair| pair[1] > pair[0]), "{nodes:?}");
                let lengths: Vec<f64> = nodes
                    .windows(2)
                    .map(|p| p[1].asin() - p[0].asin())
                    .collect();
                let ratio = |p: &[f64]| (p[1] / p[0]).max(p[0] / p[1]);
                let most = lengths.windows(2).map(ratio).fold(0.0, f64::max);
                assert!(per_side < 20 || most < 1.8, "{most} {nodes:?}");
                let is_there = |lip: f64| nodes.iter().any(|s| (s - lip).abs() < 1e-12);
                assert!(mouth.into_iter().all(is_there), "{mouth:?} {nodes:?}");
                let within = nodes
                    .iter()
                    .filter(|s| (mouth[0]..mouth[1]).contains(*s))
                    .count();
                assert!(per_side < 20 || within >= least, "{mouth:?} {nodes:?}");
            }
        }
        let even = graded(20, None);
        assert!((even[7] - (35.0f64 / 200.0 * std::f64::consts::PI).sin()).abs() < 1e-12);
    }
}
