//! Checkpoints while an equilibrium or a trim is sought, which go on from where the nodes were, and change nothing.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::plan::{Plan, Precision};
use ripstop::run::{self, Observer, Order, Report, Requests, RunError, Start};

use crate::command_line::{command, root};
use crate::engines::plain;
use crate::folders::{json, start, wait_for};
use crate::interrupts::send;
use crate::resumption::same;

pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = [
        plain("keeping::an_equilibrium_goes_on", an_equilibrium_goes_on),
        plain("keeping::changes_nothing", changes_nothing),
        plain("keeping::a_trim_goes_on_on_its_mesh", a_trim_goes_on),
        plain("keeping::no_later_end_from_half_way", no_later_end),
    ]
    .into_iter()
    .flatten()
    .collect();
    // Signals are sent by a shell's `kill`.
    if cfg!(unix) {
        trials.extend(plain("keeping::when_asked_or_due", when_asked_or_due));
    }
    trials
}

/// Counts the iterations of a minimiser, asks for a checkpoint at one of them, and at the next one fails or stops.
#[derive(Default)]
struct Watching {
    requests: Requests,
    iterations: usize,
    checkpoint_at: Option<usize>,
    fault_at: Option<usize>,
    stop_at: Option<usize>,
    /// After the first iteration of the second mesh, in place of numbers.
    fault_on_second_mesh: bool,
    /// After the first iteration of a trim.
    stop_on_trim: bool,
    lines: Vec<String>,
}

impl Observer for Watching {
    fn progress(&mut self, _: u64, _: u64, status: &str) {
        if !["equilibrium:", "trim:"]
            .iter()
            .any(|of| status.starts_with(of))
        {
            return;
        }
        self.iterations += 1;
        let now = Some(self.iterations);
        if now == self.checkpoint_at {
            self.requests.checkpoint.store(true, Ordering::Relaxed);
        }
        if now == self.stop_at {
            self.requests.stop.store(true, Ordering::Relaxed);
        }
        assert_ne!(now, self.fault_at, "a fault on purpose");
    }

    fn note(&mut self, line: &str) {
        self.lines.push(line.to_owned());
        let first = |line: &&String| line.starts_with("trim  1,");
        let begun = self.lines.iter().filter(first).count();
        if self.fault_on_second_mesh && begun == 2 && self.fault_at.is_none() {
            self.requests.checkpoint.store(true, Ordering::Relaxed);
            // It is written after the next one.
            self.fault_at = Some(self.iterations + 2);
        }
        if self.stop_on_trim && line.starts_with("trim ") {
            self.requests.stop.store(true, Ordering::Relaxed);
        }
    }
}

fn attempt(
    (path, variant): (&str, Option<&str>),
    changes: &[&str],
    (out, start): (&Path, Start),
    interval_s: f64,
    mut watching: Watching,
) -> (Result<Report, RunError>, Watching) {
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
        checkpoint_interval: Duration::from_secs_f64(interval_s),
    };
    let requests = watching.requests.clone();
    let result = run::run(order, &requests, &mut watching);
    (result, watching)
}

const CHAIN: (&str, Option<&str>) = ("cases/cloth/hanging-chain.toml", None);

fn anew(out: &Path) -> (&Path, Start<'_>) {
    (out, Start::New)
}

/// Seldom enough for a test.
const NEVER_S: f64 = 1e6;

/// A value of a run's summary.
fn result(out: &Path, name: &str) -> f64 {
    let summary = json(&out.join("summary.json"));
    summary["results"][name]["value"].as_f64().unwrap()
}

/// A checkpoint that was asked for in the midst holds where the nodes were: what is left takes fewer iterations, and ends at the same.
fn an_equilibrium_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole", "out"].map(|name| folder.path().join(name));
    let (report, all) = attempt(CHAIN, &[], anew(&whole), NEVER_S, Watching::default());
    report.unwrap();
    let at = all.iterations * 3 / 4;
    assert!(at > 8, "{} iterations are too few", all.iterations);
    let broken = Watching {
        checkpoint_at: Some(at),
        fault_at: Some(at + 1),
        ..Watching::default()
    };
    let (failed, broken) = attempt(CHAIN, &[], anew(&out), NEVER_S, broken);
    let error = failed.unwrap_err().to_string();
    assert!(error.contains("the last checkpoint stays"), "{error}");
    let told = |line: &String| line.starts_with("checkpoint after ") && line.ends_with("asked for");
    assert_eq!(broken.lines.iter().filter(|line| told(line)).count(), 1);
    let (report, rest) = attempt(
        CHAIN,
        &[],
        (&out, Start::Resume),
        NEVER_S,
        Watching::default(),
    );
    report.unwrap();
    assert!(
        rest.iterations < all.iterations * 3 / 4,
        "{} iterations after {at} of {}",
        rest.iterations,
        all.iterations
    );
    let [a, b] = [&whole, &out].map(|out| result(out, "sag_m"));
    assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
}

