//! Runs that go on after their end, and others that begin from it.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::plan::{Disk, Plan, Precision};

use crate::command_line::{CANOPY, Finished, finished, root};
use crate::engines::plain;
use crate::folders::{SMALL, canopy, canopy_of, contents, json, start, wait_for};
use crate::resumption::{run, same};

pub fn trials() -> Vec<Trial> {
    [
        plain("extension::a_finished_run_goes_on", a_finished_run_goes_on),
        plain(
            "extension::another_run_begins_from_it",
            another_run_begins_from_it,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn times_s(out: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(out.join("history.csv")).unwrap();
    let rows = text.lines().skip(1);
    rows.map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect()
}

fn reached_s(out: &Path) -> f64 {
    json(&out.join("run.json"))["reached"]["time_s"]
        .as_f64()
        .unwrap()
}

/// A run that is made longer after its end delivers the bits of one that was so from the start.
fn a_finished_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole", "longer"].map(|name| folder.path().join(name));
    assert_eq!(run(&whole, "0.06", &[]).code, 0);
    assert_eq!(run(&out, "0.03", &[]).code, 0);
    assert!(out.join("final.checkpoint").exists() && !out.join("checkpoint").exists());
    let over = run(&out, "0.03", &["--resume"]);
    assert_eq!(over.code, 2, "{}", over.errors);
    assert!(
        over.errors.contains("raise time.end_s, or give --extend"),
        "{}",
        over.errors
    );
    let output = run(&out, "0.06", &["--resume"]);
    assert_eq!(output.code, 0, "{}", output.errors);
    same(&whole, &out);

    // What `check` says of the disk.
    let choices = Choices {
        variant: None,
        overrides: SMALL.iter().map(|&change| change.to_owned()).collect(),
    };
    let case = case::load(&root().join(CANOPY), &choices).unwrap();
    let told = Disk::new(&case.scene, &Plan::new(&case.scene, Precision::F32).sizes);
    let with_interval = |interval_s: f64| {
        let mut scene = case.scene.clone();
        scene.output.sample_interval_s = interval_s;
        scene.output.animation_interval_s = Some(interval_s);
        Disk::new(&scene, &Plan::new(&scene, Precision::F32).sizes).most
    };
    assert_eq!(with_interval(1e-300), u64::MAX, "more than can be counted");
    let found = contents(&out)["final.checkpoint"].len() as f64;
    let ratio = told.checkpoint as f64 / found;
    assert!(
        (0.9..1.4).contains(&ratio),
        "{} for {found}",
        told.checkpoint
    );

    // By some time; killed, it goes on to where it was to go.
    if cfg!(unix) {
        let mut child = start(canopy(
            &out,
            &["--set", "time.end_s=0.06", "--extend", "0.05"],
        ));
        wait_for(&mut child, &out.join("checkpoint"));
        child.kill().unwrap();
        child.wait().unwrap();
        let output = run(&out, "0.06", &["--resume"]);
        assert_eq!(output.code, 0, "{}", output.errors);
        assert!(
            (reached_s(&out) / 0.11 - 1.0).abs() < 0.01,
            "{}",
            reached_s(&out)
        );
        let times = times_s(&out);
        // No sample is there twice, none is missing.
        for pair in times.windows(2) {
            let whole = times[1] - times[0];
            assert!(((pair[1] - pair[0]) / whole - 1.0).abs() < 0.1, "{pair:?}");
        }
    }

    let forgetful = folder.path().join("forgetful");
    assert_eq!(run(&forgetful, "0.01", &["--no-final-state"]).code, 0);
    assert!(!forgetful.join("final.checkpoint").exists());
    let refused = run(&forgetful, "0.01", &["--extend", "0.01"]);
    assert_eq!(refused.code, 2, "{}", refused.errors);
    assert!(
        refused.errors.contains("left no state"),
        "{}",
        refused.errors
    );
}

fn restart(from: &Path, out: &Path, more: &[&str]) -> Finished {
    let mut command = canopy_of(&["restart", from.to_str().unwrap()], out, more);
    finished(command.output().unwrap())
}

/// Another run from a settled state: with its own samples and outputs, and the state that the first would have come to.
fn another_run_begins_from_it() {
    let folder = tempfile::tempdir().unwrap();
    let [settled, out] = ["settled", "out"].map(|name| folder.path().join(name));
    assert_eq!(run(&settled, "0.03", &[]).code, 0);
    let to = ["--set", "time.end_s=0.05"];
    let wind = ["--set", "air.wind_tunnel.speed_m_s=25.0"];
    let other = restart(&settled, &out, &[&to[..], &wind].concat());
    assert_eq!(other.code, 2, "{}", other.errors);
    let needle = "air.wind_tunnel.speed_m_s was 30.0, is now 25.0";
    assert!(other.errors.contains(needle), "{}", other.errors);
    let itself = restart(&settled, &settled, &to);
    assert_eq!(itself.code, 2, "{}", itself.errors);
    // As if the state had been computed elsewhere.
    let mut ledger = json(&settled.join("run.json"));
    let genuine = ledger.to_string();
    let session = &mut ledger["sessions"][0];
    session["program"]["version"] = "0.0.9".into();
    session["machine"]["processor"] = "Another CPU".into();
    std::fs::write(settled.join("run.json"), ledger.to_string()).unwrap();
    let before = contents(&settled);
    let output = restart(&settled, &out, &to);
    assert_eq!(output.code, 0, "{}", output.errors);
    for needle in [
        "before, the state was computed by version 0.0.9",
        "Another CPU",
    ] {
        assert!(output.printed.contains(needle), "{}", output.printed);
    }
    assert!(before == contents(&settled), "the first run was touched");
    std::fs::write(settled.join("run.json"), genuine).unwrap();
    // It did none of the solves of the first run.
    let steps = |out: &Path| json(&out.join("summary.json"))["steps"].as_u64().unwrap();
    let own = steps(&out) - steps(&settled);
    let rows = json(&out.join("summary.json"))["account"].to_string();
    let solves = format!("of {own} solves");
    assert!(rows.contains(&solves), "{solves} is not in {rows}");
    assert!(
        output.printed.contains("begun from the state in"),
        "{}",
        output.printed
    );
    let ledger = json(&out.join("run.json"));
    assert_eq!(ledger["begun_from"], settled.to_str().unwrap());
    let first_s = times_s(&out)[0];
    assert!((0.03..0.0325).contains(&first_s), "{first_s}");
    // It may be done again, but the same case from rest is another run.
    let from_rest = run(&out, "0.05", &[]);
    assert_eq!(from_rest.code, 73, "{}", from_rest.errors);
    assert!(
        from_rest.errors.contains("from the state in"),
        "{}",
        from_rest.errors
    );
    let again = restart(&settled, &out, &to);
    assert_eq!(again.code, 0, "{}", again.errors);
    assert!(
        !again.printed.contains("before, the state"),
        "{}",
        again.printed
    );
    // The first run, made as long, ends in the same state.
    let output = run(&settled, "0.05", &["--resume"]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let last = |out: &Path| {
        let all = contents(out);
        let name = all
            .keys()
            .rfind(|n| n.starts_with("frames/canopy_0"))
            .unwrap();
        all[name].clone()
    };
    assert!(last(&settled) == last(&out), "the states differ");
}
