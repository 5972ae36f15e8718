//! What a designer asks of a wing beyond its equilibrium: load test, sail support, profiles from files, panel shaping.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices, Scene};
use ripstop::geometry::wing::Part;
use ripstop::geometry::wing::patterns::{Flat, patterns, unroll};
use ripstop::geometry::wing::section::Side;

use crate::command_line::{Finished, ripstop, root};
use crate::engines::plain;
use crate::tolerances::wing_design as tolerance;

pub fn trials() -> Vec<Trial> {
    [
        plain("wing_design::loads_are_raised", load_test),
        plain("wing_design::where_no_line_holds_is_told", sail_support),
        plain("wing_design::profiles_come_from_files", profiles),
        plain("wing_design::panels_fly_as_designed", panel_shaping),
        plain("wing_design::seams_of_panels_fit_their_ribs", seams),
        plain("wing_design::wings_of_leparagliding_are_read", imported),
        plain(
            "wing_design::a_cylinder_unrolls_exactly",
            a_cylinder_unrolls_exactly,
        ),
        plain("wing_design::a_sphere_is_strained", a_sphere_is_strained),
        plain(
            "wing_design::flown_ballooning_is_read_as_it_is_drawn",
            drawn_ballooning,
        ),
        plain("wing_design::pieces_are_drawn_at_true_scale", true_scale),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const CASE: &str = "cases/wing-school.toml";

struct Ran {
    output: Finished,
    summary: serde_json::Value,
    folder: tempfile::TempDir,
}

impl Ran {
    fn value(&self, name: &str) -> f64 {
        self.summary["results"][name]["value"]
            .as_f64()
            .unwrap_or_else(|| panic!("{name}: {}", self.summary["results"][name]))
    }

    fn note(&self, name: &str) -> &str {
        self.summary["results"][name]["note"].as_str().unwrap()
    }

    /// Lines of a table by the names of its columns.
    fn table(&self, name: &str) -> Vec<std::collections::HashMap<String, String>> {
        let mut reader = csv::Reader::from_path(self.folder.path().join(name)).unwrap();
        let names = reader.headers().unwrap().clone();
        reader
            .records()
            .map(|record| {
                let record = record.unwrap();
                names
                    .iter()
                    .zip(&record)
                    .map(|(a, b)| (a.to_owned(), b.to_owned()))
                    .collect()
            })
            .collect()
    }
}

fn run(more: &[&str]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = vec![
        "run",
        CASE,
        "--variant",
        "quick",
        "--out",
        folder.path().to_str().unwrap(),
    ];
    for &change in more {
        arguments.extend(["--set", change]);
    }
    let output = ripstop(&arguments);
    let text = std::fs::read(folder.path().join("summary.json")).unwrap();
    Ran {
        output,
        summary: serde_json::from_slice(&text).unwrap(),
        folder,
    }
}

/// The risers carry n times what the air does, less the weight of the wing, which stays; the line that breaks first is told with the load factor between the
/// steps; and the wing flies as before.
fn load_test() {
    let ran = run(&[
        "equilibrium.load_test.load_factors=[2.0, 4.0, 6.0]",
        "structure.wing.line_materials.gallery.breaking_load_n=300.0",
    ]);
    assert_eq!(ran.output.code, 0, "{}", ran.output.errors);
    let steps = ran.table("load_test.csv");
    assert_eq!(steps.len(), 4);
    let of = |step: usize, name: &str| -> f64 { steps[step][name].parse().unwrap() };
    let risers = |step: usize| of(step, "riser_force_right_n") + of(step, "riser_force_left_n");
    let weight = ran.value("weight_n") - 85.0 * 9.81;
    let air = risers(0) + weight;
    for (step, factor) in [2.0, 4.0, 6.0].into_iter().enumerate() {
        assert_eq!(of(step + 1, "load_factor"), factor);
        // The arc tightens under load: pressure finds less area to lift.
        let area = of(step + 1, "projected_area_m2") / of(0, "projected_area_m2");
        assert!((0.9..1.0).contains(&area), "{factor}: {area}");
        let ratio = (risers(step + 1) + weight) / (factor * air * area);
        assert!((ratio - 1.0).abs() < tolerance::RAISED, "{factor}: {ratio}");
        assert!(of(step + 1, "riser_balance_error") < 1e-2);
    }
    // Between the steps at whose ends the largest share is below and above 1.
    let shares: Vec<f64> = (0..4)
        .map(|step| of(step, "line_load_over_breaking_load_max"))
        .collect();
    let after = shares.iter().position(|share| *share > 1.0).unwrap();
    let failure = ran.value("load_test_first_failure_load_factor");
    assert!(
        failure > of(after - 1, "load_factor") && failure <= of(after, "load_factor"),
        "{failure}: {shares:?}"
    );
    let linear = of(after, "load_factor") / shares[after];
    assert!((failure / linear - 1.0).abs() < 0.1, "{failure} {linear}");
    let name = ran.note("load_test_first_failure_load_factor");
    assert!(name.contains("A level 1 of rib "), "{name}");
    // That very line is the first of the table of lines.
    let lines = ran.table("load_test_lines.csv");
    let first = lines.iter().max_by(|a, b| {
        let share = |line: &std::collections::HashMap<String, String>| -> f64 {
            line["load_over_breaking_load_at_last"]
                .parse()
                .unwrap_or(0.0)
        };
        share(a).total_cmp(&share(b))
    });
    assert!(name.starts_with("A level 1") && first.unwrap()["line"].starts_with("A level 1"));
    // Back in flight.
    let rows = ["A", "B", "C"];
    for row in rows {
        let (flown, first) = (
            ran.value(&format!("row_{row}_load_n")),
            of(0, &format!("row_{row}_load_n")),
        );
        assert!((flown / first - 1.0).abs() < 1e-9, "{row}: {flown} {first}");
    }
    for name in ["load_test.png", "load_test.vtp", "load_test_lines.png"] {
        assert!(ran.folder.path().join(name).exists(), "{name}");
    }
}

/// A row that lacks an attachment: ribs stand out there more than anywhere, at that row, and the warning names the place.
fn sail_support() {
    let lacking = |row: &str| {
        run(&[
            &format!("structure.wing.rows.{row}.ribs=[2, 5, 11, 14]"),
            &format!(
                "structure.wing.rows.{row}.levels=[{{ material = \"gallery\", joins = [2, 2], height = 0.75 }}, {{ material = \"main\" }}]"
            ),
        ])
    };
    let whole = run(&[]);
    let out = |ran: &Ran| ran.value("rib_standing_out_max");
    let warned = |ran: &Ran, words: &str| {
        let notes = ran.summary["notes"].as_array().unwrap();
        notes
            .iter()
            .any(|note| note.as_str().unwrap().contains(words))
    };
    for row in ["A", "B"] {
        let ran = lacking(row);
        assert_eq!(ran.output.code, 0, "{}", ran.output.errors);
        assert!(
            out(&ran) > 1.15 * out(&whole),
            "{row}: {} {}",
            out(&ran),
            out(&whole)
        );
        // Ribs 8 on both sides of the middle are 9 and 25 from the left tip.
        let place = ran.note("rib_standing_out_max");
        assert!(
            ["6 and 12", "22 and 28"].iter().any(|ribs| {
                place.contains(&format!(
                    "at row {row}, between the attachments of ribs {ribs}"
                ))
            }),
            "{place}"
        );
        assert!(warned(
            &ran,
            "a rib stands out between the attachments of its row"
        ));
        assert!(warned(&ran, "(8 from the middle) by"));
    }
    assert!(!warned(&whole, "ribs 6 and 12") && !warned(&whole, "(8 from the middle) by"));
}

/// A file with the coordinates of a NACA profile makes the same wing.
fn profiles() {
    let folder = tempfile::tempdir().unwrap();
    // NACA 0017 with a closed trailing edge, in Selig's order.
    let half = |x: f64| {
        5.0 * 0.17
            * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                - 0.1036 * x.powi(4))
    };
    let mut text = "NACA 0017\n".to_owned();
    for i in -60..=60_i32 {
        let x = (f64::from(i) / 60.0).powi(2);
        let sign = if i <= 0 { 1.0 } else { -1.0 };
        text.push_str(&format!(" {x:.6}  {:.6}\n", sign * half(x)));
    }
    std::fs::write(folder.path().join("p.dat"), text).unwrap();
    let source = std::fs::read_to_string(root().join(CASE)).unwrap();
    let wing = |profile: &str| {
        let choices = Choices {
            variant: Some("quick".to_owned()),
            overrides: vec![format!("structure.wing.profiles.middle={profile}")],
        };
        let case = case::parse("school", &source, folder.path(), &choices).unwrap();
        case.scene.wing.unwrap().wing
    };
    let (read, known) = (wing("{ file = \"p.dat\" }"), wing("{ naca = \"0017\" }"));
    for i in 0..=200 {
        let x = f64::from(i) / 200.0;
        for side in [Side::Upper, Side::Lower] {
            let [a, b] = [&read, &known].map(|wing| wing.profiles[0].height(side, x));
            assert!((a - b).abs() < tolerance::PROFILE, "{x} {side:?}: {a} {b}");
        }
    }
    let volumes = [read, known].map(|wing| wing.measures.section_volume_m3);
    assert!((volumes[0] / volumes[1] - 1.0).abs() < 1e-3, "{volumes:?}");
}

/// Panels cut anew fly as far out as was asked for.
fn panel_shaping() {
    let ran = run(&[
        "equilibrium.panel_shaping={ aim = \"ballooning\", tolerance = 0.008, target = { upper = [[0.0, 0.06], [0.1, 0.09], [0.5, 0.08], [0.85, 0.06], [1.0, 0.0]], lower = [[0.0, 0.06], [0.3, 0.07], [0.85, 0.06], [1.0, 0.0]] } }",
    ]);
    assert_eq!(ran.output.code, 0, "{}", ran.output.errors);
    let pair = |name: &str| {
        ["before", "after"].map(|which| ran.value(&format!("panel_shaping_{name}_{which}")))
    };
    let [before, after] = pair("error_max");
    assert!(after <= 0.008 && before > 3.0 * after, "{before} {after}");
    assert!((1.0..6.0).contains(&ran.value("panel_shaping_changes")));
    // What is to be put into a case is what was cut.
    let text = std::fs::read_to_string(ran.folder.path().join("panel_shaping.toml")).unwrap();
    let plan: toml::Table = toml::from_str(&text).unwrap();
    let upper = plan["structure"]["wing"]["ballooning"]["upper"]
        .as_array()
        .unwrap();
    let rows = ran.table("panel_shaping.csv");
    let cut: Vec<f64> = rows
        .iter()
        .filter(|row| row["side"].parse::<f64>() == Ok(1.0))
        .map(|row| row["cut_after"].parse().unwrap())
        .collect();
    assert_eq!(upper.len(), cut.len());
    for (point, cut) in upper.iter().zip(&cut) {
        assert!((point[1].as_float().unwrap() - cut).abs() < 1e-9);
    }
    let svg = std::fs::read_to_string(ran.folder.path().join("panels.svg")).unwrap();
    assert_eq!(svg.matches("<path").count(), 64);
    assert!(ran.folder.path().join("panel_shaping_upper.png").exists());
}

/// The quick school wing.
/// The school wing on its coarse mesh.
pub fn school() -> Scene {
    let source = std::fs::read_to_string(root().join(CASE)).unwrap();
    let choices = Choices {
        variant: Some("quick".to_owned()),
        overrides: Vec::new(),
    };
    case::parse("school", &source, root(), &choices)
        .unwrap()
        .scene
}

/// Seams of panels laid flat are as long as the edges of the ribs that they are sewn to, and as those of the panel on the other side.
fn seams() {
    let scene = school();
    let (wing, body) = (scene.wing.unwrap().wing, scene.body.unwrap());
    let places = &body.structure.positions_m;
    let panels = patterns(&wing, places);
    assert_eq!(panels.len(), 2 * wing.cells);
    for panel in &panels {
        let rows = panel.chord_places.len();
        assert_eq!(
            [panel.flat.left.len(), panel.flat.right.len()],
            [rows, rows]
        );
        for (ends, sewn) in [
            (&panel.flat.left, panel.seams_m[0]),
            (&panel.flat.right, panel.seams_m[1]),
        ] {
            let flat: f64 = ends.windows(2).map(|p| p[0].distance(p[1])).sum();
            assert!((flat / sewn - 1.0).abs() < 1e-9, "{flat} {sewn}");
        }
        // Around the nose a bulge cannot be laid flat; lower panels of open cells begin behind it.
        if panel.part == Part::Lower && (5..27).contains(&panel.cell) {
            assert!(
                panel.flat.strain < tolerance::LAID_FLAT,
                "cell {}: {}",
                panel.cell,
                panel.flat.strain
            );
        }
    }
    // Both panels of a closed cell at the tip go around their rib once.
    let outline = |rib: usize| -> f64 {
        let nodes = &wing.outlines[rib];
        (0..nodes.len())
            .map(|k| {
                let next = nodes[(k + 1) % nodes.len()];
                places[nodes[k] as usize].distance(places[next as usize])
            })
            .sum()
    };
    let seams: f64 = panels
        .iter()
        .filter(|p| p.cell == 0)
        .map(|p| p.seams_m[0])
        .sum();
    assert!(
        (seams / outline(0) - 1.0).abs() < 1e-12,
        "{seams} {}",
        outline(0)
    );
    // Neighbours are sewn to the same rib, and both halves are mirror images.
    for panel in panels.iter().filter(|p| (5..20).contains(&p.cell)) {
        let beside = panels
            .iter()
            .find(|p| p.part == panel.part && p.cell == panel.cell + 1);
        assert!((beside.unwrap().seams_m[0] - panel.seams_m[1]).abs() < 1e-12);
        let mirrored = wing.cells - 1 - panel.cell;
        let image = panels
            .iter()
            .find(|p| p.part == panel.part && p.cell == mirrored)
            .unwrap();
        assert!((image.seams_m[0] - panel.seams_m[1]).abs() < 1e-9);
    }
}

/// A wing as LEparagliding Studio writes it, in mm with x along the span: seven ribs 250 mm apart, the outermost of no thickness, four columns of quads in
/// each cell, an intake in the two cells in the middle if asked for, straps, and two rows with brakes on each half.
fn lep_sim(with_intakes: bool) -> String {
    const STATIONS: i32 = 12;
    const COLUMNS: i32 = 4;
    let half = |x: f64| {
        5.0 * 0.15
            * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3)
                - 0.1036 * x.powi(4))
    };
    let mut nodes: Vec<[f64; 3]> = Vec::new();
    let mut node = |place: [f64; 3]| {
        let rounded = place.map(|c| (c * 1e3).round() / 1e3);
        let known = nodes.iter().position(|n| *n == rounded);
        known.unwrap_or_else(|| {
            nodes.push(rounded);
            nodes.len() - 1
        })
    };
    let places: Vec<Vec<[f64; 3]>> = (-3..=3_i32)
        .map(|rib| {
            (-STATIONS..=STATIONS)
                .map(|i| {
                    // From the trailing edge above around the nose.
                    let x = (f64::from(i) / f64::from(STATIONS)).powi(2);
                    let thick = if rib.abs() == 3 {
                        0.0
                    } else {
                        half(x).max(0.0)
                    };
                    let z = if i <= 0 { thick } else { -thick };
                    [250.0 * f64::from(rib), 1000.0 * x, 1000.0 * z]
                })
                .collect()
        })
        .collect();
    let ribs: Vec<Vec<usize>> = places
        .iter()
        .map(|rib| rib.iter().map(|place| node(*place)).collect())
        .collect();
    let (mut quads, mut surfaces) = (Vec::new(), Vec::new());
    for cell in 0..6 {
        let columns: Vec<Vec<usize>> = (0..=COLUMNS)
            .map(|column| {
                let share = f64::from(column) / f64::from(COLUMNS);
                (0..ribs[cell].len())
                    .map(|k| match column {
                        0 => ribs[cell][k],
                        COLUMNS => ribs[cell + 1][k],
                        _ => {
                            let [a, b] = [places[cell][k], places[cell + 1][k]];
                            node([0, 1, 2].map(|i| a[i] + share * (b[i] - a[i])))
                        }
                    })
                    .collect()
            })
            .collect();
        for k in 0..2 * STATIONS as usize {
            for pair in columns.windows(2) {
                let (a, b) = (&pair[0], &pair[1]);
                quads.push([a[k], a[k + 1], b[k + 1], b[k]]);
                let below = k >= STATIONS as usize;
                let open = with_intakes && k == STATIONS as usize + 1 && (2..4).contains(&cell);
                surfaces.push(if open { 1 } else { 2 * i32::from(below) });
            }
        }
    }
    let loops: Vec<Vec<usize>> = ribs
        .iter()
        .map(|rib| {
            let mut seen = Vec::new();
            rib.iter().for_each(|n| {
                if !seen.contains(n) {
                    seen.push(*n);
                }
            });
            seen
        })
        .collect();
    let hole: Vec<[f64; 3]> = (0..12)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 12.0).sin_cos();
            [0.0, 350.0 + 60.0 * cos, 30.0 * sin]
        })
        .collect();
    let holes: Vec<Vec<Vec<[f64; 3]>>> = (0..7)
        .map(|rib| {
            if rib == 3 {
                vec![hole.clone()]
            } else {
                Vec::new()
            }
        })
        .collect();
    let mut lines = Vec::new();
    for side in [-1.0, 1.0] {
        let hang = [200.0 * side, 300.0, -3000.0];
        for (plan, brake, y) in [(1, 0, 62.5), (3, 0, 562.5), (0, 1, 1000.0)] {
            let knot = [250.0 * side, 0.5 * (300.0 + y), -1000.0];
            lines.push(serde_json::json!({ "a": hang, "b": knot, "label": "x", "plan": plan, "brake": brake }));
            let z = -1000.0 * half(y / 1000.0).max(0.0);
            for x in [0.0, 500.0] {
                let top = [x * side, y, z];
                lines.push(serde_json::json!({ "a": knot, "b": top, "label": "x", "plan": plan, "brake": brake }));
            }
        }
    }
    let strap = |side: f64| {
        let row = |x: f64, up: f64| -> Vec<[f64; 3]> {
            (0..6)
                .map(|i| {
                    let y = f64::from(i + 3).powi(2) / 144.0;
                    [x * side, 1000.0 * y, up * 1000.0 * half(y)]
                })
                .collect()
        };
        serde_json::json!({ "a": row(0.0, -1.0), "b": row(250.0, 1.0) })
    };
    serde_json::json!({
        "version": 1, "unit": "mm", "nodes": nodes, "quads": quads,
        "surfaceNames": ["extrados", "vent", "intrados"], "quadSurfaces": surfaces,
        "ribLoops": loops, "ribHoles": holes, "straps": [strap(-1.0), strap(1.0)], "lines": lines,
    })
    .to_string()
}

