//! Fabric that meets itself: forces are the gradient of an energy and sum to nothing, a folded canopy opens without crossing itself, bits
//! repeat, impossible starts are refused.

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
    [
        plain("contact::gradient_is_that_of_the_energy", gradient),
        plain("contact::forces_and_moments_sum_to_nothing", balance),
        plain("contact::a_folded_canopy_opens_without_crossing", opening),
        plain("contact::same_bits_on_any_number_of_threads", threads),
        plain("contact::far_fabric_changes_no_bits", far_fabric),
        plain(
            "contact::a_restored_state_goes_on_with_the_same_bits",
            restored,
        ),
        plain("contact::impossible_starts_are_refused", refused),
        plain("contact::is_listed_and_kept_from_devices", listed),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-2,
    displacement_floor_m: 1e-7,
    evaluation_limit: 5_000,
    history: 5,
    refresh_every: Some(5),
    initial_hessian: InitialHessian::BlockJacobi,
};

pub fn fabric() -> Fabric {
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
pub fn two_sheets(divisions: [usize; 2], gap_m: f64, thickness_m: Option<f64>) -> Structure {
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

pub fn count_crossings(cloth: &Cloth) -> usize {
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
