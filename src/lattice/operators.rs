//! Collision operators on one cell, in lattice units, on populations shifted by their weights (f − w).
//!
//! * [`two_relaxation_times`]: Ginzburg's TRT with Λ = 3/16; for verification and low Reynolds numbers.
//! * [`recursive_regularised`]: third-order recursive regularisation (Malaspinas 2015; Coreixas et al. 2017) with
//!   the D3Q19 basis of Jacob, Malaspinas & Sagaut 2018, for any Reynolds number together with an eddy viscosity.
//!   *Departure*: the trace of the non-equilibrium stress is relaxed to equilibrium at once (bulk mode), and there
//!   is no finite-difference blend (σ = 1).
//!
//! Body forces follow Guo, Zheng & Shi 2002: ρu = Σ f c + F/2; the regularised operator projects the forcing term on
//! the second-order Hermite basis.
//! The eddy viscosity is Smagorinsky's, from the local non-equilibrium stress Π̂ (TRT keeps its trace, which it also relaxes; the regularised
//! operator has none left) (Hou et al. 1994):
//! τ_e = ½ (τ + √(τ² + 18 √2 C_s² |Π̂| / ρ)).

use super::{DIRECTION_COUNT, Real};

/// Magic parameter Λ = (τ₊ − ½)(τ₋ − ½) of the TRT operator: 3/16 puts a bounce-back wall half-way between cells.
pub const TRT_MAGIC: f64 = 3.0 / 16.0;

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
    /// Relaxation time τ of the molecular viscosity (and sponge), ν = (τ − ½)/3.
    pub relaxation_time: T,
    /// Body force per cell [lattice units]; read only where `FORCED`.
    pub force: [T; 3],
    /// Smagorinsky term 18 √2 C_s²; read only where `EDDY`.
    pub eddy_factor: T,
}

/// Zeroth, first and second moments of shifted populations, without any forcing correction.
struct Moments<T> {
    density_excess: T,
    momentum: [T; 3],
    /// xx, yy, zz, xy, xz, yz.
    stress: [T; 6],
    /// f_i + f_{i+1} of the nine pairs.
    sums: [T; 9],
    /// f_i − f_{i+1} of the nine pairs.
    differences: [T; 9],
}

