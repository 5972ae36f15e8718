//! Wings of LEparagliding Studio.

use libtest_mimic::Trial;

use crate::command_line::ripstop;
use crate::engines::plain;
use crate::tolerances::wing_design as tolerance;

pub fn trials() -> Vec<Trial> {
    plain("lep_sim::wings_of_leparagliding_are_read", imported)
        .into_iter()
        .collect()
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
        breaking_load_n: None,
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
