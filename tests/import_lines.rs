//! Lines of imported wings: where they lead, how long they are, and how their lengths stand beside those that LEparagliding found.

use std::fmt::Write;

use libtest_mimic::Trial;
use ripstop::case::{self, Choices, leparagliding};
use ripstop::geometry::wing::LineKind;
use ripstop::geometry::wing::plan::{JoinPlace, Row};

use crate::engines::plain;
use crate::import::{SCALE, brought_in, drawing, put, rib};

pub fn trials() -> Vec<Trial> {
    [
        plain("import_lines::lead_where_they_are_drawn", lines),
        plain("import_lines::are_as_long_as_they_are_drawn", cascade),
        plain("import_lines::stand_beside_those_that_were_found", beside),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn lines() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), true, "ds");
    let imported = leparagliding::import(&drawing(true, "ds"), Some(80.0), |_| None).unwrap();
    let case = case::parse(
        "wing.toml",
        &imported.text,
        folder.path(),
        &Choices::default(),
    );
    let case = case.unwrap_or_else(|told| panic!("{told}"));
    let rows = &case.scene.wing().unwrap().plan.rows;
    let [a, b, c, brake] = &rows[..] else {
        panic!("{} rows", rows.len());
    };
    // The rib in the middle has a line of each half; the riser of B carries one to an anchor of A at the tip.
    assert_eq!(a.ribs, [0, 2, 4, 6, 8, 10]);
    assert_eq!(b.ribs, [0, 2, 4, 6, 8, 10, 11]);
    let places: Vec<f64> = b.attachments().map(|(_, place)| place).collect();
    assert_eq!(places[..6], [0.35; 6]);
    assert!((places[6] - 0.1).abs() < 1e-9 && (c.position - 0.655).abs() < 1e-9);
    assert_eq!(a.levels[0].joins, [3, 3]);
    assert_eq!(b.levels[0].joins, [3, 3, 1]);
    assert_eq!(brake.ribs, [2, 4, 7, 10]);
    assert_eq!(brake.levels[0].joins, [2, 2]);
    // Nodes lie 1.5 m below the sail, as the drawing says; the line of B to an anchor of A has none, and is divided in its middle.
    let ways = |row: &Row| match &row.levels[0].place {
        JoinPlace::ToSail(ways) => ways.clone(),
        JoinPlace::Height(_) => panic!("by height"),
    };
    for way in ways(a) {
        assert!((way - 1.5 * SCALE).abs() < 1e-9, "{way}");
    }
    let of_b = ways(b);
    assert_eq!(of_b.len(), 3);
    for (way, expected) in of_b.iter().zip([1.5, 1.5, 2.4]) {
        assert!((way - expected * SCALE).abs() < 1e-9, "{way}");
    }
    // The main line of the brakes is theirs, too: 2.5 m, above risers of 0.45 m, which have no scale.
    let main_m = 2.5 * SCALE + 0.45;
    assert!(
        (brake.riser_length_m - main_m).abs() < 1e-9,
        "{}",
        brake.riser_length_m
    );
    for way in ways(brake) {
        assert!((way - 1.2 * SCALE).abs() < 1e-9, "{way}");
    }
    // Lines point to where the loads of the drawing are, once it tells them: by chord, and A with 40 % of a rib's.
    assert!(a.weights.is_empty());
    let loads = "***\n*  18. Elastic lines corrections *\n100\n75 25\n40 40 20\n35 35 20 10\n35 35 15 10 5\n";
    let told = leparagliding::import(&(drawing(true, "ds") + loads), Some(80.0), |_| None).unwrap();
    let table: toml::Table = told.text.parse().unwrap();
    let weights = table["structure"]["wing"]["rows"]["A"]["weights"]
        .as_array()
        .unwrap();
    assert_eq!(weights.len(), 6);
    for (number, weight) in [0, 2, 4, 6, 8, 10].into_iter().zip(weights) {
        let expected = 0.4 * rib(number, true)[1] / rib(0, true)[1];
        let found = weight.as_float().unwrap();
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{number}: {found} {expected}"
        );
    }
}

