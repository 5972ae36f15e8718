//! Collision operators on one cell, in lattice units, on populations shifted by their weights (f − w).
//!
//! * [`single_relaxation_time`]: BGK (Bhatnagar, Gross & Krook 1954; Qian, d'Humières & Lallemand 1992), the reference that
//!   others are compared with. Unstable at small viscosity, and where its walls stand depends on τ.
//! * [`two_relaxation_times`]: Ginzburg's TRT with Λ = 3/16; for verification and low Reynolds numbers.
//! * [`recursive_regularised`]: third-order recursive regularisation (Malaspinas 2015; Coreixas et al. 2017) with
//!   the D3Q19 basis of Jacob, Malaspinas & Sagaut 2018, for any Reynolds number together with an eddy viscosity.
//!   *Departure*: the trace of the non-equilibrium stress is relaxed to equilibrium at once (bulk mode), and there
//!   is no finite-difference blend (σ = 1).
//! * [`stabilised_regularised`]: the same with a residual-based viscosity, for bodies at any Reynolds number. The recursion predicts the third-order
//!   moments that a resolved flow has; what the streamed populations have beside, r_aab = Σ f c_a c_a c_b − j_b/3 − ρ u_a² u_b − 2 u_a Π̂_ab − u_b Π̂_aa,
//!   is of the order of the second derivatives of u, and large only where the lattice resolves nothing. It gives the cell the relaxation time
//!   τ_e = ½ + √((τ − ½)² + S² |r|²), S = [`RESIDUAL_FACTOR`]: nothing where the air's own viscosity suffices, and what breakdown takes where
//!   it does not. *Our own*: the idea of viscosity from the residual of a discrete solution is Guermond, Pasquetti & Popov's (2011,
//!   doi:10.1016/j.jcp.2010.11.043), that of reading it off moments beyond the stress is akin to entropic operators (Karlin, Bösch & Chikatamarla
//!   2014, doi:10.1103/PhysRevE.90.031302). `docs/stability.md` compares it with both.
//!
//! Body forces follow Guo, Zheng & Shi 2002: ρu = Σ f c + F/2; the regularised operator projects the forcing term on
//! the second-order Hermite basis.
//! Every formula is written once, over [`Number`]: one cell, or as many as a vector of the CPU has lanes. Factors are gathered so that
//! few operations remain; j = ρu throughout. Where rounded weights would not sum to one, one of them is taken as what the others leave:
//! else mass and momentum would drift in single precision, since the same error recurs in every step.
//! An eddy viscosity within the collision is Smagorinsky's, from the local non-equilibrium stress Π̂ (BGK and TRT keep its trace, which they
//! also relax; the regularised operator has none left) (Hou et al. 1994):
//! τ_e = ½ (τ + √(τ² + 18 √2 C_s² |Π̂| / ρ)). Models that need more than one cell are in [`super::eddy_viscosity`].

use super::{DIRECTION_COUNT, Number};

/// Magic parameter Λ = (τ₊ − ½)(τ₋ − ½) of the TRT operator: 3/16 puts a bounce-back wall half-way between cells.
pub const TRT_MAGIC: f64 = 3.0 / 16.0;

/// Factor S of the residual-based viscosity. Bodies at Reynolds numbers up to 2·10⁶ stand from 0.3 on; 1 leaves a margin, and Taylor–Green
/// vortices at Re 1600 lose as much energy as without.
pub const RESIDUAL_FACTOR: f64 = 1.0;

/// Factor 18 √2 C_s² of Smagorinsky's relaxation time for a constant C_s.
#[must_use]
pub fn eddy_factor(smagorinsky_constant: f64) -> f64 {
    18.0 * std::f64::consts::SQRT_2 * smagorinsky_constant * smagorinsky_constant
}

/// Populations of one cell.
pub type Populations<T> = [T; DIRECTION_COUNT];

