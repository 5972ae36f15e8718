//! Stream function and velocity of a straight panel with linear vorticity or linear source strength.
//!
//! A panel goes from A to B, with the air on its left. In its frame a point is at (x, z), z to the left; q is the distance along the panel from
//! an element to the point. The strengths are those at A and at B, γ = u_t the speed along the surface. A vortex sheet has ψ = ∫ γ ln r ds/2π,
//! a source sheet ψ = ∫ σ φ ds/2π, and the velocity is (∂ψ/∂y, −∂ψ/∂x). The integrals are elementary (Katz & Plotkin, Low-Speed Aerodynamics,
//! 2001, chapter 10).
//!
//! The angle φ of a source jumps across a line behind each element: to the left of a panel on the surface, and downstream of one in the wake.
//! That line never enters the outline, so ψ is continuous inside; an outline so hollow that a normal meets it again is not meant.

use std::f64::consts::TAU;

use glam::DVec2;

/// Where the angle of a source jumps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// To the left of the panel.
    Left,
    /// Ahead of the panel.
    Ahead,
}

/// A panel as a point sees it.
struct View {
    along: DVec2,
    left: DVec2,
    length: f64,
    z: f64,
    /// Distance along the panel from A and from B to the point.
    q: [f64; 2],
    /// Logarithms of the distances from A and B; zero at A and B, where neighbours' terms cancel.
    log: [f64; 2],
    /// Angle under which the panel is seen, with the sign of z.
    angle: f64,
    /// ∫ ln r ds.
    first: f64,
}

impl View {
    fn new([a, b]: [DVec2; 2], point: DVec2) -> Self {
        let length = a.distance(b);
        let along = (b - a) / length;
        let left = along.perp();
        let from = point - a;
        let x = from.dot(along);
        let mut z = from.dot(left);
        // Rounding must not decide on which side of its own panel a point lies.
        if z.abs() < 1e-12 * length {
            z = 0.0;
        }
        let q = [x, x - length];
        let log = q.map(|q| {
            let r = q.hypot(z);
            if r < 1e-10 * length { 0.0 } else { r.ln() }
        });
        let angle = if z == 0.0 {
            0.0
        } else {
            (q[0] / z).atan() - (q[1] / z).atan()
        };
        let first = q[0] * log[0] - q[1] * log[1] - length + z * angle;
        Self {
            along,
            left,
            length,
            z,
            q,
            log,
            angle,
            first,
        }
    }

    /// ∫ s ln r ds, s from A.
    fn second(&self) -> f64 {
        let part = |k: usize| {
            let square = self.q[k] * self.q[k] + self.z * self.z;
            0.5 * square * (self.log[k] - 0.5)
        };
        self.q[0] * self.first - part(0) + part(1)
    }

    /// Derivatives of both integrals along the panel and to the left.
    fn gradients(&self) -> [DVec2; 2] {
        let difference = self.log[0] - self.log[1];
        [
            DVec2::new(difference, self.angle),
            DVec2::new(
                self.first - self.length * self.log[1],
                self.q[0] * self.angle - self.z * difference,
            ),
        ]
    }

    /// From the integrals with the weights 1 and s to those of the strengths at A and B, over 2π.
    fn of_ends<T>(&self, one: T, s: T) -> [T; 2]
    where
        T: Copy + std::ops::Sub<Output = T> + std::ops::Div<f64, Output = T>,
    {
        let b = s / self.length;
        [(one - b) / TAU, b / TAU]
    }
}

/// ψ of linear vorticity.
pub fn vortex_stream(panel: [DVec2; 2], point: DVec2) -> [f64; 2] {
    let view = View::new(panel, point);
    view.of_ends(view.first, view.second())
}

/// Velocity of linear vorticity.
pub fn vortex_velocity(panel: [DVec2; 2], point: DVec2) -> [DVec2; 2] {
    let view = View::new(panel, point);
    // The stream function's gradient turned to the right.
    let turned = view.gradients().map(|g| g.y * view.along - g.x * view.left);
    view.of_ends(turned[0], turned[1])
}

/// ψ of linear source strength.
pub fn source_stream(panel: [DVec2; 2], point: DVec2, cut: Cut) -> [f64; 2] {
    let view = View::new(panel, point);
    let angle = view.q.map(|q| match cut {
        Cut::Left => q.atan2(-view.z),
        Cut::Ahead => (-view.z).atan2(-q),
    });
    let z = view.z;
    let first = view.q[0] * angle[0] - view.q[1] * angle[1] + z * (view.log[0] - view.log[1]);
    // ∫ q φ dq = (q² φ + z q − z² arctan(q/z))/2.
    let moment = 0.5
        * (view.q[0] * view.q[0] * angle[0] - view.q[1] * view.q[1] * angle[1] + z * view.length
            - z * z * view.angle);
    view.of_ends(first, view.q[0] * first - moment)
}

/// Velocity of linear source strength.
pub fn source_velocity(panel: [DVec2; 2], point: DVec2) -> [DVec2; 2] {
    let view = View::new(panel, point);
    let turned = view.gradients().map(|g| g.x * view.along + g.y * view.left);
    view.of_ends(turned[0], turned[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocities are the derivatives of the stream functions, and both those of many point vortices and sources.
    #[test]
    fn panels_are_made_of_points() {
        let panel = [DVec2::new(0.3, -0.2), DVec2::new(0.7, 0.25)];
        for point in [
            DVec2::new(0.6, -0.4),
            DVec2::new(0.1, 0.3),
            DVec2::new(-1.0, -2.0),
            DVec2::new(0.45, 0.3),
        ] {
            let count = 4000;
            let mut sums = [[DVec2::ZERO; 2]; 2];
            let mut stream = [0.0; 2];
            for k in 0..count {
                let t = (f64::from(k) + 0.5) / f64::from(count);
                let from = point - panel[0].lerp(panel[1], t);
                let ds = panel[0].distance(panel[1]) / f64::from(count) / TAU;
                for (end, weight) in [1.0 - t, t].into_iter().enumerate() {
                    let radial = from / from.length_squared() * (weight * ds);
                    sums[0][end] += radial;
                    sums[1][end] -= radial.perp();
                    stream[end] += weight * ds * from.length().ln();
                }
            }
            for end in 0..2 {
                let source = source_velocity(panel, point)[end];
                let vortex = vortex_velocity(panel, point)[end];
                assert!((source - sums[0][end]).length() < 1e-6);
                assert!((vortex - sums[1][end]).length() < 1e-6);
                assert!((vortex_stream(panel, point)[end] - stream[end]).abs() < 1e-6);
                let h = 1e-5;
                for cut in [Cut::Left, Cut::Ahead] {
                    // To the left of the panel the jump itself would be differentiated.
                    if cut == Cut::Left && point.y > 0.2 && point.x > 0.0 {
                        continue;
                    }
                    let psi = |p: DVec2| source_stream(panel, p, cut)[end];
                    let by_y = (psi(point + h * DVec2::Y) - psi(point - h * DVec2::Y)) / (2.0 * h);
                    let by_x = (psi(point + h * DVec2::X) - psi(point - h * DVec2::X)) / (2.0 * h);
                    assert!((DVec2::new(by_y, -by_x) - source).length() < 1e-6);
                }
            }
        }
    }
}
