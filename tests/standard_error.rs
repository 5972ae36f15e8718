//! Standard error that nobody reads, or that lies on a full disk, ends nothing.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use libtest_mimic::Trial;

use crate::command_line::{CANOPY, command, finished};
use crate::engines::plain;
use crate::folders::{SHEET, canopy, contents, wait_for};
use crate::interrupts::send;

pub fn trials() -> Vec<Trial> {
    if !cfg!(unix) {
        return Vec::new();
    }
    [
        plain("standard_error::is_not_needed", is_not_needed),
        plain("standard_error::goes_with_the_terminal", goes_away),
        plain("standard_error::has_no_word_of_drivers", no_drivers),
        plain("standard_error::is_kept_in_the_log", kept_in_the_log),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A process whose standard error has no reader.
fn without_reader(mut command: Command) -> Child {
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stderr.take());
    child
}

/// On a full disk.
fn on_a_full_disk(mut command: Command) -> Child {
    let full = File::options().write(true).open("/dev/full").unwrap();
    command.stdout(Stdio::null()).stderr(full).spawn().unwrap()
}

fn is_not_needed() {
    let folder = tempfile::tempdir().unwrap();
    let run = |out: &Path| canopy(out, &["--set", "time.end_s=0.008"]);
    let whole = folder.path().join("whole");
    let output = run(&whole).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(!output.stderr.is_empty(), "nothing was said at all");
    let mut ways: Vec<fn(Command) -> Child> = vec![without_reader];
    if Path::new("/dev/full").exists() {
        ways.push(on_a_full_disk);
    }
    for (number, start) in ways.into_iter().enumerate() {
        let out = folder.path().join(number.to_string());
        assert_eq!(start(run(&out)).wait().unwrap().code(), Some(0));
        let (expected, found) = (contents(&whole), contents(&out));
        assert!(expected.keys().eq(found.keys()));
        assert!(expected["history.csv"] == found["history.csv"]);
        // Errors keep their codes.
        let refused = start(command(&["check", "cases/there-is-none.toml"]));
        assert_eq!({ refused }.wait().unwrap().code(), Some(2));
    }
}

/// A terminal that is closed takes standard error along and sends SIGHUP.
fn goes_away() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let seldom = ["--set", "time.end_s=1.0", "--checkpoint-every", "1000"];
    let mut child = without_reader(canopy(&out, &seldom));
    wait_for(&mut child, &out.join("frames/canopy_00001.vtp"));
    send(&child, &["HUP"]);
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(out.join("checkpoint").exists());
}

/// Who asks for no device hears nothing of drivers; those of Mesa complain where there is no display.
fn no_drivers() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let air = "cases/taylor-green.toml";
    let sheet = [&["run", "--out", out.to_str().unwrap()], &SHEET[..]].concat();
    for arguments in [
        &["check", air][..],
        &["check", air, "--engine", "cpu"],
        &["check", CANOPY],
        &sheet,
    ] {
        let mut quiet = command(arguments);
        quiet.env_remove("XDG_RUNTIME_DIR");
        let output = finished(quiet.output().unwrap());
        assert_eq!(output.code, 0, "{}", output.errors);
        for word in ["XDG", "vulkan", "lavapipe", "MESA"] {
            assert!(!output.errors.contains(word), "{}", output.errors);
        }
    }
}

/// Every line of standard error but those of progress, with the time of day; a resumed run adds its own.
fn kept_in_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let log = || std::fs::read_to_string(out.join("run.log")).unwrap();
    let run = |end_s: &str, more: &[&str]| {
        let end = format!("time.end_s={end_s}");
        let output = canopy(&out, &[&["--set", &end], more].concat()).output();
        finished(output.unwrap())
    };
    let first = run("0.01", &[]);
    assert_eq!(first.code, 0, "{}", first.errors);
    let text = log();
    for line in first.errors.lines().filter(|line| !line.contains(" %  ")) {
        assert!(text.contains(&format!("Z  {line}\n")), "{line}: {text}");
    }
    assert!(text.ends_with("Z  ended: end time reached\n"), "{text}");
    // A refusal is no part of the run.
    assert_eq!(run("0.005", &["--resume"]).code, 2);
    assert_eq!(log(), text);
    assert_eq!(run("0.02", &["--resume"]).code, 0);
    let both = log();
    assert!(both.starts_with(&text) && both[text.len()..].contains("resumed at t = "));
}
