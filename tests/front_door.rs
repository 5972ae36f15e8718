//! What a newcomer meets: lists, explanations, slips that are understood, the answer first, and pages to mail.

use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::Trial;

use crate::command_line::{ripstop, root};
use crate::engines::plain;
use crate::folders::{json, sheet};

pub fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = [
        plain("front_door::cases_are_listed", cases_are_listed),
        plain("front_door::words_are_explained", words_are_explained),
        plain("front_door::slips_are_understood", slips),
        plain("front_door::several_slips_are_told_at_once", several_slips),
        plain("front_door::the_answer_is_short", the_answer),
        plain("front_door::runs_side_by_side", side_by_side),
        plain("front_door::pages_for_packages", pages),
    ]
    .into_iter()
    .flatten()
    .collect();
    trials.push(browser_trial());
    trials
}

fn cases_are_listed() {
    let listed = ripstop(&["new"]);
    assert_eq!(listed.code, 0);
    for (name, _) in ripstop::case::SHIPPED {
        let line = listed
            .printed
            .lines()
            .find(|line| line.split_whitespace().next() == Some(name));
        let line = line.unwrap_or_else(|| panic!("{name} is not listed"));
        assert!(line.split_whitespace().count() > 2, "{line}");
    }
    let [designs, others] =
        ["by their design", "with all tables"].map(|title| listed.printed.find(title).unwrap());
    let cruciform = listed.printed.find("  cruciform ").unwrap();
    assert!(designs < cruciform && cruciform < others);
}

fn words_are_explained() {
    for (word, told) in [
        (
            "resolution.operator",
            &["key resolution.operator", "stabilised_regularised"][..],
        ),
        ("[canopy]", &["key canopy", "design"]),
        (
            "vent_percent",
            &["key canopy.vent_percent", "may be left out", "%"],
        ),
        (
            "mass_kg",
            &["key payload.mass_kg", "key payload.bodies.NAME.mass_kg"],
        ),
        (
            "drag_coefficient",
            &["column of history.csv drag_coefficient", "result"],
        ),
        ("descent_rate_m_s", &["result descent_rate_m_s [m/s]"]),
        ("row_a_load_n", &["result row_{row}_load_n [N]"]),
        (
            "separated_lift_coefficient",
            &["column of polar.csv separated_lift_coefficient [1]"],
        ),
        ("ball_lift_coefficient", &["{body}lift_coefficient"]),
    ] {
        let found = ripstop(&["explain", word]);
        assert_eq!(found.code, 0, "{word}: {}", found.errors);
        for part in told {
            assert!(found.printed.contains(part), "{word}: {}", found.printed);
        }
        assert!(!found.printed.contains("]("), "{word}: {}", found.printed);
    }
    let separated = ripstop(&["explain", "separated_lift_coefficient"]);
    assert!(
        !separated.printed.contains("{body}"),
        "{}",
        separated.printed
    );
    let unknown = ripstop(&["explain", "drag_coeficient"]);
    assert_eq!(unknown.code, 2);
    assert!(
        unknown.errors.contains("did you mean `drag_coefficient`?"),
        "{}",
        unknown.errors
    );
    let case = "cases/designs/personnel-descent.toml";
    let listed = ripstop(&["results", case]);
    assert_eq!(listed.code, 0, "{}", listed.errors);
    let loaded =
        ripstop::case::load(&root().join(case), &ripstop::case::Choices::default()).unwrap();
    for name in ripstop::measure::result_names(&loaded.scene) {
        let line = listed
            .printed
            .lines()
            .find(|line| line.split_whitespace().next() == Some(&name));
        assert!(
            line.is_some_and(|line| line.split_whitespace().count() > 3),
            "{name}: {line:?}"
        );
    }
    let first = listed.printed.lines().nth(1).unwrap();
    assert!(first.contains("descent_rate_m_s"), "{first}");
}

