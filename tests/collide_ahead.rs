//! Cells that a device takes a step ahead, while the host works on the structure: nothing of a run may show it.

use std::path::Path;
use std::sync::Arc;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::gpu::{AdapterChoice, Device, Tuning};
use ripstop::lattice::Storage;
use ripstop::plan::{AirPlacement, ClothPlacement, Placement, Plan, Stage};
use ripstop::simulation::Simulation;

use crate::engines::{needs_device, plain};

/// Cells ahead are left out before a step that is timed, one in 31, and before looks at the air.
const STEPS: u64 = 30;

/// Steps in which a device learns how long a step takes.
const LEARNING: u64 = 20;

const MARKERS: &str = include_str!("../benches/uniform-canopy.toml");
const LINKS: &str = include_str!("../cases/flat-circular-tunnel.toml");
const SPHERE: &str = include_str!("../cases/sphere.toml");

/// A sphere that stands still, for whose boundary layers the host works in every step.
const WITH_LAYERS: [&str; 3] = [
    "coupling.scheme=links",
    "bodies.sphere.friction=model",
    "resolution.operator=stabilised_regularised",
];

/// The canopy that cuts links in a small tunnel of equal cells.
pub const SMALL_TUNNEL: [&str; 5] = [
    "air.refinement.around=\"nothing\"",
    "air.wind_tunnel.size_m=[2.991, 1.9, 1.9]",
    "air.wind_tunnel.sponge_length_m=0.4",
    "structure.flat_circular.confluence_m=[1.0, 0.95, 0.95]",
    "resolution.cells_per_diameter=8.0",
];

pub fn trials() -> Vec<Trial> {
    let trial = |name: &str, scene: Scene| {
        needs_device(format!("collide_ahead::{name}_on_a_device"), move || {
            same_bits(&scene);
        })
    };
    let canopy = |case, overrides: &[&'static str]| Scene {
        case,
        variant: None,
        overrides: [
            "air.wind_tunnel.start_time_s=0.001",
            "structure.flat_circular.rings=8",
            "time.end_s=0.1",
        ]
        .iter()
        .chain(overrides)
        .copied()
        .collect(),
        cloth: ClothPlacement::Host,
        storage: Storage::F32,
    };
    let sphere = |overrides: &[&'static str]| Scene {
        case: SPHERE,
        variant: Some("quick"),
        overrides: overrides.to_vec(),
        cloth: ClothPlacement::Host,
        storage: Storage::F32,
    };
    let mut trials = vec![
        trial(
            "markers",
            canopy(MARKERS, &["resolution.cells_per_diameter=10.0"]),
        ),
        trial(
            "markers_of_fabric_solved_in_every_second_step",
            canopy(
                MARKERS,
                &[
                    "resolution.cells_per_diameter=10.0",
                    "coupling.structure_every=2",
                ],
            ),
        ),
        trial(
            "markers_in_air_of_16_bits",
            Scene {
                storage: Storage::F16,
                ..canopy(MARKERS, &["resolution.cells_per_diameter=10.0"])
            },
        ),
        trial("cut_links", canopy(LINKS, &SMALL_TUNNEL)),
        trial(
            "cut_links_with_fabric",
            Scene {
                cloth: ClothPlacement::Device,
                ..canopy(LINKS, &SMALL_TUNNEL)
            },
        ),
        trial(
            "boxes_of_finer_cells",
            canopy(LINKS, &["resolution.cells_per_diameter=12.0"]),
        ),
        trial("markers_of_a_body", sphere(&[])),
        trial("a_body_along_which_air_slides", sphere(&WITH_LAYERS)),
        needs_device(
            "collide_ahead::what_cannot_be_read_on_a_device".to_owned(),
            unreadable,
        ),
    ];
    trials.extend(plain("collide_ahead::plans", plans));
    trials
}

/// A case, how it is changed, and where its fabric is.
#[derive(Clone)]
struct Scene {
    case: &'static str,
    variant: Option<&'static str>,
    overrides: Vec<&'static str>,
    cloth: ClothPlacement,
    storage: Storage,
}

impl Scene {
    fn parsed(&self) -> case::Case {
        let choices = Choices {
            variant: self.variant.map(str::to_owned),
            overrides: self.overrides.iter().map(|&pair| pair.to_owned()).collect(),
        };
        case::parse("case", self.case, Path::new("."), &choices).unwrap()
    }

