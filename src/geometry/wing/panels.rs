//! Panels: the surface between neighbouring ribs, ballooned and with its intakes.

use glam::DVec3;

use super::builder::Builder;
use super::parts::{Part, Tag};
use super::plan::WingFault;
use super::section::Side;
use crate::geometry::table::lookup;

/// Point at share `t` of a circular arc of length w (1 + extra) over the distance w, as (along, out) per w.
#[must_use]
pub(super) fn arc_point(extra: f64, t: f64) -> [f64; 2] {
    if extra <= 0.0 {
        return [t, 0.0];
    }
    let half = half_angle(extra);
    // Radius per w: ½/sin θ; the arc runs from −θ to θ.
    let angle = half * (2.0 * t - 1.0);
    let radius = 0.5 / half.sin();
    [
        0.5 + radius * angle.sin(),
        // That times cos of the angle less cos θ, which small angles would leave without digits.
        2.0 * radius * (half * t).sin() * (half * (1.0 - t)).sin(),
    ]
}

/// Terms of the series in `half_angle`: up to π/2 those left out are below round-off.
const SERIES_TERMS: usize = 14;

/// θ of θ/sin θ = 1 + extra, 0 to π/2 for extras up to π/2 − 1.
fn half_angle(extra: f64) -> f64 {
    // θ/sin θ ≈ 1 + θ²/6 to begin with.
    let mut angle = (6.0 * extra).sqrt().min(1.5);
    if angle <= 0.0 {
        return 0.0;
    }
    for _ in 0..50 {
        let square = angle * angle;
        // (θ − sin θ)/θ³ and (sin θ − θ cos θ)/θ³ as series: differences of small angles have no digits.
        let (mut less_sine, mut less_cosine) = (0.0, 0.0);
        let mut term = 1.0 / 6.0;
        for k in 0..SERIES_TERMS {
            let even = 2.0 * k as f64 + 2.0;
            less_sine += term;
            less_cosine += even * term;
            term *= -square / ((even + 2.0) * (even + 3.0));
        }
        let ratio = angle / angle.sin();
        let slope = angle * ratio * ratio * less_cosine;
        let step = (square * less_sine * ratio - extra) / slope;
        angle -= step;
        if step.abs() <= 1e-15 * angle {
            break;
        }
    }
    angle
}

