//! Vector operations of the minimiser on the host: parallel, with sums over chunks of fixed size, so that results do not depend on the
//! number of threads.
//!
//! Vectors are in single precision, like those of a device: they hold gradients and displacements, which only have to be right relative
//! to their own size, and what is summed of them is summed in double precision. Positions, energies and the forces that a gradient is
//! added up from are in double precision.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Elements or nodes that one task works on; part of the result, since sums are rounded chunk by chunk.
pub(super) const CHUNK: usize = 256;

/// Up to so many items one thread is faster. The limit is low, and one for all loops here: threads stay awake between loops that follow each other, while a
/// long loop by a single thread sends the others to sleep, and waking them takes longer than many a loop.
pub(super) const ALONE: usize = 4 * CHUNK;

/// What `of` finds for every chunk of `count` items, in order.
fn of_chunks<R: Send>(count: usize, of: impl Fn(Range<usize>) -> R + Sync) -> Vec<R> {
    let range = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
    let chunks = 0..count.div_ceil(CHUNK);
    if count <= ALONE {
        chunks.map(|chunk| of(range(chunk))).collect()
    } else {
        chunks
            .into_par_iter()
            .map(|chunk| of(range(chunk)))
            .collect()
    }
}

/// Does `of` to every item, given its number.
pub(super) fn each<T: Send>(items: &mut [T], of: impl Fn(usize, &mut T) + Sync) {
    if items.len() <= ALONE {
        for (i, item) in items.iter_mut().enumerate() {
            of(i, item);
        }
    } else {
        items
            .par_iter_mut()
            .with_min_len(CHUNK)
            .enumerate()
            .for_each(|(i, item)| of(i, item));
    }
}

/// Does `of` to every item, given its number, and returns the sum over chunks of what it returns.
pub(super) fn each_summed<T: Send>(
    items: &mut [T],
    of: impl Fn(usize, &mut T) -> f64 + Sync,
) -> f64 {
    let one = |(chunk, items): (usize, &mut [T])| -> f64 {
        let first = chunk * CHUNK;
        (items.iter_mut().enumerate())
            .map(|(k, item)| of(first + k, item))
            .sum()
    };
    let sums: Vec<f64> = if items.len() <= ALONE {
        items.chunks_mut(CHUNK).enumerate().map(one).collect()
    } else {
        items.par_chunks_mut(CHUNK).enumerate().map(one).collect()
    };
    sums.iter().sum()
}

/// Sum over chunks of `count` items.
pub(super) fn chunked_sum<const K: usize>(
    count: usize,
    of: impl Fn(Range<usize>) -> [f64; K] + Sync,
) -> [f64; K] {
    let mut sums = [0.0; K];
    for part in of_chunks(count, of) {
        for k in 0..K {
            sums[k] += part[k];
        }
    }
    sums
}

/// Numbers that are summed side by side.
const LANES: usize = 8;

/// Does `of` with the widest vectors that the processor has; what it calls has to be inlined. Products and sums are not fused: the same bits everywhere.
fn in_lanes<R>(of: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(of)
}

/// Dot products of short vectors with another, in double precision.
#[inline(always)]
fn short_dots<const K: usize>(vectors: [&[Vec3]; K], with: &[Vec3]) -> [f64; K] {
    let with: &[f32] = bytemuck::cast_slice(with);
    let vectors: [&[f32]; K] = vectors.map(|v| &bytemuck::cast_slice(v)[..with.len()]);
    let whole = with.len() / LANES * LANES;
    let mut sums = [[0.0; LANES]; K];
    for first in (0..whole).step_by(LANES) {
        let lanes = |v: &[f32]| -> [f64; LANES] {
            let v = &v[first..first + LANES];
            std::array::from_fn(|k| f64::from(v[k]))
        };
        let b = lanes(with);
        for (sums, vector) in sums.iter_mut().zip(vectors) {
            let a = lanes(vector);
            for k in 0..LANES {
                sums[k] += a[k] * b[k];
            }
        }
    }
    std::array::from_fn(|of| {
        let pairs = vectors[of][whole..].iter().zip(&with[whole..]);
        let rest: f64 = pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
        sums[of].iter().sum::<f64>() + rest
    })
}

#[inline(always)]
fn short_dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    let [dot] = short_dots([a], b);
    dot
}

pub(super) fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    let of = |range: Range<usize>| {
        in_lanes(
            #[inline(always)]
            || short_dot(&a[range.clone()], &b[range]),
        )
    };
    let [sum] = chunked_sum(a.len(), |range| [of(range)]);
    sum
}

/// Longest of some vectors; NaN if an element is not finite.
fn longest(vectors: &[Vec3]) -> f64 {
    let mut longest: f32 = 0.0;
    for v in vectors {
        if !v.is_finite() {
            return f64::NAN;
        }
        longest = longest.max(v.abs().max_element());
    }
    if longest == 0.0 {
        return 0.0;
    }
    // Squares of small numbers would vanish in single precision.
    let mut square: f64 = 0.0;
    for v in vectors {
        square = square.max(v.as_dvec3().length_squared());
    }
    square.sqrt()
}

