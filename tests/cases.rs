//! Every shipped case runs, shortened where it has a quick variant, and delivers all its files.

use std::collections::BTreeMap;

use libtest_mimic::Trial;
use ripstop::case::{Choices, SHIPPED};

use crate::command_line::{ripstop, root};
use crate::engines::plain;

/// Largest relative error of a result that has a reference, in the shipped cases.
fn reference_error(name: &str) -> f64 {
    match name {
        // Eight cells per diameter in a narrow box, still settling.
        "sphere" => 0.2,
        _ => 0.01,
    }
}

/// Every case file under `cases/`, but for those that must be refused: its path from the root, by the name that `ripstop new` knows.
pub fn files() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec!["cases".to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let name = entry.file_name().into_string().unwrap();
            let path = format!("{folder}/{name}");
            if entry.file_type().unwrap().is_dir() {
                if name != "bad" {
                    folders.push(path);
                }
            } else if let Some(stem) = name.strip_suffix(".toml") {
                let other = found.insert(stem.to_owned(), path);
                assert_eq!(other, None, "two cases are called {stem}");
            }
        }
    }
    found
}

pub fn trials() -> Vec<Trial> {
    let files = files();
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let mut shipped: Vec<&str> = SHIPPED.iter().map(|(name, _)| *name).collect();
    shipped.sort_unstable();
    assert_eq!(
        names, shipped,
        "cases/ and the embedded cases must be the same"
    );
    files
        .into_iter()
        .flat_map(|(name, file)| {
            let is_bare_wing = SHIPPED
                .iter()
                .any(|(own, text)| *own == name && text.contains("[aero."));
            let trial = format!("case::{name}");
            // What there is to run of a wing by itself is its polar (tests/polar.rs).
            plain(&trial, move || {
                if is_bare_wing {
                    crate::polar::bare_case(&file);
                } else {
                    case(&name, &file);
                }
            })
        })
        .collect()
}

fn case(name: &str, file: &str) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let text = std::fs::read_to_string(root().join(file)).unwrap();
    let mut arguments = vec!["run", file, "--out", out.to_str().unwrap()];
    if text.contains("[variants.quick") {
        arguments.extend(["--variant", "quick"]);
    }
    let output = ripstop(&arguments);
    assert_eq!(output.code, 0, "{}", output.errors);
    let read = |file: &str| std::fs::read(out.join(file)).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&read("summary.json")).unwrap();
    assert_eq!(summary["schema_version"], 1);
    let results = summary["results"].as_object().unwrap();
    assert!(!results.is_empty());
    // What comparisons may name is known before a run.
    let choices = Choices {
        variant: arguments.contains(&"quick").then(|| "quick".to_owned()),
        overrides: Vec::new(),
    };
    let loaded = ripstop::case::load(&root().join(file), &choices).unwrap();
    let mut known = ripstop::measure::result_names(&loaded.scene);
    known.sort();
    let mut found: Vec<String> = results.keys().cloned().collect();
    found.sort();
    assert_eq!(found, known);
    let compared = summary["comparison"].as_array().map_or(0, Vec::len);
    assert_eq!(compared, loaded.scene.comparisons.len());
    assert_eq!(out.join("comparison.csv").exists(), compared > 0);
    for (key, result) in results {
        assert!(result["unit"].is_string(), "{key}");
        assert!(
            result["value"].is_number() || result["note"].is_string(),
            "{key} has neither value nor reason: {result}"
        );
        if let Some(error) = result.get("error").and_then(serde_json::Value::as_f64) {
            assert!(error.abs() < reference_error(name), "{key}: {result}");
        }
    }
    assert!(read("snapshot_000.png").starts_with(b"\x89PNG\r\n\x1a\n"));
    let history = String::from_utf8(read("history.csv")).unwrap();
    assert!(history.starts_with("time_s,"), "{history}");
    if text.contains("[structure") {
        assert!(
            read("frames/canopy_00000.vtp")
                .trim_ascii_end()
                .ends_with(b"</VTKFile>")
        );
        assert!(
            String::from_utf8(read("canopy.pvd"))
                .unwrap()
                .contains("frames/canopy_00000.vtp")
        );
    }
    if text.contains("[bodies.") {
        assert!(
            read("frames/bodies_00000.vtp")
                .trim_ascii_end()
                .ends_with(b"</VTKFile>")
        );
        assert!(
            String::from_utf8(read("bodies.pvd"))
                .unwrap()
                .contains("frames/bodies_00000.vtp")
        );
    }
    if text.contains("[air]") {
        assert!(
            read("frames/flow_00000.vti")
                .trim_ascii_end()
                .ends_with(b"</VTKFile>")
        );
    }
    if name == "flat-circular-tunnel" {
        for key in [
            "drag_coefficient",
            "projected_diameter_ratio",
            "height_m",
            "line_tension_mean_n",
            "line_tension_max_n",
            "belt_tension_max_n",
            "stress_max_pa",
            "force_imbalance",
            "slip_mean",
            "mass_drift",
            "fill_time_s",
        ] {
            assert!(results[key]["value"].is_number(), "{key}: {}", results[key]);
        }
    }
}