/// Messages are broken into lines.
fn one_line(errors: &str) -> String {
    let words = errors.replace('│', " ");
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn slips() {
    let sphere = "cases/sphere.toml";
    for (arguments, told) in [
        (
            &["check", sphere, "--set", "air.wind_tunnel.sped_m_s=3.0"][..],
            "did you mean `speed_m_s`?",
        ),
        (
            &[
                "check",
                sphere,
                "--set",
                "resolution.operator=stabilized_regularised",
            ],
            "did you mean `stabilised_regularised`?",
        ),
        (
            &["check", sphere, "--set", "structre.sheet.divisions=[1, 1]"],
            "did you mean `structure`?",
        ),
        (
            &[
                "check",
                "cases/designs/cruciform.toml",
                "--set",
                "canopy.lines=nilon cord 550 lbf",
            ],
            "did you mean `nylon cord 550 lbf`?",
        ),
        (
            &["check", "cases/flag.toml", "--variant", "quik"],
            "did you mean `quick`?",
        ),
        (
            &[
                "check",
                "cases/designs/cruciform.toml",
                "--set",
                "coupling.shceme=absent",
            ],
            "coupling.shceme is to be absent, but there is no such key",
        ),
        (&["new", "wing-27", "--cells", "5"], "cannot be used with"),
        (
            &[
                "check",
                "cases/wing-school.toml",
                "--set",
                "structure.wing.profiles.middle.naca=99",
            ],
            "`99`",
        ),
        (
            &["polar", "cases/wing-school.toml", "--brake", "-0.1"],
            "brake",
        ),
        (
            &[
                "check",
                sphere,
                "--set",
                "comparison.drag_coeficient.value=1.0",
                "--set",
                "comparison.drag_coeficient.source=x",
            ],
            "drag_coefficient`?",
        ),
        (
            &["new", "flat-circular-tunel"],
            "did you mean `flat-circular-tunnel`?",
        ),
    ] {
        let refused = ripstop(arguments);
        assert_eq!(refused.code, 2, "{arguments:?}");
        let errors = one_line(&refused.errors);
        assert!(errors.contains(told), "{arguments:?}: {errors}");
    }
}

/// All slips in a file are told at once, each with its line.
fn several_slips() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.toml");
    let text = std::fs::read_to_string(root().join("cases/sphere.toml")).unwrap();
    let text = text
        .replacen("speed_m_s", "sped_m_s", 1)
        .replacen("end_s", "ends_s", 1)
        + "\n[soup]\nhot = true\n";
    std::fs::write(&path, text).unwrap();
    let refused = ripstop(&["check", path.to_str().unwrap()]);
    assert_eq!(refused.code, 2);
    for slip in ["sped_m_s", "ends_s", "soup"] {
        assert!(refused.errors.contains(slip), "{slip}: {}", refused.errors);
    }
    // Values that cannot be are told together, too, of a design as of what is written; what may only follow from them is not.
    for (case, wrong) in [
        (
            "cases/flag.toml",
            &[
                "fabric.thickness_m=-1e-4",
                "fabric.poisson_ratio=0.7",
                "time.end_s=-2.0",
            ][..],
        ),
        (
            "cases/designs/cruciform.toml",
            &["canopy.diameter_m=-6.0", "canopy.line_length_ratio=99.0"],
        ),
    ] {
        let changes = wrong.iter().flat_map(|change| ["--set", change]);
        let all: Vec<&str> = ["check", case].into_iter().chain(changes).collect();
        let refused = ripstop(&all);
        assert_eq!(refused.code, 2);
        let told = one_line(&refused.errors);
        let more = format!("and {} more", wrong.len() - 1);
        let keys = wrong.iter().map(|change| change.split('=').next().unwrap());
        for key in keys.chain([&more[..]]) {
            assert!(told.contains(key), "{key}: {told}");
        }
    }
}

/// A run of a sheet prints eight results at most, one line of trust and where the rest is; `--all` prints the rest.
fn the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let short = sheet(&out, &[]);
    assert_eq!(short.code, 0, "{}", short.errors);
    let results = json(&out.join("summary.json"))["results"].clone();
    let all: Vec<&String> = results.as_object().unwrap().keys().collect();
    let shown = |text: &str| {
        let lines = text
            .lines()
            .map(|line| line.split_whitespace().next().unwrap_or_default());
        let names: Vec<String> = lines
            .filter(|word| all.iter().any(|name| name == word))
            .map(str::to_owned)
            .collect();
        names
    };
    let first = shown(&short.printed);
    assert!((1..=8).contains(&first.len()), "{}", short.printed);
    assert!(short.printed.contains("\ntrust: "), "{}", short.printed);
    // A cable that hangs has an exact solution beside it.
    let chain = ripstop(&[
        "run",
        "cases/cloth/hanging-chain.toml",
        "--out",
        folder.path().join("chain").to_str().unwrap(),
    ]);
    assert!(
        chain.printed.contains("; reference ") && chain.printed.contains(", error "),
        "{}",
        chain.printed
    );
    assert!(short.printed.lines().count() < 20, "{}", short.printed);
    let long = sheet(&out, &["--all", "--overwrite"]);
    assert!(
        all.iter().all(|name| shown(&long.printed).contains(name)),
        "{}",
        long.printed
    );
    // What was run lies beside the results, and runs.
    let again = ripstop(&["check", out.join("case_as_run.toml").to_str().unwrap()]);
    assert_eq!(again.code, 0, "{}", again.errors);
}