/// Per-cell inputs of a collision besides the populations.
#[derive(Debug, Clone, Copy)]
pub struct Local<T> {
    /// Relaxation time τ of the molecular viscosity (with sponge, and eddy viscosity from the stage of that name), ν = (τ − ½)/3.
    pub relaxation_time: T,
    /// Body force per cell [lattice units]; read only where `FORCED`.
    pub force: [T; 3],
    /// Smagorinsky term 18 √2 C_s²; read only where `EDDY`.
    pub eddy_factor: T,
}

/// Zeroth, first and second moments of shifted populations, without any forcing correction.
struct Moments<N> {
    density_excess: N,
    momentum: [N; 3],
    /// xx, yy, zz, xy, xz, yz.
    stress: [N; 6],
    /// f_i + f_{i+1} of the nine pairs.
    sums: [N; 9],
    /// f_i − f_{i+1} of the nine pairs.
    differences: [N; 9],
}

#[inline(always)]
fn moments<N: Number>(f: &Populations<N>) -> Moments<N> {
    let (mut s, mut d) = ([f[0]; 9], [f[0]; 9]);
    for k in 0..9 {
        s[k] = f[2 * k + 1] + f[2 * k + 2];
        d[k] = f[2 * k + 1] - f[2 * k + 2];
    }
    let xy = s[3] + s[6];
    let xz = s[4] + s[7];
    let yz = s[5] + s[8];
    Moments {
        density_excess: f[0] + ((s[0] + s[1] + s[2]) + (xy + xz + yz)),
        momentum: [
            d[0] + ((d[3] + d[6]) + (d[4] + d[7])),
            d[1] + ((d[3] - d[6]) + (d[5] + d[8])),
            d[2] + ((d[4] - d[7]) + (d[5] - d[8])),
        ],
        stress: [
            s[0] + (xy + xz),
            s[1] + (xy + yz),
            s[2] + (xz + yz),
            s[3] - s[6],
            s[4] - s[7],
            s[5] - s[8],
        ],
        sums: s,
        differences: d,
    }
}

/// Density excess δρ and momentum Σ f c (without F/2) of one cell.
#[inline(always)]
pub fn bare_moments<N: Number>(f: &Populations<N>) -> (N, [N; 3]) {
    let m = moments(f);
    (m.density_excess, m.momentum)
}

/// Every component of a vector times one factor.
#[inline(always)]
pub fn scale<N: Number>(factor: N, v: [N; 3]) -> [N; 3] {
    [factor * v[0], factor * v[1], factor * v[2]]
}

/// Sum of two vectors.
#[inline(always)]
pub(super) fn sum<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Scalar product of two vectors.
#[inline(always)]
pub fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    (a[0] * b[0])
        .plus_product(a[1], b[1])
        .plus_product(a[2], b[2])
}

/// c − a·b.
#[inline(always)]
fn minus_dot<N: Number>(c: N, a: [N; 3], b: [N; 3]) -> N {
    c.minus_product(a[0], b[0])
        .minus_product(a[1], b[1])
        .minus_product(a[2], b[2])
}

/// c·v of the first directions of the nine pairs.
#[inline(always)]
fn along<N: Number>(v: [N; 3]) -> [N; 9] {
    [
        v[0],
        v[1],
        v[2],
        v[0] + v[1],
        v[0] + v[2],
        v[1] + v[2],
        v[0] - v[1],
        v[0] - v[2],
        v[1] - v[2],
    ]
}

/// Effective relaxation time with Smagorinsky's eddy viscosity from the non-equilibrium stress (xx, yy, zz, xy, xz, yz).
#[inline(always)]
fn eddy_relaxation_time<N: Number>(local: &Local<N>, p: &[N; 6], inverse_density: N) -> N {
    let normal = dot([p[0], p[1], p[2]], [p[0], p[1], p[2]]);
    let shear = dot([p[3], p[4], p[5]], [p[3], p[4], p[5]]);
    let norm = (normal + (shear + shear)).square_root();
    let tau = local.relaxation_time;
    let root = (tau * tau)
        .plus_product(local.eddy_factor * inverse_density, norm)
        .square_root();
    tau.constant(0.5) * (tau + root)
}

