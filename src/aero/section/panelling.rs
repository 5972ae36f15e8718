//! Panels along an outline: short where it curves and at the trailing edge.
//!
//! Nodes are spread over the length s with the density ρ(s) that solves ρ − ℓ² ρ'' = raw density, so that neighbouring panels differ little.
//! The raw density grows with a power of the curvature. This is our own law; Drela (1989) asks only for about 150 panels that bunch at the nose.

use glam::DVec2;

use super::error::SectionError;
use super::outline;
use crate::geometry::spline::Spline;

/// Curvature's part in the density: factor and power.
const CURVATURE: [f64; 2] = [0.55, 0.65];

/// Density that the trailing edge adds, and over which length it fades [chords].
const TRAILING_EDGE: [f64; 2] = [2.5, 0.03];

/// Length ℓ over which the density is smoothed [chords].
const SMOOTHING: f64 = 0.012;

/// Samples per panel for the density.
const SAMPLES: usize = 12;

/// A trailing edge open by less counts as closed [chords].
const CLOSED_GAP: f64 = 1e-4;

/// An outline made of straight panels, clockwise, the air on the left of the way.
#[derive(Debug, Clone)]
pub struct Panels {
    /// Ends of the panels, from the lower trailing edge to the upper one.
    pub nodes: Vec<DVec2>,
    /// Length along the panels from the lower trailing edge to each node.
    pub along: Vec<f64>,
    /// Height of an open trailing edge across the wake; zero where it is closed.
    pub gap: f64,
    /// Direction in which the trailing edge points.
    pub bisector: DVec2,
    /// How fast both sides close at the trailing edge, thickness per length; positive where they close.
    pub closing: f64,
}

impl Panels {
    /// Checks an outline and covers it with panels.
    pub fn new(points: &[DVec2], count: usize) -> Result<Self, SectionError> {
        outline::check(points)?;
        if !(40..=600).contains(&count) {
            return Err(SectionError::Outline(format!(
                "{count} panels were asked for; 40 to 600 are possible"
            )));
        }
        let curve = Spline::new(points.to_vec());
        let mut nodes = spread(&curve, count);
        if nodes[0].distance(nodes[count]) < CLOSED_GAP {
            let middle = 0.5 * (nodes[0] + nodes[count]);
            nodes[0] = middle;
            nodes[count] = middle;
        }
        Ok(Self::from_nodes(nodes))
    }

    /// Takes points as the panels' ends.
    pub fn from_nodes(nodes: Vec<DVec2>) -> Self {
        let last = nodes.len() - 1;
        let mut along = vec![0.0; last + 1];
        for k in 1..=last {
            along[k] = along[k - 1] + nodes[k].distance(nodes[k - 1]);
        }
        // Both point downstream.
        let lower = (nodes[0] - nodes[1]).normalize_or_zero();
        let upper = (nodes[last] - nodes[last - 1]).normalize_or_zero();
        let bisector = (lower + upper).normalize_or_zero();
        let gap = bisector.perp_dot(nodes[last] - nodes[0]).abs();
        Self {
            nodes,
            along,
            gap,
            bisector,
            closing: upper.perp_dot(lower),
        }
    }

    /// Nodes.
    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the trailing edge is closed.
    pub fn is_sharp(&self) -> bool {
        self.nodes[0] == self.nodes[self.nodes.len() - 1]
    }

    /// Middle of the trailing edge.
    pub fn trailing_edge(&self) -> DVec2 {
        0.5 * (self.nodes[0] + self.nodes[self.nodes.len() - 1])
    }
}

