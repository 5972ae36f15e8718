//! Cases by their design: what follows from `[canopy]`, and that what is written stands.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::{self, Case, Choices, SHIPPED};
use ripstop::measure;

use crate::command_line::{ripstop, root};
use crate::engines::plain;
use crate::folders::json;

pub fn trials() -> Vec<Trial> {
    [
        plain("design::the_whole_case_runs_as_the_design", expanded),
        plain("design::what_is_written_stands", written),
        plain("design::sizes_and_units", sizes),
        plain("design::every_type_is_a_case", types),
        plain("design::the_rate_of_descent_balances", descent),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn load(text: &str, changes: &[&str]) -> Result<Case, String> {
    let choices = Choices {
        variant: None,
        overrides: changes.iter().map(|&change| change.to_owned()).collect(),
    };
    case::parse("design.toml", text, Path::new("."), &choices).map_err(|error| error.to_string())
}

fn design(keys: &str) -> String {
    format!("version = 1\n[canopy]\n{keys}\n")
}

/// What `check --expand` prints is a case of its own, with the same scene.
fn expanded() {
    for (name, text) in SHIPPED
        .iter()
        .filter(|(_, text)| text.contains("\n[canopy]"))
    {
        let short = load(text, &[]).unwrap();
        assert!(short.derived.len() > 35, "{name}");
        let whole = case::expanded(&short.text, &short.derived);
        let long = load(&whole, &[]).unwrap();
        assert!(long.derived.is_empty());
        assert_eq!(
            format!("{:?}", short.scene),
            format!("{:?}", long.scene),
            "{name}"
        );
        let file = format!("cases/designs/{name}.toml");
        let printed = ripstop(&["check", &file, "--expand"]);
        assert_eq!(printed.code, 0, "{}", printed.errors);
        assert_eq!(printed.printed, whole, "{name}");
    }
}

fn written() {
    let text = design("type = \"conical\"\ndiameter_m = 4.0\nspeed_m_s = 20.0");
    let case = load(
        &text,
        &[
            "lines.length_m=7.0",
            "belts=absent",
            "resolution.cell_size_m=0.25",
            "fabric.permeability.discharge_coefficient=0.1",
            "canopy.quality=fine",
        ],
    )
    .unwrap();
    let has = |key: &str| case.derived.iter().any(|derived| derived.key == key);
    for key in [
        "lines.length_m",
        "belts.area_m2",
        "belts",
        "resolution.cells_per_diameter",
        "fabric.permeability",
    ] {
        assert!(!has(key), "{key} is derived in spite of what is written");
    }
    assert!(has("lines.count") && has("structure.conical.cone_angle_deg"));
    let air = case.scene.air.as_ref().unwrap();
    assert_eq!(air.units.cell_size_m, 0.25);
    assert_eq!(case.scene.steady_drag_confidence, Some(0.03));
    for (change, told) in [
        ("canopy.gores=2", "gores"),
        ("canopy.slots=4", "ringslot"),
        ("canopy.fabric=silk", "is not known"),
        ("canopy.diameter_ft=12.0", "twice"),
        ("structure.annular.rings=12", "another canopy"),
        ("canopy.speed_m_s=absent", "payload_kg"),
        ("canopy.payload_drag_area_m2=0.1", "needs canopy.payload_kg"),
    ] {
        let message = load(&text, &[change]).unwrap_err();
        assert!(message.contains(told), "{change}: {message}");
    }
    let refused = ripstop(&["check", "cases/sphere.toml", "--quality", "draft"]);
    assert_eq!(refused.code, 2);
    assert!(
        refused.errors.contains("needs [canopy]"),
        "{}",
        refused.errors
    );
}

/// The same canopy in the units of another drawing is the same case; twice the size and the speed has the same lattice.
fn sizes() {
    let metric =
        "type = \"flat_circular\"\ndiameter_m = 3.6576\nspeed_m_s = 30.48\naltitude_m = 3048.0";
    let imperial =
        "type = \"flat_circular\"\ndiameter_ft = 12.0\nspeed_ft_s = 100.0\naltitude_ft = 10000.0";
    let [metric, imperial] = [metric, imperial].map(|keys| load(&design(keys), &[]).unwrap());
    assert_eq!(metric.hash, imperial.hash);
    let one =
        "type = \"flat_circular\"\ngores = 16\nstart = \"open\"\nlines = \"nylon cord 750 lbf\"\n";
    let [small, large] = [
        "diameter_m = 2.0\nspeed_km_h = 36.0",
        "diameter_m = 4.0\nspeed_m_s = 20.0",
    ]
    .map(|size| load(&design(&format!("{one}{size}")), &[]).unwrap());
    let [small, large] = [&small, &large].map(|case| case.scene.air.as_ref().unwrap());
    assert_eq!(small.cells, large.cells);
    // Derived keys have six digits.
    assert!((large.units.time_step_s / small.units.time_step_s - 1.0).abs() < 1e-5);
    assert!((large.units.cell_size_m / small.units.cell_size_m - 2.0).abs() < 1e-5);
}

fn types() {
    for kind in [
        "flat_circular",
        "conical",
        "extended_skirt",
        "disk_gap_band",
        "ringslot",
        "cruciform",
    ] {
        for start in ["folded", "hemispherical", "open"] {
            for flow in [
                "speed_m_s = 25.0",
                "payload_kg = 30.0",
                "payload_lb = 60.0\nspeed_kt = 80.0",
            ] {
                let keys =
                    format!("type = \"{kind}\"\ndiameter_m = 3.0\nstart = \"{start}\"\n{flow}");
                let case = load(&design(&keys), &[])
                    .unwrap_or_else(|told| panic!("{kind} {start} {flow}: {told}"));
                let known = measure::result_names(&case.scene);
                for comparison in &case.scene.comparisons {
                    assert!(
                        known.contains(&comparison.quantity),
                        "{kind}: {}",
                        comparison.quantity
                    );
                }
                let (falls, carries) = (case.scene.descent.is_some(), case.scene.carried.is_some());
                assert_eq!(falls, flow.contains("kt"));
                assert_eq!(carries, flow.contains("kg"));
                let diameter = case.scene.canopy().unwrap().nominal_diameter_m;
                assert!((diameter / 3.0 - 1.0).abs() < 1e-5, "{kind}: {diameter}");
            }
        }
    }
}

/// The rate of descent is where drag without walls bears payload, fabric, tapes and lines.
fn descent() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = ripstop(&[
        "run",
        "cases/designs/personnel-descent.toml",
        "--variant",
        "quick",
        "--set",
        "time.end_s=0.5",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let results = &json(&out.join("summary.json"))["results"];
    let value = |name: &str| results[name]["value"].as_f64().unwrap();
    let rate = value("descent_rate_m_s");
    let drag_n = 0.5 * 1.225 * rate * rate * value("drag_coefficient_blockage_corrected") * 78.5398;
    let (_, text) = SHIPPED
        .iter()
        .find(|(name, _)| *name == "personnel-descent")
        .unwrap();
    let case = case::parse("descent", text, root(), &Choices::default()).unwrap();
    let structure = &case.scene.body.as_ref().unwrap().structure;
    let own_kg: f64 = structure.masses_kg.iter().sum();
    // 78.5 m² of 40.7 g/m²; 28 lines of 10 m of 6.61 g/m and tapes of 5 m of 3.0 g/m.
    assert!(
        (own_kg / (3.18 + 1.85 + 0.42) - 1.0).abs() < 0.03,
        "{own_kg}"
    );
    assert!(
        (drag_n / ((100.0 + own_kg) * 9.80665) - 1.0).abs() < 0.01,
        "{drag_n}"
    );
}
