//! Runs that are interrupted go on with the bits of those that were not.

use std::path::Path;
use std::process::{Command, Stdio};

use libtest_mimic::Trial;

use crate::command_line::{CANOPY, command, files, finished, name_in};
use crate::engines::{needs_device, plain};
use crate::folders::{canopy, json, start, wait_for};

pub fn trials() -> Vec<Trial> {
    // Signals are sent by a shell's `kill`.
    if !cfg!(unix) {
        return Vec::new();
    }
    let mut trials = [
        plain("interrupts::of_an_equilibrium", of_an_equilibrium),
        plain("interrupts::that_come_twice", twice),
        plain("interrupts::that_ask_for_a_checkpoint", checkpoint_now),
        plain("interrupts::of_a_run", || {
            of_a_run(&[], &["--precision", "f64"]);
        }),
    ]
    .into_iter()
    .flatten()
    .collect::<Vec<_>>();
    trials.push(needs_device("interrupts::of_a_run::gpu".to_owned(), || {
        of_a_run(
            &["--engine", "gpu", "--cloth", "device"],
            &["--engine", "cpu", "--precision", "f64"],
        );
    }));
    trials
}

/// A static equilibrium can be interrupted too, and goes on from where it was.
fn of_an_equilibrium() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for resume in [false, true] {
        let mut endless = command(&[
            "run",
            "cases/cloth/hanging-chain.toml",
            "--set",
            "structure.cable.segments=5000",
            "--set",
            "equilibrium.evaluation_limit=1000000000",
            "--out",
            out.to_str().unwrap(),
        ]);
        if resume {
            endless.arg("--resume");
        }
        let mut child = endless
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let history = out.join("history.csv");
        if resume {
            std::fs::remove_file(&history).unwrap();
        }
        while !history.exists() {
            assert!(child.try_wait().unwrap().is_none(), "ended by itself");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        std::thread::sleep(std::time::Duration::from_millis(200));
        let killed = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .unwrap();
        assert!(killed.success());
        assert_eq!(child.wait().unwrap().code(), Some(75));
        assert!(out.join("checkpoint").exists());
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        // What it was at is no result.
        let marked = "interrupted on the way to an equilibrium";
        assert!(summary.contains(marked), "{summary}");
    }
}

/// Sends signals to a process, one right after the other.
pub fn send(child: &std::process::Child, signals: &[&str]) {
    let script: Vec<String> = signals
        .iter()
        .map(|signal| format!("kill -{signal} {}", child.id()))
        .collect();
    let sent = Command::new("sh").args(["-c", &script.join("; ")]).status();
    assert!(sent.unwrap().success());
}

/// Signals that come together, as to a group of processes, are one: there is a checkpoint. A later one ends the run at once, and the code tells
/// whether there is one.
fn twice() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let seldom = ["--set", "time.end_s=1.0", "--checkpoint-every", "1000"];
    let mut child = start(canopy(&out, &seldom));
    wait_for(&mut child, &out.join("frames/canopy_00001.vtp"));
    send(&child, &["TERM", "INT", "TERM"]);
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(out.join("checkpoint").exists());
    assert_eq!(json(&out.join("run.json"))["state"], "interrupted");

    // Steps that take longer than who interrupts is willing to wait.
    let mut codes = Vec::new();
    for attempt in 0..4 {
        let out = folder.path().join(format!("slow-{attempt}"));
        let mut command = command(&["run", CANOPY, "--engine", "cpu", "--threads", "1"]);
        command.args(["--set", "resolution.cells_per_diameter=32.0", "--out"]);
        let mut child = start({
            command.arg(&out);
            command
        });
        wait_for(&mut child, &out.join("run.json"));
        let wait = |milliseconds| {
            std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        };
        wait(300);
        send(&child, &["INT"]);
        wait(3);
        // A process that is stopped computes nothing, but time passes for it.
        send(&child, &["STOP"]);
        wait(700);
        send(&child, &["INT", "CONT"]);
        let code = child.wait().unwrap().code().unwrap();
        let there = out.join("checkpoint").exists();
        assert_eq!(code, if there { 75 } else { 130 });
        codes.push(code);
        if code == 130 {
            return;
        }
    }
    panic!("no run ended without a checkpoint: {codes:?}");
}

