//! `ripstop sweep`: kept, failing and interrupted runs, exit codes, files.

use libtest_mimic::Trial;

use crate::command_line::ripstop;
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        plain("sweep::one_run_fails_and_the_others_are_kept", one_fails),
        plain("sweep::a_killed_one_goes_on", killed),
        plain("sweep::usage_errors", usage_errors),
        plain("sweep::three_lattices_tell_their_error", three_lattices),
        plain("sweep::starts_of_an_ensemble_tell_an_interval", ensemble),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const CHAIN: &str = "cases/cloth/hanging-chain.toml";

/// A small sphere that the wind has hardly reached, on lattices that are all too coarse for it.
const SPHERE: [&str; 9] = [
    "sweep",
    "cases/sphere.toml",
    "--variant",
    "quick",
    "--set",
    "time.end_s=4.0",
    "--engine",
    "cpu",
    "--out",
];

fn read_json(path: &std::path::Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn rung<'a>(ladder: &'a serde_json::Value, name: &str) -> &'a serde_json::Value {
    let rungs = ladder["rungs"].as_array().unwrap();
    let found = rungs.iter().find(|rung| rung["result"] == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

/// Makes a ledger tell that a program with another checksum computed the run.
fn of_another_build(path: &std::path::Path) {
    let mut ledger = read_json(path);
    let checksum = &mut ledger["sessions"][0]["program"]["executable_crc32"];
    assert!(checksum.is_string(), "{checksum}");
    *checksum = "00000000".into();
    std::fs::write(path, ledger.to_string()).unwrap();
}

fn three_lattices() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let arguments = |cells: &'static str| {
        let mut all = SPHERE.to_vec();
        all.extend([
            out.to_str().unwrap(),
            "--vary",
            cells,
            "--result",
            "drag_coefficient",
        ]);
        all
    };
    let two = ripstop(&arguments("resolution.cells_per_diameter=5,8"));
    assert_eq!(two.code, 0, "{}", two.errors);
    assert!(
        two.printed.contains("unknown: two lattices, spread "),
        "{}",
        two.printed
    );
    let three = ripstop(&arguments("resolution.cells_per_diameter=5,8,6"));
    assert_eq!(three.code, 0, "{}", three.errors);
    assert_eq!(
        three.errors.matches("kept, it is done").count(),
        2,
        "{}",
        three.errors
    );
    assert!(!three.errors.contains("another build"), "{}", three.errors);
    assert!(
        three.printed.contains("| 5 | 6 | 8 | order |"),
        "{}",
        three.printed
    );
    let row = three
        .printed
        .lines()
        .find(|line| line.starts_with('|') && line.contains("unresolved: "));
    assert!(
        row.is_some_and(|row| row.contains("drag_coefficient")),
        "{}",
        three.printed
    );
    let json = read_json(&out.join("sweep.json"));
    let ladder = &json["ladders"][0];
    let drag = rung(ladder, "drag_coefficient");
    assert_eq!(drag["resolved"], false);
    let values: Vec<f64> = (0..3)
        .map(|k| drag["values"][k].as_f64().unwrap())
        .collect();
    let spread = values.iter().copied().fold(f64::MIN, f64::max)
        - values.iter().copied().fold(f64::MAX, f64::min);
    // An error of at least a good part of what the lattices differ by, and more than 5 % of the value.
    let error = drag["lattice_error"].as_f64().unwrap();
    assert!(error > 0.2 * spread && error > 0.05 * values[2], "{drag}");
    // The mark stands beside the result of every run, and reads back.
    for run in json["runs"].as_array().unwrap() {
        let why = run["results"]["drag_coefficient"]["unresolved"].as_str();
        assert!(
            why.is_some_and(|why| why.contains("finest lattice")),
            "{run}"
        );
    }
    // One page for all: each run with its picture and its case, and what the lattices tell.
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(page.matches("<img ").count(), 3);
    for told in [
        "What the lattices tell",
        "finest lattice",
        "3 of 3 runs done",
        "[bodies.sphere]",
    ] {
        assert!(page.contains(told), "{told} is not on the page");
    }
    let text = std::fs::read_to_string(out.join("ladder.csv")).unwrap();
    assert!(
        text.starts_with("series,result,unit,lattice_1,cell_size_m_1,"),
        "{text}"
    );
}

