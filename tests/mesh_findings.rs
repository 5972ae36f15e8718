//! What is found in meshes of others, and refused or drawn.

use glam::DVec3;
use libtest_mimic::Trial;
use ripstop::case::{self, Choices, SHIPPED};
use ripstop::geometry::mesh::doctor::{Kind, Subject, Use, examine};
use ripstop::geometry::surfaces;
use ripstop::geometry::wing::Part;
use ripstop::rigid::Surface;

use crate::command_line::{ripstop, root};
use crate::engines::plain;
use crate::meshes::{
    HELD, checked, halves, hanging, obj, parsed, sheet, unframed, with_seam, with_triangle, write,
};

pub fn trials() -> Vec<Trial> {
    [
        plain("meshes::defects_are_refused_unless_accepted", defects),
        plain("meshes::bodies_are_examined", bodies),
        plain("meshes::findings_are_drawn", pictures),
        plain("meshes::what_is_drawn_here_is_sound", drawn_here),
        plain("meshes::triangles_are_turned_alike", turned_alike),
        plain("meshes::what_is_broken_ends_with_a_message", broken),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Each defect of a mesh is refused by its name, with its place and what to do; when it is accepted the case runs, and says so.
fn defects() {
    let healthy = checked(&sheet(), HELD);
    assert_eq!(healthy.code, 0, "{}", healthy.errors);
    for part in [
        "pieces              1, of 32 triangles (25 nodes in all)",
        "open borders        1, 4.000 m long",
        "area 1.000 m2, mass 0.05000 kg",
        "size                1.000 x 0 x 1.000 m",
        "findings            none",
    ] {
        assert!(
            healthy.printed.contains(part),
            "{part}: {}",
            healthy.printed
        );
    }
    let loose = with_triangle([[2.0, 0.0, 0.0], [2.2, 0.0, 0.0], [2.0, 0.0, -0.2]]);
    let mut doubled = sheet();
    doubled.triangles.extend(doubled.triangles.clone());
    let mut rib = sheet();
    rib.positions_m.push(DVec3::new(0.4, 0.3, -0.5));
    rib.triangles.push([11, 12, 25]);
    let mut turned = sheet();
    turned.triangles[7].swap(0, 1);
    let through = with_triangle([[0.6, -0.3, -0.6], [0.7, 0.3, -0.6], [0.6, 0.3, -0.65]]);
    let upon = with_triangle([[0.3, 0.0, -0.3], [0.7, 0.0, -0.35], [0.35, 0.0, -0.7]]);
    let mut huge = sheet();
    for place in &mut huge.positions_m {
        *place *= 1e15;
    }
    let six = "held_nodes = [1, 2, 3, 4, 5, 26]";
    for (surface, held, names, parts) in [
        (
            with_seam(),
            HELD,
            &["doubled_vertices", "loose_pieces"][..],
            &[
                "5 vertices lie upon others along open borders",
                "first vertices 11 and 26 at (0.0000, 0.0000, -0.5000) m, all of them in the same places",
                "weld_tolerance_m = 2.5e-7 joins them",
            ][..],
        ),
        (
            loose,
            HELD,
            &["loose_pieces"],
            &[
                "1 piece of fabric has neither a held node nor a line",
                "(2.0667, 0.0000, -0.0667) m",
            ],
        ),
        (
            doubled,
            HELD,
            &["doubled_faces"],
            &["32 triangles lie upon another", "first triangle 1 at"],
        ),
        (
            rib,
            HELD,
            &["non_manifold_edges"],
            &[
                "1 edge of up to 3 triangles",
                "vertices 12 and 13 at (0.2500, 0.0000, -0.5000) m",
            ],
        ),
        (
            turned,
            HELD,
            &["orientation"],
            &[
                "1 triangle runs against its neighbours",
                "first triangle 8 at (0.8333, 0.0000, -0.1667) m",
            ],
        ),
        (
            through,
            six,
            &["self_crossing", "pieces"],
            &[
                "3 edges pass through the mesh itself",
                "2 pieces of fabric without a common node",
            ],
        ),
        (
            upon,
            six,
            &["overlapping_faces", "pieces"],
            &[
                "pairs of triangles cover each other in part, in one plane",
                "and triangle 33 at (0.4500, 0.0000, -0.4500) m",
            ],
        ),
        (
            huge,
            HELD,
            &["size"],
            &[
                "1.000e15 m long",
                "give the metres per unit of the file as scale",
            ],
        ),
    ] {
        let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
        let accept = format!("accept = [{}]", quoted.join(", "));
        let refused = checked(&surface, held);
        let told = unframed(&refused.errors);
        assert_eq!(refused.code, 2, "{names:?}: {told}");
        assert!(told.contains(&format!("structure.mesh.{accept}")), "{told}");
        for part in parts {
            assert!(told.contains(part), "{part}: {told}");
        }
        // What a mesh is made of is told of a refused case, too.
        let printed = &refused.printed;
        for name in names {
            assert!(printed.contains(&format!("REFUSED   {name}")), "{printed}");
        }
        let accepted = checked(&surface, &format!("{held}\n{accept}"));
        assert_eq!(accepted.code, 0, "{}", accepted.errors);
        for name in names {
            let line = format!("accepted  {name}");
            assert!(accepted.printed.contains(&line), "{}", accepted.printed);
        }
        if names.len() == 2 {
            // One of two is not enough.
            let one = checked(&surface, &format!("{held}\naccept = [{}]", quoted[0]));
            assert_eq!(one.code, 2);
            assert!(unframed(&one.errors).contains(&accept), "{}", one.errors);
        }
    }
    // The refusal is that of a run, too, and what is accepted but not there is told.
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), &with_seam(), &hanging(HELD));
    let out = folder.path().join("out");
    let run = ripstop(&["run", &case, "--out", out.to_str().unwrap()]);
    assert_eq!(run.code, 2, "{}", run.errors);
    assert!(!out.exists());
    let vain = checked(&sheet(), &format!("{HELD}\naccept = [\"orientation\"]"));
    assert!(
        vain.printed.contains("but there is none"),
        "{}",
        vain.printed
    );
    let unknown = checked(&sheet(), &format!("{HELD}\naccept = [\"seams\"]"));
    assert_eq!(unknown.code, 2);
    assert!(
        unframed(&unknown.errors).contains("`doubled_vertices`"),
        "{}",
        unknown.errors
    );
}

