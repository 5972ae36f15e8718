//! A natural cubic spline through points of the plane, over the length of their polygon.

use glam::DVec2;

/// A curve through points; its second derivatives vanish at both ends.
#[derive(Debug, Clone)]
pub struct Spline {
    points: Vec<DVec2>,
    /// Length of the polygon up to every point.
    lengths: Vec<f64>,
    /// Second derivatives at the points.
    bends: Vec<DVec2>,
}

impl Spline {
    /// The curve through at least two points, of which no neighbours coincide.
    #[must_use]
    pub fn new(points: Vec<DVec2>) -> Self {
        let count = points.len();
        let mut lengths = vec![0.0; count];
        for k in 1..count {
            lengths[k] = lengths[k - 1] + points[k].distance(points[k - 1]);
        }
        // Thomas's algorithm.
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

    /// Length of the polygon up to a point.
    #[must_use]
    pub fn length_to(&self, point: usize) -> f64 {
        self.lengths[point]
    }

    /// Length of the whole polygon.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The piece that a length lies in, its own length, and the share of it that is passed.
    fn piece(&self, at: f64) -> (usize, f64, f64) {
        let last = self.points.len() - 2;
        let after = self.lengths.partition_point(|&length| length <= at);
        let k = after.saturating_sub(1).min(last);
        let step = self.lengths[k + 1] - self.lengths[k];
        (k, step, ((at - self.lengths[k]) / step).clamp(0.0, 1.0))
    }

    /// Place at a length.
    #[must_use]
    pub fn place(&self, at: f64) -> DVec2 {
        let (k, step, b) = self.piece(at);
        let a = 1.0 - b;
        let bend = (a * a * a - a) * self.bends[k] + (b * b * b - b) * self.bends[k + 1];
        a * self.points[k] + b * self.points[k + 1] + step * step / 6.0 * bend
    }

    /// Size of the curvature at a length.
    #[must_use]
    pub fn curvature(&self, at: f64) -> f64 {
        let (k, step, b) = self.piece(at);
        let a = 1.0 - b;
        let bend = a * self.bends[k] + b * self.bends[k + 1];
        let slope = (self.points[k + 1] - self.points[k]) / step
            + step / 6.0
                * ((3.0 * b * b - 1.0) * self.bends[k + 1] - (3.0 * a * a - 1.0) * self.bends[k]);
        (slope.perp_dot(bend) / slope.length().powi(3)).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a circle through 40 points, places and curvature away from the ends are met to the fourth and the second power of the spacing.
    #[test]
    fn a_circle_is_met() {
        let points = (0..=40).map(|k| 2.0 * DVec2::from_angle(0.1 * f64::from(k)));
        let spline = Spline::new(points.collect());
        for k in 10..30 {
            let at = spline.length() * (f64::from(k) + 0.5) / 40.0;
            assert!((spline.place(at).length() - 2.0).abs() < 1e-5);
            assert!((spline.curvature(at) - 0.5).abs() < 2e-3);
        }
        assert!((spline.length_to(40) - spline.length()).abs() < 1e-12);
    }
}