impl Builder<'_> {
    /// Width of the panel over the distance of its ribs, less 1, at a place of the outline.
    pub(super) fn ballooning(&self, k: usize) -> f64 {
        let [upper, lower] = &self.plan.ballooning;
        let (side, j) = self.side_of(k);
        if j == self.fineness.along_chord {
            // Both panels are sewn together there.
            return 0.0;
        }
        let x = self.places.of(side)[j];
        match (side, j) {
            (_, 0) => 0.5 * (lookup(upper, 0.0) + lookup(lower, 0.0)),
            (Side::Upper, _) => lookup(upper, x),
            (Side::Lower, _) => lookup(lower, x),
        }
    }

    /// True if the quadrilateral from place `k` of the outline to the next is open in a cell.
    fn is_open(&self, cell: usize, k: usize) -> bool {
        let Some(intakes) = self.plan.intakes else {
            return false;
        };
        let is_closed = !intakes.open_cells(self.plan.cells).contains(&cell);
        if is_closed || k < self.fineness.along_chord {
            return false;
        }
        // On the lower side the next place is nearer to the nose.
        let (from, to) = (self.outline_len() - k - 1, self.outline_len() - k);
        let [from, to] = [from, to].map(|j| self.places.lower[j]);
        from > intakes.from - 1e-9 && to < intakes.to + 1e-9
    }

    /// Places of the nodes across a cell at `k`, both ribs' included.
    fn across(&self, cell: usize, k: usize) -> Vec<DVec3> {
        let count = self.outline_len();
        let edges = self.fineness.across_cell;
        let outline = |rib: usize, k: usize| self.position(self.outlines[rib][k % count]);
        let (left, right) = (outline(cell, k), outline(cell + 1, k));
        let along = |rib: usize| outline(rib, k + 1) - outline(rib, k + count - 1);
        let across = right - left;
        let out = (along(cell) + along(cell + 1))
            .cross(across)
            .normalize_or_zero();
        let width = across.length();
        let extra = self.ballooning(k);
        // Mini-ribs divide the panel into two arcs.
        let divided = self.has_mini_rib(k);
        (0..=edges)
            .map(|a| {
                let t = a as f64 / edges as f64;
                if a == 0 {
                    left
                } else if a == edges {
                    right
                } else if divided {
                    let part = if 2 * a >= edges { 1.0 } else { 0.0 };
                    let [x, z] = arc_point(extra, 2.0 * t - part);
                    left + across * (0.5 * (x + part)) + out * (0.5 * z * width)
                } else {
                    let [x, z] = arc_point(extra, t);
                    left + across * x + out * (z * width)
                }
            })
            .collect()
    }

    /// True where mini-ribs hold the middle of a panel.
    pub(super) fn has_mini_rib(&self, k: usize) -> bool {
        let Some(from) = self.plan.mini_ribs_from else {
            return false;
        };
        let (side, j) = self.side_of(k);
        j >= self.places.nearest(side, from)
    }

    /// Nodes of all outlines, then panels cell by cell.
    pub(super) fn add_panels(&mut self) -> Result<(), WingFault> {
        let count = self.outline_len();
        for rib in 0..self.frames.len() {
            let nodes = (0..count)
                .map(|k| {
                    let [x, z] = self.chord_point(rib, k);
                    let place = self.frames[rib].point(x, z);
                    self.structure.add_node(place)
                })
                .collect();
            self.outlines.push(nodes);
        }
        let edges = self.fineness.across_cell;
        for cell in 0..self.plan.cells {
            let open: Vec<bool> = (0..count).map(|k| self.is_open(cell, k)).collect();
            let mut grid: Vec<Vec<Option<u32>>> = Vec::with_capacity(count);
            for k in 0..count {
                let places = self.across(cell, k);
                let inside = open[k] && open[(k + count - 1) % count];
                let row = places
                    .into_iter()
                    .enumerate()
                    .map(|(a, place)| {
                        if a == 0 {
                            Some(self.outlines[cell][k])
                        } else if a == edges {
                            Some(self.outlines[cell + 1][k])
                        } else if inside {
                            None
                        } else {
                            Some(self.structure.add_node(place))
                        }
                    })
                    .collect();
                grid.push(row);
            }
            for k in 0..count {
                if open[k] {
                    continue;
                }
                let next = (k + 1) % count;
                let part = if k < self.fineness.along_chord {
                    Part::Upper
                } else {
                    Part::Lower
                };
                let middle = 0.5 * (self.chord_point(cell, k)[0] + self.chord_point(cell, next)[0]);
                let tag = Tag {
                    part,
                    number: cell as u32,
                    chord_place: middle as f32,
                };
                let warp = self.position(self.outlines[cell][next])
                    - self.position(self.outlines[cell][k])
                    + self.position(self.outlines[cell + 1][next])
                    - self.position(self.outlines[cell + 1][k]);
                for a in 0..edges {
                    let corners = [grid[k][a], grid[next][a], grid[next][a + 1], grid[k][a + 1]];
                    let [Some(p), Some(q), Some(r), Some(s)] = corners else {
                        continue;
                    };
                    // Alternate diagonals; with an even number across, both halves are mirror images.
                    let halves = if (k + a).is_multiple_of(2) {
                        [[p, q, r], [p, r, s]]
                    } else {
                        [[p, q, s], [q, r, s]]
                    };
                    for nodes in halves {
                        self.add_triangle(nodes, warp, tag)?;
                    }
                }
            }
            let rows = grid
                .iter()
                .map(|row| row[1..edges].iter().copied().flatten().collect());
            self.rows_across.push(rows.collect());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_have_their_length() {
        for extra in [1e-6, 0.01, 0.1, 0.5] {
            let mut length = 0.0;
            let points: Vec<[f64; 2]> = (0..=4000)
                .map(|i| arc_point(extra, f64::from(i) / 4000.0))
                .collect();
            for pair in points.windows(2) {
                length += (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            }
            assert!((length - 1.0 - extra).abs() < 1e-6, "{extra} {length}");
            assert!(points[0][0].abs() < 1e-12 && points[4000][1].abs() < 1e-12);
        }
    }

    /// Flat arcs have the angle of the series θ² = 6 b (1 − 7 b/10 + 94 b²/175 − …) and stand out by tan(θ/2)/2, however little their ballooning b is.
    #[test]
    fn flat_arcs_follow_their_series() {
        let ladder = (1..=12).map(|k| 10f64.powi(-k));
        for extra in ladder.chain([1e-17, 1e-100]) {
            let series = 1.0 - 0.7 * extra + 94.0 / 175.0 * extra * extra;
            let expected = (6.0 * extra * series).sqrt();
            let allowed = 0.3 * extra.powi(3) + 1e-14;
            let angle = half_angle(extra);
            assert!(
                (angle / expected - 1.0).abs() < allowed,
                "{extra:e}: {angle:e} {expected:e}"
            );
            let [along, out] = arc_point(extra, 0.5);
            let height = 0.5 * (0.5 * expected).tan();
            assert!((along - 0.5).abs() < 1e-15, "{extra:e}: {along}");
            assert!(
                (out / height - 1.0).abs() < 2.0 * allowed,
                "{extra:e}: {out:e} {height:e}"
            );
            let [along, out] = arc_point(extra, 1.0);
            assert!((along - 1.0).abs() < 1e-15 && out == 0.0, "{along} {out}");
        }
        assert_eq!(half_angle(0.0), 0.0);
        assert_eq!(arc_point(0.0, 0.25), [0.25, 0.0]);
    }
}
