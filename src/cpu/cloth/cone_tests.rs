//! Tests of the projection against the search for the direction of wrinkles, and against the conditions of the least energy.

use super::*;
use crate::fabric::membrane::principal;
use crate::fabric::plane::{dot, times};
use crate::fabric::shear::CubicShear;

/// Strains of every law.
const COUNT: usize = 200_000;

/// Random numbers (xorshift, Marsaglia 2003).
struct Random(u64);

impl Random {
    /// In 0 … 1.
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Of either sign and any size between two powers of ten.
    fn sized(&mut self, low: f64, high: f64) -> f64 {
        let size = 10_f64.powf(low + (high - low) * self.unit());
        if self.unit() < 0.5 { size } else { -size }
    }

    fn dyad(&mut self) -> [f64; 3] {
        let (s, c) = (std::f64::consts::PI * self.unit()).sin_cos();
        [c * c, s * s, 2.0 * s * c]
    }
}

fn orthotropic(moduli_pa: [f64; 2], poisson_ratio: f64, shear_modulus_pa: f64) -> Matrix3 {
    let [warp, weft] = moduli_pa;
    let scale = 1e-4 / (1.0 - poisson_ratio * poisson_ratio * weft / warp);
    let coupling = scale * poisson_ratio * weft;
    [
        [scale * warp, coupling, 0.0],
        [coupling, scale * weft, 0.0],
        [0.0, 0.0, 1e-4 * shear_modulus_pa],
    ]
}

/// Stiffness of sheets: isotropic ones, then from nearly isotropic to hardly any shear stiffness.
fn stiffnesses() -> Vec<Matrix3> {
    let isotropic = |nu: f64| orthotropic([4.31e8; 2], nu, 4.31e8 / (2.0 * (1.0 + nu)));
    vec![
        isotropic(0.14),
        isotropic(0.0),
        isotropic(0.45),
        orthotropic([4.31e8; 2], 0.14, 1.8e8),
        orthotropic([4.31e8; 2], 0.14, 5e7),
        orthotropic([4.31e8; 2], 0.14, 1e7),
        orthotropic([4.31e8; 2], 0.14, 1e6),
        orthotropic([4.31e8, 1.5e8], 0.35, 1e7),
        orthotropic([1e8, 6e8], 0.1, 3e8),
    ]
}

/// A sheet whose warp does not lie along x.
fn turned(stiffness: &Matrix3, angle: f64) -> Matrix3 {
    let (s, c) = angle.sin_cos();
    let rows = [
        [c * c, s * s, c * s],
        [s * s, c * c, -c * s],
        [-2.0 * c * s, 2.0 * c * s, c * c - s * s],
    ];
    let column = |j: usize| [rows[0][j], rows[1][j], rows[2][j]];
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(&column(i), &times(stiffness, &column(j)))))
}

fn inverse(stiffness: &Matrix3, v: &[f64; 3]) -> [f64; 3] {
    let lower = cholesky(stiffness).unwrap();
    solve_transposed(&lower, solve(&lower, *v))
}

/// Strains of all kinds: any sizes, single components, borders of taut and of slack, and at rest.
fn strain(random: &mut Random, stiffness: &Matrix3, number: usize) -> [f64; 3] {
    let size = random.sized(-9.0, -0.5).abs();
    let mut strain = match number % 6 {
        0 | 1 => [0; 3].map(|_| size * (2.0 * random.unit() - 1.0)),
        2 => [0; 3].map(|_| random.sized(-9.0, -0.5)),
        // One tension: the border of taut. Shear of a tension is half of that of a strain.
        3 => {
            let [x, y, two_xy] = random.dyad();
            inverse(stiffness, &[x, y, 0.5 * two_xy]).map(|x| size * stiffness[0][0] * x)
        }
        // One compression: the border of slack.
        4 => random.dyad().map(|x| -size * x),
        _ => {
            let mut single = [0.0; 3];
            single[number / 6 % 3] = random.sized(-9.0, -0.5);
            single
        }
    };
    if number.is_multiple_of(2) {
        let noise = size * 10_f64.powf(-16.0 * random.unit());
        strain = strain.map(|x| x + noise * (2.0 * random.unit() - 1.0));
    }
    if number % 1000 == 5 {
        strain = [0.0; 3];
    }
    strain
}

fn respond(cone: &Cone, strain: &[f64; 3]) -> (f64, [f64; 3]) {
    let e = times(&cone.from_strain, strain);
    let (energy, t) = energy_and_tension(&e, &cone.constants, cone.steps);
    (energy, times(&transposed(&cone.from_strain), &t))
}

fn largest(v: impl IntoIterator<Item = f64>) -> f64 {
    v.into_iter().map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn projection_agrees_with_the_search_for_the_direction() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (law, stiffness) in stiffnesses().into_iter().enumerate() {
        let laws = [0.0, 1e-3, 1.0].map(|residual| {
            let membrane = Membrane::new(stiffness, residual);
            let cone = Cone::new(&membrane).unwrap();
            (membrane, cone)
        });
        let stiff = largest(stiffness.into_iter().flatten());
        for number in 0..COUNT {
            let (membrane, cone) = &laws[number % 7 % 3];
            let strain = strain(&mut random, &stiffness, number);
            let expected = membrane.respond(&strain);
            let (energy, tension) = respond(cone, &strain);
            let size = largest(strain);
            let off = largest((0..3).map(|k| tension[k] - expected.tension[k]));
            // The search ends at a slope that is small; the projection is exact, as the next test shows.
            assert!(
                off <= 1e-12 * stiff * size,
                "law {law}, {strain:?}: {tension:?}, {expected:?}"
            );
            let off = (energy - expected.energy).abs();
            assert!(
                off <= 1e-14 * stiff * size * size,
                "law {law}, {strain:?}: {energy}, {expected:?}"
            );
        }
    }
}

