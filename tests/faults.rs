//! Faults of the program itself: a panic in a run becomes one message, and what was computed is kept.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::gpu::{AdapterChoice, Device};
use ripstop::plan::{AirPlacement, ClothPlacement, Placement, Plan, Precision, Storage};
use ripstop::run::{self, Fault, Observer, Order, Report, Requests, RunError, Start};

use crate::command_line::{CANOPY, finished, root};
use crate::engines::{needs_device, plain};
use crate::folders::{SHEET, SMALL, canopy, json};
use crate::resumption::same;

pub fn trials() -> Vec<Trial> {
    [
        plain("faults::between_two_steps", between_two_steps),
        plain("faults::where_nothing_can_be_kept", nothing_to_keep),
        plain("faults::of_the_program", of_the_program),
        plain("faults::of_a_file_in_the_midst", of_a_file),
        vec![needs_device(
            "faults::of_a_device_in_the_midst::gpu".to_owned(),
            of_a_device,
        )],
        vec![needs_device(
            "faults::of_a_device_that_opens_again::gpu".to_owned(),
            opened_again,
        )],
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Fails when a run tells of its progress for the n-th time, or says something; or lets its device fail.
#[derive(Default)]
struct Faulty {
    at: Option<usize>,
    heard: usize,
    at_words: Option<&'static str>,
    device: Option<Arc<Device>>,
}

impl Observer for Faulty {
    fn progress(&mut self, _: u64, _: u64, _: &str) {
        self.heard += 1;
        match &self.device {
            Some(device) if Some(self.heard) == self.at => device.destroy(),
            Some(_) => {}
            None => assert_ne!(Some(self.heard), self.at, "a fault on purpose"),
        }
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
    let placement = match &observer.device {
        None => Precision::F32.into(),
        Some(device) => Placement {
            air: AirPlacement::Gpu(Storage::F32),
            cloth: ClothPlacement::Host,
            device: Some(device.info().name.clone()),
            shared_memory: true,
        },
    };
    let order = Order {
        plan: Plan::new(&case.scene, placement),
        case: &case,
        device: observer.device.clone(),
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
    failed_summary(&out, "on purpose");
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

/// The summary of a run that failed in its midst: that it did, why, where it stood, and what was sampled before.
fn failed_summary(out: &Path, why: &str) {
    let summary = json(&out.join("summary.json"));
    assert_eq!(summary["stop"]["state"], "failed");
    let reason = summary["stop"]["reason"].as_str().unwrap();
    assert!(reason.contains(why), "{reason}");
    let ledger = json(&out.join("run.json"));
    assert_eq!(ledger["state"], "failed");
    assert_eq!(ledger["reason"], reason);
    assert_eq!(summary["steps"], ledger["reached"]["step"]);
    assert!(summary["stop"]["when_s"].as_f64().unwrap() > 0.0);
    let widest = &summary["results"]["largest_projected_diameter_ratio"];
    assert!(
        widest["value"].as_f64().unwrap() > 0.0,
        "{}",
        summary["results"]
    );
    let notes = summary["notes"].to_string();
    assert!(notes.contains("the run failed, and the results are those up to then"));
    let listed = ledger["files"].to_string();
    assert!(listed.contains("summary.json"), "{listed}");
}

/// A panic of the program itself, between two steps and within one: code 70, one message, the calls in the log.
fn of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole", "out"].map(|name| folder.path().join(name));
    let run = |out: &Path, fault: Option<&str>, more: &[&str]| {
        let end = ["--set", "time.end_s=0.03", "--checkpoint-every", "1000"];
        let mut command = canopy(out, &[&end[..], more].concat());
        command.envs(fault.map(|fault| ("RIPSTOP_TEST_FAULT", fault)));
        finished(command.output().unwrap())
    };
    assert_eq!(run(&whole, None, &[]).code, 0);
    let steps = json(&whole.join("summary.json"))["steps"].as_u64().unwrap();
    let refused = run(&out, Some("sometime"), &[]);
    assert_eq!(refused.code, 2, "{}", refused.errors);
    assert!(
        refused
            .errors
            .contains("none of between:STEP, within:STEP and device:STEP"),
        "{}",
        refused.errors
    );
    assert!(!out.join("run.json").exists());
    for (place, resumable) in [("between", true), ("within", false)] {
        let out = folder.path().join(place);
        // One in several steps is sampled; before that the state is not whole.
        let failed = (steps - 9..steps)
            .map(|step| run(&out, Some(&format!("{place}:{step}")), &["--overwrite"]))
            .find(|failed| failed.errors.contains("a checkpoint was written") == resumable)
            .unwrap();
        assert_eq!(failed.code, 70, "{}", failed.errors);
        let last: Vec<&str> = failed.errors.lines().rev().take(1).collect();
        assert!(
            last[0].contains("internal fault: a fault on purpose"),
            "{}",
            failed.errors
        );
        assert!(last[0].contains("src/run/rescue.rs"), "{last:?}");
        assert!(
            last[0].ends_with("please report it, with run.log"),
            "{last:?}"
        );
        assert!(
            !failed.errors.contains("stack backtrace"),
            "{}",
            failed.errors
        );
        let log = std::fs::read_to_string(out.join("run.log")).unwrap();
        let (_, calls) = log.split_once("where the fault was:").unwrap();
        assert!(calls.contains("fail_on_purpose"), "{calls}");
        assert_eq!(out.join("checkpoint").exists(), resumable);
        failed_summary(&out, "a fault on purpose");
        if resumable {
            let output = run(&out, None, &["--resume"]);
            assert_eq!(output.code, 0, "{}", output.errors);
            same(&whole, &out);
        } else {
            let needle = "there was no checkpoint to keep";
            assert!(failed.errors.contains(needle), "{}", failed.errors);
        }
    }
}

/// A frame that cannot be written, for another reason than want of room, ends the run with a summary.
fn of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::create_dir_all(out.join("frames/canopy_00002.vtp")).unwrap();
    let end = ["--set", "time.end_s=0.04"];
    let failed = finished(canopy(&out, &end).output().unwrap());
    assert_eq!(failed.code, 74, "{}", failed.errors);
    failed_summary(&out, "frames/canopy_00002.vtp");
    std::fs::remove_dir(out.join("frames/canopy_00002.vtp")).unwrap();
    let more = if out.join("checkpoint").exists() {
        "--resume"
    } else {
        "--overwrite"
    };
    let output = finished(
        canopy(&out, &[&end[..], &[more]].concat())
            .output()
            .unwrap(),
    );
    assert_eq!(output.code, 0, "{}", output.errors);
    assert_eq!(json(&out.join("summary.json"))["stop"]["state"], "finished");
}

/// A device that goes away in the midst of a run takes nothing of what was sampled before.
fn of_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let changes = [&SMALL[..], &["time.end_s=0.02"]].concat();
    let observer = Faulty {
        // Of its own, since it does not survive.
        device: Some(Device::open(&AdapterChoice::Any).unwrap()),
        // After the first samples: the wind has risen at the fifth.
        at: Some(8),
        ..Faulty::default()
    };
    let (result, _) = attempt((CANOPY, None), &changes, &out, Start::New, observer);
    assert!(matches!(result, Err(RunError::Device(_))), "{result:?}");
    failed_summary(&out, "the device was lost");
}

/// A device that goes away after a checkpoint is opened anew, and the run goes on from there, with the bits of one that kept its device.
fn opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole", "out"].map(|name| folder.path().join(name));
    let run = |out: &Path, fault: Option<&str>, every: &str| {
        let mut command = canopy(
            out,
            &[
                "--set",
                "time.end_s=0.02",
                "--engine",
                "gpu",
                "--checkpoint-every",
                every,
            ],
        );
        command.envs(fault.map(|fault| ("RIPSTOP_TEST_FAULT", fault)));
        finished(command.output().unwrap())
    };
    let kept = run(&whole, None, "1000");
    assert_eq!(kept.code, 0, "{}", kept.errors);
    let steps = json(&whole.join("summary.json"))["steps"].as_u64().unwrap();
    let fault = format!("device:{}", steps - 5);
    // Without a checkpoint there is nothing to go on from.
    let lost = run(&out, Some(&fault), "1000");
    assert_eq!(lost.code, 3, "{}", lost.errors);
    assert!(
        lost.errors.contains("the device was lost"),
        "{}",
        lost.errors
    );
    std::fs::remove_dir_all(&out).unwrap();
    let survived = run(&out, Some(&fault), "0.001");
    assert_eq!(survived.code, 0, "{}", survived.errors);
    let told = "it opened again, and the run went on from its last checkpoint";
    assert!(survived.errors.contains(told), "{}", survived.errors);
    let summary = json(&out.join("summary.json"));
    assert!(summary["notes"].to_string().contains(told));
    assert_eq!(summary["stop"]["state"], "finished");
    same(&whole, &out);
}
