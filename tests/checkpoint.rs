//! Runs that are killed, run out of space or find a damaged checkpoint, and what a resumed run delivers then.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use libtest_mimic::Trial;

use crate::command_line::{CANOPY, command, files, finished, name_in, program, root};
use crate::engines::{needs_device, plain};
use crate::folders::{json, start, wait_for};
use crate::tolerances;

pub fn trials() -> Vec<Trial> {
    // Signals and limits of file sizes are those of a Unix shell.
    if !cfg!(unix) {
        return Vec::new();
    }
    let mut trials: Vec<Trial> = [
        plain("checkpoint::killed_again_and_again", killed),
        plain("checkpoint::damaged_or_without_space", damaged),
    ]
    .into_iter()
    .flatten()
    .collect();
    trials.push(needs_device(
        "checkpoint::goes_on_elsewhere::gpu".to_owned(),
        elsewhere,
    ));
    trials
}

/// An end that no test comes to [s].
const NO_END_S: f64 = 1e3;

/// Names of checkpoints of a run that is not over.
const CHECKPOINTS: [&str; 3] = ["checkpoint", "checkpoint.next", "checkpoint.previous"];

/// Number of the frame that the last kills wait for.
const FARTHEST: usize = 3;

/// Kills of the short version; `RIPSTOP_KILLS` asks for more.
const KILLS: usize = 6;

/// A small canopy, with checkpoints as often as they can be written.
fn arguments(out: &Path, end_s: f64) -> Vec<String> {
    let end = format!("time.end_s={end_s}");
    let changes = [
        "resolution.cells_per_diameter=12.0",
        "structure.flat_circular.rings=8",
        "output.canopy_interval_s=0.01",
        "output.picture_times_s=[0.01]",
        "output.sample_interval_s=0.001",
        &end,
    ];
    let mut arguments: Vec<String> = ["run", CANOPY, "--out"].map(str::to_owned).to_vec();
    arguments.push(out.to_string_lossy().into_owned());
    for change in changes {
        arguments.extend(["--set".to_owned(), change.to_owned()]);
    }
    arguments
}

fn run(out: &Path, end_s: f64, more: &[&str]) -> Command {
    let arguments = arguments(out, end_s);
    let mut all: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if !more.contains(&"--checkpoint-every") {
        all.extend(["--checkpoint-every", "0.02"]);
    }
    all.extend(more);
    command(&all)
}

/// Every file but summary, ledger and log, which tell of the resumption, has the same bytes.
fn same_results(whole: &Path, resumed: &Path) {
    let names = |folder: &Path| {
        let mut names: Vec<String> = files(folder)
            .iter()
            .map(|path| name_in(folder, path))
            .collect();
        names.sort();
        names
    };
    assert_eq!(names(whole), names(resumed));
    for name in names(whole) {
        if !["summary.json", "run.json", "run.log", "report.html"].contains(&&name[..]) {
            let [a, b] = [whole, resumed].map(|folder| std::fs::read(folder.join(&name)).unwrap());
            assert!(a == b, "{name} differs");
        }
    }
}

/// SIGKILL at random moments, also while files and checkpoints are written: the run that goes on from what is left delivers the bits of one
/// that was never touched.
///
/// While it is killed the run has no end in sight, so that no kill comes after it; each but the first waits for a checkpoint of its own, so that all
/// goes on; the first finds none.
fn killed() {
    let folder = tempfile::tempdir().unwrap();
    let wanted = std::env::var("RIPSTOP_KILLS").map_or(KILLS, |count| count.parse().unwrap());
    let [whole, out] = ["whole", "killed"].map(|name| folder.path().join(name));
    let seldom = ["--checkpoint-every", "1000"];
    let mut child = start(run(&out, NO_END_S, &seldom));
    wait_for(&mut child, &out.join("frames/canopy_00000.vtp"));
    kill(&mut child);
    assert!(!CHECKPOINTS.iter().any(|name| out.join(name).exists()));
    let none = finished(run(&out, NO_END_S, &["--resume"]).output().unwrap());
    assert_eq!(none.code, 2, "{}", none.errors);
    assert!(
        none.errors.contains("ended before its first checkpoint"),
        "{}",
        none.errors
    );
    let written = || {
        let found = std::fs::metadata(out.join("checkpoint"));
        found.and_then(|found| found.modified()).ok()
    };
    let mut state = 1_u64;
    for number in 0..wanted {
        let more: &[&str] = if number == 0 { &[] } else { &["--resume"] };
        let mut before = written();
        let mut child = start(run(&out, NO_END_S, more));
        // The first two while the wind rises and the fabric is held, the others in its motion, farther and farther on.
        if number >= 2 {
            let frame = format!("frames/canopy_{:05}.vtp", (number - 2).min(FARTHEST));
            wait_for(&mut child, &out.join(frame));
            before = written();
        }
        // Of this process: whatever the machine is busy with.
        while written() == before || written().is_none() {
            assert!(child.try_wait().unwrap().is_none(), "ended by itself");
            std::thread::sleep(Duration::from_millis(1));
        }
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        std::thread::sleep(Duration::from_millis((state >> 33) % 60));
        kill(&mut child);
    }
    // An end that lies behind wherever it has come to.
    let reached = json(&out.join("run.json"))["reached"]["time_s"].as_f64();
    let end_s = reached.unwrap().max(0.0) + 0.02;
    let output = finished(run(&out, end_s, &["--resume"]).output().unwrap());
    assert_eq!(output.code, 0, "{}", output.errors);
    assert_eq!(
        finished(run(&whole, end_s, &seldom).output().unwrap()).code,
        0
    );
    same_results(&whole, &out);
}

