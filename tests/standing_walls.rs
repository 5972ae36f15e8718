//! Surfaces that stand still in the air of a device, which answers along their cut links by itself.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::checkpoint;
use ripstop::gpu::{AdapterChoice, Device, Tuning};
use ripstop::measure;
use ripstop::plan::{ClothPlacement, Placement, Plan, Stage};
use ripstop::simulation::Simulation;

use crate::engines::{Engine, air_on_a_device, needs_device, plain};
use crate::tolerances;

pub const SPHERE: &str = include_str!("../cases/sphere.toml");
const WING: &str = include_str!("../cases/ram-air-parachute.toml");

/// Steps from the release on that are compared.
const STEPS: u64 = 40;

/// Steps whose maps are counted.
pub const COUNTED: u64 = 256;

/// Bodies that stand: their case, variant, and changes.
pub type Scene = (&'static str, &'static str, &'static [&'static str]);

const STICKING: Scene = (SPHERE, "quick", &["coupling.scheme=\"links\""]);

/// Bodies with moment points beside them; the smallest shuts a cell in.
const SLIDING: Scene = (
    SPHERE,
    "quick",
    &[
        "coupling.scheme=\"links\"",
        "bodies.sphere.friction=\"none\"",
        "resolution.cells_per_diameter=absent",
        "resolution.cell_size_m=0.0125",
        "bodies.sphere.reference.moment_point_m=[0.22, 0.25, 0.1]",
        "bodies.smaller={position_m=[0.4, 0.3, 0.2], sphere={diameter_m=0.06}, friction=\"none\", reference={moment_point_m=[0.4, 0.1, 0.2]}}",
        "bodies.of_one_cell={position_m=[0.40625, 0.40625, 0.30625], sphere={diameter_m=0.015}, reference={moment_point_m=[0.4, 0.1, 0.2]}}",
        "resolution.operator=\"stabilised_regularised\"",
    ],
);

/// Open cells with ribs, in a box of finer cells: creases, two layers in a link, air that is all but shut in.
const OF_CELLS: Scene = (
    WING,
    "rigid",
    &[
        "resolution.cells_per_chord=12.0",
        "air.wind_tunnel.start_time_s=0.01",
        "time.end_s=0.2",
    ],
);

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, scene) in [
        ("sticking", STICKING),
        ("sliding", SLIDING),
        ("ram_air_wing", OF_CELLS),
    ] {
        trials.push(needs_device(
            format!("standing_walls::answered_on_a_device_as_by_a_host_{name}"),
            move || as_by_a_host(scene),
        ));
    }
    trials.push(needs_device(
        "standing_walls::a_device_answers_as_a_host_in_16_bits".to_owned(),
        || as_by_a_host_in_16_bits(SLIDING),
    ));
    for (name, scene) in [("bodies", SLIDING), ("ram_air_wing", OF_CELLS)] {
        trials.push(needs_device(
            format!("standing_walls::series_on_a_device_have_the_same_bits_{name}"),
            move || series(scene),
        ));
    }
    trials.extend([needs_device(
        "standing_walls::counts_on_a_device".to_owned(),
        counts,
    )]);
    trials.extend(plain("standing_walls::plans", plans));
    trials
}

pub fn plan_of(
    (text, variant, overrides): Scene,
    further: &[&str],
    placement: Placement,
) -> (case::Scene, Plan) {
    let choices = Choices {
        variant: Some(variant.to_owned()),
        overrides: (overrides.iter().chain(further))
            .map(|&pair| pair.to_owned())
            .collect(),
    };
    let case = case::parse("case", text, Path::new("."), &choices).unwrap();
    let plan = Plan::new(&case.scene, placement);
    (case.scene, plan)
}

fn new(scene: Scene, placement: Placement, device: Option<&Arc<Device>>) -> Simulation {
    let (scene, plan) = plan_of(scene, &[], placement);
    Simulation::new(scene, plan, device.cloned()).unwrap()
}

pub fn device(goes_ahead: bool) -> Arc<Device> {
    let tuning = Tuning {
        goes_ahead,
        ..Tuning::default()
    };
    Device::open_tuned(&AdapterChoice::Any, tuning).unwrap()
}