/// Momentum flux j u of the equilibrium (xx, yy, zz, xy, xz, yz).
#[inline(always)]
pub(super) fn flux<N: Number>(j: &[N; 3], u: &[N; 3]) -> [N; 6] {
    [
        j[0] * u[0],
        j[1] * u[1],
        j[2] * u[2],
        j[0] * u[1],
        j[0] * u[2],
        j[1] * u[2],
    ]
}

/// Force-work tensor ½(uF + Fu), in the order of [`flux`].
#[inline(always)]
pub(super) fn force_work<N: Number>(u: &[N; 3], force: &[N; 3]) -> [N; 6] {
    let half = u[0].constant(0.5);
    [
        u[0] * force[0],
        u[1] * force[1],
        u[2] * force[2],
        half * (u[0] * force[1]).plus_product(u[1], force[0]),
        half * (u[0] * force[2]).plus_product(u[2], force[0]),
        half * (u[1] * force[2]).plus_product(u[2], force[1]),
    ]
}

/// Six components each of a symmetric tensor plus another.
#[inline(always)]
pub(super) fn sum_of_tensors<N: Number>(a: &[N; 6], b: &[N; 6]) -> [N; 6] {
    [
        a[0] + b[0],
        a[1] + b[1],
        a[2] + b[2],
        a[3] + b[3],
        a[4] + b[4],
        a[5] + b[5],
    ]
}

/// Second-order non-equilibrium stress, without the Guo correction ½(uF + Fu).
#[inline(always)]
fn bare_non_equilibrium<N: Number>(m: &Moments<N>, flux: &[N; 6]) -> [N; 6] {
    let third = m.density_excess.constant(1.0 / 3.0) * m.density_excess;
    [
        m.stress[0] - third - flux[0],
        m.stress[1] - third - flux[1],
        m.stress[2] - third - flux[2],
        m.stress[3] - flux[3],
        m.stress[4] - flux[4],
        m.stress[5] - flux[5],
    ]
}

/// Single-relaxation-time collision, BGK; returns post-collision populations.
#[inline(always)]
pub fn single_relaxation_time<N: Number, const FORCED: bool, const EDDY: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Populations<N> {
    relax_pairs::<N, FORCED, EDDY, true>(f, local)
}

/// Two-relaxation-time collision; returns post-collision populations.
#[inline(always)]
pub fn two_relaxation_times<N: Number, const FORCED: bool, const EDDY: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Populations<N> {
    relax_pairs::<N, FORCED, EDDY, false>(f, local)
}

