//! `ripstop polar`: a wing by itself against a wind tunnel, and a glider over its bar and brakes.

use std::collections::BTreeMap;
use std::path::Path;

use libtest_mimic::Trial;

use crate::command_line::ripstop;
use crate::engines::plain;

pub fn trials() -> Vec<Trial> {
    [
        plain("polar::a_measured_wing_stalls", a_measured_wing_stalls),
        plain("polar::a_sweep_has_no_memory", a_sweep_has_no_memory),
        plain("polar::sideslip_rolls_a_wing", sideslip),
        plain("polar::a_mesh_is_cut_into_its_wing", mesh),
        plain("polar::thin_and_missing_things_are_told", refused),
        plain("polar::caps_are_counted", caps),
        plain("polar::speeds_at_which_air_is_squeezed_are_told", squeezed),
        plain("polar::given_polars_know_no_brakes", given_polars),
        plain("polar::a_glider_over_bar_and_brakes", glider),
        plain("polar::a_polar_is_kept", kept),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const TAPERED: &str = "cases/tapered-wing.toml";

/// Columns of a CSV file by their names; empty fields are NaN.
fn columns(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names = reader.headers().unwrap().clone();
    let mut columns = BTreeMap::new();
    for line in reader.records() {
        for (name, field) in names.iter().zip(&line.unwrap()) {
            let value = field.parse().unwrap_or(f64::NAN);
            let column: &mut Vec<f64> = columns.entry(name.to_owned()).or_default();
            column.push(value);
        }
    }
    columns
}

/// The polar of a case, by columns.
fn polar(file: &str, more: &[&str]) -> BTreeMap<String, Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut arguments = vec!["polar", file, "--out", out.to_str().unwrap()];
    arguments.extend(more);
    let output = ripstop(&arguments);
    assert_eq!(output.code, 0, "{}", output.errors);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("</html>") && page.contains("<svg"),
        "no charts"
    );
    for name in [
        "span.csv",
        "lift.svg",
        "lift.png",
        "drag_polar.svg",
        "moment.svg",
        "glide.svg",
    ] {
        assert!(out.join(name).exists(), "{name}");
    }
    columns(&out.join("polar.csv"))
}

/// A shipped wing by itself: `check` describes it, `run` names the command, `polar` computes it.
pub fn bare_case(file: &str) {
    let checked = ripstop(&["check", file]);
    assert_eq!(checked.code, 0, "{}", checked.errors);
    assert!(checked.printed.contains("unknowns"), "{}", checked.printed);
    let run = ripstop(&["run", file]);
    assert_eq!(run.code, 2);
    assert!(run.errors.contains("ripstop polar"), "{}", run.errors);
    let found = polar(file, &["--angle", "-2,10,4"]);
    assert_eq!(found["angle_of_attack_deg"], [-2.0, 2.0, 6.0, 10.0]);
    assert!(found["lift_coefficient"].iter().all(|c| c.is_finite()));
}

/// Wing 2.5-8-44,16 of NACA TN 1270 with the measured polars of its sections: slope, highest lift and its angle, and least drag as in the tunnel.
fn a_measured_wing_stalls() {
    let found = polar(TAPERED, &["--angle", "-4,24,1"]);
    let (angles, lifts) = (&found["angle_of_attack_deg"], &found["lift_coefficient"]);
    assert!(found["section_residual"].iter().all(|r| *r < 1e-6));
    let at = |angle: f64| lifts[angles.iter().position(|a| *a == angle).unwrap()];
    let near = |value: f64, measured: f64, band: f64, what: &str| {
        assert!(
            (value / measured - 1.0).abs() < band,
            "{what}: {value}, measured {measured}"
        );
    };
    // Digitised from the report: 0.0819 per degree, 1.538 at 19.3 degrees, 0.0088.
    near((at(8.0) - at(-2.0)) / 10.0, 0.0819, 0.1, "slope");
    let highest = lifts.iter().copied().fold(0.0, f64::max);
    near(highest, 1.538, 0.1, "highest lift");
    let angle = angles[lifts.iter().position(|l| *l == highest).unwrap()];
    near(angle, 19.3, 0.1, "its angle");
    let least = found["drag_coefficient"]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    near(least, 0.0088, 0.2, "least drag");
    // Beyond it the wing has less lift, most of it stalled.
    assert!(at(24.0) < highest - 0.05);
    assert!(found["stalled_area_share"].last().unwrap() > &0.5);
    // Measured about the quarter chord: −0.09 to −0.05.
    let moment = found["pitching_moment_coefficient"][4];
    assert!((-0.12..-0.06).contains(&moment), "{moment}");
}

