//! What holds for every canopy: areas, borders, quality, foldings that keep lengths, equal gores.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;

use super::designs::{Design, DesignFault, RadialSlots, Shape};
use super::pattern::PatternMesh;
use super::sewn::{self, Cut, Folding, LinePlaces};
use super::{crossings, pleats, shape};
use crate::cloth::openings::OpeningKind;
use crate::cloth::{Structure, Triangle, covers};

fn design(shape: Shape, gores: usize, vent_diameter_m: Option<f64>) -> Design {
    Design {
        nominal_area_m2: 0.78,
        gores,
        rings: 24,
        vent_diameter_m,
        shape,
    }
}

const fn cone(cone_angle_rad: f64) -> Shape {
    Shape::Conical {
        cone_angle_rad,
        slots: None,
    }
}

const fn slotted(width_m: f64) -> Shape {
    Shape::Conical {
        cone_angle_rad: 0.3,
        slots: Some(RadialSlots {
            count: 8,
            width_m,
            from_m: 0.15,
            to_m: 0.4,
        }),
    }
}

const EXTENDED: Shape = Shape::ExtendedSkirt {
    extension_ratio: 0.1,
    skirt_width_ratio: 0.9,
};

const BAND: Shape = Shape::DiskGapBand {
    disk_diameter_m: 0.72,
    gap_width_m: 0.043,
    band_width_m: 0.12,
};

const RINGS: Shape = Shape::Ringslot {
    slots: 4,
    slot_width_m: 0.02,
    tapes_per_gore: 3,
};

const CROSS: Shape = Shape::Cruciform {
    length_m: 1.2,
    width_m: 0.4,
    lines_per_end: 4,
};

/// Every design with its number of borders and the least shape quality of its triangles.
fn designs() -> Vec<(&'static str, Design, usize, f64)> {
    vec![
        ("flat with a vent", design(cone(0.0), 8, Some(0.1)), 2, 0.4),
        ("cone", design(cone(0.4), 12, None), 1, 0.1),
        ("cone with a vent", design(cone(0.4), 24, Some(0.1)), 2, 0.4),
        ("cuts", design(slotted(0.0), 24, Some(0.1)), 2 + 8, 0.4),
        ("slots", design(slotted(0.01), 24, Some(0.1)), 2 + 8, 0.4),
        ("extended skirt", design(EXTENDED, 12, Some(0.1)), 2, 0.4),
        ("annular", design(Shape::Annular, 12, Some(0.3)), 2, 0.5),
        ("disk-gap-band", design(BAND, 24, Some(0.2)), 2 + 2, 0.4),
        ("ringslot", design(RINGS, 16, Some(0.1)), 2 + 2 * 4, 0.4),
        (
            "cruciform",
            Design {
                nominal_area_m2: 0.8,
                ..design(CROSS, 4, None)
            },
            1,
            0.4,
        ),
    ]
}

fn mesh_of(design: &Design) -> PatternMesh {
    design.pattern().unwrap().mesh()
}

fn area(corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = *corners;
    0.5 * (b - a).cross(c - a).z
}

#[test]
fn areas_are_those_of_the_constructed_canopies() {
    for (name, design, ..) in designs() {
        let mesh = mesh_of(&design);
        let fabric: f64 = mesh.rest_m.iter().map(area).sum();
        assert!(
            mesh.rest_m.iter().all(|corners| area(corners) > 0.0),
            "{name}"
        );
        let pattern = design.pattern().unwrap();
        assert!((fabric - pattern.fabric_area_m2()).abs() < 1e-12, "{name}");
        let vent = design.vent_diameter_m.map_or(0.0, |d| 0.25 * PI * d * d);
        let expected = match design.shape {
            // The vent of a cone is cut from its slope.
            Shape::Conical {
                cone_angle_rad,
                slots,
            } => {
                let slots = slots.map_or(0.0, |slots| {
                    // They close over half a ring at either end.
                    let rows: Vec<f64> = (mesh.rows.iter().map(|row| row.at.distance_m))
                        .filter(|s| (slots.from_m..=slots.to_m).contains(s))
                        .collect();
                    let n = rows.len();
                    let open = [0.5 * (rows[0] + rows[1]), 0.5 * (rows[n - 2] + rows[n - 1])];
                    8.0 * slots.width_m * (open[1] - open[0])
                });
                design.nominal_area_m2 - vent / cone_angle_rad.cos() - slots
            }
            Shape::Annular => design.nominal_area_m2,
            Shape::Ringslot {
                slots,
                slot_width_m,
                ..
            } => {
                // Trapezoids, as long as the slots' middles are around the apex.
                let slope = (PI / 16.0).tan();
                let reach = |area: f64| (area / (16.0 * slope)).sqrt();
                let [start, end] = [vent, design.nominal_area_m2].map(reach);
                let ring = (end - start - slots as f64 * slot_width_m) / (slots + 1) as f64;
                let middle =
                    |k: usize| start + (k + 1) as f64 * (ring + slot_width_m) - 0.5 * slot_width_m;
                let around: f64 = (0..slots).map(|k| 32.0 * slope * middle(k)).sum();
                design.nominal_area_m2 - vent - slot_width_m * around
            }
            Shape::DiskGapBand {
                disk_diameter_m: d,
                band_width_m,
                ..
            } => {
                let around = d * (PI * 24.0 * (PI / 24.0).tan()).sqrt();
                0.25 * PI * d * d + around * band_width_m - vent
            }
            _ => design.nominal_area_m2 - vent,
        };
        assert!(
            (fabric / expected - 1.0).abs() < 1e-12,
            "{name}: {fabric} of {expected}"
        );
    }
}