/// Relaxes even and odd parts of all pairs, at one rate (`SINGLE`) or at two.
///
/// With s, d = f_i ± f_{i+1} of a pair, f*_{i, i+1} = s* ± d*. For the weight 1/36, and with h = j + (2τ − 1) F, which gathers equilibrium
/// and force,
/// s* = ½ (1 − ω₊) s + ½ ω₊ ((δρ − 3/2 h·u)/18 + (c·h)(c·u)/4) and d* = ½ (1 − ω₋) d + ½ ω₋ (c·Σ f c)/6 + (c·F)/12.
#[inline(always)]
fn relax_pairs<N: Number, const FORCED: bool, const EDDY: bool, const SINGLE: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Populations<N> {
    let m = moments(f);
    let constant = |value: f64| m.density_excess.constant(value);
    let one = constant(1.0);
    let half = constant(0.5);
    let density = one + m.density_excess;
    let force = local.force;
    let mut j = m.momentum;
    if FORCED {
        j = sum(j, scale(half, force));
    }
    let mut tau = local.relaxation_time;
    if EDDY {
        let inverse_density = one / density;
        let u = scale(inverse_density, j);
        let mut p = bare_non_equilibrium(&m, &flux(&j, &u));
        if FORCED {
            p = sum_of_tensors(&p, &force_work(&u, &force));
        }
        tau = eddy_relaxation_time(local, &p, inverse_density);
    }
    // ½ (1 − ω) and ½ ω, rounded so that they sum to ½ exactly: else mass and momentum would drift.
    let even_kept = half - half / tau;
    let odd_kept = if SINGLE {
        even_kept
    } else {
        half - half / (half + constant(TRT_MAGIC) / (tau - half))
    };
    let even_gained = half - even_kept;
    let odd_gained = half - odd_kept;
    // Odd equilibria sum to j: the weight of the axes is what those of the diagonals leave.
    let sixth = constant(1.0 / 6.0);
    let third = one - constant(4.0) * sixth;
    let mut h = j;
    let mut twelfth_force = force;
    if FORCED {
        h = sum(j, scale((tau + tau) - one, force));
        twelfth_force = scale(constant(1.0 / 12.0), force);
    }
    // v = 3/2 · ½ ω₊ u.
    let v = scale(constant(1.5) * even_gained / density, j);
    let rest = minus_dot(even_gained * m.density_excess, h, v);
    let rest_18 = constant(1.0 / 18.0) * rest;
    let rest_9 = rest_18 + rest_18;
    let v_along = along(v);
    let (axis_h, h_along) = (scale(third, h), along(scale(sixth, h)));
    let (axis_momentum, momentum_along) =
        (scale(third, m.momentum), along(scale(sixth, m.momentum)));
    let force_along = along(twelfth_force);

    let mut out = *f;
    out[0] = (even_kept + even_kept) * f[0] + ((rest + rest) - constant(24.0) * rest_18);
    for k in 0..9 {
        let (mut even, odd_equilibrium) = if k < 3 {
            (rest_9.plus_product(axis_h[k], v_along[k]), axis_momentum[k])
        } else {
            (
                rest_18.plus_product(h_along[k], v_along[k]),
                momentum_along[k],
            )
        };
        even = even.plus_product(even_kept, m.sums[k]);
        let mut odd = (odd_gained * odd_equilibrium).plus_product(odd_kept, m.differences[k]);
        if FORCED {
            odd = odd
                + if k < 3 {
                    force_along[k] + force_along[k]
                } else {
                    force_along[k]
                };
        }
        out[2 * k + 1] = even + odd;
        out[2 * k + 2] = even - odd;
    }
    out
}

/// Recursive-regularised collision of third order; returns post-collision populations.
///
/// With g the non-equilibrium part rebuilt from its second-order moment Π̂ alone, f* = f_eq + (1 − ω) g + S/2.
#[inline(always)]
pub fn recursive_regularised<N: Number, const FORCED: bool, const EDDY: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Populations<N> {
    regularise::<N, FORCED, EDDY, false>(f, local)
}

/// Recursive-regularised collision with residual-based viscosity; returns post-collision populations.
#[inline(always)]
pub fn stabilised_regularised<N: Number, const FORCED: bool, const EDDY: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Populations<N> {
    regularise::<N, FORCED, EDDY, true>(f, local)
}

/// Square of the third-order moments that the recursion does not predict, |r|², of shifted populations with the velocity u, the momentum
/// flux j u and the non-equilibrium stress. The moments are bare, without any force.
#[inline(always)]
fn residual_square<N: Number>(m: &Moments<N>, u: &[N; 3], flux: &[N; 6], p: &[N; 6]) -> N {
    let d = &m.differences;
    let third = m.density_excess.constant(1.0 / 3.0);
    let isotropic = scale(third, m.momentum);
    // Of order aab: its moment, the axes, and where ab stands among the components of a tensor.
    let residual = |moment: N, a: usize, b: usize, ab: usize| {
        (moment - isotropic[b])
            .minus_product(u[a], flux[ab] + (p[ab] + p[ab]))
            .minus_product(u[b], p[a])
    };
    let [xxy, yyx] = [
        residual(d[3] - d[6], 0, 1, 3),
        residual(d[3] + d[6], 1, 0, 3),
    ];
    let [xxz, zzx] = [
        residual(d[4] - d[7], 0, 2, 4),
        residual(d[4] + d[7], 2, 0, 4),
    ];
    let [yyz, zzy] = [
        residual(d[5] - d[8], 1, 2, 5),
        residual(d[5] + d[8], 2, 1, 5),
    ];
    dot([xxy, xxz, yyz], [xxy, xxz, yyz]) + dot([yyx, zzx, zzy], [yyx, zzx, zzy])
}

