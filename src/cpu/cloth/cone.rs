//! Tension-only sheets with a linear law, without a search for the direction of wrinkles.
//!
//! Wrinkles are the strain P ⪰ 0 that makes W(E + P), W = ½ E:C:E, least ([`crate::fabric::membrane`]). Strains P ⪰ 0 fill a cone of second order:
//! det P = PᵀJP ≥ 0 in Voigt form. So −E is projected on a cone, and the shortest distance is measured by C.
//!
//! Three directions v of strain diagonalise both forms, VᵀCV = 1 and VᵀJV = diag(λ₁, −λ₂, −λ₃), λ > 0. In coordinates e = V⁻¹E, with
//! rᵢ = λᵢ/λ₁, cᵢ = rᵢ/(1 + rᵢ) and dᵢ = 1/(1 + rᵢ), wrinkles have p₁ = T, and what is left of the strain is
//!
//! ê₁ = e₁ + T,  êᵢ = eᵢ cᵢ (e₁ + T)/(T + cᵢ e₁)  (i = 2, 3),
//!
//! where T is the largest root of the secular equation Σ cᵢdᵢ eᵢ²/(T + cᵢ e₁)² = 1, but at least 0 (taut) and −e₁ (slack).
//! With y = T for e₁ > 0 and y = T + e₁ otherwise, it reads F(y) = Σ bᵢ²/(y + oᵢ)² = 1 with oᵢ = cᵢe₁ or dᵢ|e₁|: nothing cancels, and y = 0
//! is the border of wrinkles on either side.
//!
//! F^(−1/2) is concave and nearly straight, as known from trust regions (Hebden 1973; Moré & Sorensen 1983, doi:10.1137/0904038). Halley's
//! method finds where it is 1, from below and in a number of steps that is fixed by the law. Two equal rᵢ, as of isotropic sheets, need none.
//! Operations are rounded one by one, so the bits do not depend on the vectors that a CPU has.

use pulp::Simd;

use crate::fabric::membrane::Membrane;
use crate::fabric::plane::Matrix3;
use crate::lattice::{Lanes, Number};

/// Numbers, of which each lane can choose by its sign.
pub trait Choice: Number {
    /// `yes` where this is above zero, else `no`; not a number chooses `no`.
    #[must_use]
    fn if_positive(self, yes: Self, no: Self) -> Self;

    /// True if any lane is above zero.
    #[must_use]
    fn is_any_positive(self) -> bool;
}

impl Choice for f64 {
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        if self > 0.0 { yes } else { no }
    }

    #[inline(always)]
    fn is_any_positive(self) -> bool {
        self > 0.0
    }
}

impl<S: Simd> Choice for Lanes<S, f64> {
    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Lanes::if_positive(self, yes, no)
    }

    #[inline(always)]
    fn is_any_positive(self) -> bool {
        Lanes::is_any_positive(self)
    }
}

/// Numbers of a law in a [`Cone`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Constants<N> {
    /// cᵢ of the second and the third direction.
    pub shares: [N; 2],
    /// dᵢ = 1 − cᵢ.
    pub rests: [N; 2],
    /// √(cᵢ dᵢ).
    pub weights: [N; 2],
    /// Share of the compressive stiffness that is kept.
    pub residual: N,
}

/// A linear law in the coordinates in which wrinkles are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// V⁻¹: rows give e of a strain (xx, yy, 2·xy) [√(N/m)]; |e|²/2 is the energy per area of the sheet without wrinkles.
    pub from_strain: Matrix3,
    /// Numbers of the law.
    pub constants: Constants<f64>,
    /// Steps of Halley's method that reach the rounding of numbers.
    pub steps: u32,
}

/// Ratio of r₂ and r₃ up to which they count as equal: what it leaves of the root falls with its square.
const EQUAL: f64 = 1.0 + 1e-9;

/// Most steps of Halley's method, for hardly any shear stiffness.
const STEP_LIMIT: u32 = 10;

