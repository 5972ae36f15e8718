//! Standard error: the one place that writes to it. Lints deny `eprintln!`, which panics where nobody reads any more, or the disk is full.

use std::io::Write;

/// Writes a line to standard error. Who cannot be told is no reason to end a run: errors are passed over.
pub(super) fn say(line: &str) {
    let mut text = String::with_capacity(line.len() + 1);
    text.push_str(line);
    text.push('\n');
    // At once, so that lines of several processes do not mix.
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}
