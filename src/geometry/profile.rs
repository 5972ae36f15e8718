//! Profiles of wings: NACA four- and five-digit families and Selig's files of coordinates.
//!
//! Sources: Jacobs, Ward & Pinkerton, NACA Report 460 (1933), thickness and four-digit camber; Jacobs & Pinkerton, NACA Report 537 (1935),
//! five-digit camber, with k₁ and the place m computed from the conditions of that report in place of its rounded table. Departure: the last
//! coefficient of the thickness is −0.1036 in place of −0.1015, so that the trailing edge is closed.

use std::path::Path;

use glam::DVec2;

use super::spline::Spline;

/// Points per side of a profile made from a formula.
const POINTS_PER_SIDE: usize = 200;

/// Share of cosine spacing in the spacing along a side; the rest is uniform, so that neighbours never differ much in length.
const COSINE_SHARE: f64 = 0.7;

/// By how much points move on towards the trailing edge: lengths of the side times f² (1 − f). With both, lift of panels on sections of 12 to 18 % is within 0.3 % at 20
/// per side; a share of 0.8 and no shift made it 0.4 %.
const EDGE_SHIFT: f64 = 0.5;

/// An open trailing edge up to this height is closed by shear [chords].
const OPEN_TRAILING_EDGE: f64 = 0.05;

/// Points that a file has at least. NACA 2417 through 7 points is 18.9 % thick, and its moment is 24 % off; through 13 points its drag is 16 % too high, through 21 it is 1 %.
const LEAST_OF_A_FILE: usize = 20;

/// The second number over the first, from which on both count points, as in Lednicer's format; coordinates of a trailing edge have less.
const LEDNICER: f64 = 0.2;

/// Why there is no profile.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// Not a designation of one of the families.
    #[error(
        "`{0}` is no NACA profile that is known here: four digits such as 2412, or five such as 23015 whose first three are 210, 220, 230, 240 or 250"
    )]
    UnknownDesignation(String),
    /// A file cannot be read.
    #[error("{0}")]
    File(String),
    /// A line of a file is wrong.
    #[error("line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// The points make no profile.
    #[error("{0}")]
    Points(String),
}

/// A closed profile in units of the chord, x from 0 at the nose to 1 at the trailing edge, y up.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// From the trailing edge along the lower side around the nose and along the upper side to the trailing edge; the first point is the last.
    points: Vec<DVec2>,
    /// Index of the point next to the origin.
    nose: usize,
}

/// True of a line with x and y whose decimals stand behind commas.
fn has_decimal_commas(line: &str) -> bool {
    let words = line.split([' ', '\t', ';']).filter(|word| !word.is_empty());
    let decimal = |word: &str| {
        word.split_once(',').is_some_and(|(whole, part)| {
            let digits = |text: &str| text.chars().all(|c| c.is_ascii_digit());
            let whole = whole.trim_start_matches(['-', '+']);
            digits(whole) && digits(part) && !part.is_empty()
        })
    };
    let words: Vec<&str> = words.collect();
    let is_number = |word: &str| decimal(word) || word.parse::<f64>().is_ok();
    words.len() == 2 && words.iter().all(|w| is_number(w)) && words.iter().any(|w| decimal(w))
}

