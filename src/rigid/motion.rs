//! Prescribed motions: position and velocity of a rigid body as functions of time, which are held before t = 0.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

/// How a body moves.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Not at all.
    Held,
    /// Constant velocity [m/s], reached after a linear rise [s].
    ConstantVelocity {
        /// Velocity [m/s].
        velocity_m_s: DVec3,
        /// Time in which it rises from zero [s].
        rise_s: f64,
    },
    /// Displacement at constant velocity, then rest.
    Ramp {
        /// Displacement at the end [m].
        displacement_m: DVec3,
        /// Time that it takes [s]; 0: displaced from the start.
        ramp_s: f64,
    },
    /// Constant rate of rotation about the axis, reached after a linear rise.
    ConstantRotation {
        /// Rate [rad/s].
        rate_rad_s: f64,
        /// Time in which it rises from zero [s].
        rise_s: f64,
    },
    /// Position and angle follow sin(2π f t + phase).
    Oscillation {
        /// Frequency [Hz].
        frequency_hz: f64,
        /// Phase at t = 0 [rad].
        phase_rad: f64,
        /// Amplitude of the displacement [m].
        displacement_m: DVec3,
        /// Amplitude of the angle about the axis [rad].
        angle_rad: f64,
    },
    /// Displacements and angles at given times, joined by a natural cubic spline.
    Table(Table),
}

/// A motion with its axis.
#[derive(Debug, Clone, PartialEq)]
pub struct PrescribedMotion {
    /// How it moves.
    pub motion: Motion,
    /// Point of the body that the displacement is that of, and that the axis goes through [m].
    pub centre_m: DVec3,
    /// Axis of rotation, of unit length.
    pub axis: DVec3,
}

/// Where a body is, and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    centre_m: DVec3,
    displacement_m: DVec3,
    rotation: DQuat,
    velocity_m_s: DVec3,
    rate_rad_s: DVec3,
}

impl Placement {
    /// Position of the point of the body that is at `point_m` when nothing is displaced or turned [m].
    #[must_use]
    pub fn position_m(&self, point_m: DVec3) -> DVec3 {
        self.centre_m + self.displacement_m + self.rotation * (point_m - self.centre_m)
    }

    /// Its velocity [m/s].
    #[must_use]
    pub fn velocity_m_s(&self, point_m: DVec3) -> DVec3 {
        let arm = self.rotation * (point_m - self.centre_m);
        self.velocity_m_s + self.rate_rad_s.cross(arm)
    }
}

impl PrescribedMotion {
    /// A body that never moves.
    #[must_use]
    pub const fn held() -> Self {
        Self {
            motion: Motion::Held,
            centre_m: DVec3::ZERO,
            axis: DVec3::X,
        }
    }

    /// True if the body moves at all.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.motion != Motion::Held
    }

    /// Instants up to `end_s` that show the whole way, so many and one more. Of what repeats they are those of one period: looks over many might all meet
    /// the same phase. A body that does not move has one instant.
    pub fn looks_s(&self, end_s: f64, looks: u32) -> impl Iterator<Item = f64> {
        let span_s = match self.motion {
            Motion::Oscillation { frequency_hz, .. } => end_s.min(frequency_hz.recip()),
            Motion::ConstantRotation { rate_rad_s, rise_s } if rate_rad_s != 0.0 => {
                end_s.min(rise_s + std::f64::consts::TAU / rate_rad_s.abs())
            }
            _ => end_s,
        };
        let looks = if self.moves() { looks } else { 0 };
        (0..=looks).map(move |look| span_s * f64::from(look) / f64::from(looks.max(1)))
    }

    /// Where the body is at `time_s`; before t = 0 it rests where it is at t = 0.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Placement {
        let (displacement_m, velocity_m_s, angle, rate) = self.motion.at(time_s.max(0.0));
        let moving = if time_s < 0.0 { 0.0 } else { 1.0 };
        Placement {
            centre_m: self.centre_m,
            displacement_m,
            rotation: DQuat::from_axis_angle(self.axis, angle),
            velocity_m_s: velocity_m_s * moving,
            rate_rad_s: self.axis * (rate * moving),
        }
    }
}

