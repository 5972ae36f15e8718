//! Faults of the program itself: a panic in a run becomes one message, and what was computed is kept.

use std::path::Path;
use std::time::Duration;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::plan::{Plan, Precision};
use ripstop::run::{self, Fault, Observer, Order, Report, Requests, RunError, Start};

use crate::command_line::{CANOPY, root};
use crate::engines::plain;
use crate::folders::{SHEET, SMALL, json};
use crate::resumption::same;

pub fn trials() -> Vec<Trial> {
    [
        plain("faults::between_two_steps", between_two_steps),
        plain("faults::where_nothing_can_be_kept", nothing_to_keep),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Fails when a run tells of its progress for the n-th time, or says something.
#[derive(Default)]
struct Faulty {
    at: Option<usize>,
    heard: usize,
    at_words: Option<&'static str>,
}

impl Observer for Faulty {
    fn progress(&mut self, _: u64, _: u64, _: &str) {
        self.heard += 1;
        assert_ne!(Some(self.heard), self.at, "a fault on purpose");
    }

    fn note(&mut self, line: &str) {
        let found = self.at_words.is_some_and(|words| line.contains(words));
        assert!(!found, "a fault on purpose");
    }
}

fn attempt(
    (path, variant): (&str, Option<&str>),
    changes: &[&str],
    out: &Path,
    start: Start,
    mut observer: Faulty,
) -> (Result<Report, RunError>, usize) {
    let choices = Choices {
        variant: variant.map(str::to_owned),
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    let case = case::load(&root().join(path), &choices).unwrap();
    let order = Order {
        plan: Plan::new(&case.scene, Precision::F32),
        case: &case,
        device: None,
        fallback: None,
        folder: out,
        start,
        overwrite: false,
        keep_final: true,
        checkpoint_interval: Duration::from_secs(1000),
    };
    let result = run::run(order, &Requests::default(), &mut observer);
    (result, observer.heard)
}

fn fault(result: Result<Report, RunError>) -> Fault {
    match result {
        Err(RunError::Fault(fault)) => *fault,
        other => panic!("{other:?}"),
    }
}

/// The state between two steps is whole: a checkpoint of it is written, and the run goes on with the bits of one without a fault.
fn between_two_steps() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole", "out"].map(|name| folder.path().join(name));
    let changes = [&SMALL[..], &["time.end_s=0.04"]].concat();
    let run = |out: &Path, start, at| {
        let observer = Faulty {
            at,
            ..Faulty::default()
        };
        attempt((CANOPY, None), &changes, out, start, observer)
    };
    let (result, heard) = run(&whole, Start::New, None);
    result.unwrap();
    let (result, _) = run(&out, Start::New, Some(heard - 1));
    let fault = fault(result);
    assert!(fault.message.contains("a fault on purpose"), "{fault}");
    let kept = "a checkpoint was written at t = ";
    assert!(fault.kept.starts_with(kept), "{fault}");
    assert!(
        fault
            .to_string()
            .ends_with("please report it, with run.log")
    );
    let ledger = json(&out.join("run.json"));
    assert_eq!(ledger["state"], "failed");
    assert!(ledger["reason"].as_str().unwrap().contains("on purpose"));
    let log = std::fs::read_to_string(out.join("run.log")).unwrap();
    assert!(log.contains("error: internal fault: "), "{log}");
    let (result, _) = run(&out, Start::Resume, None);
    result.unwrap();
    same(&whole, &out);
}

/// Where the state may be half of one and half of another, no checkpoint is written.
fn nothing_to_keep() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let case = (SHEET[0], Some(SHEET[2]));
    let observer = Faulty {
        at_words: Some("equilibrium: reached"),
        ..Faulty::default()
    };
    let (result, _) = attempt(case, &[], &out, Start::New, observer);
    let fault = fault(result);
    assert_eq!(fault.kept, "there was no checkpoint to keep");
    assert!(!out.join("checkpoint").exists());
    assert_eq!(json(&out.join("run.json"))["state"], "failed");
    // It is nobody's loss to begin anew.
    let (result, _) = attempt(case, &[], &out, Start::New, Faulty::default());
    result.unwrap();
}