impl Profile {
    /// A profile through points given from the lower trailing edge around the nose to the upper one, in chords. A trailing edge open by at
    /// most 0.05 chords is closed by shear, half on each side.
    pub fn new(mut points: Vec<DVec2>) -> Result<Self, ProfileError> {
        let wrong = |what: &str| Err(ProfileError::Points(what.to_owned()));
        if points.len() < 7 {
            return wrong("a profile needs at least 7 points");
        }
        if points.iter().any(|p| !p.is_finite()) {
            return wrong("a coordinate of the profile is not finite");
        }
        // The mean line of a cambered profile begins at the origin, which is not always the point farthest ahead: nothing is turned.
        let edge = 0.5 * (points[0] + points[points.len() - 1]);
        let (nose, distance) =
            points
                .iter()
                .map(|p| p.length())
                .enumerate()
                .fold((0, f64::INFINITY), |best, next| {
                    if next.1 < best.1 { next } else { best }
                });
        if nose == 0
            || nose == points.len() - 1
            || distance > 0.02
            || edge.distance(DVec2::X) > 0.05
        {
            return wrong(
                "coordinates have to be over the chord, from the trailing edge at (1, 0) around the nose at (0, 0)",
            );
        }
        let gap = points[points.len() - 1].y - points[0].y;
        if gap.abs() > OPEN_TRAILING_EDGE {
            return wrong("the trailing edge of the profile is open by more than 0.05 chords");
        }
        for (k, p) in points.iter_mut().enumerate() {
            let side = if k <= nose { 0.5 } else { -0.5 };
            p.y += (side * gap - edge.y) * p.x;
        }
        let last = points.len() - 1;
        points[0] = DVec2::X;
        points[last] = DVec2::X;
        if points.windows(2).any(|p| p[0].distance(p[1]) < 1e-9) {
            return wrong("two neighbouring points of the profile coincide");
        }
        let doubled: f64 = points.windows(2).map(|p| p[0].perp_dot(p[1])).sum();
        // Lower side first is clockwise.
        if doubled > 0.0 {
            return wrong("the points of the profile have to begin along the lower side");
        }
        Ok(Self { points, nose })
    }

