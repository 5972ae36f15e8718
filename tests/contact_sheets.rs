//! Sheets that meet: weight is carried, momentum is kept, nothing passes through, whatever the start.

use std::time::Duration;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cloth::contact::{self, Contact};
use ripstop::cpu::cloth::{Cloth, InitialHessian, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::solve::lbfgs::Stop;

use crate::contact::{SETTINGS, count_crossings, fabric, two_sheets};
use crate::engines::plain;
use crate::sheets::noise;
use crate::tolerances::contact as tolerance;

pub fn trials() -> Vec<Trial> {
    let mut trials = [
        plain("contact::a_sheet_carries_another", carried_sheet),
        plain(
            "contact::an_equilibrium_carries_too",
            carried_in_equilibrium,
        ),
        plain("contact::momentum_is_kept_and_energy_does_not_grow", impact),
        plain("contact::close_starts_are_not_under_stress", close_start),
        plain("contact::hostile_starts_stay_finite", hostile),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>();
    for (time_step_s, speed_m_s) in [
        (1e-4, 5.0),
        (1e-3, 5.0),
        (5e-3, 5.0),
        (1e-4, 50.0),
        (1e-3, 50.0),
    ] {
        trials.extend(plain(
            &format!("contact::a_thrown_sheet_does_not_pass::dt_{time_step_s}_v_{speed_m_s}"),
            move || thrown(time_step_s, speed_m_s),
        ));
    }
    trials
}

/// Weight of the upper sheet [N], and what supports carry beyond the weight of the held one; smallest gap over thickness.
fn weights(cloth: &Cloth, input: &StepInput, held: usize) -> [f64; 3] {
    let g = -input.gravity_m_s2.z;
    let upper: f64 = cloth.structure.masses_kg[held..].iter().sum::<f64>() * g;
    let lower: f64 = cloth.structure.masses_kg[..held].iter().sum::<f64>() * g;
    let carried: f64 = cloth.reactions_n(input).iter().map(|(_, f)| f.z).sum();
    let state = cloth.contact_state().unwrap();
    let thickness = cloth.structure.contact.unwrap().thickness_m;
    [upper, carried - lower, state.smallest_gap_m / thickness]
}

/// A sheet laid down by gravity on a held one comes to rest above it, and its weight is what the supports of the other feel.
fn carried_sheet() {
    let mut cloth = Cloth::new(two_sheets([5, 7], 4e-3, Some(5e-3)));
    let held = 36;
    let input = StepInput {
        time_step_s: Some(2e-3),
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        damping_1_s: 50.0,
        ..StepInput::default()
    };
    let settings = SolverSettings {
        tolerance: 1e-4,
        ..SETTINGS
    };
    for _ in 0..200 {
        let outcome = cloth.solve_cloth(&input, &settings);
        assert_eq!(outcome.stop, Stop::Converged);
        assert_eq!(count_crossings(&cloth), 0);
    }
    let [upper, carried, gap] = weights(&cloth, &input, held);
    assert!(
        (carried / upper - 1.0).abs() < tolerance::WEIGHT,
        "{carried} of {upper}"
    );
    assert!(gap > 0.0 && gap < 1.0, "{gap}");
    assert!(cloth.contact_time() > Duration::ZERO);
}

/// The same by Newton's method with multigrid, without motion.
fn carried_in_equilibrium() {
    let structure = two_sheets([5, 7], 4e-3, Some(5e-3));
    let input = StepInput {
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        ..StepInput::default()
    };
    for residual in [1e-2, 0.5] {
        let mut structure = structure.clone();
        let soft = Fabric {
            residual_stiffness: residual,
            ..fabric()
        };
        // Below a tenth Newton's method drives, above L-BFGS.
        structure.membrane = Some(soft.membrane());
        let mut cloth = Cloth::new(structure);
        let settings = SolverSettings {
            tolerance: 1e-4,
            displacement_floor_m: 0.0,
            refresh_every: Some(10),
            initial_hessian: InitialHessian::Multigrid,
            ..SETTINGS
        };
        let outcome = cloth.solve_cloth(&input, &settings);
        assert_eq!(outcome.stop, Stop::Converged, "{residual} {outcome:?}");
        assert_eq!(count_crossings(&cloth), 0);
        let [upper, carried, gap] = weights(&cloth, &input, 36);
        assert!(
            (carried / upper - 1.0).abs() < tolerance::WEIGHT,
            "{carried} of {upper}"
        );
        assert!(gap > 0.0 && gap < 1.0, "{gap}");
    }
}

/// Highest node of the lower sheet must stay below the upper sheet over it: no crossing at any step, and the upper middle ends above.
fn thrown(time_step_s: f64, speed_m_s: f64) {
    let throw = |thickness_m: Option<f64>| {
        let mut structure = two_sheets([5, 4], 0.05, thickness_m);
        structure.held.fill(false);
        for border in 0..36 {
            let (i, j) = (border % 6, border / 6);
            structure.held[border] = i == 0 || j == 0 || i == 5 || j == 5;
        }
        let mut cloth = Cloth::new(structure);
        for v in &mut cloth.velocities_m_s[36..] {
            *v = DVec3::new(0.0, 0.0, -speed_m_s);
        }
        let input = StepInput {
            time_step_s: Some(time_step_s),
            ..StepInput::default()
        };
        let settings = SolverSettings {
            displacement_floor_m: 1e-5,
            ..SETTINGS
        };
        let steps = (0.1 / speed_m_s / time_step_s).ceil() as usize + 3;
        let mut crossed = 0;
        for _ in 0..steps {
            let outcome = cloth.solve_cloth(&input, &settings);
            assert_ne!(outcome.stop, Stop::NotFinite);
            crossed += count_crossings(&cloth);
        }
        let height = |nodes: std::ops::Range<usize>| {
            let count = nodes.len() as f64;
            cloth.positions_m[nodes].iter().map(|p| p.z).sum::<f64>() / count
        };
        (crossed, height(36..61) - height(0..36))
    };
    let (crossed, above) = throw(Some(2e-3));
    assert_eq!(crossed, 0);
    assert!(above > 0.0, "{above}");
    let (_, through) = throw(None);
    assert!(through < 0.0, "without contact it is through: {through}");
}

/// Two free sheets collide in free motion: linear momentum stays, angular momentum nearly, and the energy never grows.
fn impact() {
    let mut structure = two_sheets([4, 3], 0.02, Some(3e-3));
    structure.held.fill(false);
    let mut cloth = Cloth::new(structure);
    for v in &mut cloth.velocities_m_s[25..] {
        *v = DVec3::new(0.3, 0.0, -4.0);
    }
    let input = StepInput {
        time_step_s: Some(5e-4),
        ..StepInput::default()
    };
    let settings = SolverSettings {
        displacement_floor_m: 1e-10,
        evaluation_limit: 20_000,
        ..SETTINGS
    };
    let before = cloth.momentum_kg_m_s();
    let energy = |cloth: &Cloth| {
        let mut forces = vec![DVec3::ZERO; cloth.structure.node_count()];
        let gather = ripstop::cpu::cloth::gather::Gather::new(&cloth.structure);
        let elastic = ripstop::cpu::cloth::nodal_forces::elastic_gradient(
            &cloth.structure,
            &gather,
            &cloth.positions_m,
            &mut ripstop::cpu::cloth::nodal_forces::Pulls::default(),
            &mut forces,
        );
        cloth.kinetic_energy_j() + elastic + cloth.contact_state().unwrap().energy_j
    };
    let mut last = energy(&cloth);
    let first = last;
    let mut met = false;
    for step in 0..40 {
        let outcome = cloth.solve_cloth(&input, &settings);
        assert_eq!(outcome.stop, Stop::Converged, "{step} {outcome:?}");
        let now = energy(&cloth);
        assert!(
            now <= last + tolerance::ENERGY * first,
            "{step}: {last} -> {now}"
        );
        last = now;
        let state = cloth.contact_state().unwrap();
        met |= state.energy_j > 0.0;
        let sum: DVec3 = state.forces_n.iter().sum();
        let largest = state
            .forces_n
            .iter()
            .map(|f| f.length())
            .fold(0.0, f64::max);
        assert!(sum.length() <= 1e-12 * largest.max(1e-300), "{sum}");
    }
    assert!(met, "the sheets met");
    let lost = (cloth.momentum_kg_m_s() - before).length() / before.length();
    assert!(lost < tolerance::MOMENTUM, "{lost:e}");
}

/// Sheets that start closer than the thickness stay where they are, and push when they come closer.
fn close_start() {
    let mut cloth = Cloth::new(two_sheets([5, 7], 1e-3, Some(5e-3)));
    let start = cloth.positions_m.clone();
    let input = StepInput {
        time_step_s: Some(1e-3),
        ..StepInput::default()
    };
    cloth.solve_cloth(&input, &SETTINGS);
    let moved = cloth
        .positions_m
        .iter()
        .zip(&start)
        .map(|(a, b)| a.distance(*b));
    assert!(moved.fold(0.0, f64::max) < 1e-9);
    let heavy = StepInput {
        gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
        damping_1_s: 50.0,
        ..input
    };
    for _ in 0..100 {
        cloth.solve_cloth(&heavy, &SETTINGS);
        assert_eq!(count_crossings(&cloth), 0);
    }
    let gap = cloth.contact_state().unwrap().smallest_gap_m;
    assert!(gap > 0.0 && gap < 1e-3, "{gap}");
}

/// Crumpled sheets that do not cross themselves, stiff and soft, in long and short steps: finite, and uncrossed.
fn hostile() {
    let mut random = noise(23);
    for (modulus, time_step_s) in [(1e4, 1e-2), (1e8, 1e-2), (1e4, 1e-5), (1e8, 1e-4)] {
        let mut structure = two_sheets([6, 6], 3e-2, Some(1e-2));
        let stiff = Fabric {
            warp_modulus_pa: modulus,
            weft_modulus_pa: modulus,
            shear_modulus_pa: 0.4 * modulus,
            ..fabric()
        };
        structure.membrane = Some(stiff.membrane());
        structure.held.fill(false);
        for p in &mut structure.positions_m {
            *p += DVec3::new(random(), random(), 0.0) * 0.04 + DVec3::Z * random() * 2e-3;
            p.z += 0.2 * p.x * p.y;
        }
        contact::check(&structure, Contact { thickness_m: 1e-2 }).unwrap();
        let mut cloth = Cloth::new(structure);
        for v in &mut cloth.velocities_m_s {
            *v = DVec3::new(random(), random(), random()) * 20.0;
        }
        let input = StepInput {
            time_step_s: Some(time_step_s),
            gravity_m_s2: DVec3::new(0.0, 0.0, -9.81),
            ..StepInput::default()
        };
        let settings = SolverSettings {
            evaluation_limit: 300,
            ..SETTINGS
        };
        for _ in 0..10 {
            let outcome = cloth.solve_cloth(&input, &settings);
            assert_ne!(outcome.stop, Stop::NotFinite, "{modulus} {time_step_s}");
            assert!(cloth.positions_m.iter().all(|p| p.is_finite()));
            assert_eq!(count_crossings(&cloth), 0, "{modulus} {time_step_s}");
        }
    }
}
