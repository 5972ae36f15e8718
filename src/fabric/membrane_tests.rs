//! Tests of the membrane's law.

use std::f64::consts::PI;

use super::*;
use crate::fabric::Fabric;

/// n⊗n as a strain (xx, yy, 2·xy), for n at an angle from the warp.
fn dyad(angle: f64) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * cosine, sine * sine, 2.0 * sine * cosine]
}
fn fabric(shear_modulus_pa: f64, residual_stiffness: f64) -> Membrane {
    let fabric = Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 533.77,
        warp_modulus_pa: 4.31e8,
        weft_modulus_pa: 4.31e8,
        poisson_ratio: 0.14,
        shear_modulus_pa,
        residual_stiffness,
        cubic_shear_compliance_1_pa3: None,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    };
    Membrane::new(fabric.stiffness_n_m(), residual_stiffness)
}

/// Shear that softens: half as stiff at a few per cent.
fn cubic(shear_modulus_pa: f64, residual_stiffness: f64) -> Membrane {
    let compliance_m_n = 1.0 / (1e-4 * shear_modulus_pa);
    fabric(shear_modulus_pa, residual_stiffness).with_shear(CubicShear {
        compliance_m_n,
        // As much again at 100 N/m.
        cubic_m3_n3: 1e-4 * compliance_m_n,
    })
}

fn isotropic_shear() -> f64 {
    Fabric::isotropic_shear_modulus_pa(4.31e8, 0.14)
}

/// Brute force over all positive semidefinite P = R(θ) diag(a, b) Rᵀ in a wide grid.
fn brute_force(law: &Membrane, strain: &[f64; 3]) -> f64 {
    let mut best = f64::INFINITY;
    for k in 0..180 {
        let angle = PI * f64::from(k) / 180.0;
        let n = dyad(angle);
        let m = dyad(angle + 0.5 * PI);
        for i in 0..=60 {
            for j in 0..=20 {
                let (a, b) = (f64::from(i) * 1e-3, f64::from(j) * 1e-3);
                let e: [f64; 3] = std::array::from_fn(|q| strain[q] + a * n[q] + b * m[q]);
                best = best.min(law.energy_and_tension(&e).0);
            }
        }
    }
    best
}

#[test]
fn relaxed_energy_is_the_minimum_over_wrinkles() {
    let strains = [
        [0.01, 0.004, 0.003],
        [0.01, -0.02, 0.0],
        [0.01, -0.02, 0.02],
        [-0.01, -0.02, 0.002],
        [0.002, -0.001, 0.03],
    ];
    let laws = [
        fabric(isotropic_shear(), 0.0),
        fabric(3e6, 0.0),
        fabric(5e7, 0.0),
        cubic(5e7, 0.0),
    ];
    for law in laws {
        for strain in strains {
            let response = law.respond(&strain);
            let expected = brute_force(&law, &strain);
            // The grid of the search is 1e-3 of strain wide, so it can only be above, by little.
            assert!(
                response.energy <= expected + 1e-9,
                "{strain:?} {} {expected}",
                response.energy
            );
            assert!(
                expected - response.energy < 0.02,
                "{strain:?} {} {expected}",
                response.energy
            );
        }
    }
}

/// Strains in all directions and proportions.
fn many_strains() -> impl Iterator<Item = [f64; 3]> {
    (0..3000).map(|k| {
        let wave = |n: f64| 0.02 * (n * f64::from(k)).sin();
        [wave(0.37), wave(1.31), 2.0 * wave(2.77)]
    })
}

/// What a wrinkled sheet carries is one tension along its crests: nothing across, no shear, from sheets that hardly resist shear to isotropic
/// ones, and with shear that softens by any amount.
#[test]
fn wrinkled_fabric_carries_one_tension_along_its_crests() {
    let compliance_m_n = 1.0 / (1e-4 * 1.9e8);
    let softened = [1e-16, 1e-12, 1e-10, 1e-8, 1e-4].map(|cubic_m3_n3| {
        fabric(1.9e8, 0.0).with_shear(CubicShear {
            compliance_m_n,
            cubic_m3_n3,
        })
    });
    let linear = [isotropic_shear(), 1.8e8, 1e8, 5e7, 1e7, 1e6].map(|g| fabric(g, 0.0));
    for (number, law) in linear.into_iter().chain(softened).enumerate() {
        for strain in many_strains() {
            let response = law.respond(&strain);
            if response.state != FabricState::Wrinkled {
                continue;
            }
            let t = response.tension;
            let [larger, smaller] = principal(t[0], t[1], t[2]);
            assert!(
                smaller.abs() < 1e-6 * larger,
                "law {number}, {strain:?}: {larger} N/m and {smaller} N/m"
            );
            let across = dot(&response.across, &t);
            assert!(across.abs() < 1e-6 * larger, "law {number}, {strain:?}");
        }
    }
}

