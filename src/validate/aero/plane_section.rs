//! The plane limit: a Kármán–Trefftz section on a very long wing against its exact potential flow.
//!
//! The circle |ζ − ζ₀| = R through ζ = 1 becomes the section by z = n ((ζ+1)ⁿ + (ζ−1)ⁿ)/((ζ+1)ⁿ − (ζ−1)ⁿ), with the trailing edge's angle
//! (2 − n) π; the flow around the circle with the circulation 4π R V sin(α + β) leaves the edge smoothly (Katz & Plotkin 2001, section 6.7).

use glam::{DVec2, DVec3};

use super::super::report::Gate;
use super::super::session::{Session, Stop};
use super::flows;
use crate::aero::AeroError;
use crate::aero::surface::PanelSurface;
use crate::geometry::profile::Profile;
use crate::measure::extremes::larger;

/// Centre of the circle: thickness by −x, camber by y.
const CENTRE: DVec2 = DVec2::new(-0.1, 0.08);

/// The trailing edge has 10 degrees.
const EXPONENT: f64 = 2.0 - 10.0 / 180.0;

const ANGLE: f64 = 0.07;

/// Points per side through which the panels' section is laid.
const EXACT_PER_SIDE: usize = 300;

/// Half-span over chord.
const HALF_SPAN: f64 = 1e4;

pub(in super::super) fn compute(session: &mut Session) -> Result<(), Stop> {
    let exact = Exact::new();
    let sizes: &[usize] = session.size(&[20, 40, 60], &[20, 40, 80, 160]);
    for &per_side in sizes {
        session.check_interrupt()?;
        let surface = exact.surface(per_side)?;
        let flow = flows(&surface, &[ANGLE])?.remove(0);
        let panels = surface.panels.len();
        let lift = flow.section_lift_coefficients(&surface)[0];
        let name = format!("lift coefficient, {per_side} per side");
        session
            .aero_row(panels, name, lift)
            .reference(exact.lift(), "exact, Karman-Trefftz section")
            .gate(Gate::Within(0.003));
        let pressures = flow.pressure_coefficients(&surface);
        // The last tenth of the chord, where the exact section's edge has a stagnation point that one panel cannot resolve, is left out
        // of the largest error.
        let (mut squares, mut length, mut most) = (0.0, 0.0, 0.0);
        // The highest suction of a panel, and that of the section at the same place.
        let mut peak = (0.0, 0.0);
        for (k, panel) in surface.panels[..surface.chordwise].iter().enumerate() {
            let there = exact.pressure_next_to(panel.centre_m);
            let error = pressures[k] - there;
            if pressures[k] < peak.0 {
                peak = (pressures[k], there);
            }
            let size = panel.area_m2.length();
            squares += error * error * size;
            length += size;
            if panel.centre_m.x < 0.9 {
                most = larger(most, error.abs());
            }
        }
        let name = format!("highest suction of a panel, {per_side} per side");
        session
            .aero_row(panels, name, peak.0)
            .reference(peak.1, "exact, at the same place")
            .gate(Gate::Within(0.01));
        let name = format!("error of Cp, root mean square, {per_side} per side");
        session
            .aero_row(panels, name, (squares / length).sqrt())
            .gate(Gate::AtMost(0.02));
        session.aero_row(
            panels,
            format!("error of Cp, largest before 90 % of the chord, {per_side} per side"),
            most,
        );
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct Complex(DVec2);

impl Complex {
    fn times(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x))
    }

    fn over(self, other: Self) -> Self {
        let b = other.0;
        Self(self.times(Self(DVec2::new(b.x, -b.y))).0 / b.length_squared())
    }

    fn power(self, exponent: f64) -> Self {
        let angle = exponent * self.0.to_angle();
        Self(self.0.length().powf(exponent) * DVec2::from_angle(angle))
    }
}

struct Exact {
    radius: f64,
    /// Angle of the trailing edge on the circle, negative below.
    beta: f64,
    /// Nose and chord of the section in its own plane.
    nose: DVec2,
    chord: f64,
    /// Angle on the circle where the nose is.
    nose_angle: f64,
}

