//! Where the ribs stand: stations along the half span, joined by monotone cubics.
//!
//! The span of a station is measured along the arc, over the unrolled wing, so the roll alone gives the arc, (y, z) = ∫ (cos φ, −sin φ) ds,
//! and the flat wing keeps its span whatever the arc.

use glam::DVec3;

use super::section::{Profile, Side};

/// What a designer states at one place along the half span.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Distance from the middle along the arc [m].
    pub span_m: f64,
    /// Chord [m].
    pub chord_m: f64,
    /// How far the leading edge lies behind that of the middle [m].
    pub sweep_m: f64,
    /// How far the rib leans: 0 upright, positive where the wing falls towards its tip [rad].
    pub roll_rad: f64,
    /// Nose up, about the quarter chord [rad].
    pub twist_rad: f64,
    /// Number of the profile.
    pub profile: usize,
}

/// A rib's place.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Distance from the middle along the arc, negative on the left [m].
    pub span_m: f64,
    /// Quarter-chord point [m].
    pub quarter_m: DVec3,
    /// Chord [m].
    pub chord_m: f64,
    /// Unit vector from nose to trailing edge.
    pub aft: DVec3,
    /// Unit vector across the chord, upwards.
    pub up: DVec3,
    /// Profiles on both sides of the place along the span, and the share of the second.
    pub profiles: ([usize; 2], f64),
}

impl Frame {
    /// A point of the rib's plane, coordinates per chord from the nose.
    #[must_use]
    pub fn point(&self, x: f64, z: f64) -> DVec3 {
        self.quarter_m + (self.aft * (x - 0.25) + self.up * z) * self.chord_m
    }

    /// Height of the rib at `x`, per chord.
    #[must_use]
    pub fn height(&self, profiles: &[Profile], side: Side, x: f64) -> f64 {
        let ([a, b], share) = self.profiles;
        let first = profiles[a].height(side, x);
        if a == b {
            return first;
        }
        first + (profiles[b].height(side, x) - first) * share
    }

    /// Its mirror image about the plane y = 0.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mirror = |v: DVec3| DVec3::new(v.x, -v.y, v.z);
        Self {
            span_m: -self.span_m,
            quarter_m: mirror(self.quarter_m),
            aft: mirror(self.aft),
            up: mirror(self.up),
            ..*self
        }
    }
}

/// Places along the span at which the arc is integrated.
const ARC_STEPS: usize = 4000;

/// Frames of `count` ribs at the given distances from the middle, none negative, growing.
#[must_use]
pub fn frames(stations: &[Station], spans_m: &[f64]) -> Vec<Frame> {
    let places: Vec<f64> = stations.iter().map(|s| s.span_m).collect();
    let curve = |of: fn(&Station) -> f64| Curve::new(&places, stations.iter().map(of).collect());
    let chord = curve(|s| s.chord_m);
    let sweep = curve(|s| s.sweep_m);
    let roll = curve(|s| s.roll_rad);
    let twist = curve(|s| s.twist_rad);
    let tip = places.last().copied().unwrap_or(0.0);
    let step = tip / ARC_STEPS as f64;
    // Trapezoidal sums up to every step.
    let mut arc = vec![[0.0; 2]];
    for i in 0..ARC_STEPS {
        let (a, b) = (roll.at(step * i as f64), roll.at(step * (i + 1) as f64));
        let [y, z] = arc[i];
        arc.push([
            y + 0.5 * step * (a.cos() + b.cos()),
            z - 0.5 * step * (a.sin() + b.sin()),
        ]);
    }
    spans_m
        .iter()
        .map(|&s| {
            let at = if step > 0.0 {
                (s / step).min(ARC_STEPS as f64)
            } else {
                0.0
            };
            let before = (at as usize).min(ARC_STEPS - 1);
            let share = at - before as f64;
            let [y, z] =
                [0, 1].map(|i| arc[before][i] + (arc[before + 1][i] - arc[before][i]) * share);
            let (sin_roll, cos_roll) = roll.at(s).sin_cos();
            let (sin_twist, cos_twist) = twist.at(s).sin_cos();
            let across = DVec3::new(0.0, sin_roll, cos_roll);
            let next = places
                .partition_point(|p| *p <= s)
                .clamp(1, places.len() - 1);
            let between = (s - places[next - 1]) / (places[next] - places[next - 1]);
            Frame {
                span_m: s,
                quarter_m: DVec3::new(sweep.at(s) + 0.25 * chord.at(s), y, z),
                chord_m: chord.at(s),
                aft: DVec3::X * cos_twist - across * sin_twist,
                up: DVec3::X * sin_twist + across * cos_twist,
                profiles: (
                    [stations[next - 1].profile, stations[next].profile],
                    between,
                ),
            }
        })
        .collect()
}