/// Nodes along a curve.
fn spread(curve: &Spline, count: usize) -> Vec<DVec2> {
    let samples = SAMPLES * count;
    let step = curve.length() / samples as f64;
    let raw: Vec<f64> = (0..=samples)
        .map(|k| {
            let from_edge = step * k.min(samples - k) as f64;
            let bent = curve.curvature(step * k as f64).min(1000.0);
            1.0 + CURVATURE[0] * bent.powf(CURVATURE[1])
                + TRAILING_EDGE[0] * (-from_edge / TRAILING_EDGE[1]).exp()
        })
        .collect();
    let density = smooth(&raw, (SMOOTHING / step).powi(2));
    let mut sums = vec![0.0; samples + 1];
    for k in 1..=samples {
        sums[k] = sums[k - 1] + 0.5 * (density[k] + density[k - 1]);
    }
    (0..=count)
        .map(|k| {
            let target = sums[samples] * k as f64 / count as f64;
            let after = sums.partition_point(|&s| s < target).clamp(1, samples);
            let share = (target - sums[after - 1]) / (sums[after] - sums[after - 1]);
            curve.place(step * (after as f64 - 1.0 + share))
        })
        .collect()
}

/// Solves ρ − k (ρ₊ − 2 ρ + ρ₋) = raw with no slope at the ends, by Thomas's algorithm.
fn smooth(raw: &[f64], k: f64) -> Vec<f64> {
    let count = raw.len();
    let mut upper = vec![0.0; count];
    let mut result = raw.to_vec();
    for i in 0..count {
        let below = if i > 0 { k } else { 0.0 };
        let above = if i + 1 < count { k } else { 0.0 };
        let (before, left) = if i > 0 {
            (upper[i - 1], result[i - 1])
        } else {
            (0.0, 0.0)
        };
        let pivot = 1.0 + below + above - below * before;
        upper[i] = above / pivot;
        result[i] = (raw[i] + below * left) / pivot;
    }
    for i in (0..count - 1).rev() {
        let next = result[i + 1];
        result[i] += upper[i] * next;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    /// Neighbouring panels of a usual section differ by less than a quarter, and the nose's are the shortest.
    #[test]
    fn panels_grow_gently() {
        for designation in ["0012", "4418", "2412"] {
            let panels = Panels::new(&shapes::naca(designation), 160).unwrap();
            let lengths: Vec<f64> = panels.along.windows(2).map(|s| s[1] - s[0]).collect();
            let growth = lengths
                .windows(2)
                .map(|l| (l[1] / l[0]).max(l[0] / l[1]))
                .fold(0.0, f64::max);
            assert!(growth < 1.25, "{designation} {growth}");
            let shortest = lengths.iter().copied().fold(1.0, f64::min);
            let at = lengths.iter().position(|&l| l == shortest).unwrap();
            assert!(panels.nodes[at].x < 0.01);
            assert!(!panels.is_sharp() && panels.gap > 0.002);
        }
    }

    /// Each kind of bad outline gets its own words.
    #[test]
    fn bad_outlines_are_refused() {
        let good = shapes::naca("2412");
        let refused = |points: &[DVec2], word: &str| match Panels::new(points, 160) {
            Err(SectionError::Outline(text)) => assert!(text.contains(word), "{text}"),
            other => panic!("{word}: {other:?}"),
        };
        Panels::new(&good, 160).unwrap();
        refused(&good[..6], "too few");
        refused(&[], "too few");
        let mut bad = good.clone();
        bad[20].y = f64::NAN;
        refused(&bad, "finite");
        let mut bad = good.clone();
        bad[20] = bad[21];
        refused(&bad, "coincide");
        let reversed: Vec<DVec2> = good.iter().rev().copied().collect();
        refused(&reversed, "lower side");
        let mut bad = good.clone();
        bad[60].y += 0.3;
        refused(&bad, "crosses");
        let flat: Vec<DVec2> = good.iter().map(|p| DVec2::new(p.x, 0.0)).collect();
        refused(&flat, "");
        let thin: Vec<DVec2> = good.iter().map(|p| DVec2::new(p.x, 1e-5 * p.y)).collect();
        refused(&thin, "area");
        let long: Vec<DVec2> = good.iter().map(|&p| 2.0 * p).collect();
        refused(&long, "chord");
        assert!(Panels::new(&good, 3).is_err() && Panels::new(&good, 5000).is_err());
    }
}
