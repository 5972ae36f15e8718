//! Outlines for the tests.

use glam::DVec2;

/// NACA four-digit section with its open trailing edge, or `23015`-like five-digit ones with the 230 mean line.
pub fn naca(designation: &str) -> Vec<DVec2> {
    let digits: Vec<f64> = designation
        .chars()
        .map(|c| f64::from(c.to_digit(10).unwrap()))
        .collect();
    let count = digits.len();
    let thickness = 0.1 * digits[count - 2] + 0.01 * digits[count - 1];
    let mean = |x: f64| -> (f64, f64) {
        if count == 5 {
            assert_eq!(&designation[..3], "230");
            let (m, k) = (0.2025, 15.957 / 6.0);
            if x < m {
                (
                    k * (x.powi(3) - 3.0 * m * x * x + m * m * (3.0 - m) * x),
                    k * (3.0 * x * x - 6.0 * m * x + m * m * (3.0 - m)),
                )
            } else {
                (k * m.powi(3) * (1.0 - x), -k * m.powi(3))
            }
        } else if digits[0] == 0.0 {
            (0.0, 0.0)
        } else {
            let (height, p) = (0.01 * digits[0], 0.1 * digits[1]);
            if x < p {
                let f = height / (p * p);
                (f * (2.0 * p * x - x * x), f * 2.0 * (p - x))
            } else {
                let f = height / (1.0 - p).powi(2);
                (f * (1.0 - 2.0 * p + 2.0 * p * x - x * x), f * 2.0 * (p - x))
            }
        }
    };
    around(thickness, mean)
}

/// A paraglider-like section: 17 % thick, 2.5 % camber ahead, reflex behind.
pub fn paraglider() -> Vec<DVec2> {
    let mean = |x: f64| {
        let f = 0.29;
        // x (1 − x) (7/8 − x) has its zero lift moment near zero.
        let a = 0.875;
        (
            f * x * (1.0 - x) * (a - x),
            f * (a - 2.0 * (1.0 + a) * x + 3.0 * x * x),
        )
    };
    around(0.17, mean)
}

/// A section whose mean line bends down smoothly by an angle between 0.75 and 0.85 chords.
pub fn with_flap(outline: &[DVec2], degrees: f64) -> Vec<DVec2> {
    let (from, width, bend) = (0.75, 0.1, degrees.to_radians().tan());
    outline
        .iter()
        .map(|p| {
            let u = ((p.x - from) / width).clamp(0.0, 1.0);
            let slope = -bend * (3.0 * u * u - 2.0 * u * u * u);
            let behind = (p.x - from - width).max(0.0);
            let height = -bend * (width * (u.powi(3) - 0.5 * u.powi(4)) + behind);
            let normal = DVec2::new(-slope, 1.0) / (1.0 + slope * slope).sqrt();
            DVec2::new(p.x, height) + p.y * normal
        })
        .collect()
}

fn around(thickness: f64, mean: impl Fn(f64) -> (f64, f64)) -> Vec<DVec2> {
    let half = 100;
    (0..=2 * half)
        .map(|k| {
            let t = (k as f64 - half as f64) / half as f64 * std::f64::consts::PI;
            let x = 0.5 * (1.0 - t.cos());
            let y = 5.0
                * thickness
                * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                    - 0.1015 * x.powi(4));
            let (height, slope) = mean(x);
            let side = if k < half { -1.0 } else { 1.0 };
            let normal = DVec2::new(-slope, 1.0) / (1.0 + slope * slope).sqrt();
            DVec2::new(x, height) + side * y * normal
        })
        .collect()
}