/// Monotone cubic through points (Fritsch & Carlson 1980, slopes of Fritsch & Butland 1984): it never overshoots, and a straight row of
/// points stays straight.
struct Curve {
    places: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Curve {
    fn new(places: &[f64], values: Vec<f64>) -> Self {
        let last = places.len() - 1;
        let width = |i: usize| places[i + 1] - places[i];
        let slope = |i: usize| (values[i + 1] - values[i]) / width(i);
        let mut slopes = vec![0.0; places.len()];
        slopes[0] = slope(0);
        slopes[last] = slope(last - 1);
        for i in 1..last {
            let (a, b) = (slope(i - 1), slope(i));
            if a * b > 0.0 {
                let (w1, w2) = (2.0 * width(i) + width(i - 1), width(i) + 2.0 * width(i - 1));
                slopes[i] = (w1 + w2) / (w1 / a + w2 / b);
            }
        }
        Self {
            places: places.to_vec(),
            values,
            slopes,
        }
    }

    fn at(&self, place: f64) -> f64 {
        let last = self.places.len() - 1;
        let i = self.places.partition_point(|p| *p <= place).clamp(1, last) - 1;
        let width = self.places[i + 1] - self.places[i];
        let t = (place - self.places[i]) / width;
        let (v0, v1) = (self.values[i], self.values[i + 1]);
        let (m0, m1) = (width * self.slopes[i], width * self.slopes[i + 1]);
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * v0
            + (t3 - 2.0 * t2 + t) * m0
            + (3.0 * t2 - 2.0 * t3) * v1
            + (t3 - t2) * m1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn station(span_m: f64, chord_m: f64, roll_rad: f64) -> Station {
        Station {
            span_m,
            chord_m,
            sweep_m: 0.0,
            roll_rad,
            twist_rad: 0.0,
            profile: 0,
        }
    }

    #[test]
    fn a_constant_bend_is_a_circle() {
        // Roll growing evenly to 60° over 4 m: radius 12/π.
        let roll = std::f64::consts::FRAC_PI_3;
        let stations = [station(0.0, 2.0, 0.0), station(4.0, 1.0, roll)];
        let frames = frames(&stations, &[0.0, 2.0, 4.0]);
        let radius = 4.0 / roll;
        for frame in &frames {
            let angle = frame.span_m / radius;
            let expected = [radius * angle.sin(), -radius * (1.0 - angle.cos())];
            assert!((frame.quarter_m.y - expected[0]).abs() < 1e-6);
            assert!((frame.quarter_m.z - expected[1]).abs() < 1e-6);
            assert!((frame.chord_m - (2.0 - 0.25 * frame.span_m)).abs() < 1e-12);
        }
    }

    #[test]
    fn curves_do_not_overshoot() {
        let curve = Curve::new(&[0.0, 1.0, 2.0, 3.0], vec![0.0, 0.0, 1.0, 1.0]);
        for i in 0..=300 {
            let value = curve.at(f64::from(i) / 100.0);
            assert!((0.0..=1.0).contains(&value));
        }
        assert!((curve.at(1.5) - 0.5).abs() < 1e-12);
    }
}
