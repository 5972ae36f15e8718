//! Runs of populations to 16 bits and back, by the CPU's own instructions (F16C).
//!
//! The slices of the crate `half` call a function for eight numbers at a time: MEASURED. That is why this one module may use `unsafe`:
//! a function compiled for an instruction that the CPU is asked for is called by no safe way.

#![allow(
    unsafe_code,
    reason = "no safe call of a function that is compiled for F16C; sweeps gain MEASURED"
)]

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::lattice::F16_SCALE;

/// Packs `values`, as many as there are places.
#[inline(always)]
pub(super) fn pack(values: &[f32], into: &mut [f16]) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("f16c") && is_x86_feature_detected!("avx") {
        // SAFETY: the CPU has both sets of instructions.
        return unsafe { f16c::pack(values, into) };
    }
    let scaled: Vec<f32> = values.iter().map(|value| value * F16_SCALE).collect();
    into.convert_from_f32_slice(&scaled);
}

/// Unpacks all of `kept`, as many as there are places.
#[inline(always)]
pub(super) fn unpack(kept: &[f16], into: &mut [f32]) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("f16c") && is_x86_feature_detected!("avx") {
        // SAFETY: the CPU has both sets of instructions.
        return unsafe { f16c::unpack(kept, into) };
    }
    kept.convert_to_f32_slice(into);
    for value in into {
        *value *= 1.0 / F16_SCALE;
    }
}

#[cfg(target_arch = "x86_64")]
mod f16c {
    use std::arch::x86_64::{
        __m128i, __m256, _MM_FROUND_TO_NEAREST_INT, _mm256_cvtph_ps, _mm256_cvtps_ph,
        _mm256_mul_ps, _mm256_set1_ps,
    };

    use half::f16;

    use super::super::stored::Stored;
    use crate::lattice::F16_SCALE;

    /// Numbers of a vector.
    const LANES: usize = 8;

    #[target_feature(enable = "avx,f16c")]
    pub(super) fn pack(values: &[f32], into: &mut [f16]) {
        let scale = _mm256_set1_ps(F16_SCALE);
        let (values, rest) = values.as_chunks::<LANES>();
        let (places, last) = into.as_chunks_mut::<LANES>();
        for (value, place) in values.iter().zip(places) {
            let scaled = _mm256_mul_ps(bytemuck::cast::<_, __m256>(*value), scale);
            *place = bytemuck::cast(_mm256_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(scaled));
        }
        for (value, place) in rest.iter().zip(last) {
            *place = f16::packed(*value);
        }
    }

    #[target_feature(enable = "avx,f16c")]
    pub(super) fn unpack(kept: &[f16], into: &mut [f32]) {
        let scale = _mm256_set1_ps(1.0 / F16_SCALE);
        let (kept, rest) = kept.as_chunks::<LANES>();
        let (places, last) = into.as_chunks_mut::<LANES>();
        for (kept, place) in kept.iter().zip(places) {
            let values = _mm256_cvtph_ps(bytemuck::cast::<_, __m128i>(*kept));
            *place = bytemuck::cast(_mm256_mul_ps(values, scale));
        }
        for (kept, place) in rest.iter().zip(last) {
            *place = kept.unpacked();
        }
    }
}
