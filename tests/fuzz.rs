//! Readers of files against inputs that nobody meant: whatever they are given, they end with a result or a message. The same inputs each
//! time; `tests/fuzz/run` looks for new ones.
//!
//! A process of its own reads them, with little memory: what aborts, hangs or takes too much ends that process alone, and the trial tells
//! with which input.

mod mutation;
mod targets;

use std::io::{BufRead, BufReader, Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use libtest_mimic::{Failed, Trial};

use crate::command_line::root;
use crate::timing::timed;
use targets::{Reader, Target};

/// Names the reader in the process that reads.
const READER: &str = "RIPSTOP_FUZZ_READER";

/// Changed inputs per reader in place of the usual number.
const INPUTS: &str = "RIPSTOP_FUZZ_INPUTS";

/// What a reader may take beyond what it has at the start [bytes]; inputs are shorter than a megabyte. A case may ask for a structure of
/// millions of elements.
const fn memory(reader: Reader) -> u64 {
    match reader {
        Reader::Case => 3 << 30,
        _ => 256 << 20,
    }
}

/// A reader that gives no answer for so long hangs.
const HANGS: Duration = Duration::from_secs(60);

/// An input that takes longer is kept, and told of: no failure, for how long it takes depends on the machine.
const SLOW: Duration = Duration::from_secs(1);

/// Longest part of an input that a message shows [bytes].
const SHOWN: usize = 2000;

/// Changed inputs per reader: a few seconds of one core.
const fn usual(reader: Reader) -> u64 {
    match reader {
        Reader::Case => 1500,
        Reader::Mesh => 400,
        Reader::Profile => 2000,
        Reader::Checkpoint => 1000,
    }
}

pub fn trials() -> Vec<Trial> {
    Reader::ALL
        .into_iter()
        .map(|reader| {
            let name = format!("fuzz::{}", reader.name());
            Trial::test(name.clone(), move || timed(&name, || fuzz(reader)))
        })
        .collect()
}

/// All inputs of a reader: what once went wrong, the seeds as they are, changed ones.
struct Inputs {
    found: Vec<PathBuf>,
    seeds: Vec<Vec<u8>>,
    changed: u64,
}

impl Inputs {
    fn new(reader: Reader) -> Self {
        let corpus = root().join("tests/fuzz/corpus").join(reader.name());
        let wanted = std::env::var(INPUTS).map(|count| count.parse().unwrap());
        Self {
            found: targets::files(&corpus, &[""]),
            seeds: targets::seeds(reader, &root().join("cases")),
            changed: wanted.unwrap_or_else(|_| usual(reader)),
        }
    }

    fn count(&self) -> u64 {
        (self.found.len() + self.seeds.len()) as u64 + self.changed
    }

    fn get(&self, number: u64) -> Vec<u8> {
        let index = number as usize;
        if let Some(path) = self.found.get(index) {
            return std::fs::read(path).unwrap();
        }
        match self.seeds.get(index - self.found.len()) {
            Some(seed) => seed.clone(),
            None => mutation::input(
                &self.seeds,
                number - (self.found.len() + self.seeds.len()) as u64,
            ),
        }
    }

    /// What an input is.
    fn name(&self, number: u64) -> String {
        match self.found.get(number as usize) {
            Some(path) => path.display().to_string(),
            None => format!("input {number} of {}", self.count()),
        }
    }
}

/// Reads all inputs of the reader that the environment names; `None` in any other process.
pub fn child() -> Option<ExitCode> {
    let reader = Reader::named(&std::env::var(READER).ok()?)?;
    let inputs = Inputs::new(reader);
    let mut target = Target::new(reader, &root().join("cases"));
    targets::limit_memory(memory(reader));
    let mut out = std::io::stdout();
    let mut slowest = (Duration::ZERO, 0);
    for number in 0..inputs.count() {
        writeln!(out, "{number}").unwrap();
        out.flush().unwrap();
        let input = inputs.get(number);
        let began = Instant::now();
        if catch_unwind(AssertUnwindSafe(|| target.read(&input))).is_err() {
            return Some(ExitCode::from(70));
        }
        slowest = slowest.max((began.elapsed(), number));
    }
    let missing = target.never_accepted();
    if !missing.is_empty() {
        writeln!(out, "nothing was accepted of {}", missing.join(", ")).unwrap();
        return Some(ExitCode::FAILURE);
    }
    let (longest, number) = slowest;
    let mut told = format!(
        "done, the slowest was {} with {:.2} s",
        inputs.name(number),
        longest.as_secs_f64()
    );
    if longest > SLOW {
        told += &format!(
            ", kept as {}",
            keep(reader, number, &inputs.get(number)).display()
        );
    }
    writeln!(out, "{told}").unwrap();
    Some(ExitCode::SUCCESS)
}

/// Puts an input where a developer finds it.
fn keep(reader: Reader, number: u64, input: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("ripstop-fuzz-{}-{number}", reader.name()));
    std::fs::write(&path, input).unwrap();
    path
}

fn fuzz(reader: Reader) -> Result<(), Failed> {
    let mut child = Command::new(std::env::current_exe()?)
        .env(READER, reader.name())
        .env("RAYON_NUM_THREADS", "1")
        .env("RUST_BACKTRACE", "0")
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let (sender, answers) = mpsc::channel();
    let out = child.stdout.take().unwrap();
    std::thread::spawn(move || {
        for line in BufReader::new(out).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    let mut errors = child.stderr.take().unwrap();
    let errors = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = errors.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    });
    let (mut last, mut hangs) = (String::new(), false);
    loop {
        match answers.recv_timeout(HANGS) {
            Ok(line) => last = line,
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => {
                hangs = true;
                child.kill()?;
                break;
            }
        }
    }
    let status = child.wait()?;
    let errors = errors.join().unwrap();
    if status.success() {
        println!("fuzz::{}: {last}", reader.name());
        return Ok(());
    }
    let Ok(number) = last.parse() else {
        return Err(format!(
            "the process that reads ended without an input at fault: {status}\n{last}\n{errors}"
        )
        .into());
    };
    let inputs = Inputs::new(reader);
    let input = inputs.get(number);
    let kept = keep(reader, number, &input);
    let why = if hangs {
        format!("gives no answer within {} s", HANGS.as_secs())
    } else {
        format!("ends with {status}")
    };
    Err(format!(
        "the reader of the {} {why} at {}:\n{}\nThe input, which is kept as {}:\n{}\n\
         Mend the reader, and copy the input to {} so that it is read first from now on.",
        reader.name(),
        inputs.name(number),
        errors.trim(),
        kept.display(),
        input[..input.len().min(SHOWN)].escape_ascii(),
        root()
            .join("tests/fuzz/corpus")
            .join(reader.name())
            .display(),
    )
    .into())
}
