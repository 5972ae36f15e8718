//! Populations to 16 bits and back, by the CPU's own instructions (F16C, AVX-512).
//!
//! A sweep converts 38 numbers per cell. The slices of the crate `half` take some 15 ns for these (19 arrays of 128 cells, one thread of an AMD EPYC with AVX2),
//! twice what the whole sweep in single precision does. With vectors that convert on their way from and to memory, a sweep takes 0 to 2 ns more than in single
//! precision. That is why this one module may use `unsafe`: neither `half` nor `pulp` has these conversions for vectors.

#![allow(
    unsafe_code,
    reason = "no safe function converts vectors of 16 bits; 2 ns per cell at most in place of 15"
)]

use half::f16;
use pulp::{Arch, Simd, WithSimd};

use crate::lattice::F16_SCALE;

/// Most lanes that a vector of single precision has.
const MOST_LANES: usize = 16;

/// Fewer numbers are converted one by one.
const SHORT: usize = 8;

/// True if the CPU converts whole vectors of eight.
fn has_f16c() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("f16c") && is_x86_feature_detected!("avx");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Runs `work` with vector instructions of this CPU, those that convert included. Vectors of eight without such are left alone.
pub(super) fn dispatch<W: WithSimd>(instructions: Arch, work: W) -> W::Output {
    match instructions {
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) if has_f16c() => {
            // SAFETY: the CPU has what V3 stands for, and F16C.
            unsafe { with_f16c(simd, work) }
        }
        #[cfg(target_arch = "x86_64")]
        Arch::V3(_) => Arch::Scalar.dispatch(work),
        _ => instructions.dispatch(work),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "sse,sse2,fxsr,sse3,ssse3,sse4.1,sse4.2,popcnt,avx,avx2,bmi1,bmi2,fma,lzcnt,f16c"
)]
fn with_f16c<W: WithSimd>(simd: pulp::x86::V3, work: W) -> W::Output {
    work.with_simd(simd)
}

/// Takes a whole vector.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, kept: &[f16]) -> S::f32s {
    let scale = simd.splat_f32s(1.0 / F16_SCALE);
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_mm256_cvtph_ps, _mm512_cvtph_ps};
        if let (8, Some(kept)) = (S::F32_LANES, kept.first_chunk::<8>()) {
            // SAFETY: `dispatch` takes vectors of eight where the CPU has F16C.
            let values = unsafe { _mm256_cvtph_ps(bytemuck::cast(*kept)) };
            return simd.mul_f32s(bytemuck::cast(values), scale);
        }
        if let (16, Some(kept)) = (S::F32_LANES, kept.first_chunk::<16>()) {
            // SAFETY: a CPU with vectors of sixteen has AVX-512.
            let values = unsafe { _mm512_cvtph_ps(bytemuck::cast(*kept)) };
            return simd.mul_f32s(bytemuck::cast(values), scale);
        }
    }
    let mut values = [0.0; MOST_LANES];
    for (value, kept) in values.iter_mut().zip(kept) {
        *value = kept.to_f32();
    }
    simd.mul_f32s(simd.partial_load_f32s(&values[..S::F32_LANES]), scale)
}

/// Keeps a whole vector.
#[inline(always)]
pub(super) fn store<S: Simd>(simd: S, vector: S::f32s, into: &mut [f16]) {
    let scaled = simd.mul_f32s(vector, simd.splat_f32s(F16_SCALE));
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_FROUND_TO_NEAREST_INT, _mm256_cvtps_ph, _mm512_cvtps_ph};
        if let (8, Some(into)) = (S::F32_LANES, into.first_chunk_mut::<8>()) {
            // SAFETY: `dispatch` takes vectors of eight where the CPU has F16C.
            let kept =
                unsafe { _mm256_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(bytemuck::cast(scaled)) };
            *into = bytemuck::cast(kept);
            return;
        }
        if let (16, Some(into)) = (S::F32_LANES, into.first_chunk_mut::<16>()) {
            // SAFETY: a CPU with vectors of sixteen has AVX-512.
            let kept =
                unsafe { _mm512_cvtps_ph::<_MM_FROUND_TO_NEAREST_INT>(bytemuck::cast(scaled)) };
            *into = bytemuck::cast(kept);
            return;
        }
    }
    let mut values = [0.0; MOST_LANES];
    simd.partial_store_f32s(&mut values[..S::F32_LANES], scaled);
    for (kept, value) in into.iter_mut().zip(values) {
        *kept = f16::from_f32(value);
    }
}

/// Keeps a number.
#[inline(always)]
pub(super) fn packed(value: f32) -> f16 {
    f16::from_f32(value * F16_SCALE)
}

/// Takes a number.
#[inline(always)]
pub(super) fn unpacked(kept: f16) -> f32 {
    kept.to_f32() * (1.0 / F16_SCALE)
}

/// Keeps `values`, as many as there are places.
pub(super) fn pack(values: &[f32], into: &mut [f16]) {
    if values.len() < SHORT {
        return pack_one_by_one(values, into);
    }
    dispatch(Arch::new(), Pack { values, into });
}

/// Takes all of `kept`, as many as there are places.
pub(super) fn unpack(kept: &[f16], into: &mut [f32]) {
    if kept.len() < SHORT {
        return unpack_one_by_one(kept, into);
    }
    dispatch(Arch::new(), Unpack { kept, into });
}

fn pack_one_by_one(values: &[f32], into: &mut [f16]) {
    for (value, kept) in values.iter().zip(into) {
        *kept = packed(*value);
    }
}

fn unpack_one_by_one(kept: &[f16], into: &mut [f32]) {
    for (value, kept) in into.iter_mut().zip(kept) {
        *value = unpacked(*kept);
    }
}

struct Pack<'a> {
    values: &'a [f32],
    into: &'a mut [f16],
}

impl WithSimd for Pack<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (vectors, rest) = S::as_simd_f32s(self.values);
        let (whole, last) = self.into.split_at_mut(vectors.len() * S::F32_LANES);
        for (vector, into) in vectors.iter().zip(whole.chunks_exact_mut(S::F32_LANES)) {
            store(simd, *vector, into);
        }
        pack_one_by_one(rest, last);
    }
}

struct Unpack<'a> {
    kept: &'a [f16],
    into: &'a mut [f32],
}

impl WithSimd for Unpack<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (vectors, rest) = S::as_mut_simd_f32s(self.into);
        let (whole, last) = self.kept.split_at(vectors.len() * S::F32_LANES);
        for (vector, kept) in vectors.iter_mut().zip(whole.chunks_exact(S::F32_LANES)) {
            *vector = load(simd, kept);
        }
        unpack_one_by_one(last, rest);
    }
}
