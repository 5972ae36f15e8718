//! `ripstop validate` as a user meets it, and its fastest problems on every engine.

use std::collections::BTreeSet;
use std::process::{Command, Stdio};

use libtest_mimic::Trial;
use ripstop::validate::PROBLEMS;

use crate::command_line::{program, ripstop, root};
use crate::engines::{needs_device, plain};
use crate::tolerances;

/// Problems that take some seconds on a CPU.
const FAST: [&str; 5] = [
    "poiseuille",
    "couette",
    "acoustic-pulse",
    "levels",
    "shear-layer",
];

/// Those that a software device computes in seconds. It meets walls in motion in `walls`, shear layers in `air`, and sound at inlet, outlet and sides in `sound` (at the outlet along its normal alone).
const FAST_ON_DEVICE: [&str; 2] = ["poiseuille", "levels"];

/// Flow through what air passes, and a fall in a box that follows.
const PERMEABLE: [&str; 3] = ["permeable-screen", "openings", "falling-disk"];

/// Walls along which the air slides, and the lift that they give a section and a wing.
const SLIDING: [&str; 3] = ["sliding-wall", "wall-friction", "wing-lift"];

/// The immersed boundary. Light canopies have trials of their own (`canopy`).
const COUPLING: [&str; 2] = ["immersed-boundary", "spherical-couette"];

/// Plates of fabric in the wind. `marker-spacing`, a long study, is left to `ripstop validate`.
const PLATES: [&str; 3] = ["force-routes", "flexible-plate", "flag"];

/// Panels and vortex lattices.
const AERODYNAMICS: [&str; 8] = [
    "potential-bodies",
    "plane-section",
    "rectangular-wings",
    "elliptic-wing",
    "viscous-sections",
    "wing-stall",
    "belloc-wing",
    "trim",
];

/// Problems of fabric and cables.
const FABRIC: [&str; 10] = [
    "membrane-patch",
    "catenary",
    "hencky",
    "airbag",
    "pressure-vessels",
    "shear-panel",
    "heavy-cantilever",
    "drum",
    "free-oscillations",
    "hostile-starts",
];

/// Those that a software device solves in seconds.
const FABRIC_ON_DEVICE: [&str; 2] = ["membrane-patch", "catenary"];

/// Gates of the problems of the quick set that trials compute, in 32 and 64 bits: one that a problem no longer adds would else be missed by nobody.
const GATES: [(&str, usize); 36] = [
    ("poiseuille", 3),
    ("couette", 9),
    ("acoustic-pulse", 6),
    ("levels", 8),
    ("shear-layer", 2),
    ("permeable-screen", 18),
    ("openings", 11),
    ("falling-disk", 2),
    ("sliding-wall", 6),
    ("wall-friction", 7),
    ("wing-lift", 2),
    ("immersed-boundary", 10),
    ("spherical-couette", 2),
    ("force-routes", 4),
    ("flexible-plate", 3),
    ("flag", 2),
    ("levels-around-bodies", 5),
    ("canopy-opening", 2),
    ("potential-bodies", 6),
    ("plane-section", 9),
    ("rectangular-wings", 4),
    ("elliptic-wing", 3),
    ("viscous-sections", 6),
    ("wing-stall", 5),
    ("belloc-wing", 5),
    ("trim", 6),
    ("membrane-patch", 3),
    ("catenary", 3),
    ("hencky", 3),
    ("airbag", 3),
    ("pressure-vessels", 3),
    ("shear-panel", 5),
    ("heavy-cantilever", 2),
    ("drum", 2),
    ("free-oscillations", 5),
    ("hostile-starts", 35),
];

pub fn trials() -> Vec<Trial> {
    // The longest first: what begins last ends alone.
    let mut trials = vec![needs_device(
        "validate::fast_problems::gpu".to_owned(),
        || problems(&FAST_ON_DEVICE, "gpu"),
    )];
    trials.extend(plain("validate::fabric::cpu", || problems(&FABRIC, "cpu")));
    trials.push(needs_device("validate::fabric::gpu".to_owned(), || {
        problems(&FABRIC_ON_DEVICE, "gpu");
    }));
    trials.extend(plain("validate::fast_problems::cpu_f32", || {
        problems(&FAST, "cpu");
    }));
    trials.extend(plain("validate::levels::cpu_f64", || {
        computed(&["levels"], "cpu", &["--precision", "f64"]);
    }));
    trials.extend(plain("validate::coupling::cpu_f32", || {
        problems(&COUPLING, "cpu");
    }));
    trials.extend(plain("validate::plates::cpu_f32", || {
        problems(&PLATES, "cpu");
    }));
    trials.extend(plain("validate::levels_around_bodies::cpu_f32", || {
        problems(&["levels-around-bodies"], "cpu");
    }));
    trials.extend(plain("validate::canopy_opening::cpu_f32", || {
        problems(&["canopy-opening"], "cpu");
    }));
    trials.push(needs_device("validate::coupling::gpu".to_owned(), || {
        problems(&COUPLING[..1], "gpu");
    }));
    trials.extend(plain("validate::permeable_screen::cpu_f32", || {
        problems(&PERMEABLE, "cpu");
    }));
    trials.extend(plain("validate::sliding_wall::cpu_f32", || {
        problems(&SLIDING, "cpu");
    }));
    trials.extend(plain("validate::aerodynamics::cpu", || {
        problems(&AERODYNAMICS, "cpu");
    }));
    trials.extend(plain("validate::bench_of_fabric::cpu", bench_of_fabric));
    trials.extend(plain("validate::usage_errors", usage));
    trials.extend(plain(
        "validate::accelerators_compute_every_problem",
        accelerator_script,
    ));
    trials.extend(plain("validate::sphere", sphere));
    if cfg!(unix) {
        trials.extend(plain("validate::interrupt", interrupt));
    }
    trials
}

