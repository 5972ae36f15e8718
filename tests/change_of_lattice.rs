//! Runs that go on on another lattice.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices};
use ripstop::measure::Record;
use ripstop::plan::{Plan, Precision};
use ripstop::run::{self, Observer, Order, Report, Requests, Start};
use ripstop::simulation::{Coupled, Simulation};

use crate::engines::{Body, Engine, on_every_engine, plain};
use crate::levels::{BOXES, ROOM};
use crate::read_outs::latest;
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    [
        on_every_engine("change_of_lattice::the_drag_goes_on", Drag),
        on_every_engine(
            "change_of_lattice::the_canopy_goes_on_on_finer_cells",
            Finer,
        ),
        plain("change_of_lattice::boxes_go_on_on_finer_cells", || {
            goes_on_on_finer_cells(Engine::CpuF32, &[&[BOXES], &ROOM[..]].concat());
        }),
        plain("change_of_lattice::cut_links_know_what_they_knew", links),
        plain(
            "change_of_lattice::resumed_on_the_grid_that_it_was_on",
            on_its_grid,
        ),
        plain(
            "change_of_lattice::resumed_with_the_step_that_it_had",
            with_its_step,
        ),
        plain(
            "change_of_lattice::resumed_in_boxes_of_finer_cells",
            in_boxes,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A canopy that begins on coarser cells.
fn on_its_grid() {
    let changes = [
        "steady.grid_sequence=[1.25]",
        "resolution.lattice_speed=0.12",
        "time.end_s=0.7",
        "output.canopy_interval_s=0.1",
    ];
    resumed(include_str!("../cases/flat-circular-tunnel.toml"), &changes);
}

/// A fall whose time step grows.
fn with_its_step() {
    resumed(include_str!("../cases/finite-mass-drop.toml"), &[]);
}

/// The same fall in a box of finer cells: all lattices change at once. In air so thin that τ − ½ is some 1e-9, its round-off is no other viscosity.
fn in_boxes() {
    let changes = [
        BOXES,
        "air.kinematic_viscosity_m2_s=1.55e-8",
        "air.descent.size_m=[5.98, 3.99, 3.99]",
        "structure.flat_circular.confluence_m=[1.67, 1.995, 1.995]",
    ];
    resumed(include_str!("../cases/finite-mass-drop.toml"), &changes);
}

fn canopy(changes: &[&str]) -> Case {
    let source = include_str!("../cases/flat-circular-tunnel.toml");
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: ["time.end_s=0.06"]
            .iter()
            .chain(changes)
            .map(|&change| change.to_owned())
            .collect(),
    };
    case::parse("canopy", source, Path::new("."), &choices).unwrap()
}

/// The canopy a while after its release, sampled twice, four steps apart.
fn opening(case: &Case, engine: Engine, until_s: f64) -> (Simulation, Record) {
    let plan = Plan::new(&case.scene, engine.plan_placement());
    let mut simulation = Simulation::new(case.scene.clone(), plan, engine.device()).unwrap();
    let mut record = Record::new(&simulation);
    while simulation.time_s() < until_s || !simulation.stands_together() {
        simulation.advance().unwrap();
    }
    record.add(&mut simulation).unwrap();
    sample(&mut simulation, &mut record, 4);
    (simulation, record)
}

/// Mean drag coefficient over the next steps.
fn sample(simulation: &mut Simulation, record: &mut Record, steps: usize) -> f64 {
    for _ in 0..steps {
        simulation.advance().unwrap();
    }
    while !simulation.stands_together() {
        simulation.advance().unwrap();
    }
    record.add(simulation).unwrap();
    latest(record, "drag_coefficient").unwrap()
}

/// What cut links know of loads, of the pressures on both faces and of boundary layers is the same in SI units after a change of the time step.
fn links() {
    let case = canopy(&[
        "coupling.scheme=\"links\"",
        "fabric.friction=\"model\"",
        "resolution.operator=\"stabilised_regularised\"",
    ]);
    let (mut simulation, _) = opening(&case, Engine::CpuF32, 0.004);
    let known = |simulation: &Simulation| -> [Vec<f64>; 4] {
        let Some(Coupled::Links(links)) = simulation.coupled() else {
            panic!("no links");
        };
        let (units, surface) = (links.units(), links.surface());
        let layers = surface.boundary_layers().unwrap().saved();
        let pressures = surface.face_pressures().iter().flatten();
        [
            links
                .force_on_air()
                .map(|force| force * units.force_n())
                .into(),
            pressures
                .map(|excess| excess * units.pressure_pa())
                .collect(),
            layers
                .iter()
                .map(|layer| layer[3] * units.speed_m_s())
                .collect(),
            layers
                .iter()
                .map(|layer| layer[6] * units.cell_size_m)
                .collect(),
        ]
    };
    let before = known(&simulation);
    let mut scene = case.scene.clone();
    let air = scene.air.as_mut().unwrap();
    air.units = air.units.with_step_factor(0.8);
    scene.time.as_mut().unwrap().step_s = air.units.time_step_s;
    let plan = Plan::new(&scene, Engine::CpuF32.plan_placement());
    simulation.change_lattice(scene, plan).unwrap();
    for (before, after) in before.iter().zip(known(&simulation)) {
        let largest = before
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        assert!(largest > 0.0);
        for (before, after) in before.iter().zip(after) {
            assert!(
                (before - after).abs() <= 1e-12 * largest,
                "{before} {after}"
            );
        }
    }
    simulation.advance().unwrap();
}

#[derive(Clone, Copy)]
struct Drag;

impl Body for Drag {
    /// A change of the lattice that changes nothing leaves the drag as it was; a time step that is a little longer moves it a little.
    fn run(self, engine: Engine) {
        let case = canopy(&[]);
        let drags = |factor: Option<f64>| {
            let (mut simulation, mut record) = opening(&case, engine, 0.02);
            if let Some(factor) = factor {
                let mut scene = case.scene.clone();
                let air = scene.air.as_mut().unwrap();
                air.units = air.units.with_step_factor(factor);
                scene.time.as_mut().unwrap().step_s = air.units.time_step_s;
                let plan = Plan::new(&scene, engine.plan_placement());
                let before = (simulation.time_s(), simulation.step_count());
                simulation.change_lattice(scene, plan).unwrap();
                assert_eq!(before, (simulation.time_s(), simulation.step_count()));
            }
            (0..8)
                .map(|_| sample(&mut simulation, &mut record, 5))
                .collect::<Vec<f64>>()
        };
        let unchanged = drags(None);
        for (factor, limit) in [
            (1.0, tolerances::DRAG_AFTER_NO_CHANGE),
            (1.1, tolerances::DRAG_AFTER_CHANGE_OF_STEP),
        ] {
            let changed = drags(Some(factor));
            for (now, then) in changed.iter().zip(&unchanged) {
                assert!(
                    (now / then - 1.0).abs() < limit,
                    "steps {factor} times as long: {changed:.3?} instead of {unchanged:.3?}"
                );
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Finer;

impl Body for Finer {
    fn run(self, engine: Engine) {
        goes_on_on_finer_cells(engine, &[]);
    }
}

/// On finer cells time, shape and impulses go on; the three force routes still agree over both grids.
fn goes_on_on_finer_cells(engine: Engine, changes: &[&str]) {
    let with = |cells| canopy(&[&[cells], changes].concat());
    let coarse = with("resolution.cells_per_diameter=10.0");
    let fine = with("resolution.cells_per_diameter=15.0");
    let (mut simulation, mut record) = opening(&coarse, engine, 0.02);
    let before = simulation.structure_frame().structure.unwrap();
    let (time_s, drag) = (
        simulation.time_s(),
        latest(&record, "drag_coefficient").unwrap(),
    );
    let plan = Plan::new(&fine.scene, engine.plan_placement());
    simulation.change_lattice(fine.scene.clone(), plan).unwrap();
    let after = simulation.structure_frame().structure.unwrap();
    assert_eq!(before.positions_m, after.positions_m);
    assert_eq!(before.velocities_m_s, after.velocities_m_s);
    assert!((simulation.time_s() - time_s).abs() < 1e-15);
    // The same instant, by impulses that go on.
    let impulse = latest(&record, "impulse_markers_n_s").unwrap();
    let sample_now = simulation.impulse_sample().unwrap().unwrap();
    assert!((sample_now.markers.x / impulse - 1.0).abs() < tolerances::IMPULSE_CARRIED);
    let drags: Vec<f64> = (0..6)
        .map(|_| sample(&mut simulation, &mut record, 6))
        .collect();
    for now in &drags {
        let moved = (now / drag - 1.0).abs();
        assert!(
            moved < tolerances::DRAG_ON_FINER_CELLS,
            "{drag:.3} then {drags:.3?}"
        );
    }
    let routes = [
        "impulse_markers_n_s",
        "impulse_momentum_box_n_s",
        "impulse_lines_n_s",
    ]
    .map(|name| latest(&record, name).unwrap());
    for route in routes {
        let apart = (route / routes[0] - 1.0).abs();
        assert!(apart < tolerances::ROUTES_OVER_A_CHANGE, "{routes:?}");
    }
}

/// Interrupts a run as soon as it has gone on on another lattice so many times.
struct AtChange<'a> {
    interrupt: &'a AtomicBool,
    changes: usize,
    wanted: usize,
}

impl Observer for AtChange<'_> {
    fn progress(&mut self, _: u64, _: u64, _: &str) {}

    fn note(&mut self, _: &str) {}

    fn lattice_changed(&mut self) {
        self.changes += 1;
        if self.changes == self.wanted {
            self.interrupt.store(true, Ordering::Relaxed);
        }
    }
}

/// Runs the quick variant of a case; interrupts it at a change of its lattice. Returns how many changes were seen.
fn run_in(
    folder: &Path,
    source: &str,
    changes: &[&str],
    wanted: usize,
    resume: bool,
) -> (Report, usize) {
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    let case = case::parse("case", source, Path::new("."), &choices).unwrap();
    let requests = Requests::default();
    let mut observer = AtChange {
        interrupt: &requests.stop,
        changes: 0,
        wanted,
    };
    let order = Order {
        plan: Plan::new(&case.scene, Precision::F32),
        case: &case,
        device: None,
        fallback: None,
        folder,
        start: if resume { Start::Resume } else { Start::New },
        overwrite: false,
        keep_final: false,
        checkpoint_interval: Duration::from_secs(1000),
    };
    let report = run::run(order, &requests, &mut observer).unwrap();
    (report, observer.changes)
}

/// A run that is interrupted at a change of its lattice goes on with the same bits.
fn resumed(source: &str, changes: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let [whole, broken] = ["whole", "broken"].map(|name| folder.path().join(name));
    let (unbroken, all) = run_in(&whole, source, changes, usize::MAX, false);
    assert!(all > 0, "the lattice never changed");
    let (report, before) = run_in(&broken, source, changes, all.div_ceil(2), false);
    assert!(report.interrupted);
    let (report, after) = run_in(&broken, source, changes, usize::MAX, true);
    assert!(!report.interrupted);
    assert_eq!(before + after, all);
    // However often the time step followed the speed, one note tells, of all changes.
    let followed = |report: &Report| {
        let notes = report.summary.notes.iter();
        let followed = notes.filter(|note| note.contains("time step followed"));
        followed.cloned().collect::<Vec<_>>()
    };
    let notes = followed(&unbroken);
    assert_eq!(notes, followed(&report));
    assert!(notes.len() <= 1, "{notes:?}");
    if let Some(note) = notes.first() {
        assert!(note.contains(&format!(" {all} change")), "{note}");
    }
    if source.contains("[air.descent]") {
        // However long steps have become: the air on the lattice is as fast as the case asks for.
        let mut rows = report.summary.validity.iter();
        let row = rows.find(|row| row.name == "Mach number on the lattice");
        assert!((row.unwrap().value.unwrap() - 0.08 * 3_f64.sqrt()).abs() < 1e-9);
    }
    for name in ["history.csv", "canopy.pvd", "snapshot_000.png"] {
        let [a, b] = [&whole, &broken].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}
