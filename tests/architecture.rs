//! Rules between the rooms of the house, checked on the source text (see the crate's documentation).

use std::collections::BTreeMap;
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
        plain("architecture::circles_are_noticed", circles_are_noticed),
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
const ALLOWED: [(&str, &[&str]); 35] = [
    ("lattice", &[]),
    ("solve", &[]),
    ("lines", &[]),
    ("immersed", &[]),
    ("sets.rs", &[]),
    ("cut_links", &["immersed", "lattice", "sets"]),
    ("frame.rs", &[]),
    ("aero", &["geometry"]),
    ("trim", &["aero", "cloth", "geometry"]),
    ("units.rs", &[]),
    ("polar", &["aero", "case"]),
    ("fabric", &["frame"]),
    ("rigid", &["immersed", "sets"]),
    ("output", &["frame"]),
    ("render", &["frame"]),
    ("checkpoint", &["output"]),
    ("ledger", &["output"]),
    ("cloth", &["fabric", "frame", "immersed", "lines"]),
    (
        "geometry",
        &[
            "cloth", "fabric", "frame", "immersed", "lines", "rigid", "sets",
        ],
    ),
    (
        "cpu",
        &[
            "checkpoint",
            "cloth",
            "cut_links",
            "fabric",
            "frame",
            "immersed",
            "lattice",
            "solve",
        ],
    ),
    (
        "gpu",
        &[
            "checkpoint",
            "cloth",
            "cpu",
            "cut_links",
            "immersed",
            "lattice",
            "lines",
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
            "aero", "case", "cloth", "fabric", "geometry", "immersed", "lattice", "solve", "trim",
        ],
    ),
    (
        "simulation",
        &[
            "case",
            "checkpoint",
            "cloth",
            "cpu",
            "cut_links",
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
    ("report", &["ledger", "measure", "output", "sweep"]),
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
            "report",
            "simulation",
            "solve",
            "statics",
            "trim",
            "validity",
        ],
    ),
    (
        "bluff_body.rs",
        &[
            "case",
            "gpu",
            "lattice",
            "measure",
            "output",
            "plan",
            "simulation",
        ],
    ),
    (
        "validate",
        &[
            "aero",
            "bluff_body",
            "case",
            "cloth",
            "cpu",
            "cut_links",
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
            "polar",
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
            "bench", "case", "gpu", "lattice", "measure", "output", "plan", "polar", "report",
            "run", "sweep", "validate", "validity",
        ],
    ),
    ("main.rs", &[]),
];

/// Rooms use what their rules allow, by whichever path they reach it, and need every one of these rules.
fn imports() {
    let source = root().join("src");
    let room_of = |file: &Path| {
        let relative = file.strip_prefix(&source).unwrap();
        let first = relative.components().next().unwrap().as_os_str();
        first.to_string_lossy().trim_end_matches(".rs").to_owned()
    };
    let mut used: BTreeMap<(String, String), String> = BTreeMap::new();
    let mut files = Vec::new();
    sources(&source, &mut files);
    assert!(files.len() > 50);
    for file in files {
        let room = room_of(&file);
        let text = std::fs::read_to_string(&file).unwrap();
        // Tests inside a file may look anywhere.
        let code = text.split("#[cfg(test)]").next().unwrap();
        let name = file.display();
        assert!(
            !code.contains("wgpu::") || room == "gpu",
            "{name} sees wgpu"
        );
        for target in named_rooms(code) {
            used.insert((room.clone(), target), format!("{name} names it"));
        }
    }
    let graph = FileGraph::of_crate(&source.join("lib.rs"));
    for (&(from, to), items) in &graph.arrows {
        let [from, to] = [from, to].map(|at| graph.files[at].as_path());
        used.insert(
            (room_of(from), room_of(to)),
            format!("{} uses {items:?}", from.display()),
        );
    }
    used.retain(|(room, target), _| room != target && room != "lib");
    for ((room, target), why) in &used {
        assert!(
            allowed(room).contains(&target.as_str()),
            "{room} must not use crate::{target}: {why}"
        );
    }
    for (room, targets) in ALLOWED {
        let room = room.trim_end_matches(".rs");
        for target in targets {
            assert!(
                used.contains_key(&(room.to_owned(), (*target).to_owned())),
                "{room} does not use crate::{target} any more: remove it from ALLOWED"
            );
        }
    }
}