/// SIGUSR1, as schedulers send it before their own end, writes a checkpoint; the run goes on.
fn checkpoint_now() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let seldom = ["--set", "time.end_s=0.2", "--checkpoint-every", "1000"];
    let mut child = start(canopy(&out, &seldom));
    wait_for(&mut child, &out.join("frames/canopy_00001.vtp"));
    assert!(!out.join("checkpoint").exists());
    send(&child, &["USR1"]);
    wait_for(&mut child, &out.join("checkpoint"));
    // Long before the one of the end.
    assert!(!out.join("frames/canopy_00010.vtp").exists());
    wait_for(&mut child, &out.join("frames/canopy_00011.vtp"));
    child.kill().unwrap();
    child.wait().unwrap();
    let resumed = finished(
        canopy(&out, &[&seldom[..], &["--resume"]].concat())
            .output()
            .unwrap(),
    );
    assert_eq!(resumed.code, 0, "{}", resumed.errors);
    assert!(resumed.printed.contains("resumed at t = "));
}

/// An interrupted run ends with code 75, and the resumed one delivers the same bits as one that was never interrupted.
fn of_a_run(engine: &[&str], other_engine: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        "resolution.cells_per_diameter=12.0",
        "structure.flat_circular.rings=8",
        "time.end_s=0.04",
        "coupling.scheme=kernel",
        "coupling.structure_every=2",
        "output.picture_times_s=[0.0, 0.015, 0.03]",
    ];
    let run_on = |engine: &[&str], out: &Path, more: &[&str]| {
        let mut arguments = vec!["run", CANOPY, "--out", out.to_str().unwrap()];
        for change in &changes {
            arguments.extend(["--set", change]);
        }
        arguments.extend(engine);
        arguments.extend(more);
        command(&arguments)
    };
    let run = |out: &Path, more: &[&str]| run_on(engine, out, more);
    let whole = folder.path().join("whole");
    assert_eq!(finished(run(&whole, &[]).output().unwrap()).code, 0);

    let out = folder.path().join("interrupted");
    assert_eq!(
        finished(run(&out, &["--resume"]).output().unwrap()).code,
        2,
        "there is nothing to resume from yet"
    );
    let mut child = run(&out, &[])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // The second picture is drawn at 0.015 s.
    while !out.join("snapshot_001.png").exists() {
        assert!(
            child.try_wait().unwrap().is_none(),
            "ended before it was interrupted"
        );
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("interrupted"), "{summary}");
    let output = finished(run_on(other_engine, &out, &["--resume"]).output().unwrap());
    assert_eq!(output.code, 2);
    assert!(
        output.errors.contains("belongs to another run"),
        "{}",
        output.errors
    );

    let output = finished(run(&out, &["--resume"]).output().unwrap());
    assert_eq!(output.code, 0, "{}", output.errors);
    assert!(
        output.printed.contains("resumed at t ="),
        "{}",
        output.printed
    );
    let names = |folder: &Path| {
        let mut names: Vec<_> = files(folder)
            .iter()
            .map(|path| name_in(folder, path))
            .collect();
        names.sort();
        names
    };
    assert_eq!(names(&whole), names(&out));
    for name in names(&whole) {
        let tells_time = ["summary.json", "run.json", "run.log", "report.html"];
        if !tells_time.iter().any(|known| name == *known) {
            let same = std::fs::read(whole.join(&name)).unwrap()
                == std::fs::read(out.join(&name)).unwrap();
            assert!(same, "{name} differs");
        }
    }
}
