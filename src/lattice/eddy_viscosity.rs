//! Eddy viscosity of what the grid does not resolve, in lattice units: the filter is as wide as a cell, Δ = 1.
//!
//! | model | ν_t | constant | evaluated |
//! |---|---|---|---|
//! | Smagorinsky 1963 | C_s² √(2 S:S) | C_s 0.1 to 0.2 | in every collision, from the cell's own stress ([`super::operators`]) |
//! | WALE (Nicoud & Ducros 1999, doi:10.1023/A:1009995426001) | C_w² (S^d:S^d)^{3/2} / ((S:S)^{5/2} + (S^d:S^d)^{5/4}) | C_w 0.325 (channel) to 0.6 (isotropic) | every few steps, stage `eddy_viscosity` |
//! | Vreman 2004 (doi:10.1063/1.1785131) | c √(B_β / (α:α)) | c = 2.5 C_s²: 0.025 to 0.07 | the same |
//!
//! α_ij = ∂u_j/∂x_i; S is its symmetric part, S^d the traceless symmetric part of α², β = αᵀα, and B_β the sum of the principal 2×2 minors
//! of β. WALE and Vreman are zero in pure shear, Smagorinsky is not; in solid-body rotation only Smagorinsky is zero.
//!
//! *Departures*: the gradient is divided by its norm first, so that no power of it leaves the range of single precision; B_β is summed
//! as the squares of all 2×2 minors of α (the same by the theorem of Cauchy and Binet), which cannot become negative; velocities lack the
//! half step of the body force, which only cells at a sheet have.

use serde::{Deserialize, Serialize};

use super::Number;
use super::operators::{dot, scale};

/// Model of the eddy viscosity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EddyViscosityModel {
    /// From the strain rate.
    Smagorinsky,
    /// Wall-adapting local eddy viscosity, from the whole velocity gradient.
    Wale,
    /// From the whole velocity gradient.
    Vreman,
}

impl EddyViscosityModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Smagorinsky, Self::Wale, Self::Vreman];

    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smagorinsky => "Smagorinsky",
            Self::Wale => "WALE",
            Self::Vreman => "Vreman",
        }
    }

    /// Symbol of its constant.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Smagorinsky => "C_s",
            Self::Wale => "C_w",
            Self::Vreman => "c",
        }
    }
}

/// Models that need the whole velocity gradient, and so the neighbours of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GradientModel {
    /// [`wale`].
    Wale,
    /// [`vreman`].
    Vreman,
}

/// Steps between evaluations of a [`GradientModel`]. At a lattice speed of 0.1 the air moves by less than half a cell in that time.
pub const UPDATE_EVERY: u32 = 4;

/// An eddy viscosity: model and constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EddyViscosity {
    /// The model.
    pub model: EddyViscosityModel,
    /// Its constant: C_s, C_w or c.
    pub constant: f64,
    /// Steps between evaluations where the model needs the velocity gradient; others are evaluated in every collision.
    pub update_every: u32,
}

impl EddyViscosity {
    /// Model and constant, evaluated as often as usual.
    #[must_use]
    pub const fn new(model: EddyViscosityModel, constant: f64) -> Self {
        Self {
            model,
            constant,
            update_every: UPDATE_EVERY,
        }
    }

    /// Smagorinsky's model with the constant C_s.
    #[must_use]
    pub const fn smagorinsky(constant: f64) -> Self {
        Self::new(EddyViscosityModel::Smagorinsky, constant)
    }

    /// The WALE model with the constant C_w.
    #[must_use]
    pub const fn wale(constant: f64) -> Self {
        Self::new(EddyViscosityModel::Wale, constant)
    }

    /// Vreman's model with the constant c.
    #[must_use]
    pub const fn vreman(constant: f64) -> Self {
        Self::new(EddyViscosityModel::Vreman, constant)
    }

    /// C_s of a model that is evaluated within the collision.
    #[must_use]
    pub fn smagorinsky_constant(&self) -> Option<f64> {
        (self.model == EddyViscosityModel::Smagorinsky).then_some(self.constant)
    }

    /// The model, where it needs the velocity gradient.
    #[must_use]
    pub const fn gradient_model(&self) -> Option<GradientModel> {
        match self.model {
            EddyViscosityModel::Smagorinsky => None,
            EddyViscosityModel::Wale => Some(GradientModel::Wale),
            EddyViscosityModel::Vreman => Some(GradientModel::Vreman),
        }
    }

