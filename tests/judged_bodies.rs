//! What is judged of rigid bodies before a run, and what stands beside their results.

use std::fmt::Write as _;
use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, CaseError, Choices};
use ripstop::measure::{Record, averaging_window_s, results};
use ripstop::output::{Quantity, ValidityRow};
use ripstop::plan::{Plan, Precision};
use ripstop::run::without_files;
use ripstop::statics::Statics;
use ripstop::validity;

use crate::command_line::ripstop;
use crate::engines::plain;
use crate::validity::{Body, SPHERE};

pub fn trials() -> Vec<Trial> {
    [
        ("judged_bodies::thin_closed_wing", thin_closed_wing as fn()),
        ("judged_bodies::bodies_in_one_place", bodies_in_one_place),
        ("judged_bodies::slow_air_in_long_steps", slow_air),
        (
            "judged_bodies::what_is_not_bluff_has_no_forecast",
            not_bluff,
        ),
        (
            "judged_bodies::an_oscillation_is_seen_whole",
            whole_oscillation,
        ),
        ("judged_bodies::faster_than_the_reference", fast_body),
        (
            "judged_bodies::in_the_sponge_and_through_the_outlet",
            in_the_sponge,
        ),
        (
            "judged_bodies::blockage_is_by_the_frontal_area",
            frontal_area,
        ),
        (
            "judged_bodies::meshes_by_their_own_extent_and_shadow",
            meshes,
        ),
        ("judged_bodies::pictures_after_the_end", late_pictures),
        (
            "judged_bodies::published_drags_and_windows",
            published_drags,
        ),
        ("judged_bodies::half_a_period_is_not_settled", half_a_period),
    ]
    .into_iter()
    .flat_map(|(name, test)| plain(name, test))
    .collect()
}

/// The sphere of [`SPHERE`] on 8 cells in a smaller box, with changes.
fn sphere(overrides: &[&str]) -> Case {
    try_sphere(overrides).unwrap()
}

fn try_sphere(overrides: &[&str]) -> Result<Case, Box<CaseError>> {
    let body = Body {
        cells: 8.0,
        inlet: 2.0,
        sponge: 3.0,
        width: 4.0,
        ..SPHERE
    };
    let choices = Choices {
        variant: None,
        overrides: overrides.iter().map(|&change| change.to_owned()).collect(),
    };
    case::parse("case", &body.text(), Path::new("."), &choices)
}

fn row(case: &Case, name: &str) -> Option<ValidityRow> {
    let plan = Plan::new(&case.scene, Precision::F32);
    let mut rows = validity::beforehand(&case.scene, &plan).into_iter();
    rows.find(|row| row.name == name)
}

/// Creeping flow with steps that are too long for its viscosity, and a forecast that nothing was measured for.
fn slow_air() {
    let name = "Knudsen number on the lattice";
    let slow = "air.kinematic_viscosity_m2_s=1.0";
    let long = sphere(&[slow]);
    let found = row(&long, name).unwrap();
    // √(π/2) Ma/Re with Ma = 0.1 √3 and Re = 1.
    assert!((found.value.unwrap() - 0.217).abs() < 1e-3, "{found:?}");
    assert_eq!(found.valid, Some(false));
    assert!(validity::expected_errors(&long.scene).is_empty());
    let short = sphere(&[slow, "resolution.lattice_speed=0.01"]);
    assert_eq!(row(&short, name).unwrap().valid, Some(true));
    assert_eq!(row(&sphere(&[]), name).unwrap().valid, Some(true));
    assert_eq!(validity::expected_errors(&sphere(&[]).scene).len(), 1);
}

/// The forecast of the drag is of spheres and disks across the stream.
fn not_bluff() {
    let disk = |angle_deg: f64| {
        let body = Body {
            shape: "disk",
            inlet: 2.0,
            sponge: 3.0,
            width: 4.0,
            cells: 8.0,
            ..SPHERE
        };
        let turn =
            format!("bodies.disk.rotation={{ axis = [0.0, 1.0, 0.0], angle_deg = {angle_deg:?} }}");
        let choices = Choices {
            variant: None,
            overrides: vec![turn],
        };
        let case = case::parse("case", &body.text(), Path::new("."), &choices).unwrap();
        validity::expected_errors(&case.scene).len()
    };
    assert_eq!([disk(0.0), disk(30.0), disk(80.0)], [1, 1, 0]);
    let wing = case::parse("case", THIN_WING, Path::new("."), &Choices::default()).unwrap();
    assert!(validity::expected_errors(&wing.scene).is_empty());
}

