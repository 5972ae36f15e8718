//! Upwash that the walls of a rectangular tunnel give a lifting line: that of its mirror images, which fill the plane across the wind.
//!
//! Side walls mirror a wing with its lift, floor and ceiling turn the lift of its image over. Half of what their trailing vortices do far
//! downstream acts at the wing (Garner et al. 1966, AGARDograph 109). Images in a row along the span sum up to a closed form; rows decay by
//! e^(−π height/width) each, and are added until nothing comes any more. The tunnel is taken as long before and behind the wing.

use std::f64::consts::PI;

/// A straight lifting line along the width of a tunnel, of elliptic loading.
#[derive(Debug, Clone, Copy)]
pub(super) struct LiftingLine {
    /// Width and height of the section [m].
    pub section_m: [f64; 2],
    /// Span of the line [m].
    pub span_m: f64,
    /// Its middle from that of the section, along the width and the height [m].
    pub middle_m: [f64; 2],
}

/// Points along the span. From span 0 to 0.8 of the width twice as many change nothing in the sixth digit.
const POINTS: u32 = 16;

/// Rows of images are as good as nothing from this depth on, the exponent of their decay.
const DEEP: f64 = 40.0;

impl LiftingLine {
    /// Factor δ of the walls: Δα = δ S C_L/(width × height) [rad], mean over the loading.
    pub fn interference(&self) -> f64 {
        let [width_m, height_m] = self.section_m;
        // Gauss–Chebyshev quadrature over an ellipse of area 1.
        let points: Vec<(f64, f64)> = (1..=POINTS)
            .map(|k| {
                let angle = PI * f64::from(k) / f64::from(POINTS + 1);
                let across_m = self.middle_m[0] + 0.5 * self.span_m * angle.cos();
                (across_m, 2.0 / f64::from(POINTS + 1) * angle.sin().powi(2))
            })
            .collect();
        let mean: f64 = points
            .iter()
            .flat_map(|(at, weight)| {
                let of = points.iter();
                of.map(move |(of, part)| weight * part * self.images_1_m2(*at, *of))
            })
            .sum();
        width_m * height_m / (8.0 * PI) * mean
    }

    /// Sum of ± Re 1/(y + i z)² over all images of a small part of the line at `of_m`, with y and z from each of them to a place at `at_m`
    /// on the line [1/m²].
    fn images_1_m2(&self, at_m: f64, of_m: f64) -> f64 {
        let [width_m, height_m] = self.section_m;
        let scale = 0.5 * PI / width_m;
        let rows = (DEEP * width_m / (PI * height_m)).ceil() as i32 + 1;
        let row = |n: i32| {
            // Every second row is upside down.
            let (sign, from_m) = match n.rem_euclid(2) {
                0 => (1.0, 0.0),
                _ => (-1.0, 2.0 * self.middle_m[1]),
            };
            let up = scale * (from_m - f64::from(n) * height_m);
            let alike = scale * (at_m - of_m);
            let mirrored = scale * (at_m + of_m - width_m);
            let alike = if n == 0 {
                row_without_itself(alike)
            } else {
                whole_row(alike, up)
            };
            sign * (alike + whole_row(mirrored, up))
        };
        scale * scale * (-rows..=rows).map(row).sum::<f64>()
    }
}

/// Σ Re 1/(x + i z + k π)² over all whole k, which is Re 1/sin²(x + i z).
fn whole_row(x: f64, z: f64) -> f64 {
    if z.abs() > DEEP {
        return 0.0;
    }
    let (flat, high) = ((2.0 * x).cos(), (2.0 * z).cosh());
    2.0 * (1.0 - flat * high) / (high - flat).powi(2)
}

/// The same at z = 0 without k = 0.
fn row_without_itself(x: f64) -> f64 {
    // Where the two nearly cancel, their series.
    if x.abs() < 1e-2 {
        1.0 / 3.0 + x * x / 15.0
    } else {
        x.sin().powi(-2) - x.powi(-2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interference(ratio: f64, span_m: f64) -> f64 {
        LiftingLine {
            section_m: [ratio, 1.0],
            span_m,
            middle_m: [0.0; 2],
        }
        .interference()
    }

    /// Small wings, AGARDograph 109: 0.137 in a square and a duplex tunnel, least at a ratio of √2, and there 0.119.
    #[test]
    fn small_wings_have_the_published_factors() {
        for (ratio, factor) in [(1.0, 0.137), (2f64.sqrt(), 0.119), (2.0, 0.137)] {
            let found = interference(ratio, 1e-3);
            assert!((found - factor).abs() < 5e-4, "{ratio}: {found}");
        }
        let least = interference(2f64.sqrt(), 1e-3);
        assert!(interference(1.3, 1e-3) > least && interference(1.5, 1e-3) > least);
    }

    /// A small wing feels the same in two tunnels whose ratios of width to height have the product 2.
    #[test]
    fn two_tunnels_are_alike() {
        for ratio in [0.25, 0.5, 1.0, 1.2] {
            let [one, other] = [ratio, 2.0 / ratio].map(|ratio| interference(ratio, 1e-6));
            assert!((one / other - 1.0).abs() < 1e-9, "{ratio}: {one}, {other}");
        }
    }

    /// Against the images one by one, out of the middle.
    #[test]
    fn rows_sum_up_to_their_images() {
        let line = LiftingLine {
            section_m: [1.3, 1.0],
            span_m: 0.5,
            middle_m: [0.0, 0.15],
        };
        let (at_m, of_m) = (0.2, -0.1);
        let mut sum = 0.0;
        for n in -9..=9_i32 {
            for m in -4000..=4000_i32 {
                if (m, n) == (0, 0) {
                    continue;
                }
                let [odd_m, odd_n] = [m, n].map(|k| k.rem_euclid(2) == 1);
                let y = at_m - 1.3 * f64::from(m) - if odd_m { -of_m } else { of_m };
                let z = if odd_n { 0.3 } else { 0.0 } - f64::from(n);
                let sign = if odd_n { -1.0 } else { 1.0 };
                sum += sign * (y * y - z * z) / (y * y + z * z).powi(2);
            }
        }
        let found = line.images_1_m2(at_m, of_m);
        assert!((found / sum - 1.0).abs() < 1e-3, "{found}, {sum}");
    }

    /// A wide wing lies nearer to the images beside it, and has more upwash than a small one in a square tunnel. In a duplex one, near to floor
    /// and ceiling over its whole span, it has less.
    #[test]
    fn the_span_counts() {
        assert!(interference(1.0, 0.8) > 1.15 * interference(1.0, 1e-3));
        assert!(interference(2.0, 1.6) < 0.7 * interference(2.0, 1e-3));
    }
}
