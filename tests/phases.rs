//! Phases of a run: what `check` prints of them, and that interrupted ones go on where they were.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;

use libtest_mimic::Trial;

use crate::command_line::{command, files, name_in, ripstop};
use crate::engines::plain;
use crate::interrupts::send;

pub fn trials() -> Vec<Trial> {
    let mut trials = vec![plain("phases::check_prints_them", printed)];
    // Signals are sent by a shell's `kill`.
    if cfg!(unix) {
        trials.push(plain("phases::a_trim_goes_on_from_its_mesh", meshes));
        trials.push(plain("phases::shaping_and_load_test_go_on", shaping));
    }
    trials.into_iter().flatten().collect()
}

const WING: &str = "cases/wing-school.toml";

/// Two meshes, of 2134 and 6366 nodes.
const TWO_MESHES: [&str; 2] = [
    "structure.wing.mesh.along_chord=20",
    "structure.wing.mesh.across_cell=4",
];

fn phases(arguments: &[&str]) -> Vec<String> {
    let all: Vec<&str> = ["check"].iter().chain(arguments).copied().collect();
    let checked = ripstop(&all);
    assert_eq!(checked.code, 0, "{}", checked.errors);
    let block = checked.printed.split("phases of the run\n").nth(1).unwrap();
    let lines = block.lines().take_while(|line| !line.is_empty());
    lines.map(str::to_owned).collect()
}

fn names(lines: &[String]) -> Vec<&str> {
    lines
        .iter()
        .map(|line| line.split_whitespace().next().unwrap())
        .collect()
}

/// In the order in which a run goes through them.
fn printed() {
    let wing = phases(&["cases/wing-27.toml"]);
    assert_eq!(names(&wing), ["trim"], "{wing:?}");
    assert!(wing[0].contains("then as many on"), "{wing:?}");

    let asked = ["load-test", "panel-shaping"];
    for variant in asked {
        let lines = phases(&[WING, "--variant", variant]);
        let name = variant.replace('-', "_");
        assert_eq!(names(&lines), ["trim", &name], "{lines:?}");
    }
    let folded = phases(&[
        "cases/flat-circular-tunnel.toml",
        "--engine",
        "cpu",
        "--set",
        "steady.grid_sequence=[2.0]",
    ]);
    assert_eq!(
        names(&folded),
        [
            "open_canopy",
            "raise_wind",
            "march",
            "change_lattice",
            "march"
        ],
        "{folded:?}"
    );
    assert!(folded[2].contains("until the wake has settled"));
    assert!(folded[4].contains("until the means are steady"));
    let cloth = phases(&["cases/cloth/hanging-sheet.toml"]);
    assert!(
        cloth.iter().all(|line| !line.contains("wind")),
        "no air, no wind: {cloth:?}"
    );
}

fn arguments<'a>(out: &'a str, changes: &[&'a str]) -> Vec<&'a str> {
    let mut all = vec!["run", WING, "--variant", "quick", "--out", out];
    for change in changes {
        all.extend(["--set", change]);
    }
    all
}

/// Runs until a line of standard error begins with `until`, and ends the run there.
fn interrupted(arguments: &[&str], until: &str) {
    let mut child = command(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = BufReader::new(child.stderr.take().unwrap()).lines();
    let mut seen = Vec::new();
    loop {
        match told.next() {
            Some(Ok(line)) if line.starts_with(until) => break,
            Some(Ok(line)) => seen.push(line),
            _ => panic!("no line begins with `{until}`: {seen:#?}"),
        }
    }
    send(&child, &["TERM"]);
    told.for_each(drop);
    assert_eq!(child.wait().unwrap().code(), Some(75), "{until}");
}

/// A run that is interrupted wherever a line of `stops` has been told leaves what an uninterrupted one leaves, byte for byte.
fn go_on(changes: &[&str], stops: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let of = |out: &'_ Path| out.to_str().unwrap().to_owned();
    let (whole, parts) = (of(&whole), of(&parts));
    let expected = ripstop(&arguments(&whole, changes));
    assert!([0, 20].contains(&expected.code), "{}", expected.errors);
    for (number, until) in stops.iter().enumerate() {
        let mut all = arguments(&parts, changes);
        if number > 0 {
            all.push("--resume");
        }
        interrupted(&all, until);
    }
    let mut all = arguments(&parts, changes);
    all.push("--resume");
    let resumed = ripstop(&all);
    assert_eq!(resumed.code, expected.code, "{}", resumed.errors);
    // It did not begin again: what was told before the last stop is not told after it.
    let first = stops[0];
    assert!(
        !resumed.errors.lines().any(|line| line.starts_with(first)),
        "{}",
        resumed.errors
    );
    same(Path::new(&whole), Path::new(&parts));
}

/// All files that tell neither of time nor of the interruption.
fn same(whole: &Path, parts: &Path) {
    let of = |folder: &Path| {
        let names = files(folder).into_iter().map(|p| name_in(folder, &p));
        names.collect::<Vec<_>>()
    };
    let (mut names, mut others) = (of(whole), of(parts));
    names.sort();
    others.sort();
    assert_eq!(names, others);
    let tells_time = |name: &&String| {
        [
            "summary.json",
            "run.json",
            "run.log",
            "report.html",
            "trim_iterations.csv",
        ]
        .contains(&name.as_str())
    };
    for name in names.iter().filter(|name| !tells_time(name)) {
        let [a, b] = [whole, parts].map(|folder| std::fs::read(folder.join(name)).unwrap());
        if name.ends_with(".svg") {
            // The chart library numbers its clipping paths through the whole process.
            let [a, b] = [a, b].map(|bytes| without_clip_numbers(&bytes));
            assert!(a == b, "{name} differs");
        } else {
            assert!(a == b, "{name} differs");
        }
    }
    let results = |folder: &Path| {
        let text = std::fs::read_to_string(folder.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        [&summary["results"], &summary["account"]].map(Clone::clone)
    };
    assert_eq!(results(whole), results(parts));
}

fn without_clip_numbers(svg: &[u8]) -> String {
    let text = String::from_utf8_lossy(svg);
    let mut parts = text.split("kuva-clip-");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept.push_str(part.trim_start_matches(|c: char| c.is_ascii_digit()));
    }
    kept
}

/// Within the coarser mesh, and within the wing's own.
fn meshes() {
    go_on(&TWO_MESHES, &["trim  2, 2134 nodes", "trim  1, 6366 nodes"]);
}

/// Within a trim of panels that were cut anew, and between two loads.
fn shaping() {
    go_on(
        &[
            "equilibrium.panel_shaping={ aim = \"ballooning\", tolerance = 1e-4, iteration_limit = 1, target = { upper = [[0.0, 0.06], [0.5, 0.08], [1.0, 0.0]], lower = [[0.0, 0.06], [0.5, 0.07], [1.0, 0.0]] } }",
            "equilibrium.load_test={ load_factors = [1.5, 2.0] }",
        ],
        &["panels 0", "load factor  1.50"],
    );
}