/// Twenty thousand periods in the run: looks at even parts of it would all meet the same phase.
fn whole_oscillation() {
    let swinging = |displacement_m: f64| {
        let displacement = format!(
            "bodies.sphere.motion.oscillation.displacement_m=[0.0, 0.0, {displacement_m:?}]"
        );
        let overrides = [
            "bodies.sphere.motion.oscillation.frequency_hz=20.0",
            "bodies.sphere.motion.oscillation.phase_deg=90.0",
            "time.end_s=1000.0",
            &displacement,
        ];
        try_sphere(&overrides)
    };
    let fastest = swinging(0.002).unwrap().scene.rigid_bodies[0].fastest_m_s;
    let expected = 0.002 * std::f64::consts::TAU * 20.0;
    assert!(
        (fastest / expected - 1.0).abs() < 1e-3,
        "{fastest} {expected}"
    );
    assert!(swinging(0.1).is_err(), "12.6 m/s, 1.2 cells per step");
}

/// A body that moves faster than the speed that the lattice was chosen by.
fn fast_body() {
    let still = [
        "air.wind_tunnel.speed_m_s=0.0",
        "resolution.reference_speed_m_s=1.0",
        "resolution.lattice_speed=0.08",
    ];
    let moving = |speed_m_s: f64| {
        let motion = format!(
            "bodies.sphere.motion.constant_velocity.velocity_m_s=[0.0, 0.0, {speed_m_s:?}]"
        );
        let rise = "bodies.sphere.motion.constant_velocity.start_time_s=0.1";
        let changes = [&still[..], &[&motion, rise, "time.end_s=0.2"]].concat();
        sphere(&changes)
    };
    for (speed_m_s, valid) in [(1.0, true), (2.9, false)] {
        let case = moving(speed_m_s);
        let mach = row(&case, "Mach number on the lattice").unwrap();
        let expected = 0.08 * speed_m_s * 3f64.sqrt();
        assert!(
            (mach.value.unwrap() / expected - 1.0).abs() < 1e-9,
            "{mach:?}"
        );
        assert_eq!(mach.valid, Some(valid));
        let steps = row(&case, "steps per length over speed").unwrap();
        let expected = 1.0 / speed_m_s / case.scene.air.as_ref().unwrap().units.time_step_s;
        assert!(
            (steps.value.unwrap() / expected - 1.0).abs() < 1e-9,
            "{steps:?}"
        );
    }
    // In a slower wind, on a lattice that was chosen by the body.
    let case = sphere(&[
        "resolution.reference_speed_m_s=3.0",
        "resolution.lattice_speed=0.08",
        "bodies.sphere.motion.constant_velocity.velocity_m_s=[0.0, 0.0, 2.9]",
        "bodies.sphere.motion.constant_velocity.start_time_s=0.1",
        "time.end_s=0.2",
    ]);
    let mach = row(&case, "Mach number on the lattice").unwrap();
    let expected = 0.08 * 2.9 / 3.0 * 3f64.sqrt();
    assert!(
        (mach.value.unwrap() / expected - 1.0).abs() < 1e-9,
        "{mach:?}"
    );
}

/// A body may pass through the outlet by intent; the sponge before it is still in its wake.
fn in_the_sponge() {
    let at_the_end = "bodies.sphere.position_m=[6.0, 2.0, 2.0]";
    let name = "distance to the sponge or outlet";
    let found = row(&sphere(&[at_the_end]), name).unwrap();
    assert_eq!(found.valid, Some(false));
    let without = sphere(&[at_the_end, "air.wind_tunnel.sponge_length_m=absent"]);
    assert!(row(&without, name).is_none());
}

/// Whatever area coefficients refer to.
fn frontal_area() {
    let area_m2 = 0.25 * std::f64::consts::PI;
    for changes in [&[][..], &["bodies.sphere.reference.area_m2=0.01"]] {
        let blockage = row(&sphere(changes), "blockage of the body").unwrap();
        assert!((blockage.value.unwrap() * 16.0 / area_m2 - 1.0).abs() < 1e-9);
    }
}

