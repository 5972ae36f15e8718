//! Wings as they are built: sizes against exact values, seams, symmetry, closed cells, rods.

use std::collections::HashMap;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices};
use ripstop::fabric::Fabric;
use ripstop::geometry::wing::frames::Station;
use ripstop::geometry::wing::plan::{Fineness, Intakes, PartFabrics, Plan, Rod};
use ripstop::geometry::wing::pressure::{Distribution, jumps_pa};
use ripstop::geometry::wing::section::{Profile, Side};
use ripstop::geometry::wing::{BuiltWing, Part, build};
use ripstop::rigid::Surface;

use crate::command_line::root;
use crate::engines::plain;
use crate::tolerances::wing_design as tolerance;

pub fn trials() -> Vec<Trial> {
    [
        plain("wing::sizes_are_exact", sizes),
        plain("wing::an_ellipse_has_its_area", ellipse),
        plain("wing::panels_have_their_width", ballooning),
        plain("wing::seams_hold", seams),
        plain("wing::halves_are_mirror_images", symmetry),
        plain("wing::a_closed_cell_pulls_nowhere", closed_cells),
        plain("wing::rods_follow_the_outline", rods),
    ]
    .into_iter()
    .flatten()
    .collect()
}

pub const FABRIC: Fabric = Fabric {
    thickness_m: 5e-5,
    density_kg_m3: 760.0,
    warp_modulus_pa: 6e8,
    weft_modulus_pa: 6e8,
    poisson_ratio: 0.15,
    shear_modulus_pa: 8e7,
    cubic_shear_compliance_1_pa3: None,
    residual_stiffness: 1e-3,
    initial_strain: [0.0; 2],
    yield_stress_pa: None,
};

pub const FINENESS: Fineness = Fineness {
    along_chord: 16,
    across_cell: 4,
};

/// Without lines, holes or intakes.
pub fn plan(stations: Vec<Station>, cells: usize) -> Plan {
    Plan {
        profiles: vec![Profile::naca("2415").unwrap()],
        stations,
        cells,
        tip_cell_width_ratio: 1.0,
        rib_places_m: None,
        ballooning: [Vec::new(), Vec::new()],
        intakes: None,
        holes: Vec::new(),
        mini_ribs_from: None,
        rows: Vec::new(),
        tapes: Vec::new(),
        rods: Vec::new(),
        vh_ribs: Vec::new(),
        hang_point_m: DVec3::new(0.3, 0.2, -5.0),
        pitch_guide_n_m: None,
        fabrics: PartFabrics {
            upper: FABRIC,
            lower: FABRIC,
            ribs: FABRIC,
            diagonals: FABRIC,
        },
    }
}

pub fn station(span_m: f64, chord_m: f64, roll_deg: f64) -> Station {
    Station {
        span_m,
        chord_m,
        sweep_m: 0.0,
        roll_rad: f64::to_radians(roll_deg),
        twist_rad: 0.0,
        profile: 0,
    }
}

/// Panels and tip ribs.
fn skin(wing: &BuiltWing) -> Surface {
    let triangles = wing.structure.triangles.iter().zip(&wing.tags);
    let triangles = triangles.filter_map(|(triangle, tag)| {
        let [a, b, c] = triangle.nodes;
        match tag.part {
            Part::Upper | Part::Lower => Some([a, b, c]),
            // Normals of ribs point to the right.
            Part::Rib if tag.number == 0 => Some([a, c, b]),
            Part::Rib if tag.number as usize == wing.cells => Some([a, b, c]),
            _ => None,
        }
    });
    Surface {
        positions_m: wing.structure.positions_m.clone(),
        triangles: triangles.collect(),
    }
}

