//! Profiles of ribs: height of the upper and the lower side over the chord, both per chord.
//!
//! A NACA four-digit profile has its thickness added across the chord, not across the camber line (x then is the place along the chord
//! on both sides, and every rib has the same stations), with the coefficient of a closed trailing edge.

use glam::DVec2;

/// Points along each side of a profile of coordinates.
const SAMPLES: usize = 200;

/// How far a nose may reach ahead of the origin, and a side turn back behind it, per chord.
const BLUNT_NOSE: f64 = 0.01;

/// Side of a wing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Towards the low pressure.
    Upper,
    /// Towards the lines.
    Lower,
}

/// A profile with its nose at (0, 0) and its sharp trailing edge at (1, 0).
#[derive(Debug, Clone, PartialEq)]
pub enum Profile {
    /// NACA four-digit profile.
    Naca {
        /// Largest camber per chord.
        camber: f64,
        /// Where it is, per chord.
        camber_position: f64,
        /// Largest thickness per chord.
        thickness: f64,
    },
    /// Points (x, z) of both sides, from the nose to the trailing edge.
    Points {
        /// Upper side.
        upper: Vec<[f64; 2]>,
        /// Lower side.
        lower: Vec<[f64; 2]>,
        /// Where a straight cut of the nose ends on the lower side.
        nose_cut: Option<f64>,
    },
}

impl Profile {
    /// Profile of four digits, such as `2415`; `None` for anything else.
    #[must_use]
    pub fn naca(digits: &str) -> Option<Self> {
        let numbers: Vec<f64> = digits
            .chars()
            .map(|c| c.to_digit(10).map(f64::from))
            .collect::<Option<_>>()?;
        let [camber, position, tens, ones] = numbers[..] else {
            return None;
        };
        let thickness = 0.1 * tens + 0.01 * ones;
        let cambered = camber > 0.0;
        if thickness < 0.01 || cambered != (position > 0.0) {
            return None;
        }
        Some(Self::Naca {
            camber: 0.01 * camber,
            camber_position: 0.1 * position,
            thickness,
        })
    }

    /// A profile of coordinates, over places of both sides that grow from the nose at the origin to the trailing edge; `None` where a side turns back
    /// along the chord. What lies ahead of the origin, as the nose of some cambered profiles does a little, is left out.
    #[must_use]
    pub fn sampled(profile: &crate::geometry::profile::Profile) -> Option<Self> {
        let points = profile.resampled(SAMPLES);
        let side = |points: &mut dyn Iterator<Item = &DVec2>| {
            let mut side = vec![[0.0, 0.0]];
            for point in points {
                let last = side[side.len() - 1][0];
                if point.x > last {
                    side.push([point.x, point.y]);
                } else if last > BLUNT_NOSE || point.x < -BLUNT_NOSE {
                    return None;
                }
            }
            // Closed and sharp.
            (side[side.len() - 1] == [1.0, 0.0]).then_some(side)
        };
        let (lower, upper) = points.split_at(SAMPLES);
        Some(Self::Points {
            upper: side(&mut upper.iter())?,
            lower: side(&mut lower.iter().rev())?,
            nose_cut: None,
        })
    }

    /// The profile with its nose cut off along a straight line from `above` on its upper to `below` on its lower side, per chord, as that of ram-air parachutes is.
    /// The new nose is the upper lip, the new chord leads from there to the trailing edge and is one long. `None` unless the cut leads backwards.
    #[must_use]
    pub fn with_nose_cut(&self, above: f64, below: f64) -> Option<Self> {
        let point = |side, x| DVec2::new(x, self.height(side, x));
        let [lip, heel] = [point(Side::Upper, above), point(Side::Lower, below)];
        let chord = DVec2::X - lip;
        let turned = |p: DVec2| -> [f64; 2] {
            ((p - lip).rotate(DVec2::new(chord.x, -chord.y)) / chord.length_squared()).to_array()
        };
        // Closer where sides are bent most.
        let along = |side: Side, from: f64| {
            (1..=SAMPLES).map(move |i| {
                let share = i as f64 / SAMPLES as f64;
                point(side, from + (1.0 - from) * share * share)
            })
        };
        let cut = (0..=SAMPLES).map(|i| lip.lerp(heel, i as f64 / SAMPLES as f64));
        let closed = |points: &mut dyn Iterator<Item = DVec2>| {
            let mut side: Vec<[f64; 2]> = points.map(turned).collect();
            let last = side.len() - 1;
            side[last] = [1.0, 0.0];
            let grows = side.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            grows.then_some(side)
        };
        Some(Self::Points {
            upper: closed(&mut std::iter::once(lip).chain(along(Side::Upper, above)))?,
            lower: closed(&mut cut.chain(along(Side::Lower, below)))?,
            nose_cut: Some(turned(heel)[0]),
        })
    }

