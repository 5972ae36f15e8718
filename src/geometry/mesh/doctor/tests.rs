use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use super::*;
use crate::rigid::Surface;

/// A square sheet of 4 × 4 cells of 0.25 m in the plane z = 0, hung in the middle.
fn sheet() -> Surface {
    let mut sheet = Surface::default();
    for j in 0..5 {
        for i in 0..5 {
            let place = DVec3::new(f64::from(i), f64::from(j), 0.0) * 0.25;
            sheet.positions_m.push(place);
        }
    }
    for j in 0..4 {
        for i in 0..4 {
            let a = 5 * j + i;
            let (b, c, d) = (a + 1, a + 6, a + 5);
            sheet.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    sheet
}

fn examined(surface: &Surface, held: &[u32]) -> Examination {
    let mut anchored = vec![false; surface.positions_m.len()];
    for node in held {
        anchored[*node as usize] = true;
    }
    examine(&Subject {
        surface,
        start_m: &surface.positions_m,
        numbers: None,
        used_as: Use::Fabric {
            anchored: &anchored,
            nominal_area_m2: None,
        },
        cell_size_m: None,
    })
}

fn as_body(surface: &Surface) -> Examination {
    examine(&Subject {
        surface,
        start_m: &surface.positions_m,
        numbers: None,
        used_as: Use::RigidBody,
        cell_size_m: None,
    })
}

fn kinds(examination: &Examination) -> Vec<(Kind, usize)> {
    let findings = examination.findings.iter();
    findings.map(|f| (f.kind, f.count)).collect()
}

/// The sheet with its right half on vertices of its own.
fn with_seam(gap_m: f64) -> Surface {
    let mut cut = sheet();
    let mut copies = Vec::new();
    for j in 0..5 {
        copies.push(cut.positions_m.len() as u32);
        let place = cut.positions_m[5 * j + 2] + DVec3::X * gap_m;
        cut.positions_m.push(place);
    }
    for (number, nodes) in cut.triangles.iter_mut().enumerate() {
        if number / 2 % 4 >= 2 {
            for node in nodes.iter_mut().filter(|node| **node % 5 == 2) {
                *node = copies[*node as usize / 5];
            }
        }
    }
    cut
}

/// Two sheets side by side, of four and of six cells along their common seam.
fn hung_halves() -> Surface {
    let mut surface = Surface::default();
    for (cells, from) in [(4, 0.0), (6, 1.0)] {
        let first = surface.positions_m.len() as u32;
        for j in 0..=cells {
            for i in 0..3 {
                let [x, y] = [from + 0.5 * f64::from(i), f64::from(j) / f64::from(cells)];
                surface.positions_m.push(DVec3::new(x, y, 0.0));
            }
        }
        for j in 0..cells {
            for i in 0..2 {
                let a = first + 3 * j + i;
                surface
                    .triangles
                    .extend([[a, a + 1, a + 4], [a, a + 4, a + 3]]);
            }
        }
    }
    surface
}

/// A hemisphere in gores of which each has vertices of its own: every second one more of them along its seams, whose chords lie apart.
fn hemisphere_of_gores(few: u32, many: u32) -> Surface {
    let mut surface = Surface::default();
    for gore in 0..8 {
        let rows = if gore % 2 == 0 { few } else { many };
        let columns = rows / 2;
        let first = surface.positions_m.len() as u32;
        surface.positions_m.push(DVec3::Z);
        for row in 1..=rows {
            let (out, up) = (f64::from(row) / f64::from(rows) * FRAC_PI_2).sin_cos();
            for column in 0..=columns {
                let turn = (f64::from(gore) + f64::from(column) / f64::from(columns)) * TAU / 8.0;
                surface
                    .positions_m
                    .push(DVec3::new(out * turn.cos(), out * turn.sin(), up));
            }
        }
        let at = |row: u32, column: u32| {
            if row == 0 {
                first
            } else {
                first + 1 + (row - 1) * (columns + 1) + column
            }
        };
        for row in 0..rows {
            for column in 0..columns {
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
                surface.triangles.push([a, c, d]);
                if a != b {
                    surface.triangles.push([a, d, b]);
                }
            }
        }
    }
    surface
}

/// Seams that are curved: the remedy of the finding sews them, and they stay sewn.
#[test]
fn curved_seams_are_sewn_by_the_tolerance_that_is_told() {
    for (few, many) in [(8, 12), (8, 16), (10, 12)] {
        let cut = hemisphere_of_gores(few, many);
        let examination = examined(&cut, &[0]);
        let hanging = examination
            .findings
            .iter()
            .find(|f| f.kind == Kind::HangingNodes);
        let remedy = &hanging.unwrap().remedy;
        let told = remedy.split_whitespace().nth(2).unwrap();
        let tolerance_m: f64 = told.parse().unwrap();
        let welded = weld(&cut, tolerance_m).unwrap();
        assert!(welded.inserted.len() >= 8 * few as usize / 2);
        let sewn = examined(&welded.surface, &[0]);
        assert_eq!(sewn.findings, [], "{few} {many}");
        assert_eq!([sewn.pieces.len(), sewn.borders.len()], [1, 1]);
        let length_m = 8.0 * f64::from(many) * tolerance_m;
        assert!((sewn.area_m2 - examination.area_m2).abs() < length_m);
        assert!(welded.surface.triangles.len() > cut.triangles.len());
        assert!(welded.nodes.iter().all(Option::is_some));
        let mouth = mouth(
            &welded.surface.positions_m,
            &welded.surface.triangles,
            &sewn.borders,
        )
        .unwrap();
        assert!(
            mouth.direction.distance(DVec3::NEG_Z) < 1e-9 && !mouth.is_flat,
            "{mouth:?}"
        );
    }
}

#[test]
fn a_healthy_sheet_is_measured_and_nothing_is_found() {
    let examination = examined(&sheet(), &[0]);
    assert_eq!(examination.findings, []);
    assert_eq!(examination.node_count, 25);
    assert_eq!(examination.pieces.len(), 1);
    assert_eq!(examination.pieces[0].nodes, 25);
    assert_eq!(examination.borders.len(), 1);
    assert!((examination.borders[0].length_m - 4.0).abs() < 1e-12);
    assert_eq!(examination.borders[0].nodes.len(), 17);
    assert!((examination.area_m2 - 1.0).abs() < 1e-12);
    assert_eq!(examination.size_m, DVec3::new(1.0, 1.0, 0.0));
}

/// Each defect alone, with its number; nothing depends on the unit or on where the mesh lies.
#[test]
fn each_defect_is_found_alone() {
    let mut loose = sheet();
    for place in [[2.0, 0.0, 0.0], [2.2, 0.0, 0.0], [2.0, 0.2, 0.0]] {
        loose.positions_m.push(DVec3::from_array(place));
    }
    loose.triangles.push([25, 26, 27]);
    let mut doubled = sheet();
    doubled.triangles.extend(doubled.triangles.clone());
    let mut rib = sheet();
    rib.positions_m.push(DVec3::new(0.4, 0.5, 0.3));
    rib.triangles.push([11, 12, 25]);
    let mut turned = sheet();
    turned.triangles[7].swap(0, 1);
    // A triangle through the diagonal of a cell.
    let mut crossing = sheet();
    for place in [[0.6, 0.6, -0.3], [0.7, 0.6, 0.3], [0.6, 0.65, 0.3]] {
        crossing.positions_m.push(DVec3::from_array(place));
    }
    crossing.triangles.push([25, 26, 27]);
    // A triangle that lies upon parts of others, and one that is folded back upon its neighbour.
    let mut covering = sheet();
    for place in [[0.3, 0.3, 0.0], [0.7, 0.35, 0.0], [0.35, 0.7, 0.0]] {
        covering.positions_m.push(DVec3::from_array(place));
    }
    covering.triangles.push([25, 26, 27]);
    let mut folded = sheet();
    folded.positions_m.push(DVec3::new(0.45, 0.1, 0.0));
    folded.triangles.push([1, 0, 25]);
    for (factor, shift) in [(1.0, DVec3::ZERO), (39.37, DVec3::new(5e6, -3e5, 1e3))] {
        let moved = |mut surface: Surface| {
            for place in &mut surface.positions_m {
                *place = *place * factor + shift;
            }
            surface
        };
        let found =
            |surface: &Surface, held: &[u32]| kinds(&examined(&moved(surface.clone()), held));
        assert_eq!(found(&sheet(), &[0]), []);
        assert_eq!(found(&sheet(), &[]), [(Kind::LoosePieces, 1)]);
        let seam = found(&with_seam(0.0), &[0, 4]);
        assert_eq!(seam, [(Kind::DoubledVertices, 5), (Kind::Pieces, 2)]);
        let seam = found(&with_seam(1e-4), &[0]);
        assert_eq!(seam, [(Kind::DoubledVertices, 5), (Kind::LoosePieces, 1)]);
        assert_eq!(found(&loose, &[0]), [(Kind::LoosePieces, 1)]);
        assert_eq!(found(&doubled, &[0]), [(Kind::DoubledFaces, 32)]);
        assert_eq!(found(&rib, &[0]), [(Kind::NonManifoldEdges, 1)]);
        assert_eq!(found(&turned, &[0]), [(Kind::Orientation, 1)]);
        let through = found(&crossing, &[0, 25]);
        assert_eq!(through, [(Kind::SelfCrossing, 3), (Kind::Pieces, 2)]);
        let covered = found(&covering, &[0, 25]);
        assert!(
            matches!(
                covered[..],
                [(Kind::OverlappingFaces, 6..), (Kind::Pieces, 2)]
            ),
            "{covered:?}"
        );
        let folded = found(&folded, &[0]);
        assert_eq!(folded, [(Kind::OverlappingFaces, 3)]);
        assert_eq!(
            found(&hung_halves(), &[0]),
            [
                (Kind::DoubledVertices, 3),
                (Kind::HangingNodes, 6),
                (Kind::LoosePieces, 1)
            ]
        );
    }
    let mut huge = sheet();
    for place in &mut huge.positions_m {
        *place *= 1e15;
    }
    assert_eq!(kinds(&examined(&huge, &[0])), [(Kind::Size, 1)]);
}

/// Fabric upon fabric, a slit of some width, and a flap that touches are no findings.
#[test]
fn what_is_apart_or_only_touches_is_left_alone() {
    assert_eq!(
        kinds(&examined(&with_seam(0.02), &[0, 4])),
        [(Kind::Pieces, 2)]
    );
    let mut touching = sheet();
    for place in [[0.3, 0.3, 0.0], [0.4, 0.3, 0.4], [0.3, 0.4, 0.4]] {
        touching.positions_m.push(DVec3::from_array(place));
    }
    touching.triangles.push([25, 26, 27]);
    let found = kinds(&examined(&touching, &[0, 25]));
    assert_eq!(found, [(Kind::Pieces, 2)]);
}

/// A rigid ball: closed, with a hole, with a face turned, and a copy beside it.
#[test]
fn bodies_have_holes_and_sides() {
    let ball = crate::geometry::surfaces::sphere(0.5, 0.2);
    let examination = as_body(&ball);
    assert_eq!(examination.findings, []);
    assert_eq!(examination.borders, []);
    let mut open = ball.clone();
    open.triangles.pop();
    assert_eq!(kinds(&as_body(&open)), [(Kind::Holes, 1)]);
    let mut turned = ball.clone();
    turned.triangles[3].swap(1, 2);
    assert_eq!(kinds(&as_body(&turned)), [(Kind::Orientation, 1)]);
    let mut two = ball.clone();
    let count = ball.positions_m.len() as u32;
    let shift = |by: f64| ball.positions_m.iter().map(move |p| *p + DVec3::X * by);
    two.positions_m.extend(shift(2.0));
    let copies = ball.triangles.iter().map(|t| t.map(|node| node + count));
    two.triangles.extend(copies);
    assert_eq!(kinds(&as_body(&two)), []);
    two.positions_m.truncate(count as usize);
    two.positions_m.extend(shift(0.4));
    let found = kinds(&as_body(&two));
    assert!(
        matches!(found[..], [(Kind::SelfCrossing, 8..)]),
        "{found:?}"
    );
    // Open surfaces have wide mouths.
    let open = [
        crate::geometry::surfaces::disk(0.5, 0.1),
        crate::geometry::surfaces::cylinder(0.5, 1.0, false, 0.1),
    ];
    for surface in open {
        assert_eq!(kinds(&as_body(&surface)), []);
    }
}

/// The seam is joined and the sheet is the same but for its numbers; what the file names is found again.
#[test]
fn welding_makes_one_sheet_of_two() {
    let cut = with_seam(1e-4);
    let welded = weld(&cut, 2e-4).unwrap();
    assert_eq!((welded.joined, welded.collapsed), (5, 0));
    assert_eq!(welded.surface, sheet());
    assert_eq!(kinds(&examined(&welded.surface, &[0])), []);
    assert_eq!(welded.nodes[25..], [2, 7, 12, 17, 22].map(Some));
    assert_eq!(welded.numbers, (0..25).collect::<Vec<u32>>());
    let mut start = cut.positions_m.clone();
    start[26].z += 0.5;
    let (carried, apart) = welded.carried_over(&start);
    assert_eq!(carried, sheet().positions_m);
    let (vertices, apart_m) = apart.unwrap();
    assert_eq!(vertices, [7, 26]);
    assert!((apart_m - 0.5).abs() < 1e-6);
    // Less than the gap joins nothing and makes no slivers, along a seam with other vertices neither; numbers stay.
    let mut near = hung_halves();
    for place in &mut near.positions_m[15..] {
        place.y *= 1.0 + 1e-3;
    }
    let sewn = weld(&near, 1e-5).unwrap();
    assert_eq!([sewn.joined, sewn.inserted.len()], [1, 6]);
    let left = kinds(&examined(&sewn.surface, &[0]));
    assert!(left.contains(&(Kind::DoubledVertices, 2)), "{left:?}");
    assert_eq!(weld(&cut, 5e-5).unwrap(), Welded::untouched(cut.clone()));
}

/// A tolerance that would reach over edges, or through fabric upon fabric, does not.
#[test]
fn welding_keeps_edges_and_layers() {
    let sheet = sheet();
    let median = weld(&sheet, 0.03).unwrap_err();
    assert!(matches!(median, TooWide::Median { .. }), "{median:?}");
    // A short edge at a vertex that is joined counts, elsewhere it does not.
    let mut uneven = with_seam(0.015);
    uneven.positions_m[0].x = 0.21;
    assert!(weld(&uneven, 0.02).is_ok());
    uneven.positions_m[3].x = 0.555;
    let edge = weld(&uneven, 0.02).unwrap_err();
    assert!(matches!(edge, TooWide::Edge { .. }), "{edge:?}");
    assert!(weld(&uneven, edge.largest_m().unwrap()).is_ok());
    // A second layer 1 mm above, its border 0.2 m further in: nothing is on a border on both sides.
    let mut layers = sheet.clone();
    let above = |p: &DVec3| DVec3::new(0.5, 0.5, 1e-3) + (*p - DVec3::new(0.5, 0.5, 0.0)) * 0.5;
    layers
        .positions_m
        .extend(sheet.positions_m.iter().map(above));
    let copies = sheet.triangles.iter().map(|t| t.map(|node| node + 25));
    layers.triangles.extend(copies);
    let welded = weld(&layers, 2e-3).unwrap();
    // The border of the upper layer has eight vertices over ones of the lower layer, its inside but one.
    assert_eq!(welded.joined, 8);
    assert!(welded.nodes[37].is_some_and(|node| node != welded.nodes[12].unwrap()));
}

/// A triangle without width goes, with what it alone used.
#[test]
fn welding_drops_what_collapses() {
    let mut pole = sheet();
    pole.positions_m.push(DVec3::new(1e-9, 0.0, 0.0));
    pole.triangles.push([0, 25, 1]);
    let welded = weld(&pole, 1e-6).unwrap();
    assert_eq!((welded.joined, welded.collapsed), (1, 1));
    assert_eq!(welded.surface, sheet());
    assert_eq!(welded.nodes[25], Some(0));
}