/// The least energy has a tension without compression, and wrinkles that only shorten and do no work: these conditions have one solution.
#[test]
fn tension_meets_the_conditions_of_the_least_energy() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let mut sheets = stiffnesses();
    sheets.extend([0.2, 0.7, -1.1].map(|angle| turned(&sheets[5], angle)));
    sheets.push(turned(&sheets[7], 0.4));
    for (law, stiffness) in sheets.into_iter().enumerate() {
        let cone = Cone::new(&Membrane::new(stiffness, 0.0)).unwrap();
        let stiff = largest(stiffness.into_iter().flatten());
        let mut worst = [0.0_f64; 3];
        for number in 0..COUNT {
            let strain = strain(&mut random, &stiffness, number);
            let (_, t) = respond(&cone, &strain);
            let size = largest(strain);
            if size == 0.0 {
                continue;
            }
            let relaxed = inverse(&stiffness, &t);
            let wrinkles = [0, 1, 2].map(|k| relaxed[k] - strain[k]);
            let [_, pull] = principal(t[0], t[1], t[2]);
            let [_, shortened] = principal(wrinkles[0], wrinkles[1], 0.5 * wrinkles[2]);
            let off = [
                -pull / (stiff * size),
                -shortened / size,
                dot(&t, &wrinkles).abs() / (stiff * size * size),
            ];
            for k in 0..3 {
                worst[k] = worst[k].max(off[k]);
            }
        }
        // Shear strains are as exact as tensions, over the shear stiffness.
        let soft = stiff / stiffness[2][2].min(stiffness[1][1]).min(stiffness[0][0]);
        assert!(worst[0] < 1e-14 && worst[2] < 1e-14, "law {law}: {worst:?}");
        assert!(worst[1] < 1e-14 * soft, "law {law}: {worst:?}");
    }
}

/// Ten steps more change nothing, for laws of all ratios and close to where one pole takes over from the other.
#[test]
fn steps_reach_the_rounding_of_numbers() {
    let mut random = Random(77);
    for number in 0..60 {
        let shear = 10_f64.powf(8.5 - 0.12 * f64::from(number));
        let poisson_ratio = [0.14, 0.0, -0.5, 0.8][number as usize % 4];
        let stiffness = orthotropic([4.31e8, 3e8], poisson_ratio, shear);
        let cone = Cone::new(&Membrane::new(stiffness, 0.0)).unwrap();
        let mut worst = 0.0_f64;
        for _ in 0..20_000 {
            let mean: f64 = if random.unit() < 0.5 { 1.0 } else { -1.0 };
            let pole = usize::from(random.unit() < 0.5);
            let c = &cone.constants;
            let offset = if mean > 0.0 { c.shares } else { c.rests }[pole];
            let mut e = [mean, 0.0, 0.0];
            e[1 + pole] = offset * (1.0 + random.sized(-9.0, -0.5)) / c.weights[pole];
            e[2 - pole] = random.sized(-10.0, 0.0) / c.weights[1 - pole];
            let found = relaxed(&e, c, cone.steps);
            let further = relaxed(&e, c, cone.steps + 10);
            let off = largest((0..3).map(|k| found[k] - further[k]));
            worst = worst.max(off / largest(e));
        }
        assert!(worst < 1e-14, "{shear} Pa: {worst}");
    }
}

#[test]
fn not_a_number_goes_through() {
    let cone = Cone::new(&Membrane::new(stiffnesses()[5], 0.0)).unwrap();
    for k in 0..3 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for others in [0.0, 0.01, -0.01] {
                let mut e = [others; 3];
                e[k] = bad;
                let (energy, _) = energy_and_tension(&e, &cone.constants, cone.steps);
                assert!(!energy.is_finite(), "{e:?}: {energy}");
            }
        }
    }
}

#[test]
fn laws_without_a_cone_are_refused() {
    let law = Membrane::new(stiffnesses()[5], 0.0);
    let shear = CubicShear {
        compliance_m_n: 1e-3,
        cubic_m3_n3: 1e-7,
    };
    assert!(Cone::new(&law.with_shear(shear)).is_none());
    let mut indefinite = stiffnesses()[5];
    indefinite[0][1] = 2.0 * indefinite[0][0];
    indefinite[1][0] = indefinite[0][1];
    assert!(Cone::new(&Membrane::new(indefinite, 0.0)).is_none());
    let mut missing = stiffnesses()[5];
    missing[1][1] = f64::NAN;
    assert!(Cone::new(&Membrane::new(missing, 0.0)).is_none());
    missing[1][1] = 0.0;
    assert!(Cone::new(&Membrane::new(missing, 0.0)).is_none());
}
