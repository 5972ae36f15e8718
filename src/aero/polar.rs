//! Polars of sections: lift and drag coefficients over the angle of attack.

use std::sync::Arc;

use glam::DVec3;

use super::AeroError;
use super::potential_flow::{MEMORY_LIMIT, PotentialFlow};
use super::surface::{Station, Wing};
use crate::geometry::profile::Profile;

/// Half-span over chord of the wing that stands for a plane section: its downwash is 1e-3 of the angle.
const SECTION_HALF_SPAN: f64 = 1e3;

/// Panels per side for the potential flow of a section.
const SECTION_PANELS_PER_SIDE: usize = 60;

/// Angle over which the lift becomes level beyond the ends of a polar [rad].
const LEVEL_RAD: f64 = 0.02;

/// One angle of a polar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarPoint {
    /// Angle of attack [rad].
    pub angle_rad: f64,
    /// Lift coefficient.
    pub lift: f64,
    /// Drag coefficient.
    pub drag: f64,
    /// Moment coefficient about the quarter chord, nose up; `None`: not known.
    pub moment: Option<f64>,
}

/// Lift and drag of a section with viscosity. Between its points drag is linear and lift a monotone cubic (Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5, 1984), whose slope does
/// not jump and whose extremes are those of the points. Beyond the last point the lift becomes level within some degrees and the drag grows like that of a
/// flat plate held up to the stream, by 2 (sin² α − sin² α_last) (Hoerner, Fluid-Dynamic Drag, 1965, section 3-16: 2.0 at a right angle).
#[derive(Debug, Clone, PartialEq)]
pub struct Polar {
    points: Vec<PolarPoint>,
    /// Slope of the lift at every point [1/rad].
    slopes: Vec<f64>,
    /// Angles that it is known between [rad].
    covered_rad: [f64; 2],
}

impl Polar {
    /// A polar from at least two points in ascending order of their angles.
    pub fn new(points: Vec<PolarPoint>) -> Result<Self, AeroError> {
        let wrong = |what: &str| Err(AeroError::Polar(what.to_owned()));
        if points.len() < 2 {
            return wrong("at least two angles are needed");
        }
        if points
            .iter()
            .any(|p| ![p.angle_rad, p.lift, p.drag].iter().all(|n| n.is_finite()))
        {
            return wrong("a number is not finite");
        }
        if points.iter().any(|p| p.drag < 0.0) {
            return wrong("drag coefficients cannot be negative");
        }
        if points.windows(2).any(|p| p[1].angle_rad <= p[0].angle_rad) {
            return wrong("angles have to ascend");
        }
        Ok(Self::through(points))
    }

    fn through(points: Vec<PolarPoint>) -> Self {
        let step = |k: usize| points[k + 1].angle_rad - points[k].angle_rad;
        let secant = |k: usize| (points[k + 1].lift - points[k].lift) / step(k);
        let last = points.len() - 1;
        let slopes = (0..=last)
            .map(|k| {
                if k == 0 || k == last {
                    return secant(k.min(last - 1));
                }
                let (before, after) = (secant(k - 1), secant(k));
                if before * after <= 0.0 {
                    return 0.0;
                }
                let share = (step(k - 1) + 2.0 * step(k)) / (3.0 * (step(k - 1) + step(k)));
                before * after / (share * after + (1.0 - share) * before)
            })
            .collect();
        let covered_rad = [points[0].angle_rad, points[last].angle_rad];
        Self {
            points,
            slopes,
            covered_rad,
        }
    }

    /// The polar between this one and another, the share `t` of the way, at the angles of both.
    #[must_use]
    pub fn between(&self, other: &Self, t: f64) -> Self {
        let mut angles: Vec<f64> = self
            .points
            .iter()
            .chain(&other.points)
            .map(|point| point.angle_rad)
            .collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let mix = |a: f64, b: f64| a + t * (b - a);
        let points = angles.into_iter().map(|angle_rad| PolarPoint {
            angle_rad,
            lift: mix(self.lift(angle_rad).0, other.lift(angle_rad).0),
            drag: mix(self.drag(angle_rad), other.drag(angle_rad)),
            moment: self
                .moment(angle_rad)
                .zip(other.moment(angle_rad))
                .map(|(a, b)| mix(a, b)),
        });
        let mut mixed = Self::through(points.collect());
        // Where one of both ends, the mixture is not known.
        mixed.covered_rad = [
            self.covered_rad[0].max(other.covered_rad[0]),
            self.covered_rad[1].min(other.covered_rad[1]),
        ];
        mixed
    }

