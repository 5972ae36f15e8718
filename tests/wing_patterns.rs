//! Panels of wings laid flat: seams, known surfaces, scale.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::geometry::wing::Part;
use ripstop::geometry::wing::patterns::{Flat, patterns, unroll};

use crate::engines::plain;
use crate::tolerances::wing_design as tolerance;
use crate::wing_design::school;

pub fn trials() -> Vec<Trial> {
    [
        plain("wing_patterns::seams_of_panels_fit_their_ribs", seams),
        plain(
            "wing_patterns::a_cylinder_unrolls_exactly",
            a_cylinder_unrolls_exactly,
        ),
        plain("wing_patterns::a_sphere_is_strained", a_sphere_is_strained),
        plain(
            "wing_patterns::flown_ballooning_is_read_as_it_is_drawn",
            drawn_ballooning,
        ),
        plain("wing_patterns::pieces_are_drawn_at_true_scale", true_scale),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Seams of panels laid flat are as long as the edges of the ribs that they are sewn to, and as those of the panel on the other side.
fn seams() {
    let scene = school();
    let (wing, body) = (&scene.wing().unwrap().built, scene.body.as_ref().unwrap());
    let places = &body.structure.positions_m;
    let panels = patterns(wing, places);
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
    let flat = unroll(&rows, 0);
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
    let cone = unroll(&generators, 0);
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
    let flat = unroll(&rows, 0);
    widths_and_seams_hold(&rows, &flat);
    assert!((1e-4..0.05).contains(&flat.strain), "{}", flat.strain);
}

/// The shape as it is drawn gives back the ballooning of the plan, from the heights of the panels' middles.
fn drawn_ballooning() {
    use ripstop::geometry::table::lookup;
    use ripstop::measure::{ballooning_differences, cell_width_ratios, flown_ballooning};
    let scene = school();
    let (wing, body) = (scene.wing().unwrap(), scene.body.as_ref().unwrap());
    let places = &body.structure.positions_m;
    let drawn = flown_ballooning(wing, places);
    for (side, planned) in drawn.iter().zip(&wing.plan.ballooning) {
        assert!(side.len() >= 6);
        for [x, b] in side {
            let error = b - lookup(planned, *x);
            assert!(error.abs() < 1e-9, "{x}: {b}, {error}");
        }
    }
    let ratios = cell_width_ratios(wing, places, places);
    assert!(ballooning_differences(&ratios, None)[0] < 1e-12);
    // Stretched along y by a tenth, ribs that stand upright are as much farther apart; leaning ones by less.
    let wider: Vec<DVec3> = places
        .iter()
        .map(|p| DVec3::new(p.x, 1.1 * p.y, p.z))
        .collect();
    let [largest, _] = ballooning_differences(&cell_width_ratios(wing, places, &wider), None);
    assert!((0.05..0.1).contains(&largest), "{largest}");
}

/// One unit of the drawing is a millimetre of the sheet, and of the cloth.
fn true_scale() {
    use ripstop::output::{PatternPiece, Provenance, write_patterns};
    let square = PatternPiece {
        outline_m: vec![[0.0, 0.0], [0.25, 0.0], [0.25, 0.5], [0.0, 0.5]],
        words: vec!["cell <1>".to_owned()],
        marks: Vec::new(),
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("panels.svg");
    let provenance = Provenance {
        program: "ripstop <1>".to_owned(),
        ..Provenance::default()
    };
    write_patterns(&path, "test", &[square.clone(), square], &provenance).unwrap();
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
    assert!(text.contains("<metadata>\nSoftware: ripstop &lt;1&gt;\n</metadata>"));
}
