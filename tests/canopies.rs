//! Canopies as rigged: gores that stay alike under pressure, lines and risers, tilted and uneven foldings.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use libtest_mimic::Trial;
use ripstop::case::Choices;
use ripstop::case::scene::BodyKind;
use ripstop::cloth::Structure;
use ripstop::cpu::cloth::{Cloth, InitialHessian, Pressure, SolverSettings, StepInput};
use ripstop::fabric::Fabric;
use ripstop::frame::CableKind;
use ripstop::geometry::parachute::designs::{Design, RadialSlots, Shape};
use ripstop::geometry::parachute::gores::{self, FlatCircular};
use ripstop::geometry::parachute::sewn::{Cut, Folding, LinePlaces};
use ripstop::geometry::parachute::{self, Rigged, Rigging, Risers};
use ripstop::lines::Cable;
use ripstop::plan::{Plan, Precision, place_markers};

use crate::canopy::small_case;
use crate::engines::plain;
use crate::tolerances::canopies as tolerance;

pub fn trials() -> Vec<Trial> {
    [
        plain("canopies::gores_stay_alike_under_pressure", alike),
        plain("canopies::lines_and_riser_are_rigged", riser),
        plain("canopies::several_risers_carry_their_lines", risers),
        plain(
            "canopies::tilted_and_uneven_foldings_begin_free_of_stress",
            tilted,
        ),
        plain("canopies::markers_end_inside_rims", markers_end),
        plain("canopies::meshes_of_drawn_canopies_are_those", of_a_mesh),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn fabric() -> Fabric {
    Fabric {
        thickness_m: 1e-4,
        density_kg_m3: 533.77,
        warp_modulus_pa: 4.31e8,
        weft_modulus_pa: 4.31e8,
        poisson_ratio: 0.14,
        shear_modulus_pa: 1.89e8,
        residual_stiffness: 1e-3,
        cubic_shear_compliance_1_pa3: None,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    }
}

fn rigging(design: Design, line_places: LinePlaces) -> Rigging {
    let cable = Cable::linear(4.42e-6, 462.0, 1e9);
    Rigging {
        cut: Cut::Gores(design, design.pattern().unwrap()),
        fabric: fabric(),
        belts: Some(cable.clone()),
        skirt_band: Some(cable.clone()),
        vent_band: Some(cable.clone()),
        vent_lines: None,
        lines: cable,
        line_places,
        line_length_m: 1.0,
        line_slack_m: 0.0,
        line_segments: 3,
        risers: None,
        confluence_m: DVec3::new(0.3, 1.0, 2.0),
        folding: Folding {
            diameter_ratio: 0.2,
            asymmetry: 0.0,
        },
        tilt_rad: 0.0,
        apex_guide_n_m: None,
    }
}

fn design(shape: Shape, gores: usize) -> Design {
    Design {
        nominal_area_m2: 0.785,
        gores,
        rings: 10,
        vent_diameter_m: Some(0.15),
        shape,
    }
}

fn slotted() -> Design {
    let slots = RadialSlots {
        count: 12,
        width_m: 0.0,
        from_m: 0.15,
        to_m: 0.4,
    };
    let shape = Shape::Conical {
        cone_angle_rad: 0.3,
        slots: Some(slots),
    };
    design(shape, 12)
}

fn band() -> Design {
    let shape = Shape::DiskGapBand {
        disk_diameter_m: 0.72,
        gap_width_m: 0.043,
        band_width_m: 0.12,
    };
    design(shape, 12)
}

pub const SETTINGS: SolverSettings = SolverSettings {
    tolerance: 1e-3,
    displacement_floor_m: 1e-9,
    evaluation_limit: 300,
    history: 5,
    refresh_every: Some(5),
    initial_hessian: InitialHessian::BlockJacobi,
};

/// Steps under pressure from the folded state.
fn inflate(built: &Rigged, steps: usize) -> Cloth {
    let mut cloth = Cloth::new(built.structure.clone());
    let input = StepInput {
        time_step_s: Some(5e-4),
        pressure: Pressure::Uniform(50.0),
        damping_1_s: 20.0,
        ..StepInput::default()
    };
    for _ in 0..steps {
        cloth.solve_cloth(&input, &SETTINGS);
    }
    cloth
}

/// A canopy turned by one gore about its axis is the same canopy, and so it stays while it opens.
fn alike() {
    for (design, places) in [
        (slotted(), LinePlaces::Seams),
        (band(), LinePlaces::SeamsAndCentres),
    ] {
        let rigging = rigging(design, places);
        let built = parachute::build(&rigging).unwrap();
        let cloth = inflate(&built, 12);
        let axis = rigging.confluence_m;
        let turn = DQuat::from_rotation_x(TAU / 12.0);
        let moved: f64 = (cloth.positions_m.iter().zip(&built.structure.positions_m))
            .map(|(now, start)| now.distance(*start))
            .fold(0.0, f64::max);
        assert!(moved > 0.005, "it hardly moved: {moved}");
        let fabric = &cloth.positions_m[..built.canopy_node_count];
        let start = &built.structure.positions_m[..built.canopy_node_count];
        for (node, place) in start.iter().enumerate() {
            let turned = axis + turn * (*place - axis);
            let other = start
                .iter()
                .position(|p| p.distance(turned) < 1e-9)
                .unwrap_or_else(|| panic!("node {node} has no like in the next gore"));
            // Both sides of a cut start at the same place; either is a like.
            let expected = axis + turn * (fabric[node] - axis);
            let apart = start
                .iter()
                .zip(fabric)
                .filter(|(p, _)| p.distance(start[other]) < 1e-9)
                .map(|(_, now)| now.distance(expected))
                .fold(f64::INFINITY, f64::min);
            assert!(apart < tolerance::ALIKE_M, "node {node}: {apart:e}");
        }
    }
}

fn of_kind(structure: &Structure, kind: CableKind) -> usize {
    structure.cables.iter().filter(|c| c.kind == kind).count()
}

/// The riser's end is held and the confluence is free; every kind of line is there as often as it should be.
fn riser() {
    let rigging = Rigging {
        risers: Some(Risers {
            count: 1,
            length_m: 0.5,
        }),
        ..rigging(band(), LinePlaces::SeamsAndCentres)
    };
    let built = parachute::build(&rigging).unwrap();
    let structure = &built.structure;
    assert_eq!(of_kind(structure, CableKind::SuspensionLine), 24 * 3);
    assert_eq!(of_kind(structure, CableKind::GapLine), 24);
    assert_eq!(of_kind(structure, CableKind::VentLine), 12);
    assert_eq!(of_kind(structure, CableKind::Riser), 1);
    assert_eq!(structure.openings.len(), 2);
    let held: Vec<usize> = (0..structure.node_count())
        .filter(|&n| structure.held[n])
        .collect();
    assert_eq!(held, [built.lower_end]);
    let confluence = structure.positions_m[built.canopy_node_count];
    assert_eq!(confluence, rigging.confluence_m);
    assert!((confluence.distance(structure.positions_m[built.lower_end]) - 0.5).abs() < 1e-12);
}

/// Four risers meet at the confluence; no line is stretched, and under pressure each riser pulls with what its six lines do, and all of them with
/// what the support gives.
fn risers() {
    let rigging = Rigging {
        risers: Some(Risers {
            count: 4,
            length_m: 0.3,
        }),
        ..rigging(band(), LinePlaces::SeamsAndCentres)
    };
    let built = parachute::build(&rigging).unwrap();
    let structure = built.structure;
    let confluence = built.canopy_node_count;
    assert_eq!(built.lower_end, confluence);
    assert_eq!(of_kind(&structure, CableKind::Riser), 4);
    assert_eq!(of_kind(&structure, CableKind::SuspensionLine), 24 * 3);
    let mut longest: f64 = 0.0;
    for cable in &structure.cables {
        let [a, b] = cable.nodes.map(|n| structure.positions_m[n as usize]);
        let stretch = a.distance(b) / cable.rest_length_m;
        assert!(stretch < 1.0 + 1e-9, "{cable:?}");
        if cable.kind == CableKind::SuspensionLine {
            longest = longest.max(stretch);
        }
    }
    assert!((longest - 1.0).abs() < 1e-9, "{longest}");

    let mut cloth = Cloth::new(structure);
    let input = StepInput {
        time_step_s: Some(5e-4),
        pressure: Pressure::Uniform(50.0),
        damping_1_s: 20.0,
        ..StepInput::default()
    };
    let pull = |cloth: &Cloth, node: u32, kind: CableKind| -> DVec3 {
        let cables = cloth.structure.cables.iter().enumerate();
        cables
            .filter(|(_, cable)| cable.kind == kind && cable.nodes.contains(&node))
            .map(|(index, cable)| {
                let other = cable.nodes[usize::from(cable.nodes[0] == node)];
                let [here, there] = [node, other].map(|n| cloth.positions_m[n as usize]);
                cloth.cable_tension_n(index) * (there - here).normalize_or_zero()
            })
            .sum()
    };
    // The canopy bounces on its lines: the moment of the largest load tells.
    let mut loaded = cloth.clone();
    let mut largest = DVec3::ZERO;
    for _ in 0..tolerance::RISER_STEPS {
        cloth.solve_cloth(&input, &SETTINGS);
        let load = pull(&cloth, confluence as u32, CableKind::Riser);
        if load.length() > largest.length() {
            (loaded, largest) = (cloth.clone(), load);
        }
    }
    assert!(largest.x > 1.0, "{largest}");
    let allowed = tolerance::RISER_BALANCE * largest.length();
    let risers = loaded.structure.cables.iter();
    for riser in risers.filter(|c| c.kind == CableKind::Riser) {
        let junction = riser.nodes[usize::from(riser.nodes[0] as usize == confluence)];
        let [lines, riser] =
            [CableKind::SuspensionLine, CableKind::Riser].map(|k| pull(&loaded, junction, k));
        assert!((lines + riser).length() < allowed, "{lines} and {riser}");
    }
    let reactions = loaded.reactions_n(&input);
    assert_eq!(reactions.len(), 1);
    assert!((reactions[0].1 + largest).length() < allowed);
}

/// Green strain of fabric and tension of lines at the start are nothing, wherever the canopy points.
fn tilted() {
    for (asymmetry, tilt_rad) in [(0.0, 0.3), (0.5, 0.0), (0.5, 0.3)] {
        let rigging = Rigging {
            folding: Folding {
                diameter_ratio: 0.15,
                asymmetry,
            },
            tilt_rad,
            ..rigging(slotted(), LinePlaces::Seams)
        };
        let built = parachute::build(&rigging).unwrap();
        let structure = &built.structure;
        for triangle in &structure.triangles {
            let strain = triangle.strain(&triangle.edge_vectors(&structure.positions_m));
            assert!(strain.iter().all(|e| e.abs() < 1e-9), "{strain:?}");
        }
        for cable in &structure.cables {
            let [a, b] = cable.nodes.map(|n| structure.positions_m[n as usize]);
            assert!(
                a.distance(b) < cable.rest_length_m * (1.0 + 1e-9),
                "{cable:?}"
            );
        }
        // The apex lies where the tilt points.
        let vent_lines = structure
            .cables
            .iter()
            .filter(|c| c.kind == CableKind::VentLine);
        let apex: DVec3 = vent_lines
            .map(|line| structure.positions_m[line.nodes[0] as usize] - rigging.confluence_m)
            .sum();
        let angle = apex.y.atan2(apex.x);
        let allowed = if asymmetry > 0.0 { 0.05 } else { 1e-9 };
        assert!((angle - tilt_rad).abs() < allowed, "{angle}");
        // Uneven pleats: the widest gore takes (1 + a)/(1 − a) times the azimuth of the narrowest, nearly.
        if asymmetry > 0.0 && tilt_rad == 0.0 {
            let azimuth = |node: u32| {
                let p = structure.positions_m[node as usize] - rigging.confluence_m;
                p.z.atan2(p.y).rem_euclid(TAU)
            };
            let lines: Vec<f64> = (structure.cables.iter())
                .filter(|c| c.kind == CableKind::SuspensionLine)
                .step_by(rigging.line_segments)
                .map(|c| azimuth(c.nodes[0]))
                .collect();
            let wide = (lines[1] - lines[0]).rem_euclid(TAU);
            let expected = 2.0 * PI / 12.0 * (1.0 + asymmetry * (PI / 12.0).cos());
            assert!((wide / expected - 1.0).abs() < 1e-6, "{wide} {expected}");
        }
    }
}

/// Markers of the flat circular canopy cover a circle with a radius smaller by the inset, whatever the cells; without an inset all of it.
fn markers_end() {
    for (cells, inset) in [(12.0, 0.65), (24.0, 0.65), (24.0, 0.3), (24.0, 0.0)] {
        let case = small_case(&[
            "structure.flat_circular.rings=12",
            &format!("resolution.cells_per_diameter={cells:?}"),
            &format!("coupling.rim_inset_cells={inset:?}"),
        ]);
        let markers = place_markers(&case.scene);
        let plan = Plan::new(&case.scene, Precision::F32);
        assert_eq!(markers.len() as u64, plan.sizes.markers);
        let area: f64 = markers.iter().map(|marker| marker.area_m2).sum();
        let expected = 0.78 * (1.0f64 - 2.0 * inset / cells).powi(2);
        assert!(
            (area / expected - 1.0).abs() < tolerance::MARKED_AREA,
            "{cells} {inset}: {area} {expected}"
        );
    }
}

/// The text of a case without tables whose heads contain one of some words.
pub fn without_tables(text: &str, unwanted: &[&str]) -> String {
    let mut keep = true;
    let lines = text.lines().filter(|line| {
        if line.starts_with('[') {
            keep = !unwanted.iter().any(|table| line.contains(table));
        }
        keep
    });
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// A canopy that is written to mesh files, flat and folded, and read again with a table of its lines, moves as the drawn one under pressure
/// and is measured by the same diameter.
fn of_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let drawn = small_case(&[
        "structure.flat_circular.apex_guide_n_m=absent",
        "belts=absent",
    ]);
    let body = drawn.scene.body.as_ref().unwrap();
    let (BodyKind::Canopy(canopy), structure) = (&body.kind, &body.structure) else {
        panic!("no canopy");
    };
    let flat = gores::mesh(&FlatCircular {
        nominal_area_m2: canopy.nominal_area_m2,
        gores: 8,
        rings: 8,
    });
    let shift = DVec3::new(0.25, 0.5, -0.125);
    // Nodes in the reverse order: nothing may depend on their numbers.
    let count = canopy.canopy_node_count;
    let number = |node: usize| if node < count { count - 1 - node } else { node };
    let write = |name: &str, places: &[DVec3]| {
        let mut text: String = places
            .iter()
            .rev()
            .map(|p| format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z))
            .collect();
        for t in &structure.triangles {
            let [a, b, c] = t.nodes.map(|n| number(n as usize) + 1);
            text.push_str(&format!("f {a} {b} {c}\n"));
        }
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write("flat.obj", &flat.flat_positions_m);
    let folded: Vec<DVec3> = structure.positions_m[..canopy.canopy_node_count]
        .iter()
        .map(|p| *p - shift)
        .collect();
    write("folded.obj", &folded);
    let mut table = "x_m, y_m, z_m, end_x_m, end_y_m, end_z_m, length_m\n".to_owned();
    for line in &structure.cables {
        let [a, b] = line
            .nodes
            .map(|n| structure.positions_m[n as usize] - shift);
        let length = line.rest_length_m;
        table.push_str(&format!(
            "{:?}, {:?}, {:?}, {:?}, {:?}, {:?}, {length:?}\n",
            a.x, a.y, a.z, b.x, b.y, b.z
        ));
    }
    std::fs::write(folder.path().join("lines.csv"), table).unwrap();
    let source = without_tables(
        include_str!("../cases/flat-circular-tunnel.toml"),
        &["[structure", "[belts", "[lines", "[variants"],
    ) + "[structure.mesh]\nfile = \"flat.obj\"\nstart_file = \"folded.obj\"\nscale = 1.0\nheld_nodes = []\nnominal_area_m2 = 0.78\n\
         position_m = [0.25, 0.5, -0.125]\nlines = \"lines.csv\"\n[structure.mesh.line_material]\narea_m2 = 4.42e-6\n\
         density_kg_m3 = 462.0\nyoungs_modulus_pa = 9.7e10\n";
    let parse =
        || ripstop::case::parse("mesh", &source, folder.path(), &Choices::default()).unwrap();
    let read = parse();
    // Coefficients that would refer to an area more than twice as large are warned of.
    let warnings = |source: &str| {
        let choices = Choices::default();
        let case = ripstop::case::parse("mesh", source, folder.path(), &choices).unwrap();
        let plan = Plan::new(&case.scene, Precision::F32);
        plan.warnings(&case.scene).join(", ")
    };
    let larger = source.replace("nominal_area_m2 = 0.78", "nominal_area_m2 = 1.8");
    assert!(
        warnings(&larger).contains("0.43 of the nominal area"),
        "{}",
        warnings(&larger)
    );
    assert!(!warnings(&source).contains("nominal area"));
    // What is resumed or kept is of the same case only with the same files.
    for name in ["flat.obj", "folded.obj", "lines.csv"] {
        let path = folder.path().join(name);
        let before = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("# Another one.\n{before}")).unwrap();
        assert_ne!(parse().hash, read.hash, "{name}");
        std::fs::write(&path, before).unwrap();
        assert_eq!(parse().hash, read.hash, "{name}");
    }
    let read = read.scene.body.unwrap();
    let BodyKind::Canopy(of_mesh) = read.kind else {
        panic!("no canopy");
    };
    assert_eq!(of_mesh.nominal_diameter_m, canopy.nominal_diameter_m);
    assert_eq!(of_mesh.lower_end, canopy.lower_end);
    assert_eq!(of_mesh.apex, number(canopy.apex));
    let cloths = [&read.structure, structure].map(|structure| {
        let mut cloth = Cloth::new(structure.clone());
        let input = StepInput {
            time_step_s: Some(5e-4),
            pressure: Pressure::Uniform(50.0),
            damping_1_s: 20.0,
            ..StepInput::default()
        };
        for _ in 0..12 {
            cloth.solve_cloth(&input, &SETTINGS);
        }
        cloth
    });
    let moved = structure.positions_m.iter().zip(&cloths[1].positions_m);
    assert!(moved.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max) > 0.005);
    let [read, drawn] = cloths.each_ref().map(|cloth| &cloth.positions_m);
    let apart = |(node, place): (usize, &DVec3)| read[number(node)].distance(*place);
    let apart = drawn.iter().enumerate().map(apart).fold(0.0, f64::max);
    assert!(apart < tolerance::ALIKE_M, "{apart:e}");
}