/// Volume, areas, rows and held ends are those that were written, aft and up are where they should be, and the wing hangs in its lines with its weight.
fn imported() {
    use ripstop::fabric::Fabric;
    use ripstop::geometry::mesh::lep_sim::read;
    use ripstop::lines::{Cable, CableLaw};
    let fabric = Fabric {
        thickness_m: 5e-5,
        density_kg_m3: 800.0,
        warp_modulus_pa: 6e8,
        weft_modulus_pa: 6e8,
        poisson_ratio: 0.15,
        shear_modulus_pa: 8e7,
        cubic_shear_compliance_1_pa3: None,
        residual_stiffness: 0.03,
        initial_strain: [0.0; 2],
        yield_stress_pa: None,
    };
    let cable = Cable {
        area_m2: 1e-6,
        density_kg_m3: 1000.0,
        law: CableLaw::Linear {
            axial_stiffness_n: 2e4,
        },
        damping_n_s: 0.0,
    };
    let [closed, open] =
        [false, true].map(|intakes| read(&lep_sim(intakes), &fabric, &cable).unwrap());
    // Full sections between the inner ribs, half of them in the mean beyond; 0.6810 t c² with a closed trailing edge, of which the polygon lacks some.
    let exact = 0.6810 * 0.15 * 1.25;
    assert!(
        (closed.volume_m3 / exact - 1.0).abs() < 0.03,
        "{} {exact}",
        closed.volume_m3
    );
    assert!((open.volume_m3 / closed.volume_m3 - 1.0).abs() < 1e-12);
    let skin = |wing: &ripstop::geometry::mesh::lep_sim::Imported| -> f64 {
        let triangles = wing.structure.triangles.iter().zip(&wing.is_skin);
        triangles
            .filter(|(_, skin)| **skin)
            .map(|(t, _)| t.rest_area_m2)
            .sum()
    };
    // Two intakes of 250 mm over the second edge of the lower side.
    let edge = {
        let at = |i: f64| {
            let x = i * i / 144.0;
            let half = 0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3);
            [x, 0.75 * (half - 0.1036 * x.powi(4))]
        };
        let [a, b] = [at(1.0), at(2.0)];
        f64::hypot(a[0] - b[0], a[1] - b[1])
    };
    let lacking = skin(&closed) - skin(&open);
    assert!((lacking / (0.5 * edge) - 1.0).abs() < 0.02, "{lacking}");
    assert_eq!(closed.held.len(), 2);
    let rows: std::collections::BTreeSet<&str> = closed.rows.iter().map(String::as_str).collect();
    assert_eq!(rows.into_iter().collect::<Vec<_>>(), ["A", "C", "brake"]);
    assert_eq!(closed.rows.len(), 18);
    assert!(closed.moved_max_m < 1e-3, "{}", closed.moved_max_m);
    // Noses lie ahead of trailing edges, normals point outwards.
    let places = &closed.structure.positions_m;
    for (triangle, _) in closed
        .structure
        .triangles
        .iter()
        .zip(&closed.is_skin)
        .filter(|(_, s)| **s)
    {
        let middle = triangle
            .nodes
            .iter()
            .map(|n| places[*n as usize])
            .sum::<glam::DVec3>()
            / 3.0;
        let up = triangle.doubled_area_vector(places).z;
        assert!(up * middle.z >= -1e-9, "{middle}");
    }
    let low = places.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let thickest = places.iter().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
    assert!((0.2..0.4).contains(&(thickest.x - low)), "{thickest}");
    for (text, words) in [
        ("{", "EOF"),
        (
            r#"{"version": 2, "unit": "mm", "nodes": [], "quads": []}"#,
            "version 2",
        ),
        (
            r#"{"version": 1, "unit": "mm", "nodes": [[0,0,0]], "quads": [[0,0,0,7]], "ribLoops": [[0]]}"#,
            "node 7",
        ),
    ] {
        let why = read(text, &fabric, &cable).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
    // Upside down, in ten times the gravity: its weight pulls at its lines.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lep-sim.json"), lep_sim(false)).unwrap();
    let case = "version = 1\n[structure.lep_sim]\nfile = \"lep-sim.json\"\n[structure.lep_sim.line_material]\narea_m2 = 1e-6\ndensity_kg_m3 = 1000.0\nyoungs_modulus_pa = 2e10\n\
                [fabric]\nthickness_m = 5e-5\ndensity_kg_m3 = 800.0\nyoungs_modulus_pa = 6e8\npoisson_ratio = 0.15\nresidual_stiffness = 0.03\n\
                [gravity]\nacceleration_m_s2 = [0.0, 0.0, 100.0]\n[equilibrium]\ntolerance = 1e-2\nevaluation_limit = 4000\npressure_pa = 50.0\n";
    let path = folder.path().join("case.toml");
    std::fs::write(&path, case).unwrap();
    let out = folder.path().join("out");
    let output = ripstop(&[
        "run",
        path.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.code, 0, "{}{}", output.printed, output.errors);
    let text = std::fs::read(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let value = |name: &str| summary["results"][name]["value"].as_f64().unwrap();
    let (held, weight) = (value("held_force_n"), value("weight_n"));
    assert!(
        (held / weight - 1.0).abs() < tolerance::HANGS,
        "{held} {weight}"
    );
    let rows: f64 = ["A", "C", "brake"]
        .iter()
        .map(|row| value(&format!("row_{row}_load_n")))
        .sum();
    assert!(rows > 0.9 * held, "{rows} {held}");
}

fn widths_and_seams_hold(rows: &[Vec<DVec3>], flat: &Flat) {
    for (k, row) in rows.iter().enumerate() {
        let width: f64 = row.windows(2).map(|p| p[0].distance(p[1])).sum();
        assert!((flat.left[k].distance(flat.right[k]) - width).abs() < 1e-12);
    }
    for k in 1..rows.len() {
        let last = rows[k].len() - 1;
        for (ends, node) in [(&flat.left, 0), (&flat.right, last)] {
            let sewn = rows[k][node].distance(rows[k - 1][node]);
            assert!(
                (ends[k].distance(ends[k - 1]) - sewn).abs() < 1e-9,
                "row {k}"
            );
        }
    }
}

/// A piece of a cylinder along x with arcs across is a rectangle; a cone whose rows are generators is flat, too.
fn a_cylinder_unrolls_exactly() {
    let (radius, edges) = (0.4, 6);
    let point = |x: f64, s: f64| {
        let angle: f64 = s / radius;
        DVec3::new(x, radius * angle.sin(), radius * angle.cos())
    };
    let rows: Vec<Vec<DVec3>> = (0..12)
        .map(|k| {
            let x = 0.1 * f64::from(k);
            (0..=edges)
                .map(|a| point(x, 0.25 * f64::from(a) / f64::from(edges)))
                .collect()
        })
        .collect();
    let flat = unroll(&rows);
    assert!(flat.strain < 1e-9, "{}", flat.strain);
    widths_and_seams_hold(&rows, &flat);
    // A rectangle.
    let last = rows.len() - 1;
    let diagonal = flat.left[0].distance(flat.right[last]);
    let width = flat.left[0].distance(flat.right[0]);
    assert!((diagonal - width.hypot(1.1)).abs() < 1e-9);
    let generators: Vec<Vec<DVec3>> = (0..10)
        .map(|k| {
            let angle = 0.08 * f64::from(k);
            (0..=edges)
                .map(|a| {
                    let r = 0.2 + 0.1 * f64::from(a);
                    DVec3::new(r * angle.cos(), r * angle.sin(), 0.7 * r)
                })
                .collect()
        })
        .collect();
    let cone = unroll(&generators);
    assert!(cone.strain < 1e-9, "{}", cone.strain);
    widths_and_seams_hold(&generators, &cone);
}

/// A piece of a sphere cannot be laid flat: seams and widths hold, and the strain is that of the circles that shrink.
fn a_sphere_is_strained() {
    let rows: Vec<Vec<DVec3>> = (0..=20)
        .map(|k| {
            let latitude = 0.02 * f64::from(k - 10);
            (0..=8)
                .map(|a| {
                    let longitude = 0.05 * f64::from(a - 4);
                    DVec3::new(
                        latitude.cos() * longitude.cos(),
                        latitude.cos() * longitude.sin(),
                        latitude.sin(),
                    )
                })
                .collect()
        })
        .collect();
    let flat = unroll(&rows);
    widths_and_seams_hold(&rows, &flat);
    assert!((1e-4..0.05).contains(&flat.strain), "{}", flat.strain);
}

/// The shape as it is drawn gives back the ballooning of the plan, from the heights of the panels' middles.
fn drawn_ballooning() {
    use ripstop::geometry::wing::section::lookup;
    use ripstop::measure::{ballooning_differences, cell_width_ratios, flown_ballooning};
    let scene = school();
    let (wing, body) = (scene.wing.unwrap(), scene.body.unwrap());
    let places = &body.structure.positions_m;
    let drawn = flown_ballooning(&wing, places);
    for (side, planned) in drawn.iter().zip(&wing.plan.ballooning) {
        assert!(side.len() >= 6);
        for [x, b] in side {
            let error = b - lookup(planned, *x);
            assert!(error.abs() < 1e-9, "{x}: {b}, {error}");
        }
    }
    let ratios = cell_width_ratios(&wing, places, places);
    assert!(ballooning_differences(&ratios, None)[0] < 1e-12);
    // Stretched along y by a tenth, ribs that stand upright are as much farther apart; leaning ones by less.
    let wider: Vec<DVec3> = places
        .iter()
        .map(|p| DVec3::new(p.x, 1.1 * p.y, p.z))
        .collect();
    let [largest, _] = ballooning_differences(&cell_width_ratios(&wing, places, &wider), None);
    assert!((0.05..0.1).contains(&largest), "{largest}");
}

/// One unit of the drawing is a millimetre of the sheet, and of the cloth.
fn true_scale() {
    use ripstop::output::{PatternPiece, write_patterns};
    let square = PatternPiece {
        outline_m: vec![[0.0, 0.0], [0.25, 0.0], [0.25, 0.5], [0.0, 0.5]],
        words: vec!["cell <1>".to_owned()],
        marks: Vec::new(),
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("panels.svg");
    write_patterns(&path, "test", &[square.clone(), square]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let between = |from: &str, to: &str| -> String {
        text.split(from)
            .nth(1)
            .unwrap()
            .split(to)
            .next()
            .unwrap()
            .to_owned()
    };
    let view: Vec<f64> = between("viewBox=\"", "\"")
        .split(' ')
        .map(|n| n.parse().unwrap())
        .collect();
    let sheet = [between("width=\"", "mm"), between("height=\"", "mm")];
    assert_eq!(sheet.map(|n| n.parse::<f64>().unwrap()), [view[2], view[3]]);
    assert_eq!(text.matches("<path").count(), 2);
    let points: Vec<[f64; 2]> = between("<path d=\"", "Z")
        .split(['M', 'L'])
        .filter(|p| !p.trim().is_empty())
        .map(|p| {
            let mut numbers = p.split_whitespace().map(|n| n.parse().unwrap());
            [numbers.next().unwrap(), numbers.next().unwrap()]
        })
        .collect();
    assert_eq!(points[1][0] - points[0][0], 250.0);
    // Up the page.
    assert_eq!(points[2][1] - points[1][1], -500.0);
    assert!(text.contains("cell &lt;1&gt;"));
}