/// Three pairs, of which two and one go on.
const LEVELS_OF_A: &str = "[{ material = \"gallery\", joins = [2, 2, 2], to_sail_m = [0.5, 0.5, 0.6] }, { material = \"gallery\", joins = [2, 1], to_sail_m = [1.4, 1.7] }, { material = \"main\" }]";

/// Lines between two nodes are as long as their ways to the sail differ, and the lowest node is as far from the mean of what it carries.
fn cascade() {
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), true, "ds");
    let imported = leparagliding::import(&drawing(true, "ds"), Some(80.0), |_| None).unwrap();
    let with = |levels: &str| {
        let mut table: toml::Table = imported.text.parse().unwrap();
        let levels: toml::Table = format!("levels = {levels}").parse().unwrap();
        table["structure"]["wing"]["rows"]["A"]["levels"] = levels["levels"].clone();
        let text = toml::to_string(&table).unwrap();
        case::parse("wing.toml", &text, folder.path(), &Choices::default())
    };
    let with_weights = |weights: &str| {
        let mut table: toml::Table = imported.text.parse().unwrap();
        let row: toml::Table = format!("weights = {weights}\nlevels = {}", LEVELS_OF_A)
            .parse()
            .unwrap();
        for (key, value) in row {
            table["structure"]["wing"]["rows"]["A"]
                .as_table_mut()
                .unwrap()
                .insert(key, value);
        }
        let text = toml::to_string(&table).unwrap();
        case::parse("wing.toml", &text, folder.path(), &Choices::default())
    };
    let levels = |upper: &str, lower: &str| {
        format!(
            "[{{ material = \"gallery\", joins = [2, 2, 2], to_sail_m = {upper} }}, {{ material = \"gallery\", joins = [2, 1], to_sail_m = {lower} }}, {{ material = \"main\" }}]"
        )
    };
    let case =
        with(&levels("[0.5, 0.5, 0.6]", "[1.4, 1.7]")).unwrap_or_else(|told| panic!("{told}"));
    let (body, wing) = (
        case.scene.body.as_ref().unwrap(),
        case.scene.wing().unwrap(),
    );
    let cables = body.structure.cables.iter().zip(&wing.built.line_kinds);
    let of_level = |wanted: usize| {
        cables
            .clone()
            .filter(move |(_, kind)| matches!(kind, LineKind::Line { row: 0, level } if *level == wanted))
            .map(|(cable, _)| cable)
    };
    let mut found = of_level(1).map(|cable| cable.rest_length_m);
    for half in ["right", "left"] {
        for expected in [0.9, 0.9, 1.1] {
            let length = found.next().unwrap();
            assert!(
                (length - expected).abs() < 1e-9,
                "{half}: {length} {expected}"
            );
        }
    }
    // The outermost lower node carries the last two attachments alone.
    let ends = |level: usize| of_level(level).map(|cable| cable.nodes);
    let place = |node: u32| body.structure.positions_m[node as usize];
    let upper: Vec<[u32; 2]> = ends(0).collect();
    let middle: Vec<[u32; 2]> = ends(1).collect();
    let target = 0.5 * (place(upper[4][0]) + place(upper[5][0]));
    assert!((place(middle[2][1]).distance(target) - 1.7).abs() < 1e-9);
    // A weight moves a node: the last attachment draws the outermost lower node towards itself.
    let weighted =
        with_weights("[1.0, 1.0, 1.0, 1.0, 1.0, 3.0]").unwrap_or_else(|told| panic!("{told}"));
    let (body, wing) = (
        weighted.scene.body.as_ref().unwrap(),
        weighted.scene.wing().unwrap(),
    );
    let cables = body.structure.cables.iter().zip(&wing.built.line_kinds);
    let ends = |wanted: usize| -> Vec<[u32; 2]> {
        cables
            .clone()
            .filter(
                |(_, kind)| matches!(kind, LineKind::Line { row: 0, level } if *level == wanted),
            )
            .map(|(cable, _)| cable.nodes)
            .collect()
    };
    let place = |node: u32| body.structure.positions_m[node as usize];
    let (upper, middle) = (ends(0), ends(1));
    let target = 0.25 * place(upper[4][0]) + 0.75 * place(upper[5][0]);
    assert!((place(middle[2][1]).distance(target) - 1.7).abs() < 1e-9);
    for weights in ["[1.0]", "[1.0, 1.0, 1.0, 1.0, 1.0, 0.0]"] {
        let message = with_weights(weights).unwrap_err().to_string();
        assert!(message.contains("rows.A.weights"), "{message}");
    }
    for (levels, told) in [
        (
            levels("[0.5, 0.5, 0.6]", "[1.4, 1.7]").replace("[2, 1]", "[9223372036854775807, 4]"),
            "but 3 lines reach it",
        ),
        (
            levels("[0.5, 0.5, 0.6]", "[1.4, 1.7]")
                .replace("to_sail_m = [1.4, 1.7]", "height = 0.3"),
            "all by `height`, or all by `to_sail_m`",
        ),
        (
            levels("[0.5, 0.5, 0.6]", "[1.4, 0.6]"),
            "0.6 m below the sail, where 0.620 to 100 m",
        ),
        (
            levels("[0.5, 0.5]", "[1.4, 1.7]"),
            "2 ways to the sail for 3 nodes",
        ),
        (
            levels("[0.5, 0.5, 0.6]", "[1.4, 9.0]"),
            "join 9 m below the sail, but the node below, or the end of the riser, is",
        ),
        (
            levels("[0.5, 0.5, -0.6]", "[1.4, 1.7]"),
            "-0.6 m below the sail",
        ),
        (
            levels("[0.5, 0.5, nan]", "[1.4, 1.7]"),
            "NaN m below the sail",
        ),
    ] {
        let message = with(&levels).unwrap_err().to_string();
        assert!(message.contains(told), "{message}");
    }
}