fn ensemble() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let mut arguments = SPHERE.to_vec();
    arguments.extend([out.to_str().unwrap(), "--ensemble", "3"]);
    arguments.extend(["--set", "resolution.cells_per_diameter=5"]);
    let first = ripstop(&arguments);
    assert_eq!(first.code, 0, "{}", first.errors);
    assert!(
        first.printed.contains("unknown: one lattice"),
        "{}",
        first.printed
    );
    let json = read_json(&out.join("sweep.json"));
    let drag = |start: usize| {
        let run = &json["runs"][start];
        assert_eq!(run["folder"], format!("start={}", start + 1));
        run["results"]["drag_coefficient"]["value"]
            .as_f64()
            .unwrap()
    };
    let drags = [drag(0), drag(1), drag(2)];
    let mean = drags.iter().sum::<f64>() / 3.0;
    for own in drags {
        // The same sphere, elsewhere on the lattice.
        assert!((own / mean - 1.0).abs() < 0.1, "{drags:?}");
    }
    assert!(drags[0] != drags[1] && drags[1] != drags[2], "{drags:?}");
    let told = rung(&json["ladders"][0], "drag_coefficient");
    assert!((told["values"][0].as_f64().unwrap() - mean).abs() < 1e-12);
    let squares: f64 = drags.iter().map(|own| (own - mean).powi(2)).sum();
    let one_run = 4.303 * (0.5 * squares).sqrt();
    let half = told["intervals"][0].as_f64().unwrap();
    let shrunk = match told["interval_of"].as_str().unwrap() {
        "one of 3 starts" => 1.0,
        "mean of 3 starts" => 3_f64.sqrt(),
        other => panic!("{other}"),
    };
    assert!((half * shrunk / one_run - 1.0).abs() < 1e-9, "{told}");
    let folders = json["runs"].as_array().unwrap();
    let one = folders[1]["folder"].as_str().unwrap();
    of_another_build(&out.join(one).join("run.json"));
    let again = ripstop(&arguments);
    assert_eq!(
        again.errors.matches("kept, it is done").count(),
        3,
        "{}",
        again.errors
    );
    let others = format!("another build of the program were kept: {one};");
    assert!(again.errors.contains(&others), "{}", again.errors);
    let refused = ripstop(&["sweep", "cases/taylor-green.toml", "--ensemble", "2"]);
    assert_eq!(refused.code, 2);
    assert!(
        refused.errors.contains("neither a structure nor a body"),
        "{}",
        refused.errors
    );
}