/// Just released.
pub fn released(scene: Scene, placement: Placement, device: Option<&Arc<Device>>) -> Simulation {
    let mut simulation = new(scene, placement, device);
    while !simulation.released() || !simulation.stands_together() {
        simulation.advance().unwrap();
    }
    simulation
}

/// Goes on by so many steps, after which alone somebody reads.
pub fn go_on(simulation: &mut Simulation, steps: u64) {
    let end = simulation.step_count() + steps;
    simulation.set_next_reading(end);
    while simulation.step_count() < end {
        simulation.advance().unwrap();
    }
    assert!(!simulation.is_ahead());
}

/// Forces, moments and the momentum box are those of the CPU's single precision, and the air keeps its mass as there.
pub fn as_by_a_host(scene: Scene) {
    let engines = [Engine::CpuF32, Engine::Gpu];
    compare(
        scene,
        engines,
        [tolerances::STANDING_WALLS, tolerances::STANDING_WALLS_MASS],
    );
}

/// The same of populations in 16 bits, which both round.
pub fn as_by_a_host_in_16_bits(scene: Scene) {
    let engines = [Engine::CpuF16, Engine::GpuF16];
    compare(scene, engines, tolerances::WALLS_IN_16_BITS);
}

fn compare(scene: Scene, engines: [Engine; 2], [of_forces, of_mass]: [f64; 2]) {
    let [by_host, on_device] = engines.map(Engine::plan_placement);
    let mut host = released(scene, by_host, None);
    let mut alone = released(scene, on_device, Some(&device(true)));
    assert!(alone.plan().answers_on_device());
    assert_eq!(host.step_count(), alone.step_count());
    go_on(&mut host, STEPS);
    go_on(&mut alone, STEPS);
    assert!(alone.cost().own_steps >= STEPS - 4);
    let [a, b] = [&mut host, &mut alone].map(|s| s.impulse_sample().unwrap().unwrap());
    let same = |what: &str, [a, b]: [DVec3; 2], scale: f64| {
        let off = (a - b).length() / scale;
        assert!(off < of_forces, "{what}: {off:e}");
    };
    let scale = a.markers.length();
    same("force", [a.markers, b.markers], scale);
    let boxes = [a.momentum_box, b.momentum_box].map(Option::unwrap);
    let off = (boxes[0] - boxes[1]).length() / scale;
    let of_box = tolerances::cut_momentum_box(Engine::Gpu).max(of_forces);
    assert!(off < of_box, "momentum box: {off:e}");
    for (a, b) in a.bodies.iter().zip(&b.bodies) {
        same("force on a body", [a.force, b.force], a.force.length());
        // Of a sphere about its centre it is noise.
        let moment = a.moment.length();
        if scene.2.iter().any(|key| key.contains("moment_point_m")) {
            assert!(moment > 0.01 * a.force.length(), "{a:?}");
            same("moment", [a.moment, b.moment], moment);
        }
    }
    let drags = [&host, &alone].map(|simulation| simulation.line_drag_n());
    assert_eq!(drags[0], drags[1]);
    let off = (a.mass_defect - b.mass_defect).abs();
    assert!(off < of_mass, "mass: {off:e}");
}

/// Impulses and moments, to the last bit.
fn bits(simulation: &mut Simulation) -> Vec<u64> {
    let impulses = simulation.impulse_sample().unwrap().unwrap();
    let of_bodies = (impulses.bodies.iter()).flat_map(|body| [body.force, body.moment]);
    [impulses.markers, impulses.momentum_box.unwrap()]
        .into_iter()
        .chain(of_bodies)
        .flat_map(|vector| vector.to_array().map(f64::to_bits))
        .collect()
}

