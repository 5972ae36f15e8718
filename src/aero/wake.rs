//! The wake of a trailing edge, and what it says about forces far downstream.
//!
//! From every strip trails a plane doublet strip along one direction, as strong as the jump of the potential at the trailing edge, so the
//! wake carries no bound vorticity (Katz & Plotkin 2001, section 12.1). In the Trefftz plane, across the stream far behind, it is a row of
//! point vortices, with which
//!
//! ```text
//! F = ρ Σ Γ_j V × l_j        D_i = −½ ρ Σ Γ_j w_j·n_j |l_j|
//! ```
//!
//! l_j the strip's step along the span across the stream, w_j the velocity in the strip (Katz & Plotkin, section 8.2.2), taken in the middle
//! of its range of the angle θ = acos(1 − 2s/S), s along the trace of length S: circulation falls like a root towards a tip, and is smooth
//! over θ. (In the middle of the strips' length the drag of an elliptic wing of 16 strips would be 4 % low.) Departure: the trace of the wake is the trailing edge projected along the stream, not rolled up.

use glam::{DVec2, DVec3};

use super::influence::doublet_of_strip;
use super::surface::{PanelSurface, mirrored};

/// Length of the wake over the extent of the surface: a truncation changes lift by the square of its inverse.
const LENGTH: f64 = 1e3;

/// Doublet strips behind a trailing edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Wake {
    /// Corners of each strip [m], seen counter-clockwise from above.
    strips_m: Vec<[DVec3; 4]>,
    is_symmetric: bool,
}

impl Wake {
    /// The wake that leaves along a direction; of a surface without trailing edge, none.
    #[must_use]
    pub fn new(surface: &PanelSurface, direction: DVec3) -> Self {
        let strips = if surface.has_trailing_edge {
            surface.spanwise
        } else {
            0
        };
        let extent = surface
            .nodes_m
            .iter()
            .map(|node| node.distance(surface.nodes_m[0]))
            .fold(0.0, f64::max);
        let away = LENGTH * extent * direction;
        let strips_m = (0..strips)
            .map(|j| {
                let [a, b] = [j, j + 1].map(|section| surface.node_m(0, section));
                [a, a + away, b + away, b]
            })
            .collect();
        Self {
            strips_m,
            is_symmetric: surface.is_symmetric,
        }
    }

    /// Number of strips.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.strips_m.len()
    }

    /// True without strips.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.strips_m.is_empty()
    }

    /// Doublet integral of a strip, and of its mirror image where there is one, at a point.
    #[must_use]
    pub fn influence(&self, strip: usize, point_m: DVec3) -> f64 {
        let corners = self.strips_m[strip];
        let own = doublet_of_strip(corners, point_m);
        if self.is_symmetric {
            own + doublet_of_strip(corners, mirrored(point_m))
        } else {
            own
        }
    }
}

/// Forces from the far wake [N].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrefftzForces {
    /// Across the stream, in the plane of stream and z axis: lift [N].
    pub lift_n: f64,
    /// Induced drag [N].
    pub induced_drag_n: f64,
}

