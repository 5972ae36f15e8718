//! Pressure inside a cell by that before its mouth.
//!
//! The air inside hardly moves, so what bounds the stream across the mouth is a line of one pressure, C_i. Where the closed section has the pressure C_o(s) along the
//! mouth, that line leaves the upstream lip smoothly and comes back to the other one. For small differences this is the equation of a thin aerofoil turned around: with t
//! from −1 at the upstream lip to 1,
//!
//! ```text
//! C_i = 1/π ∫ C_o(t) √((1 − t)/(1 + t)) dt
//! ```
//!
//! For a pressure that falls evenly it is that at a quarter of the mouth behind the upstream lip: more than the mean. Where the stream divides in the mouth, what arrives
//! before it keeps its pressure, and both lips may be the upstream one: the lower of both values is taken, which goes on without a jump where the dividing point leaves
//! the mouth. How far cells of the lattice agree stands in docs/results/2026-11-27-pressure-inside-ram-air-wings.md.

use std::f64::consts::PI;

/// Points of the quadrature.
const POINTS: usize = 64;

/// Coefficient of the pressure inside, by points (place along the mouth from lip to lip, coefficient before it), of which there are two at least.
#[must_use]
pub fn pressure_inside(before: &[[f64; 2]]) -> f64 {
    let backward: Vec<[f64; 2]> = before.iter().rev().map(|[s, c]| [-s, *c]).collect();
    leaving_first_lip(before).min(leaving_first_lip(&backward))
}

/// The same where the first lip is the upstream one.
fn leaving_first_lip(before: &[[f64; 2]]) -> f64 {
    let (Some(first), Some(last)) = (before.first(), before.last()) else {
        return 0.0;
    };
    let highest = before
        .iter()
        .map(|point| point[1])
        .fold(f64::NEG_INFINITY, f64::max);
    let divides = before
        .iter()
        .position(|point| point[1] == highest)
        .unwrap_or(0);
    // With t = −cos θ the weight is (1 + cos θ) dθ.
    let mut sum = 0.0;
    for i in 0..POINTS {
        let cos = (PI * (i as f64 + 0.5) / POINTS as f64).cos();
        let place = first[0] + 0.5 * (1.0 - cos) * (last[0] - first[0]);
        let next = before
            .partition_point(|point| point[0] <= place)
            .clamp(1, before.len() - 1);
        let coefficient = if next <= divides {
            highest
        } else {
            let [a, b] = [before[next - 1], before[next]];
            a[1] + (b[1] - a[1]) * (place - a[0]) / (b[0] - a[0])
        };
        sum += coefficient * (1.0 + cos);
    }
    sum / POINTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mouth(coefficient: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let places = (0..=200).map(|i| f64::from(i) / 200.0);
        places.map(|s| [3.0 + 2.0 * s, coefficient(s)]).collect()
    }

    #[test]
    fn one_pressure_before_the_mouth_stands_inside() {
        assert!((pressure_inside(&mouth(|_| 0.7)) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn a_falling_pressure_counts_at_a_quarter_of_the_mouth() {
        let falling = pressure_inside(&mouth(|s| 0.9 - 0.4 * s));
        assert!((falling - 0.8).abs() < 1e-6, "{falling}");
        let rising = pressure_inside(&mouth(|s| 0.5 + 0.4 * s));
        assert!((rising - 0.8).abs() < 1e-6, "{rising}");
    }

    /// The line of one pressure comes back to the other lip: its slope, by the equation that it follows, sums up to nothing.
    #[test]
    fn the_line_across_the_mouth_closes() {
        let before = mouth(|s| 1.0 - 1.3 * s * s + 0.2 * s);
        let inside = leaving_first_lip(&before);
        // Slope η' = −√((1 + t)/(1 − t))/π ⨍ √((1 − τ)/(1 + τ)) g(τ)/(t − τ) dτ with g = C_i − C_o, by Chebyshev points of both kinds.
        let n = 400;
        let g = |t: f64| {
            let s = 0.5 * (1.0 + t);
            inside - (1.0 - 1.3 * s * s + 0.2 * s)
        };
        let angle = |k: f64| PI * k / f64::from(n);
        let mut rise = 0.0;
        for i in 1..n {
            let t = -angle(f64::from(i)).cos();
            let mut slope = 0.0;
            for j in 0..n {
                let tau = -angle(f64::from(j) + 0.5).cos();
                slope += (1.0 - tau) * g(tau) / (t - tau);
            }
            rise += (1.0 + t) * slope / f64::from(n * n);
        }
        assert!(rise.abs() < 0.01, "{rise}");
    }

    /// As the dividing point crosses a mouth the pressure inside rises to that of stagnation and falls again, without a jump.
    #[test]
    fn it_follows_the_dividing_point() {
        let at =
            |divides: f64| pressure_inside(&mouth(|s| 1.0 - 1.5 * (s - divides) * (s - divides)));
        let values: Vec<f64> = (-20..=120).map(|i| at(0.01 * f64::from(i))).collect();
        for pair in values.windows(2) {
            assert!((pair[1] - pair[0]).abs() < 0.03, "{pair:?}");
        }
        let middle = values[70];
        assert!(middle > 0.95 && middle < 1.0, "{middle}");
        // At either lip 1 − 1.5 s² counts at s² = 1/8.
        for lip in [values[20], values[120]] {
            assert!((lip - (1.0 - 1.5 / 8.0)).abs() < 1e-3, "{lip}");
        }
    }
}