/// A chain whose equilibrium needs more evaluations than one run is allowed.
fn one_fails() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let arguments = [
        "sweep",
        CHAIN,
        "--vary",
        "equilibrium.evaluation_limit=1,2000",
        "--result",
        "sag_m",
        "--out",
        out.to_str().unwrap(),
    ];
    let first = ripstop(&arguments);
    assert_eq!(first.code, 20, "{}", first.errors);
    assert!(
        first
            .errors
            .contains("evaluation_limit=1: the static equilibrium was not reached"),
        "{}",
        first.errors
    );
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let text = read("sweep.md");
    assert_eq!(first.printed.lines().next(), text.lines().next());
    assert!(text.contains("| 2000 | done | "), "{text}");
    assert!(text.contains("| 1 | failed † | "), "{text}");
    assert!(read("sweep.csv").starts_with("equilibrium.evaluation_limit,folder,status,"));
    let json: serde_json::Value = serde_json::from_str(&read("sweep.json")).unwrap();
    let good = &json["runs"][1];
    assert_eq!(good["status"], "done");
    let own = out.join("evaluation_limit=2000");
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(own.join("summary.json")).unwrap()).unwrap();
    assert_eq!(good["results"]["sag_m"], summary["results"]["sag_m"]);
    assert!(out.join("sweep_sag_m.png").exists());

    // Again: the good run stays as it is, the other one is tried anew.
    let written = |path: &std::path::Path| std::fs::metadata(path).unwrap().modified().unwrap();
    let before = written(&own.join("summary.json"));
    let again = ripstop(&arguments);
    assert_eq!(again.code, 20);
    assert!(
        again.errors.contains("evaluation_limit=2000: kept"),
        "{}",
        again.errors
    );
    assert_eq!(written(&own.join("summary.json")), before);
    assert_eq!(read("sweep.md"), text);

    // Another case under the same name is not taken for it.
    let mut changed = arguments.to_vec();
    changed.extend(["--set", "title=another"]);
    let refused = ripstop(&changed);
    assert_eq!(refused.code, 73, "{}", refused.errors);
    assert!(
        refused
            .errors
            .contains("evaluation_limit=1, evaluation_limit=2000; --overwrite"),
        "{}",
        refused.errors
    );
    assert_eq!(written(&own.join("summary.json")), before);
    changed.push("--overwrite");
    let changed = ripstop(&changed);
    assert_eq!(changed.code, 20, "{}", changed.errors);
    assert!(!changed.errors.contains("kept"), "{}", changed.errors);
}

/// A sweep that is killed goes on from its run's own checkpoint; what it keeps stays as it is to the last digit.
fn killed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let mut arguments = vec!["sweep", crate::command_line::CANOPY, "--engine", "cpu"];
    for change in crate::folders::SMALL {
        arguments.extend(["--set", change]);
    }
    arguments.extend(["--vary", "time.end_s=0.01,0.1"]);
    arguments.extend(["--out", out.to_str().unwrap()]);
    let often = [&arguments[..], &["--checkpoint-every", "0.05"]].concat();
    let mut child = crate::folders::start(crate::command_line::command(&often));
    let own = out.join("end_s=0.1");
    crate::folders::wait_for(&mut child, &own.join("checkpoint"));
    child.kill().unwrap();
    child.wait().unwrap();
    let first = read_json(&out.join("sweep.json"));
    let again = ripstop(&arguments);
    assert_eq!(again.code, 0, "{}", again.errors);
    for needle in ["end_s=0.01: kept, it is done", "resumed at t = "] {
        assert!(again.errors.contains(needle), "{}", again.errors);
    }
    let second = read_json(&out.join("sweep.json"));
    assert_eq!(first["runs"][0]["results"], second["runs"][0]["results"]);
    assert_eq!(second["runs"][1]["status"], "done");
    // No state is kept of every run.
    assert!(!own.join("final.checkpoint").exists() && !own.join("checkpoint").exists());
    // One of the numbers that lost a digit on their way through a file.
    let text = "1.1229186340710127";
    let read: f64 = serde_json::from_str(text).unwrap();
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
}

fn usage_errors() {
    let refused = |arguments: &[&str], needle: &str| {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("sweep");
        let mut all = vec!["sweep", CHAIN, "--out", out.to_str().unwrap()];
        all.extend(arguments);
        let output = ripstop(&all);
        assert_eq!(output.code, 2, "{arguments:?}");
        assert!(output.errors.contains(needle), "{}", output.errors);
        assert!(!out.exists(), "{arguments:?}");
    };
    refused(&[], "--vary");
    refused(&["--vary", "time.end_s"], "no `=`");
    refused(&["--vary", "a=1,2;b=3"], "need as many");
    refused(&["--vary", "a=1", "--vary", "a=2"], "varies twice");
    // The last value is wrong, and nothing has run.
    refused(
        &["--vary", "equilibrium.evaluation_limit=100,0"],
        "evaluation_limit",
    );
    refused(&["--vary", "wings=absent"], "no such key");
    refused(
        &[
            "--vary",
            "equilibrium.evaluation_limit=100",
            "--result",
            "lift",
        ],
        "sag_m",
    );
}