/// Rigid bodies: a ball is closed; with a hole, a turned triangle or a doubled one it is refused. Seams of STL and OBJ are joined as they are read.
fn bodies() {
    let folder = tempfile::tempdir().unwrap();
    let source = include_str!("../cases/bad/body-degenerate-mesh.toml")
        .replace("degenerate-triangle.ply", "ball.obj")
        .replace("scale = 0.001", "scale = 0.001\nMORE")
        .replace(
            "[coupling]",
            "[bodies.sphere.reference]\narea_m2 = 0.00785\nlength_m = 0.1\n[coupling]",
        );
    let ball = surfaces::sphere(50.0, 12.0);
    let of = |surface: &Surface, more: &str| {
        std::fs::write(folder.path().join("ball.obj"), obj(surface)).unwrap();
        parsed(&source.replace("MORE", more), folder.path())
    };
    let scene = of(&ball, "").unwrap();
    assert!(scene.rigid_bodies[0].volume_m3.is_some());
    assert!((scene.meshes[0].volume_m3.unwrap() / 5.236e-4 - 1.0).abs() < 0.05);
    assert!(scene.meshes[0].examination.findings.is_empty());
    let mut open = ball.clone();
    open.triangles.pop();
    let mut turned = ball.clone();
    turned.triangles[5].swap(0, 1);
    let mut doubled = ball.clone();
    doubled.triangles.push(ball.triangles[0]);
    for (surface, name) in [
        (&open, "holes"),
        (&turned, "orientation"),
        (&doubled, "doubled_faces"),
    ] {
        let error = of(surface, "").unwrap_err();
        assert!(error.contains(&format!("({name})")), "{error}");
        // What is accepted may still be too broken for its markers to stand inside.
        let accepted = of(surface, &format!("accept = [\"{name}\"]"));
        assert!(
            accepted.is_ok_and(|scene| scene.rigid_bodies[0].volume_m3.is_none())
                || name != "holes"
        );
        if let Err(error) = of(surface, &format!("accept = [\"{name}\"]")) {
            assert!(error.contains("are too large for the body"), "{error}");
        }
    }
    // Every triangle on corners of its own, exact: joined as it is read; a hundredth of a millimetre apart: by the tolerance.
    for (gap, more) in [(0.0, ""), (0.01, "weld_tolerance_m = 5e-5")] {
        let mut soup = Surface::default();
        for (number, nodes) in ball.triangles.iter().enumerate() {
            let first = soup.positions_m.len() as u32;
            let shift = DVec3::X * gap * (number % 2) as f64;
            soup.positions_m
                .extend(ball.corners(*nodes).map(|p| p + shift));
            soup.triangles.push([first, first + 1, first + 2]);
        }
        if gap > 0.0 {
            let error = of(&soup, "").unwrap_err();
            assert!(error.contains("(doubled_vertices)"), "{error}");
        }
        let scene = of(&soup, more).unwrap();
        assert!(scene.rigid_bodies[0].volume_m3.is_some(), "{gap}");
        assert_eq!(
            scene.meshes[0].examination.node_count,
            ball.positions_m.len()
        );
    }
}