    /// Height of a side at `x`, per chord.
    #[must_use]
    pub fn height(&self, side: Side, x: f64) -> f64 {
        match self {
            Self::Naca {
                camber,
                camber_position: p,
                thickness,
            } => {
                let line = if *camber == 0.0 {
                    0.0
                } else if x < *p {
                    camber / (p * p) * (2.0 * p * x - x * x)
                } else {
                    camber / ((1.0 - p) * (1.0 - p)) * (1.0 - 2.0 * p + 2.0 * p * x - x * x)
                };
                // Closed trailing edge: −0.1036 for −0.1015.
                let half = 5.0
                    * thickness
                    * (0.2969 * x.max(0.0).sqrt()
                        + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1036 * x))));
                match side {
                    Side::Upper => line + half,
                    Side::Lower => line - half,
                }
            }
            Self::Points { upper, lower, .. } => match side {
                Side::Upper => between(upper, x),
                Side::Lower => between(lower, x),
            },
        }
    }
}

/// Straight in √x, along which a round nose is straight.
fn between(points: &[[f64; 2]], x: f64) -> f64 {
    let next = points
        .partition_point(|p| p[0] <= x)
        .clamp(1, points.len() - 1);
    let ([x0, z0], [x1, z1]) = (points[next - 1], points[next]);
    let share = (x.max(0.0).sqrt() - x0.sqrt()) / (x1.sqrt() - x0.sqrt());
    z0 + (z1 - z0) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn naca_digits_give_thickness_and_camber() {
        let profile = Profile::naca("2415").unwrap();
        let thickness = |x: f64| profile.height(Side::Upper, x) - profile.height(Side::Lower, x);
        assert!((thickness(0.3) - 0.15).abs() < 1e-4);
        let camber = 0.5 * (profile.height(Side::Upper, 0.4) + profile.height(Side::Lower, 0.4));
        assert!((camber - 0.02).abs() < 1e-12);
        assert!(profile.height(Side::Upper, 1.0).abs() < 1e-12);
        assert_eq!(profile.height(Side::Lower, 0.0), 0.0);
        for bad in ["241", "24155", "2a15", "2015", "0415", "2400"] {
            assert_eq!(Profile::naca(bad), None, "{bad}");
        }
    }

    /// Points of both sides of the whole profile lie on the cut one, turned and scaled, but for what lies between its 200 points a side (2e-5); between
    /// lip and heel it is straight.
    #[test]
    fn a_cut_nose_leaves_the_rest_as_it_was() {
        let whole = Profile::naca("2420").unwrap();
        let cut = whole.with_nose_cut(0.02, 0.08).unwrap();
        let point = |side, x: f64| DVec2::new(x, whole.height(side, x));
        let [lip, heel] = [point(Side::Upper, 0.02), point(Side::Lower, 0.08)];
        let (along, long) = ((DVec2::X - lip).normalize(), (DVec2::X - lip).length());
        let place = |p: DVec2| {
            [
                (p - lip).dot(along) / long,
                (p - lip).dot(along.perp()) / long,
            ]
        };
        for (side, from) in [(Side::Upper, 0.02), (Side::Lower, 0.08)] {
            for i in 0..=20 {
                let [x, z] = place(point(side, from + (1.0 - from) * f64::from(i) / 20.0));
                assert!((cut.height(side, x) - z).abs() < 2e-5, "{side:?} {x} {z}");
            }
        }
        let Profile::Points {
            nose_cut: Some(end),
            ..
        } = cut
        else {
            panic!("{cut:?}")
        };
        let [x, z] = place(heel);
        assert!((end - x).abs() < 1e-12);
        for share in [0.0, 0.3, 0.7, 1.0] {
            let error = cut.height(Side::Lower, share * x) - share * z;
            assert!(error.abs() < 2e-5, "{share} {error}");
        }
        assert_eq!(whole.with_nose_cut(0.1, 0.02), None);
    }

    #[test]
    fn points_follow_the_profile_they_were_taken_from() {
        let naca = Profile::naca("2415").unwrap();
        let side = |side| {
            (0..=60)
                .map(|i| {
                    let x = (f64::from(i) / 60.0).powi(2);
                    [x, naca.height(side, x)]
                })
                .collect::<Vec<_>>()
        };
        let points = Profile::Points {
            upper: side(Side::Upper),
            lower: side(Side::Lower),
            nose_cut: None,
        };
        for i in 0..100 {
            let x = f64::from(i) / 99.0;
            for s in [Side::Upper, Side::Lower] {
                assert!((points.height(s, x) - naca.height(s, x)).abs() < 2e-4);
            }
        }
    }
}
