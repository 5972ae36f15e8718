//! Standard error that nobody reads, or that lies on a full disk, ends nothing.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use libtest_mimic::Trial;

use crate::command_line::command;
use crate::engines::plain;
use crate::folders::{canopy, contents, wait_for};
use crate::interrupts::send;

pub fn trials() -> Vec<Trial> {
    if !cfg!(unix) {
        return Vec::new();
    }
    [
        plain("standard_error::is_not_needed", is_not_needed),
        plain("standard_error::goes_with_the_terminal", goes_away),
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
    let run = |out: &Path| canopy(out, &["--set", "time.end_s=0.03"]);
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
    wait_for(&mut child, &out.join("canopy_00001.vtp"));
    send(&child, &["HUP"]);
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(out.join("checkpoint").exists());
}