    /// A profile of the NACA four- or five-digit family, such as `2412` or `23015`.
    pub fn naca(designation: &str) -> Result<Self, ProfileError> {
        let unknown = || ProfileError::UnknownDesignation(designation.to_owned());
        let digits: Option<Vec<f64>> = designation
            .chars()
            .map(|c| c.to_digit(10).map(f64::from))
            .collect();
        let digits = digits.ok_or_else(unknown)?;
        let (camber, thickness) = match *digits.as_slice() {
            // A camber without a place, or a place without camber.
            [m, p, _, _] if (m > 0.0) != (p > 0.0) => return Err(unknown()),
            [m, p, t1, t2] => (
                if m == 0.0 {
                    Camber::None
                } else {
                    Camber::FourDigit {
                        height: 0.01 * m,
                        place: 0.1 * p,
                    }
                },
                0.1 * t1 + 0.01 * t2,
            ),
            [l, p, reflex, t1, t2] if l > 0.0 && (1.0..=5.0).contains(&p) && reflex == 0.0 => {
                (Camber::five_digit(l, 0.05 * p), 0.1 * t1 + 0.01 * t2)
            }
            _ => return Err(unknown()),
        };
        if thickness <= 0.0 {
            return Err(unknown());
        }
        let side = |k: usize, sign: f64| {
            let x = 0.5 * (1.0 - (std::f64::consts::PI * k as f64 / POINTS_PER_SIDE as f64).cos());
            let half = 5.0
                * thickness
                * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                    - 0.1036 * x.powi(4));
            let (height, slope) = camber.at(x);
            let angle = slope.atan();
            DVec2::new(
                x - sign * half * angle.sin(),
                height + sign * half * angle.cos(),
            )
        };
        let lower = (0..=POINTS_PER_SIDE).rev().map(|k| side(k, -1.0));
        Self::new(
            lower
                .chain((1..=POINTS_PER_SIDE).map(|k| side(k, 1.0)))
                .collect(),
        )
    }

    /// Reads a file of Selig's format: a title, then x and y per line from the upper trailing edge around the nose to the lower one.
    pub fn read(path: &Path) -> Result<Self, ProfileError> {
        let bytes = std::fs::read(path).map_err(|e| ProfileError::File(e.to_string()))?;
        if bytes.contains(&0) {
            return Err(ProfileError::Points(
                "the file is not plain text, or in UTF-16: save it as plain text".to_owned(),
            ));
        }
        // A title may have letters of any encoding.
        Self::parse(&String::from_utf8_lossy(&bytes))
    }

    /// Reads the text of a file of Selig's format.
    pub fn parse(text: &str) -> Result<Self, ProfileError> {
        let mut points = Vec::new();
        for (number, line) in text.lines().enumerate() {
            if has_decimal_commas(line) {
                return Err(ProfileError::Line {
                    line: number + 1,
                    what: format!("decimal commas: write points, as in 0.5: `{}`", line.trim()),
                });
            }
            let numbers: Option<Vec<f64>> = line
                .split([' ', '\t', ',', ';'])
                .filter(|word| !word.is_empty())
                .map(|word| word.parse().ok())
                .collect();
            match numbers.as_deref() {
                Some(&[x, y]) => {
                    if x > 1.5 && points.is_empty() && y.abs() < LEDNICER * x {
                        return Err(ProfileError::Line {
                            line: number + 1,
                            what: format!(
                                "coordinates go up to {x}: give them over the chord, from 0 to 1"
                            ),
                        });
                    }
                    if x > 1.5 && points.is_empty() {
                        return Err(ProfileError::Line {
                            line: number + 1,
                            what: "numbers of points, as in Lednicer's format; give Selig's, from the upper trailing edge around the nose to the lower one"
                                .to_owned(),
                        });
                    }
                    points.push(DVec2::new(x, y));
                }
                Some([]) => {}
                // The title.
                _ if points.is_empty() => {}
                _ => {
                    return Err(ProfileError::Line {
                        line: number + 1,
                        what: format!("two numbers are needed: `{}`", line.trim()),
                    });
                }
            }
        }
        // What Selig's format has as its first side is the last one here.
        let doubled: f64 = points.windows(2).map(|p| p[0].perp_dot(p[1])).sum();
        if points.len() > 2 && doubled < 0.0 {
            return Err(ProfileError::Points(
                "the points go along the lower side first: turn their order round; or the profile stands on its head, and y is to point up"
                    .to_owned(),
            ));
        }
        points.reverse();
        let count = points.len();
        let profile = Self::new(points)?;
        if count < LEAST_OF_A_FILE {
            return Err(ProfileError::Points(format!(
                "{count} points do not tell a profile, at least {LEAST_OF_A_FILE} do"
            )));
        }
        Ok(profile)
    }

    /// `2 per_side + 1` points from the trailing edge along the lower side around the nose and back along the upper side, close together at
    /// both ends of a side; the first is the last. Between the given points runs a cubic spline over arc length.
    #[must_use]
    pub fn resampled(&self, per_side: usize) -> Vec<DVec2> {
        let spline = Spline::new(self.points.clone());
        let (nose, end) = (spline.length_to(self.nose), spline.length());
        let per_side = per_side.max(2);
        let mut points: Vec<DVec2> = (0..=2 * per_side)
            .map(|k| {
                // From the nose to the trailing edge.
                let t = per_side.abs_diff(k) as f64 / per_side as f64;
                let cosine = 0.5 * (1.0 - (std::f64::consts::PI * t).cos());
                let f = COSINE_SHARE * cosine + (1.0 - COSINE_SHARE) * t;
                let f = f + EDGE_SHIFT * f * f * (1.0 - f);
                spline.place(if k <= per_side {
                    nose * (1.0 - f)
                } else {
                    nose + (end - nose) * f
                })
            })
            .collect();
        points[0] = DVec2::X;
        points[2 * per_side] = DVec2::X;
        points
    }

    /// Heights of the mean line over the chord at the given places, half-way between both sides.
    #[must_use]
    pub fn camber(&self, places: &[f64]) -> Vec<f64> {
        let fine = self.resampled(POINTS_PER_SIDE);
        let (lower, upper) = (&fine[..=POINTS_PER_SIDE], &fine[POINTS_PER_SIDE..]);
        let height = |side: &mut dyn Iterator<Item = &DVec2>, x: f64| {
            let mut before = DVec2::ZERO;
            for p in side {
                if p.x >= x {
                    let step = p.x - before.x;
                    let t = if step > 0.0 {
                        (x - before.x) / step
                    } else {
                        1.0
                    };
                    return before.y + t * (p.y - before.y);
                }
                before = *p;
            }
            before.y
        };
        places
            .iter()
            .map(|&x| 0.5 * (height(&mut lower.iter().rev(), x) + height(&mut upper.iter(), x)))
            .collect()
    }

    /// Largest thickness over the chord.
    #[must_use]
    pub fn thickness(&self) -> f64 {
        let fine = self.resampled(POINTS_PER_SIDE);
        let count = fine.len() - 1;
        (0..=POINTS_PER_SIDE)
            .map(|k| (fine[count - k].y - fine[k].y).abs())
            .fold(0.0, f64::max)
    }
}

