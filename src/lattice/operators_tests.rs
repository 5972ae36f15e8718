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
        single_relaxation_time::<f64, true, true>(&f, &local(force)),
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

/// In single precision too: errors of rounding must not lean to one side, step after step.
#[test]
fn uniform_wind_does_not_drift_in_single_precision() {
    let u = [0.05, 0.013, -0.02];
    let local = Local {
        relaxation_time: 0.51,
        force: [0.0; 3],
        eddy_factor: 0.0,
    };
    for collide in [
        single_relaxation_time::<f32, false, false>,
        two_relaxation_times::<f32, false, false>,
        recursive_regularised::<f32, false, false>,
    ] {
        let mut f: Populations<f32> =
            std::array::from_fn(|i| super::super::equilibrium(i, 0.02, u) as f32);
        let before = mass_and_momentum(&f.map(f64::from));
        let steps = 2000;
        for _ in 0..steps {
            f = collide(&f, &local);
        }
        let after = mass_and_momentum(&f.map(f64::from));
        for k in 0..4 {
            let drift = (after[k] - before[k]).abs() / before[k].abs();
            // A weight rounded to nearest is off by up to 6e-8: 1e-4 after these steps.
            assert!(drift < 1e-6, "{k}: {drift:e}");
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

/// The form by pairs against the textbook, direction by direction: f* = f − ω (f − f_eq) + (1 − ω/2) S with S of Guo, Zheng & Shi 2002.
#[test]
fn single_relaxation_time_is_bgk() {
    let f = populations();
    let force = [1e-3, -2e-3, 5e-4];
    let mut local = local(force);
    local.relaxation_time = 0.8;
    let out = single_relaxation_time::<f64, true, false>(&f, &local);
    let rate = 1.0 / local.relaxation_time;
    let [excess, bare @ ..] = mass_and_momentum(&f);
    let u: [f64; 3] = std::array::from_fn(|a| (bare[a] + 0.5 * force[a]) / (1.0 + excess));
    for i in 0..DIRECTION_COUNT {
        let c = DIRECTIONS[i].map(f64::from);
        let along: f64 = (0..3).map(|a| c[a] * u[a]).sum();
        let source: f64 = (0..3)
            .map(|a| WEIGHTS[i] * (3.0 * (c[a] - u[a]) + 9.0 * along * c[a]) * force[a])
            .sum();
        let expected = f[i] - rate * (f[i] - super::super::equilibrium(i, excess, u))
            + (1.0 - 0.5 * rate) * source;
        assert!(
            (out[i] - expected).abs() < 1e-16,
            "{i}: {} {expected}",
            out[i]
        );
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