    /// What the eddy part of the relaxation time, 3 ν_t, is per [`wale`] or [`vreman`].
    #[must_use]
    pub fn relaxation_factor(&self) -> f64 {
        match self.model {
            EddyViscosityModel::Smagorinsky | EddyViscosityModel::Wale => {
                3.0 * self.constant * self.constant
            }
            EddyViscosityModel::Vreman => 3.0 * self.constant,
        }
    }
}

/// Below this square the gradient counts as none: a change of 1e-15 cells per step from cell to cell.
const SMALLEST_SQUARE: f64 = 1e-30;

// Functions, not closures: only what is certainly inlined is compiled for the vector instructions of the CPU.

/// The gradient over its norm, and the norm.
#[inline(always)]
fn normalised<N: Number>([x, y, z]: [[N; 3]; 3]) -> ([[N; 3]; 3], N) {
    let tiny = x[0].constant(SMALLEST_SQUARE);
    let norm = (dot(x, x) + dot(y, y) + dot(z, z) + tiny).square_root();
    let inverse = norm.constant(1.0) / norm;
    (
        [scale(inverse, x), scale(inverse, y), scale(inverse, z)],
        norm,
    )
}

/// Element (a, b) of the square of g.
#[inline(always)]
fn product<N: Number>(g: &[[N; 3]; 3], a: usize, b: usize) -> N {
    g[a][0] * g[0][b] + g[a][1] * g[1][b] + g[a][2] * g[2][b]
}

/// Sum of all elements of a symmetric tensor squared, from its diagonal and the others (xy, xz, yz).
#[inline(always)]
fn norm_squared<N: Number>(diagonal: [N; 3], others: [N; 3]) -> N {
    let square = dot(others, others);
    dot(diagonal, diagonal) + (square + square)
}

/// ν_t/C_w² of the WALE model for `gradient[a][b]` = ∂u_b/∂x_a [1/step].
#[inline(always)]
#[must_use]
pub fn wale<N: Number>(gradient: &[[N; 3]; 3]) -> N {
    let (g, norm) = normalised(*gradient);
    let half = norm.constant(0.5);
    let [xx, yy, zz] = [product(&g, 0, 0), product(&g, 1, 1), product(&g, 2, 2)];
    let third = norm.constant(1.0 / 3.0) * (xx + yy + zz);
    let d = norm_squared(
        [xx - third, yy - third, zz - third],
        [
            half * (product(&g, 0, 1) + product(&g, 1, 0)),
            half * (product(&g, 0, 2) + product(&g, 2, 0)),
            half * (product(&g, 1, 2) + product(&g, 2, 1)),
        ],
    );
    let s = norm_squared(
        [g[0][0], g[1][1], g[2][2]],
        [
            half * (g[0][1] + g[1][0]),
            half * (g[0][2] + g[2][0]),
            half * (g[1][2] + g[2][1]),
        ],
    );
    let root = d.square_root();
    let strained = s * s * s.square_root();
    let tiny = norm.constant(SMALLEST_SQUARE);
    norm * (d * root) / (strained + d * root.square_root() + tiny)
}

/// Square of the vector product: the squares of the three minors of two rows.
#[inline(always)]
fn minors_squared<N: Number>(p: [N; 3], q: [N; 3]) -> N {
    let minors = [
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    ];
    dot(minors, minors)
}