impl Cone {
    /// `None` for laws that are not linear, and for stiffness that is not positive definite.
    #[must_use]
    pub fn new(membrane: &Membrane) -> Option<Self> {
        if membrane.shear().is_some() {
            return None;
        }
        let lower = cholesky(membrane.stiffness())?;
        let (mut values, mut rows) = diagonal(in_units_of(&lower));
        // The one positive value first.
        let first = (0..3).find(|&k| values[k] > 0.0)?;
        values.swap(0, first);
        rows.swap(0, first);
        // VᵀCV = 1 makes V⁻¹ = QᵀLᵀ, with Q the unit vectors that `rows` holds.
        let mut from_strain =
            rows.map(|row| [0, 1, 2].map(|j| (0..=j).map(|i| row[i] * lower[j][i]).sum::<f64>()));
        // The first direction, L⁻ᵀ times its unit vector, must stretch.
        let first = solve_transposed(&lower, rows[0]);
        if first[0] + first[1] < 0.0 {
            from_strain[0] = from_strain[0].map(|x| -x);
        }
        let ratios = [1, 2].map(|k| -values[k] / values[0]);
        let shares = ratios.map(|r| r / (1.0 + r));
        let rests = ratios.map(|r| 1.0 / (1.0 + r));
        let weights = [0, 1].map(|k| (shares[k] * rests[k]).sqrt());
        let numbers = from_strain.iter().flatten().chain(&weights);
        let are_usable = numbers.copied().all(f64::is_finite) && weights.iter().all(|w| *w > 0.0);
        are_usable.then_some(Self {
            from_strain,
            constants: Constants {
                shares,
                rests,
                weights,
                residual: membrane.residual(),
            },
            steps: steps(ratios),
        })
    }
}

/// Steps of Halley's method by the ratio of r₂ and r₃; measured over the worst strains.
fn steps([a, b]: [f64; 2]) -> u32 {
    let ratio = (a / b).max(b / a);
    if ratio <= EQUAL {
        return 0;
    }
    let further = (0.65 * (ratio.log10() - 1.5)).max(0.0).ceil();
    (3 + further as u32).min(STEP_LIMIT)
}

/// L of C = L Lᵀ.
fn cholesky(c: &Matrix3) -> Option<Matrix3> {
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let left = c[i][j] - known;
            l[i][j] = if i == j { left.sqrt() } else { left / l[j][j] };
        }
        let is_positive = l[i][i] > 0.0 && l[i][i].is_finite();
        if !is_positive {
            return None;
        }
    }
    Some(l)
}

/// x of L x = b.
fn solve(l: &Matrix3, b: [f64; 3]) -> [f64; 3] {
    let mut x = b;
    for i in 0..3 {
        for j in 0..i {
            x[i] -= l[i][j] * x[j];
        }
        x[i] /= l[i][i];
    }
    x
}

/// x of Lᵀ x = b.
fn solve_transposed(l: &Matrix3, b: [f64; 3]) -> [f64; 3] {
    let mut x = b;
    for i in (0..3).rev() {
        for j in i + 1..3 {
            x[i] -= l[j][i] * x[j];
        }
        x[i] /= l[i][i];
    }
    x
}

/// L⁻¹ J L⁻ᵀ, with J the determinant of a strain as a quadratic form.
fn in_units_of(l: &Matrix3) -> Matrix3 {
    const DETERMINANT: Matrix3 = [[0.0, 0.5, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, -0.25]];
    // Columns of L⁻¹J are rows of its transpose, J being symmetric.
    let half = transposed(&DETERMINANT.map(|row| solve(l, row)));
    half.map(|row| solve(l, row))
}

fn transposed(m: &Matrix3) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i]))
}

