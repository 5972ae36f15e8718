//! Scenes in boxes of finer cells.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::lattice::eddy_viscosity::EddyViscosity;
use ripstop::lattice::grid::{Faces, Setup, Sides, StreamwiseEnds, Wall};
use ripstop::lattice::nest::{IdleCells, Nest, Refinement};
use ripstop::measure::Record;
use ripstop::plan::{Plan, Stage};
use ripstop::run::without_files;
use ripstop::simulation::{Levels, Simulation};

use crate::command_line::ripstop;
use crate::cut_links::periodic;
use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::read_outs::latest;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("levels::a_canopy_opens_alike", Opens),
        on_every_engine("levels::a_box_elsewhere_changes_little", Elsewhere),
        on_every_engine("levels::boxes_rise_as_the_inlet_has_it", Rises),
        plain("levels::a_box_spans_sides_that_repeat", spans),
        on_every_engine("levels::cells_below_a_box_influence_nothing", Idle),
        plain("levels::what_is_not_there_costs_nothing", absent),
        plain("levels::files_hold_every_lattice", files),
        plain("levels::gradients_wait_for_both_lattices", gradients),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[derive(Clone, Copy)]
struct Rises;

impl Body for Rises {
    /// The wind rises everywhere as the inlet has it: cells of a box as fast as those around it.
    fn run(self, engine: Engine) {
        let case = canopy(&[
            "air.refinement.around=\"structure\"",
            "air.faces.inlet.boundary_layer.thickness_m=3.99",
            "air.faces.inlet.boundary_layer.exponent=0.5",
            "air.faces.inlet.boundary_layer.sides=[\"z_lower\"]",
        ]);
        let plan = Plan::new(&case.scene, engine.plan_placement());
        let start = plan.start_steps;
        let mut simulation = Simulation::new(case.scene, plan, engine.device()).unwrap();
        while simulation.step_count() < start {
            simulation.advance().unwrap();
        }
        let frame = simulation.frame(true).unwrap();
        let outer = frame.fluid.unwrap();
        for air in [&outer, &outer.finer[0]] {
            let [nx, ny, nz] = air.cells;
            // The plane farthest upstream that belongs to this lattice alone, over all of its height.
            for k in 2..nz - 2 {
                let height = (air.origin_m.z + k as f64 * air.cell_size_m) / 3.99;
                let cell = 2 + nx * (ny / 2 + ny * k);
                let speed = f64::from(air.velocity_m_s[cell][0]) / 30.0;
                let error = (speed - height.sqrt()).abs();
                assert!(error < tolerances::RISING_WIND, "{nx}, {k}: {error}");
            }
        }
    }
}

fn parsed(name: &str, source: &str, changes: &[&str]) -> Case {
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    case::parse(name, source, Path::new("."), &choices).unwrap()
}

/// A tunnel of 6 × 4 × 4 D_0, in which there is room for a box at 12 cells per D_0.
pub const ROOM: [&str; 2] = [
    "air.wind_tunnel.size_m=[5.98, 3.99, 3.99]",
    "structure.flat_circular.confluence_m=[1.67, 1.995, 1.995]",
];

fn canopy(changes: &[&str]) -> Case {
    let source = include_str!("../cases/flat-circular-tunnel.toml");
    let all = [
        &["time.end_s=0.01", "output.sample_interval_s=0.002"],
        &ROOM[..],
        changes,
    ]
    .concat();
    parsed("canopy", source, &all)
}

/// One box around the structure.
pub const BOXES: &str = "air.refinement={around=\"structure\", levels=1}";

fn opened(case: &Case, engine: Engine) -> (Simulation, Record) {
    let plan = Plan::new(&case.scene, engine.plan_placement());
    without_files(case, plan, engine.device()).unwrap()
}

#[derive(Clone, Copy)]
struct Opens;

