use super::*;
use crate::cloth::Triangle;
use crate::lines::Cable;

const SIDES: u32 = 24;

/// Nodes of rings round the x axis, `SIDES` each, at (x, radius).
fn rings(places: &[(f64, f64)]) -> Vec<DVec3> {
    let node = |&(x, radius): &(f64, f64)| {
        (0..SIDES).map(move |k| {
            let angle = TAU * f64::from(k) / f64::from(SIDES);
            DVec3::new(x, radius * angle.cos(), radius * angle.sin())
        })
    };
    places.iter().flat_map(node).collect()
}

/// Triangles between rings `inner` and `inner + 1`, without the quadrilaterals that `left_out` names.
fn band(inner: u32, left_out: &[u32]) -> Vec<[u32; 3]> {
    (0..SIDES)
        .filter(|k| !left_out.contains(k))
        .flat_map(|k| {
            let next = (k + 1) % SIDES;
            let [a, b] = [k, next].map(|n| inner * SIDES + n);
            let [c, d] = [k, next].map(|n| (inner + 1) * SIDES + n);
            [[a, c, d], [a, d, b]]
        })
        .collect()
}

/// A disk with a vent, a gap and a band, eight lines of two segments each that go on across the gap, and one slot in the disk.
fn disk_gap_band(turned: bool) -> (Structure, Canopy) {
    let mut positions_m = rings(&[(1.0, 0.1), (1.0, 0.5), (1.0, 1.0), (0.9, 1.0), (0.6, 1.0)]);
    let fabric = positions_m.len();
    let confluence = positions_m.len() as u32;
    positions_m.push(DVec3::new(-2.0, 0.0, 0.0));
    let mut triangles = band(0, &[]);
    triangles.extend(band(1, &[5]));
    triangles.extend(band(3, &[]));
    let mut structure = Structure {
        positions_m,
        triangles: triangles
            .iter()
            .map(|nodes| {
                Triangle::laid_out(
                    *nodes,
                    [DVec3::ZERO, DVec3::Y, DVec3::Z],
                    DVec3::Y,
                    [0.0; 2],
                )
                .unwrap()
            })
            .collect(),
        ..Structure::default()
    };
    structure.masses_kg = vec![0.0; structure.node_count()];
    let cable = Cable::linear(1e-6, 1000.0, 1e9);
    for k in (0..SIDES).step_by(3) {
        let (skirt, upper, disk) = (4 * SIDES + k, 3 * SIDES + k, 2 * SIDES + k);
        let middle = structure.positions_m.len() as u32;
        let at = 0.5 * (structure.positions_m[skirt as usize] + DVec3::new(-2.0, 0.0, 0.0));
        structure.positions_m.push(at);
        structure.masses_kg.push(0.0);
        structure.add_cable(
            &[disk, upper, skirt],
            &[0.1, 0.3],
            &cable,
            CableKind::SuspensionLine,
        );
        structure.add_cable(
            &[skirt, middle, confluence],
            &[1.0, 1.0],
            &cable,
            CableKind::SuspensionLine,
        );
    }
    if turned {
        let turn = glam::DQuat::from_rotation_z(0.3);
        for place in &mut structure.positions_m {
            *place = turn * *place;
        }
    }
    let canopy = Canopy {
        nominal_area_m2: PI,
        nominal_diameter_m: 2.0,
        canopy_node_count: fabric,
        lower_end: fabric,
        apex_count: 1,
        opened_diameter_ratio: 0.5,
        loading_pressure_pa: 10.0,
    };
    (structure, canopy)
}

#[test]
fn a_disk_gap_band_with_a_slot_has_all_its_parts() {
    for turned in [false, true] {
        let (structure, canopy) = disk_gap_band(turned);
        let outline = Outline::new(&structure, &canopy);
        let ring = |nodes: &[u32]| -> Option<u32> {
            let first = nodes.first()? / SIDES;
            (nodes.len() == SIDES as usize && nodes.iter().all(|n| n / SIDES == first))
                .then_some(first)
        };
        assert_eq!(ring(&outline.skirt), Some(4));
        assert_eq!(ring(&outline.vent), Some(0));
        assert_eq!(outline.gaps.len(), 1);
        assert_eq!(ring(&outline.gaps[0][0]), Some(3));
        // The slot opens into the gap: its border is part of the disk's.
        assert_eq!(outline.gaps[0][1].len(), SIDES as usize + 2);
        assert_eq!(outline.lines.len(), 8);
        for (k, line) in outline.lines.iter().enumerate() {
            assert_eq!(line.attachment, 4 * SIDES + 3 * k as u32);
            assert_eq!((line.lower.len(), line.upper.len()), (2, 2));
        }
        assert_eq!(outline.gores.len(), 8);
        for (k, gore) in outline.gores.iter().enumerate() {
            assert_eq!(gore.len(), 4);
            assert_eq!(gore[0], outline.lines[k].attachment);
            assert_eq!(gore[3], outline.lines[(k + 1) % 8].attachment);
        }
        let apex = outline.apex(&structure.positions_m);
        let expected = structure.positions_m[..SIDES as usize]
            .iter()
            .sum::<DVec3>();
        assert!(apex.distance(expected / f64::from(SIDES)) < 1e-12);
        assert_eq!(outline.at_vent.len(), 2 * SIDES as usize);
    }
}

/// A square hole in the fabric does not run round the axis.
#[test]
fn a_hole_beside_the_axis_is_a_slot() {
    let positions_m = rings(&[(1.0, 0.2), (1.0, 0.5), (1.0, 0.7), (0.8, 1.0)]);
    let mut triangles = band(0, &[]);
    triangles.extend(band(1, &[7]));
    triangles.extend(band(2, &[]));
    let loops = border_loops(&triangles);
    assert_eq!(loops.len(), 3);
    let axis = Axis::new(DVec3::ZERO, DVec3::X);
    let mut turns: Vec<(usize, i64)> = loops
        .iter()
        .map(|border| {
            let places: Vec<DVec3> = border.iter().map(|&n| positions_m[n as usize]).collect();
            (border.len(), axis.turns(&places).abs())
        })
        .collect();
    turns.sort_unstable();
    assert_eq!(turns, [(4, 0), (SIDES as usize, 1), (SIDES as usize, 1)]);
}

/// Two holes that touch at a node are two loops.
#[test]
fn loops_that_touch_are_cut_there() {
    let mut triangles = band(0, &[]);
    triangles.extend(band(1, &[7]));
    triangles.extend(band(2, &[8]));
    triangles.extend(band(3, &[]));
    let mut lengths: Vec<usize> = border_loops(&triangles).iter().map(Vec::len).collect();
    lengths.sort_unstable();
    assert_eq!(lengths, [4, 4, SIDES as usize, SIDES as usize]);
}
