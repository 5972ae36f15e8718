//! Canopies that cut links of the lattice, with narrow openings and without: how they open, what they store, and how they go on.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::plan::{Plan, Stage};
use ripstop::run::without_files;
use ripstop::simulation::{Coupled, Simulation};

use crate::command_line::root;
use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::read_outs::latest;
use crate::resumed::{bits_of_nodes, taken_up};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("cut_canopies::a_canopy_opens", Opens(|| canopy(&[]))),
        on_every_engine(
            "cut_canopies::a_canopy_with_narrow_openings_opens",
            Opens(|| disk_gap_band(&[])),
        ),
        plain(
            "cut_canopies::permeable_fabric_with_narrow_openings_opens",
            || {
                Opens(|| disk_gap_band(&[PERMEABLE])).run(Engine::CpuF32);
            },
        ),
        plain("cut_canopies::what_is_not_there_costs_nothing", absent),
        plain("cut_canopies::a_run_taken_up_goes_on_alike", taken_up_alike),
        plain("cut_canopies::what_leaves_the_momentum_box", leaves_the_box),
        plain(
            "cut_canopies::a_run_with_narrow_openings_goes_on_alike",
            || {
                goes_on_alike(&disk_gap_band(&[]));
            },
        ),
        plain("cut_canopies::other_cells_take_over", || {
            other_cells(|cells| canopy(&["time.end_s=0.02", cells]), [12.0, 16.0]);
        }),
        plain(
            "cut_canopies::openings_are_narrow_no_longer_on_other_cells",
            openings_on_other_cells,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The shipped canopy on few cells, a hundredth of a second after release, with these changes.
pub fn canopy(changes: &[&str]) -> Case {
    let links = [
        "coupling.scheme=links",
        "time.end_s=0.01",
        "output.sample_interval_s=0.002",
    ];
    let overrides: Vec<&str> = links.iter().chain(changes).copied().collect();
    quick(
        include_str!("../cases/flat-circular-tunnel.toml"),
        &overrides,
    )
}

/// The quick variant of a shipped canopy with these changes.
fn quick(source: &str, changes: &[&str]) -> Case {
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    case::parse("canopy", source, Path::new("."), &choices).unwrap()
}

/// Fabric that lets 0.65 m/s pass at 124 Pa.
const PERMEABLE: &str = "fabric.permeability.ergun={ viscous_coefficient_pa_s_m2 = 1.6e6, inertial_coefficient_kg_m4 = 4.8e5 }";

/// P1 on few cells, whose gap is two thirds of one. Its vent is made one and a half cells wide, from 3.3.
fn disk_gap_band(changes: &[&str]) -> Case {
    let own = [
        "coupling.scheme=links",
        "coupling.narrow_openings=law",
        "structure.disk_gap_band.vent_diameter_m=0.25",
        "time.end_s=0.02",
    ];
    let changes = [&own[..], changes].concat();
    quick(include_str!("../cases/disk-gap-band.toml"), &changes)
}

/// Which openings of a case air passes by a law: its vent, and its gap.
fn by_law(case: &Case) -> Vec<bool> {
    let (scene, structure) = (&case.scene, &case.scene.body.as_ref().unwrap().structure);
    let cell_size_m = scene.air.as_ref().unwrap().units.cell_size_m;
    let covers = (scene.coupling.as_ref().unwrap()).covers(structure, cell_size_m);
    covers.iter().map(Option::is_some).collect()
}

#[derive(Clone, Copy)]
struct Opens(fn() -> Case);

impl Body for Opens {
    /// The canopy opens alike on every engine, the three routes of the force agree, and the air keeps its mass, pleats or not.
    fn run(self, engine: Engine) {
        let case = (self.0)();
        let plan = Plan::new(&case.scene, engine.plan_placement());
        let (simulation, record) = without_files(&case, plan, engine.device()).unwrap();
        // Its triangles are smaller than the cells: what fabric and air exchange through those who share is among what is tested.
        let Some(Coupled::Links(links)) = simulation.coupled() else {
            panic!("the canopy does not cut links");
        };
        assert!(links.surface().patches().is_some());
        let [markers, momentum_box, lines] = [
            "impulse_markers_n_s",
            "impulse_momentum_box_n_s",
            "impulse_lines_n_s",
        ]
        .map(|name| latest(&record, name).unwrap());
        let off = |route: f64| (route / markers - 1.0).abs();
        assert!(
            off(momentum_box) < tolerances::cut_momentum_box(engine),
            "{momentum_box} against {markers}"
        );
        assert!(
            off(lines) < tolerances::CUT_LINES,
            "{lines} against {markers}"
        );
        let defect = latest(&record, "mass_defect").unwrap();
        assert!(defect.abs() < tolerances::cut_mass(engine), "{defect:e}");
        let open = latest(&record, "projected_diameter_ratio").unwrap();
        let plan = Plan::new(&case.scene, Engine::CpuF64.plan_placement());
        let reference = without_files(&case, plan, None).unwrap().1;
        let reference = latest(&reference, "projected_diameter_ratio").unwrap();
        assert!(
            (open / reference - 1.0).abs() < tolerances::OPENING_BY_LINKS,
            "{open} against {reference}"
        );
    }
}

/// A canopy on lines of next to no stiffness drifts out of the momentum box. From then on neither the box's momentum nor its mass is told: links that cross its faces are cut.
fn leaves_the_box() {
    let changes = [
        "coupling.scheme=links",
        "structure.mesh.line_material.youngs_modulus_pa=1e3",
        "time.end_s=0.12",
    ];
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: changes.map(str::to_owned).to_vec(),
    };
    let source = include_str!("../cases/hemispherical-mesh.toml");
    let case = case::parse("canopy", source, &root().join("cases"), &choices).unwrap();
    let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
    let record = without_files(&case, plan, None).unwrap().1;
    let [momentum, mass] = ["impulse_momentum_box_n_s", "mass_defect"]
        .map(|name| record.column(record.named(name).unwrap()));
    let left = momentum.iter().position(|of| of.is_nan()).unwrap();
    assert!(left > 10 && left + 1 < mass.len(), "{left}");
    assert!(mass[left..].iter().all(|defect| defect.is_nan()));
    let limit = tolerances::cut_mass(Engine::CpuF32);
    assert!(
        mass[..left].iter().all(|defect| defect.abs() < limit),
        "{mass:?}"
    );
}