/// Values and unit vectors of a symmetric matrix, by Jacobi's rotations.
fn diagonal(mut m: Matrix3) -> ([f64; 3], Matrix3) {
    let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Five sweeps reach the rounding of numbers; more change nothing.
    for _ in 0..12 {
        for [p, q] in [[0, 1], [0, 2], [1, 2]] {
            if m[p][q] == 0.0 {
                continue;
            }
            let half = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let tangent = half.signum() / (half.abs() + (half * half + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            let turn = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
            for k in 0..3 {
                (m[k][p], m[k][q]) = turn(m[k][p], m[k][q]);
            }
            for k in 0..3 {
                (m[p][k], m[q][k]) = turn(m[p][k], m[q][k]);
                (rows[p][k], rows[q][k]) = turn(rows[p][k], rows[q][k]);
            }
            (m[p][q], m[q][p]) = (0.0, 0.0);
        }
    }
    ([m[0][0], m[1][1], m[2][2]], rows)
}

/// Least divisor of Halley's method over that of Newton's: no step is longer than five of Newton's.
const LEAST: f64 = 0.2;

/// Below every strain: keeps 0/0 out of a sheet at rest, and is lost in every other sum.
const TINY: f64 = 1e-300;

/// The larger of two.
#[inline(always)]
fn larger<N: Choice>(a: N, b: N) -> N {
    (a - b).if_positive(a, b)
}

/// The number itself, but zero where it is below, or not a number.
#[inline(always)]
fn positive<N: Choice>(x: N) -> N {
    x.if_positive(x, x.constant(0.0))
}

#[inline(always)]
fn absolute<N: Choice>(x: N) -> N {
    x.if_positive(x, -x)
}

#[inline(always)]
fn square<N: Choice>(v: &[N; 3]) -> N {
    v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
}

/// Coordinates ê of the strain without its wrinkles; what is not a number goes through. Multiplying e by a positive number multiplies ê by it.
// Closures would be called, not inlined, and vectors then go through memory.
#[inline(always)]
pub fn relaxed<N: Choice>(e: &[N; 3], law: &Constants<N>, steps: u32) -> [N; 3] {
    let [mean, e2, e3] = *e;
    let one = mean.constant(1.0);
    let offset2 = mean.if_positive(law.shares[0], -law.rests[0]) * mean;
    let offset3 = mean.if_positive(law.shares[1], -law.rests[1]) * mean;
    let (b2, b3) = (law.weights[0] * e2, law.weights[1] * e3);
    // The equation is solved for y over |b|, so that squares and cubes of small strains do not vanish.
    let norm = (b2 * b2 + b3 * b3).square_root();
    let scale = one / norm;
    let (b2, b3) = (absolute(b2) * scale, absolute(b3) * scale);
    let (o2, o3) = (offset2 * scale, offset3 * scale);
    let (s2, s3) = (b2 * b2, b3 * b3);
    let apart = o2 - o3;
    // With Sₖ = Σ bᵢ²/qᵢᵏ, Halley's step is Newton's over 1 − 3/2 (√S₂ − 1)(S₂S₄/S₃² − 1). By Lagrange's identity,
    // S₂S₄ − S₃² = b₂²b₃²(q₂ − q₃)²/(q₂q₃)⁴: nothing cancels.
    let bend = mean.constant(1.5) * (s2 * s3 * (apart * apart));
    // Below the root: F with one pole left out, and with both moved to their mean.
    let lone = larger(b2 - o2, b3 - o3);
    let mut y = positive(larger(one - (s2 * o2 + s3 * o3), lone));
    for _ in 0..steps {
        let (q2, q3) = (y + o2, y + o3);
        let (n2, n3) = (s2 * (q3 * q3), s3 * (q2 * q2));
        // S₂ = n/d², S₃ = m/d³.
        let (n, d) = (n2 + n3, q2 * q3);
        let m = n2 * q3 + n3 * q2;
        let missing = n.square_root() - d;
        // Where no lane is wrinkled, all stay at zero.
        if !larger(y, missing).is_any_positive() {
            break;
        }
        let square = m * m;
        let least = mean.constant(LEAST) * square;
        let divisor = larger(square - bend * (d * missing), least);
        y = positive(y + n * missing * m / divisor);
    }
    let y = y * norm;
    let left = y + positive(mean);
    let tiny = mean.constant(TINY);
    let kept2 = law.shares[0] * left / (y + offset2 + tiny);
    let kept3 = law.shares[1] * left / (y + offset3 + tiny);
    [left, kept2 * e2, kept3 * e3]
}

/// Energy per area [J/m²] and tension in the coordinates of the cone, ∂(energy)/∂e, of the relaxed sheet and of the share of stiffness kept.
#[inline(always)]
pub fn energy_and_tension<N: Choice>(e: &[N; 3], law: &Constants<N>, steps: u32) -> (N, [N; 3]) {
    let r = law.residual;
    let rest = r.constant(1.0) - r;
    let mut tension = relaxed(e, law, steps);
    let energy = r.constant(0.5) * (rest * square(&tension) + r * square(e));
    for k in 0..3 {
        tension[k] = rest * tension[k] + r * e[k];
    }
    (energy, tension)
}

#[cfg(test)]
#[path = "cone_tests.rs"]
mod tests;