/// The same angles alone, from above, and in another step: the same coefficients.
fn a_sweep_has_no_memory() {
    let all = polar(TAPERED, &["--angle", "-4,23,1"]);
    for angle in ["19,19,1", "22,23,1", "-4,20,8"] {
        let some = polar(TAPERED, &["--angle", angle]);
        for (angle, lift) in some["angle_of_attack_deg"]
            .iter()
            .zip(&some["lift_coefficient"])
        {
            let places = &all["angle_of_attack_deg"];
            let known = all["lift_coefficient"][places.iter().position(|a| a == angle).unwrap()];
            assert!((lift - known).abs() < 1e-6, "{angle}: {lift} {known}");
        }
    }
}

const SWEPT: &str = r#"
version = 1
[aero.wing]
speed_m_s = 12.0
angles_deg = [4.0, 4.0, 1.0]
sideslip_deg = 5.0
strips = 8
panels_per_side = 10
stations = [
  { position_m = [0.0, 0.0, 0.0], chord_m = 2.0, profile = "p" },
  { position_m = [1.0, 4.0, 0.5], chord_m = 1.2, profile = "p" },
]
[aero.wing.profiles.p]
naca = "2415"
polar = [[-10.0, -0.9, 0.02], [0.0, 0.25, 0.008], [10.0, 1.25, 0.015]]
"#;

fn with(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wing.toml");
    std::fs::write(&path, text).unwrap();
    let name = path.to_str().unwrap().to_owned();
    (folder, name)
}

/// The method knows air of one density; it says so of a wing that flies at half the speed of sound.
fn squeezed() {
    for (speed, told) in [("12.0", false), ("170.0", true)] {
        let (folder, path) =
            with(&SWEPT.replace("speed_m_s = 12.0", &format!("speed_m_s = {speed}")));
        let out = folder.path().join("out");
        let output = ripstop(&["polar", &path, "--out", out.to_str().unwrap()]);
        assert_eq!(output.code, 0, "{}", output.errors);
        let noted = output.printed.contains("0.50 times the speed of sound");
        assert_eq!(noted, told, "{}", output.printed);
    }
}

/// Air from the right on a swept wing with dihedral lifts the right half more. Straight air rolls, turns and pushes it nowhere.
fn sideslip() {
    let (_folder, path) = with(SWEPT);
    let turned = polar(&path, &[]);
    // Positive lifts the left tip.
    assert!(turned["rolling_moment_coefficient"][0] < -1e-3);
    let straight = polar(&path, &["--set", "aero.wing.sideslip_deg=0"]);
    for name in [
        "rolling_moment_coefficient",
        "yawing_moment_coefficient",
        "side_force_coefficient",
    ] {
        assert!(straight[name][0].abs() < 1e-9, "{name}");
    }
    let (a, b) = (
        turned["lift_coefficient"][0],
        straight["lift_coefficient"][0],
    );
    assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
    // About points one chord apart in height moments differ by the force along the chord, with the drag of the sections, two fifths of all.
    let at = |height_m: f64| {
        let point = format!("aero.wing.moment_point_m=[0.5, 0.0, {height_m:?}]");
        let chord = "aero.wing.reference_chord_m=1.0";
        polar(
            &path,
            &[
                "--set",
                "aero.wing.sideslip_deg=0",
                "--set",
                &point,
                "--set",
                chord,
            ],
        )
    };
    let (low, high) = (at(-1.0), at(0.0));
    let [lift, drag] = ["lift_coefficient", "drag_coefficient"].map(|name| low[name][0]);
    let (sine, cosine) = 4f64.to_radians().sin_cos();
    let along = drag * cosine - lift * sine;
    let moment = "pitching_moment_coefficient";
    let difference = low[moment][0] - high[moment][0];
    assert!(
        (difference - along).abs() < 0.1 * drag,
        "{difference} {along} {drag}"
    );
}