/// `check --pictures` draws the finding of a refused case, and the borders of any, and leaves the exit codes as they are.
fn pictures() {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), &with_seam(), &hanging(HELD));
    let drawn = folder.path().join("pictures");
    let to = drawn.to_str().unwrap();
    let refused = ripstop(&["check", &case, "--pictures", to]);
    assert_eq!(refused.code, 2);
    let red = |name: &str| {
        let path = drawn.join(name);
        assert!(refused.printed.contains(path.to_str().unwrap()));
        let image = image::open(&path).unwrap().into_rgb8();
        let is_red = |p: &&image::Rgb<u8>| p.0[0] > 150 && p.0[1] < 90 && p.0[2] < 90;
        image.pixels().filter(is_red).count()
    };
    assert!(red("structure-mesh-doubled-vertices.png") > 100);
    assert!(red("structure-mesh-loose-pieces.png") > 10_000);
    assert_eq!(red("structure-mesh-open-borders.png"), 0);
    // Along a seam edges and vertices of either side are marked, where fabric lies twice all of both triangles.
    let upon = with_triangle([[0.3, 0.0, -0.3], [0.7, 0.0, -0.35], [0.35, 0.0, -0.7]]);
    for (surface, name) in [
        (halves(4, 6, 0.0), "hanging-nodes"),
        (upon, "overlapping-faces"),
    ] {
        let case = write(folder.path(), &surface, &hanging(HELD));
        let told = ripstop(&["check", &case, "--pictures", to]);
        assert_eq!(told.code, 2);
        let path = drawn.join(format!("structure-mesh-{name}.png"));
        let image = image::open(&path).unwrap().into_rgb8();
        let is_red = |p: &&image::Rgb<u8>| p.0[0] > 150 && p.0[1] < 90 && p.0[2] < 90;
        assert!(image.pixels().filter(is_red).count() > 500, "{name}");
    }
    let sound = write(folder.path(), &sheet(), &hanging(HELD));
    std::fs::remove_dir_all(&drawn).unwrap();
    assert_eq!(ripstop(&["check", &sound, "--pictures", to]).code, 0);
    let left: Vec<_> = std::fs::read_dir(&drawn).unwrap().collect();
    assert_eq!(left.len(), 1);
    // A folder that cannot be written.
    let file = drawn.join("structure-mesh-open-borders.png");
    let output = ripstop(&["check", &sound, "--pictures", file.to_str().unwrap()]);
    assert_eq!(output.code, 74, "{}", output.errors);
}