impl Motion {
    /// Displacement, its rate, angle, its rate.
    fn at(&self, t: f64) -> (DVec3, DVec3, f64, f64) {
        match self {
            Self::Held => (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0),
            Self::ConstantVelocity {
                velocity_m_s,
                rise_s,
            } => {
                let (way, rate) = risen(t, *rise_s);
                (*velocity_m_s * way, *velocity_m_s * rate, 0.0, 0.0)
            }
            Self::Ramp {
                displacement_m,
                ramp_s,
            } => {
                if t < *ramp_s {
                    let velocity = *displacement_m / *ramp_s;
                    (velocity * t, velocity, 0.0, 0.0)
                } else {
                    (*displacement_m, DVec3::ZERO, 0.0, 0.0)
                }
            }
            Self::ConstantRotation { rate_rad_s, rise_s } => {
                let (way, rate) = risen(t, *rise_s);
                (
                    DVec3::ZERO,
                    DVec3::ZERO,
                    rate_rad_s * way,
                    rate_rad_s * rate,
                )
            }
            Self::Oscillation {
                frequency_hz,
                phase_rad,
                displacement_m,
                angle_rad,
            } => {
                let omega = TAU * frequency_hz;
                let (sine, cosine) = (omega * t + phase_rad).sin_cos();
                (
                    *displacement_m * sine,
                    *displacement_m * (omega * cosine),
                    angle_rad * sine,
                    angle_rad * omega * cosine,
                )
            }
            Self::Table(table) => {
                let ([x, y, z, angle], [u, v, w, rate]) = table.at(t);
                (DVec3::new(x, y, z), DVec3::new(u, v, w), angle, rate)
            }
        }
    }
}

/// ∫ and value of a rate that rises linearly from 0 to 1 in `rise` and stays there.
fn risen(t: f64, rise: f64) -> (f64, f64) {
    if t < rise {
        (0.5 * t * t / rise, t / rise)
    } else {
        (t - 0.5 * rise, 1.0)
    }
}

/// Displacement x, y, z [m] and angle [rad] at given times, joined by a *natural cubic spline*: velocities and accelerations are
/// continuous.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    times_s: Vec<f64>,
    values: Vec<[f64; 4]>,
    /// Second derivatives.
    curvatures: Vec<[f64; 4]>,
}

impl Table {
    /// `None` unless there are at least two rows with ascending finite times, and as many values.
    #[must_use]
    pub fn new(times_s: Vec<f64>, values: Vec<[f64; 4]>) -> Option<Self> {
        let ascending = times_s.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = times_s
            .iter()
            .chain(values.iter().flatten())
            .all(|v| v.is_finite());
        if times_s.len() < 2 || times_s.len() != values.len() || !ascending || !finite {
            return None;
        }
        let n = times_s.len();
        // Thomas algorithm for h₋ M₋ + 2 (h₋ + h₊) M + h₊ M₊ = 6 (slope₊ − slope₋), M = 0 at both ends.
        let mut curvatures = vec![[0.0; 4]; n];
        let step = |i: usize| times_s[i + 1] - times_s[i];
        for c in 0..4 {
            let mut upper = vec![0.0; n];
            let mut right = vec![0.0; n];
            for i in 1..n - 1 {
                let slope = |i: usize| (values[i + 1][c] - values[i][c]) / step(i);
                let pivot = 2.0 * (step(i - 1) + step(i)) - step(i - 1) * upper[i - 1];
                upper[i] = step(i) / pivot;
                right[i] = (6.0 * (slope(i) - slope(i - 1)) - step(i - 1) * right[i - 1]) / pivot;
            }
            for i in (1..n - 1).rev() {
                curvatures[i][c] = right[i] - upper[i] * curvatures[i + 1][c];
            }
        }
        Some(Self {
            times_s,
            values,
            curvatures,
        })
    }

    /// First and last time [s].
    #[must_use]
    pub fn range_s(&self) -> [f64; 2] {
        [self.times_s[0], self.times_s[self.times_s.len() - 1]]
    }

