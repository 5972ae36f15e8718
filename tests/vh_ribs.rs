//! V- and H-ribs of wings: sewn where they are drawn, on both halves; pieces of every kind of a drawing of LEparagliding.

use std::collections::HashSet;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::leparagliding;
use ripstop::geometry::wing::plan::{Hole, Plan, VhRib, VhRibEnd};
use ripstop::geometry::wing::section::{Profile, Side};
use ripstop::geometry::wing::{BuiltWing, Part, build};

use crate::engines::plain;
use crate::import::drawing;
use crate::wing::{FINENESS, plan, station};

pub fn trials() -> Vec<Trial> {
    [
        plain("vh_ribs::they_are_sewn_where_they_are_drawn", sewn),
        plain("vh_ribs::halves_have_the_same", halves),
        plain("vh_ribs::a_drawing_has_all_kinds", of_a_drawing),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const CHORD_M: f64 = 2.0;

/// A straight wing with pieces, its cells 0.5 m wide.
fn straight(cells: usize, pieces: Vec<VhRib>) -> Plan {
    let half_m = 0.25 * cells as f64;
    Plan {
        vh_ribs: pieces,
        holes: vec![Hole {
            position: 0.5,
            width: 0.3,
            height: 0.5,
        }],
        ..plan(
            vec![station(0.0, CHORD_M, 0.0), station(half_m, CHORD_M, 0.0)],
            cells,
        )
    }
}

fn piece(ribs: [usize; 2], between: [[f64; 2]; 2], heights: [f64; 2]) -> VhRib {
    VhRib {
        ribs,
        ends: [0, 1].map(|k| VhRibEnd {
            between: between[k],
            height: heights[k],
        }),
    }
}

fn nodes_of(wing: &BuiltWing, wanted: impl Fn(Part) -> bool) -> HashSet<u32> {
    let triangles = wing.structure.triangles.iter().zip(&wing.tags);
    triangles
        .filter(|(_, tag)| wanted(tag.part))
        .flat_map(|(triangle, _)| triangle.nodes)
        .collect()
}

fn area_m2(wing: &BuiltWing, half: impl Fn(f64) -> bool) -> f64 {
    let triangles = wing.structure.triangles.iter().zip(&wing.tags);
    let positions = &wing.structure.positions_m;
    let sum = |nodes: &[u32; 3]| -> f64 { nodes.iter().map(|n| positions[*n as usize].y).sum() };
    triangles
        .filter(|(triangle, tag)| tag.part == Part::Diagonal && half(sum(&triangle.nodes)))
        .map(|(triangle, _)| triangle.rest_area_m2)
        .sum()
}

fn ribs_m2(wing: &BuiltWing) -> f64 {
    let triangles = wing.structure.triangles.iter().zip(&wing.tags);
    let ribs = triangles.filter(|(_, tag)| tag.part == Part::Rib);
    ribs.map(|(triangle, _)| triangle.rest_area_m2).sum()
}

/// A strap along the lower seams, a V-rib to the upper one, and one to six tenths of the height: their ends are nodes of ribs, at the ribs and heights that they name, and their areas are those of
/// trapezia. The hole in the way of the last one is left out of its rib alone.
fn sewn() {
    let whole = build(&straight(8, Vec::new()), FINENESS).unwrap();
    assert_eq!(area_m2(&whole, |_| true), 0.0);
    let mut without_holes = straight(8, Vec::new());
    without_holes.holes.clear();
    let without_holes = build(&without_holes, FINENESS).unwrap();
    let hole_m2 = (ribs_m2(&without_holes) - ribs_m2(&whole)) / 7.0;
    for (heights, between) in [
        ([0.0, 0.0], [[0.2, 0.4], [0.2, 0.4]]),
        ([0.0, 1.0], [[0.25, 0.35], [0.1, 0.5]]),
        ([0.0, 0.6], [[0.4, 0.6], [0.4, 0.6]]),
        ([0.6, 1.0], [[0.4, 0.6], [0.3, 0.7]]),
        // Near where the seams meet, away from the hole.
        ([0.0, 0.8], [[0.7, 0.8], [0.88, 0.94]]),
    ] {
        let wing = build(
            &straight(8, vec![piece([1, 2], between, heights)]),
            FINENESS,
        )
        .unwrap();
        let positions = &wing.structure.positions_m;
        let inner = nodes_of(&wing, |part| part == Part::Diagonal);
        let of_ribs = nodes_of(&wing, |part| part == Part::Rib);
        let shared: Vec<DVec3> = (inner.intersection(&of_ribs))
            .map(|node| positions[*node as usize])
            .collect();
        let mut widths_m = [0.0; 2];
        let mut middles = [DVec3::ZERO; 2];
        for (end, y) in [0.5, 1.0].into_iter().enumerate() {
            let sewn: Vec<&DVec3> = shared.iter().filter(|p| (p.y - y).abs() < 1e-9).collect();
            let [from, to] = between[end];
            let places = sewn.iter().map(|p| p.x / CHORD_M);
            let [first, last] = [
                places.clone().fold(f64::MAX, f64::min),
                places.fold(f64::MIN, f64::max),
            ];
            // To the nearest nodes: 16 edges along the chord.
            assert!(
                (first - from).abs() < 0.07 && (last - to).abs() < 0.07,
                "{first} {last}"
            );
            let profile = Profile::naca("2415").unwrap();
            for p in &sewn {
                let x = p.x / CHORD_M;
                let [up, down] = [Side::Upper, Side::Lower].map(|side| profile.height(side, x));
                let height = (p.z / CHORD_M - down) / (up - down);
                assert!(
                    (height - heights[end]).abs() < 1e-6,
                    "{height} {}",
                    heights[end]
                );
            }
            widths_m[end] = CHORD_M * (last - first);
            middles[end] = sewn.iter().copied().sum::<DVec3>() / sewn.len() as f64;
        }
        let area = area_m2(&wing, |y| y > 0.0);
        let expected = 0.5
            * (widths_m[0] + widths_m[1])
            * (middles[1] - middles[0]).reject_from(DVec3::X).length();
        assert!((area / expected - 1.0).abs() < 0.1, "{area} {expected}");
        // The ribs' area grows by the holes that are left out: on both halves, in ribs that an end between the seams is sewn to.
        let grown = ribs_m2(&wing) - ribs_m2(&whole);
        let filled = (heights.iter().zip(between))
            .filter(|(height, [from, _])| **height > 0.0 && **height < 1.0 && *from < 0.65)
            .count();
        let expected = 2.0 * filled as f64 * hole_m2;
        assert!(
            (grown - expected).abs() < 1e-3 * hole_m2,
            "{grown} {expected}"
        );
    }
}

/// Mirror images, across the middle cell, too: there one that is its own image is sewn once.
fn halves() {
    let strap = |ribs| piece(ribs, [[0.2, 0.4]; 2], [0.0, 0.0]);
    let rising = piece([0, 1], [[0.2, 0.4], [0.1, 0.5]], [0.0, 1.0]);
    for (cells, pieces, across) in [
        (8, vec![strap([0, 1]), strap([2, 3])], 4),
        (7, vec![strap([0, 1]), strap([2, 3])], 3),
        (7, vec![strap([1, 0]), strap([0, 1])], 1),
    ] {
        let wing = build(&straight(cells, pieces), FINENESS).unwrap();
        let one = area_m2(&wing, |_| true) / f64::from(across);
        assert!(
            (one / (0.5 * 0.2 * CHORD_M) - 1.0).abs() < 0.3,
            "{cells}: {one}"
        );
        let [left, right] = [area_m2(&wing, |y| y < -1e-9), area_m2(&wing, |y| y > 1e-9)];
        assert!((left - right).abs() < 1e-9, "{cells}: {left} {right}");
    }
    let wing = build(&straight(7, vec![rising]), FINENESS).unwrap();
    let [left, right] = [-1.0, 1.0].map(|sign| area_m2(&wing, |y| sign * y > 1e-9));
    assert!((left - right).abs() < 1e-9 && left > 0.0, "{left} {right}");
}

/// All kinds of section 12, by places and heights; what leads nowhere is told.
fn of_a_drawing() {
    // Kind, what follows, and pieces as ribs of ours, places and heights. Anchors at 10, 35 and 65.5 per cent; ribs count from the one in the middle. The first rib's chord is 220 cm.
    let [first, second] = [1, 2].map(|rib| crate::import::rib(rib, true)[1]);
    let cases = [
        (
            "11 2 1 3 1 2.0 0 0 0",
            vec![([1, 2], [[0.08, 0.12]; 2], [0.0; 2])],
        ),
        (
            "13 2 2 1 1 2.0 5.0 0 0",
            vec![
                ([1, 0], [[0.33, 0.37], [0.3, 0.4]], [0.0, 1.0]),
                ([1, 2], [[0.33, 0.37], [0.3, 0.4]], [0.0, 1.0]),
            ],
        ),
        (
            "12 2 2 0 1 2.0 5.0 80 90",
            vec![([1, 2], [[0.33, 0.37], [0.3, 0.4]], [0.0, 0.8])],
        ),
        (
            "3 2 2 0 1 4.0 10.0 0 0",
            vec![(
                [1, 2],
                [
                    [0.35 - 4.0 / first, 0.35 + 4.0 / first],
                    [0.35 - 10.0 / second, 0.35 + 10.0 / second],
                ],
                [0.0, 1.0],
            )],
        ),
        (
            "14 3 2 1 0 2.0 5.0 70 90",
            vec![
                ([2, 3], [[0.3, 0.4]; 2], [0.7; 2]),
                ([1, 2], [[0.33, 0.37], [0.3, 0.4]], [0.0, 0.7]),
            ],
        ),
        (
            "15 2 2 0 1 50 35 85 3.0",
            vec![([1, 2], [[0.32, 0.38], [0.225, 0.5025]], [0.0, 1.0])],
        ),
        // In the middle both sides are one piece, whose other half is its image; beyond the tip there is none.
        (
            "13 1 2 0 1 2.0 5.0 0 0",
            vec![([0, 1], [[0.33, 0.37], [0.3, 0.4]], [0.0, 1.0])],
        ),
        (
            "13 12 2 1 1 2.0 5.0 0 0",
            vec![([11, 10], [[0.33, 0.37], [0.3, 0.4]], [0.0, 1.0])],
        ),
        (
            "16 2 40 100 5 3 3 42 60 2 1",
            vec![([1, 2], [[0.37, 0.45], [0.41, 0.44]], [1.0, 0.6])],
        ),
    ];
    for (line, expected) in cases {
        let imported = imported(&format!("1\n80 150\n1 {line}\n"));
        let wing: toml::Table = imported.text.parse().unwrap();
        let wing = wing["structure"]["wing"].as_table().unwrap().clone();
        assert!(wing["rows"]["A"].get("diagonals").is_none(), "{line}");
        let found = wing["vh_ribs"].as_array().unwrap();
        assert_eq!(found.len(), expected.len(), "{line}");
        for (one, (ribs, between, heights)) in found.iter().zip(expected) {
            let numbers = |value: &toml::Value| -> Vec<f64> {
                let all = value.as_array().unwrap().iter();
                all.map(|v| {
                    v.as_float()
                        .unwrap_or_else(|| v.as_integer().unwrap() as f64)
                })
                .collect()
            };
            assert_eq!(numbers(&one["ribs"]), ribs.map(|rib| rib as f64), "{line}");
            for (found, expected) in numbers(&one["heights"]).iter().zip(heights) {
                assert!((found - expected).abs() < 1e-12, "{line}: {found}");
            }
            for (found, expected) in one["between"].as_array().unwrap().iter().zip(between) {
                let found = numbers(found);
                for (place, expected) in found.iter().zip(expected) {
                    assert!((place - expected).abs() < 1e-3, "{line}: {found:?}");
                }
            }
        }
    }
    // Without any the usual ones are not put in, either; a section that is not there is told.
    let none = imported("0\n");
    assert!(!none.text.contains("vh_ribs") && !none.text.contains("diagonals"));
    // Anchor and kind that are not there, and no neighbours; what a file of nonsense asks for.
    let lost = imported(
        "4\n80 150\n1 1 2 1 3 5 4 0 0 0\n2 9 2 1 3 1 4 0 0 0\n3 1 2 1 4 1 4 0 0 0\n4 2 1e19 -1e19 0 1 4 4 80 90\n",
    );
    assert!(lost.text.contains("diagonals") && !lost.text.contains("vh_ribs"));
    let told = "4 V- and H-ribs lead to an anchor or a rib that is not there";
    assert!(
        lost.left_out.iter().any(|line| line.contains(told)),
        "{:?}",
        lost.left_out
    );
    let missing = drawing(true, "ds").replace("12. H V and VH ribs", "13. Nothing");
    let missing = leparagliding::import(&missing, Some(80.0), |_| None).unwrap();
    assert!(missing.text.contains("diagonals"));
    let told = "V- and H-ribs: section 12";
    assert!(
        missing.left_out.iter().any(|line| line.contains(told)),
        "{:?}",
        missing.left_out
    );
}

fn imported(section: &str) -> leparagliding::Imported {
    const HEADING: &str = "*  12. H V and VH ribs *\n";
    let drawn =
        drawing(true, "ds").replace(&format!("{HEADING}0\n"), &format!("{HEADING}{section}"));
    leparagliding::import(&drawn, Some(80.0), |_| None).unwrap()
}
