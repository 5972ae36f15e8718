//! Outlines of sections: what is refused, and the curve through the points.
//!
//! Points go from the trailing edge along the lower side around the nose and along the upper side to the trailing edge, in chords, with the
//! nose near x = 0 and the trailing edge near x = 1. The curve is a natural cubic spline over the length of the points' polygon.

use glam::DVec2;

use super::error::SectionError;

/// A trailing edge may be open by this much [chords].
const WIDEST_GAP: f64 = 0.05;

/// Thinner outlines than this are refused [chords].
const LEAST_THICKNESS: f64 = 0.002;

/// A curve over the length along its points.
#[derive(Debug, Clone)]
pub struct Curve {
    points: Vec<DVec2>,
    lengths: Vec<f64>,
    /// Second derivatives at the points.
    bends: Vec<DVec2>,
}

impl Curve {
    /// A natural cubic spline.
    pub fn new(points: Vec<DVec2>) -> Self {
        let count = points.len();
        let mut lengths = vec![0.0; count];
        for k in 1..count {
            lengths[k] = lengths[k - 1] + points[k].distance(points[k - 1]);
        }
        // Thomas's algorithm for the second derivatives, which vanish at the ends.
        let mut bends = vec![DVec2::ZERO; count];
        let mut upper = vec![0.0; count];
        for k in 1..count - 1 {
            let (before, after) = (lengths[k] - lengths[k - 1], lengths[k + 1] - lengths[k]);
            let turn = (points[k + 1] - points[k]) / after - (points[k] - points[k - 1]) / before;
            let pivot = 2.0 * (before + after) - before * upper[k - 1];
            upper[k] = after / pivot;
            bends[k] = (6.0 * turn - before * bends[k - 1]) / pivot;
        }
        for k in (1..count - 1).rev() {
            let next = bends[k + 1];
            bends[k] -= upper[k] * next;
        }
        Self {
            points,
            lengths,
            bends,
        }
    }

    /// Length of the points' polygon.
    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    fn interval(&self, at: f64) -> usize {
        let last = self.points.len() - 2;
        self.lengths
            .partition_point(|&s| s <= at)
            .saturating_sub(1)
            .min(last)
    }

    /// Place.
    pub fn place(&self, at: f64) -> DVec2 {
        let k = self.interval(at);
        let step = self.lengths[k + 1] - self.lengths[k];
        let b = (at - self.lengths[k]) / step;
        let a = 1.0 - b;
        let bend = (a * a * a - a) * self.bends[k] + (b * b * b - b) * self.bends[k + 1];
        a * self.points[k] + b * self.points[k + 1] + step * step / 6.0 * bend
    }

    /// Size of the curvature.
    pub fn curvature(&self, at: f64) -> f64 {
        let k = self.interval(at);
        let step = self.lengths[k + 1] - self.lengths[k];
        let b = (at - self.lengths[k]) / step;
        let a = 1.0 - b;
        let bend = a * self.bends[k] + b * self.bends[k + 1];
        let slope = (self.points[k + 1] - self.points[k]) / step
            + step / 6.0
                * ((3.0 * b * b - 1.0) * self.bends[k + 1] - (3.0 * a * a - 1.0) * self.bends[k]);
        (slope.perp_dot(bend) / slope.length().powi(3)).abs()
    }
}

/// Refuses what is no outline, with the reason.
pub fn check(points: &[DVec2]) -> Result<(), SectionError> {
    let wrong = |what: String| Err(SectionError::Outline(what));
    if points.len() < 10 {
        return wrong(format!(
            "{} points are too few, at least 10 are needed",
            points.len()
        ));
    }
    if let Some(k) = points.iter().position(|p| !p.is_finite()) {
        return wrong(format!("point {k} is not finite"));
    }
    if let Some(k) = points.windows(2).position(|p| p[0].distance(p[1]) < 1e-9) {
        return wrong(format!("points {k} and {} coincide", k + 1));
    }
    let (first, last) = (points[0], points[points.len() - 1]);
    let edge = 0.5 * (first + last);
    let nose = points.iter().fold(f64::INFINITY, |x, p| x.min(p.x));
    if nose.abs() > 0.05 || (edge.x - 1.0).abs() > 0.05 || edge.y.abs() > 0.2 {
        return wrong(
            "the chord has to lie from x = 0 at the nose to x = 1 at the trailing edge".to_owned(),
        );
    }
    if first.distance(last) > WIDEST_GAP {
        return wrong(format!(
            "the trailing edge is open by more than {WIDEST_GAP} chords"
        ));
    }
    let closing = std::iter::once([last, first]);
    let doubled: f64 = points
        .windows(2)
        .map(|p| [p[0], p[1]])
        .chain(closing)
        .map(|[a, b]| a.perp_dot(b))
        .sum();
    if doubled > 0.0 {
        return wrong("the points have to begin along the lower side".to_owned());
    }
    if let Some((j, k)) = crossing(points) {
        return wrong(format!("it crosses itself, near points {j} and {k}"));
    }
    // Two thirds of the thickness times the chord is about the area.
    if -0.75 * doubled < LEAST_THICKNESS {
        return wrong("it encloses no area".to_owned());
    }
    Ok(())
}

/// First pair of straight pieces that cross or touch.
fn crossing(points: &[DVec2]) -> Option<(usize, usize)> {
    let pieces = points.len() - 1;
    let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a);
    for j in 0..pieces {
        for k in j + 2..pieces {
            let [a, b, c, d] = [points[j], points[j + 1], points[k], points[k + 1]];
            if j == 0 && k == pieces - 1 && a.distance(d) < 1e-9 {
                // They share a closed trailing edge.
                continue;
            }
            if side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 {
                let straight = side(a, b, c) == 0.0 && side(a, b, d) == 0.0;
                let apart = (c - a).dot(b - a) > (b - a).length_squared();
                if !(straight && apart) {
                    return Some((j, k));
                }
            }
        }
    }
    None
}