/// Two cubes of side 1, one behind the other, in a file: their blockage is that of one, and a large length of reference makes no cells of it.
fn meshes() {
    let folder = tempfile::tempdir().unwrap();
    // Boxes of a size, one behind the other.
    let boxes = |count: u32, size: [f64; 3]| {
        let mut obj = String::new();
        for number in 0..count {
            for corner in 0..8_u32 {
                let [x, y, z] =
                    [0, 1, 2].map(|axis| size[axis] * (f64::from(corner >> axis & 1) - 0.5));
                writeln!(obj, "v {} {y} {z}", x + 1.5 * f64::from(number)).unwrap();
            }
            for face in [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ] {
                let [a, b, c, d] = face.map(|corner| corner + 1 + 8 * number);
                writeln!(obj, "f {a} {b} {c} {d}").unwrap();
            }
        }
        obj
    };
    let cubes = folder.path().join("cubes.obj");
    std::fs::write(cubes, boxes(2, [1.0; 3])).unwrap();
    let beam = folder.path().join("beam.obj");
    std::fs::write(beam, boxes(1, [0.4, 4.0, 0.13])).unwrap();
    let parse = |text: &str, overrides: &[&str]| {
        let choices = Choices {
            variant: None,
            overrides: overrides.iter().map(|&change| change.to_owned()).collect(),
        };
        case::parse("case", text, folder.path(), &choices).unwrap()
    };
    let text = |length_m: f64| {
        format!(
            "version = 1\n[air]\ndensity_kg_m3 = 1.0\nkinematic_viscosity_m2_s = 0.01\n[air.wind_tunnel]\nspeed_m_s = 1.0\n\
             size_m = [10.0, 6.0, 6.0]\nstart_time_s = 1.0\nsponge_length_m = 1.0\n[resolution]\ncell_size_m = 0.125\nlattice_speed = 0.1\n\
             operator = \"recursive_regularised\"\n[bodies.cubes]\nposition_m = [3.0, 3.0, 3.0]\n[bodies.cubes.mesh]\nfile = \"cubes.obj\"\n\
             scale = 1.0\naccept = [\"pieces\"]\n[bodies.cubes.reference]\narea_m2 = 1.0\nlength_m = {length_m:?}\n[coupling]\nscheme = \"links\"\n\
             [time]\nend_s = 30.0\n[output]\nsample_interval_s = 0.5\n"
        )
    };
    // What is slender casts a shadow of few samples, which are not taken for less.
    let thin = parse(
        &text(1.0),
        &[
            "bodies.cubes.mesh.file=beam.obj",
            "bodies.cubes.mesh.accept=absent",
        ],
    );
    let blockage = row(&thin, "blockage of the body").unwrap().value.unwrap();
    assert!(
        (blockage * 36.0 / (4.0 * 0.13) - 1.0).abs() < 1e-9,
        "{blockage}"
    );
    for length_m in [1.0, 3.0] {
        let case = parse(&text(length_m), &[]);
        let blockage = row(&case, "blockage of the body").unwrap().value.unwrap();
        assert!((blockage * 36.0 - 1.0).abs() < 0.01, "{blockage}");
        let cells = row(&case, "cells across the body").unwrap();
        assert_eq!(
            (cells.value, cells.valid),
            (Some(8.0), Some(false)),
            "{cells:?}"
        );
    }
}

fn late_pictures() {
    for (times, is_told) in [("[30.0, 31.5]", false), ("[31.5, 40.0]", true)] {
        let case = sphere(&[&format!("output.picture_times_s={times}")]);
        let warnings = Plan::new(&case.scene, Precision::F32).warnings(&case.scene);
        let told = "at 31.5 s, and the run ends at 30 s";
        let found = warnings.iter().any(|warning| warning.contains(told));
        assert_eq!(found, is_told, "{warnings:?}");
    }
}

/// The drag coefficients of a run, and the window of its means.
fn run(case: &Case) -> (Vec<Quantity>, Option<[f64; 2]>) {
    let plan = Plan::new(&case.scene, Precision::F32);
    let (simulation, record): (_, Record) = without_files(case, plan, None).unwrap();
    let results = results(&simulation, &Statics::default(), &record);
    let drags = results
        .iter()
        .filter(|(name, _)| name.ends_with("drag_coefficient"))
        .map(|(_, quantity)| quantity.clone())
        .collect();
    (drags, averaging_window_s(&case.scene, &record))
}

/// What is published stands beside a body alone in an even stream, on the area that the case refers to.
fn published_drags() {
    let short = ["time.end_s=6.0", "output.sample_interval_s=0.1"];
    let reference = |changes: &[&str]| {
        let (drags, window) = run(&sphere(&[&short[..], changes].concat()));
        let [first, last] = window.expect("means have a window");
        assert!(
            first > 0.0 && first < last && last <= 6.0 + 1e-9,
            "{first} {last}"
        );
        drags.iter().map(|drag| drag.reference).collect::<Vec<_>>()
    };
    let plain = reference(&[])[0].unwrap();
    let half = format!(
        "bodies.sphere.reference.area_m2={}",
        0.125 * std::f64::consts::PI
    );
    let on_half = reference(&[&half])[0].unwrap();
    assert!((on_half / plain - 2.0).abs() < 1e-9, "{plain} {on_half}");
    let other = "bodies.other={ position_m = [4.0, 2.0, 2.0], sphere = { diameter_m = 1.0 } }";
    let cells = [
        "resolution.cells_per_diameter=absent",
        "resolution.cell_size_m=0.125",
    ];
    assert_eq!(reference(&[cells[0], cells[1], other]), [None, None]);
}