    /// Lift coefficient and its slope per radian.
    #[must_use]
    pub fn lift(&self, angle_rad: f64) -> (f64, f64) {
        let Some((k, t)) = self.segment(angle_rad) else {
            let (end, slope) = self.nearest(angle_rad);
            let beyond = angle_rad - end.angle_rad;
            let left = (-beyond.abs() / LEVEL_RAD).exp();
            let gained = slope * LEVEL_RAD.copysign(beyond) * (1.0 - left);
            return (end.lift + gained, slope * left);
        };
        let (a, b) = (self.points[k], self.points[k + 1]);
        let step = b.angle_rad - a.angle_rad;
        let rise = b.lift - a.lift;
        let [from, to] = [self.slopes[k], self.slopes[k + 1]].map(|slope| slope * step);
        // Hermite's cubic.
        let (second, third) = (3.0 * rise - 2.0 * from - to, from + to - 2.0 * rise);
        (
            a.lift + t * (from + t * (second + t * third)),
            (from + t * (2.0 * second + 3.0 * t * third)) / step,
        )
    }

    /// Drag coefficient.
    #[must_use]
    pub fn drag(&self, angle_rad: f64) -> f64 {
        match self.segment(angle_rad) {
            Some((k, t)) => {
                let [a, b] = [k, k + 1].map(|k| self.points[k].drag);
                a + t * (b - a)
            }
            None => {
                let (last, _) = self.nearest(angle_rad);
                let more = angle_rad.sin().powi(2) - last.angle_rad.sin().powi(2);
                last.drag + 2.0 * more.max(0.0)
            }
        }
    }

    /// Moment coefficient about the quarter chord, if all points have one; beyond the ends that of the end.
    #[must_use]
    pub fn moment(&self, angle_rad: f64) -> Option<f64> {
        match self.segment(angle_rad) {
            Some((k, t)) => {
                let (a, b) = (self.points[k].moment?, self.points[k + 1].moment?);
                Some(a + t * (b - a))
            }
            None => self.nearest(angle_rad).0.moment,
        }
    }

    /// Whether an angle lies between that of the highest lift and that of the lowest one before it.
    #[must_use]
    pub fn is_below_stall(&self, angle_rad: f64) -> bool {
        let by_lift = |a: &&PolarPoint, b: &&PolarPoint| a.lift.total_cmp(&b.lift);
        let Some(highest) = self.points.iter().max_by(by_lift) else {
            return false;
        };
        let before = self
            .points
            .iter()
            .filter(|p| p.angle_rad <= highest.angle_rad);
        let lowest = before
            .min_by(by_lift)
            .map_or(f64::NEG_INFINITY, |p| p.angle_rad);
        (lowest..=highest.angle_rad).contains(&angle_rad)
    }

    /// Whether the polar reaches that far.
    #[must_use]
    pub fn covers(&self, angle_rad: f64) -> bool {
        (self.covered_rad[0]..=self.covered_rad[1]).contains(&angle_rad)
    }

    /// The point before an angle, and the share of the way to the next.
    fn segment(&self, angle_rad: f64) -> Option<(usize, f64)> {
        let place = |k: usize| self.points[k].angle_rad;
        let last = self.points.len() - 1;
        if !(place(0)..=place(last)).contains(&angle_rad) {
            return None;
        }
        let after = self.points.partition_point(|p| p.angle_rad <= angle_rad);
        let k = after.clamp(1, last) - 1;
        Some((k, (angle_rad - place(k)) / (place(k + 1) - place(k))))
    }

    /// The end of the polar beyond which an angle lies, and the slope of the lift there.
    fn nearest(&self, angle_rad: f64) -> (PolarPoint, f64) {
        let last = self.points.len() - 1;
        let k = if angle_rad > self.points[last].angle_rad {
            last
        } else {
            0
        };
        (self.points[k], self.slopes[k])
    }
}

/// Lift of a section in potential flow, C_l = slope · sin(α − zero lift).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionFlow {
    /// Slope [1/rad].
    pub slope_per_rad: f64,
    /// Angle without lift [rad].
    pub zero_lift_rad: f64,
}

