//! Rules between the rooms of the house, checked on the source text (see the crate's documentation).

use std::path::{Path, PathBuf};

use libtest_mimic::Trial;

use crate::command_line::root;
use crate::engines::plain;
use crate::module_graph::FileGraph;

pub fn trials() -> Vec<Trial> {
    [
        plain("architecture::imports_follow_the_arrows", imports),
        plain("architecture::files_fit_a_room", file_sizes),
        plain("architecture::rooms_make_no_circle", no_circle),
        plain("architecture::files_make_no_circle", no_circle_of_files),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Rooms of the library that each room may use, besides itself.
const ALLOWED: [(&str, &[&str]); 31] = [
    ("lattice", &[]),
    ("solve", &[]),
    ("lines", &[]),
    ("immersed", &[]),
    ("frame.rs", &[]),
    ("aero", &["geometry"]),
    ("trim", &["aero", "cloth", "geometry"]),
    ("units.rs", &[]),
    ("fabric", &["frame"]),
    ("rigid", &["immersed"]),
    ("output", &["frame"]),
    ("render", &["frame"]),
    ("checkpoint", &["output"]),
    ("ledger", &["output"]),
    ("cloth", &["fabric", "frame", "immersed", "lines"]),
    (
        "geometry",
        &["cloth", "fabric", "frame", "immersed", "lines", "rigid"],
    ),
    (
        "cpu",
        &[
            "checkpoint",
            "cloth",
            "fabric",
            "frame",
            "immersed",
            "lattice",
            "lines",
            "solve",
        ],
    ),
    (
        "gpu",
        &[
            "checkpoint",
            "cloth",
            "cpu",
            "fabric",
            "frame",
            "immersed",
            "lattice",
            "lines",
            "render",
            "solve",
        ],
    ),
    (
        "case",
        &[
            "aero", "cloth", "fabric", "frame", "geometry", "immersed", "lattice", "lines",
            "rigid", "trim", "units",
        ],
    ),
    (
        "plan",
        &[
            "aero", "case", "cloth", "fabric", "immersed", "lattice", "solve", "trim",
        ],
    ),
    (
        "simulation",
        &[
            "case",
            "checkpoint",
            "cloth",
            "cpu",
            "fabric",
            "frame",
            "geometry",
            "gpu",
            "immersed",
            "lattice",
            "plan",
            "rigid",
            "solve",
            "trim",
            "units",
        ],
    ),
    (
        "statics",
        &[
            "case",
            "checkpoint",
            "cloth",
            "geometry",
            "gpu",
            "simulation",
            "solve",
            "trim",
        ],
    ),
    (
        "measure",
        &[
            "case",
            "checkpoint",
            "cloth",
            "cpu",
            "frame",
            "geometry",
            "gpu",
            "output",
            "rigid",
            "simulation",
            "statics",
            "trim",
        ],
    ),
    (
        "validity",
        &[
            "case", "cloth", "frame", "geometry", "measure", "output", "plan",
        ],
    ),
    ("sweep", &["measure", "output"]),
    (
        "run",
        &[
            "case",
            "checkpoint",
            "frame",
            "geometry",
            "gpu",
            "ledger",
            "measure",
            "output",
            "plan",
            "render",
            "simulation",
            "solve",
            "statics",
            "trim",
            "validity",
        ],
    ),
    (
        "bluff_body.rs",
        &["case", "gpu", "lattice", "measure", "plan", "simulation"],
    ),
    (
        "validate",
        &[
            "aero",
            "bluff_body",
            "case",
            "cloth",
            "cpu",
            "fabric",
            "frame",
            "geometry",
            "gpu",
            "immersed",
            "lattice",
            "lines",
            "measure",
            "output",
            "plan",
            "rigid",
            "run",
            "simulation",
            "solve",
            "statics",
            "trim",
        ],
    ),
    (
        "bench",
        &[
            "aero",
            "bluff_body",
            "case",
            "cloth",
            "cpu",
            "fabric",
            "geometry",
            "gpu",
            "immersed",
            "lattice",
            "measure",
            "output",
            "plan",
            "run",
            "simulation",
            "solve",
        ],
    ),
    (
        "cli",
        &[
            "bench", "case", "gpu", "measure", "output", "plan", "run", "sweep", "validate",
            "validity",
        ],
    ),
    ("main.rs", &[]),
];

fn imports() {
    let source = root().join("src");
    let mut files = Vec::new();
    sources(&source, &mut files);
    assert!(files.len() > 50);
    for file in files {
        let relative = file
            .strip_prefix(&source)
            .unwrap()
            .to_string_lossy()
            .into_owned();
        let room = relative.split('/').next().unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        // Tests inside a file may look anywhere.
        let code = text.split("#[cfg(test)]").next().unwrap();
        assert!(
            !code.contains("wgpu::") || room == "gpu",
            "{relative} sees wgpu"
        );
        if room == "lib.rs" {
            continue;
        }
        let (_, allowed) = ALLOWED
            .iter()
            .find(|(name, _)| *name == room)
            .expect("every room has its rule");
        for line in code
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
        {
            for used in line
                .match_indices("crate::")
                .map(|(at, found)| &line[at + found.len()..])
            {
                let target: String = used
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                // `use crate::{a, b}` is not written in this crate.
                assert!(!target.is_empty(), "{relative}: name the room in `{line}`");
                assert!(
                    target == room.trim_end_matches(".rs") || allowed.contains(&target.as_str()),
                    "{relative} must not use crate::{target}"
                );
            }
        }
    }
}

/// Rooms stand on floors: each uses only rooms below it.
fn no_circle() {
    let mut left: Vec<(&str, &[&str])> = ALLOWED
        .iter()
        .map(|&(room, uses)| (room.trim_end_matches(".rs"), uses))
        .collect();
    loop {
        let names: Vec<&str> = left.iter().map(|(room, _)| *room).collect();
        let before = left.len();
        left.retain(|(_, uses)| uses.iter().any(|used| names.contains(used)));
        if left.len() == before {
            break;
        }
    }
    assert!(left.is_empty(), "these rooms stand on each other: {left:?}");
}

/// Rooms whose files may make circles still.
const ROOMS_WITH_CIRCLES: [&str; 2] = [
    "case",    // goes with the branch that takes its circles out
    "measure", // goes with the branch that takes its circles out
];

/// Files stand on floors, too: the types below, the stages above, the head that runs them on top.
fn no_circle_of_files() {
    let source = root().join("src");
    let graph = FileGraph::of_crate(&source.join("lib.rs"));
    let is_free = |circle: &Vec<usize>| {
        let mut rooms = ROOMS_WITH_CIRCLES.iter().map(|room| source.join(room));
        !rooms.any(|room| graph.files[circle[0]].starts_with(room))
    };
    let circles: Vec<String> = graph
        .circles()
        .iter()
        .filter(|circle| is_free(circle))
        .map(|circle| graph.describe(circle, &source))
        .collect();
    assert!(
        circles.is_empty(),
        "{} sets of files use each other; move what they share into a file below them:\n{}",
        circles.len(),
        circles.join("\n")
    );
}

fn file_sizes() {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    for file in files {
        let lines = std::fs::read_to_string(&file).unwrap().lines().count();
        assert!(
            lines <= 600,
            "{} has {lines} lines: split it",
            file.display()
        );
    }
}