/// Lengths by rows beside those of `lines.txt`, of versions with a unit and without.
fn beside() {
    for unit in [" cm  -  type  2", ""] {
        let folder = tempfile::tempdir().unwrap();
        put(folder.path(), true, "ds");
        let mut lines = String::from(" Line number - Label\n\n Plan A\n\n");
        let mut add = |number: usize, name: &str, length: f64| {
            let _ = writeln!(lines, "  {number}   {name}   {length}{unit}");
        };
        add(1, "1A1", 45.0);
        add(2, "2A1", 300.0);
        add(3, "3A12", 150.0);
        lines += "\n Brake lines\n\n  4  1F1  310.0\n";
        let _ = writeln!(lines, "  5  2F1  200.0{unit}");
        lines += " Total line lengths (without loops) =    297.89 m\n 1   4.26 m\n";
        std::fs::write(folder.path().join("lines.txt"), lines).unwrap();
        let out = folder.path().join("out");
        let output = brought_in(&folder.path().join("leparagliding.txt"), &out);
        assert_eq!(output.code, 0, "{}", output.errors);
        // Both halves, without the riser and the main line of the brakes.
        let theirs = |row: &str| {
            let line = output
                .printed
                .lines()
                .find(|line| line.trim_start().starts_with(row));
            let mut words: Vec<&str> = line
                .unwrap_or_else(|| panic!("{row}: {}", output.printed))
                .split_whitespace()
                .collect();
            assert_eq!(words.pop(), Some("%"), "{words:?}");
            words[words.len() - 2].parse::<f64>().unwrap()
        };
        assert_eq!(theirs("lines, without risers"), 9.0);
        assert_eq!(theirs("row A"), 9.0);
        assert_eq!(theirs("brakes"), 4.0);
    }
}
