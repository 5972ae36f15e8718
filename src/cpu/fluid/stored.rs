//! How a population lies in memory: as the number that it is, or in 16 bits.
//!
//! In 16 bits it is scaled by 2^15. So the numbers near zero that shifted populations are keep their 11 bits down to 1.9e-9, and the largest is 2 (Lehmann et al.
//! 2022, doi:10.1103/PhysRevE.106.015308, format FP16S). Arithmetic stays in single precision. Devices keep them in the same format (`storage_f16.wgsl`).

use std::fmt::Debug;

use half::f16;
use pulp::{Arch, Simd, WithSimd};

use super::sixteen_bits;
use crate::lattice::Real;
use crate::lattice::grid::LINE_BYTES;

/// Vectors of populations, for what [`Vectors::dispatch`] runs.
pub(super) trait Vectors: Sized {
    /// What they are computed in.
    type Number: Real;

    /// Runs `work` with vector instructions of this CPU.
    fn dispatch<W: WithSimd>(instructions: Arch, work: W) -> W::Output {
        instructions.dispatch(work)
    }

    /// Takes a whole vector.
    fn load<S: Simd>(simd: S, kept: &[Self]) -> <Self::Number as Real>::Vector<S>;

    /// Keeps a whole vector.
    fn store<S: Simd>(simd: S, vector: <Self::Number as Real>::Vector<S>, into: &mut [Self]);

    /// Keeps the first lanes, fewer than a vector has.
    fn store_part<S: Simd>(simd: S, vector: <Self::Number as Real>::Vector<S>, into: &mut [Self]);
}

/// A population in memory.
#[allow(private_bounds, reason = "vectors of 16 bits are for sweeps alone")]
pub trait Stored:
    Copy + Debug + Default + PartialEq + Send + Sync + bytemuck::Pod + Vectors<Number = Self::Real>
{
    /// What it is computed in.
    type Real: Real;

    /// The nearest that can be kept.
    fn packed(value: Self::Real) -> Self;

    /// Its value.
    fn unpacked(self) -> Self::Real;

    /// Keeps all `values`, as many as there are places.
    fn pack(values: &[Self::Real], into: &mut [Self]);

    /// Takes all values, as many as there are places.
    fn unpack(kept: &[Self], into: &mut [Self::Real]);

    /// Room for the values of `length` populations; none where they need not be unpacked.
    fn room(length: usize) -> Vec<Self::Real>;

    /// Values of all, which lie in `room` where they must be unpacked.
    fn values<'a>(kept: &'a [Self], room: &'a mut [Self::Real]) -> &'a [Self::Real];
}

macro_rules! as_it_is {
    ($type:ty) => {
        impl Vectors for $type {
            type Number = Self;

            #[inline(always)]
            fn load<S: Simd>(_: S, kept: &[Self]) -> <Self as Real>::Vector<S> {
                Self::vectors::<S>(kept).0[0]
            }

            #[inline(always)]
            fn store<S: Simd>(_: S, vector: <Self as Real>::Vector<S>, into: &mut [Self]) {
                Self::vectors_mut::<S>(into).0[0] = vector;
            }

            #[inline(always)]
            fn store_part<S: Simd>(simd: S, vector: <Self as Real>::Vector<S>, into: &mut [Self]) {
                <Self as Real>::store_part(simd, into, vector);
            }
        }

        impl Stored for $type {
            type Real = Self;

            #[inline(always)]
            fn packed(value: Self) -> Self {
                value
            }

            #[inline(always)]
            fn unpacked(self) -> Self {
                self
            }

            #[inline(always)]
            fn pack(values: &[Self], into: &mut [Self]) {
                into.copy_from_slice(values);
            }

            #[inline(always)]
            fn unpack(kept: &[Self], into: &mut [Self]) {
                into.copy_from_slice(kept);
            }

            fn room(_: usize) -> Vec<Self> {
                Vec::new()
            }

            #[inline(always)]
            fn values<'a>(kept: &'a [Self], _: &'a mut [Self]) -> &'a [Self] {
                kept
            }
        }
    };
}

as_it_is!(f32);
as_it_is!(f64);

impl Vectors for f16 {
    type Number = f32;

    fn dispatch<W: WithSimd>(instructions: Arch, work: W) -> W::Output {
        sixteen_bits::dispatch(instructions, work)
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, kept: &[Self]) -> S::f32s {
        sixteen_bits::load(simd, kept)
    }

    #[inline(always)]
    fn store<S: Simd>(simd: S, vector: S::f32s, into: &mut [Self]) {
        sixteen_bits::store(simd, vector, into);
    }

    #[inline(always)]
    fn store_part<S: Simd>(simd: S, vector: S::f32s, into: &mut [Self]) {
        let mut whole = [Self::default(); LINE_BYTES / size_of::<f32>()];
        let whole = &mut whole[..S::F32_LANES];
        sixteen_bits::store(simd, vector, whole);
        into.copy_from_slice(&whole[..into.len()]);
    }
}

impl Stored for f16 {
    type Real = f32;

    #[inline(always)]
    fn packed(value: f32) -> Self {
        sixteen_bits::packed(value)
    }

    #[inline(always)]
    fn unpacked(self) -> f32 {
        sixteen_bits::unpacked(self)
    }

    #[inline(always)]
    fn pack(values: &[f32], into: &mut [Self]) {
        sixteen_bits::pack(values, into);
    }

    #[inline(always)]
    fn unpack(kept: &[Self], into: &mut [f32]) {
        sixteen_bits::unpack(kept, into);
    }

    fn room(length: usize) -> Vec<f32> {
        vec![0.0; length]
    }

    #[inline(always)]
    fn values<'a>(kept: &'a [Self], room: &'a mut [f32]) -> &'a [f32] {
        let room = &mut room[..kept.len()];
        Self::unpack(kept, room);
        room
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_keep_eleven_of_a_number() {
        let mut room = f16::room(1);
        for exponent in -28..1 {
            for value in [1.0_f32, -1.3, 1.999].map(|v| v * 2.0_f32.powi(exponent)) {
                let kept = f16::packed(value);
                assert!(
                    (kept.unpacked() - value).abs() <= value.abs() / 2048.0,
                    "{value}"
                );
                assert_eq!(f16::values(&[kept], &mut room), [kept.unpacked()]);
            }
        }
        assert_eq!(f16::packed(0.0).to_bits(), 0);
        assert_eq!(f16::packed(2.1), f16::INFINITY);
        assert!(f16::packed(f32::NAN).is_nan());
    }

    #[test]
    fn whole_slices_get_the_bits_of_single_numbers() {
        // All of a length that is no multiple of a vector's, with subnormal ones and those beyond the largest.
        let values: Vec<f32> = (0..1003)
            .map(|i| (i as f32 - 500.0) * 2.3_f32.powi(i % 60 - 50))
            .collect();
        let mut kept = vec![f16::default(); values.len()];
        f16::pack(&values, &mut kept);
        let mut back = vec![0.0; values.len()];
        f16::unpack(&kept, &mut back);
        for ((value, kept), back) in values.iter().zip(&kept).zip(&back) {
            assert_eq!(kept.to_bits(), f16::packed(*value).to_bits(), "{value}");
            assert_eq!(back.to_bits(), kept.unpacked().to_bits(), "{value}");
        }
    }
}
