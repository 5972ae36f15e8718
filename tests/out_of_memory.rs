//! Memory that ends: a message and an exit code, no abort.

use std::process::Command;

use libtest_mimic::Trial;

use crate::command_line::{command, finished};
use crate::engines::plain;

/// Limits of address space from one at which the program barely loads to one that is enough [KiB].
const LIMITS_KIB: std::ops::RangeInclusive<u32> = 44_000..=100_000;

pub fn trials() -> Vec<Trial> {
    if !cfg!(target_os = "linux") {
        return Vec::new();
    }
    plain("out_of_memory::is_told", is_told)
}

/// The shell sets the limit and becomes the program.
fn is_told() {
    let problem = command(&["validate", "hencky", "--engine", "cpu"]);
    let mut codes = Vec::new();
    for limit in LIMITS_KIB.step_by(8000) {
        let mut limited = Command::new("sh");
        limited.args(["-c", "ulimit -v $0 && exec \"$@\"", &limit.to_string()]);
        limited.arg(problem.get_program()).args(problem.get_args());
        let output = finished(limited.output().unwrap());
        let told = output.errors.contains("error: out of memory");
        assert_eq!(told, output.code == 74, "{limit}: {}", output.errors);
        codes.push(output.code);
    }
    assert!(codes.contains(&74), "{codes:?}");
    assert!(codes.iter().all(|code| [0, 74].contains(code)), "{codes:?}");
}