impl Body for Opens {
    /// In a box of finer cells as on finest cells throughout, on every engine; what leaves the momentum box is what the markers gave.
    fn run(self, engine: Engine) {
        let (simulation, record) = opened(&canopy(&[BOXES]), engine);
        assert!(simulation.stands_together());
        let throughout = opened(&canopy(&["air.refinement={around=\"nothing\"}"]), engine);
        for name in ["projected_diameter_ratio", "impulse_markers_n_s"] {
            let [nested, uniform] =
                [&record, &throughout.1].map(|record| latest(record, name).unwrap());
            assert!(
                (nested / uniform - 1.0).abs() < tolerances::OPENING_IN_BOXES,
                "{name}: {nested} against {uniform}"
            );
        }
        let routes = ["impulse_markers_n_s", "impulse_momentum_box_n_s"];
        let [markers, momentum_box] = routes.map(|name| latest(&record, name).unwrap());
        assert!(
            (momentum_box / markers - 1.0).abs() < tolerances::MOMENTUM_BOX_IN_BOXES,
            "{momentum_box} against {markers}"
        );
    }
}

#[derive(Clone, Copy)]
struct Idle;

impl Body for Idle {
    /// Steps that leave out what lies deep below a box give the same bits in the box and around it.
    fn run(self, engine: Engine) {
        let nest = Nest {
            first: [4, 5, 4],
            cells: [40, 12, 13],
            spans: [false; 3],
        };
        let cells = [48, 22, 22];
        let refinement = Refinement {
            nest,
            inner: Vec::new(),
        };
        let wale = EddyViscosity {
            update_every: 2,
            ..EddyViscosity::wale(0.5)
        };
        for eddy_viscosity in [None, Some(wale)] {
            let idle = IdleCells::below(std::slice::from_ref(&refinement), eddy_viscosity).unwrap();
            let is_idle =
                |cell: [usize; 3]| (0..3).all(|a| (idle.first[a]..idle.end[a]).contains(&cell[a]));
            let velocity = |cell: [usize; 3], size: f64| {
                let [x, y, z] = cell.map(|c| 0.3 * size * c as f64);
                (0.0, [0.05 + 0.02 * y.sin(), 0.03 * z.cos(), 0.02 * x.sin()])
            };
            let stepped = |left_out: Option<IdleCells>| {
                let setup = |cells: [usize; 3], relaxation_time: f64| Setup {
                    eddy_viscosity,
                    ..periodic(cells, relaxation_time)
                };
                let coarse = Setup {
                    idle: left_out,
                    ..setup(cells, 0.51)
                };
                let of_box = Setup {
                    ends: StreamwiseEnds::Walls([Wall::OfBox; 2]),
                    sides: Sides::Each([Faces::Walls([Wall::OfBox; 2]); 2]),
                    ..setup(nest.fine_cells(), 0.52)
                };
                let coarse = engine.air(coarse, &|cell| velocity(cell, 1.0));
                let fine = engine.air(of_box, &|cell| velocity(cell, 0.5));
                let mut levels = Levels::new(coarse).with(nest, Levels::new(fine)).unwrap();
                for _ in 0..4 {
                    levels.whole_step(None).unwrap();
                }
                [levels.engine(), levels.finest()].map(|air| air.macroscopic().unwrap())
            };
            let [[around, inside], [expected_around, expected_inside]] =
                [Some(idle), None].map(stepped);
            assert!(inside == expected_inside);
            let mut others = 0;
            for (i, (found, expected)) in around.iter().zip(&expected_around).enumerate() {
                let cell = [
                    i % cells[0],
                    i / cells[0] % cells[1],
                    i / cells[0] / cells[1],
                ];
                if is_idle(cell) {
                    others += usize::from(found != expected);
                } else if !nest.covers(cell) {
                    assert!(found == expected, "{cell:?}");
                }
            }
            assert!(others > 0, "nothing was left out");
        }
    }
}

#[derive(Clone, Copy)]
struct Elsewhere;