fn sizes() {
    for cells in [6, 7] {
        let wing = build(
            &plan(vec![station(0.0, 2.0, 0.0), station(3.0, 1.0, 0.0)], cells),
            FINENESS,
        )
        .unwrap();
        let measures = &wing.measures;
        assert!((measures.flat_span_m - 6.0).abs() < 1e-12);
        // A trapezium: with an odd number of cells its middle is cut off between the two inner ribs.
        let cut = if cells == 7 {
            0.5 * (6.0 / 7.0) * (6.0 / 14.0) / 3.0
        } else {
            0.0
        };
        assert!(
            (measures.flat_area_m2 - (9.0 - cut)).abs() < 1e-9,
            "{}",
            measures.flat_area_m2
        );
        assert!((measures.projected_area_m2 - measures.flat_area_m2).abs() < 1e-9);
        let surface = skin(&wing);
        assert!(surface.is_closed());
    }
    // A rectangle encloses section times span, with the section's polygon.
    let wing = build(
        &plan(vec![station(0.0, 2.0, 0.0), station(3.0, 2.0, 0.0)], 6),
        FINENESS,
    )
    .unwrap();
    let (volume, _) = skin(&wing).volume_m3();
    assert!((volume / wing.measures.section_volume_m3 - 1.0).abs() < 1e-12);
    // NACA four digits of thickness t enclose 0.6810 t c² with a closed trailing edge; the polygon lies inside.
    let exact = 0.6810 * 0.15 * 4.0 * 6.0;
    assert!((volume / exact - 1.0).abs() < 0.02, "{volume} {exact}");
    // Rolled evenly to 60° the span seen from above is that of the arc, 2 sin 60° / (π/3) of the flat half.
    let wing = build(
        &plan(vec![station(0.0, 2.0, 0.0), station(3.0, 2.0, 60.0)], 30),
        FINENESS,
    )
    .unwrap();
    let expected = 6.0 * 60f64.to_radians().sin() / 60f64.to_radians();
    assert!((wing.measures.projected_span_m / expected - 1.0).abs() < 1e-6);
    assert!((wing.measures.flat_area_m2 - 12.0).abs() < 1e-9);
    assert!((wing.measures.projected_area_m2 / (2.0 * expected) - 1.0).abs() < 1e-6);
}

/// Rods around the nose of some ribs: their mass is that of their length, their energy ½ E I ∫ κ² ds of the profile.
fn rods() {
    let (chord, rigidity, heaviness) = (2.0, 0.004, 0.005);
    let stations = || vec![station(0.0, chord, 0.0), station(3.0, chord, 0.0)];
    let fine = Fineness {
        along_chord: 120,
        across_cell: 2,
    };
    let without = build(&plan(stations(), 6), fine).unwrap();
    let mut with_rods = plan(stations(), 6);
    with_rods.rods = vec![Rod {
        name: "nose".to_owned(),
        sides: [Some([0.0, 0.12]), Some([0.0, 0.08])],
        flexural_rigidity_nm2: rigidity,
        mass_per_length_kg_m: heaviness,
        ribs: vec![0, 2],
    }];
    let wing = build(&with_rods, fine).unwrap();
    // The outline from the end below to that above, evenly in √(x/c).
    let profile = Profile::naca("2415").unwrap();
    let point = |u: f64| {
        let side = if u < 0.0 { Side::Lower } else { Side::Upper };
        let x = u * u;
        chord * DVec3::new(x, 0.0, profile.height(side, x))
    };
    let ends = [
        -wing.places.lower[wing.places.nearest(Side::Lower, 0.08)].sqrt(),
        wing.places.upper[wing.places.nearest(Side::Upper, 0.12)].sqrt(),
    ];
    let count = 4000;
    let places: Vec<DVec3> = (0..=count)
        .map(|i| point(ends[0] + (ends[1] - ends[0]) * f64::from(i) / f64::from(count)))
        .collect();
    let (mut length, mut energy) = (0.0, 0.0);
    for pair in places.windows(2) {
        length += pair[0].distance(pair[1]);
    }
    for three in places.windows(3) {
        let [a, b] = [three[1] - three[0], three[2] - three[1]];
        let along = 0.5 * (a.length() + b.length());
        let curvature = (b.normalize() - a.normalize()).length() / along;
        energy += 0.5 * rigidity * curvature * curvature * along;
    }
    let mass = |wing: &BuiltWing| wing.structure.masses_kg.iter().sum::<f64>();
    // Rib 0 in the middle, rib 2 on both halves.
    let added = mass(&wing) - mass(&without);
    assert!(
        (added / (3.0 * heaviness * length) - 1.0).abs() < tolerance::ROD_LENGTH,
        "{added} kg, {length} m"
    );
    let positions = &wing.structure.positions_m;
    let stored: f64 = (wing.structure.bendings.iter())
        .map(|bending| {
            let terms = bending.nodes.iter().zip(bending.coefficients);
            let sum: DVec3 = terms.map(|(node, c)| positions[*node as usize] * c).sum();
            0.5 * bending.stiffness_n_m * sum.length_squared()
        })
        .sum();
    assert!(
        (stored / (3.0 * energy) - 1.0).abs() < tolerance::ROD_ENERGY,
        "{stored} {energy} J"
    );
}