/// The bits of a run whose checkpoints were written in every iteration are those of one without any.
fn changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [seldom, often] = ["seldom", "often"].map(|name| folder.path().join(name));
    let changes = ["structure.cable.segments=12"];
    for (out, interval_s) in [(&seldom, NEVER_S), (&often, 0.0)] {
        let new = (out.as_path(), Start::New);
        let (report, _) = attempt(CHAIN, &changes, new, interval_s, Watching::default());
        report.unwrap();
    }
    same(&seldom, &often);
}

/// A trim that was interrupted on the case's own mesh goes on there, with the iteration that was under way.
fn a_trim_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let school = ("cases/wing-school.toml", Some("quick"));
    // Two meshes; where it rests is another test's matter.
    let changes = [
        "structure.wing.mesh.along_chord=24",
        "structure.wing.mesh.across_cell=4",
        "equilibrium.trim.iteration_limit=3",
    ];
    let meshes = |watching: &Watching| {
        let of_trim = watching
            .lines
            .iter()
            .filter(|line| line.starts_with("trim "));
        let nodes = of_trim.filter_map(|line| line.split([',', ':']).nth(1));
        let mut meshes: Vec<String> = nodes.map(str::to_owned).collect();
        meshes.dedup();
        meshes
    };
    let broken = Watching {
        fault_on_second_mesh: true,
        ..Watching::default()
    };
    let (failed, broken) = attempt(school, &changes, anew(&out), NEVER_S, broken);
    let error = failed.unwrap_err().to_string();
    assert!(error.contains("the last checkpoint stays"), "{error}");
    let both = meshes(&broken);
    assert_eq!(both.len(), 2, "{:?}", broken.lines);
    // From the checkpoint that was asked for, and from that of an interrupt.
    for stop_on_trim in [true, false] {
        let watching = Watching {
            stop_on_trim,
            ..Watching::default()
        };
        let resume = (out.as_path(), Start::Resume);
        let (report, rest) = attempt(school, &changes, resume, NEVER_S, watching);
        assert_eq!(report.unwrap().interrupted, stop_on_trim);
        assert_eq!(meshes(&rest), both[1..]);
        assert!(
            3 * rest.iterations < broken.iterations,
            "{} after {}",
            rest.iterations,
            broken.iterations
        );
    }
}

/// The steps of a run do not go on from a shape that was on its way to rest.
fn no_later_end() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let sheet = ("cases/cloth/hanging-sheet.toml", None);
    let changes = ["structure.sheet.divisions=[12, 12]", "time.end_s=0.01"];
    let watching = Watching {
        stop_at: Some(1),
        ..Watching::default()
    };
    let (report, _) = attempt(sheet, &changes, anew(&out), NEVER_S, watching);
    assert!(report.unwrap().interrupted);
    let resume = || (out.as_path(), Start::Resume);
    let later = [changes[0], "time.end_s=0.02"];
    let (refused, _) = attempt(sheet, &later, resume(), NEVER_S, Watching::default());
    let error = refused.unwrap_err().to_string();
    assert!(error.contains("may not be raised"), "{error}");
    let (report, _) = attempt(sheet, &changes, resume(), NEVER_S, Watching::default());
    assert!(!report.unwrap().interrupted);
}

/// SIGUSR1, and the time between checkpoints, while an equilibrium is sought that takes long.
fn when_asked_or_due() {
    let folder = tempfile::tempdir().unwrap();
    for (name, every) in [("asked", "1000"), ("due", "0.05")] {
        let out = folder.path().join(name);
        let endless = |more: &[&str]| {
            let mut command = command(&[
                "run",
                CHAIN.0,
                "--set",
                "structure.cable.segments=5000",
                "--set",
                "equilibrium.evaluation_limit=1000000000",
                "--checkpoint-every",
                every,
                "--out",
            ]);
            command.arg(&out).args(more);
            start(command)
        };
        let mut child = endless(&[]);
        wait_for(&mut child, &out.join("run.log"));
        if name == "asked" {
            assert!(!out.join("checkpoint").exists());
            send(&child, &["USR1"]);
        }
        wait_for(&mut child, &out.join("checkpoint"));
        child.kill().unwrap();
        child.wait().unwrap();
        let mut child = endless(&["--resume"]);
        let resumed = || {
            let log = std::fs::read_to_string(out.join("run.log")).unwrap();
            log.contains("resumed at t = ")
        };
        while !resumed() {
            assert!(child.try_wait().unwrap().is_none(), "ended too early");
            std::thread::sleep(Duration::from_millis(2));
        }
        send(&child, &["TERM"]);
        assert_eq!(child.wait().unwrap().code(), Some(75));
    }
}