/// The same bits whichever steps a device makes at once, or none, and where a run is resumed.
pub fn series(scene: Scene) {
    let placement = || air_on_a_device(ClothPlacement::Host);
    let mut one_by_one = released(scene, placement(), Some(&device(false)));
    go_on(&mut one_by_one, 60);
    assert_eq!(one_by_one.cost().own_steps, 0);
    let wanted = bits(&mut one_by_one);

    let own = device(true);
    let mut unbroken = released(scene, placement(), Some(&own));
    go_on(&mut unbroken, 20);
    let folder = tempfile::tempdir().unwrap();
    checkpoint::write(folder.path(), "test", |out| unbroken.save(out)).unwrap();
    let stored = checkpoint::open(folder.path(), "test").unwrap().reader;
    go_on(&mut unbroken, 40);
    assert!(unbroken.cost().own_steps > 50);
    assert!(bits(&mut unbroken) == wanted);

    let mut resumed = new(scene, placement(), Some(&own));
    resumed.restore(&stored).unwrap();
    for part in [2, 6, 32] {
        go_on(&mut resumed, part);
    }
    assert!(bits(&mut resumed) == wanted);
}

/// A series of steps asks for one map, and a step for less than two submissions. What the walls are goes to the device once.
fn counts() {
    let device = device(true);
    let placement = air_on_a_device(ClothPlacement::Host);
    let mut simulation = released(SLIDING, placement, Some(&device));
    go_on(&mut simulation, 20);
    let of = |simulation: &Simulation| {
        [Stage::ReadLinks, Stage::Bounce, Stage::FetchWallForces]
            .map(|stage| simulation.cost().of(stage).device)
    };
    let (of_stages, before) = (of(&simulation), device.work());
    go_on(&mut simulation, COUNTED);
    let now = of(&simulation);
    let [read, bounce, fetch] = [0, 1, 2].map(|stage| now[stage].since(&of_stages[stage]));
    let work = device.work().since(&before);
    assert!(32 * fetch.maps <= COUNTED, "{fetch:?}");
    assert!(10 * work.maps <= COUNTED, "{work:?}");
    assert!(work.submits < 2 * COUNTED, "{work:?}");
    assert_eq!(read.written_bytes, 0, "{read:?}");
    // Where the sums of a step go.
    assert_eq!(bounce.written_bytes, 32 * COUNTED, "{bounce:?}");
}

/// Whatever needs the host in a step keeps it.
fn plans() {
    let stands = |scene: Scene, further: &[&str], placement: Placement| {
        let (_, plan) = plan_of(scene, further, placement);
        let stages = |stage| plan.every(stage).is_some();
        if plan.answers_on_device() {
            assert!(stages(Stage::ReadLinks) && stages(Stage::Bounce));
            assert!(!stages(Stage::FetchLinks) && !stages(Stage::CollideAhead));
        }
        plan.answers_on_device()
    };
    let on_device = || air_on_a_device(ClothPlacement::Host);
    for scene in [STICKING, SLIDING, OF_CELLS] {
        assert!(stands(scene, &[], on_device()));
        assert!(!stands(scene, &[], Engine::CpuF32.plan_placement()));
    }
    for further in [
        "coupling.scheme=\"kernel\"",
        "bodies.sphere.friction=\"model\"",
    ] {
        let of_operator = ["resolution.operator=\"stabilised_regularised\"", further];
        assert!(!stands(STICKING, &of_operator, on_device()), "{further}");
    }
    let by_a_law = ["coupling.narrow_openings=\"law\""];
    assert!(!stands(OF_CELLS, &by_a_law, on_device()));
    let loose = ["structure.wing.tunnel.held=\"attachments\""];
    assert!(!stands(OF_CELLS, &loose, on_device()));
    // What is held everywhere is solved on no engine.
    for (further, solved) in [(&[][..], false), (&loose, true)] {
        let (scene, plan) = plan_of(OF_CELLS, further, Engine::CpuF32.plan_placement());
        assert_eq!(plan.every(Stage::SolveCloth).is_some(), solved);
        let columns = measure::history_columns(&scene);
        for name in ["solver_residual", "elastic_energy_j"] {
            assert_eq!(columns.iter().any(|c| c.name == name), solved, "{name}");
        }
        assert_eq!(plan.evaluations.is_some(), solved);
    }
    let says = |scene: Scene, further: &[&str]| {
        let (scene, plan) = plan_of(scene, further, on_device());
        let report = plan.report(&scene, &[], 1);
        report.contains("makes up to 64 of these steps without waiting for the host")
    };
    assert!(says(OF_CELLS, &[]) && says(STICKING, &[]) && !says(OF_CELLS, &loose));
}