/// What the regularised operators read off a cell before its collision.
pub(super) struct Regularised<N> {
    pub(super) density_excess: N,
    pub(super) inverse_density: N,
    /// Σ f c.
    pub(super) momentum: [N; 3],
    pub(super) u: [N; 3],
    /// j u.
    pub(super) flux: [N; 6],
    /// ½(uF + Fu); only where `FORCED`.
    pub(super) work: [N; 6],
    /// Stress beyond equilibrium, without its trace where `TRACELESS`.
    pub(super) stress: [N; 6],
    /// Relaxation time with all that adds to it.
    pub(super) relaxation_time: N,
}

/// Reads it off; other operators than the regularised ones keep the trace of the stress.
#[inline(always)]
pub(super) fn regularised<
    N: Number,
    const FORCED: bool,
    const EDDY: bool,
    const RESIDUAL: bool,
    const TRACELESS: bool,
>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Regularised<N> {
    let m = moments(f);
    let constant = |value: f64| m.density_excess.constant(value);
    let one = constant(1.0);
    let half = constant(0.5);
    let inverse_density = one / (one + m.density_excess);
    let force = local.force;
    let mut j = m.momentum;
    if FORCED {
        j = sum(j, scale(half, force));
    }
    let u = scale(inverse_density, j);
    let flux = flux(&j, &u);
    let mut p = bare_non_equilibrium(&m, &flux);
    let mut work = flux;
    if FORCED {
        work = force_work(&u, &force);
        p = sum_of_tensors(&p, &work);
    }
    if TRACELESS {
        let bulk = constant(1.0 / 3.0) * (p[0] + p[1] + p[2]);
        p[0] = p[0] - bulk;
        p[1] = p[1] - bulk;
        p[2] = p[2] - bulk;
    }
    let mut tau = if EDDY {
        eddy_relaxation_time(local, &p, inverse_density)
    } else {
        local.relaxation_time
    };
    if RESIDUAL {
        let viscous = tau - half;
        let factor = constant(RESIDUAL_FACTOR * RESIDUAL_FACTOR);
        let square = residual_square(&m, &u, &flux, &p);
        tau = half
            + (viscous * viscous)
                .plus_product(factor, square)
                .square_root();
    }
    Regularised {
        density_excess: m.density_excess,
        inverse_density,
        momentum: m.momentum,
        u,
        flux,
        work,
        stress: p,
        relaxation_time: tau,
    }
}

#[inline(always)]
fn regularise<N: Number, const FORCED: bool, const EDDY: bool, const RESIDUAL: bool>(
    f: &Populations<N>,
    local: &Local<N>,
) -> Populations<N> {
    let cell = regularised::<N, FORCED, EDDY, RESIDUAL, true>(f, local);
    let one = cell.density_excess.constant(1.0);
    // Momentum after the collision, Σ f c + F.
    let mut carried = cell.momentum;
    let mut equilibrium = cell.flux;
    if FORCED {
        carried = sum(carried, local.force);
        equilibrium = sum_of_tensors(&cell.flux, &cell.work);
    }
    let keep = one - one / cell.relaxation_time;
    let p = cell.stress;
    let kept = [
        keep * p[0],
        keep * p[1],
        keep * p[2],
        keep * p[3],
        keep * p[4],
        keep * p[5],
    ];
    // Second-order Hermite coefficients, ρ u u + (1 − ω) Π̂ + ½ (uF + Fu).
    let second = sum_of_tensors(&equilibrium, &kept);
    assembled(
        cell.density_excess,
        &cell.u,
        &cell.flux,
        &kept,
        &second,
        carried,
    )
}