impl Exact {
    fn new() -> Self {
        let radius = (DVec2::X - CENTRE).length();
        let beta = (CENTRE.y / radius).asin();
        let mut exact = Self {
            radius,
            beta,
            nose: DVec2::ZERO,
            chord: 1.0,
            nose_angle: 0.0,
        };
        // The point farthest ahead.
        let count = 20_000;
        let start = -beta;
        let (mut best, mut far) = (0.0, f64::INFINITY);
        for k in 1..count {
            let angle = start + 2.0 * std::f64::consts::PI * f64::from(k) / f64::from(count);
            let x = exact.section(angle).x;
            if x < far {
                (best, far) = (angle, x);
            }
        }
        exact.nose_angle = best;
        exact.nose = exact.section(best);
        exact.chord = EXPONENT - exact.nose.x;
        exact
    }

    fn circle(&self, angle: f64) -> DVec2 {
        CENTRE + self.radius * DVec2::from_angle(angle)
    }

    /// Point of the section, its trailing edge at (n, 0).
    fn section(&self, angle: f64) -> DVec2 {
        let zeta = self.circle(angle);
        let plus = Complex(zeta + DVec2::X).power(EXPONENT);
        let minus = Complex(zeta - DVec2::X).power(EXPONENT);
        EXPONENT * Complex(plus.0 + minus.0).over(Complex(plus.0 - minus.0)).0
    }

    /// In chords, nose at x = 0, trailing edge at (1, 0).
    fn place(&self, angle: f64) -> DVec2 {
        DVec2::new(
            (self.section(angle).x - self.nose.x) / self.chord,
            self.section(angle).y / self.chord,
        )
    }

    /// 8π R sin(α + β)/c.
    fn lift(&self) -> f64 {
        8.0 * std::f64::consts::PI * self.radius * (ANGLE + self.beta).sin() / self.chord
    }

    fn pressure(&self, angle: f64) -> f64 {
        // Speed on the circle, and how much the map stretches.
        let around = 2.0 * ((angle - ANGLE).sin() + (ANGLE + self.beta).sin());
        let step = 1e-6;
        let stretch = (self.section(angle + step) - self.section(angle - step)).length()
            / (2.0 * step * self.radius);
        1.0 - (around / stretch).powi(2)
    }

    /// Points of the section, `per_side` on each side, close together at the edge and the nose.
    fn profile(&self) -> Result<Profile, Stop> {
        let full = 2.0 * std::f64::consts::PI;
        let (edge, nose) = (full - self.beta, self.nose_angle);
        let points = (0..=2 * EXACT_PER_SIDE)
            .map(|k| {
                let t = k.min(2 * EXACT_PER_SIDE - k) as f64 / EXACT_PER_SIDE as f64;
                // On the circle equal steps are cosine spacing on the section.
                self.place(if k <= EXACT_PER_SIDE {
                    edge + t * (nose - edge)
                } else {
                    -self.beta + t * (nose + self.beta)
                })
            })
            .collect();
        Ok(Profile::new(points).map_err(AeroError::from)?)
    }

    fn surface(&self, per_side: usize) -> Result<PanelSurface, Stop> {
        let section = self.profile()?.resampled(per_side);
        let nodes = [0.0, HALF_SPAN]
            .iter()
            .flat_map(|&y| section.iter().map(move |p| DVec3::new(p.x, y, p.y)))
            .collect();
        Ok(PanelSurface::new(nodes, 2 * per_side, true, true)?)
    }

    /// Exact pressure at the point of the section next to a place.
    fn pressure_next_to(&self, place: DVec3) -> f64 {
        let at = DVec2::new(place.x, place.z);
        let distance = |angle: f64| self.place(angle).distance(at);
        let step = 2.0 * std::f64::consts::PI / 1000.0;
        let angle_of = |k: usize| -self.beta + (k as f64 + 0.5) * step;
        let nearest = (0..1000)
            .map(angle_of)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap_or(0.0);
        let (mut low, mut high) = (nearest - step, nearest + step);
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if distance(a) < distance(b) {
                high = b;
            } else {
                low = a;
            }
        }
        self.pressure(0.5 * (low + high))
    }
}