    fn placement(&self, device: Option<&Device>) -> Placement {
        Placement {
            air: AirPlacement::Gpu(self.storage),
            cloth: self.cloth,
            device: device.map(|device| device.info().name.clone()),
            shared_memory: true,
        }
    }

    /// Just released, its device knowing how long a step takes.
    fn released(&self, goes_ahead: bool) -> Simulation {
        let tuning = Tuning {
            goes_ahead,
            ..Tuning::default()
        };
        let device = Device::open_tuned(&AdapterChoice::Any, tuning).unwrap();
        let case = self.parsed();
        let plan = Plan::new(&case.scene, self.placement(Some(&device)));
        let steps = plan.start_steps + LEARNING;
        let mut simulation =
            Simulation::new(case.scene.clone(), plan, Some(Arc::clone(&device))).unwrap();
        while simulation.step_count() < steps || !simulation.stands_together() {
            simulation.advance().unwrap();
        }
        simulation
    }
}

/// All that can be read of the air, of the fabric, and of the forces.
fn state(simulation: &mut Simulation) -> String {
    let air = simulation.air().unwrap();
    let mut text = String::new();
    let mut levels = vec![air];
    while let Some(level) = levels.pop() {
        text += &format!("{:?}\n", level.engine().macroscopic().unwrap());
        levels.extend(level.boxes().map(|(_, inner)| inner));
    }
    if let Some(cloth) = simulation.cloth() {
        text += &format!("{:?}\n", cloth.positions_m);
    }
    text + &format!("{:?}", simulation.impulse_sample().unwrap())
}

/// Most steps are taken ahead, and the run is that without it, bit by bit.
fn same_bits(scene: &Scene) {
    let mut together = scene.released(false);
    let mut ahead = scene.released(true);
    // All lattices stand at one time then.
    let end = together.step_count() + STEPS;
    let mut steps_ahead = 0;
    ahead.set_next_reading(end);
    together.set_next_reading(end);
    while ahead.step_count() < end {
        together.advance().unwrap();
        ahead.advance().unwrap();
        steps_ahead += u64::from(ahead.is_ahead());
        assert!(!together.is_ahead());
    }
    assert!(2 * steps_ahead > STEPS, "{steps_ahead} of {STEPS} steps");
    assert!(!ahead.is_ahead());
    assert!(state(&mut ahead) == state(&mut together));
}

/// While cells are ahead the air cannot be read. A device goes ahead only where the caller has said when it reads next, and the run can catch up at any time.
fn unreadable() {
    let scene = Scene {
        case: SPHERE,
        variant: Some("quick"),
        overrides: WITH_LAYERS.to_vec(),
        cloth: ClothPlacement::Host,
        storage: Storage::F32,
    };
    let mut simulation = scene.released(true);
    simulation.advance().unwrap();
    assert!(
        !simulation.is_ahead(),
        "nobody said when the air is read next"
    );
    simulation.set_next_reading(u64::MAX);
    for _ in 0..STEPS {
        simulation.advance().unwrap();
        if simulation.is_ahead() {
            break;
        }
    }
    assert!(simulation.is_ahead());
    let step = simulation.step_count();
    assert!(simulation.air().unwrap().finest().macroscopic().is_err());
    simulation.catch_up().unwrap();
    assert_eq!(simulation.step_count(), step + 1);
    assert!(simulation.air().unwrap().finest().macroscopic().is_ok());
}

/// What cannot go ahead is not planned to: where the structure acts on all cells at once, where forces are repeated, and without a device.
fn plans() {
    let of_sphere = |overrides: &[&'static str], on_device: bool| {
        let scene = Scene {
            case: SPHERE,
            variant: Some("quick"),
            overrides: overrides.to_vec(),
            cloth: ClothPlacement::Host,
            storage: Storage::F32,
        };
        let mut placement = scene.placement(None);
        if !on_device {
            placement.air = AirPlacement::Cpu(ripstop::plan::Precision::F32);
        }
        Plan::new(&scene.parsed().scene, placement)
            .every(Stage::CollideAhead)
            .is_some()
    };
    assert!(of_sphere(&[], true));
    assert!(of_sphere(&WITH_LAYERS, true));
    // There the device answers along the links by itself.
    assert!(!of_sphere(&["coupling.scheme=links"], true));
    assert!(!of_sphere(&[], false));
    assert!(!of_sphere(&["coupling.passes=3"], true));
    assert!(!of_sphere(
        &["resolution.eddy_viscosity={ model = \"wale\", constant = 0.3 }"],
        true
    ));
}
