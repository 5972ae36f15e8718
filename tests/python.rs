//! The examples of docs/python.md, run by Python on the folder of a run.

use std::path::PathBuf;
use std::process::Command;

use libtest_mimic::Trial;

use crate::command_line::{finished, root};
use crate::folders::{canopy, json};

const PAGE: &str = "docs/python.md";

pub fn trials() -> Vec<Trial> {
    let name = "python::examples_read_a_run";
    let skipped = |why: &str| {
        Trial::test(name, || Ok(()))
            .with_ignored_flag(true)
            .with_kind(why)
    };
    let trial = match python() {
        // The pages are not everywhere that the tests run.
        _ if !root().join(PAGE).exists() => skipped("docs/python.md is not here"),
        Some(python) => Trial::test(name, move || {
            examples(Command::new(python));
            Ok(())
        }),
        None => skipped("no Python with pandas and pyvista"),
    };
    vec![trial]
}

/// A Python that has what the page uses: that which `RIPSTOP_PYTHON` names, or `python3`.
fn python() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("RIPSTOP_PYTHON") {
        return Some(named.into());
    }
    let looks = "import importlib.util as u, sys; sys.exit(any(u.find_spec(m) is None for m in ['pandas', 'pyvista', 'PIL']))";
    let found = Command::new("python3").args(["-c", looks]).output().ok()?;
    found.status.success().then(|| "python3".into())
}

fn examples(mut python: Command) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let more = [
        "--set",
        "time.end_s=0.03",
        "--set",
        "output.flow_interval_s=0.01",
        "--set",
        "output.picture_times_s=[0.0]",
    ];
    let run = finished(canopy(&out, &more).output().unwrap());
    assert_eq!(run.code, 0, "{}", run.errors);
    let page = std::fs::read_to_string(root().join(PAGE)).unwrap();
    let blocks: Vec<&str> = page
        .split("```python\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap())
        .collect();
    assert!(blocks.len() >= 6, "{}", blocks.len());
    let script = folder.path().join("examples.py");
    std::fs::write(&script, blocks.join("\n")).unwrap();
    let output = python.arg(&script).current_dir(folder.path()).output();
    let output = finished(output.unwrap());
    assert_eq!(output.code, 0, "{}", output.errors);
    let summary = json(&out.join("summary.json"));
    let tension = summary["results"]["line_tension_max_n"]["value"].as_f64();
    let tension = format!("largest tension of a line: {:.1} N", tension.unwrap());
    for told in [
        &tension[..],
        "program: ripstop version",
        "source: flat-circular-tunnel.toml, --set",
        "N in a line",
        "points, up to",
        "Software: ripstop version",
        "[fabric]",
    ] {
        assert!(output.printed.contains(told), "{told}: {}", output.printed);
    }
    // What does not act on the state is not part of it.
    assert!(!output.printed.contains("picture_times_s"));
}
