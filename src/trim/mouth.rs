//! Pressure inside a cell by that before its mouth.
//!
//! The air inside hardly moves. So what bounds the stream across the mouth is a line of one pressure, C_i. Along it the stream has one speed, v_i = √(1 − C_i) of the
//! free stream's. Where the closed section has the speed v(s) along the mouth, that line leaves the upstream lip smoothly and comes back to the other one. For small
//! disturbances of the speed this is the equation of a thin aerofoil turned around: with t from −1 at the upstream lip to 1,
//!
//! ```text
//! v_i = 1/π ∫ v(t) √((1 − t)/(1 + t)) dt        C_i = 1 − v_i²
//! ```
//!
//! For a speed that grows evenly it is that at a quarter of the mouth behind the upstream lip: less than the mean. The lip that is nearer to the point where the
//! stream divides is the upstream one. Where it divides within the mouth, either may be: then what lies between that lip and the dividing point counts with the
//! speed at that point, and the lower of both pressures is taken. It goes on without a jump where the dividing point leaves the mouth.
//! docs/results/2026-11-27-pressure-inside-ram-air-wings.md has it beside the lattice.

use std::f64::consts::PI;

/// Points of the quadrature.
const POINTS: usize = 64;

/// Coefficient of the pressure inside, by points (place along the mouth, growing from lip to lip, and the coefficient before it), and by the place where the stream
/// divides, which may lie beyond either lip. Stagnation, 1, without two points.
#[must_use]
pub fn pressure_inside(before: &[[f64; 2]], divides: f64) -> f64 {
    let [first, .., last] = before else {
        return 1.0;
    };
    let leaving_first = || leaving_first_lip(before, divides);
    let leaving_last = || {
        let backward: Vec<[f64; 2]> = before.iter().rev().map(|[s, c]| [-s, *c]).collect();
        leaving_first_lip(&backward, -divides)
    };
    if divides <= first[0] {
        leaving_first()
    } else if divides >= last[0] {
        leaving_last()
    } else {
        leaving_first().min(leaving_last())
    }
}

/// Speed over that of the free stream where the pressure has a coefficient.
fn speed(coefficient: f64) -> f64 {
    (1.0 - coefficient).max(0.0).sqrt()
}

/// The same where the first lip is the upstream one.
fn leaving_first_lip(before: &[[f64; 2]], divides: f64) -> f64 {
    let [[first, _], .., [last, _]] = before else {
        return 1.0;
    };
    // With t = −cos θ the weight is (1 + cos θ) dθ.
    let sum = |i: usize| {
        let cos = (PI * (i as f64 + 0.5) / POINTS as f64).cos();
        let place = first + 0.5 * (1.0 - cos) * (last - first);
        speed(at(before, place.max(divides.min(*last)))) * (1.0 + cos)
    };
    let inside = (0..POINTS).map(sum).sum::<f64>() / POINTS as f64;
    1.0 - inside * inside
}

/// Coefficient at a place, on straight lines between the points.
fn at(before: &[[f64; 2]], place: f64) -> f64 {
    let next = before.partition_point(|point| point[0] <= place);
    let next = next.clamp(1, before.len() - 1);
    let [a, b] = [before[next - 1], before[next]];
    a[1] + (b[1] - a[1]) * (place - a[0]) / (b[0] - a[0])
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
        assert!((pressure_inside(&mouth(|_| 0.7), 4.0) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn a_growing_speed_counts_at_a_quarter_of_the_mouth() {
        let of = |speed: fn(f64) -> f64, divides| {
            pressure_inside(&mouth(|s| 1.0 - speed(s) * speed(s)), divides)
        };
        let growing = of(|s| 0.2 + 0.4 * s, 1.0);
        assert!((growing - (1.0 - 0.09)).abs() < 1e-4, "{growing}");
        let falling = of(|s| 0.6 - 0.4 * s, 6.0);
        assert!((falling - (1.0 - 0.09)).abs() < 1e-4, "{falling}");
    }

    /// The line of one speed comes back to the other lip: its slope, by the equation that it follows, sums up to nothing.
    #[test]
    fn the_line_across_the_mouth_closes() {
        let outside = |s: f64| 0.1 + 0.9 * s + 0.2 * s * s;
        let inside = leaving_first_lip(&mouth(|s| 1.0 - outside(s) * outside(s)), 3.0);
        // Slope η' = −√((1 + t)/(1 − t))/π ⨍ √((1 − τ)/(1 + τ)) g(τ)/(t − τ) dτ with g = v − v_i, by Chebyshev points of both kinds.
        let n = 400;
        let g = |t: f64| outside(0.5 * (1.0 + t)) - (1.0 - inside).sqrt();
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
        assert!(rise.abs() < 2e-3, "{rise}");
    }

    /// As the dividing point crosses a mouth the pressure inside rises nearly to that of stagnation and falls again, without a jump.
    #[test]
    fn it_follows_the_dividing_point() {
        let at = |divides: f64| {
            let before = mouth(|s| 1.0 - 1.5 * (s - divides) * (s - divides));
            pressure_inside(&before, 3.0 + 2.0 * divides)
        };
        let values: Vec<f64> = (-20..=120).map(|i| at(0.01 * f64::from(i))).collect();
        for pair in values.windows(2) {
            assert!((pair[1] - pair[0]).abs() < 0.03, "{pair:?}");
        }
        let middle = values[70];
        assert!(middle > 0.95 && middle < 1.0, "{middle}");
        // At either lip 1 − 1.5 s² counts at a quarter of the mouth.
        for lip in [values[20], values[120]] {
            assert!((lip - (1.0 - 1.5 / 16.0)).abs() < 1e-3, "{lip}");
        }
    }

    /// Which lip is the upstream one does not depend on the pressure before the mouth: with a suction peak in it, lips that swap ranks change nothing.
    #[test]
    fn a_suction_peak_does_not_turn_the_stream() {
        let of = |first: f64| {
            let before = mouth(|s| {
                if s < 0.3 {
                    first - (first + 0.5) * s / 0.3
                } else {
                    s - 0.8
                }
            });
            pressure_inside(&before, 2.0)
        };
        let [lower, higher] = [of(0.19), of(0.21)];
        assert!(higher > lower && higher - lower < 0.01, "{lower} {higher}");
    }
}
