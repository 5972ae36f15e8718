//! Peskin's 4-point kernel (Peskin 2002, Acta Numerica 11, eq. 6.27).
//!
//! φ(r) = (3 − 2|r| + √(1 + 4|r| − 4r²))/8 for |r| ≤ 1, (5 − 2|r| − √(−7 + 12|r| − 4r²))/8 for 1 ≤ |r| ≤ 2.
//! *Paper P0 prints a plus before the second root*: with it the weights do not sum to one.

/// Σ φ² over a lattice line, the same for every offset.
pub const SUM_OF_SQUARES: f64 = 3.0 / 8.0;

/// Cells per axis under the kernel.
pub const WIDTH: usize = 4;

/// First cell under the kernel of a marker at `position` (cell centres at whole numbers), and the four weights.
#[must_use]
pub fn weights(position: f64) -> (i64, [f64; WIDTH]) {
    let floor = position.floor();
    let r = position - floor;
    // Cells floor − 1, floor, floor + 1, floor + 2 at distances 1 + r, r, 1 − r, 2 − r.
    let near = (1.0 + 4.0 * r - 4.0 * r * r).sqrt();
    let q = 1.0 - r;
    (
        floor as i64 - 1,
        [
            (3.0 - 2.0 * r - near) / 8.0,
            (3.0 - 2.0 * r + near) / 8.0,
            (3.0 - 2.0 * q + near) / 8.0,
            (3.0 - 2.0 * q - near) / 8.0,
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phi(r: f64) -> f64 {
        let r = r.abs();
        if r <= 1.0 {
            (3.0 - 2.0 * r + (1.0 + 4.0 * r - 4.0 * r * r).sqrt()) / 8.0
        } else if r <= 2.0 {
            (5.0 - 2.0 * r - (-7.0 + 12.0 * r - 4.0 * r * r).max(0.0).sqrt()) / 8.0
        } else {
            0.0
        }
    }

    /// Moments that define the kernel: Σφ = 1, Σ(x − i)φ = 0, even and odd halves equal, Σφ² = 3/8.
    #[test]
    fn moments_hold_for_every_offset() {
        for k in 0..1000 {
            let x = 7.0 + f64::from(k) * 1e-3;
            let (first, w) = weights(x);
            let sum: f64 = w.iter().sum();
            let moment: f64 = (0..WIDTH)
                .map(|i| w[i] * (x - (first + i as i64) as f64))
                .sum();
            let squares: f64 = w.iter().map(|w| w * w).sum();
            assert!((sum - 1.0).abs() < 1e-14);
            assert!(moment.abs() < 1e-13);
            assert!((w[0] + w[2] - 0.5).abs() < 1e-14);
            assert!((squares - SUM_OF_SQUARES).abs() < 1e-14);
            for i in 0..WIDTH {
                assert!((w[i] - phi(x - (first + i as i64) as f64)).abs() < 1e-13);
            }
        }
    }
}