fn ellipse() {
    let (half_span, chord) = (6.0, 2.5);
    let stations = (0..=40)
        .map(|i| {
            // Denser towards the tip, which is blunt.
            let share = (f64::from(i) / 40.0 * std::f64::consts::FRAC_PI_2).sin();
            station(
                share * half_span,
                chord * (1.0 - share * share).sqrt().max(0.02),
                0.0,
            )
        })
        .collect();
    let wing = build(&plan(stations, 80), FINENESS).unwrap();
    let exact = std::f64::consts::FRAC_PI_2 * half_span * chord;
    let found = wing.measures.flat_area_m2;
    assert!((found / exact - 1.0).abs() < 4e-3, "{found} {exact}");
    let ratio = wing.measures.flat_aspect_ratio();
    assert!((ratio / (144.0 / exact) - 1.0).abs() < 4e-3);
}

/// Across a cell the rest lengths add up to a polygon in an arc of the width asked for.
fn ballooning() {
    let extra = 0.08;
    let mut plan = plan(vec![station(0.0, 2.0, 0.0), station(3.0, 2.0, 0.0)], 6);
    plan.ballooning = [
        vec![[0.0, extra], [1.0, extra]],
        vec![[0.0, 0.5 * extra], [1.0, 0.5 * extra]],
    ];
    let wing = build(&plan, FINENESS).unwrap();
    // θ/sin θ = 1 + b by bisection.
    let half_angle = |b: f64| {
        let (mut low, mut high) = (1e-9, 3.0);
        for _ in 0..200 {
            let middle: f64 = 0.5 * (low + high);
            if middle / middle.sin() < 1.0 + b {
                low = middle
            } else {
                high = middle
            }
        }
        low
    };
    for (part, b) in [(Part::Upper, extra), (Part::Lower, 0.5 * extra)] {
        let angle = half_angle(b);
        let edges = 4.0;
        let expected = edges * (angle / edges).sin() / angle.sin();
        // Edges across the cell, 1 m wide, away from nose and trailing edge; those along the chord and the diagonals reach farther in x.
        let mut lengths: HashMap<[u32; 2], f64> = HashMap::new();
        let triangles = wing.structure.triangles.iter().zip(&wing.tags);
        for (triangle, _) in triangles.filter(|(_, tag)| tag.part == part && tag.number == 2) {
            let places = triangle
                .nodes
                .map(|n| wing.structure.positions_m[n as usize]);
            for i in 0..3 {
                let (from, to) = ((i + 1) % 3, (i + 2) % 3);
                let edge = places[to] - places[from];
                let x = 0.5 * (places[to].x + places[from].x);
                if edge.x.abs() < 0.03 && (0.6..1.7).contains(&x) {
                    let nodes = [triangle.nodes[from], triangle.nodes[to]];
                    let key = [nodes[0].min(nodes[1]), nodes[0].max(nodes[1])];
                    lengths.insert(key, triangle.rest_squares_m2[i].sqrt());
                }
            }
        }
        assert!(lengths.len() >= 16, "{part:?}: {} edges", lengths.len());
        for length in lengths.values() {
            let error = length * edges / expected - 1.0;
            assert!(error.abs() < 1e-9, "{part:?}: {length} {expected}");
        }
    }
}

/// The shipped school wing, coarse.
fn school() -> (BuiltWing, case::Case) {
    let path = root().join("cases/wing-school.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: Vec::new(),
    };
    let case = case::parse("school", &text, root(), &choices).unwrap();
    let mut wing = case.scene.wing().unwrap().built.clone();
    wing.structure = case.scene.body.as_ref().unwrap().structure.clone();
    (wing, case)
}

fn edges(triangles: impl Iterator<Item = [u32; 3]>) -> HashMap<[u32; 2], usize> {
    let mut uses = HashMap::new();
    for t in triangles {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            *uses.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        }
    }
    uses
}

/// Panels and tip ribs have no open edges but at the intakes; ribs meet panels along their whole outline; no node stands twice or is idle.
fn seams() {
    let (wing, _) = school();
    let of = |is: &dyn Fn(Part, u32) -> bool| {
        let triangles = wing.structure.triangles.iter().zip(&wing.tags);
        edges(
            triangles
                .filter(|(_, tag)| is(tag.part, tag.number))
                .map(|(t, _)| t.nodes)
                .collect::<Vec<_>>()
                .into_iter(),
        )
    };
    let skin = edges(skin(&wing).triangles.into_iter());
    assert!(skin.values().all(|n| *n <= 2));
    // 26 open cells in a row, with two edges across each of their two rims, and one edge along the rib at either end.
    let open = skin.values().filter(|n| **n == 1).count();
    assert_eq!(open, 26 * 2 * 2 + 2);
    // Every rib's outline: edges that one of its own triangles has, and those belong to panels unless an intake is on both sides.
    for rib in 1..wing.cells as u32 {
        let own = of(&|part, number| part == Part::Rib && number == rib);
        let panels = of(&|part, number| {
            matches!(part, Part::Upper | Part::Lower) && (number == rib || number + 1 == rib)
        });
        let outline = own.iter().filter(|(_, n)| **n == 1).map(|(e, _)| *e);
        let sewn = outline.filter(|e| panels.get(e) == Some(&2)).count();
        // 24 edges around, one or two of which lie in the intakes.
        assert!(
            (22..=24).contains(&sewn),
            "rib {rib}: {sewn} edges sewn to both cells"
        );
    }
    let mut sorted: Vec<DVec3> = wing.structure.positions_m.clone();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x));
    for (i, a) in sorted.iter().enumerate() {
        let near = sorted[i + 1..].iter().take_while(|b| b.x - a.x < 1e-6);
        for b in near {
            assert!(a.distance(*b) > 1e-6, "two nodes at {a}");
        }
    }
    let mut used = vec![false; wing.structure.node_count()];
    for node in wing.structure.triangles.iter().flat_map(|t| t.nodes) {
        used[node as usize] = true;
    }
    for node in wing.structure.cables.iter().flat_map(|c| c.nodes) {
        used[node as usize] = true;
    }
    assert!(used.iter().all(|u| *u));
}