/// Populations of third order with the momentum `carried` and the second-order Hermite coefficients `second`; those of third order are what the
/// recursion has for the stress `kept` beyond equilibrium.
#[inline(always)]
pub(super) fn assembled<N: Number>(
    density_excess: N,
    u: &[N; 3],
    flux: &[N; 6],
    kept: &[N; 6],
    second: &[N; 6],
    carried: [N; 3],
) -> Populations<N> {
    let constant = |value: f64| density_excess.constant(value);
    // Times 4.5/36.
    let eighth = constant(1.0 / 8.0);
    let quarter = constant(0.25);
    let normal = [eighth * second[0], eighth * second[1], eighth * second[2]];
    let shear = [
        quarter * second[3],
        quarter * second[4],
        quarter * second[5],
    ];
    // Third-order coefficients a_aab = u_a (ρ u_a u_b + 2 (1 − ω) Π̂_ab) + u_b (1 − ω) Π̂_aa, times 9/36.
    let quarter_u = scale(quarter, *u);
    let [xy, xz, yz] = [
        flux[3] + (kept[3] + kept[3]),
        flux[4] + (kept[4] + kept[4]),
        flux[5] + (kept[5] + kept[5]),
    ];
    let xxy = (quarter_u[0] * xy).plus_product(quarter_u[1], kept[0]);
    let xxz = (quarter_u[0] * xz).plus_product(quarter_u[2], kept[0]);
    let yyx = (quarter_u[1] * xy).plus_product(quarter_u[0], kept[1]);
    let yyz = (quarter_u[1] * yz).plus_product(quarter_u[2], kept[1]);
    let zzx = (quarter_u[2] * xz).plus_product(quarter_u[0], kept[2]);
    let zzy = (quarter_u[2] * yz).plus_product(quarter_u[1], kept[2]);

    // Everything below is for the weight 1/36 of the diagonals.
    let trace = normal[0] + normal[1] + normal[2];
    let base = (constant(1.0 / 36.0) * density_excess).minus_product(constant(1.0 / 3.0), trace);
    // The populations sum to δρ and their momentum to the carried one: rest and axes take what the diagonals leave.
    let twelfth = constant(1.0 / 12.0);
    let axis_carried = scale(quarter - (twelfth + twelfth), carried);
    let carried = scale(twelfth, carried);
    let mut out = [density_excess; DIRECTION_COUNT];
    out[0] = density_excess
        .minus_product(constant(24.0), base)
        .minus_product(constant(12.0), trace);
    axis(&mut out, 0, base + normal[0], axis_carried[0] - (yyx + zzx));
    axis(&mut out, 1, base + normal[1], axis_carried[1] - (xxy + zzy));
    axis(&mut out, 2, base + normal[2], axis_carried[2] - (xxz + yyz));
    let normal = [
        base + (normal[0] + normal[1]),
        base + (normal[0] + normal[2]),
        base + (normal[1] + normal[2]),
    ];
    diagonals(
        &mut out,
        3,
        normal[0],
        shear[0],
        [carried[0], carried[1]],
        [xxy, yyx],
    );
    diagonals(
        &mut out,
        4,
        normal[1],
        shear[1],
        [carried[0], carried[2]],
        [xxz, zzx],
    );
    diagonals(
        &mut out,
        5,
        normal[2],
        shear[2],
        [carried[1], carried[2]],
        [yyz, zzy],
    );
    out
}

/// Pair `k` of an axis, of twice the weight of the diagonals. (These are functions since closures are not always inlined.)
#[inline(always)]
fn axis<N: Number>(out: &mut Populations<N>, k: usize, even: N, odd: N) {
    let (plus, minus) = (even + odd, even - odd);
    out[2 * k + 1] = plus + plus;
    out[2 * k + 2] = minus + minus;
}

/// Pairs `k` and `k + 3`, (1, 1) and (1, −1) in the plane of axes a and b, from what the axes carry and the coefficients of orders aab and bba.
#[inline(always)]
fn diagonals<N: Number>(
    out: &mut Populations<N>,
    k: usize,
    normal: N,
    shear: N,
    carried: [N; 2],
    third_order: [N; 2],
) {
    let (even, odd) = (
        normal + shear,
        (carried[0] + carried[1]) + (third_order[0] + third_order[1]),
    );
    out[2 * k + 1] = even + odd;
    out[2 * k + 2] = even - odd;
    let (even, odd) = (
        normal - shear,
        (carried[0] - carried[1]) + (third_order[1] - third_order[0]),
    );
    out[2 * k + 7] = even + odd;
    out[2 * k + 8] = even - odd;
}

#[cfg(test)]
#[path = "operators_tests.rs"]
mod tests;
