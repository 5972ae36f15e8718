//! Who a folder belongs to: the ledger, the lock, and what is refused.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use libtest_mimic::Trial;

use crate::command_line::{CANOPY, Finished, command, files, name_in, ripstop};
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    let mut trials = plain(
        "folders::the_ledger_tells_of_the_run",
        the_ledger_tells_of_the_run,
    )
    .into_iter()
    .chain(plain(
        "folders::other_runs_are_not_replaced_unasked",
        other_runs_are_not_replaced,
    ))
    .collect::<Vec<_>>();
    if cfg!(unix) {
        trials.extend(plain("folders::two_runs_in_one_folder", two_runs));
    }
    trials
}

/// Fabric alone, some tenths of a second of computing.
pub const SHEET: [&str; 4] = [
    "cases/cloth/hanging-sheet.toml",
    "--variant",
    "quick",
    "--engine=cpu",
];

/// `ripstop run` of that sheet, or of another one.
pub fn sheet(out: &Path, more: &[&str]) -> Finished {
    let mut arguments = vec!["run"];
    arguments.extend(SHEET);
    arguments.extend(["--out", out.to_str().unwrap()]);
    arguments.extend(more);
    ripstop(&arguments)
}

/// What makes the shipped canopy small.
pub const SMALL: [&str; 5] = [
    "resolution.cells_per_diameter=12.0",
    "structure.flat_circular.rings=8",
    "output.canopy_interval_s=0.01",
    "output.sample_interval_s=0.002",
    "output.picture_times_s=absent",
];

/// `ripstop run` of that canopy, with checkpoints as often as it is worth.
pub fn canopy(out: &Path, more: &[&str]) -> Command {
    canopy_of(&["run"], out, more)
}

/// The same with another command.
pub fn canopy_of(begin: &[&str], out: &Path, more: &[&str]) -> Command {
    let mut arguments = begin.to_vec();
    arguments.extend([CANOPY, "--out", out.to_str().unwrap()]);
    if !more.contains(&"--engine") {
        arguments.extend(["--engine", "cpu"]);
    }
    for change in SMALL {
        arguments.extend(["--set", change]);
    }
    if !more.contains(&"--checkpoint-every") {
        arguments.extend(["--checkpoint-every", "0.02"]);
    }
    arguments.extend(more);
    command(&arguments)
}

/// Starts it without a terminal.
pub fn start(mut command: Command) -> Child {
    command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Waits for a file of a run that must not end before.
pub fn wait_for(child: &mut Child, path: &Path) {
    while !path.exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended too early");
        std::thread::sleep(Duration::from_millis(2));
    }
}

pub fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// All files of a folder by their names.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    files(folder)
        .into_iter()
        .map(|path| {
            let name = name_in(folder, &path);
            (name, std::fs::read(path).unwrap())
        })
        .collect()
}

fn the_ledger_tells_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = sheet(&out, &["--set", "title=mine"]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let ledger = json(&out.join("run.json"));
    assert_eq!(ledger["state"], "finished");
    let case = &ledger["case"];
    assert_eq!(
        [&case["file"], &case["variant"], &case["overrides"][0]],
        [SHEET[0], SHEET[2], "title=mine"]
    );
    // The text holds what variant and override made of the case.
    let text: toml::Table = toml::from_str(case["text"].as_str().unwrap()).unwrap();
    assert_eq!(text["title"].as_str(), Some("mine"));
    assert_eq!(
        case["hash"],
        json(&out.join("summary.json"))["case"]["hash"]
    );
    let session = &ledger["sessions"][0];
    assert_eq!(session["program"]["version"], env!("CARGO_PKG_VERSION"));
    let ended = session["ended"].as_str().unwrap();
    assert!(session["began"].as_str().unwrap() <= ended && ended.ends_with('Z'));
    // Every file, with length and checksum, and no other.
    let mut there = contents(&out);
    there.remove("run.json").unwrap();
    there.remove("run.log").unwrap();
    let listed = ledger["files"].as_array().unwrap();
    assert_eq!(listed.len(), there.len(), "{:?}", there.keys());
    for entry in listed {
        let bytes = &there[entry["name"].as_str().unwrap()];
        assert_eq!(entry["bytes"], bytes.len());
        let crc = format!("{:08x}", crc32fast::hash(bytes));
        assert_eq!(entry["crc32"], crc, "{entry}");
    }
}