fn allowed(room: &str) -> &'static [&'static str] {
    let mut rules = ALLOWED.iter();
    let rule = rules.find(|(name, _)| name.trim_end_matches(".rs") == room);
    rule.expect("every room has its rule").1
}

/// Rooms that code names behind `crate::`, one by one or in braces.
fn named_rooms(code: &str) -> Vec<String> {
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    let code: Vec<&str> = code.lines().filter(is_code).collect();
    let code = code.join("\n");
    let word = |text: &str| -> String {
        let text = text.trim_start().chars();
        text.take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let mut rooms = Vec::new();
    for (at, found) in code.match_indices("crate::") {
        let behind = &code[at + found.len()..];
        let Some(group) = behind.strip_prefix('{') else {
            rooms.push(word(behind));
            continue;
        };
        // First names of what stands between the outer braces.
        let (mut depth, mut begins) = (1, true);
        for (at, mark) in group.char_indices() {
            match mark {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 1 => begins = true,
                _ if begins && !mark.is_whitespace() => {
                    rooms.push(word(&group[at..]));
                    begins = false;
                }
                _ => {}
            }
            if depth == 0 {
                break;
            }
        }
    }
    rooms
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

/// Files stand on floors, too: the types below, the stages above, the head that runs them on top.
fn no_circle_of_files() {
    let source = root().join("src");
    let graph = FileGraph::of_crate(&source.join("lib.rs"));
    let circles: Vec<String> = graph
        .circles()
        .iter()
        .map(|circle| graph.describe(circle, &source))
        .collect();
    assert!(
        circles.is_empty(),
        "{} sets of files use each other; move what they share into a file below them:\n{}",
        circles.len(),
        circles.join("\n")
    );
}

/// Arrows by every kind of path, and none by re-exports or by tests.
fn circles_are_noticed() {
    let crate_of = |files: &[(&str, &str)]| -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let graph = FileGraph::of_crate(&folder.path().join("lib.rs"));
        let circles = graph.circles();
        let mut text = circles
            .iter()
            .map(|circle| graph.describe(circle, folder.path()));
        text.next().map_or_else(Vec::new, |text| {
            let lines = text.lines().skip(1);
            lines.map(|line| line.trim().to_owned()).collect()
        })
    };
    let head = "mod a; mod b; pub use a::A; pub use b::*;";
    // A head that only re-exports stands on nothing, and nobody on it.
    assert!(
        crate_of(&[
            ("lib.rs", "mod room;"),
            ("room/mod.rs", head),
            ("room/a.rs", "use super::B; pub struct A(B);"),
            (
                "room/b.rs",
                "pub struct B; #[cfg(test)] mod tests { use super::super::A; }"
            ),
        ])
        .is_empty()
    );
    // One with code of its own does both.
    let with_code = format!("{head} pub const C: i32 = 1; fn f(_: A) {{}}");
    assert_eq!(
        crate_of(&[
            ("lib.rs", "mod room;"),
            ("room/mod.rs", &with_code),
            ("room/a.rs", "pub struct A; fn f() -> i32 { super::C }"),
            ("room/b.rs", "pub struct B;"),
        ]),
        ["room/mod.rs -> room/a.rs: A", "room/a.rs -> room/mod.rs: C"]
    );
    for user in [
        "use crate::{room::{a, b::B}}; struct C(B); use a::A as D; fn f(_: D) {}",
        "fn f() { use crate::room::A; let _: Option<A> = None; }",
        "fn f() { println!(\"{:?}\", crate::room::a::A); }",
        "use super::*; fn f(_: A) {}",
        "use crate::room; impl room::A {}",
        "#[derive(Debug)] struct C { #[serde(with = \"crate::room::a::f\")] c: i32 }",
    ] {
        let found = crate_of(&[
            ("lib.rs", "mod room;"),
            ("room/mod.rs", head),
            (
                "room/a.rs",
                "use super::b::B; pub struct A(B); pub mod f {}",
            ),
            ("room/b.rs", &format!("pub struct B; {user}")),
        ]);
        assert_eq!(found.len(), 2, "{user}: {found:?}");
    }
    // What a macro defines has no item of its own in the text.
    assert_eq!(
        crate_of(&[
            ("lib.rs", "mod a; mod b;"),
            (
                "a.rs",
                "table! { A { a: i32, } } const LAYOUT: i32 = crate::b::B;"
            ),
            ("b.rs", "make!(); fn f(_: crate::a::A) {}"),
        ]),
        ["a.rs -> b.rs: B", "b.rs -> a.rs: A"]
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