impl SectionFlow {
    /// That of a section between this one and another, the share `t` of the way.
    #[must_use]
    pub fn between(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + t * (b - a);
        Self {
            slope_per_rad: mix(self.slope_per_rad, other.slope_per_rad),
            zero_lift_rad: mix(self.zero_lift_rad, other.zero_lift_rad),
        }
    }

    /// The panel method on one strip of a wing that is 2 000 chords long.
    pub fn of(profile: &Arc<Profile>) -> Result<Self, AeroError> {
        let station = |y: f64| Station {
            position_m: DVec3::Y * y,
            chord_m: 1.0,
            twist_rad: 0.0,
            roll_rad: 0.0,
            profile: Arc::clone(profile),
        };
        let wing = Wing {
            stations: vec![station(0.0), station(SECTION_HALF_SPAN)],
            chord_fraction: 0.25,
            is_symmetric: true,
        };
        let surface = wing.panels(SECTION_PANELS_PER_SIDE)?;
        let flows =
            PotentialFlow::new(&surface, DVec3::X, MEMORY_LIMIT)?.solve(&[DVec3::X, DVec3::Z])?;
        // C_l is linear in cos α and sin α.
        let [a, b] = [&flows[0], &flows[1]].map(|flow| 2.0 * flow.circulation_m2_s[0]);
        Ok(Self {
            slope_per_rad: a.hypot(b),
            zero_lift_rad: -(a / b).atan(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(degrees: f64, lift: f64, drag: f64) -> PolarPoint {
        PolarPoint {
            angle_rad: degrees.to_radians(),
            lift,
            drag,
            moment: None,
        }
    }

    #[test]
    fn polars_interpolate_and_end() {
        let polar = Polar::new(vec![
            point(0.0, 0.1, 0.01),
            point(10.0, 1.1, 0.02),
            point(20.0, 0.9, 0.1),
        ])
        .unwrap();
        // At a point the lift is the point's; between them it is steady, with the slope that it says, and highest at the highest point.
        for degrees in [0.0, 3.0, 5.0, 9.99, 10.0, 10.01, 17.0] {
            let at = |degrees: f64| polar.lift(degrees.to_radians());
            let (lift, slope) = at(degrees);
            let (next, _) = at(degrees + 1e-4);
            assert!(
                (next - lift - slope * 1e-4f64.to_radians()).abs() < 1e-8,
                "{degrees}"
            );
            assert!(lift <= 1.1);
        }
        assert_eq!(polar.lift(10f64.to_radians()), (1.1, 0.0));
        assert!((polar.drag(15f64.to_radians()) - 0.06).abs() < 1e-12);
        let far = 40f64.to_radians();
        // A fall of 0.02 per degree becomes level over 0.02 rad.
        let level = 0.9 - 0.02 * 0.02f64.to_degrees();
        let (lift, slope) = polar.lift(far);
        assert!((lift - level).abs() < 1e-4 && slope.abs() < 1e-4, "{lift}");
        assert!(!polar.covers(far) && polar.drag(far) > 0.5);
        for (points, part) in [
            (vec![point(0.0, 0.0, 0.0)], "two"),
            (vec![point(0.0, 0.0, 0.0), point(0.0, 0.0, 0.0)], "ascend"),
            (
                vec![point(0.0, 0.0, -1.0), point(1.0, 0.0, 0.0)],
                "negative",
            ),
            (
                vec![point(0.0, f64::NAN, 0.0), point(1.0, 0.0, 0.0)],
                "finite",
            ),
        ] {
            let error = Polar::new(points).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    /// A thin symmetric section has 2π, a thick one 2π (1 + 0.77 t/c) (exact Joukowski sections), and a cambered one lifts at no angle.
    #[test]
    fn sections_have_their_slope_and_zero_lift() {
        let of = |name: &str| SectionFlow::of(&Arc::new(Profile::naca(name).unwrap())).unwrap();
        let two_pi = 2.0 * std::f64::consts::PI;
        let thin = of("0003");
        assert!(
            (thin.slope_per_rad / (1.023 * two_pi) - 1.0).abs() < 0.01,
            "{thin:?}"
        );
        assert!(thin.zero_lift_rad.abs() < 1e-6, "{thin:?}");
        // Abbott & von Doenhoff: −1.1 to −1.2 degrees for the 230 series; thin-profile theory −1.09.
        let cambered = of("23012");
        assert!(
            (cambered.zero_lift_rad.to_degrees() + 1.1).abs() < 0.15,
            "{cambered:?}"
        );
    }
}
