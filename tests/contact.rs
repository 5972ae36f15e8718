//! Fabric that meets itself: forces are the gradient of an energy and sum to nothing, weight is carried, nothing passes through, a folded
//! canopy opens without crossing itself.

use std::time::Duration;

use glam::{DQuat, DVec3};
use libtest_mimic::Trial;
use ripstop::cloth::Structure;
use ripstop::cloth::contact::barrier::push;
use ripstop::cloth::contact::crossing::crossings;
use ripstop::cloth::contact::pairs::{Kind, Pair, Surface};
use ripstop::cloth::contact::{self, Contact, ContactFault};
use ripstop::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::geometry::parachute::gores::FlatCircular;
use ripstop::geometry::parachute::sewn::{Cut, Folding, LinePlaces};
use ripstop::geometry::parachute::{self, Rigging};
use ripstop::geometry::sheet::{self, FabricModel, SheetShape};
use ripstop::lines::Cable;
use ripstop::solve::lbfgs::Stop;

use crate::command_line::ripstop;
use crate::engines::plain;
use crate::sheets::noise;
use crate::tolerances::contact as tolerance;

pub fn trials() -> Vec<Trial> {
    let mut trials = [
        plain("contact::gradient_is_that_of_the_energy", gradient),
        plain("contact::forces_and_moments_sum_to_nothing", balance),
        plain("contact::a_sheet_carries_another", carried_sheet),
        plain(
            "contact::an_equilibrium_carries_too",
            carried_in_equilibrium,
        ),
        plain("contact::momentum_is_kept_and_energy_does_not_grow", impact),
        plain("contact::a_folded_canopy_opens_without_crossing", opening),
        plain("contact::same_bits_on_any_number_of_threads", threads),
        plain("contact::far_fabric_changes_no_bits", far_fabric),
        plain(
            "contact::a_restored_state_goes_on_with_the_same_bits",
            restored,
        ),
        plain("contact::impossible_starts_are_refused", refused),
        plain("contact::close_starts_are_not_under_stress", close_start),
        plain("contact::hostile_starts_stay_finite", hostile),
        plain("contact::is_listed_and_kept_from_devices", listed),
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

const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-2,
    displacement_floor_m: 1e-7,
    evaluation_limit: 5_000,
    history: 5,
    refresh_every: Some(5),
    initial_hessian: InitialHessian::BlockJacobi,
};

fn fabric() -> Fabric {
    Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 500.0,
        warp_modulus_pa: 4e6,
        weft_modulus_pa: 4e6,
        poisson_ratio: 0.2,
        shear_modulus_pa: 1.7e6,
        residual_stiffness: 1e-2,
        cubic_shear_compliance_1_pa3: None,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

/// Two level square sheets of 1 m, the second `gap_m` above the first and shifted, so that meshes do not coincide; the first is held.
fn two_sheets(divisions: [usize; 2], gap_m: f64, thickness_m: Option<f64>) -> Structure {
    let one = |divisions: usize, corner_m: DVec3| {
        let shape = SheetShape {
            size_m: [1.0, 1.0],
            divisions: [divisions, divisions],
            corner_m,
            across: DVec3::X,
            down: DVec3::Y,
        };
        sheet::build(&shape, &fabric(), FabricModel::Membrane).unwrap()
    };
    let mut both = one(divisions[0], DVec3::ZERO);
    both.held.fill(true);
    let above = one(divisions[1], DVec3::new(0.031, -0.022, gap_m));
    let first = both.node_count() as u32;
    both.positions_m.extend(&above.positions_m);
    both.masses_kg.extend(&above.masses_kg);
    both.held.extend(&above.held);
    both.triangles
        .extend(above.triangles.into_iter().map(|mut t| {
            t.nodes = t.nodes.map(|n| n + first);
            t
        }));
    both.contact = thickness_m.map(|thickness_m| Contact { thickness_m });
    both
}

fn canopy(rings: usize, ratio: f64, thickness_m: Option<f64>) -> Structure {
    let rigging = Rigging {
        cut: Cut::Circle(FlatCircular {
            nominal_area_m2: 0.78,
            gores: 8,
            rings,
        }),
        fabric: fabric(),
        belts: None,
        skirt_band: None,
        vent_band: None,
        vent_lines: None,
        line_places: LinePlaces::Seams,
        line_segments: 1,
        risers: None,
        tilt_rad: 0.0,
        lines: Cable::linear(4.42e-6, 462.0, 1e9),
        line_length_m: 0.75,
        line_slack_m: 0.0,
        confluence_m: DVec3::ZERO,
        folding: Folding {
            diameter_ratio: ratio,
            asymmetry: 0.0,
        },
        apex_guide_n_m: Some(1e4),
    };
    let mut structure = parachute::build(&rigging).unwrap().structure;
    structure.contact = thickness_m.map(|thickness_m| Contact { thickness_m });
    structure
}

fn count_crossings(cloth: &Cloth) -> usize {
    crossings(&Surface::new(&cloth.structure, 1e-3), &cloth.positions_m).len()
}

/// Random pairs of both kinds, nearest in faces, along edges and at corners, and nearly parallel edges.
fn close_pairs() -> Vec<(Pair, Vec<DVec3>)> {
    let mut random = noise(17);
    let mut pairs = Vec::new();
    for number in 0..200 {
        let kind = if number % 2 == 0 {
            Kind::NodeTriangle
        } else {
            Kind::EdgeEdge
        };
        let mut point = |scale: f64| DVec3::new(random(), random(), random()) * scale;
        let mut places: Vec<DVec3> = (0..4).map(|_| point(1.0)).collect();
        if number % 8 == 1 {
            // Nearly parallel: the factor of the barrier is at work.
            let along = places[1] - places[0];
            places[3] = places[2] + along + point(0.02);
        }
        let pair = Pair {
            kind,
            nodes: [0, 1, 2, 3],
            thickness_m: 1.5,
            parallel_m4: 1e-2,
        };
        if push(&pair, &places, 3.0).is_some_and(|p| p.gap_m > 0.05) {
            pairs.push((pair, places));
        }
    }
    assert!(pairs.len() > 100);
    pairs
}

fn gradient() {
    for (pair, places) in close_pairs() {
        let found = push(&pair, &places, 3.0).unwrap();
        let scale = found
            .gradient_n
            .iter()
            .map(|g| g.length())
            .fold(1e-3, f64::max);
        for node in 0..4 {
            for axis in 0..3 {
                let energy = |step: f64| {
                    let mut moved = places.clone();
                    moved[node][axis] += step;
                    push(&pair, &moved, 3.0).map_or(0.0, |p| p.energy_j)
                };
                let difference = (energy(1e-6) - energy(-1e-6)) / 2e-6;
                let error = (difference - found.gradient_n[node][axis]).abs() / scale;
                assert!(error < tolerance::GRADIENT, "{pair:?} {node}: {error:e}");
            }
        }
    }
}

fn balance() {
    for (pair, places) in close_pairs() {
        let found = push(&pair, &places, 3.0).unwrap();
        let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for (place, gradient) in places.iter().zip(found.gradient_n) {
            force += gradient;
            moment += place.cross(gradient);
        }
        let scale = found
            .gradient_n
            .iter()
            .map(|g| g.length())
            .fold(0.0, f64::max);
        assert!(force.length() <= tolerance::BALANCE * scale, "{force}");
        assert!(moment.length() <= tolerance::BALANCE * scale, "{moment}");
    }
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

/// A pleated canopy is opened by pressure. Without contact its gores pass through one another; with it no edge pierces a triangle at
/// any step.
fn opening() {
    let open = |thickness_m: Option<f64>| {
        let mut cloth = Cloth::new(canopy(8, 0.15, thickness_m));
        let input = StepInput {
            time_step_s: Some(5e-4),
            pressure: Pressure::Uniform(20.0),
            damping_1_s: 100.0,
            ..StepInput::default()
        };
        let mut most = 0;
        let mut closest: f64 = 1.0;
        for _ in 0..40 {
            let outcome = cloth.solve_cloth(&input, &SETTINGS);
            assert_ne!(outcome.stop, Stop::NotFinite);
            most = most.max(count_crossings(&cloth));
            if let Some(state) = cloth.contact_state() {
                closest = closest.min(state.smallest_gap_m);
            }
        }
        (most, closest)
    };
    let (crossed, _) = open(None);
    assert!(crossed > 10, "without contact: {crossed}");
    let (crossed, closest) = open(Some(2e-3));
    assert_eq!(crossed, 0);
    assert!(closest > 0.0 && closest < 2e-3, "{closest}");
}

/// Where a pressed canopy is after some steps.
fn pressed(cloth: &mut Cloth, steps: usize) -> Vec<u64> {
    let input = StepInput {
        time_step_s: Some(5e-4),
        pressure: Pressure::Uniform(20.0),
        damping_1_s: 100.0,
        ..StepInput::default()
    };
    for _ in 0..steps {
        cloth.solve_cloth(&input, &SETTINGS);
    }
    bits(cloth)
}

fn bits(cloth: &Cloth) -> Vec<u64> {
    let places = cloth.positions_m.iter().chain(&cloth.velocities_m_s);
    places
        .flat_map(|p| p.to_array())
        .map(f64::to_bits)
        .collect()
}

fn threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        // Enough edges and pairs to be shared among threads.
        pool.install(|| pressed(&mut Cloth::new(canopy(16, 0.15, Some(3e-3))), 6))
    };
    assert!(run(1) == run(2));
}

/// Contact that nothing comes near leaves every bit as it is without.
fn far_fabric() {
    let run = |thickness_m: Option<f64>| {
        let mut cloth = Cloth::new(two_sheets([4, 4], 0.5, thickness_m));
        let input = StepInput {
            time_step_s: Some(1e-3),
            gravity_m_s2: DVec3::new(0.0, 1.0, -9.81),
            ..StepInput::default()
        };
        for _ in 0..20 {
            cloth.solve_cloth(&input, &SETTINGS);
        }
        bits(&cloth)
    };
    assert!(run(None) == run(Some(1e-3)));
}

fn restored() {
    let structure = canopy(8, 0.15, Some(2e-3));
    let mut cloth = Cloth::new(structure.clone());
    pressed(&mut cloth, 25);
    let mut resumed = Cloth::new(structure);
    resumed.positions_m.clone_from(&cloth.positions_m);
    resumed.velocities_m_s.clone_from(&cloth.velocities_m_s);
    resumed.restore_contact_state(cloth.contact_state().unwrap().clone());
    assert!(cloth.contact_state().unwrap().energy_j > 0.0, "in contact");
    assert!(pressed(&mut cloth, 10) == pressed(&mut resumed, 10));
}

fn refused() {
    let contact = Contact { thickness_m: 5e-3 };
    let fault = |structure: &Structure| contact::check(structure, contact).unwrap_err();
    let mut crossed = two_sheets([5, 7], 0.02, None);
    let turn = DQuat::from_rotation_x(0.3);
    let middle = DVec3::new(0.5, 0.5, 0.0);
    for p in &mut crossed.positions_m[36..] {
        *p = middle + turn * (*p - middle);
    }
    assert!(matches!(fault(&crossed), ContactFault::Crossing { .. }));
    let touching = two_sheets([5, 7], 0.0, None);
    let ContactFault::Touching { gap_m, .. } = fault(&touching) else {
        panic!("{}", fault(&touching));
    };
    assert!(gap_m == 0.0);
    let fine = two_sheets([120, 7], 0.02, None);
    let ContactFault::TooThick { altitude_m, .. } = fault(&fine) else {
        panic!("{}", fault(&fine));
    };
    assert!(
        (altitude_m * 120.0 * 2f64.sqrt() - 1.0).abs() < 1e-9,
        "{altitude_m}"
    );
    assert!(contact::check(&two_sheets([5, 7], 0.02, None), contact).is_ok());
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

/// `check` says who searches and what is skipped without; a device is refused.
fn listed() {
    let with = ripstop(&["check", "cases/cloth/folded-gore.toml"]);
    assert!(
        with.printed.contains("where contact is searched for"),
        "{}",
        with.printed
    );
    let without = ripstop(&["check", "cases/cloth/hanging-sheet.toml"]);
    assert!(
        without.printed.contains("contact of fabric with itself"),
        "{}",
        without.printed
    );
    let device = ripstop(&["check", "cases/cloth/folded-gore.toml", "--cloth", "device"]);
    assert_eq!(device.code, 2);
    assert!(device.errors.contains("[contact]"), "{}", device.errors);
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