/// `benches/accelerator.sh` names each problem but those of panels, which no device takes part in.
fn accelerator_script() {
    let script = std::fs::read_to_string(root().join("benches/accelerator.sh")).unwrap();
    let (_, list) = script.split_once("\nproblems=(").unwrap();
    let (list, _) = list.split_once(')').unwrap();
    let named: BTreeSet<&str> = list.split_whitespace().collect();
    let computed: BTreeSet<&str> = PROBLEMS
        .iter()
        .map(|problem| problem.name)
        .filter(|name| !AERODYNAMICS.contains(name))
        .collect();
    assert_eq!(named, computed);
}

fn problems(names: &[&str], engine: &str) {
    computed(names, engine, &[]);
}

fn computed(names: &[&str], engine: &str, choices: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    for &problem in names {
        let out = folder.path().join(problem);
        let given = [
            "validate",
            problem,
            "--engine",
            engine,
            "--out",
            out.to_str().unwrap(),
        ];
        let output = ripstop(&[&given[..], choices].concat());
        assert_eq!(output.code, 0, "{}{}", output.printed, output.errors);
        assert!(output.printed.contains(" 0 fail"), "{}", output.printed);
        let report: serde_json::Value =
            serde_json::from_slice(&std::fs::read(out).unwrap()).unwrap();
        assert_eq!(report["schema_version"], 1);
        assert_eq!(report["engine"], engine);
        assert_eq!(report["interrupted"], false);
        let rows = report["rows"].as_array().unwrap();
        let gated = rows.iter().filter(|row| row["holds"] == true).count();
        let known = GATES.iter().find(|(name, _)| *name == problem).unwrap();
        assert_eq!(gated, known.1, "{report}");
        for row in rows {
            assert_eq!(row["problem"], problem);
            assert!(row["value"].is_number(), "{row}");
            assert_ne!(row["holds"], false, "{row}");
        }
    }
}

/// The quick sizes of `ripstop bench fabric`: all converge, membranes better the finer they are, and springs as far as they can.
fn bench_of_fabric() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = ripstop(&["bench", "fabric", "--engine", "cpu", "--out", out]);
    assert_eq!(output.code, 0, "{}", output.errors);
    assert!(
        !output.printed.contains("not converged"),
        "{}",
        output.printed
    );
    let mut reader = csv::Reader::from_path(folder.path().join("fabric.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let errors = |problem: &str, model: &str| -> Vec<f64> {
        let of = rows
            .iter()
            .filter(|row| &row[0] == problem && &row[1] == model);
        of.map(|row| row[6].parse().unwrap()).collect()
    };
    for problem in ["disc", "airbag"] {
        let errors = errors(problem, "membrane");
        let falls = errors.windows(2).all(|pair| pair[1] < 0.5 * pair[0]);
        assert!(errors.len() > 1 && falls, "{problem}: {errors:?}");
        let best = errors[errors.len() - 1];
        assert!(best < tolerances::BENCH_MEMBRANE, "{problem}: {best}");
    }
    for problem in ["disc", "airbag"] {
        let errors = errors(problem, "network");
        let best = errors[errors.len() - 1];
        assert!(best < tolerances::BENCH_NETWORK, "{problem}: {best}");
    }
    assert!(folder.path().join("fabric-airbag.png").exists());
}

fn usage() {
    let output = ripstop(&["validate", "warp-drive"]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("poiseuille"), "{}", output.errors);
    let output = ripstop(&["bench", "warp-drive"]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("sphere"), "{}", output.errors);
    let output = ripstop(&["validate", "soak", "--engine", "gpu", "--precision", "f64"]);
    assert_eq!(output.code, 2, "{}", output.errors);
    // An unwritable file is noticed before anything is computed.
    let output = ripstop(&["validate", "--full", "--out", "no/such/folder/rows.json"]);
    assert_eq!(output.code, 74, "{}", output.errors);
}

fn interrupt() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("rows.json");
    let mut child = Command::new(program())
        .args([
            "validate",
            "beltrami",
            "--full",
            "--precision",
            "f64",
            "--out",
        ])
        .arg(&out)
        .current_dir(root())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !out.exists() {
        assert!(child.try_wait().unwrap().is_none());
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(out).unwrap()).unwrap();
    assert_eq!(report["interrupted"], true);
}

/// The drag of the sphere on the CPU, as the quick set computes it, with markers and at cut links: settled, within its band, the same by both routes.
fn sphere() {
    let output = ripstop(&["validate", "sphere", "--engine", "cpu"]);
    assert_eq!(output.code, 0, "{}{}", output.printed, output.errors);
    assert!(
        output.printed.contains("4 gates, 0 fail"),
        "{}",
        output.printed
    );
    assert!(
        !output.printed.contains("not settled"),
        "{}",
        output.printed
    );
}
