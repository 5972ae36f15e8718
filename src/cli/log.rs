//! Standard error and standard output: the one place that writes to them. Lints deny `eprintln!` and `println!`, which panic where nobody
//! reads any more, or the disk is full.

use std::io::Write;

use super::exit;
use super::failure::Failure;

/// Writes a line to standard error. Who cannot be told is no reason to end a run: errors are passed over.
pub(super) fn say(line: &str) {
    let mut text = String::with_capacity(line.len() + 1);
    text.push_str(line);
    text.push('\n');
    // At once, so that lines of several processes do not mix.
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Writes to standard output. A reader that has gone away is no failure; a full disk behind a redirection is.
pub(super) fn emit(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::Other(
            exit::OUTPUT_FAILED,
            format!("cannot write to standard output: {error}"),
        )),
        _ => Ok(()),
    }
}
