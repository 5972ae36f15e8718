//! What single nodes have beside: masses, loads, velocities, supports; springs between nodes; pre-tension; several meshes in one structure.

use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::plan::{Plan, Precision};
use ripstop::run::without_files;
use ripstop::simulation::Simulation;

use crate::engines::plain;
use crate::tolerances::nodes;

pub fn trials() -> Vec<Trial> {
    [
        plain("nodes::a_load_stretches_a_spring", spring),
        plain("nodes::a_flung_weight_swings_as_a_pendulum", slung_weight),
        plain("nodes::a_baton_turns", baton),
        plain("nodes::a_point_does_not_turn", point),
        plain("nodes::a_string_sounds_as_its_tension_says", string),
        plain("nodes::a_strip_between_two_sides_is_stretched", strip),
        plain("nodes::meshes_hang_beside_each_other", two_meshes),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn parse(source: &str, folder: &Path) -> Case {
    case::parse("nodes", source, folder, &Choices::default()).unwrap()
}

fn run(source: &str) -> Simulation {
    let case = parse(source, Path::new("."));
    moved_or_at_rest(&case)
}

/// After its motion, or in its equilibrium.
fn moved_or_at_rest(case: &Case) -> Simulation {
    let plan = Plan::new(&case.scene, Precision::F64);
    if case.scene.equilibrium.is_none() {
        return without_files(case, plan, None).unwrap().0;
    }
    let mut simulation = Simulation::new(case.scene.clone(), plan, None).unwrap();
    let outcome = simulation.equilibrate(&mut |_| true).unwrap().unwrap();
    assert!(outcome.stop.reached(), "{outcome:?}");
    simulation
}

/// A loose rope whose middle hangs on a spring: with a load it is stretched by load and weight over its stiffness.
fn spring() {
    let simulation = run(r#"
version = 1

[structure.cable]
ends_m = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0]]
length_m = 3.0
segments = 4
material = { area_m2 = 1e-6, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e9 }

[nodes.top]
nodes = [5]
held = true

[nodes.others]
nodes = [1, 4]
held = true

[nodes.weight]
nodes = [3]
load_n = [0.0, 0.0, -30.0]
mass_kg = 2.0

[springs.first]
nodes = [3, 5]
stiffness_n_m = 400.0
rest_length_m = 1.0

[gravity]
acceleration_m_s2 = [0.0, 0.0, -10.0]

[equilibrium]
tolerance = 1e-6
evaluation_limit = 5000
"#);
    let cloth = simulation.cloth().unwrap();
    // The rope beside it is slack or not; what the spring carries and what the cables carry together bear the load.
    let [x, top] = [cloth.positions_m[2], cloth.positions_m[4]];
    let spring_n = 400.0 * (x.distance(top) - 1.0).max(0.0) * (top - x).normalize();
    let cables: DVec3 = (0..cloth.structure.cables.len())
        .filter_map(|k| {
            let [a, b] = cloth.structure.cables[k].nodes;
            let other = match (a, b) {
                (2, b) => b,
                (a, 2) => a,
                _ => return None,
            };
            let way = cloth.positions_m[other as usize] - x;
            Some(way.normalize() * cloth.cable_tension_n(k))
        })
        .sum();
    let mass_kg = cloth.structure.masses_kg[2];
    assert!(mass_kg > 2.0 && mass_kg < 2.01, "{mass_kg}");
    let left_n = spring_n + cables + DVec3::Z * (-30.0 - 10.0 * mass_kg);
    assert!(spring_n.length() > 5.0, "{spring_n}");
    assert!(
        left_n.length() < nodes::BALANCE_N,
        "{left_n} N of {spring_n}"
    );
}

/// The shipped case: a weight on a rope that is flung at 3 m/s rises by v²/2g at most, and its energy stays.
fn slung_weight() {
    let source = include_str!("../cases/cloth/slung-weight.toml");
    let case = parse(source, Path::new("cases/cloth"));
    let plan = Plan::new(&case.scene, Precision::F64);
    let steps = plan.steps.min(320);
    let mut simulation = Simulation::new(case.scene, plan, None).unwrap();
    let weight = 20;
    let mut highest = f64::NEG_INFINITY;
    let mut crossings = Vec::new();
    let mut before = 0.0;
    for step in 0..steps {
        simulation.advance().unwrap();
        let place = simulation.cloth().unwrap().positions_m[weight];
        highest = f64::max(highest, place.z);
        if step > 10 && place.x * before < 0.0 {
            crossings.push(step as f64 - place.x / (place.x - before));
        }
        before = place.x;
    }
    // A rope of 20 g beside a weight of 500 g takes part: some per cent less.
    let rise = 9.0 / (2.0 * 9.81);
    println!("rises to {:.4} of v²/2g", highest / rise);
    assert!(
        (1.0 - nodes::BESIDE_A_ROPE[0]..1.0).contains(&(highest / rise)),
        "{highest} of {rise} m"
    );
    // Half a swing of a pendulum of amplitude φ: π √(l/g) (1 + φ²/16).
    let angle = (1.0 - rise / 2.0_f64).acos();
    let half_s = 0.5 * TAU * (2.0 / 9.81_f64).sqrt() * (1.0 + angle * angle / 16.0);
    let found_s = crossings[0] * 0.005;
    println!("half a swing {:.4} of a pendulum's", found_s / half_s);
    assert!(
        (found_s / half_s - 1.0).abs() < nodes::BESIDE_A_ROPE[1],
        "{found_s} {half_s}"
    );
    let energies = simulation.energies().unwrap();
    let put_in_j = 0.5 * 0.5 * 9.0;
    println!("lost {:.4}", energies.numerical_loss_j / put_in_j);
    assert!(
        energies.numerical_loss_j.abs() < nodes::BESIDE_A_ROPE[2] * put_in_j,
        "{energies:?}"
    );
}

/// A rope with both ends free, thrown and turning: its middle flies straight, and it turns on.
fn baton() {
    let simulation = run(r#"
version = 1

[structure.cable]
ends_m = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
pretension_n = 0.5
segments = 8
material = { area_m2 = 1e-5, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e8 }

[nodes.ends]
nodes = [1, 9]
held = false
mass_kg = 1.0

[nodes.all]
box_m = [[-1.1, -0.1, -0.1], [1.1, 0.1, 0.1]]
velocity_m_s = [0.0, 1.0, 0.0]
angular_velocity_rad_s = [0.0, 0.0, 2.0]

[solver]
tolerance = 1e-6

[time]
end_s = 1.5
step_s = 0.005
"#);
    let cloth = simulation.cloth().unwrap();
    let structure = &cloth.structure;
    let mass: f64 = structure.masses_kg.iter().sum();
    let middle: DVec3 = cloth
        .positions_m
        .iter()
        .zip(&structure.masses_kg)
        .map(|(x, m)| *x * *m)
        .sum::<DVec3>()
        / mass;
    assert!(
        (middle - DVec3::Y * 1.5).length() < nodes::BATON[0],
        "{middle}"
    );
    let arm = cloth.positions_m[8] - cloth.positions_m[0];
    let angle = arm.y.atan2(arm.x);
    // Turned by 3 rad.
    println!("turned by {angle} rad, middle {middle}");
    assert!((angle - 3.0).abs() < nodes::BATON[1], "{angle}");
}

/// Nodes turn about their middle, which a single one stands in.
fn point() {
    let source = r#"
version = 1

[structure.cable]
ends_m = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
length_m = 2.5
segments = 8
material = { area_m2 = 1e-5, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e8 }

[nodes.one]
nodes = [5]
angular_velocity_rad_s = [0.0, 0.0, 2.0]

[time]
end_s = 1.5
step_s = 0.005
"#;
    let parsed = |source: &str| case::parse("nodes", source, Path::new("."), &Choices::default());
    let refused = format!("{:?}", parsed(source).unwrap_err());
    assert!(
        refused.contains("nodes.one.angular_velocity_rad_s"),
        "{refused}"
    );
    parsed(&source.replace("nodes = [5]", "nodes = [5, 6]")).unwrap();
}

/// A string in tension, plucked: f = √(T/μ)/(2 l).
fn string() {
    const SEGMENTS: usize = 20;
    let source = r#"
version = 1

[structure.cable]
ends_m = [[0.0, 0.0, 0.0], [0.8, 0.0, 0.0]]
pretension_n = 60.0
segments = 20
material = { area_m2 = 1e-6, density_kg_m3 = 7800.0, youngs_modulus_pa = 2e11 }

[nodes.middle]
at_m = [0.4, 0.0, 0.0]
load_n = [0.0, 0.0, 0.1]

[solver]
tolerance = 1e-7

[time]
end_s = 0.05
step_s = 5e-5
"#;
    let case = parse(source, Path::new("."));
    let structure = &case.scene.body.as_ref().unwrap().structure;
    let cable = structure.cables[0];
    let tension_n = structure
        .cable_state(&cable, 0.8 / SEGMENTS as f64)
        .tension_n;
    assert!(
        (tension_n / 60.0 - 1.0).abs() < nodes::PRETENSION,
        "{tension_n}"
    );
    let plan = Plan::new(&case.scene, Precision::F64);
    let steps = plan.steps;
    let mut simulation = Simulation::new(case.scene, plan, None).unwrap();
    // Under a load that comes at once the middle swings about its new place, F l/(4 T).
    let (mut sum, mut ways) = (0.0, Vec::new());
    for _ in 0..steps {
        simulation.advance().unwrap();
        ways.push(simulation.cloth().unwrap().positions_m[SEGMENTS / 2].z);
        sum += ways[ways.len() - 1];
    }
    let mean = sum / steps as f64;
    let crossings: Vec<f64> = ways
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < mean && pair[1] >= mean)
        .map(|(i, pair)| i as f64 + (mean - pair[0]) / (pair[1] - pair[0]))
        .collect();
    let period_s =
        (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64 * 5e-5;
    let exact_s = 2.0 * 0.8 / (60.0 / (7800.0 * 1e-6_f64)).sqrt();
    assert!(
        (period_s / exact_s - 1.0).abs() < nodes::STRING[0],
        "{period_s} {exact_s}"
    );
    let still = 0.1 * 0.8 / (4.0 * 60.0);
    assert!(
        (mean / still - 1.0).abs() < nodes::STRING[1],
        "{mean} {still}"
    );
}

/// E ε of a strip that is stretched by two per cent between its sides, and narrows as it likes.
fn strip() {
    let simulation = run(r#"
version = 1

[structure.sheet]
size_m = [2.0, 0.1]
divisions = [80, 4]
model = "membrane"
corner_m = [0.0, 0.0, 0.0]
held = "sides"
hung_width_m = 2.04

[fabric]
thickness_m = 1e-4
density_kg_m3 = 500.0
youngs_modulus_pa = 1e8
poisson_ratio = 0.3

[equilibrium]
tolerance = 1e-5
evaluation_limit = 5000
"#);
    let frame = simulation.structure_frame().structure.unwrap();
    let middle = frame.triangles.iter().position(|t| {
        t.iter()
            .all(|&n| (0.95..1.1).contains(&frame.positions_m[n as usize].x))
    });
    let tension_n_m = frame.principal_tensions_n_m[middle.unwrap()][0];
    let at = middle.unwrap();
    // Cloth that is longer and, by Poisson's ratio, narrower: the true stress is so much larger.
    let thinner = frame.true_stress_pa[at] / frame.stress_pa[at];
    let area = 1.02 * (1.0 - 2.0 * 0.3 * 0.5 * (1.02_f64.powi(2) - 1.0)).sqrt();
    assert!(
        (thinner / area - 1.0).abs() < nodes::STRIP[1],
        "{thinner} {area}"
    );
    // Second Piola–Kirchhoff E h ε_Green, per present width: λ over the width that Poisson's ratio leaves.
    let green = 0.5 * (1.02_f64.powi(2) - 1.0);
    let width = (1.0 - 2.0 * 0.3 * green).sqrt();
    let exact = 1e8 * 1e-4 * green * 1.02 / width;
    println!(
        "strip: tension {:.5}, thinning {:.6} of exact",
        tension_n_m / exact,
        thinner / area
    );
    assert!(
        (tension_n_m / exact - 1.0).abs() < nodes::STRIP[0],
        "{tension_n_m} {exact}"
    );
}

/// Two sheets from one file, held alike, of which one is twice as stiff: each hangs as if it were alone.
fn two_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = String::new();
    for j in 0..3 {
        for i in 0..3 {
            obj += &format!("v {} {} 0\n", 0.5 * f64::from(i), 0.5 * f64::from(j));
        }
    }
    for j in 0..2 {
        for i in 0..2 {
            let first = 3 * j + i + 1;
            obj += &format!("f {} {} {}\n", first, first + 1, first + 4);
            obj += &format!("f {} {} {}\n", first, first + 4, first + 3);
        }
    }
    std::fs::write(folder.path().join("sheet.obj"), obj).unwrap();
    let source = r#"
version = 1

[structure.mesh]
file = "sheet.obj"
scale = 1.0
held_nodes = [1, 3, 7, 9]

[structure.mesh.further.stiff]
file = "sheet.obj"
scale = 1.0
held_nodes = [1, 3, 7, 9]
position_m = [0.0, 0.0, 2.0]
fabric = { thickness_m = 1e-4, density_kg_m3 = 500.0, youngs_modulus_pa = 8e7, poisson_ratio = 0.3 }

[fabric]
thickness_m = 1e-4
density_kg_m3 = 500.0
youngs_modulus_pa = 1e7
poisson_ratio = 0.3

[gravity]
acceleration_m_s2 = [0.0, 0.0, -9.81]

[equilibrium]
tolerance = 1e-6
evaluation_limit = 5000
"#;
    let case = parse(source, folder.path());
    assert_eq!(case.scene.meshes.len(), 2);
    let simulation = moved_or_at_rest(&case);
    let cloth = simulation.cloth().unwrap();
    assert_eq!(cloth.structure.node_count(), 18);
    let [soft, stiff] = [-cloth.positions_m[4].z, 2.0 - cloth.positions_m[13].z];
    // Of a membrane the sag goes with the cube root of load over stiffness.
    let ratio = soft / stiff;
    println!("sags: ratio {ratio}");
    assert!((ratio - 2.0).abs() < nodes::SAGS, "{soft} {stiff}");
}