/// ν_t/c of Vreman's model for `gradient[a][b]` = ∂u_b/∂x_a [1/step].
#[inline(always)]
#[must_use]
pub fn vreman<N: Number>(gradient: &[[N; 3]; 3]) -> N {
    let ([x, y, z], norm) = normalised(*gradient);
    let minors = minors_squared(x, y) + minors_squared(y, z) + minors_squared(z, x);
    norm * minors.square_root()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRADIENT: [[f64; 3]; 3] = [
        [0.011, -0.004, 0.007],
        [0.023, -0.005, 0.002],
        [-0.009, 0.013, -0.006],
    ];

    fn transposed(g: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|a| std::array::from_fn(|b| g[b][a]))
    }

    fn product(g: &[[f64; 3]; 3], h: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|a| {
            std::array::from_fn(|b| (0..3).map(|k| g[a][k] * h[k][b]).sum::<f64>())
        })
    }

    fn contraction(g: &[[f64; 3]; 3], h: &[[f64; 3]; 3]) -> f64 {
        (0..9).map(|k| g[k / 3][k % 3] * h[k / 3][k % 3]).sum()
    }

    fn scaled<T: Number>(g: &[[T; 3]; 3], factor: T) -> [[T; 3]; 3] {
        g.map(|row| row.map(|x| factor * x))
    }

    /// With the paper's second form of S^d:S^d, for flow without divergence, from S and Ω: eq. 11 of Nicoud & Ducros.
    #[test]
    fn wale_is_the_papers() {
        let t = transposed(&GRADIENT);
        let part = |sign: f64| -> [[f64; 3]; 3] {
            std::array::from_fn(|a| {
                std::array::from_fn(|b| 0.5 * (GRADIENT[a][b] + sign * t[a][b]))
            })
        };
        let (s, w) = (part(1.0), part(-1.0));
        let (s2, w2) = (contraction(&s, &s), contraction(&w, &w));
        // IV = S_ik S_kj Ω_jl Ω_li.
        let fourth = contraction(&product(&s, &s), &transposed(&product(&w, &w)));
        let d = (s2 * s2 + w2 * w2) / 6.0 + 2.0 / 3.0 * s2 * w2 + 2.0 * fourth;
        let expected = d.powf(1.5) / (s2.powf(2.5) + d.powf(1.25));
        assert!((wale(&GRADIENT) / expected - 1.0).abs() < 1e-13);
    }

    /// From β as the paper defines it.
    #[test]
    fn vreman_is_the_papers() {
        let b = product(&transposed(&GRADIENT), &GRADIENT);
        let minors = b[0][0] * b[1][1] - b[0][1] * b[0][1] + b[0][0] * b[2][2] - b[0][2] * b[0][2]
            + b[1][1] * b[2][2]
            - b[1][2] * b[1][2];
        let expected = (minors / contraction(&GRADIENT, &GRADIENT)).sqrt();
        assert!((vreman(&GRADIENT) / expected - 1.0).abs() < 1e-13);
    }

    #[test]
    fn pure_shear_has_none() {
        for a in 0..3 {
            for b in (0..3).filter(|b| *b != a) {
                let mut g = [[0f32; 3]; 3];
                g[a][b] = 0.037;
                assert_eq!(wale(&g), 0.0, "{a}{b}");
                assert_eq!(vreman(&g), 0.0, "{a}{b}");
            }
        }
        assert_eq!(wale(&[[0f32; 3]; 3]), 0.0);
        assert_eq!(vreman(&[[0f32; 3]; 3]), 0.0);
    }

    /// Solid-body rotation at ω: S^d:S^d = ⅔ ω⁴, S = 0; β has ω² twice, α:α = 2ω².
    #[test]
    fn rotation_has_some() {
        let rate = 0.02;
        let g = [[0.0, rate, 0.0], [-rate, 0.0, 0.0], [0.0; 3]];
        let expected = rate * (2f64 / 3.0).powf(0.25);
        assert!((wale(&g) / expected - 1.0).abs() < 1e-14);
        assert!((vreman(&g) / (rate / 2f64.sqrt()) - 1.0).abs() < 1e-14);
    }

    /// u = a y + e y z, w = c y next to a wall at y = 0: WALE's eddy viscosity falls with the cube of the distance, as turbulent stress does.
    #[test]
    fn wale_vanishes_at_a_wall_with_the_cube_of_the_distance() {
        let at = |y: f64| wale(&[[0.0; 3], [0.03, 0.0, 0.01], [0.02 * y, 0.0, 0.0]]);
        let ratio = at(1e-3) / at(5e-4);
        assert!((ratio - 8.0).abs() < 1e-3, "{ratio}");
    }

    /// Both are proportional to the gradient, in single precision from 1e-12 to 1.
    #[test]
    fn no_power_leaves_single_precision() {
        let single = GRADIENT.map(|row| row.map(|g| g as f32));
        for exponent in -10..=2 {
            let factor = 10f32.powi(exponent);
            let g = scaled(&single, factor);
            for (found, exact) in [(wale(&g), wale(&GRADIENT)), (vreman(&g), vreman(&GRADIENT))] {
                let error = f64::from(found) / (exact * f64::from(factor)) - 1.0;
                assert!(error.abs() < 2e-6, "{exponent}: {error:e}");
            }
        }
    }
}
