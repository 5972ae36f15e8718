//! Rigid bodies that move in the air of a device, which finds the links that they cut, and answers along them, by itself.

use libtest_mimic::Trial;
use ripstop::plan::{ClothPlacement, Placement, Stage};
use ripstop::simulation::Simulation;

use crate::engines::{Engine, air_on_a_device, needs_device, plain};
use crate::standing_walls::{COUNTED, SPHERE, Scene};
use crate::standing_walls::{
    as_by_a_host, as_by_a_host_in_16_bits, device, go_on, plan_of, released, series,
};

/// A sphere that drifts, and one that stands. Two vanes a third of a cell apart turn together: two layers in a link. A small sphere shuts a cell in, and a lid that moves through it presses its air
/// together.
const BODIES: Scene = (
    SPHERE,
    "quick",
    &[
        "coupling.scheme=\"links\"",
        "time.end_s=25.0",
        "resolution.cells_per_diameter=absent",
        "resolution.cell_size_m=0.0125",
        "bodies.sphere.motion.constant_velocity={velocity_m_s=[-0.004, 0.003, 0.002]}",
        "bodies.sphere.reference.moment_point_m=[0.22, 0.25, 0.1]",
        "bodies.smaller={position_m=[0.4, 0.3, 0.2], sphere={diameter_m=0.06}, reference={moment_point_m=[0.4, 0.1, 0.2]}}",
        "bodies.vane={position_m=[0.42, 0.2, 0.3], disk={diameter_m=0.1}, motion={constant_rotation={axis=[0.1, 1.0, 0.2], rate_rad_s=0.2, centre_m=[0.43, 0.21, 0.31]}}, reference={moment_point_m=[0.42, 0.1, 0.3]}}",
        "bodies.next_vane={position_m=[0.424, 0.2, 0.3], disk={diameter_m=0.1}, motion={constant_rotation={axis=[0.1, 1.0, 0.2], rate_rad_s=0.2, centre_m=[0.43, 0.21, 0.31]}}, reference={moment_point_m=[0.42, 0.1, 0.3]}}",
        "bodies.of_one_cell={position_m=[0.31875, 0.40625, 0.10625], sphere={diameter_m=0.015}, motion={oscillation={frequency_hz=0.1, displacement_m=[0.003, 0.003, 0.001]}}, reference={moment_point_m=[0.3, 0.1, 0.2]}}",
        "bodies.lid={position_m=[0.32325, 0.40625, 0.10625], disk={diameter_m=0.03}, motion={constant_velocity={velocity_m_s=[-0.002, 0.0, 0.0]}}, reference={moment_point_m=[0.3, 0.1, 0.2]}}",
    ],
);

/// A sphere that turns about an axis beside it, in a box of finer cells.
const IN_A_BOX: Scene = (
    SPHERE,
    "quick",
    &[
        "coupling.scheme=\"links\"",
        "air.refinement.around=\"structure\"",
        "air.wind_tunnel.size_m=[1.0, 0.8, 0.8]",
        "bodies.sphere.position_m=[0.42, 0.4, 0.4]",
        "bodies.sphere.motion.constant_rotation={axis=[0.0, 0.2, 1.0], rate_rad_s=0.1, centre_m=[0.42, 0.43, 0.4]}",
        "bodies.sphere.reference.moment_point_m=[0.42, 0.3, 0.4]",
    ],
);

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, scene) in [("bodies", BODIES), ("in_a_box", IN_A_BOX)] {
        trials.push(needs_device(
            format!("moving_walls::a_device_answers_as_a_host_{name}"),
            move || as_by_a_host(scene),
        ));
    }
    trials.extend([
        needs_device(
            "moving_walls::series_on_a_device_have_the_same_bits".to_owned(),
            || series(BODIES),
        ),
        needs_device("moving_walls::counts_of_a_device".to_owned(), counts),
        needs_device(
            "moving_walls::a_device_answers_as_a_host_in_16_bits".to_owned(),
            || as_by_a_host_in_16_bits(BODIES),
        ),
    ]);
    trials.extend(plain("moving_walls::plans", plans));
    trials
}

/// A series of steps asks for one map, and a step for less than two submissions. The host tells where nodes are, and nothing of the links.
fn counts() {
    let device = device(true);
    let placement = air_on_a_device(ClothPlacement::Host);
    let mut simulation = released(BODIES, placement, Some(&device));
    go_on(&mut simulation, 20);
    let of = |simulation: &Simulation| {
        [
            Stage::FindLinks,
            Stage::ReadLinks,
            Stage::Bounce,
            Stage::FetchWallForces,
        ]
        .map(|stage| simulation.cost().of(stage).device)
    };
    let (of_stages, before) = (of(&simulation), device.work());
    go_on(&mut simulation, COUNTED);
    let now = of(&simulation);
    let [find, read, bounce, fetch] = [0, 1, 2, 3].map(|stage| now[stage].since(&of_stages[stage]));
    let work = device.work().since(&before);
    assert!(32 * fetch.maps <= COUNTED, "{fetch:?}");
    assert!(10 * work.maps <= COUNTED, "{work:?}");
    assert!(work.submits < 2 * COUNTED, "{work:?}");
    assert_eq!(read.written_bytes, 0, "{read:?}");
    assert_eq!(bounce.written_bytes, 0, "{bounce:?}");
    // Parameters, 48 bytes of a node, and of fabric and each body the point of its moments.
    let surfaces = simulation.scene().rigid_bodies.iter();
    let nodes: usize = surfaces
        .map(|body| body.surface.positions_m.len() + 1)
        .sum();
    let each = 96 + 48 * (nodes as u64 + 1);
    let all = each * COUNTED;
    // And a word for each series.
    assert!((all..all + 64).contains(&find.written_bytes), "{find:?}");
}

/// Whatever needs the host in a step keeps it.
fn plans() {
    let alone = |further: &[&str], placement: Placement| {
        let (_, plan) = plan_of(BODIES, further, placement);
        let stages = |stage| plan.every(stage).is_some();
        if plan.answers_on_device() {
            assert!(stages(Stage::FindLinks) && stages(Stage::ReadLinks));
            assert!(!stages(Stage::FetchLinks) && !stages(Stage::CollideAhead));
        }
        plan.answers_on_device()
    };
    let on_device = || air_on_a_device(ClothPlacement::Host);
    assert!(alone(&[], on_device()));
    assert!(!alone(&[], Engine::CpuF32.plan_placement()));
    for further in [
        "bodies.smaller.friction=\"none\"",
        "bodies.smaller.friction=\"model\"",
        "bodies.vane.permeability={measured={pressures_pa=[124.5], air_speeds_m_s=[8.0]}}",
        "air.faces={y_lower=\"periodic\", y_upper=\"periodic\"}",
    ] {
        let further = ["resolution.operator=\"stabilised_regularised\"", further];
        assert!(!alone(&further, on_device()), "{further:?}");
    }
}