impl Body for Elsewhere {
    /// A second box in the undisturbed stream beside that of a sphere moves its drag by little more than round-off.
    fn run(self, engine: Engine) {
        let around = "{lower_m=[0.14, 0.14, 0.14], upper_m=[0.36, 0.36, 0.36]}";
        let beside = "{lower_m=[0.3, 0.45, 0.15], upper_m=[0.6, 0.6, 0.35]}";
        let drag = |boxes: &str| {
            let boxes = format!("air.refinement={{boxes=[{boxes}]}}");
            let case = parsed(
                "sphere",
                include_str!("../cases/sphere.toml"),
                &[
                    &boxes,
                    "air.wind_tunnel.size_m=[0.9, 0.7, 0.5]",
                    "air.wind_tunnel.sponge_length_m=absent",
                    "resolution.cell_size_m=0.0125",
                    "resolution.cells_per_diameter=absent",
                    "bodies.sphere.position_m=[0.25, 0.25, 0.25]",
                    "time.end_s=5.0",
                    "output.sample_interval_s=1.0",
                ],
            );
            let lattices = case.scene.air.as_ref().unwrap().levels().len();
            let (_, record) = opened(&case, engine);
            (lattices, latest(&record, "drag_coefficient").unwrap())
        };
        let (one, alone) = drag(around);
        let (two, with_it) = drag(&format!("{beside}, {around}"));
        assert_eq!([one, two], [2, 3]);
        assert!(
            (with_it / alone - 1.0).abs() < tolerances::BOX_ELSEWHERE,
            "{with_it} against {alone}"
        );
    }
}

/// Where sides repeat and the box would come near them it spans them, however few cells they are apart.
fn spans() {
    let case = canopy(&[
        "air.refinement={around=\"structure\", levels=1}",
        "air.faces.sides=\"periodic\"",
        "air.wind_tunnel.size_m=[5.98, 1.5, 1.5]",
        "structure.flat_circular.confluence_m=[1.67, 0.75, 0.75]",
        "resolution.cells_per_diameter=8.0",
        "time.end_s=0.004",
    ]);
    let air = case.scene.air.as_ref().unwrap();
    let finest = air.finest();
    assert_eq!(finest.spans, [false, true, true]);
    // The fewest that a structure may have around it.
    assert_eq!(finest.cells[1], 12, "{finest:?}");
    let (_, record) = opened(&case, Engine::CpuF32);
    assert!(
        latest(&record, "impulse_momentum_box_n_s")
            .unwrap()
            .is_finite()
    );
}

/// In boxes velocity gradients are taken after even numbers of steps alone: in between shells are spoilt.
fn gradients() {
    let every = |boxes: &str| {
        let case = canopy(&[
            boxes,
            "resolution.operator=\"recursive_regularised\"",
            "resolution.eddy_viscosity={model=\"vreman\", constant=0.05, update_every=3}",
        ]);
        let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
        plan.every(Stage::EddyViscosity)
    };
    assert_eq!(every("air.refinement={around=\"nothing\"}"), Some(3));
    assert_eq!(every(BOXES), Some(4));
}

/// Without boxes no stage is planned and no cell is added; with them the plan says what they cost.
fn absent() {
    let planned = |changes: &[&str]| {
        let case = canopy(changes);
        let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
        let has = plan.stages.iter().any(|s| s.stage == Stage::CoarserLevels);
        (has, plan.sizes.cells, plan.sizes.updates)
    };
    let (has, cells, updates) = planned(&[]);
    assert!(!has);
    assert_eq!(cells, updates);
    let (has, fewer, updated) = planned(&[BOXES]);
    assert!(has);
    assert!(fewer < cells && updated < fewer, "{fewer} {updated}");
}

/// Flow files hold every lattice, and hide cells that finer ones cover.
fn files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let changes = [
        BOXES,
        "time.end_s=0.002",
        "output.flow_interval_s=0.001",
        "output.picture_times_s=absent",
    ];
    let mut arguments = vec![
        "run",
        "cases/flat-circular-tunnel.toml",
        "--variant",
        "quick",
        "--engine=cpu",
        "--out",
        out.to_str().unwrap(),
    ];
    for change in ROOM.iter().chain(&changes) {
        arguments.extend(["--set", change]);
    }
    let finished = ripstop(&arguments);
    assert!(out.join("flow.pvd").exists(), "{}", finished.errors);
    let text = |name: &str| {
        let bytes = std::fs::read(out.join(name)).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    assert!(text("flow.pvd").contains("frames/flow_00001.vtm"));
    let listed = text("frames/flow_00001.vtm");
    for name in ["flow_00001.vti", "flow_00001_box_1.vti"] {
        assert!(listed.contains(&format!("file=\"{name}\"")), "{listed}");
    }
    assert!(text("frames/flow_00001.vti").contains("vtkGhostType"));
    assert!(!text("frames/flow_00001_box_1.vti").contains("vtkGhostType"));
}
