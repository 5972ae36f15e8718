//! Seams of meshes of others: joined and sewn, and what the numbers of the file mean then.

use std::fmt::Write;

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::cpu::cloth::{Cloth, Pressure, StepInput};
use ripstop::geometry::parachute::gores::{self, FlatCircular};
use ripstop::rigid::Surface;

use crate::canopies::{SETTINGS, without_tables};
use crate::canopy::small_case;
use crate::command_line::ripstop;
use crate::engines::plain;
use crate::meshes::{
    HELD, checked, halves, hanging, obj, parsed, sheet, unframed, with_seam, write,
};
use crate::tolerances::meshes as tolerance;

pub fn trials() -> Vec<Trial> {
    [
        plain(
            "meshes::a_joined_seam_carries_what_a_whole_sheet_does",
            seam,
        ),
        plain("meshes::gores_become_one_canopy", canopy_of_gores),
        plain(
            "meshes::gores_with_other_vertices_become_one_canopy",
            unmatched_gores,
        ),
        plain(
            "meshes::unmatched_seams_are_found_and_sewn",
            unmatched_seams,
        ),
        plain("meshes::numbers_of_the_file_outlive_joining", numbers),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A sheet in two halves with a common seam is as taut when it is joined as one that was whole; apart it tears.
fn seam() {
    let tension = |surface: &Surface, more: &str| -> f64 {
        let folder = tempfile::tempdir().unwrap();
        let case = write(folder.path(), surface, &hanging(&format!("{HELD}\n{more}")));
        let out = folder.path().join("out");
        let run = ripstop(&["run", &case, "--out", out.to_str().unwrap()]);
        assert_eq!(run.code, 0, "{}", run.errors);
        let summary = std::fs::read(out.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        summary["results"]["tension_max_n_m"]["value"]
            .as_f64()
            .unwrap()
    };
    let whole = tension(&sheet(), "");
    let joined = tension(&with_seam(), "weld_tolerance_m = 1e-6");
    let torn = tension(
        &with_seam(),
        "accept = [\"doubled_vertices\", \"loose_pieces\"]",
    );
    assert!(
        (joined / whole - 1.0).abs() < tolerance::TENSION,
        "{joined} {whole}"
    );
    assert!(torn < 0.7 * whole, "{torn} {whole}");
    let told = checked(&with_seam(), &format!("{HELD}\nweld_tolerance_m = 1e-6"));
    let line = "joined              5 vertices to others within 0.000001 m; 0 triangles collapsed";
    assert!(told.printed.contains(line), "{}", told.printed);
    assert!(
        told.printed.contains("findings            none"),
        "{}",
        told.printed
    );
    // A tolerance that reaches over edges.
    let wide = checked(&with_seam(), &format!("{HELD}\nweld_tolerance_m = 0.1"));
    assert_eq!(wide.code, 2);
    assert!(
        unframed(&wide.errors).contains("give at most 2.50e-2 m"),
        "{}",
        wide.errors
    );
}

/// A flat circular canopy, written gore by gore as a program that cuts fabric does, flat and folded: with its seams joined it has the nodes,
/// the mass and the motion under pressure of the one that it was written from.
fn canopy_of_gores() {
    const GORES: usize = 8;
    let folder = tempfile::tempdir().unwrap();
    let drawn = small_case(&[
        "structure.flat_circular.apex_guide_n_m=absent",
        "belts=absent",
    ]);
    let structure = &drawn.scene.body.as_ref().unwrap().structure;
    let flat = gores::mesh(&FlatCircular {
        nominal_area_m2: 0.78,
        gores: GORES,
        rings: 8,
    });
    let count = flat.flat_positions_m.len();
    let folded = &structure.positions_m[..count];
    let [mut rest, mut start] = [String::new(), String::new()];
    // Node of the canopy that each vertex of the files lies on.
    let mut vertices: Vec<u32> = Vec::new();
    let per_gore = flat.triangles.len() / GORES;
    for (gore, triangles) in flat.triangles.chunks(per_gore).enumerate() {
        let first = vertices.len();
        let mut faces = String::new();
        for nodes in triangles {
            let [a, b, c] = nodes.map(|node| {
                let known = vertices[first..].iter().position(|v| *v == node);
                first
                    + 1
                    + known.unwrap_or_else(|| {
                        vertices.push(node);
                        vertices.len() - 1 - first
                    })
            });
            writeln!(faces, "f {a} {b} {c}").unwrap();
        }
        for (text, places) in [
            (&mut rest, &flat.flat_positions_m[..]),
            (&mut start, folded),
        ] {
            writeln!(text, "o gore{gore}").unwrap();
            for node in &vertices[first..] {
                let p = places[*node as usize];
                writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).unwrap();
            }
            text.push_str(&faces);
        }
    }
    std::fs::write(folder.path().join("flat.obj"), rest).unwrap();
    std::fs::write(folder.path().join("folded.obj"), &start).unwrap();
    let mut table = "x_m, y_m, z_m, end_x_m, end_y_m, end_z_m, length_m\n".to_owned();
    for line in &structure.cables {
        let [a, b] = line.nodes.map(|n| structure.positions_m[n as usize]);
        let length = line.rest_length_m;
        let numbers = [a.x, a.y, a.z, b.x, b.y, b.z, length].map(|x| format!("{x:?}"));
        writeln!(table, "{}", numbers.join(", ")).unwrap();
    }
    std::fs::write(folder.path().join("lines.csv"), table).unwrap();
    let source = without_tables(
        include_str!("../cases/flat-circular-tunnel.toml"),
        &["[structure", "[belts", "[lines", "[variants"],
    ) + "[structure.mesh]\nfile = \"flat.obj\"\nstart_file = \"folded.obj\"\nscale = 1.0\nheld_nodes = []\nnominal_area_m2 = 0.78\n\
         lines = \"lines.csv\"\nWELD\n[structure.mesh.line_material]\narea_m2 = 4.42e-6\ndensity_kg_m3 = 462.0\n\
         youngs_modulus_pa = 9.7e10\n";
    let apart = parsed(&source.replace("WELD", ""), folder.path()).unwrap_err();
    for part in [
        "doubled_vertices",
        "7 pieces of fabric without a common node",
        "loose_pieces",
        &format!("{} vertices lie upon others", vertices.len() - count),
    ] {
        assert!(apart.contains(part), "{part}: {apart}");
    }
    let joined = source.replace("WELD", "weld_tolerance_m = 1e-6");
    let scene = parsed(&joined, folder.path()).unwrap();
    let [mesh] = &scene.meshes[..] else {
        panic!("{}", scene.meshes.len());
    };
    assert_eq!(mesh.examination.pieces.len(), 1);
    assert_eq!(mesh.examination.borders.len(), 1);
    assert_eq!(mesh.weld.unwrap().joined, vertices.len() - count);
    let read = &scene.body.as_ref().unwrap().structure;
    assert_eq!(read.node_count(), structure.node_count());
    let masses = [read, structure].map(|s| s.masses_kg.iter().sum::<f64>());
    assert!((masses[0] / masses[1] - 1.0).abs() < 1e-12, "{masses:?}");
    // Nodes come in the order of the files; that of the first vertex on each stays.
    let mut order: Vec<u32> = Vec::new();
    for node in &vertices {
        if !order.contains(node) {
            order.push(*node);
        }
    }
    let cloths = [read, structure].map(|structure| {
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
        cloth.positions_m
    });
    let moved =
        |node: &u32| structure.positions_m[*node as usize].distance(cloths[1][*node as usize]);
    assert!(order.iter().map(moved).fold(0.0, f64::max) > 0.005);
    let apart =
        |(number, node): (usize, &u32)| cloths[0][number].distance(cloths[1][*node as usize]);
    let apart = order.iter().enumerate().map(apart).fold(0.0, f64::max);
    assert!(apart < tolerance::ALIKE_M, "{apart:e}");
    // A fold that opens a seam that is joined at rest.
    let opened = start.replacen("v ", "v 1.0 2.0 3.0\nx ", 1);
    std::fs::write(folder.path().join("folded.obj"), opened).unwrap();
    let error = parsed(&joined, folder.path()).unwrap_err();
    assert!(
        error.contains("longer than at rest") || error.contains("are joined in"),
        "{error}"
    );
}

/// Held nodes, supports and lines keep the numbers and places of the file, whichever of two joined vertices they name.
fn numbers() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mesh.obj"), obj(&with_seam())).unwrap();
    std::fs::write(
        folder.path().join("lines.csv"),
        "x_m, y_m, z_m, end_x_m, end_y_m, end_z_m, length_m\n0.5, 0.0, -0.5, 0.5, 1.0, -0.5,\n",
    )
    .unwrap();
    let supports = |nodes: &str| {
        hanging(
            "held_nodes = [1, 26, 30]\nweld_tolerance_m = 1e-6\nlines = \"lines.csv\"\n\
             line_material = { area_m2 = 1e-6, density_kg_m3 = 1000.0, youngs_modulus_pa = 1e9 }",
        ) + &format!("[supports.pull]\nnodes = {nodes}\ndisplacement_m = [0.0, 0.1, 0.0]\n")
    };
    let scene = parsed(&supports("[30, 15, 31]"), folder.path()).unwrap();
    let structure = &scene.body.as_ref().unwrap().structure;
    let held: Vec<usize> = (0..structure.node_count())
        .filter(|node| structure.held[*node])
        .collect();
    // The line ends at the node after those of the mesh, in the file's numbers vertex 31.
    assert_eq!(held, [0, 10, 14, 25]);
    assert_eq!(structure.cables[0].nodes, [12, 25]);
    assert_eq!(scene.supports[0].nodes, [14, 25]);
    let error = parsed(&supports("[32]"), folder.path()).unwrap_err();
    assert!(error.contains("there is no node 32"), "{error}");
    // A seam that is open at the start is not joined.
    let mut open = with_seam();
    open.positions_m[27] += DVec3::new(0.0, 0.1, 0.0);
    std::fs::write(folder.path().join("open.obj"), obj(&open)).unwrap();
    let start = hanging(&format!(
        "{HELD}\nweld_tolerance_m = 1e-6\nstart_file = \"open.obj\""
    ));
    let error = parsed(&start, folder.path()).unwrap_err();
    assert!(
        error.contains(
            "vertices 13 and 28 are joined in mesh.obj, but 1.000e-1 m apart in open.obj"
        ),
        "{error}"
    );
}

/// Halves with other vertices along their seam are refused, and sewn by a tolerance: nothing of area, mass, sides or numbers changes.
fn unmatched_seams() {
    for (gap_m, weld) in [
        (0.0, "weld_tolerance_m = 2.5e-7"),
        (2e-3, "weld_tolerance_m = 3.0e-3"),
    ] {
        let cut = halves(4, 6, gap_m);
        let refused = checked(&cut, HELD);
        assert_eq!(refused.code, 2);
        let told = unframed(&refused.errors);
        for part in [
            "3 vertices lie upon others along open borders",
            "6 vertices lie upon edges of others along open borders, where the mesh is not joined and has other vertices",
            "first vertex 17 at (0.1667, 0.0000, -0.50",
            "between vertices 11 and 12",
            "\"doubled_vertices\", \"hanging_nodes\", \"loose_pieces\"",
        ] {
            assert!(told.contains(part), "{part}: {told}");
        }
        assert!(
            told.contains(&format!("hanging_nodes: {weld} joins them")),
            "{told}"
        );
        let sewn = checked(&cut, &format!("{HELD}\n{weld}"));
        assert_eq!(sewn.code, 0, "{}", sewn.errors);
        for part in [
            "joined              3 vertices to others",
            "sewn                6 vertices inserted into edges of the other side of their seam",
            "pieces              1, of 46 triangles (33 nodes in all)",
            "area 1.00",
            "findings            none",
        ] {
            assert!(sewn.printed.contains(part), "{part}: {}", sewn.printed);
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mesh.obj"), obj(&cut)).unwrap();
        let scene = parsed(&hanging(&format!("{HELD}\n{weld}")), folder.path()).unwrap();
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.examination.borders.len(), 1);
        // The gap is bridged by what lies within the tolerance, and nothing else.
        assert!(
            (mesh.examination.area_m2 - 1.0).abs() <= gap_m + 1e-12,
            "{}",
            mesh.examination.area_m2
        );
        assert!((mesh.mass_kg.unwrap() / 0.05 - 1.0).abs() <= gap_m + 1e-12);
        assert!(mesh.surface.area_vectors_m2().all(|area| area.y > 0.0));
    }
    // What would leave edges about as short as the tolerance.
    let wide = checked(
        &halves(8, 9, 0.0),
        &format!("{HELD}\nweld_tolerance_m = 0.01"),
    );
    assert_eq!(wide.code, 2);
    assert!(
        unframed(&wide.errors).contains("neither keep nor join"),
        "{}",
        wide.errors
    );
    // A piece that only touches a border with its corner stays apart, and one beside a border stays, too.
    for second in [
        [[0.1, 0.0, -1.0], [0.2, 0.0, -1.4], [0.0, 0.0, -1.4]],
        [[0.1, 0.0, -1.04], [0.9, 0.0, -1.04], [0.5, 0.0, -1.4]],
    ] {
        let mut touching = sheet();
        touching.positions_m.extend(second.map(DVec3::from_array));
        touching.triangles.push([25, 26, 27]);
        let apart = checked(
            &touching,
            "held_nodes = [1, 26]\nweld_tolerance_m = 1e-3\naccept = [\"pieces\"]",
        );
        assert_eq!(apart.code, 0, "{}", apart.errors);
        assert!(!apart.printed.contains("sewn"), "{}", apart.printed);
        assert!(
            apart.printed.contains("pieces              2"),
            "{}",
            apart.printed
        );
    }
    // A start at which the seam gapes.
    let folder = tempfile::tempdir().unwrap();
    let mut open = halves(4, 6, 0.0);
    std::fs::write(folder.path().join("mesh.obj"), obj(&open)).unwrap();
    open.positions_m[16] += DVec3::Y * 0.06;
    std::fs::write(folder.path().join("open.obj"), obj(&open)).unwrap();
    let start = format!("{HELD}\nweld_tolerance_m = 1e-6\nstart_file = \"open.obj\"");
    let error = parsed(&hanging(&start), folder.path()).unwrap_err();
    assert!(
        error.contains("vertex 17 is sewn to the edge between vertices 11 and 12 in mesh.obj, but"),
        "{error}"
    );
}

/// Flat gores side by side, each with vertices of its own and as many rings as it is told.
fn gore_by_gore(gores: usize, rings: impl Fn(usize) -> usize) -> Surface {
    let mut surface = Surface::default();
    for gore in 0..gores {
        let pattern = FlatCircular {
            nominal_area_m2: 0.78,
            gores,
            rings: rings(gore),
        };
        let flat = gores::mesh(&pattern);
        // The same skirt, whatever its polygon.
        let scale = 0.5 / pattern.skirt_radius_m();
        let count = flat.triangles.len() / gores;
        let first = surface.positions_m.len();
        let mut known: Vec<u32> = Vec::new();
        for nodes in &flat.triangles[gore * count..(gore + 1) * count] {
            surface.triangles.push(nodes.map(|node| {
                let number = known.iter().position(|known| *known == node);
                let number = number.unwrap_or_else(|| {
                    known.push(node);
                    let place = flat.flat_positions_m[node as usize];
                    surface.positions_m.push(scale * place);
                    known.len() - 1
                });
                (first + number) as u32
            }));
        }
    }
    surface
}

/// Gores with 8 and 12 divisions along their seams become one canopy: held at its skirt it bulges under pressure, and is as taut, as the one with 12
/// everywhere. Unsewn it tears open and has no equilibrium.
fn unmatched_gores() {
    const GORES: usize = 8;
    let run = |surface: &Surface, more: &str, limit: u32| {
        let folder = tempfile::tempdir().unwrap();
        // Flat in x and y, so that it bulges along z.
        let flat = Surface {
            positions_m: surface
                .positions_m
                .iter()
                .map(|p| DVec3::new(p.y, p.z, p.x))
                .collect(),
            triangles: surface.triangles.clone(),
        };
        let radius_m = flat.positions_m.iter().map(|p| p.length());
        let radius_m = radius_m.fold(0.0, f64::max);
        let places = flat.positions_m.iter().enumerate();
        let skirt = places.filter(|(_, p)| p.length() > radius_m - 1e-9);
        let held: Vec<usize> = skirt.map(|(number, _)| number + 1).collect();
        let case = hanging(&format!("held_nodes = {held:?}\n{more}"));
        let case = case.split("[gravity]").next().unwrap().to_owned()
            + "[equilibrium]\npressure_pa = 500.0\ntolerance = 1e-4\n"
            + &format!("evaluation_limit = {limit}\n");
        let case = write(folder.path(), &flat, &case);
        let out = folder.path().join("out");
        let run = ripstop(&["run", &case, "--out", out.to_str().unwrap()]);
        let summary = std::fs::read(out.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        let [high, low, tension] = ["highest_point_m", "lowest_point_m", "tension_max_n_m"]
            .map(|name| summary["results"][name]["value"].as_f64().unwrap());
        (run.code, [high - low, tension])
    };
    let weld = "weld_tolerance_m = 1e-6";
    let unmatched = gore_by_gore(GORES, |gore| if gore % 2 == 0 { 8 } else { 12 });
    let (code, expected) = run(&gore_by_gore(GORES, |_| 12), weld, 3000);
    assert_eq!(code, 0);
    assert!(expected[0] > 0.09, "{expected:?}");
    let (code, sewn) = run(&unmatched, weld, 3000);
    assert_eq!(code, 0);
    for (sewn, expected) in sewn.iter().zip(expected) {
        let ratio = sewn / expected;
        assert!((ratio - 1.0).abs() < tolerance::SEWN, "{ratio}");
    }
    let (code, torn) = run(
        &unmatched,
        "accept = [\"doubled_vertices\", \"hanging_nodes\", \"pieces\"]",
        600,
    );
    assert_eq!(code, 20, "{torn:?}");
}