/// Loops of edges that only one triangle has.
fn borders(mesh: &PatternMesh) -> usize {
    let mut uses: HashMap<[u32; 2], i32> = HashMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let used = uses.entry([a.min(b), a.max(b)]).or_insert(0);
            // An inner edge is run along once in either direction.
            *used += if a < b { 1 } else { 16 };
        }
    }
    assert!(
        uses.values().all(|&n| n == 17 || n == 1 || n == 16),
        "not a surface"
    );
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    for (edge, _) in uses.iter().filter(|&(_, &n)| n != 17) {
        next.entry(edge[0]).or_default().push(edge[1]);
        next.entry(edge[1]).or_default().push(edge[0]);
    }
    assert!(next.values().all(|ends| ends.len() == 2), "borders touch");
    let mut loops = 0;
    while let Some(&start) = next.keys().min() {
        loops += 1;
        let mut ahead = vec![start];
        while let Some(node) = ahead.pop() {
            ahead.extend(next.remove(&node).unwrap_or_default());
        }
    }
    loops
}

#[test]
fn meshes_are_surfaces_with_the_borders_of_their_openings() {
    for (name, design, expected, _) in designs() {
        let mesh = mesh_of(&design);
        assert_eq!(borders(&mesh), expected, "{name}");
        let rims: usize = mesh.openings.iter().map(|o| o.rim.len()).sum();
        let edges = mesh
            .skirt
            .iter()
            .map(|path| path.rest_m.len())
            .sum::<usize>();
        let border = {
            let mut uses: HashMap<[u32; 2], i32> = HashMap::new();
            for t in &mesh.triangles {
                for k in 0..3 {
                    let (a, b) = (t[k], t[(k + 1) % 3]);
                    *uses.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
                }
            }
            for edge in mesh.openings.iter().flat_map(|o| &o.rim) {
                let key = [edge[0].min(edge[1]), edge[0].max(edge[1])];
                assert_eq!(
                    uses.get(&key),
                    Some(&1),
                    "{name}: an inner edge bounds an opening"
                );
            }
            uses.values().filter(|&&n| n == 1).count()
        };
        // What bounds no opening is the skirt, and the sides of arms.
        let sides = if design.shape == CROSS {
            let rings = design.pattern().unwrap().sections[1].rings;
            8 * rings
        } else {
            0
        };
        assert_eq!(rims + edges + sides, border, "{name}");
    }
}

#[test]
fn openings_are_as_wide_as_constructed() {
    let widths = |shape, gores, vent| -> Vec<(OpeningKind, f64)> {
        let mesh = mesh_of(&design(shape, gores, vent));
        mesh.openings.iter().map(|o| (o.kind, o.width_m)).collect()
    };
    let band = widths(BAND, 24, Some(0.2));
    assert_eq!(band.len(), 2);
    assert_eq!(band[0].0, OpeningKind::Vent);
    assert!((band[0].1 / 0.2 - 1.0).abs() < 0.005, "{band:?}");
    assert!(band[1].0 == OpeningKind::Gap && (band[1].1 - 0.043).abs() < 1e-12);
    let rings = widths(RINGS, 16, Some(0.1));
    assert_eq!(rings.len(), 1 + 4);
    for (kind, width_m) in &rings[1..] {
        assert!(*kind == OpeningKind::Gap && (width_m - 0.02).abs() < 1e-12);
    }
    let slots = widths(slotted(0.01), 24, None);
    assert_eq!(slots, [(OpeningKind::Slot, 0.01); 8]);
    assert!(widths(cone(0.0), 8, None).is_empty());
}