/// No direction of wrinkles gives up more energy than the one taken.
#[test]
fn wrinkles_give_up_the_most_energy() {
    for law in [1.8e8, 1e8, 5e7, 1e7, 1e6].map(|g| fabric(g, 0.0)) {
        for strain in many_strains() {
            let response = law.respond(&strain);
            if response.state != FabricState::Wrinkled {
                continue;
            }
            let tension = times(&law.stiffness, &strain);
            let whole = 0.5 * dot(&strain, &tension);
            for degree in 0..180 {
                let n = dyad(PI * f64::from(degree) / 180.0);
                let across = dot(&n, &tension).min(0.0);
                let left = whole - 0.5 * across * across / dot(&n, &times(&law.stiffness, &n));
                assert!(
                    response.energy <= left + 1e-12 * whole,
                    "{strain:?}: {} and {left} at {degree} degrees",
                    response.energy
                );
            }
        }
    }
}

#[test]
fn tension_is_the_gradient_of_the_energy_and_never_pushes() {
    for law in [
        fabric(isotropic_shear(), 0.1),
        fabric(1e7, 0.1),
        cubic(5e7, 0.1),
    ] {
        for strain in [
            [0.01, -0.02, 0.01],
            [0.01, 0.001, 0.002],
            [-0.01, -0.002, 0.001],
            [0.0, -0.003, 0.03],
        ] {
            let response = law.respond(&strain);
            for k in 0..3 {
                let step = 1e-7;
                let mut up = strain;
                let mut down = strain;
                up[k] += step;
                down[k] -= step;
                let slope = (law.respond(&up).energy - law.respond(&down).energy) / (2.0 * step);
                assert!(
                    (slope - response.tension[k]).abs() < 1e-3 * 4.31e4 * 0.03,
                    "{strain:?} {k} {slope} {:?}",
                    response.tension
                );
            }
            let [_, smaller] = principal(
                response.tension[0],
                response.tension[1],
                response.tension[2],
            );
            // Only the residual share of the compression may be left.
            assert!(smaller > -0.11 * 4.31e4 * 0.03, "{smaller}");
        }
    }
}

/// The tangent is what differences of the tension say, where the state does not change between them; wrinkles that turn and grow are in it.
#[test]
fn tangent_is_the_slope_of_the_tension() {
    let laws = [
        fabric(isotropic_shear(), 0.01),
        fabric(8e7, 0.01),
        fabric(1e7, 0.01),
        cubic(1e8, 0.01),
    ];
    for (number, law) in laws.iter().enumerate() {
        let (mut seen, mut off) = (0, 0);
        for strain in many_strains() {
            let response = law.respond(&strain);
            let tangent = law.tangent(&strain, &response);
            let step = 1e-7;
            let size = tangent[0][0].max(tangent[1][1]).max(tangent[2][2]);
            for k in 0..3 {
                let moved = |by: f64| {
                    let mut moved = strain;
                    moved[k] += by;
                    law.respond(&moved)
                };
                let (up, down) = (moved(step), moved(-step));
                if up.state != response.state || down.state != response.state {
                    continue;
                }
                for i in 0..3 {
                    assert!((tangent[i][k] - tangent[k][i]).abs() <= 1e-9 * size);
                    let slope = (up.tension[i] - down.tension[i]) / (2.0 * step);
                    seen += 1;
                    // Where wrinkles begin or their direction jumps, a difference is not a slope.
                    off += usize::from((slope - tangent[i][k]).abs() > 1e-3 * size);
                }
            }
        }
        assert!(seen > 20_000, "law {number}: {seen}");
        assert!(off < seen / 200, "law {number}: {off} of {seen} are off");
    }
}

/// Wagner's shear panel (C6 of the design): pure shear γ leaves σ₁ = E γ/2 at 45°, so τ = σ₁/2.
#[test]
fn sheared_panel_carries_half_the_diagonal_tension() {
    let law = fabric(isotropic_shear(), 0.0);
    let shear = 0.01;
    let response = law.respond(&[0.0, 0.0, shear]);
    let diagonal = 4.31e4 * 0.5 * shear;
    assert!((response.tension[2] - 0.5 * diagonal).abs() < 1e-9 * diagonal);
}

/// Bias test (eq. 1 of paper P1): 1/E45 = 1/4 (1/E1 + 1/E2 − 2 ν/E1 + 1/G).
#[test]
fn bias_modulus_follows_the_shear_modulus() {
    let law = fabric(1e7, 0.0);
    let (e, nu, g) = (4.31e8, 0.14, 1e7);
    let expected = 4.0 / (2.0 / e - 2.0 * nu / e + 1.0 / g);
    // Uniaxial tension at 45°: find the strain by inverting the stiffness for tension T (1, 1, 1)/2.
    let t = 100.0;
    let k = law.stiffness;
    let normal = 0.5 * t / (k[0][0] + k[0][1]);
    let shear = 0.5 * t / k[2][2];
    let along = 0.5 * (normal + normal) + 0.5 * shear;
    let modulus = t / along / 1e-4;
    assert!(
        (modulus / expected - 1.0).abs() < 1e-3,
        "{modulus} {expected}"
    );
    assert!((modulus - 38.5e6).abs() < 0.1e6);
    assert_eq!(
        law.respond(&[normal, normal, shear]).state,
        FabricState::Taut
    );
}