/// A mean line.
#[derive(Debug, Clone, Copy)]
enum Camber {
    None,
    FourDigit {
        height: f64,
        place: f64,
    },
    /// y = k₁/6 (x³ − 3 m x² + m² (3 − m) x) before m, k₁ m³/6 (1 − x) behind.
    FiveDigit {
        place: f64,
        factor: f64,
    },
}

impl Camber {
    /// The mean line whose highest point is at `highest` and whose ideal lift coefficient is 0.15 `digit`.
    fn five_digit(digit: f64, highest: f64) -> Self {
        // Zero slope at the highest point: highest = m (1 − √(m/3)).
        let mut m = highest;
        for _ in 0..100 {
            m = highest / (1.0 - (m / 3.0).sqrt());
        }
        // Ideal lift coefficient of the thin profile.
        let q = (3.0 * m - 7.0 * m * m + 8.0 * m.powi(3) - 4.0 * m.powi(4))
            / (m * (1.0 - m)).sqrt()
            - 1.5 * (1.0 - 2.0 * m) * (0.5 * std::f64::consts::PI - (1.0 - 2.0 * m).asin());
        Self::FiveDigit {
            place: m,
            factor: 6.0 * 0.15 * digit / q,
        }
    }

    /// Height and slope.
    fn at(self, x: f64) -> (f64, f64) {
        match self {
            Self::None => (0.0, 0.0),
            Self::FourDigit { height, place: p } => {
                let scale = if x < p { p * p } else { (1.0 - p).powi(2) };
                let start = if x < p { 0.0 } else { 1.0 - 2.0 * p };
                (
                    height / scale * (start + 2.0 * p * x - x * x),
                    2.0 * height / scale * (p - x),
                )
            }
            Self::FiveDigit { place: m, factor } => {
                let k = factor / 6.0;
                if x < m {
                    (
                        k * (x.powi(3) - 3.0 * m * x * x + m * m * (3.0 - m) * x),
                        k * (3.0 * x * x - 6.0 * m * x + m * m * (3.0 - m)),
                    )
                } else {
                    (k * m.powi(3) * (1.0 - x), -k * m.powi(3))
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published coordinates: NACA 0012 is 0.12 thick at 30 %; 2412's mean line is highest, 0.02, at 40 %.
    #[test]
    fn naca_profiles_have_their_thickness_and_camber() {
        let thin = Profile::naca("0012").unwrap();
        assert!(
            (thin.thickness() - 0.12).abs() < 2e-4,
            "{}",
            thin.thickness()
        );
        assert!(thin.camber(&[0.3])[0].abs() < 1e-6);
        let cambered = Profile::naca("2412").unwrap();
        let heights = cambered.camber(&[0.3, 0.4, 0.5]);
        assert!((heights[1] - 0.02).abs() < 1e-4, "{heights:?}");
        assert!(heights[1] > heights[0] && heights[1] > heights[2]);
    }

    /// Abbott & von Doenhoff 1959, table of the 230 mean line: m = 0.2025, k₁ = 15.957; NACA 23015 at 15 %: camber 0.0184.
    #[test]
    fn the_230_mean_line_is_the_published_one() {
        let Camber::FiveDigit { place, factor } = Camber::five_digit(2.0, 0.15) else {
            panic!()
        };
        assert!((place - 0.2025).abs() < 1e-3, "{place}");
        assert!((factor - 15.957).abs() < 0.05, "{factor}");
        let profile = Profile::naca("23015").unwrap();
        assert!((profile.camber(&[0.15])[0] - 0.0184).abs() < 4e-4);
        assert!((profile.thickness() - 0.15).abs() < 3e-3);
    }

    /// Resampling keeps the shape: all points lie on the formula's curve.
    #[test]
    fn resampling_keeps_the_curve() {
        let profile = Profile::naca("0018").unwrap();
        for p in profile.resampled(23) {
            let x = p.x.clamp(0.0, 1.0);
            let half = 0.9
                * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                    - 0.1036 * x.powi(4));
            assert!((p.y.abs() - half).abs() < 2e-5, "{p} {half}");
        }
    }

    #[test]
    fn a_selig_file_is_read_and_closed() {
        let whole = Profile::naca("2415").unwrap();
        // Turned a little, and open by 0.002 at the trailing edge.
        let mut text = "some profile\n".to_owned();
        for (k, p) in whole.points.iter().enumerate().rev() {
            let sign = if k < whole.nose { -1.0 } else { 1.0 };
            let y = p.y + 0.001 * p.x * sign;
            text.push_str(&format!("  {:.9} {:.9}\n", p.x, y + 0.01 * p.x));
        }
        let read = Profile::parse(&text).unwrap();
        for (a, b) in read.resampled(20).iter().zip(whole.resampled(20)) {
            assert!(a.distance(b) < 2e-4, "{a} {b}");
        }
    }

    #[test]
    fn decimal_commas_are_told_with_their_line() {
        let told = |text: &str| Profile::parse(text).unwrap_err().to_string();
        for line in ["1,00000 0,00126", "1,0;0,00126", "1 -0,5"] {
            let told = told(&format!("wing\n{line}\n"));
            assert!(
                told.contains("decimal commas") && told.contains('2'),
                "{told}"
            );
        }
        // Commas between numbers, and in a title.
        for line in ["1.0,0.001", "NACA 2415,5"] {
            let told = told(&format!("wing\n{line}\n"));
            assert!(!told.contains("decimal"), "{told}");
        }
    }

    #[test]
    fn faults_are_named() {
        for designation in [
            "", "24", "241x", "23115", "29015", "2400", "2300", "4012", "0412",
        ] {
            assert!(
                matches!(
                    Profile::naca(designation),
                    Err(ProfileError::UnknownDesignation(_))
                ),
                "{designation}"
            );
        }
        for (text, part) in [
            ("title\n", "at least 7"),
            ("title\n1 0\n0.5\n", "line 3"),
            ("title\n17 17\n", "Lednicer"),
            ("title\n100.0 -0.1\n", "up to 100: give them over the chord"),
            (
                "t\n1 0\n.7 .1\n.3 .1\n0 0\n.3 -.1\n.7 -.1\n1 0\n",
                "7 points do not tell",
            ),
            ("t\n1 0\n.7 .1\n.3 .1\n0 0\n.3 -.1\n.7 nan\n1 0\n", "finite"),
            (
                "t\n1 0\n.7 -.1\n.3 -.1\n0 0\n.3 .1\n.7 .1\n1 0\n",
                "turn their order round",
            ),
            (
                "t\n1 .1\n.7 .1\n.3 .1\n0 0\n.3 -.1\n.7 -.1\n1 -.1\n",
                "open",
            ),
        ] {
            let error = Profile::parse(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