/// Forces of a wing from the points of its trailing edge and the circulation of the strips between them.
///
/// `edge_m` are the points [m], one more than strips; `circulation_m2_s` counts positive where it lifts; `stream_m_s` is the velocity far
/// ahead. Of a symmetric wing half is given, and the forces are those of the whole.
#[must_use]
pub fn trefftz(
    edge_m: &[DVec3],
    circulation_m2_s: &[f64],
    stream_m_s: DVec3,
    density_kg_m3: f64,
    is_symmetric: bool,
) -> TrefftzForces {
    let along = stream_m_s.normalize_or_zero();
    let up = (DVec3::Z - along * along.z).normalize_or_zero();
    let side = up.cross(along);
    let trace: Vec<DVec2> = edge_m
        .iter()
        .map(|p| DVec2::new(p.dot(side), p.dot(up)))
        .collect();
    // The vortex between two strips carries what their circulations differ by.
    let vortices: Vec<(DVec2, f64)> = trace
        .iter()
        .enumerate()
        .map(|(k, &at)| {
            let before = if k > 0 { circulation_m2_s[k - 1] } else { 0.0 };
            let after = circulation_m2_s.get(k).copied().unwrap_or(0.0);
            (at, after - before)
        })
        .collect();
    let velocity = |point: DVec2| -> DVec2 {
        vortices
            .iter()
            .flat_map(|&(at, strength)| {
                let image = is_symmetric.then_some((DVec2::new(-at.x, at.y), -strength));
                [Some((at, strength)), image]
            })
            .flatten()
            .map(|(at, strength)| {
                let off = point - at;
                // Counter-clockwise seen from downstream, side to the right: positive circulation on the left wing pushes air down inside.
                strength / (2.0 * std::f64::consts::PI * off.length_squared())
                    * DVec2::new(off.y, -off.x)
            })
            .sum()
    };
    let mut forces = TrefftzForces {
        lift_n: 0.0,
        induced_drag_n: 0.0,
    };
    let shares = middles(&trace, is_symmetric);
    for ((pair, &circulation), share) in trace.windows(2).zip(circulation_m2_s).zip(shares) {
        let step = pair[1] - pair[0];
        let normal = DVec2::new(-step.y, step.x);
        let wash = velocity(pair[0].lerp(pair[1], share));
        forces.lift_n += density_kg_m3 * stream_m_s.length() * circulation * step.x;
        forces.induced_drag_n -= 0.5 * density_kg_m3 * circulation * wash.dot(normal);
    }
    if is_symmetric {
        forces.lift_n *= 2.0;
        forces.induced_drag_n *= 2.0;
    }
    forces
}

/// Where in each strip its middle angle θ is, 0 at the strip's first point.
fn middles(trace: &[DVec2], is_symmetric: bool) -> Vec<f64> {
    let mut lengths = vec![0.0];
    for pair in trace.windows(2) {
        let last = lengths[lengths.len() - 1];
        lengths.push(last + pair[0].distance(pair[1]));
    }
    let whole = lengths[lengths.len() - 1];
    // Of a symmetric wing the other half goes before.
    let before = if is_symmetric { whole } else { 0.0 };
    let cosine = |length: f64| (1.0 - 2.0 * (before + length) / (before + whole)).clamp(-1.0, 1.0);
    lengths
        .windows(2)
        .map(|pair| {
            let middle = 0.5 * (cosine(pair[0]).acos() + cosine(pair[1]).acos());
            let at = 0.5 * (before + whole) * (1.0 - middle.cos()) - before;
            let step = pair[1] - pair[0];
            if step > 0.0 {
                ((at - pair[0]) / step).clamp(0.0, 1.0)
            } else {
                0.5
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elliptic loading over a straight span: L = π/4 ρ V Γ₀ b, D = π/8 ρ Γ₀² (Prandtl).
    #[test]
    fn elliptic_loading_has_the_least_drag() {
        let (strips, span, density, speed) = (20, 3.0, 1.2, 10.0);
        let edge: Vec<DVec3> = (0..=strips)
            .map(|k| {
                let angle = 0.5 * std::f64::consts::PI * k as f64 / strips as f64;
                DVec3::Y * 0.5 * span * angle.sin()
            })
            .collect();
        let circulation: Vec<f64> = (0..strips)
            .map(|k| (0.5 * std::f64::consts::PI * (k as f64 + 0.5) / strips as f64).cos())
            .collect();
        let half = trefftz(&edge, &circulation, speed * DVec3::X, density, true);
        let pi = std::f64::consts::PI;
        assert!((half.lift_n / (pi / 4.0 * density * speed * span) - 1.0).abs() < 2e-3);
        assert!(
            (half.induced_drag_n / (pi / 8.0 * density) - 1.0).abs() < 5e-3,
            "{half:?}"
        );
        // The whole, as such.
        let mut whole: Vec<DVec3> = edge.iter().skip(1).rev().map(|p| -*p).collect();
        whole.extend(&edge);
        let both: Vec<f64> = circulation
            .iter()
            .rev()
            .chain(&circulation)
            .copied()
            .collect();
        let full = trefftz(&whole, &both, speed * DVec3::X, density, false);
        assert!((full.induced_drag_n / half.induced_drag_n - 1.0).abs() < 1e-9);
        assert!((full.lift_n / half.lift_n - 1.0).abs() < 1e-9);
    }
}