/// No structure of the shipped cases has what would be refused in a mesh of others, but for what it is meant to have.
fn drawn_here() {
    let mut wrong = Vec::new();
    for (name, text) in SHIPPED {
        let choices = Choices::default();
        let case = case::parse(name, text, &root().join("cases"), &choices).unwrap();
        let structure = match &case.scene.body {
            Some(body) if !body.structure.triangles.is_empty() => &body.structure,
            _ => continue,
        };
        let meant: &[Kind] = match name {
            // Two sheets that lie upon each other.
            "airbag" => &[Kind::DoubledFaces],
            // A disk and its band; rings of fabric between slots.
            "disk-gap-band" | "ringslot-drop" | "slotted-drop" => &[Kind::Pieces],
            _ => &[],
        };
        // Of a wing its panels: ribs meet them in threes, and their normals all point to the right, at both tips.
        let tags = case.scene.wing().map(|wing| &wing.built.tags[..]);
        let is_looked_at = |number: usize| {
            tags.is_none_or(|tags| matches!(tags[number].part, Part::Upper | Part::Lower))
        };
        let numbered = structure.triangles.iter().enumerate();
        let surface = Surface {
            triangles: numbered
                .filter(|(number, _)| is_looked_at(*number))
                .map(|(_, triangle)| triangle.nodes)
                .collect(),
            positions_m: structure.positions_m.clone(),
        };
        let examination = examine(&Subject {
            surface: &surface,
            start_m: &structure.positions_m,
            numbers: None,
            used_as: Use::Fabric {
                anchored: &vec![true; structure.node_count()],
                nominal_area_m2: None,
            },
            cell_size_m: None,
        });
        let findings = examination.findings.iter();
        let unmeant = findings.filter(|f| !meant.contains(&f.kind));
        wrong.extend(unmeant.map(|f| format!("{name}: {}: {}", f.kind.name(), f.what)));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Triangles that run against their neighbours are turned where the case asks for it, piece by piece; where nothing says which way is right the
/// case is refused.
fn turned_alike() {
    let mut turned = sheet();
    for number in [3, 7, 8] {
        turned.triangles[number].swap(0, 1);
    }
    // A second piece, of which most runs the other way: it keeps its own.
    let second: Vec<DVec3> = sheet()
        .positions_m
        .iter()
        .map(|p| *p + DVec3::X * 3.0)
        .collect();
    turned.positions_m.extend(second);
    for (number, [a, b, c]) in sheet().triangles.into_iter().enumerate() {
        let [a, b, c] = [a, b, c].map(|node| node + 25);
        let is_odd = number == 5;
        turned
            .triangles
            .push(if is_odd { [a, b, c] } else { [a, c, b] });
    }
    let held = "held_nodes = [1, 2, 3, 4, 5, 26]\naccept = [\"pieces\"]";
    let refused = checked(&turned, held);
    assert_eq!(refused.code, 2);
    let told = unframed(&refused.errors);
    assert!(
        told.contains("4 triangles run against their neighbours"),
        "{told}"
    );
    assert!(
        told.contains("orient_triangles = true turns them"),
        "{told}"
    );
    let taken = checked(&turned, &format!("{held}\norient_triangles = true"));
    assert_eq!(taken.code, 0, "{}", taken.errors);
    let line = "turned              4 triangles, so that those of each piece run alike";
    assert!(taken.printed.contains(line), "{}", taken.printed);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mesh.obj"), obj(&turned)).unwrap();
    let scene = parsed(
        &hanging(&format!("{held}\norient_triangles = true")),
        folder.path(),
    )
    .unwrap();
    let areas = scene.meshes[0]
        .surface
        .area_vectors_m2()
        .collect::<Vec<DVec3>>();
    assert!(areas[..32].iter().all(|area| area.y > 0.0), "{areas:?}");
    assert!(areas[32..].iter().all(|area| area.y < 0.0), "{areas:?}");

    let mut rib = sheet();
    rib.positions_m.push(DVec3::new(0.4, 0.3, -0.5));
    rib.triangles.push([11, 12, 25]);
    let mut strip = Surface::default();
    for k in 0..8 {
        // Half a turn on the way around.
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 8.0).sin_cos();
        let (up, out) = (f64::from(k) * std::f64::consts::PI / 8.0).sin_cos();
        for side in [-0.2, 0.2] {
            let radius = 1.0 + side * out;
            strip
                .positions_m
                .push(DVec3::new(radius * cos, radius * sin, side * up));
        }
    }
    for k in 0..8u32 {
        let [a, b] = [2 * k, 2 * k + 1];
        let [c, d] = if k == 7 {
            [1, 0]
        } else {
            [2 * k + 2, 2 * k + 3]
        };
        strip.triangles.extend([[a, c, b], [b, c, d]]);
    }
    for (surface, part) in [
        (&rib, "between vertices 12 at"),
        (&rib, "more than two triangles meet there"),
        (&strip, "one side only, as a Möbius strip"),
    ] {
        let refused = checked(surface, &format!("{HELD}\norient_triangles = true"));
        assert_eq!(refused.code, 2);
        let told = unframed(&refused.errors);
        assert!(told.contains(part), "{part}: {told}");
    }
}

/// One message and exit code 2, or a finding, whatever the numbers are.
fn broken() {
    let scaled = |factor: f64| {
        let mut surface = sheet();
        surface
            .positions_m
            .iter_mut()
            .for_each(|place| *place *= factor);
        obj(&surface)
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 0 -1\n";
    let flat = |count: usize| "v 0 0 0\nv 1 0 0\nv 2 0 0\n".to_owned() + &"f 1 2 3\n".repeat(count);
    let far = sheet()
        .positions_m
        .iter()
        .map(|p| *p + DVec3::splat(1e9))
        .collect();
    let far = obj(&Surface {
        positions_m: far,
        ..sheet()
    });
    for (text, more, code, part) in [
        (scaled(1e300), "", 2, "beyond 1e30 m"),
        (scaled(1e29), "", 2, "(size)"),
        (scaled(1e-300), "", 2, "is degenerate"),
        (scaled(1e-9), "", 2, "(size)"),
        (scaled(1e308), "scale = 1e3", 2, "is not finite"),
        (far.clone(), "", 0, ""),
        (format!("{triangle}f 1 2 3\n"), "held_nodes = [1]", 0, ""),
        (
            format!("{triangle}f 1 2 3\n"),
            "held_nodes = [1]\nweld_tolerance_m = 0.5",
            2,
            "is too wide",
        ),
        (
            format!("{triangle}f 1 1 1\n"),
            "held_nodes = [1]",
            2,
            "vertex 2 belongs to no face",
        ),
        (flat(300), "held_nodes = [1]", 2, "triangle 1 of"),
        (
            flat(300),
            "held_nodes = [1]\nweld_tolerance_m = 1e-3",
            2,
            "triangle 1 of",
        ),
        ("v 0 0 0\n".to_owned(), "", 2, "no faces"),
        (
            "v 0 0 0\nf 1 1 1\n".to_owned(),
            "held_nodes = [1]",
            2,
            "is degenerate",
        ),
        (
            "v 0 0 0\nf 1 1 1\n".to_owned(),
            "held_nodes = [1]\nweld_tolerance_m = 1e-3",
            2,
            "is too wide",
        ),
        (
            "v 0 nan 0\nf 1 1 1\n".to_owned(),
            "",
            2,
            "line 1: a vertex is not finite",
        ),
        (
            "v 0 inf 0\nf 1 1 1\n".to_owned(),
            "",
            2,
            "line 1: a vertex is not finite",
        ),
        (scaled(1.0), "weld_tolerance_m = 1e9", 2, "is too wide"),
        (scaled(1.0), "weld_tolerance_m = nan", 2, "must be positive"),
        (
            scaled(1.0),
            "weld_tolerance_m = -1.0",
            2,
            "must be positive",
        ),
        (
            obj(&with_seam()),
            "weld_tolerance_m = 0.07",
            2,
            "give at most",
        ),
        (
            scaled(1.0),
            "rotation = { axis = [0.0, 0.0, 0.0], angle_deg = 1.0 }",
            2,
            "has no direction",
        ),
        (
            scaled(1.0),
            "rotation = { axis = [0.0, 0.0, 1.0], angle_deg = inf }",
            2,
            "plausible",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mesh.obj"), &text).unwrap();
        let held = if more.contains("held_nodes") {
            ""
        } else {
            HELD
        };
        let mut case = hanging(&format!("{held}\n{more}"));
        if more.contains("scale") {
            case = case.replacen("scale = 1.0\n", "", 1);
        }
        let path = folder.path().join("case.toml");
        std::fs::write(&path, case).unwrap();
        let pictures = folder.path().join("pictures");
        let done = ripstop(&[
            "check",
            path.to_str().unwrap(),
            "--pictures",
            pictures.to_str().unwrap(),
        ]);
        let told = unframed(&done.errors);
        assert_eq!(done.code, code, "{part}: {more}: {told}");
        assert!(told.contains(part), "{part}: {told}");
        assert!(!told.contains("panicked"), "{told}");
    }
}
