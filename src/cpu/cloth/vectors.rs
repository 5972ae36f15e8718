//! Vector operations of the minimiser on the host: parallel, with sums over chunks of fixed size, so that results do not depend on the
//! number of threads.

use glam::DVec3;
use rayon::prelude::*;

use super::nodal_forces::CHUNK;

/// Sum over chunks of `count` items.
pub(super) fn chunked_sum<const K: usize>(
    count: usize,
    of: impl Fn(std::ops::Range<usize>) -> [f64; K] + Sync,
) -> [f64; K] {
    let parts: Vec<[f64; K]> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| of(chunk * CHUNK..((chunk + 1) * CHUNK).min(count)))
        .collect();
    let mut sums = [0.0; K];
    for part in parts {
        for k in 0..K {
            sums[k] += part[k];
        }
    }
    sums
}

pub(super) fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    let [sum] = chunked_sum(a.len(), |range| {
        let terms = a[range.clone()].iter().zip(&b[range]);
        [terms.map(|(a, b)| a.dot(*b)).sum()]
    });
    sum
}

/// Dot products of two vectors with a third, in one pass.
pub(super) fn dot_both(a: &[DVec3], b: &[DVec3], with: &[DVec3]) -> [f64; 2] {
    chunked_sum(a.len(), |range| {
        let mut sums = [0.0; 2];
        for i in range {
            sums[0] += a[i].dot(with[i]);
            sums[1] += b[i].dot(with[i]);
        }
        sums
    })
}

/// Longest displacement [m]; NaN if an element is not finite.
pub(super) fn longest_m(step: &[DVec3]) -> f64 {
    step.par_chunks(CHUNK)
        .map(|chunk| {
            let mut longest: f64 = 0.0;
            for v in chunk {
                if !v.is_finite() {
                    return f64::NAN;
                }
                longest = longest.max(v.length_squared());
            }
            longest.sqrt()
        })
        .reduce(
            || 0.0,
            // f64::max would lose NaN.
            |a, b| {
                if a.is_nan() || b.is_nan() {
                    f64::NAN
                } else {
                    a.max(b)
                }
            },
        )
}

/// `result[i] = of(i)`.
pub(super) fn fill(result: &mut [DVec3], of: impl Fn(usize) -> DVec3 + Sync) {
    result
        .par_iter_mut()
        .with_min_len(CHUNK)
        .enumerate()
        .for_each(|(i, r)| *r = of(i));
}