fn other_runs_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let refused = |output: Finished, needles: &[&str]| {
        assert_eq!(output.code, 73, "{}{}", output.printed, output.errors);
        for needle in needles {
            assert!(
                output.errors.contains(needle),
                "{needle}: {}",
                output.errors
            );
        }
    };
    assert_eq!(sheet(&out, &[]).code, 0);
    std::fs::write(out.join("thoughts.txt"), "mine").unwrap();
    let first = contents(&out);
    // A run that is over may be done again, but not be replaced by another: not even of the same file.
    assert_eq!(sheet(&out, &[]).code, 0);
    let other = ["--set", "gravity.acceleration_m_s2=[0.0, 0.0, -3.0]"];
    let again = contents(&out);
    refused(
        sheet(&out, &other),
        &[
            "a run of cases/cloth/hanging-sheet.toml --variant quick (finished at t = ",
            "gravity.acceleration_m_s2 was ",
            "--overwrite removes it, --out DIR takes another folder",
        ],
    );
    refused(
        sheet(&out, &["--set", "title=another"]),
        &["title was \"Hanging sheet\", is now \"another\""],
    );
    assert!(
        again == contents(&out),
        "the refused run changed the folder"
    );
    for (name, bytes) in &first {
        if !["summary.json", "run.json", "run.log", "report.html"].contains(&name.as_str()) {
            assert!(again[name] == *bytes, "{name} differs");
        }
    }
    // Of what the first run left, nothing stays that the other one does not write; what is not its own stays.
    std::fs::write(out.join("frames/canopy_00099.vtp"), "of the first").unwrap();
    let output = sheet(&out, &[&other[..], &["--overwrite"]].concat());
    assert_eq!(output.code, 0, "{}", output.errors);
    let after = contents(&out);
    assert_eq!(after["thoughts.txt"], b"mine");
    assert!(!after.contains_key("frames/canopy_00099.vtp"));
    // Files of a version without a ledger are another's.
    std::fs::remove_file(out.join("run.json")).unwrap();
    refused(sheet(&out, &other), &["of a run that kept no ledger"]);
    std::fs::write(out.join("run.json"), "{\"schema_version\": 1}").unwrap();
    refused(sheet(&out, &other), &["run.json cannot be read"]);
}

/// The second of two runs in one folder is refused with who holds it, whatever it asks for; after a kill, what can be gone on with is not lost.
fn two_runs() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let long = ["--set", "time.end_s=0.5"];
    let mut child = start(canopy(&out, &long));
    wait_for(&mut child, &out.join("checkpoint"));
    for more in [&["--overwrite"][..], &[]] {
        let second = sheet(&out, more);
        assert_eq!(second.code, 73, "{}", second.errors);
        let holder = format!("process {}", child.id());
        for needle in [holder.as_str(), CANOPY, "another run works in"] {
            assert!(second.errors.contains(needle), "{}", second.errors);
        }
    }
    assert!(child.try_wait().unwrap().is_none(), "the first run ended");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(json(&out.join("run.json"))["state"], "running");
    let killed = contents(&out);
    let ways = "--resume with its own case goes on with it, --overwrite removes it";
    let other = sheet(&out, &[]);
    assert_eq!(other.code, 73, "{}", other.errors);
    assert!(other.errors.contains(ways), "{}", other.errors);
    let same = crate::command_line::finished(canopy(&out, &long).output().unwrap());
    assert_eq!(same.code, 73, "{}", same.errors);
    let ways = "an unfinished run of this case (running or killed at t = ";
    assert!(same.errors.contains(ways), "{}", same.errors);
    let mut now = contents(&out);
    now.remove("run.lock");
    let mut before = killed;
    before.remove("run.lock");
    assert!(before == now, "a refused run changed the folder");
}
