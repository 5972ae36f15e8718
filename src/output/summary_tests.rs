use std::fs;

use super::*;
use crate::output::Quantity;
use crate::output::ReadOut;

fn summary() -> Summary {
    let mut results = Results::new();
    let drag = Quantity::new(1234.5678).with_confidence(12.3);
    results.insert(
        &ReadOut::new("zeta_drag", "N", ""),
        drag.with_reference(1200.0, "Smith 1999"),
    );
    results.insert(
        &ReadOut::new("alpha_time", "s", ""),
        Quantity::new(f64::NAN),
    );
    results.insert(
        &ReadOut::new("mid_size", "m²", ""),
        Quantity::new(2.5).with_reference(0.0, "zero"),
    );
    Summary {
        schema_version: SCHEMA_VERSION,
        ripstop_version: "0.1.0".to_owned(),
        case: CaseInfo {
            title: "Disk".to_owned(),
            file: "cases/disk.toml".to_owned(),
            variant: None,
            hash: "ab12".to_owned(),
        },
        engine: "cpu".to_owned(),
        device: "2 cores".to_owned(),
        precision: "f32".to_owned(),
        fabric: Some(Processor {
            engine: "cpu".to_owned(),
            device: "2 cores".to_owned(),
            precision: "f64".to_owned(),
        }),
        threads: 2,
        cells: Some([8, 6, 4]),
        lattices: Vec::new(),
        markers: 10,
        nodes: 4,
        triangles: 1,
        steps: 100,
        resumed_at_step: Some(40),
        simulated_s: 1.5,
        wall_s: 3.25,
        million_lattice_updates_per_s: Some(5.0),
        milliseconds_per_step: MillisecondsPerStep::default(),
        structure_every: None,
        stages: Vec::new(),
        device_use: None,
        stop: StopInfo {
            state: "finished".to_owned(),
            reason: "end time reached".to_owned(),
            when_s: 1.5,
        },
        skipped: Vec::new(),
        account: Vec::new(),
        validity: Vec::new(),
        expected_errors: Vec::new(),
        notes: vec!["a note".to_owned()],
        details: vec!["a detail".to_owned()],
        averaging_window_s: None,
        results,
        comparison: Vec::new(),
    }
}

fn written(summary: &Summary) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("summary.json");
    write_summary(&path, summary).unwrap();
    fs::read_to_string(&path).unwrap()
}

#[test]
fn results_keep_their_order_and_read_back() {
    let text = written(&summary());
    let place = |name: &str| text.find(&format!("\"{name}\": {{")).unwrap();
    assert!(place("zeta_drag") < place("alpha_time"));
    assert!(place("alpha_time") < place("mid_size"));
    assert!(text.starts_with("{\n  \"schema_version\": 1,\n"));
    assert!(text.ends_with("}\n"));
    let read: Summary = serde_json::from_str(&text).unwrap();
    assert_eq!(read, summary());
    let names: Vec<&str> = read.results.iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["zeta_drag", "alpha_time", "mid_size"]);
}

#[test]
fn inserting_again_replaces_in_place() {
    let mut results = summary().results;
    results.insert(&ReadOut::new("zeta_drag", "N", ""), Quantity::new(1.0));
    assert_eq!(results.len(), 3);
    assert_eq!(results.iter().next().unwrap().0, "zeta_drag");
    assert_eq!(results.get("zeta_drag").unwrap().value, Some(1.0));
    assert!(results.get("none").is_none());
}

#[test]
fn numbers_that_are_not_finite_become_null_with_a_note() {
    let mut strange = summary();
    strange.wall_s = f64::INFINITY;
    strange.million_lattice_updates_per_s = Some(f64::NAN);
    let mut quantity = Quantity::missing("too short a run");
    quantity.value = Some(f64::NEG_INFINITY);
    strange
        .results
        .insert(&ReadOut::new("raw", "N", ""), quantity);
    let json: serde_json::Value = serde_json::from_str(&written(&strange)).unwrap();
    assert!(json["wall_s"].is_null());
    assert!(json["million_lattice_updates_per_s"].is_null());
    assert_eq!(
        json["notes"],
        serde_json::json!([
            "a note",
            "million_lattice_updates_per_s was not finite (NaN)",
            "wall_s was not finite (inf)"
        ])
    );
    let raw = &json["results"]["raw"];
    assert!(raw["value"].is_null());
    assert_eq!(raw["note"], "too short a run; value was not finite (-inf)");
    assert!(raw.get("reference").is_none());
    let alpha = &json["results"]["alpha_time"];
    assert_eq!(alpha["note"], "value was not finite (NaN)");
    let read: Summary = serde_json::from_value(json).unwrap();
    assert!(read.wall_s.is_nan());
}

#[test]
fn the_table_is_aligned() {
    assert_eq!(
        summary().table(),
        "result       value ±    unit  reference   error\n\
         zeta_drag     1235 ±12  N        1200.0  +2.9 %\n\
         alpha_time       - -    s             -       -\n\
         mid_size    2.5000 -    m²            0       -\n\
         alpha_time: value was not finite (NaN)\n"
    );
    let mut empty = summary();
    empty.results = Results::new();
    assert_eq!(empty.table(), "no results\n");
}