    /// Values and rates at a time; the nearest end's beyond the table.
    fn at(&self, time_s: f64) -> ([f64; 4], [f64; 4]) {
        let [first, last] = self.range_s();
        let t = time_s.clamp(first, last);
        let i = self
            .times_s
            .partition_point(|&time| time <= t)
            .clamp(1, self.times_s.len() - 1)
            - 1;
        let h = self.times_s[i + 1] - self.times_s[i];
        let (a, b) = ((self.times_s[i + 1] - t) / h, (t - self.times_s[i]) / h);
        let mut result = ([0.0; 4], [0.0; 4]);
        for c in 0..4 {
            let [y0, y1] = [self.values[i][c], self.values[i + 1][c]];
            let [m0, m1] = [self.curvatures[i][c], self.curvatures[i + 1][c]];
            result.0[c] =
                a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0;
            result.1[c] =
                (y1 - y0) / h + ((1.0 - 3.0 * a * a) * m0 + (3.0 * b * b - 1.0) * m1) * h / 6.0;
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motions() -> Vec<Motion> {
        let times: Vec<f64> = (0..21)
            .map(|i| 0.1 * f64::from(i) + 0.02 * f64::from(i % 3))
            .collect();
        let values = times
            .iter()
            .map(|t| [(2.0 * t).sin(), t * t, -t, (3.0 * t).cos()])
            .collect();
        vec![
            Motion::Held,
            Motion::ConstantVelocity {
                velocity_m_s: DVec3::new(1.0, -2.0, 0.5),
                rise_s: 0.4,
            },
            Motion::Ramp {
                displacement_m: DVec3::new(0.3, 0.0, -0.2),
                ramp_s: 0.5,
            },
            Motion::ConstantRotation {
                rate_rad_s: 3.0,
                rise_s: 0.0,
            },
            Motion::Oscillation {
                frequency_hz: 0.7,
                phase_rad: 0.3,
                displacement_m: DVec3::new(0.1, 0.0, 0.3),
                angle_rad: 0.8,
            },
            Motion::Table(Table::new(times, values).unwrap()),
        ]
    }

    /// The velocity of a point is the rate of its position.
    #[test]
    fn velocities_are_rates_of_positions() {
        for motion in motions() {
            let moved = PrescribedMotion {
                motion,
                centre_m: DVec3::new(0.5, 0.2, -0.1),
                axis: DVec3::new(1.0, 2.0, -1.0).normalize(),
            };
            let point = DVec3::new(1.0, 0.0, 0.7);
            for t in [0.05, 0.31, 0.77, 1.5] {
                let step = 1e-6;
                let position = |t: f64| moved.at(t).position_m(point);
                let rate = (position(t + step) - position(t - step)) / (2.0 * step);
                let error = (rate - moved.at(t).velocity_m_s(point)).length();
                assert!(error < 1e-8, "{moved:?} at {t}: {error:e}");
            }
            // Held before t = 0.
            assert_eq!(moved.at(-0.3).velocity_m_s(point), DVec3::ZERO);
            assert_eq!(
                moved.at(-0.3).position_m(point),
                moved.at(0.0).position_m(point)
            );
        }
    }

    /// Looks at what repeats see all of its way, however many whole periods a run has.
    #[test]
    fn looks_see_the_whole_way() {
        let point = DVec3::new(0.0, 1.0, 0.0);
        let turning = Motion::ConstantRotation {
            rate_rad_s: std::f64::consts::TAU,
            rise_s: 0.0,
        };
        let heaving = Motion::Oscillation {
            frequency_hz: 5.0,
            phase_rad: 0.0,
            displacement_m: DVec3::new(0.0, -1.0, 0.0),
            angle_rad: 0.0,
        };
        for (motion, end_s) in [(turning, 400.0), (heaving, 40.0)] {
            let moved = PrescribedMotion {
                motion,
                centre_m: DVec3::ZERO,
                axis: DVec3::X,
            };
            let heights = moved
                .looks_s(end_s, 200)
                .map(|time_s| moved.at(time_s).position_m(point).y);
            let lowest = heights.fold(f64::INFINITY, f64::min);
            let expected = if end_s > 100.0 { -1.0 } else { 0.0 };
            assert!((lowest - expected).abs() < 1e-3, "{lowest}");
        }
        assert_eq!(PrescribedMotion::held().looks_s(9.0, 200).count(), 1);
    }

    /// A spline goes through its rows and follows a smooth function between them.
    #[test]
    fn a_table_is_met_and_smooth() {
        let times: Vec<f64> = (0..41).map(|i| 0.05 * f64::from(i)).collect();
        let values: Vec<[f64; 4]> = times.iter().map(|t| [t.sin(), 0.0, *t, 1.0]).collect();
        let table = Table::new(times.clone(), values.clone()).unwrap();
        for (t, value) in times.iter().zip(&values) {
            assert!((table.at(*t).0[0] - value[0]).abs() < 1e-14);
        }
        let (value, rate) = table.at(0.987);
        assert!((value[0] - 0.987f64.sin()).abs() < 1e-6);
        assert!((rate[0] - 0.987f64.cos()).abs() < 1e-5);
        assert!((rate[2] - 1.0).abs() < 1e-12 && rate[3].abs() < 1e-12);
        assert!(Table::new(vec![0.0, 0.0], vec![[0.0; 4]; 2]).is_none());
        assert!(Table::new(vec![0.0], vec![[0.0; 4]]).is_none());
    }
}