#[inline(always)]
fn moments<T: Real>(f: &Populations<T>) -> Moments<T> {
    let s = [
        f[1] + f[2],
        f[3] + f[4],
        f[5] + f[6],
        f[7] + f[8],
        f[9] + f[10],
        f[11] + f[12],
        f[13] + f[14],
        f[15] + f[16],
        f[17] + f[18],
    ];
    let d = [
        f[1] - f[2],
        f[3] - f[4],
        f[5] - f[6],
        f[7] - f[8],
        f[9] - f[10],
        f[11] - f[12],
        f[13] - f[14],
        f[15] - f[16],
        f[17] - f[18],
    ];
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
            s[0] + xy + xz,
            s[1] + xy + yz,
            s[2] + xz + yz,
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
pub fn bare_moments<T: Real>(f: &Populations<T>) -> (T, [T; 3]) {
    let m = moments(f);
    (m.density_excess, m.momentum)
}

/// Effective relaxation time with Smagorinsky's eddy viscosity from the non-equilibrium stress (xx, yy, zz, xy, xz, yz).
#[inline(always)]
fn eddy_relaxation_time<T: Real>(local: &Local<T>, p: &[T; 6], inverse_density: T) -> T {
    let norm = (p[0] * p[0]
        + p[1] * p[1]
        + p[2] * p[2]
        + T::of(2.0) * (p[3] * p[3] + p[4] * p[4] + p[5] * p[5]))
        .square_root();
    let tau = local.relaxation_time;
    T::of(0.5) * (tau + (tau * tau + local.eddy_factor * norm * inverse_density).square_root())
}

/// Second-order non-equilibrium stress including the Guo correction, and the force-work tensor ½(uF + Fu).
#[inline(always)]
fn non_equilibrium<T: Real, const FORCED: bool>(
    m: &Moments<T>,
    density: T,
    u: &[T; 3],
    force: &[T; 3],
) -> ([T; 6], [T; 6]) {
    let third = T::of(1.0 / 3.0) * m.density_excess;
    let mut work = [T::default(); 6];
    if FORCED {
        let half = T::of(0.5);
        work = [
            u[0] * force[0],
            u[1] * force[1],
            u[2] * force[2],
            half * (u[0] * force[1] + u[1] * force[0]),
            half * (u[0] * force[2] + u[2] * force[0]),
            half * (u[1] * force[2] + u[2] * force[1]),
        ];
    }
    let p = [
        m.stress[0] - third - density * u[0] * u[0] + work[0],
        m.stress[1] - third - density * u[1] * u[1] + work[1],
        m.stress[2] - third - density * u[2] * u[2] + work[2],
        m.stress[3] - density * u[0] * u[1] + work[3],
        m.stress[4] - density * u[0] * u[2] + work[4],
        m.stress[5] - density * u[1] * u[2] + work[5],
    ];
    (p, work)
}

/// Two-relaxation-time collision; returns post-collision populations.
#[inline(always)]
pub fn two_relaxation_times<T: Real, const FORCED: bool, const EDDY: bool>(
    f: &Populations<T>,
    local: &Local<T>,
) -> Populations<T> {
    let m = moments(f);
    let one = T::of(1.0);
    let half = T::of(0.5);
    let density = one + m.density_excess;
    let inverse_density = one / density;
    let force = local.force;
    let mut momentum = m.momentum;
    if FORCED {
        for a in 0..3 {
            momentum[a] += half * force[a];
        }
    }
    let u = momentum.map(|j| j * inverse_density);
    let mut tau = local.relaxation_time;
    if EDDY {
        let (p, _) = non_equilibrium::<T, FORCED>(&m, density, &u, &force);
        tau = eddy_relaxation_time(local, &p, inverse_density);
    }
    let even_rate = one / tau;
    let odd_tau = half + T::of(TRT_MAGIC) / (tau - half);
    let odd_rate = one / odd_tau;
    let square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    let rest = m.density_excess - T::of(1.5) * density * square;
    let force_along_u = if FORCED {
        u[0] * force[0] + u[1] * force[1] + u[2] * force[2]
    } else {
        T::default()
    };
    let even_source = one - half * even_rate;
    let odd_source = one - half * odd_rate;

    let mut out = *f;
    out[0] = f[0] - even_rate * (f[0] - T::of(1.0 / 3.0) * rest);
    if FORCED {
        out[0] += even_source * T::of(-1.0) * force_along_u;
    }
    let axis = T::of(1.0 / 18.0);
    let diagonal = T::of(1.0 / 36.0);
    // (pair index, weight, c·u, c·F)
    let along = |v: &[T; 3]| {
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
    };
    let cu = along(&u);
    let cf = along(&force);
    for k in 0..9 {
        let weight = if k < 3 { axis } else { diagonal };
        let two_weights = weight + weight;
        let even_equilibrium = two_weights * (rest + T::of(4.5) * density * cu[k] * cu[k]);
        let odd_equilibrium = two_weights * T::of(3.0) * density * cu[k];
        let mut even = m.sums[k] - even_rate * (m.sums[k] - even_equilibrium);
        let mut odd = m.differences[k] - odd_rate * (m.differences[k] - odd_equilibrium);
        if FORCED {
            even += even_source
                * two_weights
                * (T::of(9.0) * cu[k] * cf[k] - T::of(3.0) * force_along_u);
            odd += odd_source * two_weights * T::of(3.0) * cf[k];
        }
        out[2 * k + 1] = half * (even + odd);
        out[2 * k + 2] = half * (even - odd);
    }
    out
}

/// Recursive-regularised collision of third order; returns post-collision populations.
///
/// With g the non-equilibrium part rebuilt from its second-order moment Π̂ alone, f* = f_eq + (1 − ω) g + S/2.
#[inline(always)]
pub fn recursive_regularised<T: Real, const FORCED: bool, const EDDY: bool>(
    f: &Populations<T>,
    local: &Local<T>,
) -> Populations<T> {
    let m = moments(f);
    let one = T::of(1.0);
    let half = T::of(0.5);
    let two = T::of(2.0);
    let third = T::of(1.0 / 3.0);
    let density = one + m.density_excess;
    let inverse_density = one / density;
    let force = local.force;
    let mut momentum = m.momentum;
    // Momentum after the collision, Σ f c + F.
    let mut carried = m.momentum;
    if FORCED {
        for a in 0..3 {
            momentum[a] += half * force[a];
            carried[a] += force[a];
        }
    }
    let u = momentum.map(|j| j * inverse_density);
    let (mut p, work) = non_equilibrium::<T, FORCED>(&m, density, &u, &force);
    let bulk = third * (p[0] + p[1] + p[2]);
    p[0] = p[0] - bulk;
    p[1] = p[1] - bulk;
    p[2] = p[2] - bulk;
    let tau = if EDDY {
        eddy_relaxation_time(local, &p, inverse_density)
    } else {
        local.relaxation_time
    };
    let keep = one - one / tau;
    let kept = p.map(|value| keep * value);

    // Second-order Hermite coefficients: ρ u u + (1 − ω) Π̂ + ½ (uF + Fu).
    let mut q = [
        density * u[0] * u[0] + kept[0],
        density * u[1] * u[1] + kept[1],
        density * u[2] * u[2] + kept[2],
        density * u[0] * u[1] + kept[3],
        density * u[0] * u[2] + kept[4],
        density * u[1] * u[2] + kept[5],
    ];
    if FORCED {
        for k in 0..6 {
            q[k] += work[k];
        }
    }
    // Third-order coefficients a_aab = ρ u_a² u_b + (1 − ω)(2 u_a Π̂_ab + u_b Π̂_aa).
    let third_order = |a: usize, b: usize, aa: usize, ab: usize| {
        u[a] * (density * u[a] * u[b] + two * kept[ab]) + u[b] * kept[aa]
    };
    let xxy = third_order(0, 1, 0, 3);
    let xxz = third_order(0, 2, 0, 4);
    let yyx = third_order(1, 0, 1, 3);
    let yyz = third_order(1, 2, 1, 5);
    let zzx = third_order(2, 0, 2, 4);
    let zzy = third_order(2, 1, 2, 5);

    let trace = T::of(1.5) * (q[0] + q[1] + q[2]);
    let base = m.density_excess - trace;
    let nine = T::of(9.0);
    let four_and_half = T::of(4.5);
    let three = T::of(3.0);
    let axis = T::of(1.0 / 18.0);
    let diagonal = T::of(1.0 / 36.0);
    let mut out = *f;
    out[0] = third * base;
    let mut pair = |k: usize, weight: T, even: T, odd: T| {
        out[2 * k + 1] = weight * (even + odd);
        out[2 * k + 2] = weight * (even - odd);
    };
    pair(
        0,
        axis,
        base + four_and_half * q[0],
        three * carried[0] - nine * (yyx + zzx),
    );
    pair(
        1,
        axis,
        base + four_and_half * q[1],
        three * carried[1] - nine * (xxy + zzy),
    );
    pair(
        2,
        axis,
        base + four_and_half * q[2],
        three * carried[2] - nine * (xxz + yyz),
    );
    let mut diagonal_pair = |k: usize, a: usize, b: usize, ab: usize, aab: T, bba: T, sign: T| {
        let even = base + four_and_half * (q[a] + q[b] + two * sign * q[ab]);
        let odd = three * (carried[a] + sign * carried[b]) + nine * (sign * aab + bba);
        pair(k, diagonal, even, odd);
    };
    diagonal_pair(3, 0, 1, 3, xxy, yyx, one);
    diagonal_pair(4, 0, 2, 4, xxz, zzx, one);
    diagonal_pair(5, 1, 2, 5, yyz, zzy, one);
    diagonal_pair(6, 0, 1, 3, xxy, yyx, -one);
    diagonal_pair(7, 0, 2, 4, xxz, zzx, -one);
    diagonal_pair(8, 1, 2, 5, yyz, zzy, -one);
    out
}

#[cfg(test)]
mod tests {
    use super::super::{DIRECTIONS, WEIGHTS};
    use super::*;

    fn populations() -> Populations<f64> {
        std::array::from_fn(|i| 0.01 * WEIGHTS[i] * ((i * i) as f64 * 0.7 + 1.3).sin())
    }

    fn local(force: [f64; 3]) -> Local<f64> {
        Local {
            relaxation_time: 0.7,
            force,
            eddy_factor: 18.0 * 2f64.sqrt() * 0.15 * 0.15,
        }
    }

    fn mass_and_momentum(f: &Populations<f64>) -> [f64; 4] {
        let mut m = [0.0; 4];
        for i in 0..DIRECTION_COUNT {
            m[0] += f[i];
            for a in 0..3 {
                m[a + 1] += f[i] * f64::from(DIRECTIONS[i][a]);
            }
        }
        m
    }

    #[test]
    fn collisions_keep_mass_and_add_exactly_the_force() {
        let f = populations();
        let force = [1e-3, -2e-3, 5e-4];
        let before = mass_and_momentum(&f);
        for out in [
            two_relaxation_times::<f64, true, true>(&f, &local(force)),
            recursive_regularised::<f64, true, true>(&f, &local(force)),
        ] {
            let after = mass_and_momentum(&out);
            assert!((after[0] - before[0]).abs() < 1e-15);
            for a in 0..3 {
                assert!((after[a + 1] - before[a + 1] - force[a]).abs() < 1e-15);
            }
        }
    }

    /// The third-order terms must leave second-order moments alone: the stress after a collision of an equilibrium
    /// state is that of the equilibrium.
    #[test]
    fn third_order_basis_is_orthogonal_to_lower_moments() {
        let u = [0.1, -0.05, 0.08];
        let f: Populations<f64> = std::array::from_fn(|i| super::super::equilibrium(i, 0.02, u));
        let out = recursive_regularised::<f64, false, false>(&f, &local([0.0; 3]));
        let before = moments(&f);
        let after = moments(&out);
        for k in 0..6 {
            assert!((before.stress[k] - after.stress[k]).abs() < 1e-15, "{k}");
        }
        for a in 0..3 {
            assert!((before.momentum[a] - after.momentum[a]).abs() < 1e-15);
        }
    }

    /// The closed form against the textbook: f* rebuilt direction by direction from Hermite polynomials, with second- and third-order
    /// coefficients from their definitions, for a forced state far from equilibrium.
    #[test]
    fn recursive_regularised_is_its_hermite_series() {
        let f = populations();
        let force = [1e-3, -2e-3, 5e-4];
        let local = Local {
            relaxation_time: 0.7,
            force,
            eddy_factor: 0.0,
        };
        let out = recursive_regularised::<f64, true, false>(&f, &local);
        let c = |i: usize, a: usize| f64::from(DIRECTIONS[i][a]);
        let unit = |a: usize, b: usize| if a == b { 1.0 } else { 0.0 };
        let rho = 1.0 + f.iter().sum::<f64>();
        let bare: [f64; 3] =
            std::array::from_fn(|a| (0..DIRECTION_COUNT).map(|i| f[i] * c(i, a)).sum());
        let u: [f64; 3] = std::array::from_fn(|a| (bare[a] + 0.5 * force[a]) / rho);
        let work = |a: usize, b: usize| 0.5 * (u[a] * force[b] + u[b] * force[a]);
        // Non-equilibrium stress without its trace.
        let raw = |a: usize, b: usize| -> f64 {
            let stress: f64 = (0..DIRECTION_COUNT)
                .map(|i| (f[i] + WEIGHTS[i]) * c(i, a) * c(i, b))
                .sum();
            stress - rho * (u[a] * u[b] + unit(a, b) / 3.0) + work(a, b)
        };
        let trace = (raw(0, 0) + raw(1, 1) + raw(2, 2)) / 3.0;
        let keep = 1.0 - 1.0 / local.relaxation_time;
        let p = |a: usize, b: usize| keep * (raw(a, b) - unit(a, b) * trace);
        let second = |a: usize, b: usize| rho * u[a] * u[b] + p(a, b) + work(a, b);
        // a_aab of the third order.
        let third =
            |a: usize, b: usize| rho * u[a] * u[a] * u[b] + 2.0 * u[a] * p(a, b) + u[b] * p(a, a);
        let hermite2 = |i: usize, a: usize, b: usize| c(i, a) * c(i, b) - unit(a, b) / 3.0;
        let hermite3 = |i: usize, a: usize, b: usize| (c(i, a) * c(i, a) - 1.0 / 3.0) * c(i, b);
        for i in 0..DIRECTION_COUNT {
            let mut sum = rho - 1.0;
            for a in 0..3 {
                sum += 3.0 * c(i, a) * (bare[a] + force[a]);
                for b in 0..3 {
                    sum += 4.5 * hermite2(i, a, b) * second(a, b);
                }
            }
            // On D3Q19 the pairs (aab, ccb) are orthogonal only as sum and difference (Jacob et al. 2018).
            for (a, d, b) in [(0, 2, 1), (0, 1, 2), (1, 2, 0)] {
                let (h1, h2) = (hermite3(i, a, b), hermite3(i, d, b));
                let (t1, t2) = (third(a, b), third(d, b));
                sum += 13.5 * (h1 + h2) * (t1 + t2) + 4.5 * (h1 - h2) * (t1 - t2);
            }
            assert!(
                (out[i] - WEIGHTS[i] * sum).abs() < 1e-15,
                "{i}: {} {}",
                out[i],
                WEIGHTS[i] * sum
            );
        }
    }
}