/// Two lengths of a run: the table tells values and differences, and the page holds both.
fn side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
    assert_eq!(sheet(&one, &[]).code, 0);
    assert_eq!(
        sheet(&other, &["--set", "fabric.density_kg_m3=2000.0"]).code,
        0
    );
    let page = folder.path().join("page.html");
    let compared = ripstop(&[
        "compare",
        one.to_str().unwrap(),
        other.to_str().unwrap(),
        "--out",
        page.to_str().unwrap(),
    ]);
    assert_eq!(compared.code, 0, "{}", compared.errors);
    let header = compared.printed.lines().next().unwrap();
    assert!(
        header.contains("one") && header.contains("other"),
        "{header}"
    );
    assert!(compared.printed.contains(" %"), "{}", compared.printed);
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("one beside other") && text.contains("data:image/png;base64,"));
    // Folders of the same name are told by their paths.
    let page = page.to_str().unwrap();
    let same = ripstop(&[
        "compare",
        one.to_str().unwrap(),
        one.to_str().unwrap(),
        "--out",
        page,
    ]);
    assert!(
        same.printed.contains(one.to_str().unwrap()),
        "{}",
        same.printed
    );
    let nothing = ripstop(&[
        "compare",
        one.to_str().unwrap(),
        folder.path().to_str().unwrap(),
    ]);
    assert_eq!(nothing.code, 2);
    assert!(
        nothing.errors.contains("holds no finished run"),
        "{}",
        nothing.errors
    );
    // The page of a run is made anew from its folder, and needs nothing beside it.
    let report = one.join("report.html");
    std::fs::remove_file(&report).unwrap();
    assert_eq!(ripstop(&["report", one.to_str().unwrap()]).code, 0);
    let text = std::fs::read_to_string(&report).unwrap();
    for outside in ["src=\"http", "href=", "url(", "<script"] {
        assert!(!text.contains(outside), "{outside}");
    }
}

fn pages() {
    for shell in ["bash", "zsh", "fish"] {
        let completions = ripstop(&["completions", shell]);
        assert_eq!(completions.code, 0, "{}", completions.errors);
        assert!(
            completions.printed.contains("personnel") || completions.printed.contains("overwrite")
        );
    }
    let manual = ripstop(&["man"]);
    assert!(
        manual.printed.starts_with(".ie") || manual.printed.contains(".TH"),
        "{}",
        &manual.printed[..200]
    );
    assert!(manual.printed.contains("ripstop\\-run") || manual.printed.contains("ripstop-run"));
}

/// A browser on the path, or that RIPSTOP_BROWSER names.
fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("RIPSTOP_BROWSER") {
        return Some(named.into());
    }
    let folders = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&folders)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|path| path.exists())
}

fn browser_trial() -> Trial {
    let name = "front_door::a_browser_shows_the_report";
    match browser() {
        Some(browser) => Trial::test(name, move || {
            shown(&browser);
            Ok(())
        }),
        None => Trial::test(name, || Ok(()))
            .with_ignored_flag(true)
            .with_kind("no browser"),
    }
}

/// The report of a canopy in a real browser: all pictures and charts are there, nothing is asked of the network, and the page is not blank.
fn shown(browser: &Path) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = ripstop(&[
        "run",
        "cases/flat-circular-tunnel.toml",
        "--variant",
        "quick",
        "--set",
        "time.end_s=0.02",
        "--set",
        "output.history_plots=true",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(run.code, 0, "{}", run.errors);
    let report = out.join("report.html");
    let address = format!("file://{}", report.display());
    let ask = |arguments: &[&str]| {
        let home = folder.path().join("home");
        let output = Command::new(browser)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--hide-scrollbars",
            ])
            .arg(format!("--user-data-dir={}", home.display()))
            .args(arguments)
            .arg(&address)
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let page = ask(&["--dump-dom"]);
    let count = |what: &str| page.matches(what).count();
    let pictures = json(&out.join("run.json"))["files"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|file| file["name"].as_str().unwrap().starts_with("snapshot_"))
        .count();
    assert_eq!(count("<img "), pictures);
    assert!(count("<svg") >= 3, "{} charts", count("<svg"));
    assert!(
        page.contains("Beside the values of others") && page.contains("What the set-up supports")
    );
    let shot = folder.path().join("shot.png");
    ask(&[
        "--window-size=1200,2400",
        &format!("--screenshot={}", shot.display()),
    ]);
    if let Some(kept) = std::env::var_os("RIPSTOP_KEEP_SHOT") {
        std::fs::copy(&shot, kept).unwrap();
    }
    let image = image::open(&shot).unwrap().to_rgb8();
    assert_eq!(image.dimensions(), (1200, 2400));
    let coloured = image.pixels().filter(|pixel| pixel.0 != [255; 3]).count();
    let share = coloured as f64 / (1200.0 * 2400.0);
    // The pictures of this run alone, two beside each other, fill more than a tenth of the shot.
    assert!(share > 0.1, "{share} of the page is not white");
}