/// A tapered wing as triangles, cut into sections, has the forces of the same wing by its stations, polars computed in both.
fn mesh() {
    const STRIPS: usize = 20;
    let profile = ripstop::geometry::profile::Profile::naca("2415").unwrap();
    let points = profile.resampled(50);
    let row = points.len() - 1;
    let (mut text, mut triangles) = (String::new(), String::new());
    for strip in 0..=2 * STRIPS {
        let share = strip as f64 / STRIPS as f64 - 1.0;
        let chord = 1.0 - 0.4 * share.abs();
        for p in &points[..row] {
            let x = (p.x - 0.25) * chord;
            text += &format!("v {x} {} {}\n", 3.0 * share, p.y * chord);
        }
    }
    for strip in 0..2 * STRIPS {
        for k in 0..row {
            let at = |strip: usize, k: usize| strip * row + k % row + 1;
            let [a, b, c, d] = [
                at(strip, k),
                at(strip, k + 1),
                at(strip + 1, k + 1),
                at(strip + 1, k),
            ];
            triangles += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    let head =
        "version = 1\n[aero.wing]\nspeed_m_s = 20.0\nangles_deg = [0.0, 6.0, 6.0]\nstrips = 8\n";
    let by_mesh =
        format!("{head}[aero.wing.mesh]\nfile = \"wing.obj\"\nscale = 1.0\nsections = 4\n");
    let (folder, path) = with(&by_mesh);
    std::fs::write(folder.path().join("wing.obj"), text + &triangles).unwrap();
    let cut = polar(&path, &[]);
    let stations = "stations = [\n  { position_m = [0.0, 0.0, 0.0], chord_m = 1.0, profile = \"p\" },\n  { position_m = [0.0, 3.0, 0.0], chord_m = 0.6, profile = \"p\" },\n]\n[aero.wing.profiles.p]\nnaca = \"2415\"\n";
    let (_folder, path) = with(&format!("{head}{stations}"));
    let drawn = polar(&path, &[]);
    // Layers on the polygons of the mesh turn turbulent elsewhere: drag differs more.
    for (name, band) in [
        ("lift_coefficient", 0.02),
        ("drag_coefficient", 0.06),
        ("pitching_moment_coefficient", 0.05),
    ] {
        for (a, b) in cut[name].iter().zip(&drawn[name]) {
            assert!((a / b - 1.0).abs() < band, "{name}: {a} {b}");
        }
    }
    // A mesh without a wing is told.
    std::fs::write(
        folder.path().join("wing.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    let path = folder.path().join("wing.toml");
    let output = ripstop(&["check", path.to_str().unwrap()]);
    assert_eq!(output.code, 2);
    assert!(output.errors.contains("wing.obj"), "{}", output.errors);
}

fn refused() {
    let told = |text: &str, arguments: &[&str], what: &str| {
        let (_folder, path) = with(text);
        let mut all = vec!["polar", &path, "--out", "/nonexistent-is-not-reached"];
        all.extend(arguments);
        let output = ripstop(&all);
        assert_eq!(output.code, 2, "{what}: {}", output.errors);
        let flat = output.errors.replace(['\n', '│'], " ");
        let flat: Vec<&str> = flat.split_whitespace().collect();
        assert!(flat.join(" ").contains(what), "{what}: {}", output.errors);
    };
    told(&SWEPT.replace("\"2415\"", "\"24152\""), &[], "24152");
    told(SWEPT, &["--angle", "4,2,1"], "is no sweep");
    told(SWEPT, &["--angle", "5"], "is not FROM,TO,STEP");
    told(SWEPT, &["--brake", "0.1"], "a wing by itself");
    told(SWEPT, &["--engine", "gpu"], "--engine gpu has no use");
    told(
        SWEPT,
        &["--precision", "f16-storage"],
        "--precision f16-storage has no use",
    );
    told(
        &SWEPT.replace("profile = \"p\" }", "profile = \"q\" }"),
        &[],
        "names the profile `q`",
    );
    told(
        &format!("{SWEPT}[time]\nend_s = 1.0\n"),
        &[],
        "nothing would read [time]",
    );
    told(
        &SWEPT.replace("polar = [[", "polar = [[20.0, 1.0, 0.1], ["),
        &[],
        "ascend",
    );
    let output = ripstop(&["polar", "cases/cloth/hanging-sheet.toml"]);
    assert_eq!(output.code, 2);
    assert!(
        output.errors.contains("there is no polar"),
        "{}",
        output.errors
    );
}

/// `check` counts as many panels as the polar has: a wing from tip to tip has two caps.
fn caps() {
    let whole = SWEPT
        .replace("sideslip_deg = 5.0", "symmetric = false")
        .replace(
            "[0.0, 0.0, 0.0], chord_m = 2.0",
            "[0.0, -4.0, 0.0], chord_m = 2.0",
        );
    for (text, panels) in [(SWEPT.to_owned(), 340), (whole, 180)] {
        let (folder, path) = with(&text);
        let checked = ripstop(&["check", &path]);
        let told = format!("{panels} unknowns");
        assert!(checked.printed.contains(&told), "{}", checked.printed);
        let out = folder.path().join("out");
        let computed = ripstop(&["polar", &path, "--out", out.to_str().unwrap()]);
        let told = format!("{panels} panels");
        assert!(computed.printed.contains(&told), "{}", computed.printed);
    }
}

/// Polars that are given do not know a turned trailing edge: `check` says so, and brakes are not swept over.
fn given_polars() {
    const CASE: &str = "cases/wing-school.toml";
    const POLARS: &str =
        "equilibrium.trim.polars={middle=[[-10.0,-0.9,0.02],[0.0,0.25,0.008],[10.0,1.25,0.015]]}";
    const SAID: &str = "of the section as drawn: brakes count as a larger angle of attack";
    let check =
        |more: &[&str]| ripstop(&[&["check", CASE, "--variant", "quick"][..], more].concat());
    let plain = check(&[]);
    assert_eq!(plain.code, 0, "{}", plain.errors);
    assert!(!plain.printed.contains(SAID), "{}", plain.printed);
    let given = check(&["--set", POLARS]);
    assert_eq!(given.code, 0, "{}", given.errors);
    assert!(given.printed.contains(SAID), "{}", given.printed);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let brakes = ["--vary", "structure.wing.brake_pull_m=0,0.2"];
    for (command, asked) in [("polar", ["--brake", "0,0.2"]), ("sweep", brakes)] {
        let arguments = [
            command,
            CASE,
            "--set",
            POLARS,
            "--out",
            out.to_str().unwrap(),
        ];
        let output = ripstop(&[&arguments[..], &asked[..]].concat());
        assert_eq!(output.code, 2, "{command}: {}", output.errors);
        let said = output.errors.contains("equilibrium.trim.polars");
        assert!(said, "{command}: {}", output.errors);
        assert!(!out.exists(), "{command} left a folder");
    }
}

/// A folder with a polar is taken again only where that is asked for; `check --expand` prints the case itself.
fn kept() {
    let (folder, path) = with(SWEPT);
    let out = folder.path().join("out");
    let polar = |more: &[&str]| {
        let mut all = vec!["polar", &path, "--out", out.to_str().unwrap()];
        all.extend(more);
        ripstop(&all)
    };
    assert_eq!(polar(&["--angle", "0,2,2"]).code, 0);
    let first = std::fs::read(out.join("polar.csv")).unwrap();
    let again = polar(&["--angle", "4,6,1"]);
    assert_eq!(again.code, 73);
    assert!(again.errors.contains("--overwrite"), "{}", again.errors);
    assert_eq!(std::fs::read(out.join("polar.csv")).unwrap(), first);
    assert_eq!(polar(&["--angle", "4,6,1", "--overwrite"]).code, 0);
    assert_eq!(columns(&out.join("polar.csv"))["lift_n"].len(), 3);
    let expanded = ripstop(&["check", &path, "--expand"]);
    let [printed, given] =
        [expanded.printed.as_str(), SWEPT].map(|text| toml::from_str::<toml::Table>(text).unwrap());
    assert_eq!(printed, given);
}

/// The bar makes a glider faster, brakes make it slower, more weight makes it faster at the same glide.
fn glider() {
    let folder = tempfile::tempdir().unwrap();
    let table = |name: &str, arguments: &[&str]| {
        let out = folder.path().join(name);
        let mut all = vec![
            "polar",
            "cases/wing-school.toml",
            "--variant",
            "quick",
            "--out",
            out.to_str().unwrap(),
        ];
        all.extend(arguments);
        let output = ripstop(&all);
        assert_eq!(output.code, 0, "{}", output.errors);
        assert!(out.join("sweep_sink_m_s_over_speed_m_s.svg").exists());
        columns(&out.join("sweep.csv"))
    };
    let bar = table("bar", &["--bar", "0,1"]);
    assert!(
        bar["speed_m_s"][1] > 1.05 * bar["speed_m_s"][0],
        "{:?}",
        bar["speed_m_s"]
    );
    assert!(bar["angle_of_attack_deg"][1] < bar["angle_of_attack_deg"][0] - 1.0);
    // Beside the glide without bar, brakes or ballast.
    let plain = bar["speed_m_s"][0];
    let brake = table("brake", &["--brake", "0.2"]);
    assert_eq!(brake["structure.wing.brake_pull_m"][0].to_string(), "0.2");
    assert!(
        brake["speed_m_s"][0] < 0.95 * plain,
        "{:?}",
        brake["speed_m_s"]
    );
    // Both add up: the bar's speed, and a wing that the brakes turn down further, with their load.
    let both = table("both", &["--bar", "0.4", "--brake", "0.1"]);
    let of = |name: &str| (both[name][0], bar[name][0]);
    assert_eq!(both["structure.wing.speed_bar.used"][0].to_string(), "0.4");
    let (speed, alone) = of("speed_m_s");
    assert!(speed > 1.03 * alone, "{speed} {alone}");
    let (angle, alone) = of("angle_of_attack_deg");
    assert!(angle < alone - 1.0, "{angle} {alone}");
    let (load, alone) = of("row_brake_load_n");
    assert!(load > 3.0 * alone, "{load} {alone}");
    let mass = table("mass", &["--mass", "100"]);
    assert!(
        mass["speed_m_s"][0] > 1.03 * plain,
        "{:?}",
        mass["speed_m_s"]
    );
}
