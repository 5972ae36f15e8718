//! Cases by their design: what follows from `[canopy]`, `[wing]` and `[mesh]`, and that what is written stands.

use std::path::Path;

use libtest_mimic::Trial;
use ripstop::case::scene::Flow;
use ripstop::case::{self, Case, Choices, DESIGN_TABLES, SHIPPED};
use ripstop::measure;

use crate::command_line::{ripstop, root};
use crate::engines::plain;
use crate::folders::json;

pub fn trials() -> Vec<Trial> {
    [
        plain("design::the_whole_case_runs_as_the_design", expanded),
        plain("design::what_is_written_stands", written),
        plain("design::reasons_are_those_of_what_is_there", reasons),
        plain("design::the_wind_follows_what_is_written", balanced),
        plain("design::sizes_and_units", sizes),
        plain("design::every_type_is_a_case", types),
        plain("design::the_rate_of_descent_balances", descent),
        plain("design::every_class_of_wings_is_a_case", wings),
        plain("design::a_wing_flies_as_it_is_asked_for", flown),
        plain("design::every_type_of_meshes_is_a_case", meshes),
        plain(
            "design::a_designed_mesh_stands_in_its_tunnel",
            in_the_tunnel,
        ),
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
    case::parse("design.toml", text, Path::new("."), &choices).map_err(|error| {
        let help = miette::Diagnostic::help(&*error).map(|help| help.to_string());
        format!("{error} {}", help.unwrap_or_default())
    })
}

fn design(keys: &str) -> String {
    format!("version = 1\n[canopy]\n{keys}\n")
}

/// What `check --expand` prints is a case of its own, with the same scene.
fn expanded() {
    let is_design = |text: &str| {
        let tables = DESIGN_TABLES.iter();
        tables
            .into_iter()
            .any(|t| text.contains(&format!("\n[{t}]\n")))
    };
    let designs = SHIPPED.iter().filter(|(_, text)| is_design(text));
    assert_eq!(designs.clone().count(), 5);
    for (name, text) in designs {
        let file = &crate::cases::files()[*name];
        let folder = root().join(file);
        let load = |text: &str| {
            let folder = folder.parent().unwrap();
            case::parse(file, text, folder, &Choices::default()).unwrap()
        };
        let short = load(text);
        assert!(short.derived.len() > 30, "{name}");
        let whole = case::expanded(&short.text, &short.derived);
        let long = load(&whole);
        assert!(long.derived.is_empty());
        assert_eq!(
            format!("{:?}", short.scene),
            format!("{:?}", long.scene),
            "{name}"
        );
        let printed = ripstop(&["check", file, "--expand"]);
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
        ("structure.annular.rings=12", "another structure"),
        ("canopy.speed_m_s=absent", "payload_kg"),
        ("canopy.payload_drag_area_m2=0.1", "needs canopy.payload_kg"),
    ] {
        let message = load(&text, &[change]).unwrap_err();
        assert!(message.contains(told), "{change}: {message}");
    }
    // What is wrong with a key that follows says what it follows from.
    let message = load(&text, &["canopy.gores=2"]).unwrap_err();
    assert!(
        message.contains("follows from the design (gores)"),
        "{message}"
    );
    let refused = ripstop(&["check", "cases/sphere.toml", "--quality", "draft"]);
    assert_eq!(refused.code, 2);
    assert!(
        refused.errors.contains("needs a design"),
        "{}",
        refused.errors
    );
}

/// Rings that slots ask for are not said to be of the quality. Constants beside others that are written are not said to be of a cord that is not there.
fn reasons() {
    let reason = |case: &Case, key: &str| -> (i64, String) {
        let mut derived = case.derived.iter();
        let one = derived.find(|one| one.key == key).unwrap();
        (one.value.as_integer().unwrap_or_default(), one.why.clone())
    };
    let rings = |keys: &str| {
        let text = format!("type = \"ringslot\"\ndiameter_m = 4.0\nspeed_m_s = 20.0\n{keys}");
        let case = load(&design(&text), &[]).unwrap();
        reason(&case, "structure.ringslot.rings")
    };
    for (keys, wanted) in [("", 14), ("slots = 9\nquality = \"fine\"", 20)] {
        let (count, why) = rings(keys);
        assert_eq!(count, wanted);
        assert!(why.contains("between slots"), "{why}");
    }
    let few = (12, "quality".to_owned());
    assert_eq!(rings("slots = 4"), few);

    let text = design("type = \"conical\"\ndiameter_m = 4.0\nspeed_m_s = 20.0");
    let named = |change: &str, key: &str| {
        let changes: &[&str] = if change.is_empty() { &[] } else { &[change] };
        let (_, why) = reason(&load(&text, changes).unwrap(), key);
        why.contains("beside other constants that the case writes")
    };
    for (change, of_its_table, of_others) in [
        (
            "lines.area_m2=1e-5",
            "lines.diameter_m",
            "lines.drag_coefficient",
        ),
        (
            "lines.breaking_load_n=9e3",
            "lines.area_m2",
            "belts.area_m2",
        ),
        (
            "lines.force_strain=[[0.1, 900.0], [0.2, 2000.0]]",
            "lines.area_m2",
            "lines.count",
        ),
        (
            "belts.density_kg_m3=1300.0",
            "belts.area_m2",
            "lines.area_m2",
        ),
        (
            "fabric.thickness_m=1e-4",
            "fabric.density_kg_m3",
            "belts.area_m2",
        ),
    ] {
        assert!(named(change, of_its_table), "{change}: {of_its_table}");
        assert!(!named(change, of_others), "{change}: {of_others}");
        assert!(!named("", of_its_table), "{of_its_table}");
    }
    assert!(!named("lines.length_m=7.0", "lines.area_m2"));
    // What breaks a cord of other constants is not known; its thickness in the wind says nothing of it.
    let has_strength = |change: &str, key: &str| {
        let case = load(&text, &[change]).unwrap();
        case.derived.iter().any(|one| one.key == key)
    };
    for (change, key, is_known) in [
        ("lines.area_m2=1e-5", "lines.breaking_load_n", false),
        ("lines.diameter_m=2e-3", "lines.breaking_load_n", true),
        ("belts.density_kg_m3=1300.0", "belts.breaking_load_n", false),
        ("lines.area_m2=1e-5", "belts.breaking_load_n", true),
    ] {
        assert_eq!(has_strength(change, key), is_known, "{change}: {key}");
    }

    let case = load(
        "version = 1\n[wing]\nclass = \"en_b\"\nspan_m = 11.0\nquality = \"draft\"\n",
        &["structure.wing.fabrics.upper.density_kg_m3=900.0"],
    )
    .unwrap();
    let of = |part: &str| reason(&case, &format!("structure.wing.fabrics.{part}.thickness_m")).1;
    assert!(
        of("upper").contains("beside other constants"),
        "{}",
        of("upper")
    );
    assert!(
        !of("ribs").contains("beside other constants"),
        "{}",
        of("ribs")
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
    // What is wrong is told under the key that is written, and in its unit.
    for (keys, told) in [
        (
            "diameter_ft = 700.0\nspeed_kt = 50.0",
            "canopy.diameter_ft = 700 is out of range allowed are values from 0.0328084 to 656.168",
        ),
        (
            "diameter_ft = 12.0\nspeed_kt = 50.0\naltitude_ft = 40000.0",
            "canopy.altitude_ft = 40000 is out of range",
        ),
        (
            "diameter_ft = 12.0\nspeed_kt = -50.0",
            "canopy.speed_kt = -5e1 must be positive",
        ),
    ] {
        let message = load(&design(&format!("type = \"conical\"\n{keys}")), &[]).unwrap_err();
        assert!(message.contains(told), "{keys}: {message}");
    }
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

/// What a case says itself of air, gravity and payload counts in the wind of a steady descent, and in all that follows from it.
fn balanced() {
    let text = "version = 1\n[canopy]\ntype = \"flat_circular\"\ndiameter_m = 10.0\npayload_kg = 100.0\nquality = \"draft\"\n";
    let wind = |changes: &[&str]| {
        let case = load(text, changes).unwrap();
        let air = case.scene.air.unwrap();
        let Flow::WindTunnel {
            speed_m_s,
            start_time_s,
            ..
        } = air.flow
        else {
            panic!("no tunnel");
        };
        // Diameters in which the wind rises.
        let rise = start_time_s * speed_m_s / 10.0;
        assert!((rise / 0.67 - 1.0).abs() < 0.01, "{rise}");
        speed_m_s
    };
    let usual = wind(&[]);
    let drag_area_m2 = 2.0 * 100.0 * 9.80665 / (1.225 * usual * usual);
    assert!(
        (drag_area_m2 / 78.54 - 0.775).abs() < 0.05,
        "{drag_area_m2}"
    );
    let payload = (drag_area_m2 / (drag_area_m2 + 60.0)).sqrt();
    for (change, factor) in [
        ("air.density_kg_m3=0.3648", (1.225_f64 / 0.3648).sqrt()),
        ("canopy.altitude_m=11000.0", (1.225_f64 / 0.3639).sqrt()),
        (
            "gravity.acceleration_m_s2=[-3.71, 0.0, 0.0]",
            (3.71_f64 / 9.80665).sqrt(),
        ),
        ("canopy.payload_drag_area_m2=60.0", payload),
        ("payload.drag_area_m2=60", payload),
        ("payload.drag_area_m2=absent", 1.0),
        ("payload.mass_kg=400.0", 2.0),
        // No gravity is the usual one.
        ("gravity.acceleration_m_s2=[0.0, 0.0, 0.0]", 1.0),
    ] {
        let ratio = wind(&[change]) / usual;
        assert!((ratio / factor - 1.0).abs() < 0.003, "{change}: {ratio}");
    }
    assert!((wind(&["air.wind_tunnel.speed_m_s=10.0"]) - 10.0).abs() < 1e-12);
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

fn wing(keys: &str) -> Result<Case, String> {
    load(&format!("version = 1\n[wing]\n{keys}\n"), &[])
}

/// Wings of every class and any number of cells are cases whose area, span and mass are those that were asked for.
fn wings() {
    for class in ["en_a", "en_b", "en_c", "en_d"] {
        for cells in [6, 7, 13, 24, 31, 44, 63, 90, 131, 200] {
            let case = wing(&format!(
                "class = \"{class}\"\nspan_m = 11.0\naspect_ratio = 5.5\ncells = {cells}\npilot_lb = 198.0\nquality = \"draft\""
            ));
            let case = case.unwrap_or_else(|told| panic!("{class} {cells}: {told}"));
            let measures = &case.scene.wing().unwrap().built.measures;
            assert!((measures.flat_span_m / 11.0 - 1.0).abs() < 1e-5);
            // Chords between stations are those of cubics, the design's of an ellipse.
            let area = measures.flat_area_m2 / 22.0;
            assert!((area - 1.0).abs() < 0.01, "{class} {cells}: {area}");
            let pilot = (case.derived.iter())
                .find(|one| one.key == "equilibrium.trim.pilot_mass_kg")
                .and_then(|one| one.value.as_float());
            assert!((pilot.unwrap() / 89.811 - 1.0).abs() < 1e-4);
        }
    }
    // Whoever flies has the drag of his own mass, wherever that is written; once.
    let flown = load(
        "version = 1\n[wing]\nclass = \"en_b\"\nspan_m = 11.0\n[equilibrium.trim]\npilot_mass_kg = 110.0\n",
        &[],
    );
    let flown = flown.unwrap();
    let drag = flown.derived.iter();
    let drag: Vec<f64> = drag
        .filter(|one| one.key == "equilibrium.trim.pilot_drag_area_m2")
        .filter_map(|one| one.value.as_float())
        .collect();
    assert_eq!(drag.len(), 1);
    let expected = 0.45 * f64::powf(110.0 / 95.0, 2.0 / 3.0);
    assert!((drag[0] / expected - 1.0).abs() < 1e-4, "{drag:?}");
    let by_area = wing("class = \"en_c\"\narea_m2 = 27.0").unwrap();
    let measures = &by_area.scene.wing().unwrap().built.measures;
    // As of `wing-27`, the shipped plan of the class: 26.996 m2, 12.94 m.
    assert!((measures.flat_span_m / 12.94 - 1.0).abs() < 0.01);
    assert!((measures.flat_area_m2 / 27.0 - 1.0).abs() < 0.02);
    for (keys, told) in [
        ("class = \"en_b\"", "span_m"),
        (
            "class = \"en_b\"\nspan_m = 11.0\narea_m2 = 20.0",
            "keep one",
        ),
        (
            "class = \"en_b\"\nspan_ft = 36.0\narea_m2 = 20.0",
            "wing.span_ft and wing.area_m2",
        ),
        ("class = \"en_b\"\nspan_ft = 200.0", "wing.span_ft = 200 is"),
        ("class = \"en_b\"\narea_m2 = 500.0", "wing.area_m2 = 500 is"),
        (
            "class = \"en_b\"\nspan_ft = 36.0\npilot_lb = 3000.0",
            "wing.pilot_lb = 3000 is out of range",
        ),
        ("class = \"en_b\"\nspan_m = 11.0\ncells = 3", "out of range"),
        ("class = \"en_e\"\nspan_m = 11.0", "en_d"),
    ] {
        let message = wing(keys).unwrap_err();
        assert!(message.contains(told), "{keys}: {message}");
    }
}

/// What `new --wing` writes trims: risers bear the weight, and the wing glides at a speed and slope that paragliders have.
fn flown() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let options = [
        "--span", "9.4", "--cells", "36", "--class", "en_a", "--pilot", "75",
    ];
    let written = ripstop(&[&["new", "--wing", "--out", &at("mine")][..], &options].concat());
    assert_eq!(written.code, 0, "{}", written.errors);
    let case = at("mine/paraglider.toml");
    let output = ripstop(&["run", &case, "--quality", "draft", "--out", &at("out")]);
    assert_eq!(output.code, 0, "{}", output.errors);
    let summary = json(&folder.path().join("out/summary.json"));
    let value = |name: &str| summary["results"][name]["value"].as_f64().unwrap();
    assert!(
        (8.0..13.0).contains(&value("speed_m_s")),
        "{}",
        output.printed
    );
    assert!(
        (4.5..10.0).contains(&value("glide_ratio")),
        "{}",
        output.printed
    );
    let refused = ripstop(&["new", "--wing", "--span", "-3"]);
    assert_eq!(refused.code, 2);
    assert!(refused.errors.contains("wing.span_m"), "{}", refused.errors);
}

fn mesh_case(keys: &str) -> Result<Case, String> {
    let text = format!("version = 1\n[mesh]\nspeed_m_s = 12.0\n{keys}\n");
    let folder = root().join("cases");
    case::parse("mesh.toml", &text, &folder, &Choices::default()).map_err(|told| told.to_string())
}

const HEMISPHERE: &str = "file = \"meshes/hemisphere.obj\"";
const LINES: &str = "line_table = \"meshes/hemisphere-lines.csv\"";

fn meshes() {
    let canopy = mesh_case(&format!("type = \"canopy\"\n{HEMISPHERE}\n{LINES}")).unwrap();
    let known = canopy.scene.canopy().unwrap();
    // The area of its triangles, a little less than that of the hemisphere.
    assert!((known.nominal_area_m2 / 0.7697 - 1.0).abs() < 0.01);
    let body = mesh_case(&format!("type = \"rigid\"\n{HEMISPHERE}\nscale = 2.0")).unwrap();
    let known = &body.scene.rigid_bodies[0];
    // A disk of 1.4 m is what it shows to the wind.
    assert!((known.reference_area_m2 / 1.5394 - 1.0).abs() < 0.02);
    assert!((known.reference_length_m / 1.4 - 1.0).abs() < 1e-6);
    let sheet = mesh_case(&format!(
        "type = \"sheet\"\n{HEMISPHERE}\nheld_nodes = [1, 2]"
    ))
    .unwrap();
    let held = sheet.scene.body.as_ref().unwrap().structure.held.iter();
    assert_eq!(held.filter(|held| **held).count(), 2);
    for (keys, told) in [
        (
            format!("type = \"canopy\"\n{HEMISPHERE}"),
            "line_table is missing",
        ),
        (
            format!("type = \"sheet\"\n{HEMISPHERE}"),
            "held_nodes is missing",
        ),
        (
            format!("type = \"rigid\"\n{HEMISPHERE}\n{LINES}"),
            "has no effect",
        ),
        (
            format!("type = \"rigid\"\n{HEMISPHERE}\nfabric = \"ripstop 40 g/m²\""),
            "has no effect",
        ),
        (
            "type = \"rigid\"\nfile = \"nowhere.obj\"".to_owned(),
            "nowhere.obj",
        ),
    ] {
        let message = mesh_case(&keys).unwrap_err();
        assert!(message.contains(told), "{keys}: {message}");
    }
}

/// However a mesh lies in its file, it stands in the middle of its tunnel, with the same room on every side.
fn in_the_tunnel() {
    for more in [
        "",
        "rotation = { axis = [1.0, 0.0, 0.0], angle_deg = 90.0 }",
        "altitude_m = 1000.0",
    ] {
        let keys = format!("type = \"canopy\"\n{HEMISPHERE}\n{LINES}\n{more}");
        let case = mesh_case(&keys).unwrap();
        let structure = &case.scene.body.as_ref().unwrap().structure;
        let canopy = case.scene.canopy().unwrap();
        let fabric = &structure.positions_m[..canopy.canopy_node_count];
        let air = case.scene.air.as_ref().unwrap();
        let diameter = canopy.nominal_diameter_m;
        for axis in 1..3 {
            let places = || fabric.iter().map(|p| p[axis]);
            let low = places().fold(f64::INFINITY, f64::min);
            let high = places().fold(f64::NEG_INFINITY, f64::max);
            let size = air.cells[axis] as f64 * air.units.cell_size_m;
            assert!(
                (0.5 * (low + high) / (0.5 * size) - 1.0).abs() < 0.02,
                "{more}"
            );
            assert!((size / diameter - 6.0).abs() < 0.2, "{more}: {size}");
        }
        let ends = structure.positions_m.iter().map(|p| p.x);
        assert!(ends.fold(f64::INFINITY, f64::min) > 0.29 * diameter);
    }
}
