use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use pulp::Simd;

/// Numbers that the formulas of the lattice work on: one value, or the lanes of a vector of the CPU. Operations are rounded by
/// themselves as IEEE 754 says, but for [`Number::plus_product`] and [`Number::minus_product`], which vectors of a CPU with such an
/// instruction round once: only there do the bits depend on the CPU.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Div<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Sub<Output = Self>
{
    /// The value nearest to `value`, in all lanes of a number like this one.
    #[must_use]
    fn constant(self, value: f64) -> Self;

    /// Square root.
    #[must_use]
    fn square_root(self) -> Self;

    /// self + a b.
    #[must_use]
    fn plus_product(self, a: Self, b: Self) -> Self;

    /// self − a b.
    #[must_use]
    fn minus_product(self, a: Self, b: Self) -> Self;
}

/// The two floating-point types in which the air can be computed: `f64` is the reference, `f32` the fast engine.
pub trait Real:
    Number + Debug + Default + PartialOrd + Send + Sync + AddAssign + bytemuck::Pod + 'static
{
    /// Vector of these under the instruction set `S`.
    type Vector<S: Simd>: Copy + Debug + Send + Sync + 'static;

    /// Values in such a vector.
    fn lanes<S: Simd>() -> usize;

    /// Nearest value.
    fn of(value: f64) -> Self;

    /// Exact widening.
    fn to_f64(self) -> f64;

    /// All whole vectors of a slice, and the values that remain behind them.
    fn vectors<S: Simd>(values: &[Self]) -> (&[Self::Vector<S>], &[Self]);

    /// All whole vectors of a slice, and the values that remain behind them.
    fn vectors_mut<S: Simd>(values: &mut [Self]) -> (&mut [Self::Vector<S>], &mut [Self]);

    /// Reads fewer values than a vector has; the other lanes are zero.
    fn load_part<S: Simd>(simd: S, values: &[Self]) -> Self::Vector<S>;

    /// Writes the first lanes, fewer than a vector has.
    fn store_part<S: Simd>(simd: S, values: &mut [Self], vector: Self::Vector<S>);

    /// The same value in all lanes.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Vector<S>;

    /// a + b.
    fn add<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// a − b.
    fn subtract<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// a b.
    fn multiply<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// a / b.
    fn divide<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;

    /// −a.
    fn negate<S: Simd>(simd: S, a: Self::Vector<S>) -> Self::Vector<S>;

    /// a b + c, rounded once where the CPU has an instruction for it.
    fn multiply_add<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;

    /// c − a b, rounded once where the CPU has an instruction for it.
    fn negate_multiply_add<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;

    /// √a.
    fn root<S: Simd>(simd: S, a: Self::Vector<S>) -> Self::Vector<S>;
}

macro_rules! real {
    ($type:ty, $vector:ident, $lanes:ident, $vectors:ident, $vectors_mut:ident, $load:ident, $store:ident, $splat:ident,
     $add:ident, $subtract:ident, $multiply:ident, $divide:ident, $negate:ident, $multiply_add:ident, $negate_multiply_add:ident, $root:ident) => {
        impl Number for $type {
            #[inline(always)]
            fn constant(self, value: f64) -> Self {
                value as $type
            }

            #[inline(always)]
            fn square_root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn plus_product(self, a: Self, b: Self) -> Self {
                self + a * b
            }

            #[inline(always)]
            fn minus_product(self, a: Self, b: Self) -> Self {
                self - a * b
            }
        }

        impl Real for $type {
            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }

            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $type
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn vectors<S: Simd>(values: &[Self]) -> (&[S::$vector], &[Self]) {
                S::$vectors(values)
            }

            #[inline(always)]
            fn vectors_mut<S: Simd>(values: &mut [Self]) -> (&mut [S::$vector], &mut [Self]) {
                S::$vectors_mut(values)
            }

            #[inline(always)]
            fn load_part<S: Simd>(simd: S, values: &[Self]) -> S::$vector {
                simd.$load(values)
            }

            #[inline(always)]
            fn store_part<S: Simd>(simd: S, values: &mut [Self], vector: S::$vector) {
                simd.$store(values, vector);
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$vector {
                simd.$splat(value)
            }

            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn subtract<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$subtract(a, b)
            }

            #[inline(always)]
            fn multiply<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$multiply(a, b)
            }

            #[inline(always)]
            fn divide<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$divide(a, b)
            }

            #[inline(always)]
            fn negate<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$negate(a)
            }

            #[inline(always)]
            fn multiply_add<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
            ) -> S::$vector {
                simd.$multiply_add(a, b, c)
            }

            #[inline(always)]
            fn negate_multiply_add<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
            ) -> S::$vector {
                simd.$negate_multiply_add(a, b, c)
            }

            #[inline(always)]
            fn root<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$root(a)
            }
        }
    };
}

real!(
    f32,
    f32s,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    partial_load_f32s,
    partial_store_f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    neg_f32s,
    mul_add_e_f32s,
    negate_mul_add_e_f32s,
    sqrt_f32s
);
real!(
    f64,
    f64s,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    partial_load_f64s,
    partial_store_f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    neg_f64s,
    mul_add_e_f64s,
    negate_mul_add_e_f64s,
    sqrt_f64s
);

/// The lanes of one vector, with the operators of numbers. `S` is a token of no size that shows that the CPU has the instructions.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd, T: Real> {
    simd: S,
    /// The vector itself.
    pub vector: T::Vector<S>,
}

impl<S: Simd, T: Real> Lanes<S, T> {
    /// The lanes of `vector`.
    #[inline(always)]
    pub fn new(simd: S, vector: T::Vector<S>) -> Self {
        Self { simd, vector }
    }

    /// `value` in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, value: T) -> Self {
        Self::new(simd, T::splat(simd, value))
    }
}

impl<S: Simd> Lanes<S, f64> {
    /// `yes` where this is above zero, else `no`; not a number chooses `no`.
    #[inline(always)]
    #[must_use]
    pub fn if_positive(self, yes: Self, no: Self) -> Self {
        let simd = self.simd;
        let is_positive = simd.greater_than_f64s(self.vector, simd.splat_f64s(0.0));
        Self::new(simd, simd.select_f64s(is_positive, yes.vector, no.vector))
    }

    /// True if any lane is above zero.
    #[inline(always)]
    #[must_use]
    pub fn is_any_positive(self) -> bool {
        let simd = self.simd;
        let is_positive = simd.greater_than_f64s(self.vector, simd.splat_f64s(0.0));
        simd.first_true_m64s(is_positive) < S::F64_LANES
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd, T: Real> $trait for Lanes<S, T> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::new(
                    self.simd,
                    <T as Real>::$function(self.simd, self.vector, other.vector),
                )
            }
        }
    };
}

operator!(Add, add, add);
operator!(Sub, sub, subtract);
operator!(Mul, mul, multiply);
operator!(Div, div, divide);

impl<S: Simd, T: Real> Neg for Lanes<S, T> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, T::negate(self.simd, self.vector))
    }
}

impl<S: Simd, T: Real> Number for Lanes<S, T> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, T::of(value))
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        Self::new(self.simd, T::root(self.simd, self.vector))
    }

    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        Self::new(
            self.simd,
            T::multiply_add(self.simd, a.vector, b.vector, self.vector),
        )
    }

    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        Self::new(
            self.simd,
            T::negate_multiply_add(self.simd, a.vector, b.vector, self.vector),
        )
    }
}
