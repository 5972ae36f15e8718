//! `ripstop sweep`: kept, failing and interrupted runs, exit codes, files.

use libtest_mimic::Trial;

use crate::command_line::ripstop;
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        plain("sweep::one_run_fails_and_the_others_are_kept", one_fails),
        plain("sweep::usage_errors", usage_errors),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const CHAIN: &str = "cases/cloth/hanging-chain.toml";

/// A chain whose equilibrium needs more evaluations than one run is allowed.
fn one_fails() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sweep");
    let arguments = [
        "sweep",
        CHAIN,
        "--vary",
        "equilibrium.evaluation_limit=1,2000",
        "--result",
        "sag_m",
        "--out",
        out.to_str().unwrap(),
    ];
    let first = ripstop(&arguments);
    assert_eq!(first.code, 20, "{}", first.errors);
    assert!(
        first
            .errors
            .contains("evaluation_limit=1: the static equilibrium was not reached"),
        "{}",
        first.errors
    );
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let text = read("sweep.md");
    assert_eq!(first.printed.lines().next(), text.lines().next());
    assert!(text.contains("| 2000 | done | "), "{text}");
    assert!(text.contains("| 1 | failed | "), "{text}");
    assert!(read("sweep.csv").starts_with("equilibrium.evaluation_limit,folder,status,"));
    let json: serde_json::Value = serde_json::from_str(&read("sweep.json")).unwrap();
    let good = &json["runs"][1];
    assert_eq!(good["status"], "done");
    let own = out.join("evaluation_limit=2000");
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(own.join("summary.json")).unwrap()).unwrap();
    assert_eq!(good["results"]["sag_m"], summary["results"]["sag_m"]);
    assert!(out.join("sweep_sag_m.png").exists());

    // Again: the good run stays as it is, the other one is tried anew.
    let written = |path: &std::path::Path| std::fs::metadata(path).unwrap().modified().unwrap();
    let before = written(&own.join("summary.json"));
    let again = ripstop(&arguments);
    assert_eq!(again.code, 20);
    assert!(
        again.errors.contains("evaluation_limit=2000: kept"),
        "{}",
        again.errors
    );
    assert_eq!(written(&own.join("summary.json")), before);
    assert_eq!(read("sweep.md"), text);

    // Another case under the same name is not taken for it.
    let mut changed = arguments.to_vec();
    changed.extend(["--set", "title=another"]);
    let changed = ripstop(&changed);
    assert!(!changed.errors.contains("kept"), "{}", changed.errors);
}

fn usage_errors() {
    let refused = |arguments: &[&str], needle: &str| {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("sweep");
        let mut all = vec!["sweep", CHAIN, "--out", out.to_str().unwrap()];
        all.extend(arguments);
        let output = ripstop(&all);
        assert_eq!(output.code, 2, "{arguments:?}");
        assert!(output.errors.contains(needle), "{}", output.errors);
        assert!(!out.exists(), "{arguments:?}");
    };
    refused(&[], "--vary");
    refused(&["--vary", "time.end_s"], "no `=`");
    refused(&["--vary", "a=1,2;b=3"], "need as many");
    refused(&["--vary", "a=1", "--vary", "a=2"], "varies twice");
    // The last value is wrong, and nothing has run.
    refused(
        &["--vary", "equilibrium.evaluation_limit=100,0"],
        "evaluation_limit",
    );
    refused(&["--vary", "wings=absent"], "no such key");
    refused(
        &[
            "--vary",
            "equilibrium.evaluation_limit=100",
            "--result",
            "lift",
        ],
        "sag_m",
    );
}
