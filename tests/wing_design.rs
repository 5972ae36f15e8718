//! What a designer asks of a wing beyond its equilibrium: load test, sail support, profiles from files, panel shaping.

use libtest_mimic::Trial;
use ripstop::case::{self, Choices, Scene};
use ripstop::geometry::wing::section::Side;
use ripstop::plan::{Plan, Precision};

use crate::command_line::{Finished, ripstop, root};
use crate::engines::plain;
use crate::tolerances::wing_design as tolerance;

pub fn trials() -> Vec<Trial> {
    [
        plain("wing_design::loads_are_raised", load_test),
        plain("wing_design::where_no_line_holds_is_told", sail_support),
        plain("wing_design::profiles_come_from_files", profiles),
        plain("wing_design::panels_fly_as_designed", panel_shaping),
        plain("wing_design::numbers_in_other_units_are_doubted", doubted),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const CASE: &str = "cases/wing-school.toml";

/// What `check` says of the set-up of a case with a change.
fn warnings(case: &str, change: Option<&str>) -> Vec<String> {
    let choices = Choices {
        variant: None,
        overrides: change.into_iter().map(str::to_owned).collect(),
    };
    let case = case::load(&root().join(case), &choices).unwrap();
    Plan::new(&case.scene, Precision::F32).warnings(&case.scene)
}

/// A number in another unit, or upside down, does not pass without a word; shipped wings do.
fn doubted() {
    for shipped in [
        CASE,
        "cases/wing-27.toml",
        "cases/ram-air-parachute.toml",
        "cases/parafoil-brake.toml",
    ] {
        let of_a_wing = |text: &String| text.contains("structure.wing") || text.contains("trim.");
        let found = warnings(shipped, None);
        assert!(!found.iter().any(of_a_wing), "{shipped}: {found:?}");
    }
    for (change, told) in [
        ("equilibrium.trim.pilot_mass_kg=85000.0", "pilot_mass_kg"),
        (
            "gravity.acceleration_m_s2=[0.0, 0.0, -981.0]",
            "gravity is 981",
        ),
        (
            "equilibrium.trim.air_density_kg_m3=1.15e-3",
            "air_density_kg_m3",
        ),
        (
            "equilibrium.trim.pilot_drag_area_m2=45.0",
            "pilot_drag_area_m2",
        ),
        (
            "structure.wing.line_materials.main.mass_per_length_kg_m=1.3",
            "line_materials.main has 1.3",
        ),
        (
            "structure.wing.line_materials.gallery.diameter_m=0.008",
            "line_materials.gallery has",
        ),
        (
            "structure.wing.line_materials.main.breaking_load_n=2.3",
            "line_materials.main breaks at 2.3 N",
        ),
        (
            "structure.wing.fabrics.upper.youngs_modulus_pa=600.0",
            "fabrics.upper has a stiffness",
        ),
        (
            "structure.wing.fabrics.upper.thickness_m=0.05",
            "fabrics.upper weighs",
        ),
        (
            "structure.wing.fabrics.upper.density_kg_m3=0.038",
            "fabrics.upper weighs",
        ),
        (
            "structure.wing.hang_point_m=[1.04, 0.21, 6.2]",
            "above the lowest rib",
        ),
        ("structure.wing.rows.A.position=0.6", "row B is sewn on"),
    ] {
        let found = warnings(CASE, Some(change));
        assert!(
            found.iter().any(|text| text.contains(told)),
            "{change}: {found:?}"
        );
    }
}

struct Ran {
    output: Finished,
    summary: serde_json::Value,
    folder: tempfile::TempDir,
}

impl Ran {
    fn value(&self, name: &str) -> f64 {
        self.summary["results"][name]["value"]
            .as_f64()
            .unwrap_or_else(|| panic!("{name}: {}", self.summary["results"][name]))
    }

    fn note(&self, name: &str) -> &str {
        self.summary["results"][name]["note"].as_str().unwrap()
    }

    /// Lines of a table by the names of its columns.
    fn table(&self, name: &str) -> Vec<std::collections::HashMap<String, String>> {
        let mut reader = csv::Reader::from_path(self.folder.path().join(name)).unwrap();
        let names = reader.headers().unwrap().clone();
        reader
            .records()
            .map(|record| {
                let record = record.unwrap();
                names
                    .iter()
                    .zip(&record)
                    .map(|(a, b)| (a.to_owned(), b.to_owned()))
                    .collect()
            })
            .collect()
    }
}

fn run(more: &[&str]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = vec![
        "run",
        CASE,
        "--variant",
        "quick",
        "--out",
        folder.path().to_str().unwrap(),
    ];
    for &change in more {
        arguments.extend(["--set", change]);
    }
    let output = ripstop(&arguments);
    let text = std::fs::read(folder.path().join("summary.json")).unwrap();
    Ran {
        output,
        summary: serde_json::from_slice(&text).unwrap(),
        folder,
    }
}

/// The risers carry n times what the air does, less the weight of the wing, which stays; the line that breaks first is told with the load factor between the
/// steps; and the wing flies as before.
fn load_test() {
    let ran = run(&[
        "equilibrium.load_test.load_factors=[2.0, 4.0, 6.0]",
        "structure.wing.line_materials.gallery.breaking_load_n=300.0",
    ]);
    assert_eq!(ran.output.code, 0, "{}", ran.output.errors);
    let steps = ran.table("load_test.csv");
    assert_eq!(steps.len(), 4);
    let of = |step: usize, name: &str| -> f64 { steps[step][name].parse().unwrap() };
    let risers = |step: usize| of(step, "riser_force_right_n") + of(step, "riser_force_left_n");
    let weight = ran.value("weight_n") - 85.0 * 9.81;
    let air = risers(0) + weight;
    for (step, factor) in [2.0, 4.0, 6.0].into_iter().enumerate() {
        assert_eq!(of(step + 1, "load_factor"), factor);
        // The arc tightens under load: pressure finds less area to lift.
        let area = of(step + 1, "projected_area_m2") / of(0, "projected_area_m2");
        assert!((0.9..1.0).contains(&area), "{factor}: {area}");
        let ratio = (risers(step + 1) + weight) / (factor * air * area);
        assert!((ratio - 1.0).abs() < tolerance::RAISED, "{factor}: {ratio}");
        assert!(of(step + 1, "riser_balance_error") < 1e-2);
    }
    // Between the steps at whose ends the largest share is below and above 1.
    let shares: Vec<f64> = (0..4)
        .map(|step| of(step, "line_load_over_breaking_load_max"))
        .collect();
    let after = shares.iter().position(|share| *share > 1.0).unwrap();
    let failure = ran.value("load_test_first_failure_load_factor");
    assert!(
        failure > of(after - 1, "load_factor") && failure <= of(after, "load_factor"),
        "{failure}: {shares:?}"
    );
    let linear = of(after, "load_factor") / shares[after];
    assert!((failure / linear - 1.0).abs() < 0.1, "{failure} {linear}");
    let name = ran.note("load_test_first_failure_load_factor");
    assert!(name.contains("A level 1 from the wing of rib "), "{name}");
    // That very line is the first of the table of lines.
    let lines = ran.table("load_test_lines.csv");
    let first = lines.iter().max_by(|a, b| {
        let share = |line: &std::collections::HashMap<String, String>| -> f64 {
            line["load_over_breaking_load_at_last"]
                .parse()
                .unwrap_or(0.0)
        };
        share(a).total_cmp(&share(b))
    });
    assert!(name.starts_with("A level 1") && first.unwrap()["line"].starts_with("A level 1"));
    // Back in flight.
    let rows = ["A", "B", "C"];
    for row in rows {
        let (flown, first) = (
            ran.value(&format!("row_{row}_load_n")),
            of(0, &format!("row_{row}_load_n")),
        );
        assert!((flown / first - 1.0).abs() < 1e-9, "{row}: {flown} {first}");
    }
    for name in ["load_test.png", "load_test.vtp", "load_test_lines.png"] {
        assert!(ran.folder.path().join(name).exists(), "{name}");
    }
}

/// A row that lacks an attachment: ribs stand out there more than anywhere, at that row, and the warning names the place.
fn sail_support() {
    let lacking = |row: &str| {
        run(&[
            &format!("structure.wing.rows.{row}.ribs=[2, 5, 11, 14]"),
            &format!(
                "structure.wing.rows.{row}.levels=[{{ material = \"gallery\", joins = [2, 2], height = 0.75 }}, {{ material = \"main\" }}]"
            ),
        ])
    };
    let whole = run(&[]);
    let out = |ran: &Ran| ran.value("rib_standing_out_max");
    let warned = |ran: &Ran, words: &str| {
        let notes = ran.summary["notes"].as_array().unwrap();
        notes
            .iter()
            .any(|note| note.as_str().unwrap().contains(words))
    };
    for row in ["A", "B"] {
        let ran = lacking(row);
        assert_eq!(ran.output.code, 0, "{}", ran.output.errors);
        assert!(
            out(&ran) > 1.15 * out(&whole),
            "{row}: {} {}",
            out(&ran),
            out(&whole)
        );
        // Ribs 8 on both sides of the middle are 9 and 25 from the left tip.
        let place = ran.note("rib_standing_out_max");
        assert!(
            ["6 and 12", "22 and 28"].iter().any(|ribs| {
                place.contains(&format!(
                    "at row {row}, between the attachments of ribs {ribs}"
                ))
            }),
            "{place}"
        );
        assert!(warned(
            &ran,
            "a rib stands out between the attachments of its row"
        ));
        assert!(warned(&ran, "(8 from the middle) by"));
    }
    assert!(!warned(&whole, "ribs 6 and 12") && !warned(&whole, "(8 from the middle) by"));
}

/// A file with the coordinates of a NACA profile makes the same wing.
fn profiles() {
    let folder = tempfile::tempdir().unwrap();
    // NACA 0017 with a closed trailing edge, in Selig's order.
    let half = |x: f64| {
        5.0 * 0.17
            * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                - 0.1036 * x.powi(4))
    };
    let mut text = "NACA 0017\n".to_owned();
    for i in -60..=60_i32 {
        let x = (f64::from(i) / 60.0).powi(2);
        let sign = if i <= 0 { 1.0 } else { -1.0 };
        text.push_str(&format!(" {x:.6}  {:.6}\n", sign * half(x)));
    }
    std::fs::write(folder.path().join("p.dat"), text).unwrap();
    let source = std::fs::read_to_string(root().join(CASE)).unwrap();
    let wing = |profile: &str| {
        let choices = Choices {
            variant: Some("quick".to_owned()),
            overrides: vec![format!("structure.wing.profiles.middle={profile}")],
        };
        let case = case::parse("school", &source, folder.path(), &choices).unwrap();
        case.scene.wing().unwrap().built.clone()
    };
    let (read, known) = (wing("{ file = \"p.dat\" }"), wing("{ naca = \"0017\" }"));
    for i in 0..=200 {
        let x = f64::from(i) / 200.0;
        for side in [Side::Upper, Side::Lower] {
            let [a, b] = [&read, &known].map(|wing| wing.profiles[0].height(side, x));
            assert!((a - b).abs() < tolerance::PROFILE, "{x} {side:?}: {a} {b}");
        }
    }
    let volumes = [read, known].map(|wing| wing.measures.section_volume_m3);
    assert!((volumes[0] / volumes[1] - 1.0).abs() < 1e-3, "{volumes:?}");
}

/// Panels cut anew fly as far out as was asked for.
fn panel_shaping() {
    let ran = run(&[
        "equilibrium.panel_shaping={ aim = \"ballooning\", tolerance = 0.008, target = { upper = [[0.0, 0.06], [0.1, 0.09], [0.5, 0.08], [0.85, 0.06], [1.0, 0.0]], lower = [[0.0, 0.06], [0.3, 0.07], [0.85, 0.06], [1.0, 0.0]] } }",
    ]);
    assert_eq!(ran.output.code, 0, "{}", ran.output.errors);
    let pair = |name: &str| {
        ["before", "after"].map(|which| ran.value(&format!("panel_shaping_{name}_{which}")))
    };
    let [before, after] = pair("error_max");
    assert!(after <= 0.008 && before > 3.0 * after, "{before} {after}");
    assert!((1.0..6.0).contains(&ran.value("panel_shaping_changes")));
    // What is to be put into a case is what was cut.
    let text = std::fs::read_to_string(ran.folder.path().join("panel_shaping.toml")).unwrap();
    let plan: toml::Table = toml::from_str(&text).unwrap();
    let upper = plan["structure"]["wing"]["ballooning"]["upper"]
        .as_array()
        .unwrap();
    let rows = ran.table("panel_shaping.csv");
    let cut: Vec<f64> = rows
        .iter()
        .filter(|row| row["side"].parse::<f64>() == Ok(1.0))
        .map(|row| row["cut_after"].parse().unwrap())
        .collect();
    assert_eq!(upper.len(), cut.len());
    for (point, cut) in upper.iter().zip(&cut) {
        assert!((point[1].as_float().unwrap() - cut).abs() < 1e-9);
    }
    let svg = std::fs::read_to_string(ran.folder.path().join("panels.svg")).unwrap();
    assert_eq!(svg.matches("<path").count(), 64);
    assert!(ran.folder.path().join("panel_shaping_upper.png").exists());
}

/// The school wing on its coarse mesh.
pub fn school() -> Scene {
    let source = std::fs::read_to_string(root().join(CASE)).unwrap();
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: Vec::new(),
    };
    case::parse("school", &source, root(), &choices)
        .unwrap()
        .scene
}