/// A sphere that swings through half a period: its mean drag is that of no state.
fn half_a_period() {
    let (drags, _) = run(&sphere(&[
        "bodies.sphere.motion.oscillation.frequency_hz=0.1",
        "bodies.sphere.motion.oscillation.displacement_m=[0.8, 0.0, 0.0]",
        "time.end_s=5.0",
        "output.sample_interval_s=0.1",
    ]));
    let why = drags[0].unresolved.as_deref();
    assert!(
        why.is_some_and(|why| why.contains("not settled")),
        "{:?}",
        drags[0]
    );
}

const THIN_WING: &str = r#"
version = 1
title = "A thin wing"
[air]
density_kg_m3 = 1.0
kinematic_viscosity_m2_s = 1e-3
[air.wind_tunnel]
speed_m_s = 1.0
size_m = [6.0, 6.0, 4.0]
start_time_s = 1.0
[resolution]
cell_size_m = 0.08
lattice_speed = 0.08
operator = "stabilised_regularised"
[coupling]
scheme = "links"
[bodies.wing]
position_m = [2.0, 3.0, 2.0]
rotation = { axis = [0.0, 1.0, 0.0], angle_deg = 4.0 }
friction = "model"
[bodies.wing.wing]
naca = "0006"
stations = [{ position_m = [0.0, 0.0, 0.0], chord_m = 1.0 }, { position_m = [0.0, 1.5, 0.3], chord_m = 1.0 }]
[time]
end_s = 10.0
[output]
sample_interval_s = 0.1
"#;

/// A wing that is pitched and arched stands in a box far thicker than its sections.
fn thin_closed_wing() {
    let case = case::parse("case", THIN_WING, Path::new("."), &Choices::default()).unwrap();
    let plan = Plan::new(&case.scene, Precision::F32);
    let rows = validity::beforehand(&case.scene, &plan);
    let row = rows
        .iter()
        .find(|row| row.name == "cells across the thickness, cut links")
        .unwrap();
    // The largest thickness is 0.75 cells, half of the sections are thinner than 0.57.
    let cells = row.value.unwrap();
    assert!((0.48..0.66).contains(&cells), "{cells}");
    assert_eq!(row.valid, Some(false));
}

/// Bodies that stand in one another share the force arbitrarily.
fn bodies_in_one_place() {
    let sphere = Body {
        cells: 12.0,
        ..SPHERE
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, place_m, share) in [
        ("same", [5.0, 5.0, 5.0], Some(0.99..1.01)),
        ("half", [5.0, 5.5, 5.0], Some(0.18..0.32)),
        ("apart", [5.0, 7.0, 5.0], None),
    ] {
        let text = sphere.text().replace(
            "cells_per_diameter = 12.0",
            &format!("cell_size_m = {:?}", 1.0 / 12.0),
        ) + &format!(
            "[bodies.other]\nposition_m = {place_m:?}\n[bodies.other.sphere]\ndiameter_m = 1.0\n"
        );
        let path = folder.path().join(format!("{name}.toml"));
        std::fs::write(&path, text).unwrap();
        let case = case::load(&path, &Choices::default()).unwrap();
        let plan = Plan::new(&case.scene, Precision::F32);
        let rows = validity::beforehand(&case.scene, &plan);
        for body in ["sphere", "other"] {
            let wanted = format!("{body}: overlap with another body");
            let row = rows.iter().find(|row| row.name == wanted);
            let value = row.map(|row| row.value.unwrap());
            match &share {
                Some(share) => assert!(share.contains(&value.unwrap()), "{name}: {value:?}"),
                None => assert_eq!(value, None, "{name}"),
            }
            let prefix = format!("{body}_");
            assert!(row.is_none_or(|row| row.valid == Some(false) && row.prefix == prefix));
        }
        if share.is_some() {
            let strict = ripstop(&["check", path.to_str().unwrap(), "--strict"]);
            assert_eq!(strict.code, 1, "{name}");
            let finding = "other: overlap with another body";
            assert!(strict.errors.contains(finding), "{}", strict.errors);
        }
    }
}