#[test]
fn triangles_are_well_shaped() {
    for (name, design, _, least) in designs() {
        let mesh = mesh_of(&design);
        let corners = mesh.rest_m.iter().copied();
        let quality = crate::geometry::mesh::quality::measure_corners(corners).unwrap();
        assert!(quality.smallest_shape > least, "{name}: {quality:?}");
        assert!(quality.mean_shape > 0.75, "{name}: {quality:?}");
    }
}

/// Largest relative change of an edge's length.
fn strain(mesh: &PatternMesh, positions_m: &[DVec3]) -> f64 {
    let mut largest: f64 = 0.0;
    for (t, rest) in mesh.triangles.iter().zip(&mesh.rest_m) {
        for k in 0..3 {
            let n = (k + 1) % 3;
            let now = positions_m[t[k] as usize].distance(positions_m[t[n] as usize]);
            largest = largest.max((now / rest[k].distance(rest[n]) - 1.0).abs());
        }
    }
    largest
}

#[test]
fn foldings_keep_lengths_and_reach_their_ratio() {
    for (name, design, ..) in designs() {
        let mesh = mesh_of(&design);
        let pattern = design.pattern().unwrap();
        for (ratio, asymmetry) in [(0.15, 0.0), (0.3, 0.0), (0.15, 0.4)] {
            let target = ratio * ratio * design.nominal_area_m2;
            let folded = pleats::pleat(&pattern, &mesh, target, asymmetry)
                .unwrap_or_else(|| panic!("{name} cannot be folded to {ratio}, {asymmetry}"));
            let allowed = if design.shape == EXTENDED { 0.02 } else { 1e-9 };
            let strain = strain(&mesh, &folded);
            assert!(strain < allowed, "{name} {ratio} {asymmetry}: {strain:e}");
            let triangles = mesh.triangles.iter().copied();
            let reached =
                shape::projected_diameter_m(&folded, triangles) / design.nominal_diameter_m();
            // Slots around the canopy cast no shadow.
            let vent = design.vent_diameter_m.map_or(0.0, |d| 0.25 * PI * d * d);
            let expected = if design.shape == RINGS {
                ratio * (pattern.fabric_area_m2() / (design.nominal_area_m2 - vent)).sqrt()
            } else {
                ratio
            };
            assert!(
                (reached / expected - 1.0).abs() < 0.1,
                "{name} {ratio}: {reached}"
            );
            // The apex is downstream of the skirt.
            let skirt = mesh.skirt[0].nodes[0] as usize;
            assert!(folded[0].x > folded[skirt].x, "{name}");
        }
    }
}

/// Lines over the gap are slack or straight where a canopy is folded, never stretched; so are vent lines.
#[test]
fn lines_within_a_folded_canopy_are_not_stretched() {
    for (shape, gores) in [(BAND, 24), (RINGS, 24)] {
        lines_within_are_not_stretched(shape, gores);
    }
}

fn lines_within_are_not_stretched(shape: Shape, gores: usize) {
    let design = design(shape, gores, Some(0.2));
    let pattern = design.pattern().unwrap();
    let folding = Folding {
        diameter_ratio: 0.15,
        asymmetry: 0.3,
    };
    let cut = Cut::Gores(design, pattern);
    let sewn = sewn::sew(&cut, LinePlaces::SeamsAndCentres, &folding).unwrap();
    assert_eq!(sewn.radials.len(), 48);
    let place = |node: u32| sewn.positions_m[node as usize];
    let mut straight = 0;
    for gap in sewn.radials.iter().flat_map(|radial| &radial.gaps) {
        let ratio = place(gap.nodes[0]).distance(place(gap.nodes[1])) / gap.rest_m[0];
        assert!(ratio < 1.0 + 1e-12, "{ratio}");
        straight += usize::from(ratio > 0.999);
    }
    assert!(straight >= 24, "{straight} lines span the gap");
    let vent = sewn.vent_lines.unwrap();
    assert_eq!(vent.ends.len(), 24);
    assert!(
        (vent.length_m / 0.2 - 1.0).abs() < 0.02,
        "{}",
        vent.length_m
    );
    for k in 0..12 {
        assert!(place(vent.ends[k]).distance(place(vent.ends[k + 12])) < vent.length_m);
    }
}

#[test]
fn impossible_designs_are_refused() {
    let fault = |shape, vent| design(shape, 24, vent).pattern().unwrap_err();
    assert!(matches!(fault(cone(0.0), Some(0.95)), DesignFault::Vent(_)));
    assert!(matches!(
        fault(slotted(0.04), None),
        DesignFault::SlotWidth(_)
    ));
    assert!(matches!(
        fault(slotted(0.0), Some(0.4)),
        DesignFault::Slots(..)
    ));
    assert!(matches!(
        fault(
            Shape::Ringslot {
                slots: 8,
                slot_width_m: 0.04,
                tapes_per_gore: 0,
            },
            Some(0.1)
        ),
        DesignFault::RingWidth(_)
    ));
    assert!(matches!(
        fault(Shape::Annular, Some(50.0)),
        DesignFault::Vent(_)
    ));
}

