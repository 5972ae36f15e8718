//! Drag of what hangs below a wing: lines, and a pilot by his drag area.
//!
//! A line feels ½ ρ C_d d |u_n| u_n per length, u_n the part of the air's velocity across it (the cross-flow principle: Hoerner, Fluid-Dynamic
//! Drag, 1965, section 3-11), as lines in the coupled simulation do. Friction along a line and what lines do to each other are left out.

use glam::DVec3;

use super::forces::Forces;

/// A straight piece of line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSegment {
    /// Ends [m].
    pub ends_m: [DVec3; 2],
    /// Diameter d [m].
    pub diameter_m: f64,
    /// Drag coefficient C_d across the line; about 1.1 for smooth round lines at the usual Reynolds numbers of 5e2 to 2e3.
    pub coefficient: f64,
}

/// A body that is known by its drag area alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DragArea {
    /// Where it is [m].
    pub position_m: DVec3,
    /// C_D A [m²]; a sitting pilot has about 0.4 to 0.6, a lying one in a fairing 0.2.
    pub area_m2: f64,
}

/// Force and moment of a stream on lines and bodies.
#[must_use]
pub fn forces(
    lines: &[LineSegment],
    bodies: &[DragArea],
    stream_m_s: DVec3,
    density_kg_m3: f64,
    about_m: DVec3,
) -> Forces {
    let mut sum = Forces {
        force_n: DVec3::ZERO,
        moment_n_m: DVec3::ZERO,
    };
    let mut add = |at: DVec3, force: DVec3| {
        sum.force_n += force;
        sum.moment_n_m += (at - about_m).cross(force);
    };
    for line in lines {
        let [a, b] = line.ends_m;
        let along = (b - a).normalize_or_zero();
        let across = stream_m_s - along * along.dot(stream_m_s);
        let area = line.diameter_m * a.distance(b);
        let factor = 0.5 * density_kg_m3 * line.coefficient * area * across.length();
        add(0.5 * (a + b), factor * across);
    }
    for body in bodies {
        let factor = 0.5 * density_kg_m3 * body.area_m2 * stream_m_s.length();
        add(body.position_m, factor * stream_m_s);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Across the stream a line has its full drag, along it none, and at an angle ψ to it sin³ ψ of drag and sin² ψ cos ψ across.
    #[test]
    fn lines_feel_what_crosses_them() {
        let (density, speed) = (1.2, 10.0);
        let full = 0.5 * density * 1.1 * 0.002 * 3.0 * speed * speed;
        for degrees in [90.0f64, 0.0, 60.0, 25.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let line = LineSegment {
                ends_m: [DVec3::ZERO, 3.0 * DVec3::new(cos, 0.0, sin)],
                diameter_m: 0.002,
                coefficient: 1.1,
            };
            let result = forces(&[line], &[], speed * DVec3::X, density, DVec3::ZERO);
            assert!((result.force_n.x - full * sin.powi(3)).abs() < 1e-12);
            assert!((result.force_n.z + full * sin * sin * cos).abs() < 1e-12);
            let arm = 1.5 * DVec3::new(cos, 0.0, sin);
            assert!((result.moment_n_m - arm.cross(result.force_n)).length() < 1e-12);
        }
    }

    #[test]
    fn a_pilot_has_his_drag_area() {
        let pilot = DragArea {
            position_m: DVec3::new(0.0, 0.0, -7.0),
            area_m2: 0.45,
        };
        let result = forces(&[], &[pilot], 11.0 * DVec3::X, 1.1, DVec3::ZERO);
        assert!((result.force_n.x - 0.5 * 1.1 * 0.45 * 121.0).abs() < 1e-12);
        assert!((result.moment_n_m.y + 7.0 * result.force_n.x).abs() < 1e-9);
    }
}
