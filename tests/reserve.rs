//! A disk that is full from the start, or becomes free again: a file system of six megabytes in memory, which only the run and its shell see.

use std::path::Path;
use std::process::Command;

use libtest_mimic::Trial;

use crate::command_line::{Finished, finished, root};
use crate::engines::plain;
use crate::folders::{canopy, json};

pub fn trials() -> Vec<Trial> {
    if !cfg!(target_os = "linux") {
        return Vec::new();
    }
    // Mounts of one's own need root, or user namespaces: what a container may forbid.
    let allowed = Command::new("unshare")
        .args(["--mount", "sh", "-c", "mount -t tmpfs none /mnt"])
        .output()
        .is_ok_and(|output| output.status.success());
    let trials = [
        plain("reserve::frames_are_missing", frames_are_missing),
        plain("reserve::room_that_comes_back", room_comes_back),
    ];
    let trials = trials.into_iter().flatten();
    if allowed {
        return trials.collect();
    }
    trials
        .map(|trial| {
            trial
                .with_ignored_flag(true)
                .with_kind("no mounts of its own")
        })
        .collect()
}

/// Runs `script` beside a small canopy on a file system of six megabytes; what is there at the end lies in `out`. The script has `$DISK`, and the run as `"$@"`.
fn on_a_small_disk(out: &Path, script: &str, end_s: &str) -> Finished {
    let disk = tempfile::tempdir().unwrap();
    let end = format!("time.end_s={end_s}");
    let run = canopy(
        &disk.path().join("out"),
        &[
            "--set",
            &end,
            "--set",
            "output.flow_interval_s=0.004",
            "--checkpoint-every",
            "1000",
            "--no-final-state",
        ],
    );
    let whole = format!(
        "mount -t tmpfs -o size=6m none \"$DISK\" || exit 99\n{script}\ncode=$?\nmkdir -p \"$OUT\" && cp -r \"$DISK\"/out/* \"$OUT\"\nexit $code"
    );
    let mut shell = Command::new("unshare");
    shell
        .args(["--mount", "sh", "-c", &whole, "sh"])
        .arg(run.get_program())
        .args(run.get_args())
        .env("DISK", disk.path())
        .env("OUT", out)
        .current_dir(root());
    finished(shell.output().unwrap())
}

/// Times of the frames of air that are listed [s], and of those that the summary names as missing.
fn frames(out: &Path) -> (Vec<f64>, usize) {
    let list = std::fs::read_to_string(out.join("flow.pvd")).unwrap();
    let times = list.split("timestep=\"").skip(1);
    let times = times.map(|rest| rest.split('"').next().unwrap().parse().unwrap());
    let notes = json(&out.join("summary.json"))["notes"].to_string();
    (times.collect(), notes.matches("the air at t = ").count())
}

/// Begins the run, and waits until it says that there is no room.
const UNTIL_FULL: &str = r#""$@" &
until grep -qs "goes on without it" "$DISK/out/run.log"; do
    kill -0 $! || exit 98
    sleep 0.01
done
"#;

/// All files but those that there was no room for are there and whole, though somebody else takes every byte that is free: what was kept free is enough.
fn frames_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let script = format!("{UNTIL_FULL}cat /dev/zero 2>&- >\"$DISK/more\"\nwait $!");
    let output = on_a_small_disk(&out, &script, "0.03");
    assert_eq!(output.code, 0, "{}{}", output.printed, output.errors);
    let (times_s, missing) = frames(&out);
    assert!(missing > 0 && times_s.len() < 8, "{times_s:?} {missing}");
    for name in ["summary.json", "history.csv", "run.json", "canopy.pvd"] {
        assert!(
            std::fs::metadata(out.join(name)).unwrap().len() > 0,
            "{name}"
        );
    }
    let ledger = json(&out.join("run.json"));
    assert_eq!(ledger["state"], "finished");
    // What the ledger lists lies there with its length.
    for entry in ledger["files"].as_array().unwrap() {
        let found = std::fs::metadata(out.join(entry["name"].as_str().unwrap())).unwrap();
        assert_eq!(entry["bytes"], found.len(), "{entry}");
    }
    assert!(
        output.errors.contains("the run goes on without it"),
        "{}",
        output.errors
    );
}

/// Somebody else's file fills the disk at the start and is removed once the run has said that there is no room.
fn room_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let big = "head -c 3500000 /dev/zero >\"$DISK/big\"\n";
    let script = format!("{big}{UNTIL_FULL}rm \"$DISK/big\"\nwait $!");
    let output = on_a_small_disk(&out, &script, "0.03");
    assert_eq!(output.code, 0, "{}{}", output.printed, output.errors);
    let (times_s, missing) = frames(&out);
    assert!(missing > 0, "nothing was missing: {times_s:?}");
    // The first is missing; more than one came after.
    assert!(times_s.len() > 1 && times_s[0] > 0.0, "{times_s:?}");
}