/// Tapes lie over every slot between the seams, alike in both halves of a gore, and none twice; they hardly slant.
#[test]
fn tapes_cross_slots() {
    for (rings, wanted) in [(20, 1), (20, 2), (20, 3), (26, 3), (31, 3), (40, 9)] {
        let shape = Shape::Ringslot {
            slots: 4,
            slot_width_m: 0.02,
            tapes_per_gore: wanted,
        };
        let design = Design {
            rings,
            ..design(shape, 16, Some(0.1))
        };
        let mesh = mesh_of(&design);
        let gaps = mesh.rows.iter().skip(1).filter(|row| row.begins).count();
        assert_eq!(gaps, 4);
        let mut most = 0;
        for gore in 0..16 {
            let tapes = crossings::tapes(&mesh, gore, wanted);
            let mut by_gap: Vec<Vec<[f64; 2]>> = vec![Vec::new(); mesh.rows.len()];
            for tape in &tapes {
                let [from, to] = [0, 1].map(|end| mesh.places[tape.nodes[end] as usize]);
                assert!(mesh.rows[to.row].begins && to.row == from.row + 1);
                let across = [from.across, to.across];
                assert!(across.iter().all(|place| place.abs() < 1.0 - 1e-9));
                let row = mesh.rows[to.row];
                assert!((across[0] - across[1]).abs() <= 0.5 / row.segments as f64 + 1e-9);
                assert!(tape.rest_m[0] > 0.02 - 1e-12);
                by_gap[to.row].push(across);
            }
            for mut places in by_gap {
                most = most.max(places.len());
                assert!(places.len() <= wanted);
                let sort = |places: &mut Vec<[f64; 2]>| {
                    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
                };
                let mut mirrored: Vec<[f64; 2]> =
                    places.iter().map(|ends| ends.map(|place| -place)).collect();
                sort(&mut places);
                sort(&mut mirrored);
                for (place, other) in places.iter().zip(&mirrored) {
                    assert!((0..2).all(|end| (place[end] - other[end]).abs() < 1e-12));
                }
                assert!(places.windows(2).all(|pair| pair[0] != pair[1]));
            }
        }
        assert!(most + 1 >= wanted.min(3), "{rings} {wanted}: {most}");
    }
}

/// Covers shut every opening but the mouth: with them each edge of a rim lies between two triangles that are turned alike.
#[test]
fn covers_shut_openings() {
    for (name, design, ..) in designs() {
        let cut = Cut::Gores(design, design.pattern().unwrap());
        let lines = match design.shape {
            Shape::Cruciform { .. } => LinePlaces::Ends(4),
            _ => LinePlaces::Seams,
        };
        let folding = Folding {
            diameter_ratio: 0.6,
            asymmetry: 0.0,
        };
        let sewn = sewn::sew(&cut, lines, &folding).unwrap();
        let triangle = |(nodes, rest_m): (&[u32; 3], &[DVec3; 3])| {
            Triangle::new(*nodes, rest_m.map(|corner| corner.truncate())).unwrap()
        };
        let mut structure = Structure {
            triangles: sewn
                .triangles
                .iter()
                .zip(&sewn.rest_m)
                .map(triangle)
                .collect(),
            positions_m: sewn.positions_m.clone(),
            ..Structure::default()
        };
        structure.openings.clone_from(&sewn.openings);
        let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
        let mut add = |nodes: [u32; 3]| {
            for k in 0..3 {
                *edges.entry([nodes[k], nodes[(k + 1) % 3]]).or_default() += 1;
            }
        };
        sewn.triangles.iter().for_each(|nodes| add(*nodes));
        let all = covers::covers(&structure, structure.openings.iter());
        for (opening, covers) in structure.openings.iter().zip(all) {
            let covers = covers.unwrap();
            let loops = if opening.kind == OpeningKind::Gap {
                2
            } else {
                1
            };
            let less = if loops == 2 { 0 } else { 2 };
            assert_eq!(covers.len(), opening.rim.len() - less, "{name}");
            for cover in covers {
                add(cover.nodes);
                for (node, (triangle, corner)) in cover.nodes.into_iter().zip(cover.at) {
                    let of = structure.triangles[triangle as usize].nodes;
                    assert_eq!(of[usize::from(corner)], node);
                }
            }
        }
        for opening in &structure.openings {
            for [a, b] in &opening.rim {
                let both = [[*a, *b], [*b, *a]].map(|edge| edges.get(&edge));
                assert_eq!(both, [Some(&1); 2], "{name}, {:?}", opening.kind);
            }
        }
    }
}