fn symmetry() {
    let (wing, _) = school();
    let structure = &wing.structure;
    let quantum = |p: DVec3| [p.x, p.y, p.z].map(|c| (c * 1e7).round() as i64);
    let nodes: HashMap<[i64; 3], usize> = structure
        .positions_m
        .iter()
        .enumerate()
        .map(|(i, p)| (quantum(*p), i))
        .collect();
    let mirror: Vec<u32> = structure
        .positions_m
        .iter()
        .map(|p| {
            let key = quantum(DVec3::new(p.x, -p.y, p.z));
            let near = |d: i64| [key[0], key[1] + d, key[2]];
            let found = [0, 1, -1].iter().find_map(|d| nodes.get(&near(*d)));
            *found.unwrap_or_else(|| panic!("no mirror image of {p}")) as u32
        })
        .collect();
    let sorted = |mut nodes: [u32; 3]| {
        nodes.sort_unstable();
        nodes
    };
    let triangles: std::collections::HashSet<[u32; 3]> = structure
        .triangles
        .iter()
        .map(|t| sorted(t.nodes))
        .collect();
    for triangle in &structure.triangles {
        let image = sorted(triangle.nodes.map(|n| mirror[n as usize]));
        assert!(triangles.contains(&image));
    }
    for (node, image) in mirror.iter().enumerate() {
        let (a, b) = (
            structure.masses_kg[node],
            structure.masses_kg[*image as usize],
        );
        assert!((a - b).abs() <= 1e-12 * a.max(1e-3));
    }
}

fn closed_cells() {
    let mut closed = plan(vec![station(0.0, 2.0, 0.0), station(3.0, 1.0, 50.0)], 8);
    closed.ballooning = [vec![[0.0, 0.05], [1.0, 0.0]], vec![[0.0, 0.03], [1.0, 0.0]]];
    let inside: Vec<f64> = (0..8).map(|cell| 1.0 + 0.1 * f64::from(cell)).collect();
    let sum = |plan: &Plan, inside: &[f64], only: Option<u32>| {
        let wing = build(plan, FINENESS).unwrap();
        let distribution = Distribution {
            dynamic_pressure_pa: 50.0,
            inside: inside.to_vec(),
            upper: vec![[0.0, 0.0]],
            lower: vec![[0.0, 0.0]],
            along_span: vec![[0.0, 1.0]],
        };
        let jumps = jumps_pa(&wing, &distribution);
        let structure = &wing.structure;
        let mut force = DVec3::ZERO;
        let mut scale = 0.0;
        for ((triangle, tag), jump) in structure.triangles.iter().zip(&wing.tags).zip(&jumps) {
            if only.is_some_and(|cell| tag.number != cell && tag.part != Part::Rib) {
                continue;
            }
            let pull = triangle.doubled_area_vector(&structure.positions_m) * (0.5 * jump);
            force += pull;
            scale += pull.length();
        }
        force.length() / scale
    };
    // One pressure in all cells, then one of its own in every cell: both sum up to nothing.
    assert!(sum(&closed, &[1.0], None) < 1e-13);
    assert!(sum(&closed, &inside, None) < 1e-13);
    // A single cell under pressure, with its two ribs.
    let mut single = vec![0.0; 8];
    single[3] = 1.0;
    assert!(sum(&closed, &single, Some(3)) < 1e-13);
    // With intakes it does not: what is open does not pull.
    closed.intakes = Some(Intakes {
        from: 0.02,
        to: 0.08,
        closed_tip_cells: 0,
    });
    assert!(sum(&closed, &[1.0], None) > 1e-3);
}
