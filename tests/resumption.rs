//! What a resumed run finds of itself, what of its case may change, and that it always ends with a summary.

use std::collections::BTreeMap;
use std::path::Path;

use libtest_mimic::Trial;

use crate::command_line::{Finished, finished};
use crate::engines::plain;
use crate::folders::{canopy, contents, json, start, wait_for};

pub fn trials() -> Vec<Trial> {
    if !cfg!(unix) {
        return Vec::new();
    }
    [
        plain("resumption::lost_files_are_named", lost_files),
        plain(
            "resumption::a_fresh_start_leaves_no_old_checkpoint",
            no_old_checkpoint,
        ),
        plain(
            "resumption::length_may_change_physics_not",
            length_may_change,
        ),
        plain(
            "resumption::the_summary_comes_first",
            the_summary_comes_first,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const FRAMES: [&str; 4] = [
    "--set",
    "output.animation_interval_s=0.005",
    "--set",
    "output.flow_interval_s=0.01",
];

fn end_at(end_s: &str) -> [String; 2] {
    ["--set".to_owned(), format!("time.end_s={end_s}")]
}

/// A whole run, or what is left of it.
pub fn run(out: &Path, end_s: &str, more: &[&str]) -> Finished {
    let end = end_at(end_s);
    let mut all: Vec<&str> = end.iter().map(String::as_str).collect();
    all.extend(more);
    if !more.contains(&"--checkpoint-every") {
        // Every checkpoint waits for the disk.
        all.extend(["--checkpoint-every", "1000"]);
    }
    finished(canopy(out, &all).output().unwrap())
}

/// Starts a run and kills it once it has written `file` and a checkpoint after it.
fn killed_after(out: &Path, end_s: &str, more: &[&str], file: &str) {
    let end = end_at(end_s);
    let all: Vec<&str> = end
        .iter()
        .map(String::as_str)
        .chain(more.iter().copied())
        .collect();
    let mut child = start(canopy(out, &all));
    wait_for(&mut child, &out.join(file));
    let last = || std::fs::metadata(out.join("checkpoint")).and_then(|m| m.modified());
    let before = last().ok();
    while last().ok() == before {
        assert!(child.try_wait().unwrap().is_none(), "ended too early");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

fn results(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = contents(out);
    all.remove("summary.json").unwrap();
    all.remove("run.json").unwrap();
    all.remove("run.log").unwrap();
    // It shows when the run was computed.
    all.remove("report.html");
    all
}

pub fn same(a: &Path, b: &Path) {
    let [a, b] = [a, b].map(results);
    assert!(a.keys().eq(b.keys()), "{:?} {:?}", a.keys(), b.keys());
    for (name, bytes) in &a {
        assert!(b[name] == *bytes, "{name} differs");
    }
}

/// A frame that has gone, one that is cut short, and a box of finer cells that is missing: the run goes on, ends with its summary, and lists only what is there.
fn lost_files() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    killed_after(&out, "0.06", &FRAMES, "frames/canopy_00002.vtp");
    for name in ["frames/canopy_00001.vtp", "frames/flow_00001_box_1.vti"] {
        std::fs::remove_file(out.join(name)).unwrap();
    }
    let path = out.join("frames/animation_00001.png");
    let frame = std::fs::read(&path).unwrap();
    std::fs::write(&path, &frame[..frame.len() / 2]).unwrap();
    let output = run(&out, "0.06", &[&FRAMES[..], &["--resume"]].concat());
    assert_eq!(output.code, 0, "{}", output.errors);
    let list = std::fs::read_to_string(out.join("canopy.pvd")).unwrap();
    let listed: Vec<&str> = list
        .split("file=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    assert!(
        !listed.contains(&"frames/canopy_00001.vtp") && listed.contains(&"frames/canopy_00000.vtp")
    );
    assert!(listed.len() >= 5, "{listed:?}");
    for name in &listed {
        assert!(out.join(name).exists(), "{name} is listed and not there");
    }
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let list = std::fs::read_to_string(out.join("flow.pvd")).unwrap();
    assert!(list.contains("frames/flow_00000.vtm") && !list.contains("frames/flow_00001.vtm"));
    for needle in [
        "frames/canopy_00001.vtp is not there",
        "frames/flow_00001_box_1.vti is not there",
        "frames/animation_00001.png has ",
    ] {
        assert!(summary.contains(needle), "{needle}: {summary}");
    }
    assert!(summary.contains("warning: 1 of "), "{summary}");
    assert!(out.join("animation.png").exists());
}

/// Who forgets --resume is told; who overwrites and is killed early is not given the state of the run before.
fn no_old_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    killed_after(&out, "0.2", &[], "frames/canopy_00001.vtp");
    let before = contents(&out);
    let forgotten = run(&out, "0.2", &[]);
    assert_eq!(forgotten.code, 73, "{}", forgotten.errors);
    assert!(forgotten.errors.contains("--resume goes on with it"));
    let mut after = contents(&out);
    after.remove("run.lock");
    assert!(after.iter().all(|(name, bytes)| before[name] == *bytes));
    let seldom = ["--checkpoint-every", "1000"];
    let more = ["--overwrite", "--set", "time.end_s=0.2"];
    let mut child = start(canopy(&out, &[&more[..], &seldom].concat()));
    // The files of the run before go as the new one begins.
    while out.join("frames/canopy_00001.vtp").exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended too early");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let resumed = run(&out, "0.2", &["--resume"]);
    assert_eq!(resumed.code, 2, "{}", resumed.errors);
    // Killed before the new run wrote its case, or after.
    assert!(resumed.errors.contains("begin anew"), "{}", resumed.errors);
}

/// A run that is made longer delivers the bits of one that was so from the start; one of other physics is told which key differs.
fn length_may_change() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole", "longer"].map(|name| folder.path().join(name));
    assert_eq!(run(&whole, "0.06", &[]).code, 0);
    killed_after(&out, "0.05", &[], "frames/canopy_00001.vtp");
    let before = contents(&out);
    let wind = ["--set", "air.wind_tunnel.speed_m_s=25.0", "--resume"];
    let refused = run(&out, "0.05", &wind);
    assert_eq!(refused.code, 2, "{}", refused.errors);
    assert!(
        refused
            .errors
            .contains("air.wind_tunnel.speed_m_s was 30.0, is now 25.0"),
        "{}",
        refused.errors
    );
    let short = run(&out, "0.005", &["--resume"]);
    assert_eq!(short.code, 2, "{}", short.errors);
    assert!(
        short.errors.contains("behind time.end_s = 0.005 s"),
        "{}",
        short.errors
    );
    let mut after = contents(&out);
    after.remove("run.lock");
    assert!(after.iter().all(|(name, bytes)| before[name] == *bytes));
    // As if an older program on another machine had begun it.
    let mut ledger = json(&out.join("run.json"));
    ledger["sessions"][0]["program"]["version"] = "0.0.9".into();
    ledger["sessions"][0]["machine"]["processor"] = "Another CPU".into();
    std::fs::write(out.join("run.json"), ledger.to_string()).unwrap();
    let output = run(&out, "0.06", &["--resume"]);
    assert_eq!(output.code, 0, "{}", output.errors);
    for needle in [
        "time.end_s was 0.05, is now 0.06",
        "computed by version 0.0.9",
        "Another CPU",
        "the bits may differ",
    ] {
        assert!(output.printed.contains(needle), "{}", output.printed);
    }
    same(&whole, &out);
    let ledger = json(&out.join("run.json"));
    assert!(ledger["sessions"][1]["ended"].is_string());
}

/// What fails at the end does so after the summary, and can be done again.
fn the_summary_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::create_dir_all(out.join("animation.png")).unwrap();
    let output = run(&out, "0.02", &FRAMES);
    assert_eq!(output.code, 74, "{}", output.errors);
    assert!(output.errors.contains("animation.png"), "{}", output.errors);
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("warning: cannot write"), "{summary}");
    assert_eq!(json(&out.join("run.json"))["state"], "failed");
    std::fs::remove_dir(out.join("animation.png")).unwrap();
    let output = run(&out, "0.02", &[&FRAMES[..], &["--resume"]].concat());
    assert_eq!(output.code, 0, "{}", output.errors);
    assert!(out.join("animation.png").is_file());
}