/// Markers, their stages and read-outs are not there; the number of links that `check` tells is about that of the run.
fn absent() {
    let choices = Choices {
        variant: None,
        overrides: ["coupling.scheme=links", "time.end_s=1.0"]
            .map(str::to_owned)
            .to_vec(),
    };
    let source = include_str!("../cases/sphere.toml");
    let case = case::parse("sphere", source, Path::new("."), &choices).unwrap();
    let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
    let has = |stage| plan.every(stage).is_some();
    for stage in [Stage::FindLinks, Stage::ReadLinks, Stage::Bounce] {
        assert!(has(stage), "{}", stage.name());
    }
    for stage in [Stage::Interpolate, Stage::Spread, Stage::SendMarkers] {
        assert!(!has(stage), "{}", stage.name());
    }
    assert_eq!(plan.sizes.markers, 0);
    let told = plan.sizes.links as f64;
    let (simulation, record) = without_files(&case, plan, None).unwrap();
    let coupled = simulation.coupled().unwrap();
    assert!(coupled.immersed().is_none() && coupled.markers().is_empty());
    assert!(latest(&record, "slip_ratio").is_none());
    let found = coupled.point_count() as f64;
    assert!((0.9..1.1).contains(&(found / told)), "{found} of {told}");
}

/// A run stored and taken up goes on bit by bit.
fn taken_up_alike() {
    goes_on_alike(&canopy(&["time.end_s=0.02"]));
}

/// The same of any case with fabric that cuts links.
pub fn goes_on_alike(case: &Case) {
    let fresh = || {
        let plan = Plan::new(&case.scene, Engine::CpuF32.plan_placement());
        Simulation::new(case.scene.clone(), plan, None).unwrap()
    };
    let mut run = fresh();
    let release = run.plan().start_steps;
    while run.step_count() < release + 30 {
        run.advance().unwrap();
    }
    let mut again = taken_up(&mut run, fresh());
    for _ in 0..15 {
        run.advance().unwrap();
        again.advance().unwrap();
    }
    assert_eq!(bits_of_nodes(&run), bits_of_nodes(&again));
    let force = |simulation: &Simulation| simulation.coupled().map(Coupled::force_on_air);
    assert_eq!(force(&run), force(&again));
}

/// A vent that has a law on coarse cells has none on fine ones, where the gap has it still.
fn openings_on_other_cells() {
    let with = |cells: &str| disk_gap_band(&[cells]);
    let [coarse, fine] = [16.0, 24.0].map(|cells| with(&per_diameter(cells)));
    assert_eq!(by_law(&coarse), [true, true]);
    assert_eq!(by_law(&fine), [false, true]);
    let cells = disk_gap_band(&["coupling.narrow_openings=cells"]);
    assert_eq!(by_law(&cells), [false, false]);
    other_cells(with, [16.0, 24.0]);
}

fn per_diameter(cells: f64) -> String {
    format!("resolution.cells_per_diameter={cells:?}")
}

/// A run goes on on finer cells, with about the force that it has where it goes on on its own.
fn other_cells(case: impl Fn(&str) -> Case, cells: [f64; 2]) {
    let refined = cells[1] / cells[0];
    let [case, finer] = cells.map(|cells| case(&per_diameter(cells)));
    let plan = |case: &Case| Plan::new(&case.scene, Engine::CpuF32.plan_placement());
    let fresh = || {
        let mut run = Simulation::new(case.scene.clone(), plan(&case), None).unwrap();
        let release = run.plan().start_steps;
        while run.step_count() < release + 40 {
            run.advance().unwrap();
        }
        run
    };
    let mean_force_n = |run: &mut Simulation, steps: usize| {
        let force_n = |_| {
            run.advance().unwrap();
            let coupled = run.coupled().unwrap();
            coupled.force_on_air()[0] * coupled.units().force_n()
        };
        (0..steps).map(force_n).sum::<f64>() / steps as f64
    };
    let [mut unchanged, mut run] = [fresh(), fresh()];
    let links = run.coupled().unwrap().point_count();
    run.change_lattice(finer.scene.clone(), plan(&finer))
        .unwrap();
    let mean = mean_force_n(&mut run, 30);
    assert!(run.coupled().unwrap().point_count() > links * 3 / 2);
    let reference = mean_force_n(&mut unchanged, (30.0 / refined).round() as usize);
    assert!(
        (0.6..1.6).contains(&(mean / reference)),
        "{mean}, without the change {reference}"
    );
}
