//! Tests of the lanes against one triangle at a time.

use super::*;
use crate::cloth::SewnFabric;
use crate::fabric::shear::CubicShear;

/// More triangles than one thread takes, and not a whole number of blocks.
const COUNT: usize = ALONE + 3 * CHUNK + 5;

fn law(shear_n_m: f64, residual: f64) -> Membrane {
    let stiffness = [[4.4e4, 6e3, 0.0], [6e3, 4.4e4, 0.0], [0.0, 0.0, shear_n_m]];
    Membrane::new(stiffness, residual)
}

fn sewn(membrane: Membrane) -> SewnFabric {
    SewnFabric {
        membrane,
        thickness_m: 1e-4,
        yield_stress_pa: None,
    }
}

/// Between −1 and 1 (SplitMix64, Steele et al. 2014).
fn noise(number: usize) -> f64 {
    let mut x = (number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Triangles of all shapes that share nodes, of four fabrics of which one has a nonlinear shear law, and where their nodes are now.
fn patchwork(count: usize) -> (Structure, Vec<DVec3>) {
    let shear = CubicShear {
        compliance_m_n: 1e-3,
        cubic_m3_n3: 1e-7,
    };
    let mut structure = Structure {
        membrane: Some(law(1e3, 1e-3)),
        further_fabrics: vec![
            sewn(law(1.9e4, 0.0)),
            sewn(law(1e3, 0.1).with_shear(shear)),
            sewn(law(3e2, 1.0)),
        ],
        ..Structure::default()
    };
    structure.positions_m = (0..count + 2)
        .map(|k| {
            let row = (k % 2) as f64;
            DVec3::new(0.01 * k as f64, 0.02 * row + 0.003 * noise(k), 0.0)
        })
        .collect();
    for k in 0..count {
        let nodes = [k, k + 1, k + 2].map(|n| n as u32);
        let rest = nodes.map(|n| structure.positions_m[n as usize].truncate());
        let mut triangle = Triangle::new(nodes, rest).unwrap();
        // The first thousand are all of one fabric, the others mixed.
        let mixed = (noise(7 * k) * 4.0).abs() as u32 % 4;
        triangle.fabric = if k < 1000 { 0 } else { mixed };
        structure.triangles.push(triangle);
    }
    let positions = structure
        .positions_m
        .iter()
        .enumerate()
        .map(|(k, place)| {
            let size = [1e-6, 1e-4, 1e-3][k / 50 % 3];
            *place + size * DVec3::new(noise(3 * k), noise(3 * k + 1), noise(3 * k + 2))
        })
        .collect();
    (structure, positions)
}

fn evaluate_all(
    structure: &Structure,
    positions: &[DVec3],
    instructions: pulp::Arch,
) -> (f64, Vec<DVec3>) {
    let mut lanes = MembraneLanes::new(structure);
    lanes.instructions = instructions;
    // What lies there must not matter.
    let mut pulls = vec![DVec3::NAN; 7];
    let energy = lanes.pulls(structure, positions, &mut pulls);
    (energy, pulls)
}

#[test]
fn lanes_agree_with_one_triangle_at_a_time() {
    for count in [0, 1, 7, 8, 9, 65, CHUNK - 1, CHUNK, CHUNK + 1, COUNT] {
        let (structure, positions) = patchwork(count);
        let laws = structure.laws().unwrap();
        let (energy, pulls) = evaluate_all(&structure, &positions, pulp::Arch::new());
        assert_eq!(pulls.len(), 3 * count);
        let mut sum = 0.0;
        let mut states = [0; 3];
        for (triangle, pulls) in structure.triangles.iter().zip(pulls.chunks(3)) {
            let law = laws.of(triangle);
            let strain = triangle.strain(&triangle.edge_vectors(&positions));
            let state = law.respond(&strain).state;
            states[state as usize] += 1;
            let (expected, one) = triangle_pulls(law, triangle, &positions);
            sum += one;
            let size = strain.into_iter().map(f64::abs).fold(0.0, f64::max);
            let edge = triangle
                .rest_squares_m2
                .into_iter()
                .fold(0.0, f64::max)
                .sqrt();
            for (pull, expected) in pulls.iter().zip(expected) {
                let off = (*pull - expected).abs().max_element();
                assert!(off <= 1e-11 * 4.4e4 * size * edge, "{pull}, {expected}");
            }
        }
        assert!((energy - sum).abs() <= 1e-13 * sum, "{energy} {sum}");
        assert!(
            count < 1000 || states.iter().all(|&n| n > count / 50),
            "{states:?}"
        );
    }
}

/// The sets of instructions that this CPU has.
fn instruction_sets() -> Vec<pulp::Arch> {
    let mut sets = vec![pulp::Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        sets.extend(pulp::x86::V3::try_new().map(pulp::Arch::V3));
        sets.extend(pulp::x86::V4::try_new().map(pulp::Arch::V4));
    }
    sets.push(pulp::Arch::new());
    sets
}

#[test]
fn bits_depend_neither_on_the_instructions_nor_on_the_threads() {
    let (structure, positions) = patchwork(COUNT);
    let first = evaluate_all(&structure, &positions, pulp::Arch::Scalar);
    for instructions in instruction_sets() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let found = pool
                .build()
                .unwrap()
                .install(|| evaluate_all(&structure, &positions, instructions));
            assert!(found == first, "{instructions:?}, {threads} threads");
        }
    }
}

#[test]
fn not_a_number_reaches_the_energy() {
    for count in [1, 20] {
        for node in 0..count + 2 {
            let (structure, mut positions) = patchwork(count);
            positions[node].y = f64::NAN;
            let (energy, _) = evaluate_all(&structure, &positions, pulp::Arch::new());
            assert!(energy.is_nan());
        }
    }
}

/// All corners in one place, or on a line, or at rest: nothing is not a number.
#[test]
fn collapsed_triangles_have_finite_pulls() {
    let (structure, _) = patchwork(40);
    let rest = &structure.positions_m;
    for positions in [
        vec![DVec3::ZERO; rest.len()],
        rest.iter().map(|p| DVec3::X * p.x).collect(),
        rest.clone(),
    ] {
        let (energy, pulls) = evaluate_all(&structure, &positions, pulp::Arch::new());
        assert!(energy.is_finite() && energy >= 0.0);
        assert!(pulls.iter().all(|pull| pull.is_finite()));
    }
}

#[test]
fn fabric_with_a_nonlinear_shear_law_alone_is_evaluated_as_before() {
    let (mut structure, positions) = patchwork(CHUNK + 9);
    let cubic = structure.further_fabrics[1].membrane;
    structure.membrane = Some(cubic);
    structure.further_fabrics.clear();
    for triangle in &mut structure.triangles {
        triangle.fabric = 0;
    }
    let (energy, pulls) = evaluate_all(&structure, &positions, pulp::Arch::new());
    let mut sum = 0.0;
    for (triangle, pulls) in structure.triangles.iter().zip(pulls.chunks(3)) {
        let (expected, one) = triangle_pulls(&cubic, triangle, &positions);
        assert_eq!(pulls, expected);
        sum += one;
    }
    assert!((energy - sum).abs() <= 1e-13 * sum);
}

#[test]
fn structures_without_a_law_pull_nothing() {
    let (mut structure, positions) = patchwork(40);
    structure.membrane = None;
    let (energy, pulls) = evaluate_all(&structure, &positions, pulp::Arch::new());
    assert_eq!(energy, 0.0);
    assert!(
        pulls
            .iter()
            .all(|pull| *pull == DVec3::ZERO || pull.is_nan())
    );
}