/// Ends a process that goes on, and no other.
fn kill(child: &mut Child) {
    child.kill().unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), None, "it had ended by itself: {status}");
}

/// A checkpoint that there is no room for leaves the older ones, to go on from after a kill; a damaged one is passed over.
fn damaged() {
    let folder = tempfile::tempdir().unwrap();
    let end_s = 0.03;
    let [whole, out] = ["whole", "limited"].map(|name| folder.path().join(name));
    assert_eq!(finished(run(&whole, end_s, &[]).output().unwrap()).code, 0);
    let mut child = run(&out, end_s, &[])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !out.join("checkpoint.previous").exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended too early");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // Larger files than the tables of a run fail from now on: the checkpoint is the first. Frames that are missed then are drawn again.
    let script = format!(
        "trap '' XFSZ; ulimit -f 200; exec '{}' {} --checkpoint-every 0.02 --resume",
        program().display(),
        arguments(&out, end_s)
            .iter()
            .map(|a| format!("'{a}'"))
            .collect::<Vec<_>>()
            .join(" ")
    );
    let mut limited = Command::new("sh");
    limited.args(["-c", &script]).current_dir(root());
    let mut child = limited
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let told = || std::fs::read_to_string(out.join("run.log")).unwrap_or_default();
    while !told().contains("tries again with the next checkpoint") {
        assert!(child.try_wait().unwrap().is_none(), "ended too early");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();

    let path = ["checkpoint.next", "checkpoint"]
        .map(|name| out.join(name))
        .into_iter()
        .find(|path| path.exists())
        .unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let output = finished(run(&out, end_s, &["--resume"]).output().unwrap());
    assert_eq!(output.code, 0, "{}", output.errors);
    assert!(
        output.printed.contains("is not used: section"),
        "{}",
        output.printed
    );
    same_results(&whole, &out);
}

/// A run that is killed on one engine goes on on the other, says so, and ends where it would have ended but for rounding.
fn elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let end_s = 0.01;
    // Solved so well that the engines part by rounding alone.
    let exact = ["--set", "solver.tolerance=1e-5"];
    let cpu: &[&str] = &[&["--engine", "cpu"], &exact[..]].concat();
    let gpu: &[&str] = &[&["--engine", "gpu", "--cloth", "host"], &exact[..]].concat();
    let last_row = |out: &Path| -> Vec<f64> {
        let text = std::fs::read_to_string(out.join("history.csv")).unwrap();
        let row = text.lines().last().unwrap();
        row.split(',').map(|value| value.parse().unwrap()).collect()
    };
    let whole = folder.path().join("whole");
    assert_eq!(finished(run(&whole, end_s, cpu).output().unwrap()).code, 0);
    let header = std::fs::read_to_string(whole.join("history.csv")).unwrap();
    let column = |name: &str| {
        let names = header.lines().next().unwrap().split(',');
        names.into_iter().position(|n| n == name).unwrap()
    };
    let columns = ["projected_diameter_ratio", "impulse_markers_n_s"].map(column);
    for (name, [first, second]) in [("to_the_device", [cpu, gpu]), ("from_it", [gpu, cpu])] {
        let out = folder.path().join(name);
        let mut child = run(&out, end_s, first)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // The canopy is free by then.
        while !(out.join("checkpoint").exists() && out.join("frames/canopy_00000.vtp").exists()) {
            assert!(child.try_wait().unwrap().is_none(), "ended too early");
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(Duration::from_millis(60));
        child.kill().unwrap();
        child.wait().unwrap();
        let more = [second, &["--resume"]].concat();
        let output = finished(run(&out, end_s, &more).output().unwrap());
        assert_eq!(output.code, 0, "{}", output.errors);
        assert!(
            output.printed.contains("differ in rounding"),
            "{}",
            output.printed
        );
        let [a, b] = [&whole, &out].map(|out| last_row(out));
        for &k in &columns {
            let error = (a[k] - b[k]).abs() / a[k].abs();
            assert!(
                error < tolerances::OTHER_ENGINE,
                "{name}, column {k}: {error:e}"
            );
        }
    }
}
