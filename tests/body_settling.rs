//! `[steady]` of rigid bodies: a run that stops by itself, one that is too short, one that keeps its symmetry, and the correction for walls.

use libtest_mimic::Trial;

use crate::command_line::{ripstop, root};
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        plain("body_settling::a_steady_sphere_stops_by_itself", stops),
        plain("body_settling::all_bodies_must_be_known", two),
        plain("body_settling::a_short_run_says_so", short),
        plain("body_settling::a_disk_is_corrected_for_walls", disk),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Runs the shipped sphere, coarse and in a small box, with changes; what it prints, and its summary.
fn run(changes: &[&str]) -> (String, serde_json::Value) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut arguments = vec![
        "run",
        "cases/sphere.toml",
        "--engine",
        "cpu",
        "--all",
        "--out",
        out.to_str().unwrap(),
    ];
    for change in [
        "resolution.cells_per_diameter=6.0",
        "resolution.lattice_speed=0.1",
        "air.wind_tunnel.size_m=[0.5, 0.4, 0.4]",
        "air.wind_tunnel.sponge_length_m=0.1",
        "bodies.sphere.position_m=[0.2, 0.2, 0.2]",
        "output.sample_interval_s=2.0",
    ]
    .iter()
    .chain(changes)
    {
        arguments.extend(["--set", change]);
    }
    let output = ripstop(&arguments);
    assert_eq!(output.code, 0, "{}", output.errors);
    let summary = std::fs::read(out.join("summary.json")).unwrap();
    (output.printed, serde_json::from_slice(&summary).unwrap())
}

/// D/U is 6.67 s: averaging begins after 66.7 s and needs 26.7.
fn stops() {
    assert!(root().join("cases/sphere.toml").exists());
    let (printed, summary) = run(&["steady.drag_confidence=0.02", "time.end_s=400.0"]);
    assert!(
        printed.contains("stopped: steady: the mean drag coefficient"),
        "{printed}"
    );
    let when = summary["stop"]["when_s"].as_f64().unwrap();
    assert!((93.0..140.0).contains(&when), "{when}");
    let drag = &summary["results"]["drag_coefficient"];
    let half = drag["confidence"].as_f64().unwrap();
    assert!(half <= 0.02 * drag["value"].as_f64().unwrap(), "{drag}");
    // Six cells are too few, but it has settled.
    let unresolved = drag["unresolved"].as_str().unwrap();
    assert!(!unresolved.contains("not settled"), "{drag}");
    // Force and coefficient are means of the same samples, with the same interval.
    let force = &summary["results"]["force_x_n"];
    let scale = force["value"].as_f64().unwrap() / drag["value"].as_f64().unwrap();
    let interval = force["confidence"].as_f64().unwrap() / scale;
    assert!((interval / half - 1.0).abs() < 1e-6, "{interval} {half}");
    // No law for the walls of a sphere at Re 100.
    let corrected = &summary["results"]["drag_coefficient_blockage_corrected"];
    assert!(corrected["value"].is_null(), "{corrected}");
    assert!(
        corrected["note"]
            .as_str()
            .unwrap()
            .contains("no correction"),
        "{corrected}"
    );
}

/// The run waits for the larger of two spheres, whose D/U is longer, and says whose drag is known least.
fn two() {
    let (printed, summary) = run(&[
        "resolution.cells_per_diameter=absent",
        "resolution.cell_size_m=0.02",
        "air.wind_tunnel.size_m=[0.5, 0.7, 0.4]",
        "bodies.other.position_m=[0.2, 0.5, 0.2]",
        "bodies.other.sphere.diameter_m=0.08",
        "steady.drag_confidence=0.05",
        "time.end_s=400.0",
    ]);
    assert!(printed.contains(", known least, "), "{printed}");
    let when = summary["stop"]["when_s"].as_f64().unwrap();
    assert!((93.0..200.0).contains(&when), "{when}");
    for name in ["sphere_drag_coefficient", "other_drag_coefficient"] {
        let drag = &summary["results"][name];
        let half = drag["confidence"].as_f64().unwrap();
        assert!(half <= 0.05 * drag["value"].as_f64().unwrap(), "{drag}");
    }
}

fn short() {
    let (_, summary) = run(&["steady.drag_confidence=0.3", "time.end_s=40.0"]);
    assert_eq!(summary["stop"]["reason"], "end time reached");
    for name in ["drag_coefficient", "lift_coefficient", "moment_y_n_m"] {
        let why = summary["results"][name]["unresolved"].as_str().unwrap();
        assert!(
            why.contains("not settled") && why.contains("10 L/U"),
            "{why}"
        );
    }
}

/// A disk at Re 1000: a wake that may shed vortices is given more time, and the walls are corrected for.
fn disk() {
    let (_, summary) = run(&[
        "steady.drag_confidence=0.3",
        "time.end_s=40.0",
        "bodies.sphere.sphere=absent",
        "bodies.sphere.disk.diameter_m=0.1",
        "air.kinematic_viscosity_m2_s=1.5e-6",
        "resolution.eddy_viscosity.model=smagorinsky",
        "resolution.eddy_viscosity.constant=0.15",
    ]);
    let result = |name: &str| summary["results"][name]["value"].as_f64().unwrap();
    let drag = result("drag_coefficient");
    let ratio = 1.0 + 1.85 * drag * result("blockage_ratio");
    assert!((1.07..1.25).contains(&ratio), "{ratio}");
    let corrected = result("drag_coefficient_blockage_corrected");
    assert!((corrected * ratio / drag - 1.0).abs() < 1e-9, "{corrected}");
    let why = &summary["results"]["drag_coefficient"]["unresolved"];
    assert!(why.as_str().unwrap().contains("30 L/U"), "{why}");
}