/// The larger; NaN if one is. f64::max would lose NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.max(b)
    }
}

/// Longest displacement [m]; NaN if an element is not finite.
pub(super) fn longest_m(step: &[Vec3]) -> f64 {
    let parts = of_chunks(step.len(), |range| longest(&step[range]));
    parts.into_iter().fold(0.0, larger)
}

/// What a trial tells, all in one pass; y = g⁺ − g.
pub(super) struct Products {
    /// g⁺ · d
    pub slope: f64,
    /// y · d
    pub slope_change: f64,
    /// g⁺ · H₀ g⁺
    pub norm_square: f64,
    /// g⁺ · H₀ y
    pub gradient_change: f64,
    /// y · H₀ y
    pub change_square: f64,
    /// Longest of H₀ g⁺ [m]; NaN if an element is not finite.
    pub longest_m: f64,
    /// (g⁺ · v, y · v) of every stored vector v.
    pub stored: Vec<[f64; 2]>,
}

/// `gradients` and `preconditioned` are those of the trial (g⁺, H₀ g⁺) and of where it started (g, H₀ g).
pub(super) fn products(
    gradients: [&[Vec3]; 2],
    preconditioned: [&[Vec3]; 2],
    direction: &[Vec3],
    stored: &[&[Vec3]],
) -> Products {
    const OWN: usize = 6;
    let count = direction.len();
    let parts: Vec<Vec<f64>> = of_chunks(count, |range| {
        let difference = |a: &[Vec3], b: &[Vec3]| -> Vec<Vec3> {
            a.iter().zip(b).map(|(a, b)| *a - *b).collect()
        };
        let [new, old] = gradients.map(|v| &v[range.clone()]);
        let [new_z, old_z] = preconditioned.map(|v| &v[range.clone()]);
        let change = difference(new, old);
        let preconditioned_change = difference(new_z, old_z);
        let along = &direction[range.clone()];
        let mut sums = Vec::with_capacity(OWN + 2 * stored.len());
        in_lanes(
            #[inline(always)]
            || {
                let [slope, slope_change] = short_dots([new, &change], along);
                sums.extend([
                    slope,
                    slope_change,
                    short_dot(new, new_z),
                    short_dot(new, &preconditioned_change),
                    short_dot(&change, &preconditioned_change),
                ]);
            },
        );
        sums.push(longest(new_z));
        in_lanes(
            #[inline(always)]
            || {
                for vector in stored {
                    sums.extend(short_dots([new, &change], &vector[range.clone()]));
                }
            },
        );
        sums
    });
    let mut sums = vec![0.0; OWN + 2 * stored.len()];
    for part in &parts {
        for (k, (sum, value)) in sums.iter_mut().zip(part).enumerate() {
            *sum = if k == OWN - 1 {
                larger(*sum, *value)
            } else {
                *sum + value
            };
        }
    }
    Products {
        slope: sums[0],
        slope_change: sums[1],
        norm_square: sums[2],
        gradient_change: sums[3],
        change_square: sums[4],
        longest_m: sums[5],
        stored: sums[OWN..].chunks_exact(2).map(|s| [s[0], s[1]]).collect(),
    }
}

/// Numbers that one task combines.
const NUMBERS: usize = 3 * CHUNK;

/// `result = Σ coefficient · vector`.
pub(super) fn combine(result: &mut [Vec3], terms: &[(f64, &[Vec3])]) {
    let result: &mut [f32] = bytemuck::cast_slice_mut(result);
    let alone = result.len() <= 3 * ALONE;
    let one = |(chunk, result): (usize, &mut [f32])| {
        let range = chunk * NUMBERS..chunk * NUMBERS + result.len();
        let mut sums = [0.0f64; NUMBERS];
        in_lanes(
            #[inline(always)]
            || {
                for (coefficient, vector) in terms {
                    let vector: &[f32] = bytemuck::cast_slice(vector);
                    for (sum, v) in sums.iter_mut().zip(&vector[range.clone()]) {
                        *sum += coefficient * f64::from(*v);
                    }
                }
                for (r, sum) in result.iter_mut().zip(&sums) {
                    *r = *sum as f32;
                }
            },
        );
    };
    if alone {
        result.chunks_mut(NUMBERS).enumerate().for_each(one);
    } else {
        result.par_chunks_mut(NUMBERS).enumerate().for_each(one);
    }
}

/// `result[i] = of(i)`.
pub(super) fn fill<V: Send>(result: &mut [V], of: impl Fn(usize) -> V + Sync) {
    each(result, |i, r| *r = of(i));
}

/// In single precision.
pub(super) fn single(vector: &[DVec3]) -> Vec<Vec3> {
    vector.iter().map(|v| v.as_vec3()).collect()
}

/// In double precision.
pub(super) fn double(vector: &[Vec3]) -> Vec<DVec3> {
    vector.iter().map(|v| v.as_dvec3()).collect()
}
